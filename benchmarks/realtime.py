"""Real time: a step of exported C beside the engine in Python and EXUDYN, and its longest steps.

    realtime.py [steps]         1,000,000 if not given

EXUDYN has the pendulum and the four-bar, built of the same invariants (exudyn_peer.py); without
the package its column is empty. It takes generalised alpha, its method for stiff and closed
machines, at the same step. Bytes are those of one exported machine, all that it needs.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import jousto as jo
import machines
from cases import Case, beam, mechanism
from jousto.export.program import program
from jousto.export.project import flat_files
from jousto.export.realtime import NO_ALLOCATION, time_steps
from jousto.export.toolchain import build, platforms
from jousto.model.native.native import Engine
from jousto.simulation.solvers.base import prepared

EXAMPLES = Path(__file__).parents[1] / "examples"
PENDULUM = Case("spherical", 1, 10)
ENGINE_STEPS, REPEATS = 20_000, 3


def pendulum() -> tuple[Any, Any, Any]:
    return jo.compile(mechanism(PENDULUM, beam(10))), jo.ROS2(1e-3), None


def four_bar() -> tuple[Any, Any, Any]:
    return jo.compile(machines.four_bar()), jo.ROS2(1e-3), None


def example(name: str) -> Callable[[], tuple[Any, Any, Any]]:
    def made() -> tuple[Any, Any, Any]:
        found = jo.read_model(EXAMPLES / f"{name}.yaml")
        model = jo.compile(found.mechanism)
        given = found.simulation.given(model)
        return model, given["solver"], given.get("state")

    return made


def in_python(model: Any, solver: Any, state: Any) -> float:
    """Return the least processor time of a step of the engine that Python calls, us."""
    least = np.inf
    for _ in range(REPEATS):
        engine = Engine(model)
        if state is not None:
            from jousto.simulation.state import put

            put(engine, state, "benchmark")
        native = prepared(engine, solver, solver.step)
        rows = np.zeros((2, engine.row_size))
        begin = time.process_time()
        engine.run(native, ENGINE_STEPS, ENGINE_STEPS, rows)
        least = min(least, (time.process_time() - begin) / ENGINE_STEPS)
    return 1e6 * least


def exudyn(name: str, step: float) -> float:
    """Return the least processor time of a step of EXUDYN, us; nan if it has no such model."""
    try:
        import exudyn_machines
        import exudyn_peer
    except ImportError:
        return np.nan
    if name == "pendulum":
        return exudyn_peer.build(PENDULUM, beam(10), modified_newton=True)(
            step, 1.0, REPEATS
        ).microseconds
    if name == "four-bar":
        times = np.linspace(0.05, 1.0, 20)
        run = exudyn_machines.runner(*exudyn_machines.four_bar(), times, dense=True)
        return run(step, REPEATS).microseconds
    return np.nan


def main(steps: int) -> None:
    models = {
        "pendulum": pendulum,
        "four-bar": four_bar,
        "crane": example("crane"),
        "robot": example("robot"),
    }
    head = ("model", "step ms", "bytes", "C median", "engine", "EXUDYN", "worst", "FIFO", "granted")
    print(f"{steps} steps; median, engine, EXUDYN and the longest steps in us")
    print("{:<10}{:>9}{:>9}{:>10}{:>9}{:>9}{:>10}{:>10}  {}".format(*head), flush=True)
    for name, make in models.items():
        model, solver, state = make()
        made = program(model, solver, state=state, name="machine")
        with tempfile.TemporaryDirectory() as folder:
            binary = Path(folder) / "timing"
            build(flat_files(made, "timing.c"), platforms(["here"])[0], binary, flags=NO_ALLOCATION)
            plain = time_steps(made, binary, steps, urgent=False)
            fifo = time_steps(made, binary, steps, urgent=True)
        beside = in_python(model, solver, state), exudyn(name, solver.step)
        granted = "all" if all(x for _, x in fifo.granted) else "not all"
        print(
            f"{name:<10}{1e3 * solver.step:>9g}{plain.bytes:>9}{1e6 * plain.median:>10.1f}"
            f"{beside[0]:>9.1f}{beside[1]:>9.1f}{1e6 * plain.worst:>10.0f}"
            f"{1e6 * fifo.worst:>10.0f}  {granted}",
            flush=True,
        )
        for kind, x in (("ordinary", plain), ("SCHED_FIFO", fifo)):
            shares = ", ".join(
                f"{100 * s:g} % {1e6 * x.share(s):.1f}" for s in (0.5, 0.999, 0.9999)
            )
            print(f"  {kind}: {shares}, worst / median {x.worst / x.median:.0f}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000)
