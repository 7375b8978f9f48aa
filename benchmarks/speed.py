"""Microseconds of a step, floating-point rate of the engine, and an energy balance.

.venv/bin/python benchmarks/speed.py        all cases
.venv/bin/python benchmarks/speed.py short  one beam alone: that everything runs, in seconds
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from collections.abc import Callable
from typing import Any

# one thread, also in the linear algebra around the engine
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import jousto as jo
from cases import CHAINS, PENDULUMS, Case, beam, mechanism
from flops import Counter, scalar_peak

H = 1e-3
REPEATS = 5


def cost(model: jo.Model, solver: type[Any]) -> float:
    """Microseconds per step: the least of several runs, less what a run of one step takes.

    Processor time, so that it is not slowed by what else the machine does.
    """
    # the work of a step is fixed, so a model that diverges may use a small step
    for h in (H, H / 100.0):
        steps = max(200, 20_000 // len(model.bodies))

        def once(count: int, h: float = h) -> float:
            begin = time.process_time()
            jo.simulate(model, count * h, solver=solver(step=h), output_step=count * h)
            return time.process_time() - begin

        try:
            long = min(once(steps) for _ in range(REPEATS))
            short = min(once(1) for _ in range(REPEATS))
            return 1e6 * (long - short) / (steps - 1)
        except jo.SimulationError:
            continue
    return float("nan")


def rates(
    model: jo.Model, counter: Counter, microseconds: tuple[float, float]
) -> tuple[float, ...]:
    """Operations per step and their rate in 1e9/s, for RK4 and for ROS2."""
    found: list[float] = []
    for solver, cost_of_step in zip((jo.RK4(), jo.ROS2()), microseconds, strict=True):
        operations = counter.per_step(model, solver)
        found += [operations, operations / cost_of_step / 1e3]
    return tuple(found)


def energy_gained(young: float) -> str:
    """Why the codes differ with revolute joints: energy is made at the peer's markers."""
    import exudyn_peer

    case = next(c for c in CHAINS if c.bodies == 1)
    reduced = beam(case.modes, young)
    model = jo.compile(mechanism(case, reduced))
    engine = jo.model.Engine(model)
    before = engine.energy().sum()
    peer = exudyn_peer.build(case, reduced, modified_newton=True)
    gained = []
    for h in (H, H / 8):
        run = peer(h, case.t_end)
        engine.q[:], engine.v[:] = run.q, run.v
        gained.append(f"{engine.energy().sum() - before:.2e} J at a step of {1e3 * h:g} ms")
    ours = jo.simulate(model, case.t_end, solver=jo.RK4(step=H / 8))
    exchanged = np.ptp(ours.energy.potential)
    return (
        f"{case.name}, E = {young:g} Pa, highest frequency {reduced.frequencies[-1]:.0f} Hz:\n"
        f"    energy gained in {case.t_end:g} s, of {exchanged:.0f} J exchanged:\n"
        f"    EXUDYN {gained[0]}, {gained[1]}\n"
        f"    jousto {ours.energy.error[-1]:.2e} J (RK4, {1e3 * H / 8:g} ms)"
    )


def main(arguments: list[str]) -> None:
    warnings.simplefilter("ignore", jo.JoustoWarning)
    say: Callable[[str], None] = lambda line: print(line, flush=True)  # noqa: E731
    counter, peaks = Counter(), [scalar_peak()]
    short = "short" in arguments
    cases = [*PENDULUMS, Case("spherical", 1, 100), *CHAINS][: 1 if short else None]
    table: list[tuple[str, tuple[float, float], tuple[float, ...]]] = []
    for case in cases:
        model = jo.compile(mechanism(case, beam(case.modes)))
        times = (cost(model, jo.RK4), cost(model, jo.ROS2))
        table.append((case.name, times, rates(model, counter, times)))
        peaks.append(scalar_peak())
    peak = max(peaks)
    say(f"peak of scalar fused multiply-adds on one core {peak:.2f} GFlop/s")
    head = f"{'us/step':>8s} {'kflop/st.':>9s} {'GFlop/s':>7s} {'of peak':>7s}"
    say(f"{'':32s} {'RK4':>34s}   {'ROS2':>34s}")
    say(f"{'':32s} {head}   {head}")
    for name, costs, values in table:
        halves = [
            f"{costs[k]:8.2f} {values[2 * k] / 1e3:9.1f} {values[2 * k + 1]:7.2f} "
            f"{values[2 * k + 1] / peak:7.2f}"
            for k in (0, 1)
        ]
        say(f"{name:32s} {halves[0]}   {halves[1]}")
    for young in (2.07e9,) if short else (2.07e9, 2.07e8):
        say("\n" + energy_gained(young))


if __name__ == "__main__":
    main(sys.argv[1:])
