"""Rigid arms on a flexible boom, condensed to their ports: microseconds of a step in both cores.

    .venv/bin/python benchmarks/ports.py [quick]

A boom of ten modes on a hinge carries a chain of hinged rigid links. One step of classical
Runge-Kutta and one of ROS2; the cores take turns in one run, least of many, processor time. The
boom alone says what remains of a step that the links cost nothing in. Printed as it stands in
docs/benchmarks-trees.md.
"""

from __future__ import annotations

import sys
import time
from typing import Any

import numpy as np

import jousto as jo
from cases import GRAVITY, LENGTH, beam
from jousto.model.native.native import Engine
from machines import CENTER, INERTIA, MASS

STEP, STEPS = 1e-4, 400
Y, Z = (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def machine(count: int, modes: int = 10) -> jo.Mechanism:
    boom = jo.FlexibleBody("boom", beam(modes))
    items: list[Any] = [boom, jo.Revolute("foot", jo.ground.at((0, 0, 0)), boom["start"], Y)]
    before: Any = boom["end"]
    for k in range(count):
        link = jo.RigidBody(
            f"link{k}", MASS, INERTIA, center=CENTER, position=(LENGTH * (k + 1), 0, 0)
        )
        items += [link, jo.Revolute(f"pin{k}", before, link.at((0, 0, 0)), Y if k % 2 else Z)]
        before = link.at((LENGTH, 0, 0))
    return jo.Mechanism(*items, jo.Gravity(GRAVITY))


def costs(models: list[Any], method: str, rounds: int) -> list[float]:
    """Microseconds of a step of each model."""
    engines = [Engine(model) for model in models]
    solvers = [engine.native_solver(method, STEP, True) for engine in engines]
    rows = [np.zeros((1, engine.row_size)) for engine in engines]
    best = [np.inf] * len(models)
    for _ in range(rounds):
        for i, (engine, model) in enumerate(zip(engines, models, strict=True)):
            engine.q[:], engine.v[:], engine.time[0] = model.q0, model.v0, 0.0
            start = time.process_time()
            engine.run(solvers[i], STEPS, 10**9, rows[i])
            best[i] = min(best[i], time.process_time() - start)
    return [1e6 * x / STEPS for x in best]


def main() -> None:
    short = "short" in sys.argv
    rounds = 2 if short else 20 if "quick" in sys.argv else 100
    boom = jo.compile(machine(0))
    print("| rigid links | method | joint | maximal | ratio | boom alone |")
    print("|---|---|---|---|---|---|")
    for count in (2, 3, 6, 10, 20)[: 1 if short else None]:
        pair = [jo.compile(machine(count), core=core) for core in ("joint", "maximal")]
        for method, name in (("rk4", "RK4"), ("ros2", "ROS2")):
            joint, maximal, alone = costs([*pair, boom], method, rounds)
            print(
                f"| {count} | {name} | {joint:.1f} | {maximal:.1f} | {maximal / joint:.2f} "
                f"| {alone:.1f} |"
            )


if __name__ == "__main__":
    main()
