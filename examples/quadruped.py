"""A quadruped from its MJCF file stands on a floor and on a slope, then trots: contacts that last.

Each foot is a sphere on a half-space, with friction by a bristle that sticks. Standing, the forces
of the feet carry the weight and no foot creeps, not even on a slope of 10 degrees. In a trot the
diagonal pairs of legs take turns; with a quarter of the step the robot takes the same path.
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.mechanism import Contact, HalfSpace, PowerLaw, Sphere
from jousto.output.style import COLORS, STYLE

FILE = Path(__file__).parent / "data" / "quadruped.xml"
HIP, KNEE, LENGTH, RADIUS = np.radians(25), np.radians(-50), 0.2, 0.025  # of the stance, m
WEIGHT = 12.8 * 9.81  # N
SHINS = {"fl": "body3", "fr": "body5", "hl": "body7", "hr": "body9"}
SWING, RATE, TIME = np.radians(8), 1.0, 8.0  # amplitude of hips and knees, Hz, s
RUBBER = PowerLaw(1e6, restitution=0.1, slowest=0.1)


def quadruped(
    swing: float = 0.0, slope: float = 0.0, above: float = 0.0, contacts: bool = True
) -> jo.Model:
    """The robot on a floor, or above it; servos hold its joints and let the legs swing, 1 Hz."""
    with warnings.catch_warnings():  # the reader warns that it makes no contacts of its shapes
        warnings.filterwarnings("ignore", ".*contact is off")
        robot = jo.robots.read_mjcf(FILE)
    at = {f"{leg}_{joint}": x for leg in SHINS for joint, x in (("hip", HIP), ("knee", KNEE))}
    down = 9.81 * np.array([-np.sin(slope), 0.0, -np.cos(slope)])
    body = jo.robots.mechanism(robot, gravity=down, at=at, actuators=False)
    links = {one.name: one for one in body.bodies}
    joints: dict[str, Any] = {
        one.name: one.coordinate for one in body.sensors if isinstance(one, jo.CoordinateSensor)
    }
    floor = jo.ground.at((0, 0, 0.42 - 2 * LENGTH * np.cos(HIP) - RADIUS - above))
    items: list[Any] = [jo.PositionSensor("trunk", links["trunk"]["origin"])]
    for leg, shin in SHINS.items():
        foot = links[shin].at((0, 0, -LENGTH))
        contact = Contact(leg, floor, HalfSpace(), foot, Sphere(RADIUS), RUBBER, mu_kinetic=0.8)
        if contacts:
            items += [contact, jo.ForceSensor(f"{leg} force", contact)]
        items += [jo.PositionSensor(f"{leg} foot", foot)]
        phase = 0.0 if leg in ("fl", "hr") else np.pi
        for joint, mean, ahead in (("hip", HIP, 0.0), ("knee", KNEE, np.pi / 2)):
            wanted = jo.Harmonic(frequency=RATE, amplitude=swing, phase=phase + ahead, offset=mean)
            items.append(jo.Servo(f"{leg} {joint}", joints[f"{leg}_{joint}"], wanted, 400.0, 10.0))
    return jo.compile(jo.Mechanism(*body.items, *items))


def stand(slope: float) -> jo.Solution:
    """Three seconds in the stance."""
    return jo.simulate(quadruped(slope=slope), 3.0, solver=jo.ROS2(2e-3))


def trot(model: jo.Model, step: float) -> jo.Solution:
    """Eight seconds with swinging legs."""
    return jo.simulate(model, TIME, solver=jo.ROS2(step), output_step=1e-2)


def force(run: jo.Solution) -> np.ndarray:
    """Sum of the forces on the feet (instants, 3), N."""
    return np.sum([run[f"{leg} force"] for leg in SHINS], axis=0)


def creep(run: jo.Solution) -> float:
    """Largest path of a foot in the last second, m."""
    late = run.time > 2.0
    return max(float(np.ptp(run[f"{leg} foot"][late], axis=0).max()) for leg in SHINS)


def draw(runs: dict[str, jo.Solution], path: Path) -> None:
    """The path of the trunk with both steps, and the feet over the floor."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(12, 3.6), layout="constrained")
        for i, (label, run) in enumerate(runs.items()):
            dashed = {"linestyle": (0, (5, 2))} if i else {}
            left.plot(run.time, run["trunk"][:, 0], color=COLORS[i], label=label, **dashed)
        left.set_title("Trunk, forward", **bold)
        left.set(xlabel="time (s)", ylabel="m")
        left.legend()
        run = next(iter(runs.values()))
        late = run.time > TIME - 2.0 / RATE
        for i, leg in enumerate(SHINS):
            height = 1e3 * (run[f"{leg} foot"][late, 2] - run[f"{leg} foot"][:, 2].min())
            right.plot(run.time[late], height, color=COLORS[i], label=leg)
        right.set_title("Feet above the floor", **bold)
        right.set(xlabel="time (s)", ylabel="mm")
        right.legend(ncols=4)
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Stand, trot, compare and draw; return 0 if weight, creep and path are right."""
    out.mkdir(parents=True, exist_ok=True)
    level, slope = stand(0.0), stand(np.radians(10))
    carried = abs(force(level)[-1, 2] / WEIGHT - 1.0)
    hips, knees = (
        np.degrees(np.mean([level[f"{leg}_{joint}"][-1, 0] for leg in SHINS]))
        for joint in ("hip", "knee")
    )
    print(f"the feet carry the weight to {carried:.0e}; hips {hips:.2f}, knees {knees:.2f} degrees")
    crept = max(creep(level), creep(slope))
    print(f"no foot creeps by more than {1e9 * crept:.3f} nm in a second, level or at 10 degrees")
    model = quadruped(SWING)
    with warnings.catch_warnings():  # 140 J pass the servos and feet, whose errors sum up to 0.7 J
        warnings.filterwarnings("ignore", ".*energy balance")
        runs = {f"step {1e3 * step:g} ms": trot(model, step) for step in (2e-3, 5e-4)}
    far = [run["trunk"][-1, 0] for run in runs.values()]
    print("trots", " and ".join(f"{x:.3f} m" for x in far), "with steps of 2 and 0.5 ms")
    draw(runs, out / "quadruped.png")
    good = carried < 1e-9 and crept < 1e-9 and abs(far[0] / far[1] - 1.0) < 0.02
    good = good and abs(hips - 24.93) < 0.05 and abs(knees + 50.32) < 0.05
    print("the quadruped stands and trots" if good else "THE QUADRUPED IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
