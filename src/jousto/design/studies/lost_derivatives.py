"""Derivatives that a check along one direction cannot see, each checked alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array

RELATIVE, FAR, WIDE = 6e-6, 1e-4, 1e-3
"""Steps as shares of the length over which outcomes change: about the cube root of the rounding,
another for slopes, and one for jumps and noise."""
WHOLE = 0.5
"""Step, as the same share, over which a whole number changes if it depends on the parameter."""
UNSEEN = 1e-2
"""Share of a checked direction below which an error of the tenth part stays unseen."""
AGREES = 1e-3
"""Of a slope: complex steps that agree with differences, whose noise is smaller."""
ROUNDING = 1e-14
"""Of an outcome: rounding of a sum of some hundred terms."""
ALIKE = 2.0
"""Ratio of two slopes up to which they are one slope; curvature and rounding give 17 and more."""
BISECTIONS = 12
JUMP = 0.02
"""Share of a change over a step that makes it a jump if it happens in 1/4096 of the step."""
FAINT = 2e-4
"""Part of an outcome, over that length, below which its rounding hides a tenth of the change."""

Outcomes = Callable[[float], "Array | None"]
"""Outcomes (no,) at a distance along one parameter; None where there are none."""


def unseen(jacobian: Array, sizes: Array, y: Array) -> NDArray[np.bool_]:
    """Return the derivatives (no, np) whose loss a check along one direction may not see.

    Parameters
    ----------
    jacobian : (no, np) array
        Derivatives.
    sizes : (np,) array
        Lengths over which outcomes change.
    y : (no,) array
        Outcomes.
    """
    terms = np.abs(jacobian) * sizes
    hidden = UNSEEN * np.nansum(terms, axis=1) + FAINT * np.abs(y)
    return np.asarray(terms <= hidden[:, None])


def lost(
    at: Outcomes, y: Array, slopes: Array, rows: Iterable[int], size: float
) -> dict[int, tuple[str, bool]]:
    """Return why derivatives by one parameter are wrong, and whether there is none at all.

    ``y(x + h) - y(x) - h dy/dx`` is no part of dy/dx if it grows with h: on one side, or half the
    difference of both, at two steps. Curvature and rounding grow otherwise. What is constant close
    by and jumps farther away has no derivative.

    Parameters
    ----------
    at : callable
        Outcomes at a distance.
    y : (no,) array
        Outcomes at the point.
    slopes : (no,) array
        Their derivatives.
    rows : iterable of int
        Outcomes to check.
    size : float
        Length along the parameter over which outcomes change.
    """
    zero = [i for i in rows if slopes[i] == 0.0]
    left, ends = [i for i in rows if slopes[i] != 0.0], dict[float, Array | None]()
    if zero:
        ends |= {h: at(h * size) for h in (WIDE, -WIDE)}
        still = [end for end in ends.values() if end is not None]
        left += [i for i in zero if not still or not all(_same(end[i], y[i]) for end in still)]
    if left:
        ends |= {h: at(h * size) for h in (RELATIVE, -RELATIVE)}

    def rest(i: int) -> dict[float, float]:
        return {
            h: end[i] - y[i] - h * size * slopes[i] for h, end in ends.items() if end is not None
        }

    least = ROUNDING * np.abs(y) + AGREES * RELATIVE * size * np.abs(slopes)
    wrong = [
        i for i in left if any(abs(rest(i).get(h, 0.0)) > least[i] for h in (RELATIVE, -RELATIVE))
    ]
    if wrong:
        ends |= {h: at(h * size) for h in (FAR, -FAR)}
    found: dict[int, tuple[str, bool]] = {}
    for i in left:
        if i in wrong and _grows(rest(i), least[i]):
            found[i] = ("complex steps lose this derivative", False)
        elif i in zero and (jump := _jump(at, ends, i, y[i], size)):
            found[i] = (jump, True)
    return found


def _same(a: float, y: float) -> bool:
    """Return whether an outcome has not changed, but for its rounding."""
    return bool(abs(a - y) <= ROUNDING * abs(y))


def _grows(rest: dict[float, float], least: float) -> bool:
    """Return whether what a derivative leaves of a change is proportional to the step."""
    sides = [{h: rest[s * h] for h in (RELATIVE, FAR) if s * h in rest} for s in (1.0, -1.0)]
    if all(len(side) == 2 for side in sides):
        sides.append({h: 0.5 * (rest[h] - rest[-h]) for h in (RELATIVE, FAR)})
    for side in sides:
        if len(side) < 2 or abs(side[RELATIVE]) <= least:
            continue
        ratio = side[FAR] / FAR / (side[RELATIVE] / RELATIVE)
        if 1.0 / ALIKE <= ratio <= ALIKE:
            return True
    return False


def _jump(at: Outcomes, ends: dict[float, Array | None], i: int, y: float, size: float) -> str:
    """Return what an outcome that is constant close by does farther away, if it jumps there."""
    for side in (1.0, -1.0):
        inner, outer = ends[side * RELATIVE], ends[side * WIDE]
        if inner is None or outer is None or not _same(inner[i], y) or _same(outer[i], y):
            continue
        low, high, beyond = RELATIVE, WIDE, outer
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            here = at(side * middle * size)
            if here is None:
                break
            if _same(here[i], y):
                low = middle
            else:
                high, beyond = middle, here
        if abs(beyond[i] - y) > JUMP * abs(outer[i] - y):
            return f"it is constant here and jumps to {beyond[i]:.6g} at {side * high * size:+.3g}"
    return ""
