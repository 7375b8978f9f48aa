"""Joints that keep the relative orientation: fixed, constant orientation, prismatic and planar."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

from jousto.mechanism.joints.base import (
    NO_TURN,
    PARALLEL,
    AxisJoint,
    Joint,
    NormalJoint,
    along,
    free_angle,
    held,
)
from jousto.mechanism.joints.coordinate import Angle, Coordinate, Displacement, Line


class Fixed(Joint, tag="fixed"):
    """The markers keep their relative position and orientation: 6 rows, no freedom.

    ``r_b - r_a = 0`` and three perpendicular rows (Rantalainen 2007, eq. 3.95 and 3.90)

    At the start the markers must have the same world position. They keep their relative orientation
    of the initial pose or, without `as_placed`, get equal axes.
    """

    coincident: ClassVar[bool] = True
    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = NO_TURN


class ConstantOrientation(Joint, tag="constant-orientation"):
    """The markers keep their relative orientation and move freely: 3 rows.

    ``f_a . h_b = g_a . h_b = f_a . g_b = 0`` (Rantalainen 2007, eq. 3.90)

    The markers keep their relative orientation of the initial pose or, without `as_placed`, get
    equal axes.
    """

    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = NO_TURN


class Prismatic(AxisJoint, tag="prismatic"):
    """Slide without rotation: 5 rows; the displacement along the axis is free.

    ``f_a . h_b = g_a . h_b = f_a . g_b = 0``, ``f_a . d = g_a . d = 0`` with d = r_b - r_a
    (Rantalainen 2007, eq. 3.90, 3.96 and 3.97)

    Marker b is on the axis through a at the start.
    """

    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = NO_TURN

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Rows without displacement along x and y of a."""
        return held(self, "x", "y")

    @cached_property
    def displacement(self) -> Displacement:
        """Displacement of b along the axis, m; 0 where the origins meet."""
        return along(self, "z", "displacement")

    @property
    def coordinates(self) -> tuple[Displacement]:
        """The free coordinate, the displacement along the axis."""
        return (self.displacement,)


class Planar(NormalJoint, tag="planar"):
    """Plane on plane: 3 rows; 2 displacements and the rotation in the plane are free.

    ``f_a . h_b = g_a . h_b = 0``, ``h_a . (r_b - r_a) = 0`` (Rantalainen 2007, eq. 3.96, 3.92)

    Marker b is on the plane through a at the start.
    """

    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = PARALLEL

    @cached_property
    def angle(self) -> Angle:
        """Rotation of b relative to a about the normal, rad.

        0 at the initial pose if `as_placed`.
        """
        return free_angle(self)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The free coordinates: two displacements in the plane, and the angle about its normal."""
        return self.x, self.y, self.angle
