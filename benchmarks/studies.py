"""What a study costs beside the engine's steps: 1 s of the flexible pendulum, many times.

Process time of one thread. Run: python benchmarks/studies.py [points]
"""

from __future__ import annotations

import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np

import jousto as jo
from jousto.model.native.native import Engine
from jousto.simulation.solvers.explicit import prepared

MODEL = (Path(__file__).parent.parent / "examples" / "flexible_pendulum.yaml").read_text()
SOLVER, STEPS, EVERY = jo.RK4(1e-3), 1000, 10
RUN = {"t_end": 1.0, "solver": SOLVER, "output_step": 1e-2}
OUTCOMES = ["max(tip.x)", "last(middle.y)"]


def rod(height: float) -> jo.ReducedPart:
    """Return the reduced rod of the example."""
    part = jo.Part.frame(
        nodes=[[0, 0, 0], [0.5, 0, 0], [1, 0, 0], [1.5, 0, 0], [2, -1e-5, 0]],
        elements=[[0, 1], [1, 2], [2, 3], [3, 4]],
        sections=jo.Rectangle(0.1, height),
        materials=jo.Material(E=207e6, nu=0.3, rho=7850.0),
        lumped=True,
    )
    reduced = jo.reduce(part, jo.CraigBampton(["node1"], 4))
    return reduced.keep(reduced.in_plane("xy"))


def pendulum(height: float = 0.1, g: float = 9.81) -> jo.Mechanism:
    """Return the pendulum with a force at its tip that is an input."""
    arm = jo.FlexibleBody("arm", rod(height))
    return jo.Mechanism(
        arm,
        jo.Spherical("pivot", jo.ground["origin"], arm["node1"]),
        jo.Force("push", arm["node5"], (1.0, 0.0, 0.0), signal=jo.Input("load")),
        jo.Gravity((0, -g, 0)),
        jo.PositionSensor("middle", arm["node3"]),
        jo.PositionSensor("tip", arm["node5"]),
    )


def spent(work: Callable[[], object]) -> float:
    """Return the process time of some work, s."""
    start = time.process_time()
    work()
    return time.process_time() - start


def steps_alone(model: jo.Model, count: int) -> float:
    """Return the process time of the steps alone."""
    total = 0.0
    for _ in range(count):
        engine = Engine(model)
        native, rows = prepared(engine, SOLVER, 1e-3), np.empty((STEPS // EVERY, engine.row_size))
        total += spent(lambda e=engine, n=native, r=rows: e.run(n, STEPS, EVERY, r))
    return total


def main() -> None:
    """Print the times."""
    warnings.simplefilter("ignore")
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    model = jo.compile(pendulum())
    load = jo.Parameter("load", 0.0, bounds=(-100.0, 100.0), unit="N")
    g = jo.Parameter("g", 9.81, bounds=(9.0, 10.0), unit="m/s2")
    height = jo.Parameter("height", 0.1, bounds=(0.09, 0.11), unit="m")
    kinds = {
        "an input (runs only)": (model, load, count),
        "gravity (compiles)": (pendulum, g, count // 5),
        "the section (reduces, compiles)": (pendulum, height, count // 20),
    }
    for name, (machine, parameter, n) in kinds.items():
        study = jo.study(machine, parameter, OUTCOMES, **RUN)
        points = jo.design.latin_hypercube(study.parameters, n)
        study(points[:3])
        whole = [spent(lambda s=study, p=points: s.run(p)) for _ in range(3)]
        steps = min(steps_alone(model, n) for _ in range(3))
        print(
            f"{name}: {n} points in {min(whole):.3f} s, {1e3 * min(whole) / n:.3f} ms each; "
            f"steps alone {steps:.3f} s, ratio {min(whole) / steps:.2f}; {study.counts}"
        )
    n = min(200, count)
    loads = jo.design.latin_hypercube([load], n)[:, 0]

    def loop() -> None:
        for value in loads:
            run = jo.simulate(model, inputs={"load": float(value)}, **RUN)
            run["tip"][:, 0].max(), run["middle"][-1, 1]

    study = jo.study(model, load, OUTCOMES, **RUN)
    print(
        f"{n} points of an input: a loop over simulate {min(spent(loop) for _ in range(3)):.3f} s"
    )
    print(f"the same by study {min(spent(lambda: study(loads[:, None])) for _ in range(3)):.3f} s")


if __name__ == "__main__":
    main()
