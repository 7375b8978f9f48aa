"""Speed side by side with EXUDYN: microseconds per step and the error that they buy.

make bench                                  all cases, about five minutes
.venv/bin/python benchmarks/speed.py quick  without the long chains
.venv/bin/python benchmarks/speed.py short  one beam alone: that everything runs, in seconds
"""

from __future__ import annotations

import os
import subprocess
import sys
import time
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

# one thread, also in the linear algebra around the engine
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import exudyn_peer
import jousto as jo
from cases import CHAINS, PENDULUMS, Case, beam, mechanism
from flops import Counter, scalar_peak

H = 1e-3
REPEATS = 7
ROOT = Path(__file__).parent.parent


def tips(model: jo.Model, case: Case, solver: Any) -> np.ndarray | None:
    """World position of the free end at the case's times (nt, 3), m; None if the run diverged."""
    try:
        run = jo.simulate(model, case.t_end, solver=solver, output_step=case.times[0])
    except jo.SimulationError:
        return None
    return np.asarray(run["tip"][1:])


def cost(model: jo.Model, solver: type[Any]) -> float:
    """Microseconds per step: the least of several runs, less what a run of one step takes.

    Processor time, so that it is not slowed by what else the machine does.
    """
    # the work of a step is fixed, so a model that diverges may use a small step
    for h in (H, H / 100.0):
        steps = max(400, 40_000 // len(model.bodies))

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


def error(tip: np.ndarray | None, reference: np.ndarray) -> float:
    """Largest distance to the reference, m."""
    return float("nan") if tip is None else float(np.linalg.norm(tip - reference, axis=1).max())


def show(value: float, form: str) -> str:
    return "diverged" if np.isnan(value) else format(value, form)


def compare(case: Case, counter: Counter) -> tuple[str, tuple[float, ...]]:
    """Line of the first table; operations and rate (1e9/s) of a step of RK4 and of ROS2."""
    reduced = beam(case.modes)
    model = jo.compile(mechanism(case, reduced))
    rk4, ros2 = cost(model, jo.RK4), cost(model, jo.ROS2)
    reference = tips(model, case, jo.RK4(step=H / 32))
    assert reference is not None
    ours = [error(tips(model, case, s(step=H)), reference) for s in (jo.RK4, jo.ROS2)]

    # the peer: its default full Newton and its modified Newton; the reference is its own
    fine = 16 if case.bodies <= 5 else 4
    repeats = {1: 7, 5: 3}.get(case.bodies, 1)
    modified = exudyn_peer.build(case, reduced, modified_newton=True)
    theirs = modified(H, case.t_end, repeats)
    full = exudyn_peer.build(case, reduced)(H, case.t_end, repeats)
    their_reference = modified(H / fine, case.t_end).tip
    # a second-order error at H / fine is this share of the one at H
    share = 1.0 - 1.0 / fine**2
    their_error = error(theirs.tip, their_reference) / share
    apart = error(their_reference, reference)

    first = (
        f"{case.name:32s} {rk4:8.2f} {ros2:8.2f} {full.microseconds:9.0f} "
        f"{theirs.microseconds:9.0f} {theirs.newton:6.1f} {theirs.microseconds / ros2:7.1f} "
        f"{theirs.microseconds / rk4:7.1f}   {show(ours[0], '8.1e'):>8s} {ours[1]:8.1e} "
        f"{their_error:8.1e} {apart:8.1e}"
    )
    return first, rates(model, counter, (rk4, ros2))


def rates(
    model: jo.Model, counter: Counter, microseconds: tuple[float, float]
) -> tuple[float, ...]:
    """Operations per step and their rate in 1e9/s, for RK4 and for ROS2."""
    found: list[float] = []
    for solver, cost_of_step in zip((jo.RK4(), jo.ROS2()), microseconds, strict=True):
        operations = counter.per_step(model, solver)
        found += [operations, operations / cost_of_step / 1e3]
    return tuple(found)


def energy_gained() -> str:
    """Why the codes differ with revolute joints: energy is made at the peer's markers."""
    case = next(c for c in CHAINS if c.bodies == 1)
    reduced = beam(case.modes)
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
        f"{case.name}: energy gained in {case.t_end:g} s, of {exchanged:.0f} J exchanged:\n"
        f"    EXUDYN {gained[0]}, {gained[1]}\n"
        f"    jousto {ours.energy.error[-1]:.2e} J (RK4, {1e3 * H / 8:g} ms)"
    )


