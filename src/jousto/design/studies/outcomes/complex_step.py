"""Directional derivatives of real-valued outcomes of a run."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from jousto.base.complexstep import STEP, plainly, stepped
from jousto.design.studies.case import Case
from jousto.simulation.results.memory import displaced_results
from jousto.simulation.results.solution import Solution

SHARE = 1e-5
"""Relative change of the parameter in `directional`: small, so that cycles stay the same."""


def has_slope(run: Solution) -> bool:
    """Return whether the results of a run have derivatives."""
    return stepped(getattr(run._records, "rows", None))


def directional(case: Case, judge: Callable[[Solution, float], float]) -> float:
    """Return a real-valued outcome of a run, with its derivative along that of the motion.

    Fourth-order differences of `judge` between results that are shifted along their derivatives:
    evaluation after a run needs real numbers, and is smooth as long as places, instants and cycles
    stay the same.

    Parameters
    ----------
    case : Case
        Case with a parameter that has a derivative.
    judge : callable
        Function of results and parameter change; it may change numbers of its own along with the
        latter.
    """
    run, size = case.run, SHARE * case.reach
    case.followed = True
    moves = has_slope(run)

    def at(change: float) -> float:
        return judge(displaced_results(run, change) if moves else run, change)

    with plainly():
        found = [at(k * size) for k in (1, -1, 2, -2)]
        value = at(0.0)
    slope = (8.0 * (found[0] - found[1]) - (found[2] - found[3])) / (12.0 * size)
    made: Any = value + 1j * STEP * slope
    return made  # type: ignore[no-any-return]
