"""Joints of discs and wheels that roll on a plane, and of blades that glide on it."""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from jousto.base.complexstep import scalar
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.base.rotations import Direction, turn_onto
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import Joint, aligned
from jousto.mechanism.joints.coordinate import Coordinate, Line

FLAT = 1e-6
"""Sine of the angle between axle and normal below which a disc has no lowest point."""


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
        made = []
        for marker, given in ((self.a, self.normal), (self.b, self.across_b)):
            frame = marker.A if given is None else turn_onto(marker.A, given)
            made.append(marker if given is None else aligned(marker, frame))
        return made[0], made[1]

    def _coordinate(self, kind: type[DiscCoordinate], word: str, radius: Any = 0.0) -> Any:
        return kind(*self.frames, radius, name=f"{self.name}.{word}", joint=self)

    def _check_upright(self, problems: Problems, where: str, what: str) -> None:
        a, b = self.frames
        if float(np.linalg.norm(np.cross(np.real(a.A[:, 2]), np.real(b.A[:, 2])))) < FLAT:
            problems.add(where, f"{what} is normal to the plane at the initial pose; turn the body")


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
        self._check_upright(problems, where, "the axle")

    @cached_property
    def height(self) -> RimHeight:
        """Height of the lowest point of the rim above the plane, m; constant 0."""
        return self._coordinate(RimHeight, "height", self.radius)  # type: ignore[no-any-return]


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
        self._check_upright(problems, where, "the direction across the blade")

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """The row across."""
        return (Line((self._coordinate(Across, "across"),), (1.0,)),)
