"""What a run costs besides its steps, side by side with EXUDYN.

.venv/bin/python benchmarks/overhead.py         a minute, part of `make bench`
.venv/bin/python benchmarks/overhead.py quick   without the chain of 1000
.venv/bin/python benchmarks/overhead.py short   without that of 100 either
"""

from __future__ import annotations

import os
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from pathlib import Path

# one thread, also in the linear algebra around the engine
os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import jousto as jo
from cases import PENDULUMS, beam, mechanism
from machines import RIGID_CHAINS, RigidChain, rigid_chain

try:
    import exudyn_machines as peer
except ImportError:  # then jousto alone
    peer = None

H = 1e-3  # s
STEPS = 11


def least(once: Callable[[], object], seconds: float = 1.0) -> float:
    """Least processor time in s of many calls, after one that is not counted."""
    once()
    best, begin, count = float("inf"), time.monotonic(), 0
    while count < 5 or time.monotonic() - begin < seconds:
        start = time.process_time()
        once()
        best = min(best, time.process_time() - start)
        count += 1
    return best


def fixed(run: Callable[[int], object]) -> float:
    """Milliseconds of a run with no steps, from runs of one step and of more."""
    one, more = least(lambda: run(1)), least(lambda: run(STEPS))
    return 1e3 * (one - (more - one) / (STEPS - 1))


def ours(model: jo.Model, path: Path | None = None) -> Callable[[int], object]:
    solver = jo.ROS2(step=H)  # the settings of EXUDYN are made once, too

    def run(steps: int) -> object:
        end = steps * H
        return jo.simulate(model, end, solver=solver, output_step=end, path=path)

    return run


def theirs(case: RigidChain) -> Callable[[int], object]:
    """EXUDYN's generalised alpha, which its runs of rigid chains use, nothing written."""
    mbs, _ = peer.rigid_chain(case)
    mbs.Assemble()
    settings = peer.exu.SimulationSettings()
    settings.timeIntegration.verboseMode = 0
    settings.timeIntegration.newton.useModifiedNewton = True
    settings.solutionSettings.writeSolutionToFile = False
    settings.parallel.numberOfThreads = 1
    kinds = peer.exu.LinearSolverType
    settings.linearSolverType = kinds.EigenDense if case.bodies < 20 else kinds.EigenSparse

    def run(steps: int) -> object:
        settings.timeIntegration.numberOfSteps = steps
        settings.timeIntegration.endTime = steps * H
        settings.solutionSettings.sensorsWritePeriod = steps * H
        return mbs.SolveDynamic(settings)

    return run


def main() -> None:
    warnings.simplefilter("ignore")
    most = 10 if "short" in sys.argv[1:] else 100 if "quick" in sys.argv[1:] else 1000
    print("fixed cost of a run, ms of processor time, least of many; compiled model given")
    print(f"{'':32s} {'memory':>9s} {'file':>9s} {'EXUDYN':>9s} {'ratio':>7s}")
    pendulum = PENDULUMS[0]
    models = [(pendulum.name, jo.compile(mechanism(pendulum, beam(pendulum.modes))), None)]
    for case in (RigidChain("spherical", 1, 1.0), *RIGID_CHAINS):
        if case.joint == "spherical" and case.bodies <= most:
            models.append((case.name, jo.compile(rigid_chain(case)), case))
    with tempfile.TemporaryDirectory() as folder:
        for name, model, rigid in models:
            kept, written = fixed(ours(model)), fixed(ours(model, Path(folder) / "run.h5"))
            line = f"{name:32s} {kept:9.2f} {written:9.1f}"
            if peer is not None and rigid is not None:
                other = fixed(theirs(rigid))
                line += f" {other:9.2f} {other / kept:7.2f}"
            print(line, flush=True)


if __name__ == "__main__":
    main()
