"""Joints that hold points: spherical, on a line, on a plane, at a distance."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from jousto.errors import Problems
from jousto.mechanism.coordinate import Displacement, Distance, Line
from jousto.mechanism.fields import number, set_fields
from jousto.mechanism.joints.base import (
    AxisJoint,
    Joint,
    NormalJoint,
    along,
    held,
    init_joint,
)
from jousto.mechanism.marker import Marker


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Spherical(Joint):
    """The origins of the two markers stay together: 3 rows, 3 rotations free.

    ``r_b - r_a = 0`` (Rantalainen 2007, eq. 3.95)

    Parameters
    ----------
    name, a, b, as_placed
        As for every joint; the markers are at one world position at the start.
    """

    coincident: ClassVar[bool] = True

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """The two markers as given."""
        return self.a, self.b


@dataclass(frozen=True, eq=False, init=False, repr=False)
class PointOnLine(AxisJoint):
    """The origin of b stays on the line through a: 2 rows, sliding and 3 rotations free.

    ``f_a . d = g_a . d = 0``, ``d = r_b - r_a`` (Rantalainen 2007, eq. 3.97)

    Parameters
    ----------
    name, a, b, as_placed
        As for every joint; b is on the line at the start.
    axis : (3,) array_like, optional
        Direction of the line in the world frame at the initial pose, fixed to a; None for the
        z axis of marker a.
    """

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """No displacement along x and y of a."""
        return held(self, "x", "y")

    @cached_property
    def displacement(self) -> Displacement:
        """Displacement of b along the line, m."""
        return along(self, "z", "displacement")

    @property
    def coordinates(self) -> tuple[Displacement]:
        """The displacement."""
        return (self.displacement,)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class PointOnPlane(NormalJoint):
    """The origin of b stays on the plane through a: 1 row.

    ``h_a . (r_b - r_a) = 0`` (Rantalainen 2007, eq. 3.92)

    Parameters
    ----------
    name, a, b, as_placed
        As for every joint; b is on the plane at the start.
    normal : (3,) array_like, optional
        Normal of the plane in the world frame at the initial pose, fixed to a; None for the
        z axis of marker a.
    """


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Rod(Joint):
    """The origins keep their distance, a massless rod with spherical ends: 1 row.

    ``|r_b - r_a| = L``

    Parameters
    ----------
    name, a, b, as_placed
        As for every joint.
    length : float, optional
        Distance L, m, more than zero; None for the distance at the initial pose.
    """

    length: float | None

    def __init__(
        self,
        name: str,
        a: Marker,
        b: Marker,
        length: float | None = None,
        *,
        as_placed: bool = True,
    ) -> None:
        problems = Problems()
        value = None if length is None else number(problems, f"joint {name!r}", "length", length)
        if value is not None and value <= 0:
            problems.add(
                f"joint {name!r}",
                f"length is {value:g} m, must be positive; Spherical joins two points",
            )
        set_fields(self, length=value)
        init_joint(self, name, a, b, as_placed, problems)

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """The two markers as given."""
        return self.a, self.b

    @cached_property
    def distance(self) -> Distance:
        """Distance of the origins, m; constant."""
        return Distance(self.a, self.b, name=f"{self.name}.distance", joint=self)

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """The distance is the length."""
        length = self.distance.initial if self.length is None else self.length
        return (Line((self.distance,), (1.0,), length),)
