"""View of a scene: an orthographic projection onto the picture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, frozen
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.rotations import parse_direction

FLAT = 1e-3  # relative range of motion in a direction below which the motion is plane
PLANES = {"xy": ((0, 0, 1), (0, 1, 0)), "xz": ((0, -1, 0), (0, 0, 1)), "yz": ((1, 0, 0), (0, 0, 1))}


@dataclass(frozen=True, eq=False, init=False)
class View:
    """Direction of view from infinity, and the upward direction.

    Parameters
    ----------
    direction : (3,) array_like
        Direction from the scene to the eye, world frame.
    up : (3,) array_like
        Upwards in the picture, world frame; need not be perpendicular to the direction.

    Attributes
    ----------
    axes : (3, 3) array
        Rows: the picture's right and up and the direction to the eye, unit vectors, world frame.

    Raises
    ------
    InputError
        If a vector is zero or not finite, or the two are parallel.

    Examples
    --------
    >>> View((0, 0, 1), up=(0, 1, 0)).project([[1.0, 2.0, 3.0]])
    array([[1., 2., 3.]])
    """

    axes: Array

    def __init__(self, direction: ArrayLike, *, up: ArrayLike = (0.0, 0.0, 1.0)) -> None:
        problems = Problems()
        n = parse_direction(problems, "View", "direction", direction)
        u = parse_direction(problems, "View", "up", up)
        problems.raise_if_any()
        assert n is not None and u is not None
        n = n / np.linalg.norm(n)
        right = np.cross(u / np.linalg.norm(u), n)
        if np.linalg.norm(right) < 1e-6:
            raise InputError(Problem("View", "up is parallel to the direction; give another one"))
        right /= np.linalg.norm(right)
        object.__setattr__(self, "axes", frozen(np.stack([right, np.cross(n, right), n])))

    @classmethod
    def on(cls, plane: str) -> View:
        """Return the view normal to a coordinate plane: "xy", "xz" or "yz".

        Raises
        ------
        InputError
            If there is no such plane.
        """
        if plane not in PLANES:
            raise InputError(
                Problem("view", f"is {plane!r}, must be 'xy', 'xz', 'yz' or a View(direction, up=)")
            )
        direction, up = PLANES[plane]
        return cls(direction, up=up)

    @property
    def plane(self) -> str:
        """Coordinate plane normal to the view, as "xy"; empty if there is none."""
        if np.abs(self.axes).max(axis=1).min() < 1.0 - 1e-9:
            return ""
        return "".join("xyz"[int(np.argmax(np.abs(axis)))] for axis in self.axes[:2])

    @property
    def up(self) -> int:
        """Index of the coordinate axis nearest to the picture's upward direction."""
        return int(np.argmax(np.abs(self.axes[1])))

    def project(self, x: ArrayLike) -> Array:
        """Return right, up and nearness (..., 3) of world positions (..., 3), m."""
        return np.asarray(np.asarray(x, dtype=np.float64) @ self.axes.T)


def choose_view(view: View | str | None, points: Array, gravity: ArrayLike | None) -> View:
    """Return the given view, or one that shows the motion well.

    Plane motion is viewed along its normal, other motion from the front, the right and above.

    Parameters
    ----------
    view : View, "xy", "xz", "yz" or None
        View requested by the user.
    points : (k, 3) array
        Positions that are in the picture, m.
    gravity : (3,) array or None
        Gravity; its opposite is up. Without gravity, y is up in the xy plane, and z in other views.

    Raises
    ------
    InputError
        If the view is none of these.
    """
    if isinstance(view, View):
        return view
    if view is not None:
        return View.on(view)
    extent = np.ptp(points, axis=0)
    thin = int(np.argmin(extent))
    g: Any = np.zeros(3) if gravity is None else np.asarray(gravity, dtype=np.float64)
    flat = extent[thin] <= FLAT * extent.max()
    main = int(np.argmax(np.abs(g))) if g.any() else 1 if flat and thin == 2 else 2
    up = np.zeros(3)
    up[main] = -np.sign(g[main]) if g.any() else 1.0
    if flat and thin != main:
        plane = {0: "yz", 1: "xz", 2: "xy"}[thin]
        return View(PLANES[plane][0], up=up)
    # from front, right and above; x to the right
    front = {0: (0.9, 0.5, 1.0), 1: (0.75, 0.9, 1.0), 2: (0.75, -1.0, 0.9)}[main]
    direction = np.array(front)
    direction[main] = 0.55 * up[main]
    return View(direction, up=up)
