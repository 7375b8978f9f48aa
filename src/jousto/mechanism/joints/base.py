"""Base of all joints: markers, frames along the joint's axes, constraint rows as data.

A joint is composed of few constraint rows, in this order:

* coincidence, ``r_b - r_a = 0`` (3 rows, world axes);
* perpendicular pairs, ``(axis i of a) . (axis j of b) = 0`` (1 row each);
* lines, relations that are linear in coordinates of the joint (1 row each).

A new joint is one class with the first two as tuples, and with the property `lines` if it has
linear rows.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import ClassVar

from jousto.base.arrays import Array, frozen, read_only, transposed
from jousto.base.complexstep import floats, is_stepping
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Flag, Name, field
from jousto.base.rotations import Direction, turn_each_onto, turn_onto
from jousto.mechanism.bodies.marker import Marker, MarkerField, carriers
from jousto.mechanism.joints.coordinate import AXES, Angle, Coordinate, Displacement, Line

# perpendicular pairs (axis of a, axis of b); x, y, z = 0, 1, 2
PARALLEL = ((0, 2), (1, 2))
NO_TURN = ((0, 2), (1, 2), (0, 1))


class Joint(Declared, section="joints"):
    """Constraint rows between marker a and marker b, both full frames.

    Attributes
    ----------
    coincident : bool
        Whether the origins of the markers stay together (3 rows).
    perpendicular : tuple of (int, int)
        Pairs of an axis of frame a and an axis of frame b that stay perpendicular (1 row each).
    lines : tuple of Line
        Linear relations of coordinates (1 row each).
    frames : tuple of two Marker
        The markers with the joint's axes.
    rows : int
        Number of constraint rows.
    """

    kind = "joint"
    coincident: ClassVar[bool] = False
    perpendicular: ClassVar[tuple[tuple[int, int], ...]] = ()
    name: Name = field("Unique among joints, couplings and drives")
    a: MarkerField = field("First marker")
    b: MarkerField = field("Second marker, on another body")
    as_placed: Flag = field(
        "True: the joint takes its directions from the initial pose, in which the markers must "
        "already fit. False: the joint uses the axes of the markers, z as its axis, and the "
        "initial pose may be rough: it is moved and rotated until the markers fit",
        default=True,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report directions that have no effect."""
        for key, kind in self.fields.items():
            if (
                not self.as_placed
                and isinstance(kind, Direction)
                and getattr(self, key) is not None
            ):
                problems.add(
                    where,
                    f"{key} is a direction at the initial pose; with as_placed=False the joint "
                    f"uses the z axes of the markers, leave {key} out and rotate the markers",
                )

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name!r}: {self.a.label} - {self.b.label}>"

    @property
    def direction(self) -> Array | None:
        """World direction (3,) of the z axes at the initial pose.

        None for the z axis of marker a.
        """
        return None

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers with axes along those of the joint; equal at the initial pose if `as_placed`."""
        if not self.as_placed:
            return self.a, self.b
        frame = self.a.A if self.direction is None else turn_onto(self.a.A, self.direction)
        return aligned(self.a, frame), aligned(self.b, frame)

    @property
    def axis_world(self) -> Array:
        """Unit vector (3,) of the z axes at the initial pose, world frame."""
        return read_only(self.frames[0].A[:, 2])

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Linear rows: relations of coordinates."""
        return ()

    @property
    def rows(self) -> int:
        """Number of constraint rows."""
        return 3 * self.coincident + len(self.perpendicular) + len(self.lines)

    @property
    def row_names(self) -> tuple[str, ...]:
        """Motion that each row prevents, for messages: ``"turn about x"``, ``"displacement y"``."""
        names = [f"displacement {x}" for x in AXES] if self.coincident else []
        # the row of axes i and j prevents the rotation about the third axis
        names += [f"turn about {AXES[3 - i - j]}" for i, j in self.perpendicular if i != j]
        names += ["turn about the normal of both axes" for i, j in self.perpendicular if i == j]
        for line in self.lines:
            parts = [s.name.removeprefix(f"{self.name}.") for s in line.coordinates]
            names.append(" with ".join(parts))
        return tuple(names)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Free coordinates of the joint that have names."""
        return ()

    @property
    def held(self) -> tuple[Coordinate, ...]:
        """Coordinates that the rows keep constant, which have names too."""
        return ()

    @property
    def turns(self) -> tuple[bool, bool]:
        """Whether the rows depend on the orientations of a and b."""
        used = [s for line in self.lines for s in line.coordinates]
        both = bool(self.perpendicular)
        return both or any(s.turns_a for s in used), both or any(s.turns_b for s in used)


AXIS = "Axis in the world frame at the initial pose; None for the z axis of marker a"


class AxisJoint(Joint):
    """A joint with a z axis, whose direction may be given."""

    axis: Direction = field(AXIS, default=None)

    @property
    def direction(self) -> Array | None:
        """World direction (3,) of the axis at the initial pose; None for the z axis of a."""
        return self.axis


class NormalJoint(Joint):
    """A joint that keeps the origin of b in a plane through a; the normal may be given."""

    normal: Direction = field(
        "Normal of the plane in the world frame at the initial pose, fixed to a; None for the z "
        "axis of marker a",
        default=None,
    )

    @property
    def direction(self) -> Array | None:
        """World direction (3,) of the normal at the initial pose; None for the z axis of a."""
        return self.normal

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Row without displacement along the normal."""
        return held(self, "z")

    @cached_property
    def x(self) -> Displacement:
        """Displacement of b along the x axis of the frame of a, m."""
        return along(self, "x")

    @cached_property
    def y(self) -> Displacement:
        """Displacement of b along the y axis of the frame of a, m."""
        return along(self, "y")

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The two displacements in the plane."""
        return self.x, self.y


def free_angle(joint: Joint) -> Angle:
    """Return the angle coordinate of a joint about the z axis of its frames."""
    return Angle(*joint.frames, name=f"{joint.name}.angle", joint=joint)


def along(joint: Joint, axis: str, name: str | None = None) -> Displacement:
    """Return the displacement coordinate of a joint along an axis of its frames."""
    return Displacement(*joint.frames, axis, name=f"{joint.name}.{name or axis}", joint=joint)


def held(joint: Joint, *axes: str) -> tuple[Line, ...]:
    """Return the rows that keep the displacements along given axes of the frames at zero."""
    return tuple(Line((along(joint, axis),), (1.0,)) for axis in axes)


def aligned(marker: Marker, frame: Array) -> Marker:
    """Return the marker with axes equal to the world axes `frame` (3, 3) at the initial pose."""
    return with_axes(marker, read_only(marker.carrier.T @ frame))


def align_frames(joints: Iterable[Joint]) -> None:
    """Compute and cache the frames of all joints at once.

    `Joint.frames` computes those of one joint.
    """
    found = [
        joint
        for joint in joints
        if joint.as_placed and type(joint).frames is Joint.frames and "frames" not in vars(joint)
    ]
    if not found or is_stepping():
        return
    sides = [joint.a for joint in found], [joint.b for joint in found]
    carrier_a, carrier_b = (carriers(markers) for markers in sides)
    frames = carrier_a @ floats([marker.axes for marker in sides[0]])
    given = [i for i, joint in enumerate(found) if joint.direction is not None]
    axes = floats([found[i].direction for i in given]).reshape(-1, 3)
    frames[given] = turn_each_onto(frames[given], axes)
    axes_a, axes_b = (frozen(transposed(A) @ frames) for A in (carrier_a, carrier_b))
    for joint, x, y in zip(found, axes_a, axes_b, strict=True):
        vars(joint)["frames"] = with_axes(joint.a, x), with_axes(joint.b, y)


def with_axes(marker: Marker, axes: Array) -> Marker:
    """Return the marker with axes (3, 3) relative to its body frame."""
    given = marker.body, marker.point, marker.position_local, marker.node
    return Marker(*given, axes, marker.followed)
