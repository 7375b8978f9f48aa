"""A crane whose slewing drive is somebody else's: a functional mock-up unit in its model file.

The maker of the drive hands over `drive.fmu`: motor, controller and rotor behind a shaft that
gives. Here we are the maker, too, and export it; so the whole machine can also be computed as one,
and the difference is the error of the exchange. It halves with the time between exchanges where
values are held from one to the next, and is far smaller where they go on along straight lines.
"""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

CRANE = Path(__file__).parent / "crane_live.yaml"
ROTOR, SHAFT = 1500.0, 700e3  # kg m2 and N m/rad, as the crane feels them
KP, KD = 400e3, 60e3  # N m/rad, N m s/rad of the controller
GOAL = jo.SCurve((0.1, 1.2), (0.0, np.deg2rad(15.0)))
T_END = 1.6
OWN = jo.GeneralizedAlpha(step=1e-3)
STEPS = (32e-3, 16e-3)  # s between exchanges

SLEWING = """
  - type: joint-force
    name: slewing
    coordinate: slew ring.angle
    signal: {type: product, factors: [-1, {type: input, name: shaft}]}   # against the rotor
"""
UNIT = """
fmus:
  - name: drive
    file: drive.fmu
    inputs: {angle: ring}      # of the slew ring, measured by the sensor below
    outputs: {shaft: shaft}    # torque on the rotor
    step: STEP
    between: BETWEEN
"""


def rotor() -> tuple[jo.RigidBody, jo.Revolute, jo.Servo]:
    """The rotor on its bearing and the motor that holds it at the wanted angle."""
    body = jo.RigidBody("rotor", 300.0, (ROTOR, ROTOR, ROTOR))
    bearing = jo.Revolute("bearing", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    return body, bearing, jo.Servo("motor", bearing.angle, GOAL, kp=KP, kd=KD)


def drive() -> jo.Mechanism:
    """The drive alone: the crane is the angle behind its shaft."""
    body, bearing, motor = rotor()
    shaft = jo.Servo("shaft", bearing.angle, jo.Input("angle"), kp=SHAFT)
    return jo.Mechanism(
        body, bearing, motor, shaft, jo.ForceSensor("shaft", shaft), name="slewing drive"
    )


def described(text: str) -> str:
    """The crane's model file without its own slewing drive."""
    start = text.index("  - type: servo\n    name: slewing")
    end = text.index("  - type: servo\n    name: luffing")
    text = text[:start] + SLEWING.lstrip("\n") + text[end:]
    ring = "sensors:\n  - {type: coordinate, name: ring, coordinate: slew ring.angle}"
    # nobody knows where it rests beside a unit: it starts straight, as the whole machine does
    text = re.sub(r"  start: rest.*\n", "", text)
    return text.replace("sensors:", ring)


def with_unit(folder: Path, step: float, between: str) -> jo.Mechanism:
    """The crane with the unit in its model file."""
    unit = UNIT.replace("STEP", f"{step} s").replace("BETWEEN", between)
    path = folder / "crane.yaml"
    path.write_text(described(CRANE.read_text(encoding="utf-8")) + unit, encoding="utf-8")
    return jo.read_model(path, trust=True).mechanism


def as_one() -> jo.Mechanism:
    """Crane, shaft and drive in one machine."""
    crane = jo.read_model(CRANE).mechanism
    ring = next(joint for joint in crane.joints if joint.name == "slew ring")
    assert isinstance(ring, jo.Revolute)
    body, bearing, motor = rotor()
    column = next(one for one in crane.bodies if one.name == "column")
    twist = jo.Angle(body["origin"], column["origin"])
    shaft = jo.Spring("shaft", twist, stiffness=SHAFT, free=0.0)
    kept = [item for item in crane.items if getattr(item, "name", "") != "slewing"]
    return jo.Mechanism(*kept, body, bearing, motor, shaft, jo.CoordinateSensor("ring", ring.angle))


def angle(mechanism: jo.Mechanism) -> tuple[np.ndarray, np.ndarray]:
    """Time and angle of the slew ring, s and rad."""
    run = jo.simulate(jo.compile(mechanism), T_END, solver=OWN, output_step=32e-3)
    return run.time, run["ring"][:, 0]


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    made = tempfile.TemporaryDirectory()
    jo.write(jo.compile(drive()), Path(made.name) / "drive.fmu", solver=jo.RK4(step=1e-3))
    time, whole = angle(as_one())
    errors: dict[str, list[float]] = {}
    with plt.style.context(STYLE):
        figure, (place, off) = plt.subplots(2, 1, figsize=(7.2, 5.0), layout="constrained")
        place.plot(time, np.rad2deg(GOAL(time)), color="0.6", label="wanted")
        place.plot(time, np.rad2deg(whole), color=COLORS[0], label="slew ring")
        place.set(ylabel="angle in deg")
        for between, color in zip(("hold", "linear"), COLORS[1:], strict=False):
            errors[between] = []
            for step, line in zip(STEPS, (":", "-"), strict=True):
                _, found = angle(with_unit(Path(made.name), step, between))
                errors[between].append(float(np.abs(found - whole).max()))
                label = f"{between}, {1e3 * step:.0f} ms"
                off.plot(time, np.rad2deg(found - whole), line, color=color, label=label)
        off.set(xlabel="time in s", ylabel="error of the exchange in deg")
        for axis in (place, off):
            axis.legend()
        figure.savefig(folder / "crane_drive.png")
    made.cleanup()
    for between, least in (("hold", 0.85), ("linear", 1.4)):
        order = float(np.log2(errors[between][-2] / errors[between][-1]))
        print(f"{between:7} error {np.rad2deg(errors[between][-1]):.1e} deg, order {order:.1f}")
        assert order > least
    assert errors["linear"][-1] < 0.1 * errors["hold"][-1] < np.deg2rad(0.1)


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path.cwd())
