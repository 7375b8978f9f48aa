"""Joints between points: coincident, on a line, on a plane, at a constant distance."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

from jousto.base.fields import field
from jousto.base.numbers import OptionalNumber
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import AxisJoint, Joint, NormalJoint, along, held
from jousto.mechanism.joints.coordinate import Displacement, Distance, Line


class Spherical(Joint, tag="spherical"):
    """The origins of the two markers stay together: 3 rows, 3 rotations free.

    ``r_b - r_a = 0`` (Rantalainen 2007, eq. 3.95)

    At the start the markers must have the same world position.
    """

    coincident: ClassVar[bool] = True

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """The two markers, unchanged."""
        return self.a, self.b


class PointOnLine(AxisJoint, tag="point-on-line"):
    """The origin of b stays on the line through a: 2 rows, sliding and 3 rotations free.

    ``f_a . d = g_a . d = 0``, ``d = r_b - r_a`` (Rantalainen 2007, eq. 3.97)

    Marker b is on the line at the start.
    """

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Rows without displacement along x and y of a."""
        return held(self, "x", "y")

    @cached_property
    def displacement(self) -> Displacement:
        """Displacement of b along the line, m."""
        return along(self, "z", "displacement")

    @property
    def coordinates(self) -> tuple[Displacement]:
        """The free coordinate, the displacement along the line."""
        return (self.displacement,)


class PointOnPlane(NormalJoint, tag="point-on-plane"):
    """The origin of b stays on the plane through a: 1 row.

    ``h_a . (r_b - r_a) = 0`` (Rantalainen 2007, eq. 3.92)

    Marker b is on the plane at the start.
    """


class Rod(Joint, tag="rod"):
    """Rod: the origins keep their distance, as joined by a massless rod with spherical ends: 1 row.

    ``|r_b - r_a| = L``
    """

    length: OptionalNumber = field(
        "Distance L; None for the distance at the initial pose",
        unit="m",
        above=0,
        default=None,
        remedy="use Spherical to join two points",
    )

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """The two markers, unchanged."""
        return self.a, self.b

    @cached_property
    def distance(self) -> Distance:
        """Distance of the origins, m; constant."""
        return Distance(self.a, self.b, name=f"{self.name}.distance", joint=self)

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """The distance equals the length."""
        length = self.distance.initial if self.length is None else self.length
        return (Line((self.distance,), (1.0,), length),)
