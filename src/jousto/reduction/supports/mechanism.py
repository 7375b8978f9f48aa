"""Rigid motions that supports leave free, and their names."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problem

ROUNDING = 1e-9  # entry of a motion over the largest, below which it is zero


def names_of_motions(left: Array, center: Array, length: float) -> list[str]:
    """Return names of rigid motions such as ``rotation about x through (0, 0, 0) m``.

    Parameters
    ----------
    left : (6, r) array
        Independent motions: translation of the centre divided by the length, and rotation.
    center : (3,) array
        Point to which they refer, m.
    length : float
        Size of the body, m.
    """
    # rotations first, so that each of the motions has as few rotations as possible
    rows = reduced_rows(np.vstack([left[3:], left[:3]]).T)
    return [name_of_motion(row, center, length) for row in rows]


def mechanism_left(where: str, left: Array, center: Array, length: float) -> Problem:
    """Return the error for supports that leave rigid motions free."""
    found = names_of_motions(left, center, length)
    return Problem(
        where,
        f"its supports leave {len(found)} rigid motion{'s' * (len(found) > 1)}: "
        f"{'; '.join(found)}; hold further directions or nodes",
    )


def reduced_rows(A: Array) -> Array:
    """Return the reduced row echelon form of independent rows (r, 6)."""
    A, row = A.copy(), 0
    for column in range(A.shape[1]):
        pivot = row + int(np.abs(A[row:, column]).argmax())
        if abs(A[pivot, column]) <= ROUNDING * np.abs(A).max():
            A[row:, column] = 0.0
            continue
        A[[row, pivot]] = A[[pivot, row]]
        A[row] /= A[row, column]
        others = np.arange(len(A)) != row
        A[others] -= np.outer(A[others, column], A[row])
        row += 1
        if row == len(A):
            break
    return A


def name_of_motion(row: Array, center: Array, length: float) -> str:
    """Return the name of a motion (6,): rotation, and translation of the centre / length."""
    w, t = row[:3], row[3:] * length
    turn = float(np.linalg.norm(w))
    if turn <= ROUNDING * max(1.0, float(np.linalg.norm(t)) / length):
        return f"translation along {_direction(t)}"
    # the axis of the screw: its point next to the centre, and its advance in a radian
    point = center + np.cross(w, t) / turn**2
    advance = float(w @ t) / turn**2
    point = np.where(np.abs(point) <= 1e-6 * length, 0.0, point)
    place = ", ".join(f"{x:.4g}" for x in point)
    text = f"rotation about {_direction(w)} through ({place}) m"
    return text if abs(advance) <= 1e-6 * length else f"{text} with {advance:.4g} m/rad along it"


def _direction(d: Array) -> str:
    """Return ``x``, ``y`` or ``z`` for a direction along an axis, else the unit vector as text."""
    unit = d / np.abs(d).max()
    unit = np.where(np.abs(unit) <= 1e-6, 0.0, unit)
    if np.count_nonzero(unit) == 1:
        return "xyz"[int(np.abs(unit).argmax())]
    unit = unit / np.linalg.norm(unit)
    return "(" + ", ".join(f"{x:.4g}" for x in unit) + ")"
