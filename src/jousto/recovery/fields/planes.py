"""Critical plane: the plane of the largest normal stress, or of its largest range."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.ranking import TIE, largest, ranking
from jousto.base.voigt import PAIRS
from jousto.recovery.fields.criteria import principal

GRID = 400
"""Number of directions on the half-sphere, some 7 degrees apart."""
STARTS = 6
"""Number of the best directions that are refined."""

ROUNDS = 100

INSTANTS = 1 << 16
"""Number of instants evaluated on the grid at a time."""


@dataclass(frozen=True, eq=False)
class CriticalPlane:
    """Critical plane with the extremes of its normal stress over time.

    Attributes
    ----------
    normal : (3,) array
        Unit normal, in the axes of the stress.
    value : float
        Largest normal stress, or the range from the smallest to the largest, Pa (or m/m).
    time : float
        Instant of the largest normal stress, s.
    minimum_time : float
        Instant of the smallest normal stress, s.
    by : str
        "maximum" or "range".
    """

    normal: Array
    value: float
    time: float
    minimum_time: float
    by: str

    def __str__(self) -> str:
        n = ", ".join(f"{x:.4f}" for x in self.normal)
        return f"normal ({n}): {self.by} {self.value:.6g}, largest at {self.time:.6g} s"


def half_sphere(count: int = GRID) -> Array:
    """Return evenly distributed directions (count, 3) on a half-sphere, by the golden angle."""
    z = (np.arange(count) + 0.5) / count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


def plane_weights(normals: Array, strain: bool = False) -> Array:
    """Return weights w (..., 6) of normals (..., 3) such that ``n^T S n = w . s``."""
    shear = 1.0 if strain else 2.0
    columns = [normals[..., i] * normals[..., j] * (1.0 if i == j else shear) for i, j in PAIRS]
    return np.stack(columns, axis=-1)


def critical_plane(
    s: ArrayLike,
    time: ArrayLike,
    *,
    by: Literal["maximum", "range"] = "maximum",
    strain: bool = False,
) -> CriticalPlane:
    """Return the plane of the largest normal stress of a history, or of its largest range.

    The search starts from the best directions of a grid on the half-sphere. In an iteration, the
    principal direction of the difference of the tensors at the instants of the largest and the
    smallest normal stress gives a plane with a larger range, until the instants do not change.

    Parameters
    ----------
    s : (nt, 6) array_like
        Stress history ``[s11 s22 s33 s12 s23 s13]``, or strains.
    time : (nt,) array_like
        Instants, s.
    by : str
        "maximum" (the largest principal stress of all instants) or "range".
    strain : bool
        Whether s are strains with engineering shears.

    Raises
    ------
    InputError
        If `by` is unknown.

    Examples
    --------
    Tension along x, then along y: the plane of the largest range is normal to one of these axes.

    >>> plane = critical_plane([[80.0, 0, 0, 0, 0, 0], [0, 100.0, 0, 0, 0, 0]], [0, 1], by="range")
    >>> abs(plane.normal).round(6), round(plane.value, 6)
    (array([0., 1., 0.]), 100.0)
    """
    history, t = np.asarray(s, dtype=np.float64), np.asarray(time, dtype=np.float64)
    if by == "maximum":
        values, directions = principal(history, strain)
        k = largest(values[:, 0])
        n = positive_normal(directions[k, :, 0])
        least = largest(-(history @ plane_weights(n, strain)))
        return CriticalPlane(n, float(values[k, 0]), float(t[k]), float(t[least]), by)
    if by != "range":
        raise InputError(Problem("critical plane", f"by is {by!r}, must be 'maximum' or 'range'"))
    normals = half_sphere()
    w = plane_weights(normals, strain).T
    high, low = np.full(len(normals), -np.inf), np.full(len(normals), np.inf)
    for k in range(0, len(history), INSTANTS):
        x = history[k : k + INSTANTS] @ w
        high, low = np.maximum(high, x.max(axis=0)), np.minimum(low, x.min(axis=0))
    best = (-1.0, np.array([1.0, 0.0, 0.0]), 0, 0)
    for start in ranking(high - low)[:STARTS]:
        found = _refined(history, normals[start], strain)
        best = found if found[0] > best[0] + TIE * abs(best[0]) else best
    value, n, top, bottom = best
    return CriticalPlane(positive_normal(n), value, float(t[top]), float(t[bottom]), by)


def positive_normal(normal: Array) -> Array:
    """Return the normal or its opposite, such that its (first) largest component is positive."""
    return normal if normal[largest(np.abs(normal))] >= 0.0 else -normal


def _refined(history: Array, n: Array, strain: bool) -> tuple[float, Array, int, int]:
    """Return range, normal and instants of the extremes of the local maximum near a normal."""
    pair = (-1, -1)
    for _ in range(ROUNDS):
        x = history @ plane_weights(n, strain)
        found = (int(np.argmax(x)), int(np.argmin(x)))
        if found == pair:
            break
        pair = found
        n = principal(history[pair[0]] - history[pair[1]], strain)[1][:, 0]
    x = history @ plane_weights(n, strain)
    top, bottom = largest(x), largest(-x)
    return float(x[top] - x[bottom]), n, top, bottom
