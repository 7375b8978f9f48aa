"""Picks: nodes of a part or mesh chosen by where they are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Floats, Ints
from jousto.base.errors import Problems
from jousto.base.ranking import TIE

NEAR = 1e-6
"""Nodes this far outside still count as inside, as a share of the size of the body."""


def _slack(nodes: Floats) -> float:
    return NEAR * float(np.ptp(nodes, axis=0).max()) if len(nodes) else 0.0


@explained
@dataclass(frozen=True, eq=False)
class InBox:
    """The nodes in a box along the axes, those on its faces included.

    Parameters
    ----------
    low, high : (3,) array_like
        Two opposite corners in m, part frame; infinite values leave a side open.

    Raises
    ------
    InputError
        If a corner is not a point or `low` is above `high`.

    Examples
    --------
    >>> InBox((0, -1, -1), (0, 1, 1)).of(np.array([[0.0, 0, 0], [0.5, 0, 0]]))
    array([0])
    """

    low: Any
    high: Any

    def __post_init__(self) -> None:
        problems = Problems()
        corners = []
        for name in ("low", "high"):
            corner = np.asarray(getattr(self, name), dtype=np.float64)
            if corner.shape != (3,) or np.any(np.isnan(corner)):
                problems.add("InBox", f"{name} is {getattr(self, name)!r}, must be three numbers")
            corners.append(corner)
            object.__setattr__(self, name, corner)
        if not problems.found:
            for a in np.flatnonzero(corners[0] > corners[1]):
                problems.add(
                    "InBox",
                    f"low is {corners[0][a]:g} m along {'xyz'[a]}, above high, {corners[1][a]:g} m",
                )
        problems.raise_if_any()

    def of(self, nodes: Floats) -> Ints:
        """Return the indices of the nodes (nn, 3) in the box, ascending."""
        e = _slack(nodes)
        return np.flatnonzero(np.all((nodes >= self.low - e) & (nodes <= self.high + e), axis=1))


@dataclass(frozen=True, eq=False)
class InCylinder:
    """The nodes in a solid cylinder, those on its surface included: a bore, a pin, a flange.

    Inside a bore there are no nodes: a cylinder of its radius takes those on its wall.

    Parameters
    ----------
    point : (3,) array_like
        A point on the axis in m, part frame; the middle of the cylinder if it has a length.
    axis : (3,) array_like
        Direction of the axis, any length.
    radius : float
        In m.
    length : float, optional
        Along the axis in m; without end if not given.

    Raises
    ------
    InputError
        If a value is not a point, a direction or a positive number.

    Examples
    --------
    >>> InCylinder((0, 0, 0), (0, 0, 1), 0.1).of(np.array([[0.1, 0.0, 5.0], [0.1, 0.1, 0.0]]))
    array([0])
    """

    point: Any
    axis: Any
    radius: float
    length: float | None = None

    def __post_init__(self) -> None:
        problems = Problems()
        point = problems.array("InCylinder", "point", self.point, (3,))
        axis = problems.array("InCylinder", "axis", self.axis, (3,))
        if axis is not None and not np.any(axis):
            problems.add("InCylinder", "axis is zero, must be a direction")
        problems.positive("InCylinder", "radius", self.radius, "m")
        if self.length is not None:
            problems.positive("InCylinder", "length", self.length, "m")
        problems.raise_if_any()
        assert axis is not None
        object.__setattr__(self, "point", point)
        object.__setattr__(self, "axis", axis / np.linalg.norm(axis))

    def of(self, nodes: Floats) -> Ints:
        """Return the indices of the nodes (nn, 3) in the cylinder, ascending."""
        e = _slack(nodes)
        arm = nodes - self.point
        along = arm @ self.axis
        away = np.linalg.norm(arm - along[:, None] * self.axis, axis=1)
        half = np.inf if self.length is None else 0.5 * self.length
        return np.flatnonzero((away <= self.radius + e) & (np.abs(along) <= half + e))


@dataclass(frozen=True, eq=False)
class InSphere:
    """The nodes in a sphere, those on its surface included.

    Parameters
    ----------
    point : (3,) array_like
        The centre in m, part frame.
    radius : float
        In m.

    Raises
    ------
    InputError
        If a value is not a point or a positive number.
    """

    point: Any
    radius: float

    def __post_init__(self) -> None:
        problems = Problems()
        object.__setattr__(self, "point", problems.array("InSphere", "point", self.point, (3,)))
        problems.positive("InSphere", "radius", self.radius, "m")
        problems.raise_if_any()

    def of(self, nodes: Floats) -> Ints:
        """Return the indices of the nodes (nn, 3) in the sphere, ascending."""
        away = np.linalg.norm(nodes - self.point, axis=1)
        return np.flatnonzero(away <= self.radius + _slack(nodes))


@explained
@dataclass(frozen=True, eq=False)
class Nearest:
    """The nodes nearest to a point; of equally near ones those of lower number.

    Parameters
    ----------
    point : (3,) array_like
        In m, part frame.
    count : int
        How many nodes.

    Raises
    ------
    InputError
        If `point` is not a point or `count` is below one.

    Examples
    --------
    >>> Nearest((1, 0, 0)).of(np.array([[0.0, 0, 0], [0.8, 0, 0]]))
    array([1])
    """

    point: Any
    count: int = 1

    def __post_init__(self) -> None:
        problems = Problems()
        object.__setattr__(self, "point", problems.array("Nearest", "point", self.point, (3,)))
        if self.count != int(self.count) or self.count < 1:
            problems.add("Nearest", f"count is {self.count!r}, must be a whole number from 1")
        problems.raise_if_any()

    def of(self, nodes: Floats) -> Ints:
        """Return the indices of the nodes (nn, 3) nearest to the point, ascending."""
        away = np.linalg.norm(nodes - self.point, axis=1)
        if len(away) <= self.count:
            return np.arange(len(away), dtype=np.intp)
        # of nodes that are equally far the first ones
        last = np.partition(away, self.count - 1)[self.count - 1]
        nearer = np.flatnonzero(away < last * (1.0 - TIE))
        equal = np.flatnonzero(np.abs(away - last) <= TIE * last)
        return np.sort(np.concatenate([nearer, equal[: self.count - len(nearer)]]))


Pick = InBox | InCylinder | InSphere | Nearest
