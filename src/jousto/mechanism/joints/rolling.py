"""Joints of discs and wheels that roll on a plane, and of blades that glide on it."""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from jousto.base.complexstep import scalar
from jousto.base.errors import Problems
from jousto.base.fields import Choice, field
from jousto.base.numbers import Number
from jousto.base.rotations import Direction, turn_onto
from jousto.mechanism.bodies.marker import Marker, MarkerField
from jousto.mechanism.joints.base import Joint, aligned
from jousto.mechanism.joints.coordinate import AXES, Coordinate, Line
from jousto.mechanism.joints.switched import UNLIMITED, SwitchedRow

FLAT = 1e-6
"""Sine of the angle between axle and normal below which a disc has no lowest point."""
LOW = 1e-9
"""Depth of a disc below the plane over its radius that counts as rounding."""
NORMAL = "Normal k of the plane in the world frame at the initial pose; None for the z axis of a"
AXLE = "Axle n in the world frame at the initial pose; None for the z axis of marker b"


def plane_frames(*sides: tuple[Marker, Any]) -> tuple[Marker, Marker]:
    """Return two markers with their z axes along given directions, or as they are for None."""
    a, b = (
        marker if given is None else aligned(marker, turn_onto(marker.A, given))
        for marker, given in sides
    )
    return a, b


def check_upright(problems: Problems, where: str, frames: tuple[Marker, Marker], what: str) -> None:
    """Report an axle, or the direction across a blade, along the normal of the plane."""
    a, b = (np.real(marker.A[:, 2]) for marker in frames)
    if float(np.linalg.norm(np.cross(a, b))) < FLAT:
        problems.add(where, f"{what} is normal to the plane at the initial pose; turn the body")


class DiscCoordinate(Coordinate):
    """Base of the coordinates of a disc b on a plane a, whose z axes are axle and normal."""

    radius: Number = field("Radius of the disc; 0 for a blade", unit="m", least=0, default=0.0)

    @property
    def turns_b(self) -> bool:
        """Whether the coordinate depends on the orientation of frame b."""
        return True

    @property
    def key(self) -> tuple[Any, ...]:
        """Key that is equal for the same disc on the same plane."""
        return (*super().key, float(np.real(self.radius)))

    @property
    def sine(self) -> Any:
        """Sine of the angle between axle and normal at the initial pose."""
        w = np.cross(self.a.A[:, 2], self.b.A[:, 2])
        return np.sqrt(w @ w)


class RimHeight(DiscCoordinate):
    """Height of the lowest point of the rim above the plane, ``k . (r_b - r_a) - R |k x n|``, m."""

    engine: ClassVar[str] = "rim"

    @property
    def initial(self) -> float:
        """Value at the initial pose, m."""
        height = self.a.A[:, 2] @ (self.b.r - self.a.r)
        return scalar(height - self.radius * self.sine)


class Rolled(DiscCoordinate):
    """Velocity of the lowest point of a disc on the plane, in its rolling direction ``n x k``.

    It is the rate of no function of the position (nonholonomic), so that the value is 0.
    """

    engine: ClassVar[str] = "rolled"

    @property
    def initial(self) -> float:
        """0."""
        return 0.0


class Across(Rolled):
    """The same along the axle, ``n - (k . n) k``."""

    engine: ClassVar[str] = "across"


class PointSlip(DiscCoordinate):
    """Velocity of the lowest point of a sphere about b on the plane of a, along an axis of a.

    The plane is normal to the z axis of a. It is the rate of no function of the position.
    """

    engine: ClassVar[str] = "slip"
    axis: Choice = field("Axis of frame a", words=AXES[:2], default="x")

    @property
    def column(self) -> int:
        """Number of the axis: 0 or 1."""
        return AXES.index(self.axis)

    @property
    def initial(self) -> float:
        """0."""
        return 0.0


class OnPlane(Joint):
    """Base of the joints of a disc, wheel or blade on a plane."""

    normal: Direction = field(
        "Normal k of the plane in the world frame at the initial pose, fixed to a; None for the z "
        "axis of marker a",
        default=None,
        kw_only=True,
    )

    @property
    def across_b(self) -> Any:
        """Direction of the axle, or across a blade, at the initial pose; None: z of marker b."""
        raise NotImplementedError

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers with z axes along the normal and along the axle."""
        return plane_frames((self.a, self.normal), (self.b, self.across_b))

    def _coordinate(self, kind: type[DiscCoordinate], word: str, radius: Any = 0.0) -> Any:
        return kind(*self.frames, radius, name=f"{self.name}.{word}", joint=self)


class _Wheel(OnPlane):
    """Base of the joints of a disc or wheel."""

    radius: Number = field("Radius R of the disc", unit="m", above=0)
    axle: Direction = field(
        "Axle n in the world frame at the initial pose, fixed to b; None for the z axis of "
        "marker b, which is at the centre",
        default=None,
        kw_only=True,
    )

    @property
    def across_b(self) -> Any:
        """The axle."""
        return self.axle

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a disc that lies flat."""
        super().consistent(problems, where)
        check_upright(problems, where, self.frames, "the axle")

    @cached_property
    def height(self) -> RimHeight:
        """Height of the lowest point of the rim above the plane, m; constant 0."""
        return self._coordinate(RimHeight, "height", self.radius)  # type: ignore[no-any-return]

    @property
    def held(self) -> tuple[Coordinate, ...]:
        """The height."""
        return (self.height,)


