"""Joints with a rotation about an axis: revolute, cylindrical, screw and universal."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import ClassVar

import numpy as np

from jousto.base.arrays import Array, read_only
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.base.rotations import Direction
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import (
    AXIS,
    PARALLEL,
    AxisJoint,
    Joint,
    along,
    free_angle,
    held,
)
from jousto.mechanism.joints.coordinate import Angle, Coordinate, Displacement, Line
from jousto.mechanism.joints.directions import CrossedAxes


class Revolute(AxisJoint, tag="revolute"):
    """The markers share a point and an axis: 5 rows, the rotation about the axis is free.

    ``r_b - r_a = 0``, ``f_a . h_b = g_a . h_b = 0`` (Rantalainen 2007, eq. 3.95 and 3.96)

    At the start the markers must have the same world position.
    """

    coincident: ClassVar[bool] = True
    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = PARALLEL

    @cached_property
    def angle(self) -> Angle:
        """Rotation of b relative to a about the axis, rad; 0 at the initial pose if `as_placed`."""
        return free_angle(self)

    @property
    def coordinates(self) -> tuple[Angle]:
        """The free coordinate, the angle about the axis."""
        return (self.angle,)


class SharedAxisJoint(Joint):
    """A joint with a common axis: a rotation about it and a displacement along it."""

    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = PARALLEL

    @cached_property
    def angle(self) -> Angle:
        """Rotation of b relative to a about the axis, rad; 0 at the initial pose if `as_placed`."""
        return free_angle(self)

    @cached_property
    def displacement(self) -> Displacement:
        """Displacement of b along the axis, m; 0 where the origins meet."""
        return along(self, "z", "displacement")

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The free coordinates: displacement along the axis, angle about it."""
        return self.displacement, self.angle


class Cylindrical(SharedAxisJoint, AxisJoint, tag="cylindrical"):
    """The markers share an axis: 4 rows; rotation about it and displacement along it are free.

    ``f_a . h_b = g_a . h_b = 0``, ``f_a . d = g_a . d = 0`` (Rantalainen 2007, eq. 3.96, 3.97)

    Marker b is on the axis through a at the start.
    """

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Rows without displacement along x and y of a."""
        return held(self, "x", "y")


class Screw(SharedAxisJoint, tag="screw"):
    """Cylindrical joint with a thread: 5 rows, ``s - s0 = pitch (phi - phi0) / 2 pi``.

    Index 0 is the initial pose. Marker b is on the axis through a at the start.
    """

    pitch: Number = field(
        "Displacement in one turn; negative for a left-hand thread",
        unit="m",
        nonzero=True,
        remedy="without a pitch the joint cannot slide; use Revolute",
    )
    axis: Direction = field(AXIS, default=None)

    @property
    def direction(self) -> Array | None:
        """World direction (3,) of the axis at the initial pose; None for the z axis of a."""
        return self.axis

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Rows without displacement along x and y of a, and the relation of the thread."""
        s, phi = self.displacement, self.angle
        ratio = self.pitch / (2 * np.pi)
        offset = s.initial - ratio * phi.initial
        return (*held(self, "x", "y"), Line((s, phi), (1.0, -ratio), offset))


class Universal(CrossedAxes, tag="universal"):
    """Cardan joint, with a common point and two perpendicular axes: 4 rows.

    ``r_b - r_a = 0``, ``h_a . h_b = 0`` (Rantalainen 2007, eq. 3.95 and 3.90): the cross turns
    about h_a against a by `angle1`, and b against the cross about h_b by `angle2`.

    At the start the markers must have the same world position.
    """

    coincident: ClassVar[bool] = True

    @cached_property
    def angle1(self) -> Angle:
        """Rotation of the cross relative to a about h_a, rad; 0 where h_b is the x axis of a."""
        a, b = self.frames
        return Angle(a, reordered(b, Z_FIRST), name=f"{self.name}.angle1", joint=self)

    @cached_property
    def angle2(self) -> Angle:
        """Rotation of b relative to the cross about h_b, rad; 0 where h_a is the y axis of b."""
        a, b = self.frames
        # seen from b, h_a rotates about -h_b by the same angle
        back = reordered(b, Y_FIRST_BACK)
        return Angle(back, reordered(a, Z_FIRST), name=f"{self.name}.angle2", joint=self)

    @property
    def coordinates(self) -> tuple[Angle, Angle]:
        """The angles about h_a and h_b."""
        return self.angle1, self.angle2


# permuted axes in columns, in terms of the original ones: (z, x, y) and (y, x, -z)
Z_FIRST = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
Y_FIRST_BACK = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def reordered(marker: Marker, axes: Array) -> Marker:
    """Return the marker with axes (3, 3) relative to its present axes."""
    return replace(marker, axes=read_only(marker.axes @ axes))
