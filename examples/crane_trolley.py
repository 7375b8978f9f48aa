"""A crane trolley runs into its buffers: steps as long as the motion allows, and no longer.

Between the buffers the trolley and the swinging load move slowly, in a buffer everything happens in
50 ms. A fixed step must suit the buffer all the time; `DormandPrince` finds the contact, takes
short steps there and long ones elsewhere. Nothing is lost, so that the energy tells the error, and
the momentum of the trolley and its load along the rail changes only by the buffers' force.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray

import jousto as jo
from jousto.output.style import COLORS, STYLE

Array = NDArray[np.float64]
TROLLEY, LOAD, ROPE = 1000.0, 400.0, 3.0  # kg, kg, m
STIFFNESS, TRAVEL = 4e6, 1.0  # N/m of a buffer, m to either side
T_END = 3.6
TOLERANCES = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
STEPS = (1e-2, 5e-3, 2.5e-3, 1.25e-3, 6.25e-4, 3.125e-4)


def crane() -> jo.Mechanism:
    """A trolley at 2 m/s between two buffers, a load on a stiff rope below it."""
    trolley = jo.RigidBody("trolley", TROLLEY, (200.0, 200.0, 200.0), velocity=(2.0, 0.0, 0.0))
    load = jo.RigidBody(
        "load",
        LOAD,
        (30.0, 30.0, 30.0),
        position=(0.0, 0.0, -ROPE),
        velocity=(2.0, 0.0, 0.0),
        markers={"hook": (0.0, 0.0, ROPE)},
    )
    rail = jo.Prismatic("rail", jo.ground["origin"], trolley["origin"], axis=(1, 0, 0))
    end = TRAVEL + 0.2
    push = 0.2 * STIFFNESS
    buffers = jo.Table((-end, -TRAVEL, TRAVEL, end), (push, 0.0, 0.0, -push))
    spring = jo.Spring("buffers", rail.displacement, table=buffers)
    return jo.Mechanism(
        trolley,
        load,
        rail,
        jo.Revolute("hook", trolley["origin"], load["hook"], axis=(0, 1, 0)),
        spring,
        jo.Gravity((0.0, 0.0, -9.81)),
        jo.PositionSensor("trolley", trolley["origin"]),
        jo.PositionSensor("load", load["origin"]),
        jo.VelocitySensor("trolley speed", trolley["origin"]),
        jo.VelocitySensor("load speed", load["origin"]),
        jo.ForceSensor("buffer", spring),
        name="crane trolley",
    )


def run(model: jo.Model, solver: object) -> jo.Solution:
    """Results every 10 ms, whatever the steps."""
    return jo.simulate(model, T_END, solver=solver, output_step=0.01)  # type: ignore[arg-type]


def draw_steps(solution: jo.Solution, path: Path) -> None:
    """Position of trolley and load, and the length of the steps."""
    t = solution.time
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(2, 1, figsize=(7.2, 5.0), layout="constrained", sharex=True)
        place, step = axes
        for sensor, color in zip(("trolley", "load"), COLORS, strict=False):
            place.plot(t, solution[sensor][:, 0], color=color)
            x = solution[sensor][-1, 0]
            place.text(T_END + 0.03, x, sensor, color=color, va="center", fontweight="bold")
        for side in (-TRAVEL, TRAVEL):
            place.axhline(side, color="#69707A", linewidth=0.8, linestyle=":")
        place.text(0.05, TRAVEL + 0.08, "buffer", color="#69707A")
        place.set_title("Along the rail", loc="left", fontweight="bold", fontsize=10.5)
        place.set(ylabel="m")
        step.step(t[1:], 1e3 * solution.work.step[1:], where="mid", color=COLORS[0])
        step.set_yscale("log")
        title = f"Length of the {solution.work.steps[-1]:.0f} steps"
        step.set_title(title, loc="left", fontweight="bold", fontsize=10.5)
        step.set(xlabel="s", ylabel="ms", xlim=(0, T_END))
        figure.savefig(path)
        plt.close(figure)


def draw_cost(found: dict[str, tuple[Array, Array]], path: Path) -> None:
    """Error against evaluations of the equations of motion."""
    with plt.style.context(STYLE):
        figure, ax = plt.subplots(figsize=(6.4, 4.4), layout="constrained")
        for color, (name, (cost, error)) in zip(COLORS, found.items(), strict=False):
            ax.loglog(cost, error, "o-", color=color, markerfacecolor="white")
            ax.text(1.1 * cost[-1], error[-1], name, color=color, fontweight="bold", va="center")
        ax.set_title("Error of the load's position", loc="left", fontweight="bold", fontsize=10.5)
        ax.set(xlabel="evaluations of the accelerations", ylabel="m", xlim=(2e2, 2e5))
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run with several accuracies; return 0 if laws and orders hold."""
    out.mkdir(parents=True, exist_ok=True)
    model = jo.compile(crane())
    exact = run(model, jo.simulation.DormandPrince(tolerance=1e-12))
    found: dict[str, tuple[Array, Array]] = {}
    methods: dict[str, list[object]] = {
        "DormandPrince": [
            jo.simulation.DormandPrince(tolerance=tolerance) for tolerance in TOLERANCES
        ],
        "RK4": [jo.RK4(step=step) for step in STEPS],
        "ROS2": [jo.ROS2(step=step) for step in STEPS[2:]],
    }
    for name, solvers in methods.items():
        runs = [run(model, solver) for solver in solvers]
        rows = len(exact)
        cost = np.array([r.work.evaluations[-1] - rows for r in runs])  # rows cost one each
        found[name] = (cost, np.array([np.abs(r["load"] - exact["load"]).max() for r in runs]))
        print(f"{name:14} evaluations " + "".join(f"{c:10.0f}" for c in found[name][0]))
        print(f"{'':14} error (m)   " + "".join(f"{e:10.1e}" for e in found[name][1]))
    draw_cost(found, out / "work_precision.png")

    usual = run(model, jo.simulation.DormandPrince())
    draw_steps(usual, out / "trolley.png")
    # the force of the buffers is all that changes the momentum along the rail
    momentum = TROLLEY * exact["trolley speed"][:, 0] + LOAD * exact["load speed"][:, 0]
    quiet = np.abs(exact["trolley"][:, 0]) < TRAVEL - 0.05
    jumps = np.abs(np.diff(momentum))[quiet[:-1] & quiet[1:]]
    kinetic = usual.energy.kinetic.max()
    inside = np.abs(usual["trolley"][:, 0]) > TRAVEL
    ratio = float(np.median(usual.work.step[~inside]) / np.median(usual.work.step[inside]))
    print(f"steps {usual.work.steps[-1]:.0f}, tried again {usual.work.rejected[-1]:.0f}")
    print(f"outside the buffers they are {ratio:.0f} times longer than inside")
    print(f"energy error {np.abs(usual.energy.error).max() / kinetic:.1e} of the kinetic energy")
    print(f"momentum changes by {jumps.max():.1e} kg m/s between the buffers")
    good = (
        found["DormandPrince"][1][-1] < 1e-5
        and ratio > 4.0
        and np.abs(usual.energy.error).max() < 1e-4 * kinetic
        and jumps.max() < 1e-6
    )
    print("laws hold" if good else "A LAW DOES NOT HOLD")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
