"""The humanoid of MuJoCo walks six steps from its file, with driven joints and no other control.

`data/humanoid_plan.py` plans a zero-moment point under the feet and the angles of the joints, by
the linear inverted pendulum and inverse kinematics.
"""

from __future__ import annotations

import runpy
import sys
import time
import warnings
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.mechanism import CollisionShape, ContactForceSensor, Contacts, PowerLaw
from jousto.output.style import COLORS, STYLE

FILE = Path(__file__).parent / "data" / "mujoco_humanoid.xml"
PLAN = runpy.run_path(str(FILE.parent / "humanoid_plan.py"))
G, STEPS, BEGIN = PLAN["G"], PLAN["STEPS"], PLAN["BEGIN"]  # m/s2, number of steps, s
SOLE = PowerLaw(3e6, 1.0, restitution=0.1, slowest=0.1)  # N/m at each end of a capsule


def machine(robot: Any, names: list[str], t: np.ndarray, q: np.ndarray) -> jo.Mechanism:
    """The robot with driven joints, whose feet touch the floor of the file."""
    drives: dict[str, Any] = {
        name.removesuffix(".angle"): jo.Table(t, angle, "cubic") if np.ptp(angle) else angle[0]
        for name, angle in zip(names, q.T, strict=True)
    }
    body = jo.robots.mechanism(robot, drives=drives, contact=True)
    (touch,) = (one for one in body.forces if isinstance(one, Contacts))
    shapes = [
        CollisionShape(one.name, one.marker, one.shape, group=one.name[:4])
        for one in touch.shapes
        if one.name.startswith(("foot", "floor"))
    ]
    feet = Contacts("feet", shapes, law=SOLE, mu_kinetic=0.7)
    ground = ContactForceSensor("ground", feet, "floor", "foot")
    trunk = jo.PositionSensor("trunk", body.bodies[0]["origin"])
    rest = [one for one in body.items if one is not touch]
    return jo.Mechanism(*rest, feet, ground, trunk)


def pressed(run: jo.Solution) -> tuple[np.ndarray, np.ndarray]:
    """Times and centre of pressure (instants, 2) of the feet, m."""
    t, places = run.time[5::5], []
    for points in map(run.contacts.at, t):
        force = np.array([one.force for one in points])
        places.append(force @ np.array([one.point for one in points])[:, :2] / force.sum())
    return t, np.array(places)


def draw(plan: tuple[np.ndarray, ...], found: tuple[np.ndarray, ...], path: Path) -> None:
    """Planned zero-moment point and centre of pressure, sideways and forward."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(12, 3.6), layout="constrained")
        for i, (ax, name) in enumerate(zip(axes, ("Forward", "Sideways"), strict=True)):
            ax.plot(found[0], found[1][:, i], color=COLORS[0], label="centre of pressure")
            ax.plot(plan[0], plan[2][:, i], "--", color=COLORS[1], label="plan")
            ax.set_title(name, loc="left", fontweight="bold", fontsize=10.5, pad=8)
            ax.set(xlabel="time (s)", ylabel="m")
        axes[0].legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Plan, walk and draw; return 0 if the robot walks as planned."""
    out.mkdir(parents=True, exist_ok=True)
    with warnings.catch_warnings():  # tendons are not read, links between two joints have no mass
        warnings.simplefilter("ignore", jo.JoustoWarning)
        return walk(out)


def walk(out: Path) -> int:
    """Plan, walk, compare and draw."""
    robot = jo.robots.read_mjcf(FILE)
    plan = PLAN["Plan"](robot)
    t, q, p = plan.walk()
    whole = machine(robot, list(plan.tree.positions[7:]), t, q[:, 7:])
    model = jo.compile(whole)
    state = jo.robots.state_at(jo.robots.Tree(whole), model, q[0])
    clock = time.process_time()
    run = jo.simulate(model, t[-1], solver=jo.ROS2(2e-3), state=state, output_step=2e-2)
    clock = (time.process_time() - clock) / t[-1]
    wanted = np.array([np.interp(run.time, t, q[:, i]) for i in range(3)]).T
    off = np.abs(run["trunk"] - wanted).max()
    print(f"{STEPS} steps, the trunk within {1e3 * off:.1f} mm of its plan")
    late = run.time > BEGIN
    force = run["ground"][late, 2].mean() / (plan.masses.sum() * G)
    print(f"mean force on the feet over the weight {force:.4f}")
    found = pressed(run)
    error = found[1] - np.array([np.interp(found[0], t, p[:, i]) for i in (0, 1)]).T
    far = np.sqrt((error**2).mean(axis=0))
    print(f"centre of pressure {1e3 * far[0]:.1f} and {1e3 * far[1]:.1f} mm (rms) beside the plan")
    print(f"a second takes {clock:.2f} s of processor time")
    draw((t, q, p), found, out / "humanoid.png")
    good = off < 0.01 and abs(force - 1.0) < 0.01 and far.max() < 0.015
    print("the humanoid walks" if good else "THE HUMANOID FALLS")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