class DiscOnPlane(SwitchedRow, tag="disc-on-plane"):
    """A disc that touches a plane, leaves it and lands on it: one row while it touches.

    The height of the lowest point of the rim, as of `RollingDisc`, is limited by 0: a landing is an
    impact with a restitution, as of a `RigidStop`, and a disc at rest on the plane leaves it when
    the plane would have to pull. With a `Friction` on it, whose normal force is that of the plane,
    the disc rolls or slips: with `StickSlip` two more rows hold the velocity of the lowest point at
    0 up to mu_static N, then mu_kinetic N acts against its slip until that stops. Flight, landing,
    slip and rolling are events of the run.

    Examples
    --------
    >>> from jousto import Friction, RigidBody, ground
    >>> from jousto.mechanism import StickSlip
    >>> disc = RigidBody("disc", 1.0, (0.0025, 0.005, 0.0025), position=(0, 0, 0.1))
    >>> touch = DiscOnPlane("touch", ground["origin"], disc["origin"], 0.1, axle=(0, 1, 0))
    >>> grip = Friction("grip", touch, 0.2, law=StickSlip())
    """

    kind = "disc on a plane"
    together = ("a", "b", "radius")
    a: MarkerField = field("Marker of the plane")
    b: MarkerField = field("Marker at the centre of the disc, on another body")
    radius: Number = field("Radius R of the disc", unit="m", above=0)
    normal: Direction = field(NORMAL, default=None, kw_only=True)
    axle: Direction = field(AXLE, default=None, kw_only=True)
    restitution: Number = field(
        "Coefficient of restitution of a landing",
        unit="1",
        least=0,
        most=1,
        default=0.0,
        kw_only=True,
    )
    slowest: Number = field(
        "Speed of approach up to which a landing does not rebound",
        unit="m/s",
        above=0,
        default=1e-3,
        kw_only=True,
    )

    def __repr__(self) -> str:
        return f"<DiscOnPlane {self.name!r}: {self.a.label} - {self.b.label}>"

    def consistent(self, problems: Problems, where: str) -> None:
        """Report one body on both sides, a disc that lies flat, and one below the plane."""
        if self.a.body is self.b.body:
            problems.add(where, f"a and b are both on {self.a.body.name!r}; take two bodies", "b")
        check_upright(problems, where, self.frames, "the axle")
        height = float(np.real(self.height.initial))
        if height < -LOW * float(np.real(self.radius)):
            problems.add(
                where,
                f"the disc is {-height:g} m below the plane at the initial pose; move the body",
                "radius",
            )

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers with z axes along the normal and along the axle."""
        return plane_frames((self.a, self.normal), (self.b, self.axle))

    def _coordinate(self, kind: type[DiscCoordinate], word: str) -> Any:
        return kind(*self.frames, self.radius, name=f"{self.name}.{word}")

    @cached_property
    def height(self) -> RimHeight:
        """Height of the lowest point of the rim above the plane, m."""
        return self._coordinate(RimHeight, "height")  # type: ignore[no-any-return]

    @property
    def coordinate(self) -> Coordinate:
        """The height."""
        return self.height

    @cached_property
    def slips(self) -> tuple[Coordinate, ...]:
        """Coordinates whose rates are the slip of the lowest point along and across."""
        return (self._coordinate(Rolled, "along"), self._coordinate(Across, "across"))

    @property
    def numbers(self) -> dict[str, float]:
        """Limits, restitution and slowest impact."""
        return {
            "lower": 0.0,
            "upper": UNLIMITED,
            "restitution": self.restitution,
            "slowest": self.slowest,
        }


class RollingDisc(_Wheel, tag="rolling-disc"):
    """A thin disc that rolls on a plane without slip: 3 rows.

    With the normal k of the plane, the axle n of the disc and the vector ``e = -(k - (k . n) n) /
    |k x n|`` to the lowest point of its rim: ``(r_b + R e - r_a) . k = 0``, and the velocity of
    that point of the disc on the plane is zero along and across (nonholonomic rows, Géradin and
    Cardona, Flexible Multibody Dynamics, 2001). The disc tilts and turns freely: a coin.

    A `ReactionSensor` in the axes of the joint has the normal force as Fz: an `Event` that it
    falls below 0, or that the force along the plane exceeds mu Fz, may release the joint.
    """

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Rows of the height, along and across."""
        along = self._coordinate(Rolled, "along", self.radius)
        across = self._coordinate(Across, "across", self.radius)
        return tuple(Line((s,), (1.0,)) for s in (self.height, along, across))


class RollingWheel(_Wheel, tag="rolling-wheel"):
    """A wheel that rolls on a plane and may slide across, as on a rail or on castors: 2 rows.

    The rows of `RollingDisc` for the height and along the rolling direction.
    """

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Rows of the height and along."""
        along = self._coordinate(Rolled, "along", self.radius)
        return tuple(Line((s,), (1.0,)) for s in (self.height, along))


class KnifeEdge(OnPlane, tag="knife-edge"):
    """A blade that glides along itself, not across: 1 nonholonomic row, a skate or a sleigh.

    The velocity of marker b on the plane is zero along the direction across the blade.
    """

    across: Direction = field(
        "Direction across the blade in the world frame at the initial pose, fixed to b; None for "
        "the z axis of marker b",
        default=None,
    )

    @property
    def across_b(self) -> Any:
        """The direction across the blade."""
        return self.across

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a blade that is held nowhere in the plane."""
        super().consistent(problems, where)
        check_upright(problems, where, self.frames, "the direction across the blade")

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """The row across."""
        return (Line((self._coordinate(Across, "across"),), (1.0,)),)
