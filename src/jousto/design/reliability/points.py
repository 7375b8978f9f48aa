"""Search for further design points of a limit state, with bulges around the known ones."""

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
"""Radius of a bulge, and the distance that defines its height, in distances |u*| of its design
point (Der Kiureghian and Dakessian)."""
MOST = 8
"""Maximum number of further design points."""
COUNTS = 1e-3
"""Probability of a point relative to the first one below which it is neglected."""
NEAR = 0.8
"""Radius factor where the limit state lies below all tangents: planes 50 degrees apart."""
BELOW = 0.1
"""Distance of the limit state from all known tangents, relative to g at the origin, from which a
search is worth its calls."""
APART = 0.5
"""Distance, standard deviations, below which two points are one."""
TOLERANCE, STEPS = 1e-4, 30
"""Tolerance of a search; its point is only a centre of samples."""


class Excluding(Space):
    """Limit state raised by a bulge around each known design point.

    ``g(u) + sum s (r^2 - |u - u*|^2)^2`` within r of u*, so that the nearest failure is elsewhere
    (A. Der Kiureghian and T. Dakessian, *Struct. Saf.* 20 (1998) 37-49).

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
        """Return the sum of the bulges, and its gradient."""
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
        """Return ``dg/du`` of the raised limit state at a point with known g."""
        more, slope = self._raised(u)
        return super().gradient(u, g - more) + slope


def further_points(space: Space, first: FormResult) -> list[FormResult]:
    """Return further design points of a limit state whose probability is not negligible.

    Each search starts at the origin and, if it finds no new point, opposite the last point and at
    the perpendicular points at which the limit state lies below all known tangents. A found point
    is refined without the bulges. No search starts where the tangent leads to a known or a
    negligible point: a plane limit state costs two gradients and two values per variable.

    Parameters
    ----------
    space : Space
        The limit state; calls are counted there.
    first : FormResult
        First design point of the limit state.
    """
    known = [first]
    around = _perpendicular_points(space, first)
    while len(known) <= MOST:
        found = None
        for start in _search_starts(space, known, around):
            found = _next_design_point(space, known, start)
            if found is not None:
                known.append(found)
                break
        if found is None:
            break
    return known[1:]


def _perpendicular_points(space: Space, first: FormResult) -> list[tuple[Array, float]]:
    """Return points perpendicular to u* at the same distance, and their limit state.

    The points lie in both directions of each axis of the plane perpendicular to u*: at one of them
    the limit state reveals a second plane at the same distance, whatever its direction. NaN where
    the limit state cannot be computed.
    """
    sides = max(abs(first.beta), APART) * null_space(first.alpha[None])
    if not sides.size:
        return []
    places = np.hstack([sides, -sides])
    return list(zip(places.T, space.g_columns(places, lenient=True), strict=True))


def _search_starts(
    space: Space, known: Sequence[FormResult], around: Sequence[tuple[Array, float]]
) -> Iterator[Array]:
    """Return starts for searches: see `further_points`."""
    for start in (np.zeros(space.n), -known[-1].u):
        if _leads_to_new_point(space, known, start):
            yield start
    first = known[0]
    side = 1.0 if first.beta >= 0.0 else -1.0
    size = float(np.linalg.norm(first.gradient)) * max(abs(first.beta), APART)
    below = []
    for u, g in around:
        expected = min(side * float(one.gradient @ (u - one.u)) for one in known)
        below.append(side * g - expected)
    for k in np.argsort(below):
        if below[k] < -BELOW * size and _leads_to_new_point(space, known, around[k][0], NEAR):
            yield around[k][0]


def _next_design_point(
    space: Space, known: Sequence[FormResult], start: Array
) -> FormResult | None:
    """Return a design point other than the known ones, or None."""
    try:
        u = design_point(Excluding(space, known), start, "sqp", TOLERANCE, STEPS, FAR).u
        found = design_point(space, u, "sqp", TOLERANCE, STEPS, FAR)
    except (DesignPointError, LimitStateError):
        return None
    new = all(np.linalg.norm(found.u - one.u) > APART for one in known)
    same = (found.beta >= 0.0) is (known[0].beta >= 0.0)
    return found if new and same and _is_relevant(found.beta, known) else None


def _leads_to_new_point(
    space: Space, known: Sequence[FormResult], start: Array, radius: float = RADIUS
) -> bool:
    """Return whether the tangent at a start leads to a new point."""
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
    return _is_relevant(beta, known) and all(x > r for x, r in zip(away, within, strict=True))


def _is_relevant(beta: float, known: Sequence[FormResult]) -> bool:
    """Return whether a point at a distance beta has a noticeable share of the probability."""
    return float(ndtr(-abs(beta))) > COUNTS * float(ndtr(-abs(known[0].beta)))
