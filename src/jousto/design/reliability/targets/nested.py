"""Nested reliability-based design: an analysis of each limit state at each trial design."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.design.reliability.errors import DesignPointError
from jousto.design.reliability.form import design_point
from jousto.design.reliability.targets.redesign import FAR, Redesign
from jousto.design.reliability.targets.sora import worst


def nested(
    problem: Redesign,
    d: Array,
    method: str,
    inner: str,
    cycles: int,
    rows: list[tuple[float, ...]],
) -> tuple[Array, list[Array | None]]:
    """Return the design of one optimisation with a reliability analysis at each trial design."""
    points: list[Array | None] = [None] * len(problem.names)
    known: dict[bytes, tuple[Array, Array]] = {}

    def both(e: Array) -> tuple[Array, Array]:
        key = e.tobytes()
        if key not in known:
            g, J = np.empty(len(points)), np.empty((len(points), len(e)))
            for i in range(len(points)):
                if method == "pma":
                    points[i], g[i], slope = worst(problem, e, i, inner, points[i])
                    J[i] = problem.slope_at(e, i, np.asarray(points[i]), slope)
                else:
                    g[i], J[i], points[i] = _index(problem, e, i, points[i])
            known.clear()
            known[key] = g, J
            rows.append((problem.cost_of(e), *e))
        return known[key]

    d = problem.optimum(d, (lambda e: both(e)[0], lambda e: both(e)[1]), cycles)
    return d, points


def far_index(problem: Redesign, d: Array, i: int) -> float:
    """Return plus or minus a large beta where FORM finds no design point."""
    space = problem.space_at(d, i)
    return FAR if space.g(np.zeros(space.n)) > 0.0 else -FAR


def _index(
    problem: Redesign, d: Array, i: int, near: Array | None
) -> tuple[float, Array, Array | None]:
    """Return index minus target, its derivatives by the design, and the design point."""
    target = float(problem.beta[i])
    for start in (near, None) if near is not None else (None,):
        space = problem.space_at(d, i)
        u = np.zeros(space.n) if start is None else start
        try:
            found = design_point(space, u, "sqp", 1e-6, 100, FAR)
        except DesignPointError as error:
            # no gradient at the start, since the limit state may fail anywhere
            if not error.history:
                raise
            continue
        slope = problem.slope_at(d, i, found.u, found.gradient)
        return found.beta - target, slope / np.linalg.norm(found.gradient), found.u
    # no failure or no safe point within reach
    return far_index(problem, d, i) - target, np.zeros(len(d)), None
