"""Further design points of a limit state: a search from which those that are known are excluded."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.linalg import null_space
from scipy.special import ndtr

from jousto.base.arrays import Array
from jousto.design.reliability.errors import DesignPointError, LimitStateError
from jousto.design.reliability.form import FAR, FormResult, design_point, slope_at
from jousto.design.reliability.inputs.space import Space

RADIUS, HEIGHT = 1.1, 0.75
"""Of a bulge, in distances of its point from the origin; where it raises G by that of the origin,
in distances of the point. Both are those of Der Kiureghian and Dakessian."""
MOST = 8
"""Further points that are looked for."""
COUNTS = 1e-3
"""Probability of a point, of the first one, below which it does not matter."""
NEAR = 0.8
"""As the radius, where the limit state lies below all tangents: planes 50 degrees apart."""
BELOW = 0.1
"""Of the limit state at the origin, by which it lies below all known tangents where a search is
worth its calls."""
APART = 0.5
"""Distance of two points, in standard deviations, below which they are one."""
TOLERANCE, STEPS = 1e-4, 30
"""Of a search, whose point is only where samples are drawn around."""


class Excluding(Space):
    """A limit state with a bulge of safety around each known design point.

    ``g(u) + sum s (r^2 - |u - u*|^2)^2`` within r of u*; then the nearest failure is elsewhere (A.
    Der Kiureghian and T. Dakessian, *Struct. Saf.* 20 (1998) 37-49).

    Parameters
    ----------
    space : Space
        The limit state; its calls are counted there.
    known : sequence of FormResult
        The points.
    """

    def __init__(self, space: Space, known: Sequence[FormResult]) -> None:
        super().__init__(space.limit, space.variables, space.fixed, space.counted)
        self._bulges: list[tuple[Array, float, float]] = []
        for one in known:
            beta, size = max(abs(one.beta), APART), float(np.linalg.norm(one.gradient))
            r2 = (RADIUS * beta) ** 2
            s = HEIGHT * beta * size / (r2 - (HEIGHT * beta) ** 2) ** 2
            self._bulges.append((one.u, r2, s if one.beta >= 0.0 else -s))

    def _raised(self, u: Array) -> tuple[float, Array]:
        """Return what the bulges add to g, and its gradient."""
        more, slope = 0.0, np.zeros(len(u))
        for point, r2, s in self._bulges:
            away = u - point
            inside = r2 - float(away @ away)
            if inside > 0.0:
                more += s * inside**2
                slope -= 4.0 * s * inside * away
        return more, slope

    def g(self, u: Array) -> float:
        """Return the raised limit state at a point."""
        return super().g(u) + self._raised(u)[0]

    def gradient(self, u: Array, g: float) -> Array:
        """Return ``dg/du`` at a point where the raised g is known."""
        more, slope = self._raised(u)
        return super().gradient(u, g - more) + slope


def further_points(space: Space, first: FormResult) -> list[FormResult]:
    """Return other design points of a limit state that matter beside the first.

    Each search begins at the origin and, if it finds nothing there, opposite of the last point and
    where the limit state, across the first one, lies below all known tangents; what it finds is
    then followed without the bulges. Where the tangent of the limit state at a start leads to what
    is known, or to what does not matter, no search begins: of a plane two gradients and two values
    for each variable are all that is asked.

    Parameters
    ----------
    space : Space
        The limit state; calls are counted there.
    first : FormResult
        Its first design point.
    """
    known = [first]
    around = _across(space, first)
    while len(known) <= MOST:
        found = None
        for start in _starts(space, known, around):
            found = _another(space, known, start)
            if found is not None:
                known.append(found)
                break
        if found is None:
            break
    return known[1:]


def _across(space: Space, first: FormResult) -> list[tuple[Array, float]]:
    """Return places at right angles to a point, as far away as it is, and the limit states there.

    In both directions of each axis of the plane across the point: a further plane as near as the
    first shows at one of them, whichever way it lies. Where the limit state fails it is NaN.
    """
    sides = max(abs(first.beta), APART) * null_space(first.alpha[None])
    if not sides.size:
        return []
    places = np.hstack([sides, -sides])
    return list(zip(places.T, space.many(places, lenient=True), strict=True))


def _starts(
    space: Space, known: Sequence[FormResult], around: Sequence[tuple[Array, float]]
) -> Iterator[Array]:
    """Return where searches may find something: see `further_points`."""
    for start in (np.zeros(space.n), -known[-1].u):
        if _promising(space, known, start):
            yield start
    first = known[0]
    side = 1.0 if first.beta >= 0.0 else -1.0
    size = float(np.linalg.norm(first.gradient)) * max(abs(first.beta), APART)
    below = []
    for u, g in around:
        expected = min(side * float(one.gradient @ (u - one.u)) for one in known)
        below.append(side * g - expected)
    for k in np.argsort(below):
        if below[k] < -BELOW * size and _promising(space, known, around[k][0], NEAR):
            yield around[k][0]


def _another(space: Space, known: Sequence[FormResult], start: Array) -> FormResult | None:
    """Return a design point that is none of those known, or None."""
    try:
        u = design_point(Excluding(space, known), start, "sqp", TOLERANCE, STEPS, FAR).u
        found = design_point(space, u, "sqp", TOLERANCE, STEPS, FAR)
    except (DesignPointError, LimitStateError):
        return None
    new = all(np.linalg.norm(found.u - one.u) > APART for one in known)
    same = (found.beta >= 0.0) is (known[0].beta >= 0.0)
    return found if new and same and _matters(found.beta, known) else None


def _promising(
    space: Space, known: Sequence[FormResult], start: Array, radius: float = RADIUS
) -> bool:
    """Return whether the tangent at a start comes nearest to the origin at a point that is new."""
    try:
        g = space.g(start)
        slope = slope_at(space, start, g, [])
    except (DesignPointError, LimitStateError):
        return False
    size = float(np.linalg.norm(slope))
    beta = (g - float(slope @ start)) / size
    nearest = -beta * slope / size
    within = [radius * max(abs(one.beta), APART) for one in known]
    away = [float(np.linalg.norm(nearest - one.u)) for one in known]
    return _matters(beta, known) and all(x > r for x, r in zip(away, within, strict=True))


def _matters(beta: float, known: Sequence[FormResult]) -> bool:
    """Return whether a point at this distance counts beside the first one."""
    return float(ndtr(-abs(beta))) > COUNTS * float(ndtr(-abs(known[0].beta)))
