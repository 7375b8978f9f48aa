"""Bounds of a criterion between stored instants, from the stored velocities."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.recovery.fields.field import StressField
from jousto.recovery.hotspots.measures import Measure
from jousto.recovery.hotspots.search import search

PARTS = 8
"""Number of pieces of the cubic between two stored instants."""

INSTANTS = 1 << 12
"""Number of stored instants whose cubics are searched at a time."""

SAFETY = 2.0
"""Safety factor on the fourth derivative, which is estimated by differences."""

RESOLVED = 0.1
"""Allowance over the largest value, up to which the stored instants are close enough."""


@dataclass(frozen=True)
class Between:
    """Upper bound of a criterion between the stored instants of a body.

    Attributes
    ----------
    curve : float
        Largest ranked value of all sites on the cubics through stored coordinates and velocities.
    allowance : float
        Bound of the error of `curve`: curvature between the samples of the cubics, and the fourth
        derivative, which the cubics neglect, from differences of their third derivatives.
    """

    curve: float
    allowance: float

    @property
    def bound(self) -> float:
        """Upper bound for all sites between stored instants."""
        return self.curve + self.allowance

    @property
    def resolved(self) -> bool:
        """Whether the allowance is small, which means instants close enough for the motion."""
        return self.allowance <= RESOLVED * abs(self.curve)


@dataclass(frozen=True, eq=False)
class Cubics:
    """Cubic motion between stored instants, ``p = H(p_a, v_a, p_b, v_b)``.

    Attributes
    ----------
    path : (m PARTS + 1, n) array
        Coordinates at the samples.
    stray : (n,) array
        Largest deviation of each coordinate from the chord between two samples.
    """

    path: Array
    stray: Array


def cubics(p: Array, v: Array, time: Array) -> Cubics:
    """Return the cubics between instants, with the largest deviation of the motion from chords.

    The error of a Hermite cubic is at most ``h^4 / 384 max |p''''|`` (C. de Boor, *A Practical
    Guide to Splines*, ch. IV). The fourth derivative is estimated by the change of the third
    derivative from one interval to the next over the distance of their midpoints, times SAFETY.
    The deviation of a cubic from the chord between samples at the distance d = h / PARTS is at
    most ``d^2 / 8`` times its largest second derivative, which is that at an end.

    Parameters
    ----------
    p, v : (nt, n) array
        Coordinates and their rates.
    time : (nt,) array
        s.
    """
    h = np.diff(time)[:, None]
    rise, a, b = np.diff(p, axis=0), h * v[:-1], h * v[1:]
    x = (np.arange(PARTS) / PARTS)[:, None, None]
    inner = p[:-1] + x * (a + x * (3.0 * rise - 2.0 * a - b + x * (a + b - 2.0 * rise)))
    path = np.concatenate([np.moveaxis(inner, 0, 1).reshape(-1, p.shape[1]), p[-1:]])
    second = np.maximum(
        np.abs(6.0 * rise - 4.0 * a - 2.0 * b), np.abs(-6.0 * rise + 2.0 * a + 4.0 * b)
    )
    third = 6.0 * (a + b - 2.0 * rise) / h**3
    fourth = np.zeros_like(third)
    if len(third) > 1:
        jump = np.abs(np.diff(third, axis=0)) / (0.5 * (h[1:] + h[:-1]))
        fourth[:-1] = jump
        fourth[1:] = np.maximum(fourth[1:], jump)
    stray = second / (8.0 * PARTS**2) + SAFETY * h**4 / 384.0 * fourth
    return Cubics(path, stray.max(axis=0, initial=0.0))


def bounds_between(field: StressField, measure: Measure) -> Between | None:
    """Return the bound of a criterion at all sites between the instants of a field.

    None without velocities, with one instant, or for a criterion whose sign jumps.
    """
    if field.v is None or field.nt < 2 or not measure.smooth:
        return None
    columns = sensitivity(field.S, measure)
    curve, allowance = -np.inf, 0.0
    for first in range(0, field.nt - 1, INSTANTS):
        # one more interval on each side for the fourth derivative
        rows = slice(max(first - 1, 0), min(first + INSTANTS + 2, field.nt))
        found = cubics(field.p[rows], field.v[rows], field.time[rows])
        best = search(field.S, found.path, field.positions, measure, count=1)
        curve = max(curve, float(best.ranked[0]))
        allowance = max(allowance, float((columns @ found.stray).max(initial=0.0)))
    return Between(curve, allowance)


def largest_between(field: StressField, place: int, measure: Measure) -> float:
    """Return the bound of a criterion at a site between instants, with its sign; nan if none."""
    if field.v is None or field.nt < 2 or not measure.smooth:
        return float("nan")
    S = field.S[place]
    found = cubics(field.p, field.v, field.time)
    values = measure.value(found.path @ S.T)
    ranked = measure.rank(values)
    k = int(np.argmax(ranked))
    top = float(ranked[k]) + float((sensitivity(S[None], measure) @ found.stray)[0])
    # sign of the largest ranked value
    down = measure.extreme == "smallest" or (measure.extreme == "magnitude" and values[k] < 0.0)
    return -top if down else top


def sensitivity(S: Array, measure: Measure) -> Array:
    """Return the largest change (ns, n) of a criterion per unit of each coordinate."""
    return np.asarray(np.sqrt(((measure.rows @ S) ** 2).sum(axis=1)))
