"""Runs of machines of equal structure, computed together in the vector lanes of the engine."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from typing import Any

import numpy as np

from jousto.model.native.ensemble import Ensemble, machines
from jousto.simulation.results.events import Chronicle
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.repeated_runs import Repeated

Run = tuple[Repeated, dict[str, float]]


def run_in_lanes(runs: Sequence[Run]) -> list[Solution | None]:
    """Return the results of runs computed in vector lanes; None for each run left to the caller.

    Machines of equal structure with the same method, step and end share the lanes of a vector.
    Their results equal those of `Repeated.run` to round-off. Runs that fail, and groups of too few
    runs of the same structure, are left to the caller.

    Parameters
    ----------
    runs : sequence of (Repeated, dict)
        Runs, each with the values of its inputs.
    """
    found: list[Solution | None] = [None] * len(runs)
    width = machines()
    if width == 1:
        return found
    groups: dict[Any, list[int]] = {}
    for i, (repeated, _) in enumerate(runs):
        if repeated.alike is not None:
            groups.setdefault(repeated.alike, []).append(i)
    for places in groups.values():
        for k in range(0, len(places), width):
            part = places[k : k + width]
            if len(part) <= width // 2:
                continue  # an unused lane costs as much as a used one
            for i, solution in zip(part, _side_by_side([runs[i] for i in part]), strict=True):
                found[i] = solution
    return found


def _side_by_side(runs: Sequence[Run]) -> list[Solution | None]:
    """Return the results of runs, one run per lane; spare lanes repeat the last run."""
    started = [repeated.begin(inputs) for repeated, inputs in runs]
    engines = [engine for engine, _, _ in started]
    lanes = Ensemble([*engines, *engines[-1:] * (machines() - len(engines))])
    plan, native = runs[0][0].plan, started[0][1]
    begin = clock.perf_counter()
    rows = np.concatenate([lanes.row()[:, None], lanes.run(native, plan.steps, plan.every)], axis=1)
    wall = (clock.perf_counter() - begin) / len(runs)
    return [
        repeated.finish(own, rows[k], wall, Chronicle(own[0]))
        if np.isfinite(rows[k, -1]).all()
        else None
        for k, ((repeated, _), own) in enumerate(zip(runs, started, strict=True))
    ]
