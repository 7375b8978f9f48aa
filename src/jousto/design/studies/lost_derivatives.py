"""Check of single derivatives that are too small for the check along one direction."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array

RELATIVE, FAR, WIDE = 6e-6, 1e-4, 1e-3
"""Steps relative to the length over which outcomes change: near the cube root of rounding, for
slopes, and for jumps and noise."""
WHOLE = 0.5
"""Relative step over which a whole number changes if it depends on the parameter."""
UNSEEN = 1e-2
"""Share of the directional derivative below which a 10 % error is not detected."""
AGREES = 1e-3
"""Relative difference of slopes up to which complex steps and differences agree."""
ROUNDING = 1e-14
"""Relative rounding error of an outcome: a sum of some hundred terms."""
ALIKE = 2.0
"""Ratio of two slopes up to which they count as equal; curvature and rounding reach 17."""
BISECTIONS = 12
JUMP = 0.02
"""Share of a change within 1/4096 of the step from which it counts as a jump."""
FAINT = 2e-4
"""Relative slope of an outcome below which rounding hides a tenth of it."""

Outcomes = Callable[[float], "Array | None"]
"""Function: outcomes (no,) at a distance along one parameter; None where they do not exist."""


def unresolved(jacobian: Array, sizes: Array, y: Array) -> NDArray[np.bool_]:
    """Return a mask (no, np) of derivatives that the direction check may not resolve.

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


def find_lost(
    at: Outcomes, y: Array, slopes: Array, rows: Iterable[int], size: float
) -> dict[int, tuple[str, bool]]:
    """Return the reason why derivatives by one parameter are wrong, and whether they are zero.

    The remainder ``y(x + h) - y(x) - h dy/dx`` shows a lost derivative if it is proportional to h,
    on one side or as half the difference of both, at two steps. Curvature and rounding are not
    proportional to h. An outcome that is constant nearby and jumps at a distance has no derivative.

    Parameters
    ----------
    at : callable
        Outcomes at a distance.
    y : (no,) array
        Outcomes at the point.
    slopes : (no,) array
        Derivatives of the outcomes by the parameter.
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
        left += [
            i for i in zero if not still or not all(_is_unchanged(end[i], y[i]) for end in still)
        ]
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
        if i in wrong and _is_proportional(rest(i), least[i]):
            found[i] = ("complex steps lose this derivative", False)
        elif i in zero and (jump := _find_jump(at, ends, i, y[i], size)):
            found[i] = (jump, True)
    return found


def _is_unchanged(a: float, y: float) -> bool:
    """Return whether an outcome is unchanged except for rounding."""
    return bool(abs(a - y) <= ROUNDING * abs(y))


def _is_proportional(rest: dict[float, float], least: float) -> bool:
    """Return whether the part of a change outside the derivative is proportional to the step."""
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


def _find_jump(at: Outcomes, ends: dict[float, Array | None], i: int, y: float, size: float) -> str:
    """Return the jump, further off, of an outcome that is constant nearby; empty if none."""
    for side in (1.0, -1.0):
        inner, outer = ends[side * RELATIVE], ends[side * WIDE]
        if (
            inner is None
            or outer is None
            or not _is_unchanged(inner[i], y)
            or _is_unchanged(outer[i], y)
        ):
            continue
        low, high, beyond = RELATIVE, WIDE, outer
        for _ in range(BISECTIONS):
            middle = 0.5 * (low + high)
            here = at(side * middle * size)
            if here is None:
                break
            if _is_unchanged(here[i], y):
                low = middle
            else:
                high, beyond = middle, here
        if abs(beyond[i] - y) > JUMP * abs(outer[i] - y):
            return f"it is constant here and jumps to {beyond[i]:.6g} at {side * high * size:+.3g}"
    return ""
