"""A six-axis arm from its URDF file welds a circle: angles, torques, the run, and its stops.

Inverse kinematics gives the angles for the tip of the torch on a circle, pointing down and within
the limits of the joints; inverse dynamics gives the torques. The engine, which knows nothing of
either, gets the torques alone and has to draw the circle. Then the motors are switched off: the arm
falls onto its stops and stays inside.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.interpolate import CubicSpline

import jousto as jo
from jousto.output.style import COLORS, STYLE

FILE = Path(__file__).parent / "data" / "six_axis_arm.urdf"
CENTER, RADIUS, TIME = np.array([0.62, 0.1, 0.25]), 0.15, 1.5  # m, m, s
DOWN = jo.Rotate((0, 1, 0), degrees=90)  # x of the torch points down
FALL = 3.0  # s
AXES = [f"axis {i}" for i in range(1, 7)]


def circle(t: np.ndarray) -> np.ndarray:
    """Points (k, 3) of the seam, m: one turn from rest to rest."""
    s = t / TIME
    angle = 2 * np.pi * s**3 * (10 - 15 * s + 6 * s**2)
    return CENTER + RADIUS * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)


def angles(tree: jo.robots.Tree, points: np.ndarray) -> np.ndarray:
    """Angles (k, 6) with the tip on the points, each found from the one before."""
    found = []
    start = np.array([0.1, 0.2, 0.3, 0.0, 0.9, 0.0])
    for point in points:
        reached = jo.robots.inverse_kinematics(tree, "tip", point, DOWN, start=start, starts=1)
        if not reached:
            raise SystemExit(f"the seam is out of reach: {reached}")
        found.append(start := reached.q)
    return np.array(found)


def torques(tree: jo.robots.Tree, t: np.ndarray, path: CubicSpline) -> np.ndarray:
    """Torques (k, 6) that move the arm along angles, N m."""
    rows = zip(path(t), path(t, 1), path(t, 2), strict=True)
    return np.array([tree.inverse_dynamics(*row) for row in rows])


def tip(tree: jo.robots.Tree, run: jo.Solution) -> np.ndarray:
    """Where the tip is in a run (instants, 3), m."""
    q = np.stack([run[axis][:, 0] for axis in AXES], axis=1)
    return np.array([tree.pose("tip", row).r for row in q])


def welded(robot: jo.robots.Robot, q: np.ndarray, t: np.ndarray, tau: np.ndarray) -> jo.Solution:
    """The run under the torques alone, without losses and stops."""
    motors = {axis: jo.Table(t, tau[:, i], "cubic") for i, axis in enumerate(AXES)}
    start = dict(zip(AXES, q[0], strict=True))
    machine = jo.robots.mechanism(robot, at=start, efforts=motors, losses=False, stops=False)
    return jo.simulate(jo.compile(machine), TIME, solver=jo.RK4(1e-3), output_step=0.01)


def fallen(robot: jo.robots.Robot, q: np.ndarray) -> jo.Solution:
    """The run without motors, with the losses and stops of the file."""
    machine = jo.robots.mechanism(robot, at=dict(zip(AXES, q, strict=True)))
    return jo.simulate(jo.compile(machine), FALL, output_step=0.01)


def draw(tree: jo.robots.Tree, t: np.ndarray, tau: np.ndarray, runs: list, path: Path) -> None:
    """The seam, the torques, and the fall between the limits."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    drawn, fall = runs
    with plt.style.context(STYLE):
        figure, (left, middle, right) = plt.subplots(1, 3, figsize=(12, 3.8), layout="constrained")
        seam, real = circle(t), tip(tree, drawn)
        left.plot(*seam[:, :2].T, color=COLORS[0], label="wanted")
        left.plot(*real[:, :2].T, color=COLORS[1], linestyle=(0, (5, 2)), label="under the torques")
        left.set_aspect("equal")
        left.set_title("Tip of the torch", **bold)
        left.set(xlabel="x (m)", ylabel="y (m)")
        left.legend(loc="center")
        for i, axis in enumerate(AXES):
            middle.plot(t, tau[:, i], color=COLORS[i % len(COLORS)], label=axis)
        middle.set_title("Torques", **bold)
        middle.set(xlabel="time (s)", ylabel="N m")
        middle.legend(ncols=2, fontsize=8)
        for i, axis in enumerate(AXES[1:3], start=1):
            color = COLORS[i]
            right.plot(fall.time, np.degrees(fall[axis][:, 0]), color=color, label=axis)
            for limit in (tree.lower[i], tree.upper[i]):
                right.axhline(np.degrees(limit), color=color, linewidth=0.8, linestyle=(0, (2, 2)))
        right.set_title("Motors off: onto the stops", **bold)
        right.set(xlabel="time (s)", ylabel="degrees")
        right.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Weld, fall, compare and draw; return 0 if the circle is closed and the limits hold."""
    out.mkdir(parents=True, exist_ok=True)
    robot = jo.robots.read_urdf(FILE)
    tree = jo.robots.Tree(robot)
    coarse, t = np.linspace(0.0, TIME, 76), np.linspace(0.0, TIME, 601)
    path = CubicSpline(coarse, angles(tree, circle(coarse)), bc_type="clamped")
    q = path(t)
    tau = torques(tree, t, path)
    run, fall = welded(robot, q, t, tau), fallen(robot, q[0])

    off = np.linalg.norm(tip(tree, run) - circle(run.time), axis=1)
    inside = ((q >= tree.lower) & (q <= tree.upper)).all()
    values = np.stack([fall[axis][:, 0] for axis in AXES], axis=1)
    over = np.maximum(values - tree.upper, tree.lower - values).max()
    print("largest torques", " ".join(f"{x:.1f}" for x in np.abs(tau).max(axis=0)), "N m")
    print(f"the tip leaves the circle by up to {1e3 * off.max():.3f} mm under the torques alone")
    print(f"without motors a joint goes {np.degrees(max(over, 0.0)):.2f} degrees into its stop")
    draw(tree, t, tau, [run, fall], out / "six_axis_arm.png")
    jo.still(run, out / "six_axis_arm_still.png", times=(0.0, 0.6, 0.9))

    good = inside and off.max() < 1e-3 and 0.0 < over < np.radians(3.0)
    print("the arm welds its circle" if good else "THE ARM IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
