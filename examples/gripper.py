"""A gripper closes on a part, lifts it and holds it for a minute: contacts that do not creep.

Two jaws press with 60 N each on a box of 1 kg, mu = 0.4 (0.3 once it slides). Friction bears up to
2 mu N = 48 N, the weight is 9.81 N: the part hangs on its bristles and does not creep. Then they
press with 6 N only: the part slides out with the acceleration g - 2 mu_k N / m.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.mechanism import Contact, Cuboid, HalfSpace, PowerLaw, Sphere
from jousto.output.style import COLORS, STYLE

G, MASS, SIZE, STATIC, KINETIC = 9.81, 1.0, 0.1, 0.4, 0.3
LIFT, HOLD = 0.3, 62.0  # m, s
GRIP, WEAK = 60.0, 6.0  # N
PAD = PowerLaw(2e5, 1.0, restitution=0.3, slowest=0.05)  # N/m at each corner of a face


def gripper() -> jo.Model:
    """Return the gripper and a part on the floor; it closes, lifts and at last gives way."""
    part = jo.RigidBody.box(
        "part", size=(SIZE,) * 3, mass=MASS, position=(0, 0, SIZE / 2 - MASS * G / 4 / 1e5)
    )
    hand = jo.RigidBody("hand", 2.0, (0.01,) * 3, position=(0, 0, 0.25))
    lift = jo.Prismatic("lift", jo.ground["origin"], hand["origin"], axis=(0, 0, 1))
    up = jo.SCurve([0.5, 1.5], [lift.displacement.initial, lift.displacement.initial + LIFT])
    items: list[object] = [part, hand, lift, jo.Drive("motor", lift.displacement, up)]
    for name, side in (("left", -1), ("right", 1)):
        x = side * (SIZE / 2 + 0.011)
        jaw = jo.RigidBody(name, 0.2, (1e-4,) * 3, position=(x, 0, SIZE / 2))
        slide = jo.Prismatic(
            f"{name} slide", hand.at((0, 0, SIZE / 2 - 0.25)), jaw["origin"], axis=(-side, 0, 0)
        )
        push = jo.JointForce(f"{name} push", slide.displacement, jo.Step(HOLD, GRIP, WEAK))
        brake = jo.Spring(f"{name} brake", slide.displacement, damping=100.0)
        pad = Contact(
            *(f"{name} pad", jaw["origin"], Cuboid((0.02, 0.06, 0.06))),
            *(part["origin"], Cuboid((SIZE,) * 3), PAD),
            mu_static=STATIC,
            mu_kinetic=KINETIC,
        )
        items += [jaw, slide, push, brake, pad]
    floor = PowerLaw(1e5, 1.0, restitution=0.3, slowest=0.05)
    for i, (x, y) in enumerate([(-1, -1), (-1, 1), (1, -1), (1, 1)]):
        foot = part.at((x * SIZE / 2, y * SIZE / 2, -SIZE / 2))
        items.append(
            Contact(f"foot {i}", jo.ground["origin"], HalfSpace(), foot, Sphere(0.0), floor)
        )
    items += [
        jo.PositionSensor("place", part["origin"]),
        jo.PositionSensor("in the hand", part["origin"], relative_to=hand["origin"]),
        jo.VelocitySensor("speed", part["origin"]),
    ]
    return jo.compile(jo.Mechanism(*items, jo.Gravity((0, 0, -G))))


def main(out: Path) -> int:
    """Lift, hold and drop the part, draw it; return 0 if it creeps nowhere and falls as it must."""
    out.mkdir(parents=True, exist_ok=True)
    run = jo.simulate(gripper(), HOLD + 0.1, solver=jo.ROS2(1e-3), output_step=1e-2)
    held = (run.time > 2.0) & (run.time < HOLD)
    path = run["in the hand"][held]
    creep = float(np.linalg.norm(path - path[0], axis=1).max())
    height = run["place"][held][-1, 2] - SIZE / 2
    print(f"lifted by {height:.6f} m of {LIFT} m, the rest is in bristles and pads")
    print(f"creep in {HOLD - 2:.0f} s: {1e9 * creep:.3f} nm")
    falls = run.time > HOLD + 0.035
    fall = -np.polyfit(run.time[falls], run["speed"][falls, 2], 1)[0]
    exact = G - 2 * KINETIC * WEAK / MASS
    print(f"slides out with {fall:.3f} m/s2, closed form {exact:.3f} m/s2")
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3), layout="constrained")
        left.plot(run.time[:200], run["place"][:200, 2], color=COLORS[0])
        left.set(xlabel="time (s)", ylabel="height of the part (m)")
        right.plot(run.time[held], 1e9 * (path[:, 2] - path[0, 2]), color=COLORS[1])
        right.set(xlabel="time (s)", ylabel="creep (nm)", ylim=(-1, 1))
        figure.savefig(out / "gripper.png")
        plt.close(figure)
    return int(creep > 1e-11 or abs(fall / exact - 1) > 1e-3)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
