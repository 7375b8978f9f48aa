"""Joints that turn about an axis: revolute, cylindrical, screw and universal."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jousto.errors import InputError, Problem, Problems
from jousto.mechanism.coordinate import Angle, Coordinate, Displacement, Line
from jousto.mechanism.fields import number, set_fields
from jousto.mechanism.joints.base import (
    PARALLEL,
    AxisJoint,
    Joint,
    aligned,
    along,
    free_angle,
    held,
    init_joint,
)
from jousto.mechanism.marker import Marker
from jousto.mechanism.orientation import Array, readonly, turn_onto, unit_vector

# sine of the angle by which the axes of a universal joint may miss the right angle
RIGHT_ANGLE = 1e-6


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Revolute(AxisJoint):
    """The markers share a point and an axis: 5 rows, the rotation about the axis is free.

    ``r_b - r_a = 0``, ``f_a . h_b = g_a . h_b = 0`` (Rantalainen 2007, eq. 3.95 and 3.96)

    Parameters
    ----------
    name, a, b, as_placed
        As for every joint; the markers are at one world position at the start.
    axis : (3,) array_like, optional
        Axis in the world frame at the initial pose; None for the z axis of marker a.
    """

    coincident: ClassVar[bool] = True
    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = PARALLEL

    @cached_property
    def angle(self) -> Angle:
        """Turn of b against a about the axis, rad; 0 at the initial pose if `as_placed`."""
        return free_angle(self)

    @property
    def coordinates(self) -> tuple[Angle]:
        """The angle."""
        return (self.angle,)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class SharedAxisJoint(AxisJoint):
    """A joint that keeps one axis for both markers, with a turn about and a way along it."""

    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = PARALLEL

    @cached_property
    def angle(self) -> Angle:
        """Turn of b against a about the axis, rad; 0 at the initial pose if `as_placed`."""
        return free_angle(self)

    @cached_property
    def displacement(self) -> Displacement:
        """Displacement of b along the axis, m; 0 where the origins meet."""
        return along(self, "z", "displacement")

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The displacement and the angle."""
        return self.displacement, self.angle


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Cylindrical(SharedAxisJoint):
    """The markers share an axis: 4 rows, turning about it and sliding along it are free.

    ``f_a . h_b = g_a . h_b = 0``, ``f_a . d = g_a . d = 0`` (Rantalainen 2007, eq. 3.96, 3.97)

    Parameters
    ----------
    name, a, b, as_placed
        As for every joint; b is on the axis through a at the start.
    axis : (3,) array_like, optional
        Axis in the world frame at the initial pose; None for the z axis of marker a.
    """

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """No displacement along x and y of a."""
        return held(self, "x", "y")


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Screw(SharedAxisJoint):
    """A cylindrical joint with a thread: 5 rows, ``s - s0 = pitch (phi - phi0) / 2 pi``.

    Index 0 is the initial pose.

    Parameters
    ----------
    name, a, b, as_placed
        As for every joint; b is on the axis through a at the start.
    pitch : float
        Displacement in one turn, m; negative for a left-hand thread.
    axis : (3,) array_like, optional
        Axis in the world frame at the initial pose; None for the z axis of marker a.
    """

    pitch: float

    def __init__(
        self,
        name: str,
        a: Marker,
        b: Marker,
        pitch: float,
        axis: ArrayLike | None = None,
        *,
        as_placed: bool = True,
    ) -> None:
        problems = Problems()
        value = number(problems, f"joint {name!r}", "pitch", pitch)
        if value == 0.0:
            problems.add(f"joint {name!r}", "pitch is 0, it cannot slide; use Revolute")
        set_fields(self, pitch=value)
        init_joint(self, name, a, b, as_placed, problems, axis=axis)

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """No displacement along x and y of a; the thread."""
        s, phi = self.displacement, self.angle
        ratio = self.pitch / (2 * np.pi)
        offset = s.initial - ratio * phi.initial
        return (*held(self, "x", "y"), Line((s, phi), (1.0, -ratio), offset))


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Universal(Joint):
    """A cardan joint: a point and a right angle between two axes: 4 rows.

    ``r_b - r_a = 0``, ``h_a . h_b = 0`` (Rantalainen 2007, eq. 3.95 and 3.90): the cross turns
    about h_a against a by `angle1`, and b against the cross about h_b by `angle2`.

    Parameters
    ----------
    name, a, b, as_placed
        As for every joint; the markers are at one world position at the start.
    axis_a : (3,) array_like, optional
        Axis h_a of the cross in a, world frame at the initial pose; None for the z axis of a.
    axis_b : (3,) array_like, optional
        Axis h_b of the cross in b, world frame at the initial pose, at a right angle to h_a;
        None for the x axis of a, turned with its z axis onto h_a. Without `as_placed` h_b is
        the z axis of marker b.
    """

    coincident: ClassVar[bool] = True
    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = ((2, 2),)
    axis_a: Array | None
    axis_b: Array | None

    def __init__(
        self,
        name: str,
        a: Marker,
        b: Marker,
        axis_a: ArrayLike | None = None,
        axis_b: ArrayLike | None = None,
        *,
        as_placed: bool = True,
    ) -> None:
        init_joint(self, name, a, b, as_placed, axis_a=axis_a, axis_b=axis_b)
        if self.axis_b is not None:
            h = self.a.A[:, 2] if self.axis_a is None else unit_vector(self.axis_a)
            sine = float(h @ unit_vector(self.axis_b))
            if abs(sine) > RIGHT_ANGLE:
                angle = np.degrees(np.arccos(np.clip(sine, -1, 1)))
                raise InputError(
                    Problem(
                        f"joint {name!r}",
                        f"the axes are at {angle:.6g} deg to each other, must be at 90 deg; "
                        "leave axis_b out to have one chosen",
                    )
                )

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers a and b with z axes along h_a and h_b; x of a along h_b if `as_placed`."""
        if not self.as_placed:
            return self.a, self.b
        frame = self.a.A if self.axis_a is None else turn_onto(self.a.A, self.axis_a)
        h = frame[:, 2]
        x = frame[:, 0] if self.axis_b is None else unit_vector(self.axis_b)
        x = unit_vector(x - (h @ x) * h)
        cross = np.stack([x, np.cross(h, x), h], axis=1)
        return aligned(self.a, cross), aligned(self.b, cross[:, [1, 2, 0]])

    @cached_property
    def angle1(self) -> Angle:
        """Turn of the cross against a about h_a, rad; 0 where h_b is the x axis of a."""
        a, b = self.frames
        return Angle(a, reordered(b, Z_FIRST), name=f"{self.name}.angle1", joint=self)

    @cached_property
    def angle2(self) -> Angle:
        """Turn of b against the cross about h_b, rad; 0 where h_a is the y axis of b."""
        a, b = self.frames
        # seen from b, h_a turns about -h_b by the same angle
        back = reordered(b, Y_FIRST_BACK)
        return Angle(back, reordered(a, Z_FIRST), name=f"{self.name}.angle2", joint=self)

    @property
    def coordinates(self) -> tuple[Angle, Angle]:
        """The angles about h_a and h_b."""
        return self.angle1, self.angle2


# new axes in columns, in terms of the old ones: (z, x, y) and (y, x, -z)
Z_FIRST = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
Y_FIRST_BACK = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])


def reordered(marker: Marker, axes: Array) -> Marker:
    """Return the marker with axes (3, 3) given in its own."""
    return Marker(
        marker.body,
        marker.point,
        marker.position_local,
        marker.node,
        readonly(marker.axes @ axes),
    )
