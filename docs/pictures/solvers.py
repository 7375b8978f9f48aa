"""Draw the error of each method against the evaluations it takes, for three kinds of machine.

.venv/bin/python docs/pictures/solvers.py FOLDER
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

STEPS = (1e-3, 5e-4, 2e-4, 1e-4)
METHODS: dict[str, Callable[[float], jo.Solver]] = {
    "RK4": jo.RK4,
    "ROS2": jo.ROS2,
    "GeneralizedAlpha": jo.GeneralizedAlpha,
    "DormandPrince": lambda step: jo.simulation.DormandPrince(tolerance=1e-2 * step),
}


def rod() -> jo.Model:
    """A steel rod of four modes falls about one end."""
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    part = jo.Part.beam(2.0, jo.Rectangle(0.008, 0.04), 8, steel)
    arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(("start",), modes=4)))
    pivot = jo.Revolute("pivot", jo.ground["origin"], arm["start"], (0, 0, 1))
    return compiled(arm, pivot, (0, -9.81, 0), arm["end"])


def bushing() -> jo.Model:
    """A rigid bar hangs in a bushing of 1e9 N/m."""
    bar = jo.RigidBody("bar", 2.0, (0.05, 0.2, 0.2), center=(0.5, 0, 0), markers={"tip": (1, 0, 0)})
    stiff, damped = [1e9, 1e9, 1e9, 0, 0, 0], [1e3, 1e3, 1e3, 0, 0, 0]
    rubber = jo.Bushing("rubber", jo.ground["origin"], bar["origin"], stiff, damped)
    return compiled(bar, rubber, (0, -9.81, 0), bar["tip"])


def cable() -> jo.Model:
    """A cable of 20 exact elements falls about one end."""
    nylon = jo.Material(E=1e9, nu=0.3, rho=1200)
    line = jo.BeamBody("cable", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.004), nylon, elements=20)
    hook = jo.Spherical("hook", jo.ground["origin"], line["start"])
    return compiled(line, hook, (0, 0, -9.81), line["end"])


def compiled(body: object, held: object, weight: tuple[float, ...], tip: object) -> jo.Model:
    """Join a body to ground under gravity, with a sensor at its tip."""
    sensor = jo.PositionSensor("tip", tip)  # type: ignore[arg-type]
    return jo.compile(jo.Mechanism(body, held, jo.Gravity(weight), sensor))  # type: ignore[arg-type]


# end of the run, s, and the method and step of the reference
CASES: dict[str, tuple[Callable[[], jo.Model], float, jo.Solver]] = {
    "flexible rod": (rod, 2.0, jo.RK4(2e-5)),
    "stiff bushing": (bushing, 1.0, jo.RK4(1e-5)),
    "exact beam": (cable, 0.5, jo.GeneralizedAlpha(2e-5)),
}


def main(folder: Path) -> None:
    """Run the cases, print what each took and draw them side by side."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(10.5, 3.6), layout="constrained", sharey=True)
        for ax, (name, (make, end, reference)) in zip(axes, CASES.items(), strict=True):
            model = make()
            exact = jo.simulate(model, end, solver=reference, output_step=0.01)["tip"]
            for color, (method, solver) in zip(COLORS, METHODS.items(), strict=False):
                points = []
                for step in STEPS:
                    started = time.process_time()
                    try:
                        run = jo.simulate(model, end, solver=solver(step), output_step=0.01)
                    except jo.SimulationError as error:
                        print(f"{name:14} {method:17} {step:.0e}  {str(error)[:60]}")
                        continue
                    spent = time.process_time() - started
                    error = np.abs(run["tip"] - exact).max()
                    points.append((run.work.evaluations[-1], error))
                    print(
                        f"{name:14} {method:17} {step:.0e}  {error:.1e} m  "
                        f"{run.work.steps[-1]:.0f} steps  "
                        f"{run.work.evaluations[-1]:.0f} evaluations  {1e3 * spent:5.0f} ms"
                    )
                if points:
                    ax.loglog(*zip(*points, strict=True), "o-", color=color, label=method)
            ax.set_title(name, loc="left", fontweight="bold", fontsize=10.5)
            ax.minorticks_off()
            ax.set(xlabel="evaluations", xlim=(9e2, 2.5e6))
        axes[0].set_ylabel("largest error of the tip (m)")
        axes[0].legend(fontsize=8)
        figure.savefig(folder / "solvers.png")
        plt.close(figure)


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
