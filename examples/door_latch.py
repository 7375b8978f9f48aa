"""A door falls into its latch, and a pull opens it or not: wedge, spring and friction.

The sloping front of the bolt meets the lip of the frame and is pushed in; behind the lip the spring
throws it out again. Pulled open, the lip presses on the back of the bolt. With the angle a of the
back and mu = tan(11.31 degrees) the latch gives way at S (cos a + mu sin a) / (sin a - mu cos a), S
the force of the spring; below 11.31 degrees it holds for ever.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.mechanism import Capsule, Contact, ConvexHull, PowerLaw, RigidStop
from jousto.output.style import COLORS, STYLE

RADIUS, MU, SPRING, PULL = 0.8, 0.2, 15.0, 50.0  # m to the bolt, N, N/s of the pull
LIP, ROUND = 0.006, 0.002  # reach of the lip over the bolt and its radius, m
CLOSED = 1.0  # s, from then on it is pulled


def bolt_shape(back: float) -> ConvexHull:
    """Return the wedge of the bolt in the plane, its back through (LIP, 0) at an angle, rad."""
    slope = np.tan(back)
    ends = [(x, slope * (LIP - x)) for x in (-0.015, 0.015)]
    front = [(0.015, ends[1][1] - 0.002), (-0.015, ends[1][1] - 0.032)]
    return ConvexHull([(x, y, z) for x, y in (*ends, *front) for z in (-0.01, 0.01)])


def door(back: float) -> jo.Model:
    """Return a door 0.1 rad before its frame at 1 rad/s, with a latch whose back has an angle."""
    turn = (np.cos(0.05), 0, 0, np.sin(0.05))
    leaf = jo.RigidBody("leaf", 20.0, (0.1, 1.5, 1.5), center=(0.4, 0, 0), orientation=turn)
    hinge = jo.Revolute("hinge", jo.ground["origin"], leaf["origin"])
    place = RADIUS * np.array([np.cos(0.1), np.sin(0.1), 0])
    bolt = jo.RigidBody("bolt", 0.1, (1e-5,) * 3, position=place, orientation=turn)
    guide = jo.Prismatic("guide", leaf.at((RADIUS, 0, 0)), bolt["origin"], axis=place)
    spring = jo.Spring("spring", guide.displacement, 200.0, damping=2.0, preload=SPRING)
    gap = 2e-4  # between lip and back of the bolt of the closed door, m
    normal = np.array([np.sin(back), np.cos(back)])
    lip = np.array([RADIUS + LIP, 0.0]) + (ROUND + gap) * normal
    latch = Contact(
        *("latch", jo.ground.at((*lip, 0)), Capsule(ROUND, 0.1)),
        *(bolt["origin"], bolt_shape(back), PowerLaw(1e6, 1.0, restitution=0.2, slowest=0.02)),
        mu_kinetic=MU,
    )
    pull = jo.Ramp(CLOSED, CLOSED + 10, before=0.0, after=10 * PULL)
    return jo.compile(
        jo.Mechanism(
            *(leaf, hinge, bolt, guide, spring, latch),
            RigidStop("frame", hinge.angle, lower=-0.1, restitution=0.1),
            RigidStop("end", guide.displacement, upper=0.0, restitution=0.0),
            jo.Initial(hinge.angle, rate=-1.0),
            jo.JointForce("pull", hinge.angle, RADIUS * pull),
            jo.CoordinateSensor("door", hinge.angle),
            jo.CoordinateSensor("bolt", guide.displacement),
        )
    )


def main(out: Path) -> int:
    """Close and pull two doors; return 0 if one opens at its pull and the other holds."""
    out.mkdir(parents=True, exist_ok=True)
    runs = {}
    for degrees, end in ((30.0, 2.2), (8.0, 3.5)):
        model = door(np.radians(degrees))
        runs[degrees] = jo.simulate(model, end, solver=jo.ROS2(1e-4), output_step=2e-3)
    run, a = runs[30.0], np.radians(30.0)
    leaves = [e.time for e in run.events if (e.name, e.change) == ("end", "opens")]
    found = PULL * (min(t for t in leaves if t > CLOSED) - CLOSED)  # the bolt leaves its end
    exact = (
        (1 + LIP / RADIUS) * SPRING * (np.cos(a) + MU * np.sin(a)) / (np.sin(a) - MU * np.cos(a))
    )
    print(f"a back of 30 degrees opens at {found:.1f} N, closed form {exact:.1f} N")
    tight = runs[8.0]
    moved = tight["door"][-1, 0] + 0.1
    print(
        f"one of 8 degrees holds {PULL * 2.5:.0f} N, the door gives {1e3 * RADIUS * moved:.2f} mm"
    )
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3), layout="constrained")
        for i, (degrees, run) in enumerate(runs.items()):
            label = f"back of {degrees:.0f} degrees"
            left.plot(run.time, np.degrees(run["door"] + 0.1), color=COLORS[i], label=label)
            right.plot(run.time, 1e3 * run["bolt"], color=COLORS[i])
        left.set(xlabel="time (s)", ylabel="door (degrees)", ylim=(-0.5, 8))
        left.legend()
        right.set(xlabel="time (s)", ylabel="bolt (mm)")
        figure.savefig(out / "door_latch.png")
        plt.close(figure)
    return int(abs(found / exact - 1) > 3e-3 or abs(moved) > 1e-3)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
