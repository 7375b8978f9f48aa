"""Picks: nodes of a part or mesh selected by position."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, Ints
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, field
from jousto.base.numbers import OptionalPositive, Positive, Vector, Whole
from jousto.base.ranking import TIE

NEAR = 1e-6
"""Largest distance outside at which nodes count as inside / size of the body."""


def _slack(nodes: Array) -> float:
    return NEAR * float(np.ptp(nodes, axis=0).max()) if len(nodes) else 0.0


class Corner(Vector):
    """Field of a corner of a box; infinite values leave a side open."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return an array (3,), or report what is wrong."""
        try:
            corner = np.array(value, dtype=np.float64)
        except (TypeError, ValueError, OverflowError):
            corner = np.array(np.nan)
        if corner.shape != (3,) or np.any(np.isnan(corner)):
            problems.add(where, f"{self.name} is {value!r}, must be three numbers")
        return corner


class Way(Field[ArrayLike, Array]):
    """Field of a direction, stored as a unit vector."""

    form = "direction"
    noun = "(3,) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a unit vector, or report what is wrong."""
        return unit_vector(problems, where, self.name, value)


def unit_vector(problems: Problems, where: str, name: str, value: Any) -> Array | None:
    """Return a vector divided by its length, or report a zero vector."""
    vector = problems.array(where, name, value, (3,))
    if vector is None:
        return None
    long = float(np.linalg.norm(vector))
    if long == 0.0:
        problems.add(where, f"{name} is zero, must have a direction", name)
        return None
    return vector / long


class Pick(Declared, ABC):
    """Base of selections of nodes by position."""

    @abstractmethod
    def of(self, nodes: Array) -> Ints:
        """Return the indices of the selected nodes among nodes (nn, 3), ascending."""

    def __repr__(self) -> str:
        return (
            f"{type(self).__name__}({', '.join(f'{k}={getattr(self, k)!r}' for k in self.fields)})"
        )


class InBox(Pick):
    """Nodes in a box along the axes, including those on its faces.

    Raises
    ------
    InputError
        If a corner is not a point or `low` is above `high`.

    Examples
    --------
    >>> InBox((0, -1, -1), (0, 1, 1)).of(np.array([[0.0, 0, 0], [0.5, 0, 0]]))
    array([0])
    """

    low: Corner = field("One corner, part frame; -inf leaves a side open", unit="m")
    high: Corner = field("The opposite corner; inf leaves a side open", unit="m")

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a lower corner above the upper one."""
        for a in np.flatnonzero(self.low > self.high):
            low, high = self.low[a], self.high[a]
            problems.add(where, f"low is {low:g} m along {'xyz'[a]}, above high, {high:g} m", "low")

    def of(self, nodes: Array) -> Ints:
        """Return the indices of the nodes (nn, 3) in the box, ascending."""
        e = _slack(nodes)
        return np.flatnonzero(np.all((nodes >= self.low - e) & (nodes <= self.high + e), axis=1))


class InCylinder(Pick):
    """Nodes in a solid cylinder, including those on its surface: a bore, a pin, a flange.

    A bore contains no nodes, so a cylinder of its radius selects those on its wall.

    Raises
    ------
    InputError
        If a value is not a point, a direction or a positive number.

    Examples
    --------
    >>> InCylinder((0, 0, 0), (0, 0, 1), 0.1).of(np.array([[0.1, 0.0, 5.0], [0.1, 0.1, 0.0]]))
    array([0])
    """

    point: Vector = field(
        "Point on the axis, part frame; the middle of the cylinder if a length is given", unit="m"
    )
    axis: Way = field("Direction of the axis, any length")
    radius: Positive = field("Radius", unit="m")
    length: OptionalPositive = field(
        "Length along the axis; None for an infinite cylinder", unit="m", default=None
    )

    def of(self, nodes: Array) -> Ints:
        """Return the indices of the nodes (nn, 3) in the cylinder, ascending."""
        e = _slack(nodes)
        arm = nodes - self.point
        along = arm @ self.axis
        away = np.linalg.norm(arm - along[:, None] * self.axis, axis=1)
        half = np.inf if self.length is None else 0.5 * self.length
        return np.flatnonzero((away <= self.radius + e) & (np.abs(along) <= half + e))


class InSphere(Pick):
    """Nodes in a sphere, including those on its surface.

    Raises
    ------
    InputError
        If a value is not a point or a positive number.
    """

    point: Vector = field("The centre, part frame", unit="m")
    radius: Positive = field("Radius", unit="m")

    def of(self, nodes: Array) -> Ints:
        """Return the indices of the nodes (nn, 3) in the sphere, ascending."""
        away = np.linalg.norm(nodes - self.point, axis=1)
        return np.flatnonzero(away <= self.radius + _slack(nodes))


class OnPlane(Pick):
    """Nodes on a plane.

    Raises
    ------
    InputError
        If a value is not a point, a direction or a positive number.

    Examples
    --------
    >>> OnPlane((0, 0, 1), (0, 0, 1)).of(np.array([[0.0, 0, 0], [5, 0, 1]]))
    array([1])
    """

    point: Vector = field("A point of the plane, part frame", unit="m")
    normal: Way = field("Normal of the plane, any length")
    tolerance: OptionalPositive = field(
        "Largest distance; None for 1e-6 times the size of the body", unit="m", default=None
    )

    def of(self, nodes: Array) -> Ints:
        """Return the indices of the nodes (nn, 3) on the plane, ascending."""
        near = _slack(nodes) if self.tolerance is None else self.tolerance
        return np.flatnonzero(np.abs((nodes - self.point) @ self.normal) <= near)


class Nearest(Pick):
    """Nodes nearest to a point; of equally near nodes those with lower index.

    Raises
    ------
    InputError
        If `point` is not a point or `count` is below one.

    Examples
    --------
    >>> Nearest((1, 0, 0)).of(np.array([[0.0, 0, 0], [0.8, 0, 0]]))
    array([1])
    """

    point: Vector = field("Point, part frame", unit="m")
    count: Whole = field("Number of nodes", least=1, default=1)

    def of(self, nodes: Array) -> Ints:
        """Return the indices of the nodes (nn, 3) nearest to the point, ascending."""
        away = np.linalg.norm(nodes - self.point, axis=1)
        if len(away) <= self.count:
            return np.arange(len(away), dtype=np.intp)
        # among nodes at equal distance the first nodes are taken
        last = np.partition(away, self.count - 1)[self.count - 1]
        nearer = np.flatnonzero(away < last * (1.0 - TIE))
        equal = np.flatnonzero(np.abs(away - last) <= TIE * last)
        return np.sort(np.concatenate([nearer, equal[: self.count - len(nearer)]]))
