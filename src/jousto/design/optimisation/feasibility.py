"""Search for a design within all limits, and the conflicting limits if there is none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize, nnls

from jousto.base.arrays import Array
from jousto.design.optimisation import loads as esl
from jousto.design.optimisation.optimum import ACTIVE
from jousto.design.optimisation.problem import Kept, Problem
from jousto.design.optimisation.slopes import differences

ROUNDS, STEP = 10, 1e-5
"""Maximum number of searches, and the step at which they end, as a share of the bounds' spans."""
WEIGHT = 1e-3
"""Share of the largest multiplier below which a limit is no part of a conflict."""


@dataclass(frozen=True, eq=False)
class Nearest:
    """Design with the smallest violation of its limits.

    Parameters
    ----------
    x : (nd,) array
    ratio : float
        Largest ratio of value to limit at this design.
    conflict : tuple of str
        Conflicting limits at this design, and parameters whose bounds are active.
    """

    x: Array
    ratio: float
    conflict: tuple[str, ...]

    @property
    def message(self) -> str:
        """Return the sentence that explains the conflict and its remedy."""
        if self.ratio <= 1.0 + ACTIVE:
            return "; a design that meets all limits is near, start there: "
        return (
            "; no design within the bounds meets the limits: the nearest exceeds them by "
            f"{self.ratio - 1.0:.3g} of their size, where these conflict: "
            + ", ".join(self.conflict)
        )


def nearest(problem: Problem, x: Array, screen: float, size: float) -> Nearest:
    """Return the design that minimises the largest ratio: ``min t``, ``r_i <= t``.

    Solved by SLSQP with derivatives from runs. At the solution, ``sum m_i grad r_i`` is zero except
    along active bounds, with ``m >= 0`` and ``sum m_i = 1``: limits with m above 0 conflict.
    """
    span = problem.high - problem.low
    for _ in range(ROUNDS):
        kept = esl.screened(esl.table_of(problem, x), screen)
        new = _lowered(problem, x, kept, size)
        moved = float(np.max(np.abs(new - x) / span))
        x = new
        if moved <= STEP:
            break
    table = esl.table_of(problem, x)
    kept = esl.screened(table, screen)
    ratios = esl.ratios_of(problem, x, kept)
    names = esl.labels(problem, x, kept)
    worst = float(ratios.max())
    near = np.flatnonzero(ratios >= worst * (1.0 - ACTIVE))
    slopes = differences(problem, lambda y: esl.ratios_of(problem, y, kept), x, size)[near] * span
    low, high = x <= problem.low + 1e-9 * span, x >= problem.high - 1e-9 * span
    unit = np.eye(len(x))
    scale = np.abs(slopes).max(initial=0.0) or 1.0
    columns = np.vstack([slopes / scale, -unit[low], unit[high]]).T
    sums = np.concatenate([np.ones(len(near)), np.zeros(columns.shape[1] - len(near))])
    m, _ = nnls(np.vstack([columns, sums]), np.append(np.zeros(len(x)), 1.0))
    least = WEIGHT * m.max(initial=0.0)
    found = [names[row].limit for row, weight in zip(near, m, strict=False) if weight > least]
    bounds = [f"{problem.names[i]} at its lower bound" for i in np.flatnonzero(low)]
    bounds += [f"{problem.names[i]} at its upper bound" for i in np.flatnonzero(high)]
    held = [b for b, weight in zip(bounds, m[len(near) :], strict=True) if weight > least]
    return Nearest(x, worst, tuple(dict.fromkeys([*found, *held])))


def _lowered(problem: Problem, x: Array, kept: list[Kept], size: float) -> Array:
    """Return the design that minimises the largest ratio of the selected rows."""
    span = problem.high - problem.low

    def design(w: Array) -> Array:
        return np.asarray(np.clip(problem.low + w[:-1] * span, problem.low, problem.high))

    def room(w: Array) -> Array:
        return np.asarray(w[-1] - esl.ratios_of(problem, design(w), kept))

    def slopes(w: Array) -> Array:
        found = differences(problem, lambda y: esl.ratios_of(problem, y, kept), design(w), size)
        return np.hstack([-found * span, np.ones((len(found), 1))])

    start = np.append((x - problem.low) / span, esl.ratios_of(problem, x, kept).max())
    only = np.append(np.zeros(len(x)), 1.0)
    found: Any = minimize(  # type: ignore[call-overload]
        lambda w: float(w[-1]),
        start,
        jac=lambda w: only,
        bounds=[*[(0.0, 1.0)] * len(x), (0.0, None)],
        method="SLSQP",
        options={"ftol": 1e-8, "maxiter": 40},
        constraints={"type": "ineq", "fun": room, "jac": slopes},
    )
    return design(found.x)
