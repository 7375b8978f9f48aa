"""A crane's jib is slewed until a limit switch, braked, and stops: rigid and flexible.

The motor turns the jib with T1 up to the limit switch at 40 degrees, then the brake acts with T2
against the motion; the run ends where the jib stands still. A rigid jib does so at
``limit (1 + T1 / T2)``, which the events must meet; the flexible one swings.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

LENGTH, MASS = 20.0, 20.0 * 7850 * (0.4 * 0.4 - 0.38 * 0.38)  # m, kg: a box of 0.4 m, wall 1 cm
TOWER = 5e5  # kg m2: slewing platform and counterweight about the axis
MOTOR, BRAKE = 40e3, 60e3  # N m
LIMIT = np.radians(40.0)


def jib(flexible: bool) -> jo.FlexibleBody | jo.RigidBody:
    """A steel box beam that only bends sideways, or a rod of the same mass."""
    if not flexible:
        inertia = MASS * LENGTH**2 / 12
        return jo.RigidBody(
            "jib",
            MASS,
            (1.0, inertia, inertia),
            center=(LENGTH / 2, 0, 0),
            markers={"start": (0, 0, 0), "end": (LENGTH, 0, 0)},
        )
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    box = jo.Box(0.4, 0.4, web=0.01, flange=0.01)
    part = jo.Part.beam(length=LENGTH, section=box, elements=8, material=steel)
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=12))
    return jo.FlexibleBody("jib", reduced.keep(reduced.in_plane("xy")), damping=0.01)


def slew(flexible: bool) -> jo.Solution:
    """Run one jib until it stands still."""
    body = jib(flexible)
    platform = jo.RigidBody("platform", 5000.0, (TOWER, TOWER, TOWER))
    bearing = jo.Revolute("bearing", jo.ground["origin"], platform["origin"], axis=(0, 0, 1))
    root = jo.Fixed("root", platform["origin"], body["start"])
    switch = jo.mechanism.Event("limit switch", bearing.angle, LIMIT, "rising")
    speed = jo.RateSensor("speed", bearing.angle)
    still = jo.mechanism.Event("standstill", speed, 0.0, "falling", stop=True)
    torque = jo.mechanism.Switched(switch, MOTOR, -BRAKE)
    mechanism = jo.Mechanism(
        *(platform, body, bearing, root, switch, speed, still),
        jo.JointForce("drive", bearing.angle, torque),
        jo.CoordinateSensor("angle", bearing.angle),
        jo.SignalSensor("torque", torque),
        jo.PositionSensor("tip", body["end"]),
    )
    return jo.simulate(jo.compile(mechanism), 60.0, solver=jo.ROS2(2e-3), output_step=0.02)


def deflection(run: jo.Solution) -> np.ndarray:
    """Tip of the jib across the direction at its bearing, m."""
    x, y, _ = run["tip"].T
    angle = run["angle"].ravel()
    return y * np.cos(angle) - x * np.sin(angle)


def draw(runs: tuple[jo.Solution, jo.Solution], path: Path) -> None:
    """Speed of slewing and deflection of the tip, with the instants of the events."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6), layout="constrained")
        for run, color, label in zip(runs, COLORS, ("rigid", "flexible"), strict=False):
            left.plot(run.time, np.degrees(run["speed"]), color=color, label=label)
            right.plot(run.time, 1e3 * deflection(run), color=color, label=label)
            for event in run.events:
                for axes in (left, right):
                    axes.axvline(event.time, color=color, linewidth=0.8, linestyle=(0, (2, 2)))
        left.set_title("Speed of slewing", **bold)
        left.set(xlabel="time (s)", ylabel="deg/s")
        left.legend()
        right.set_title("Deflection of the tip", **bold)
        right.set(xlabel="time (s)", ylabel="mm")
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run both jibs, compare and draw; return 0 if they stop where they must."""
    out.mkdir(parents=True, exist_ok=True)
    rigid, flexible = runs = slew(False), slew(True)
    inertia = TOWER + MASS * LENGTH**2 / 3
    time = np.sqrt(2 * LIMIT * inertia / MOTOR)
    stand = time * (1 + MOTOR / BRAKE), LIMIT * (1 + MOTOR / BRAKE)
    for name, run in (("rigid", rigid), ("flexible", flexible)):
        for event in run.events:
            print(f"{name:9} {event}")
        print(f"{name:9} stands at {np.degrees(run['angle'][-1, 0]):.4f} degrees")
    print(
        f"closed form, rigid: {time:.6f} s; {stand[0]:.6f} s at {np.degrees(stand[1]):.4f} degrees"
    )
    print(f"largest energy error {max(np.abs(run.energy.error).max() for run in runs):.1e} J")
    draw(runs, out / "slewing_limit.png")

    good = [event.name for event in rigid.events] == ["limit switch", "standstill"]
    good &= abs(rigid.events[0].time - time) < 1e-8
    good &= abs(rigid.time[-1] - stand[0]) < 1e-8
    good &= abs(rigid["angle"][-1, 0] - stand[1]) < 1e-8
    good &= abs(flexible["angle"][-1, 0] - stand[1]) < np.radians(2.0)
    print("the jib stops where it must" if good else "THE JIB IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
