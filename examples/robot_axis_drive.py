"""The axis of a robot with its electric drive: motor, current control, gear with play, brake.

A servo motor turns an arm through a gear with backlash and losses. A position and a speed
controller lead it along an S-curve, above the base speed of the motor, so that its field is
weakened. Then the brake takes over and the voltage is off. The same move with a worn gear shows
what backlash costs. Where the electrical energy goes is a book that closes.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.electric import Brake, Gearbox, SynchronousMotor, ThermalLoad
from jousto.mechanism import BlockForce, PIDController, StateSensor, rate, value
from jousto.output.style import COLORS, STYLE

ARM, CENTRE = 30.0, 0.5  # kg, m from the axis
RATIO, ROTOR = 100.0, 3e-4  # turns of the rotor per turn of the arm; kg m2
WINDING = (0.4, 1.6e-3, 2.4e-3, 0.055, 4)  # R, ohm; Ld and Lq, H; flux, V s; pairs of poles
EFFICIENCY = 0.85
TURN, T_MOVE, T_BRAKE, T_END = np.deg2rad(120.0), 0.7, 1.0, 1.6  # rad, s
PLAY = {"new gear": np.deg2rad(0.01), "worn gear": np.deg2rad(0.3)}  # on the side of the arm
SOLVER = jo.ROS2(step=5e-4)


def axis(backlash: float) -> jo.Mechanism:
    """The axis: it lifts the arm from hanging to 30 degrees above the horizontal."""
    origin, z = jo.ground["origin"], (0, 0, 1)
    arm = jo.RigidBody("arm", ARM, (0.5, 2.5, 2.5), center=(0, -CENTRE, 0))
    rotor = jo.RigidBody("rotor", 1.0, (ROTOR, ROTOR, ROTOR))
    elbow = jo.Revolute("elbow", origin, arm["origin"], axis=z)
    shaft = jo.Revolute("shaft", origin, rotor["origin"], axis=z)

    goal: Any = jo.SCurve((0.05, 0.05 + T_MOVE), (0.0, RATIO * TURN))
    place = PIDController("place", goal, value(shaft.angle), kp=25.0)
    off = jo.SCurve((T_BRAKE + 0.05, T_BRAKE + 0.1), (1.0, 0.0))  # the current fades
    speed = PIDController("speed", place["u"], rate(shaft.angle), kp=0.25, ki=5.0, limit=20.0)
    motor = SynchronousMotor(
        *("motor", shaft.angle, *WINDING),
        current=off * speed["u"],
        bandwidth=2 * np.pi * 200.0,
        dc_voltage=200.0,
        largest_current=20.0,
        strategy="least-current",
        weakening=True,
        book=True,
    )
    gear = Gearbox(
        *("gear", shaft.angle, elbow.angle, RATIO, 8e4, 400.0),
        backlash=backlash,
        efficiency=EFFICIENCY,
        book=True,
    )
    release = jo.SCurve((T_BRAKE, T_BRAKE + 0.01), (1.0, 0.0))
    brake = Brake(
        *("brake", shaft.angle, 4.0, 2e3, 5.0), release=release, lag=0.01, damping=0.05, closed=0.0
    )
    heat = ThermalLoad("heat", motor["amplitude"], rated=6.0, time=60.0)
    seen = {"motor": ("iq", "id", "vd", "vq", "supplied_work", "heat_work", "stored_work"),
            "gear": ("torque", "mechanical_work", "heat_work"), "brake": ("torque",),
            "heat": ("load",)}  # fmt: skip
    blocks = {x.name: x for x in (motor, gear, brake, heat)}
    sensors = [
        StateSensor(f"{name} {what}", blocks[name][what])
        for name, names in seen.items()
        for what in names
    ]
    return jo.Mechanism(
        *(arm, rotor, elbow, shaft, place, speed, *blocks.values()),
        BlockForce("bearing", shaft.angle, -2e-4 * rate(shaft.angle)),
        jo.Gravity((0, -9.81, 0)),
        *(
            jo.CoordinateSensor("angle", elbow.angle),
            jo.RateSensor("speed of the arm", elbow.angle),
        ),
        *(jo.RateSensor("speed of the rotor", shaft.angle), *sensors),
        name="robot axis",
    )


def check(run: jo.Solution) -> None:
    """Hold, weakened field, voltage, and the energy of the motor."""
    late = run.time > T_END - 0.2
    angle = run["angle"][-1, 0]
    weight = ARM * 9.81 * CENTRE * np.sin(angle)
    held = -run["brake torque"][-1, 0] * RATIO
    # friction of the teeth carries a part of the weight
    low, high = weight * EFFICIENCY, weight / EFFICIENCY
    print(f"the brake carries {held:.0f} N m at the arm, the weight is {weight:.0f} N m")
    assert low - 1.0 < abs(held) < high + 1.0
    creep = np.ptp(run["angle"][late])
    print(f"the arm moves by {1e6 * creep:.2f} urad in the last 0.2 s")
    assert creep < 2e-5
    size = np.hypot(run["motor vd"], run["motor vq"]).max()
    print(f"largest voltage {size:.1f} V, allowed {200 / np.sqrt(3):.1f} V; "
          f"id down to {run['motor id'].min():.1f} A")  # fmt: skip
    assert size < 200 / np.sqrt(3) + 1e-6
    assert run["motor id"].min() < -5.0
    taken = run["motor supplied_work"][-1, 0]
    lifted = ARM * 9.81 * CENTRE * (1 - np.cos(angle))
    rest = taken - run["motor heat_work"][-1, 0] - run["gear heat_work"][-1, 0]
    print(f"{taken:.0f} J from the grid, {lifted:.0f} J in the lifted arm")
    assert 0.0 < rest - lifted < 0.2 * taken, "bearings and brake take what is left"


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    runs = {
        name: jo.simulate(jo.compile(axis(x)), T_END, solver=SOLVER) for name, x in PLAY.items()
    }
    check(runs["new gear"])
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(3, sharex=True, figsize=(7.2, 6.4), layout="constrained")
        for (name, run), color in zip(runs.items(), COLORS, strict=False):
            axes[0].plot(run.time, np.rad2deg(run["angle"]), color=color, label=name)
            axes[1].plot(run.time, run["gear torque"], color=color, lw=0.8)
            axes[2].plot(run.time, run["motor iq"], color=color, lw=0.8)
        axes[2].plot(runs["new gear"].time, runs["new gear"]["motor id"], color=COLORS[2])
        for one, label in zip(axes, ("arm / deg", "gear / N m", "iq, id / A"), strict=True):
            one.set_ylabel(label)
        axes[0].legend()
        axes[2].set_xlabel("time / s")
        figure.savefig(folder / "robot_axis_drive.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path.cwd())
