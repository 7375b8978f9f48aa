"""Joints between directions: parallel axes and perpendicular axes."""

from __future__ import annotations

from functools import cached_property
from typing import ClassVar

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.rotations import Direction, turn_onto, unit_vector
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import PARALLEL, AxisJoint, Joint, aligned, free_angle
from jousto.mechanism.joints.coordinate import Angle

# largest sine of the deviation of two axes from the right angle
RIGHT_ANGLE = 1e-6


class ParallelAxes(AxisJoint, tag="parallel-axes"):
    """An axis of a stays parallel to an axis of b: 2 rows.

    One rotation and 3 displacements are free.

    ``f_a . h_b = g_a . h_b = 0`` (constraint p1, Rantalainen 2007, eq. 3.96)

    With `Spherical` it makes a revolute joint, with `PointOnLine` a cylindrical one, with
    `PointOnPlane` a planar one.
    """

    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = PARALLEL

    @cached_property
    def angle(self) -> Angle:
        """Rotation of b relative to a about the axis, rad; 0 at the initial pose if `as_placed`."""
        return free_angle(self)

    @property
    def coordinates(self) -> tuple[Angle]:
        """The free coordinate, the angle about the axis."""
        return (self.angle,)


class CrossedAxes(Joint):
    """A joint that keeps an axis of a at a right angle to an axis of b."""

    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = ((2, 2),)
    axis_a: Direction = field(
        "Axis h_a in a, world frame at the initial pose; None for the z axis of a",
        default=None,
    )
    axis_b: Direction = field(
        "Axis h_b in b, world frame at the initial pose, at a right angle to h_a; "
        "None for the x axis of a, turned with its z axis onto h_a. Without `as_placed` h_b is "
        "the z axis of marker b",
        default=None,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report axes that are not perpendicular."""
        super().consistent(problems, where)
        if self.axis_b is None:
            return
        h = self.a.A[:, 2] if self.axis_a is None else unit_vector(self.axis_a)
        sine = float(h @ unit_vector(self.axis_b))
        if abs(sine) > RIGHT_ANGLE:
            angle = np.degrees(np.arccos(np.clip(sine, -1, 1)))
            problems.add(
                where,
                f"the axes are at {angle:.6g} deg to each other, must be at 90 deg; leave axis_b "
                f"out to use a perpendicular one",
            )

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers a and b with z axes along h_a and h_b; x of a along h_b if `as_placed`."""
        if not self.as_placed:
            return self.a, self.b
        frame = self.a.A if self.axis_a is None else turn_onto(self.a.A, self.axis_a)
        h = frame[:, 2]
        x: Array = frame[:, 0] if self.axis_b is None else unit_vector(self.axis_b)
        x = unit_vector(x - (h @ x) * h)
        cross = np.stack([x, np.cross(h, x), h], axis=1)
        return aligned(self.a, cross), aligned(self.b, cross[:, [1, 2, 0]])


class Perpendicular(CrossedAxes, tag="perpendicular"):
    """An axis of a stays perpendicular to an axis of b: 1 row.

    ``h_a . h_b = 0`` (constraint d1, Rantalainen 2007, eq. 3.90)

    With `Spherical` it makes a universal joint.
    """
