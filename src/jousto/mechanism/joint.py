"""Joints connect marker a to marker b; both are full frames.

A joint is a composition of few constraint rows: coincidence (3 rows), parallel (2 rows)
and perpendicular (1 row). `frames` gives the two markers turned so that their axes agree at
the initial pose; the z axis is the axis of the joint.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, TypeAlias

from numpy.typing import ArrayLike

from jousto.errors import InputError, Problems
from jousto.mechanism.fields import check_name, set_fields
from jousto.mechanism.marker import Marker, as_marker
from jousto.mechanism.orientation import (
    Array,
    parse_direction,
    readonly,
    turn_onto,
    unit_vector,
)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Spherical:
    """The origins of the two markers stay together: 3 rows, 3 rotations free.

    ``r_b - r_a = 0`` (Rantalainen 2007, eq. 3.95)

    Parameters
    ----------
    name : str
        Name, unique among the joints.
    a, b : Marker
        Markers on two different bodies, at the same world position at the start.
    """

    rows: ClassVar[int] = 3
    name: str
    a: Marker
    b: Marker

    def __init__(self, name: str, a: Marker, b: Marker) -> None:
        init_joint(self, name, a, b, {})

    def __repr__(self) -> str:
        return joint_repr(self)

    @property
    def frames(self) -> tuple[Marker, Marker]:
        """The two markers as given."""
        return self.a, self.b


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Revolute:
    """The markers share a point and an axis: 5 rows, the rotation about the axis is free.

    ``r_b - r_a = 0``, ``f_a . h_b = g_a . h_b = 0`` (Rantalainen 2007, eq. 3.95 and 3.96)

    Parameters
    ----------
    name : str
        Name, unique among the joints.
    a, b : Marker
        Markers on two different bodies, at the same world position at the start.
    axis : (3,) array_like, optional
        Axis in the world frame at the initial pose; None for the z axis of marker a.
    """

    rows: ClassVar[int] = 5
    name: str
    a: Marker
    b: Marker
    axis: Array | None

    def __init__(self, name: str, a: Marker, b: Marker, axis: ArrayLike | None = None) -> None:
        problems = Problems()
        direction = None
        if axis is not None:
            direction = parse_direction(problems, f"joint {name!r}", "axis", axis)
        init_joint(self, name, a, b, {"axis": direction}, problems)

    def __repr__(self) -> str:
        return joint_repr(self)

    @property
    def axis_world(self) -> Array:
        """Unit vector (3,) of the axis at the initial pose, world frame."""
        if self.axis is None:
            return readonly(self.a.A[:, 2])
        return readonly(unit_vector(self.axis))

    @property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers a and b with equal world axes at the initial pose, z along the axis."""
        frame = self.a.A if self.axis is None else turn_onto(self.a.A, self.axis)
        return aligned(self.a, frame), aligned(self.b, frame)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Fixed:
    """The markers keep the relative orientation of the initial pose: 6 rows, nothing free.

    ``r_b - r_a = 0`` and three perpendicular rows (Rantalainen 2007, eq. 3.95 and 3.90)

    Parameters
    ----------
    name : str
        Name, unique among the joints.
    a, b : Marker
        Markers on two different bodies, at the same world position at the start.
    """

    rows: ClassVar[int] = 6
    name: str
    a: Marker
    b: Marker

    def __init__(self, name: str, a: Marker, b: Marker) -> None:
        init_joint(self, name, a, b, {})

    def __repr__(self) -> str:
        return joint_repr(self)

    @property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers a and b with equal world axes at the initial pose, those of a."""
        return self.a, aligned(self.b, self.a.A)


Joint: TypeAlias = Spherical | Revolute | Fixed
JOINTS: tuple[type[Joint], ...] = (Spherical, Revolute, Fixed)


def aligned(marker: Marker, frame: Array) -> Marker:
    """Return the marker with the world axes `frame` (3, 3) at the initial pose."""
    axes = readonly(marker.carrier.T @ frame)
    return Marker(marker.body, marker.point, marker.position_local, marker.node, axes)


def joint_repr(joint: Joint) -> str:
    """Return ``<Spherical 'pivot': ground.origin - arm.start>``."""
    return f"<{type(joint).__name__} {joint.name!r}: {joint.a.label} - {joint.b.label}>"


def init_joint(
    joint: Joint,
    name: str,
    a: Marker,
    b: Marker,
    extra: dict[str, Array | None],
    problems: Problems | None = None,
) -> None:
    """Check what all joints have in common and set the fields."""
    problems = problems or Problems()
    where = check_name(problems, "joint", name)
    for key, marker in (("a", a), ("b", b)):
        try:
            as_marker(where, key, marker)
        except InputError as error:
            problems.found.extend(error.problems)
    problems.raise_if_any()
    set_fields(joint, name=name, a=a, b=b, **extra)
