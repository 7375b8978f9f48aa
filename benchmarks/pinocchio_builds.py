"""Accelerations of trees by jousto and Pinocchio, built for any processor and for this one.

.venv/bin/python benchmarks/pinocchio_builds.py [short]

jousto: a quarter of a Runge-Kutta step in joint coordinates, which contains four evaluations and
little else. Pinocchio: `aba`, of its package in a loop of its own in C++, and compiled here from
the headers of the package with the flags of the engine. Processor time, least of several runs.
"""

from __future__ import annotations

import os
import sys

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import jousto as jo
import pinocchio_native
import trees
from builds import use

STEP = 1e-4  # s


def main(short: bool) -> None:
    """Print the table."""
    pinocchio_native.may_compile = not short
    machines = {"six-axis arm": trees.arm()}
    machines |= {f"revolute chain of {n}": trees.chain("hinge", n) for n in (10, 100)}
    repeats = 1 if short else 7
    print("| us an evaluation | jousto, any x86-64 | Pinocchio's package | ratio ", end="")
    print("| jousto, AVX2 | Pinocchio, AVX2 | ratio |\n|---|---|---|---|---|---|---|")
    for name, links in machines.items():
        own = {}
        for build in ("baseline", "v3"):
            use(build)
            own[build] = trees.ours(jo.compile(trees.mechanism(links)), "rk4", repeats) / 4
        package = trees.pinocchio(links, repeats)[0] / 4
        count = 20 if short else max(100, 20_000 // len(links))
        cells = [f"{own['baseline']:.3g}", f"{package:.3g}", f"{package / own['baseline']:.1f}"]
        cells.append(f"{own['v3']:.3g}")
        try:
            here = pinocchio_native.steps(links, STEP, count, count, repeats).evaluation
            cells += [f"{here:.3g}", f"{here / own['v3']:.1f}"]
        except ImportError as error:
            cells += [str(error), ""]
        print(f"| {name} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main("short" in sys.argv[1:])
