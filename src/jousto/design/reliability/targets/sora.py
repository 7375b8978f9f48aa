"""Sequential optimisation and reliability assessment (SORA)."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import count
from jousto.design.reliability.errors import DesignPointError
from jousto.design.reliability.pma import performance
from jousto.design.reliability.targets.redesign import STEPS, WHERE, Redesign


def sora(
    problem: Redesign,
    d: Array,
    inner: str,
    tolerance: float,
    cycles: int,
    rows: list[tuple[float, ...]],
) -> tuple[Array, list[Array | None]]:
    """Return the design of alternating optimisations and searches for most probable points."""
    points: list[Array | None] = [None] * len(problem.names)
    for _ in range(cycles):
        points = [worst(problem, d, i, inner, points[i])[0] for i in range(len(points))]
        new = problem.optimum(d, problem.shifted(points), STEPS)
        rows.append((problem.cost_of(new), *new))
        moved = float(np.max(np.abs(new - d) / problem.scale))
        d = new
        if moved <= tolerance:
            return d, points
    message = f"{WHERE}: the design still moves by {moved:.2g} after {count(cycles, 'cycle')}"
    raise DesignPointError(message, d, rows)


def worst(
    problem: Redesign, d: Array, i: int, inner: str, near: Array | None
) -> tuple[Array, float, Array]:
    """Return the most probable point of a limit state on its sphere, its value and gradient."""
    space = problem.space_at(d, i)
    u = np.zeros(space.n) if near is None else near
    found = performance(space, u, float(problem.beta[i]), inner, 1e-6, 100)
    return found.u, found.value, found.gradient
