"""Loops of rigid bodies in both cores: microseconds of a step, and how far results are apart.

    .venv/bin/python benchmarks/loops.py [quick | short]

One step of classical Runge-Kutta, whose four evaluations and the closing of the loops are all it
costs. Both cores take turns in one run; the least of many is given.
"""

from __future__ import annotations

import sys
import time
import warnings
from typing import Any

import numpy as np

import jousto as jo
from jousto.model.native.native import Engine

STEP = 1e-4
Z = (0.0, 0.0, 1.0)


def body(name: str, at: Any = (0.0, 0.0, 0.0)) -> Any:
    return jo.RigidBody(name, 1.0, (0.02, 0.03, 0.04), center=(0.1, 0, 0), position=at)


def four_bar(spatial: bool = False) -> Any:
    lift = 1.0 if spatial else 0.0
    at = np.array([[0, 0, 0], [0, 1, 0.2 * lift], [2, 1.5, 0.5 * lift], [2, 0, 0]], float)
    a, b, c = (body(name) for name in "abc")
    first = jo.Revolute("one", jo.ground.at(at[0]), a.at(at[0]), axis=Z)
    ends = [(a.at(at[1]), b.at(at[1])), (b.at(at[2]), c.at(at[2]))]
    if spatial:
        middle = [
            jo.Spherical("two", *ends[0]),
            jo.Universal("three", *ends[1], axis_a=Z, axis_b=(0, 1, 0)),
        ]
    else:
        middle = [
            jo.Revolute(name, *pair, axis=Z)
            for name, pair in zip(("two", "three"), ends, strict=True)
        ]
    axis = (0, 1, 0) if spatial else Z
    last = jo.Revolute("four", c.at(at[3]), jo.ground.at(at[3]), axis=axis)
    return jo.Mechanism(a, b, c, first, *middle, last, jo.Gravity((0, -9.81, 0)))


def slider_crank() -> Any:
    a, b, c = (body(name) for name in "abc")
    at = [(0, 0, 0), (0.6, 0.8, 0), (2.6, 0, 0)]
    pins = [
        jo.Revolute(f"pin{i}", one.at(at[i]), other.at(at[i]), axis=Z)
        for i, (one, other) in enumerate(((jo.ground, a), (a, b), (b, c)))
    ]
    guide = jo.Prismatic("guide", jo.ground.at(at[2]), c.at(at[2]), axis=(1, 0, 0))
    return jo.Mechanism(a, b, c, *pins, guide, jo.Gravity((0, -9.81, 0)))


def stewart() -> Any:
    """A plate on six legs of a universal, a prismatic and a spherical joint."""
    plate = body("plate", (0, 0, 1))
    items: list[Any] = [plate]
    for i in range(6):
        angle, over = np.pi / 3 * (i // 2 * 2) + 0.3 * (-1) ** i, np.pi / 3 * ((i + 1) // 2 * 2 - 1)
        over += 0.2 * (-1) ** i
        foot = np.array([1.2 * np.cos(angle), 1.2 * np.sin(angle), 0.0])
        head = np.array([0.7 * np.cos(over), 0.7 * np.sin(over), 1.0])
        along = head - foot
        across = np.cross(along, (0.3, 0.2, 1.0))
        turned = np.cross(along, across)
        lower, upper, ground = body(f"lower{i}", foot), body(f"upper{i}", head), jo.ground.at(foot)
        items += [
            *(lower, upper),
            jo.Universal(f"foot{i}", ground, lower.at((0, 0, 0)), axis_a=across, axis_b=turned),
            jo.Prismatic(f"leg{i}", lower.at(along), upper.at((0, 0, 0)), axis=along),
            jo.Spherical(f"head{i}", upper.at((0, 0, 0)), plate.at(head - (0, 0, 1))),
        ]
    return jo.Mechanism(*items, jo.Gravity((0, 0, -9.81)))


def compared(mechanism: Any, repeats: int) -> tuple[float, float, float]:
    """Microseconds of a step in both cores, and the largest difference of the results."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        models = [jo.compile(mechanism, core=core) for core in ("joint", "maximal")]
    engines = [Engine(model) for model in models]
    best, steps = [np.inf, np.inf], 300
    for _ in range(repeats):
        for i, engine in enumerate(engines):
            solver = engine.native_solver("rk4", STEP, True)
            engine.steps_done = 0
            begin = time.process_time()
            engine.run(solver, steps, steps, np.zeros((2, engine.row_size)))
            best[i] = min(best[i], (time.process_time() - begin) / steps)
    return 1e6 * best[0], 1e6 * best[1], float(np.abs(engines[0].q - engines[1].q).max())


def main() -> None:
    repeats = 1 if "short" in sys.argv else 4 if "quick" in sys.argv else 20
    print(f"{'machine':22s}   joint maximal   ratio   apart")
    machines = {
        "planar four-bar": four_bar(),
        "slider-crank": slider_crank(),
        "spatial four-bar": four_bar(spatial=True),
        "Stewart platform": stewart(),
    }
    for name, mechanism in machines.items():
        joint, maximal, apart = compared(mechanism, repeats)
        print(f"{name:22s} {joint:7.2f} {maximal:7.2f} {maximal / joint:7.2f} {apart:7.1e}")


if __name__ == "__main__":
    main()
