"""Implicit methods side by side: microseconds per step of ROS2, generalised alpha and EXUDYN's.

python benchmarks/implicit.py        all cases, under a minute
python benchmarks/implicit.py quick  without the long chains
python benchmarks/implicit.py short  the first one: that it runs

All at 1 ms. Generalised alpha ends its iteration by the error of the step, EXUDYN by its default
tolerances, with
its default full Newton and with modified Newton.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from typing import Any

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import exudyn_peer
import jousto as jo
from cases import Case, beam, mechanism

H = 1e-3
SOLVERS = (
    jo.ROS2(step=H),
    jo.GeneralizedAlpha(step=H, tangent="exact"),
    jo.GeneralizedAlpha(step=H, tangent="modified"),
)
CASES = (
    Case("spherical", 1, 2),
    Case("spherical", 1, 10),
    Case("spherical", 1, 30),
    Case("spherical", 5, 10),
    Case("revolute", 5, 10),
    Case("revolute", 20, 10),
    Case("revolute", 100, 10),
)


def cost(model: jo.Model, solver: Any, steps: int) -> tuple[float, float]:
    """Microseconds and Newton iterations per step, the least of three runs of the engine alone."""
    best, iterations = np.inf, 0.0
    for _ in range(3):
        engine = jo.model.Engine(model)
        native = engine.native_solver(
            solver.method, solver.step, solver.projection, **solver.options
        )
        rows = np.zeros((1, engine.row_size))
        engine.run(native, 2, 10**9, rows)  # the first step starts up
        before = int(engine.counts.iterations)
        begin = time.process_time()
        status, _ = engine.run(native, steps, 10**9, rows)
        best = min(best, time.process_time() - begin)
        assert status == "ok", f"{solver} stopped with status {status}"
        iterations = (int(engine.counts.iterations) - before) / steps
    return 1e6 * best / steps, iterations


def line(case: Case) -> str:
    """Return one line of the table."""
    reduced = beam(case.modes)
    model = jo.compile(mechanism(case, reduced))
    steps = max(20, 2000 // case.bodies)
    (ros2, _), (exact, k), (kept, j) = (cost(model, solver, steps) for solver in SOLVERS)
    end = steps * H
    full = exudyn_peer.build(case, reduced)(H, end)
    modified = exudyn_peer.build(case, reduced, modified_newton=True)(H, end)
    return (
        f"{case.name:30s} {ros2:8.1f} {exact:8.1f} {k:4.1f} {kept:8.1f} {j:4.1f} "
        f"{full.microseconds:9.0f} {full.newton:4.1f} {modified.microseconds:9.0f} "
        f"{modified.newton:4.1f} {full.microseconds / exact:7.1f} "
        f"{modified.microseconds / kept:7.1f}"
    )


def main() -> None:
    """Print the table."""
    warnings.simplefilter("ignore")
    print(f"{'':30s} {'':8s} generalised alpha, iter.    EXUDYN, iterations          ratio")
    print(
        f"{'microseconds a step':30s} {'ROS2':>8s} {'exact':>8s} {'':4s} {'modified':>8s} {'':4s} "
        f"{'full':>9s} {'':4s} {'modified':>9s} {'':4s} {'full':>7s} {'modif.':>7s}"
    )
    for case in CASES[: 1 if "short" in sys.argv else None]:
        if case.bodies <= 5 or "quick" not in sys.argv:
            print(line(case), flush=True)


if __name__ == "__main__":
    main()
