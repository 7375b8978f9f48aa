"""Speed of each build of the engine (baseline, v3, ...) that this processor runs, side by side.

.venv/bin/python benchmarks/builds.py

Runs of the builds take turns, each figure is the least processor time of many, so that what else
the machine does falls on all of them alike.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable

os.environ["OMP_NUM_THREADS"] = os.environ["OPENBLAS_NUM_THREADS"] = "1"

import numpy as np

import jousto as jo
from cases import PENDULUMS, Case, beam, mechanism
from jousto.model.native import library
from jousto.reduction.fields.stress import StressModes
from machines import RIGID_CHAINS, four_bar, rigid_chain, slider_crank

ROUNDS = 10


def use(build: str) -> None:
    """Let what is made and run from now on use this build."""
    os.environ["JOUSTO_CPU"] = build
    library.real_library.cache_clear()


def stepping(declared: jo.Mechanism, solver: jo.Solver, steps: int) -> Callable[[], object]:
    """Return a run of so many steps in the build that is in use."""
    model = jo.compile(declared)
    end = steps * solver.step  # type: ignore[attr-defined]
    return lambda: jo.simulate(model, end, solver=solver, output_step=end)


def strip() -> jo.Mechanism:
    """Return a strip of spring steel on a hinge."""
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
    body = jo.BeamBody(
        "strip", [[0, 0, 0], [1.0, 0, 0]], jo.Rectangle(0.01, 0.01), steel, elements=100
    )
    hinge = jo.Spherical("hinge", jo.ground["origin"], body["start"])
    return jo.Mechanism(body, hinge, jo.Gravity((0.0, 0.0, -9.81)))


def frames() -> Callable[[], object]:
    """Return the envelope of von Mises stress of 20,000 places at 50 instants."""
    rng = np.random.default_rng(1)
    ns, nt, n = 20_000, 50, 20
    eye = np.broadcast_to(np.eye(3), (ns, 3, 3))
    modes = StressModes(
        tuple(f"n{i}" for i in range(ns)), np.zeros((ns, 3)), eye, rng.standard_normal((ns, 6, n))
    )
    field = jo.recovery.field_from(modes, rng.standard_normal((nt, n)), np.arange(nt, dtype=float))
    return lambda: field.envelope("von-mises")


def cases() -> dict[str, Callable[[], Callable[[], object]]]:
    """Return the name of each case and what makes it in the build that is in use."""
    h, chain = 1e-3, Case("revolute", 20, 10)
    table: dict[str, Callable[[], Callable[[], object]]] = {}
    for case in PENDULUMS:
        declared = mechanism(case, beam(case.modes))
        table[f"pendulum of {case.modes} modes, RK4"] = lambda d=declared: stepping(
            d, jo.RK4(step=h / 10), 20000
        )
    long = mechanism(chain, beam(10))
    table["20 flexible links, ROS2"] = lambda: stepping(long, jo.ROS2(step=h / 10), 3000)
    table["20 flexible links, generalised alpha"] = lambda: stepping(
        long, jo.GeneralizedAlpha(step=h / 10), 300
    )
    table["slider-crank, flexible, RK4"] = lambda: stepping(
        slider_crank(), jo.RK4(step=h / 10), 10000
    )
    table["four-bar, flexible, ROS2"] = lambda: stepping(four_bar(), jo.ROS2(step=h / 10), 10000)
    rigid = next(case for case in RIGID_CHAINS if case.bodies == 100 and case.joint == "revolute")
    table["100 rigid links, ROS2"] = lambda: stepping(
        rigid_chain(rigid), jo.ROS2(step=h / 10), 1000
    )
    table["100 exact beam elements, generalised alpha"] = lambda: stepping(
        strip(), jo.GeneralizedAlpha(step=h), 500
    )
    table["von Mises of 20,000 places"] = frames
    return table


def main() -> None:
    """Measure and print."""
    builds = [name for name in reversed(library.BUILDS) if library._runs(name)]
    print(f"{'processor time, ms':45s}" + "".join(f"{build:>12s}" for build in builds))
    for name, make in cases().items():
        works = {}
        for build in builds:
            use(build)
            works[build] = make()
        least = dict.fromkeys(builds, np.inf)
        for _ in range(ROUNDS):
            for build, work in works.items():
                use(build)
                start = time.process_time()
                work()
                least[build] = min(least[build], time.process_time() - start)
        print(f"{name:45s}" + "".join(f"{1e3 * least[build]:12.2f}" for build in builds), end="")
        print("   " + ", ".join(f"{least[builds[0]] / least[b]:.2f}" for b in builds[1:]))


if __name__ == "__main__":
    main()
