"""The axis of points on a cylinder, such as the nodes of a bore."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Floats

LEAST = 8
"""Fewer points than these do not tell a cylinder from something else."""
ROUND = 0.01
"""Root mean square distance of the points from the cylinder, as a share of its radius."""
GAP = np.radians(210.0)
"""Widest angle without points."""


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder through points.

    Attributes
    ----------
    middle : (3,) ndarray
        Middle of its axis in m.
    axis : (3,) ndarray
        Unit vector along it.
    radius, length : float
        In m.
    """

    middle: Floats
    axis: Floats
    radius: float
    length: float


def cylinder_middle(x: Floats) -> Floats | None:
    """Return the middle of the axis of the cylinder through points, or None if there is none.

    Parameters
    ----------
    x : (k, 3) ndarray
        Points in m.

    Examples
    --------
    >>> t = np.linspace(0.0, 4.0, 12)  # 230 degrees of a ring
    >>> x = np.stack([np.cos(t), np.sin(t), 0.3 * (np.arange(12) % 2)], axis=1)
    >>> cylinder_middle(x).round(9) + 0.0
    array([0.  , 0.  , 0.15])
    """
    found = cylinder_through(x)
    return None if found is None else found.middle


def cylinder_through(x: Floats) -> Cylinder | None:
    """Return the cylinder through points, or None if there is none.

    Least squares over axis, centre and radius, from the three principal directions of the points.

    Parameters
    ----------
    x : (k, 3) ndarray
        Points in m.

    Examples
    --------
    >>> t = np.linspace(0.0, 4.0, 12)  # 230 degrees of a ring
    >>> x = np.stack([np.cos(t), np.sin(t), 0.3 * (np.arange(12) % 2)], axis=1)
    >>> round(cylinder_through(x).radius, 9)
    1.0
    """
    if len(x) < LEAST:
        return None
    centroid = x.mean(axis=0)
    size = float(np.linalg.norm(x - centroid, axis=1).max())
    if size == 0.0:
        return None
    y = (x - centroid) / size
    best: tuple[float, Cylinder] | None = None
    for axis in np.linalg.eigh(y.T @ y)[1].T:
        found = _fit(y, axis)
        if found is not None and (best is None or found[0] < best[0]):
            best = found
    if best is None or best[0] > ROUND:
        return None
    c = best[1]
    return Cylinder(centroid + size * c.middle, c.axis, size * c.radius, size * c.length)


def _fit(y: Floats, axis: Floats) -> tuple[float, Cylinder] | None:
    """Return the error relative to the radius and the cylinder, from a first axis."""
    from scipy.optimize import least_squares  # slow to import and rarely needed

    u, v = np.linalg.svd(axis[None, :])[2][1:]
    # a circle in the plane across the axis: |y|^2 = 2 c.y + (r^2 - |c|^2)
    plane = np.stack([y @ u, y @ v], axis=1)
    A = np.column_stack([2.0 * plane, np.ones(len(y))])
    (a, b, c), *_ = np.linalg.lstsq(A, np.einsum("ij,ij->i", plane, plane), rcond=None)
    r = np.sqrt(max(c + a * a + b * b, 0.0))
    if not 0.0 < r < 4.0:
        return None

    def frame(p: Floats) -> tuple[Floats, Floats, Floats]:
        e = axis + p[0] * u + p[1] * v
        e = e / np.linalg.norm(e)
        centre = p[2] * u + p[3] * v
        arm = y - centre
        along = arm @ e
        return centre, e, np.linalg.norm(arm - along[:, None] * e, axis=1)

    if np.sqrt(np.mean((frame(np.array([0.0, 0.0, a, b, r]))[2] - r) ** 2)) > 0.3 * r:
        return None

    def distance(p: Floats) -> Floats:
        return np.asarray(frame(p)[2] - p[4])

    p = least_squares(distance, np.array([0.0, 0.0, a, b, r]), method="lm").x
    centre, e, away = frame(p)
    if not 0.0 < p[4] < 4.0:
        return None
    error = float(np.sqrt(np.mean((away / p[4] - 1.0) ** 2)))

    arm = y - centre
    along = arm @ e
    first = arm[0] - along[0] * e
    second = np.cross(e, first)
    angle = np.sort(np.arctan2(arm @ second, arm @ first))
    if np.diff(angle, append=angle[0] + 2.0 * np.pi).max() > GAP:
        return None
    low, high = float(along.min()), float(along.max())
    return error, Cylinder(centre + 0.5 * (low + high) * e, e, float(p[4]), high - low)