def wall(command: list[str], repeats: int = 7) -> float:
    """Least wall time of a command, s."""

    def once() -> float:
        begin = time.perf_counter()
        subprocess.run(command, check=True, capture_output=True)
        return time.perf_counter() - begin

    return min(once() for _ in range(repeats))


def startup() -> list[str]:
    """Import and check times."""
    empty = wall([sys.executable, "-c", "pass"])
    imported = wall([sys.executable, "-c", "import jousto"])
    lines = [f"{'import jousto':32s} {imported - empty:6.3f} s (Python alone {empty:.3f} s)"]
    files = sorted((ROOT / "examples").rglob("*.yaml"))
    for file in files[:3]:
        taken = wall([sys.executable, "-m", "jousto", "check", str(file)])
        lines.append(f"{'jousto check ' + file.name:32s} {taken:6.3f} s, all included")
    return lines


def main(arguments: list[str]) -> None:
    warnings.simplefilter("ignore", jo.JoustoWarning)
    say: Callable[[str], None] = lambda line: print(line, flush=True)  # noqa: E731
    counter, peaks = Counter(), [scalar_peak()]
    short = "short" in arguments
    cases = [c for c in PENDULUMS + CHAINS if not arguments or c.bodies <= 5][
        : 1 if short else None
    ]
    say(f"one core; step {H * 1e3:g} ms")
    say("EXUDYN 1.13.6: generalised alpha, index 3, default tolerances; full and modified Newton")
    say("ratio: modified Newton against ROS2 and RK4")
    say("error: largest distance of the free end, m, from the same code at a fine step; the last")
    say("column is how far apart the two codes are at their fine steps")
    say("")
    say(
        f"{'':32s} {'jousto, us/step':>17s} {'EXUDYN, us/step':>19s} {'Newton':>6s} "
        f"{'ratio':>15s}   {'error, m':>26s}"
    )
    say(
        f"{'':32s} {'RK4':>8s} {'ROS2':>8s} {'full':>9s} {'modified':>9s} {'/step':>6s} "
        f"{'ROS2':>7s} {'RK4':>7s}   {'RK4':>8s} {'ROS2':>8s} {'EXUDYN':>8s} {'apart':>8s}"
    )
    table: list[tuple[str, tuple[float, ...]]] = []
    for case in cases:
        line, rate = compare(case, counter)
        say(line)
        table.append((case.name, rate))
        peaks.append(scalar_peak())
    large = Case("spherical", 1, 20 if short else 100)
    model = jo.compile(mechanism(large, beam(large.modes)))
    table.append((large.name, rates(model, counter, (cost(model, jo.RK4), cost(model, jo.ROS2)))))
    peak = max(peaks)
    say("")
    say(f"floating-point rate; peak of scalar fused multiply-adds on one core {peak:.2f} GFlop/s")
    head = f"{'kflop/st.':>9s} {'GFlop/s':>8s} {'of peak':>7s}"
    say(f"{'':32s} {'RK4':>26s}   {'ROS2':>26s}")
    say(f"{'':32s} {head}   {head}")
    for name, values in table:
        halves = [
            f"{values[i] / 1e3:9.1f} {values[i + 1]:8.2f} {values[i + 1] / peak:7.2f}"
            for i in (0, 2)
        ]
        say(f"{name:32s} {halves[0]}   {halves[1]}")
    say("")
    say(energy_gained())
    say("")
    for line in startup():
        say(line)


if __name__ == "__main__":
    main(sys.argv[1:])
