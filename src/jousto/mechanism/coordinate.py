"""Coordinates: scalar functions of two marker frames a and b, and lines through them.

Joints give theirs as properties (``hinge.angle``); drives, couplings, springs, servos and sensors
take them. Three kinds are enough for all of these: an angle, a displacement and a distance.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from jousto.errors import InputError, Problem, Problems
from jousto.mechanism.fields import set_fields
from jousto.mechanism.marker import Marker, check_marker

if TYPE_CHECKING:
    from jousto.mechanism.joints.base import Joint
    from jousto.mechanism.signals import Signal

AXES = ("x", "y", "z")


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Coordinate(ABC):
    """A scalar function of the frames of two markers.

    Parameters
    ----------
    a, b : Marker
        The frames; not both on one rigid body.
    name : str, optional
        Name for messages and results; None for one made of the markers' labels.
    joint : Joint, optional
        The joint that keeps this coordinate free, if it belongs to one.

    Attributes
    ----------
    unit, force_unit : str
        Unit of the coordinate, and of a force along it.
    """

    unit: ClassVar[str] = "m"
    force_unit: ClassVar[str] = "N"
    a: Marker
    b: Marker
    name: str
    joint: Joint | None

    def __init__(
        self, a: Marker, b: Marker, *, name: str | None = None, joint: Joint | None = None
    ) -> None:
        init_coordinate(self, a, b, name, joint)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name}>"

    @property
    @abstractmethod
    def initial(self) -> float:
        """Value at the initial pose, m or rad."""

    @property
    def turns_a(self) -> bool:
        """Whether the orientation of frame a matters."""
        return True

    @property
    def turns_b(self) -> bool:
        """Whether the orientation of frame b matters."""
        return False

    def same_as(self, other: Coordinate) -> bool:
        """Return whether another coordinate is the same function of the same frames."""
        return (
            type(self) is type(other)
            and getattr(self, "axis", None) == getattr(other, "axis", None)
            and same_frame(self.a, other.a, self.turns_a)
            and same_frame(self.b, other.b, self.turns_b)
        )


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Angle(Coordinate):
    """The turn of b against a about the z axis of a, ``atan2(y_a . x_b, x_a . x_b)``, rad.

    It is 0 where the x axes agree and runs on over many turns without a jump. Something has to
    keep the x axis of b away from the z axis of a; the joints that have an angle do.
    """

    unit: ClassVar[str] = "rad"
    force_unit: ClassVar[str] = "N m"

    @property
    def initial(self) -> float:
        """Value at the initial pose in (-pi, pi], rad."""
        A, x = self.a.A, self.b.A[:, 0]
        return float(np.arctan2(A[:, 1] @ x, A[:, 0] @ x))

    @property
    def turns_b(self) -> bool:
        """Whether the orientation of frame b matters."""
        return True


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Displacement(Coordinate):
    """The displacement of b along an axis of a, ``axis . (r_b - r_a)``, m.

    Parameters
    ----------
    a, b : Marker
        The frames; not both on one rigid body.
    axis : {"x", "y", "z"}
        Axis of frame a.
    name, joint
        As for every coordinate.
    """

    axis: str

    def __init__(
        self,
        a: Marker,
        b: Marker,
        axis: str = "z",
        *,
        name: str | None = None,
        joint: Joint | None = None,
    ) -> None:
        if axis not in AXES:
            raise InputError(Problem("displacement", f"axis is {axis!r}, must be 'x', 'y' or 'z'"))
        set_fields(self, axis=axis)
        init_coordinate(self, a, b, name, joint)

    @property
    def column(self) -> int:
        """Number of the axis: 0, 1 or 2."""
        return AXES.index(self.axis)

    @property
    def initial(self) -> float:
        """Value at the initial pose, m."""
        return float(self.a.A[:, self.column] @ (self.b.r - self.a.r))


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Distance(Coordinate):
    """The distance of the origins, ``|r_b - r_a|``, m; it must not become zero."""

    @property
    def initial(self) -> float:
        """Value at the initial pose, m."""
        return float(np.linalg.norm(self.b.r - self.a.r))

    @property
    def turns_a(self) -> bool:
        """Whether the orientation of frame a matters."""
        return False


COORDINATES: tuple[type[Coordinate], ...] = (Angle, Displacement, Distance)


@dataclass(frozen=True, eq=False)
class Line:
    """One constraint row, linear in one or two coordinates: ``sum f_i s_i = offset + signal(t)``.

    Parameters
    ----------
    coordinates : tuple of Coordinate
        One or two coordinates s_i.
    factors : tuple of float
        Their factors f_i.
    offset : float
        Constant right-hand side.
    signal : Signal, optional
        Right-hand side as a function of time (rheonomic); None for zero.
    """

    coordinates: tuple[Coordinate, ...]
    factors: tuple[float, ...]
    offset: float = 0.0
    signal: Signal | None = None

    @property
    def initial(self) -> float:
        """Sum of the factors times the coordinates at the initial pose."""
        return sum(f * s.initial for f, s in zip(self.factors, self.coordinates, strict=True))


def same_frame(one: Marker, other: Marker, axes: bool) -> bool:
    """Return whether two markers are the same point, and the same frame if `axes`."""
    return (
        one.body is other.body
        and one.node == other.node
        and np.array_equal(one.position_local, other.position_local)
        and (not axes or np.array_equal(one.axes, other.axes))
    )


def init_coordinate(
    coordinate: Coordinate, a: Marker, b: Marker, name: Any, joint: Joint | None
) -> None:
    """Check what all coordinates have in common and set the fields."""
    problems = Problems()
    kind = type(coordinate).__name__.lower()
    for key, marker in (("a", a), ("b", b)):
        check_marker(problems, kind if name is None else f"{kind} {name!r}", key, marker)
    if not (name is None or isinstance(name, str)):
        problems.add(kind, f"name is {name!r}, must be a string or None")
    problems.raise_if_any()
    label = f"{kind}({a.label}, {b.label})" if name is None else name
    if a.body is b.body and (a.node is None or a.node == b.node):
        problems.add(
            label if name is None else f"{kind} {name!r}",
            f"both markers are on {a.body.name!r}: it never changes",
        )
        problems.raise_if_any()
    set_fields(coordinate, a=a, b=b, name=label, joint=joint)


def check_coordinate(problems: Problems, where: str, name: str, value: Any) -> Coordinate | None:
    """Return `value` if it is a coordinate, else note how to get one."""
    if isinstance(value, Coordinate):
        return value
    owned = [key for key in ("angle", "displacement") if hasattr(value, key)]
    if owned and hasattr(value, "name"):
        hint = f"is the joint {value.name!r}; name a coordinate of it, {value.name}.{owned[0]}"
    else:
        hint = f"is {value!r}, must be a coordinate such as hinge.angle or Distance(a, b)"
    problems.add(where, f"{name} {hint}")
    return None
