"""Joint of a conical wheel that rolls on a rail."""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar, Protocol

import numpy as np

from jousto.base.complexstep import scalar
from jousto.base.errors import Problems
from jousto.base.fields import Flag, field
from jousto.base.numbers import Number
from jousto.base.rotations import Direction, turn_onto
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import Joint, aligned
from jousto.mechanism.joints.coordinate import Coordinate, Line

ALONG = 0.1
"""Sine of the angle between rail and top, or cosine between rail and axle, that is an error."""
STEEP = 1.0
"""Largest conicity."""


class RailCoordinate(Coordinate):
    """Base of the coordinates of a conical wheel b on a rail a: x of a along the rail, z its top.

    The axle is the z axis of b.
    """

    radius: Number = field("Radius of the wheel at marker b", unit="m", above=0)
    cone: Number = field("Conicity", unit="1", default=0.0)
    head: Number = field("Radius of the head of the rail", unit="m", least=0, default=0.0)

    @property
    def turns_b(self) -> bool:
        """Whether the coordinate depends on the orientation of frame b."""
        return True

    @property
    def key(self) -> tuple[Any, ...]:
        """Key that is equal for the same wheel on the same rail."""
        sizes = (float(np.real(x)) for x in (self.radius, self.cone, self.head))
        return (*super().key, *sizes)


class RailGap(RailCoordinate):
    """Distance between tread and head of the rail, m."""

    engine: ClassVar[str] = "rail gap"

    @property
    def initial(self) -> float:
        """Value at the initial pose, m."""
        x, k, n = self.a.A[:, 0], self.a.A[:, 2], self.b.A[:, 2]
        start = self.a.r - self.head * k - self.b.r
        c = x @ n
        e = np.sqrt(1.0 - c * c)
        u = (x - c * n) / e
        h = start - (start @ n) * n - (start @ u) * u
        share = self.cone * c / e
        far = np.sqrt(h @ h) / np.sqrt(1.0 - share * share)
        y = (start + (far * share - start @ u) / e * x) @ n
        lean = np.sqrt(1.0 + self.cone**2)
        return scalar((far - self.radius - self.cone * y) / lean - self.head)


class RailRolled(RailCoordinate):
    """Velocity of the point of contact of the wheel along the rail; its value is 0."""

    engine: ClassVar[str] = "rail rolled"

    @property
    def initial(self) -> float:
        """0."""
        return 0.0


class RailAcross(RailRolled):
    """The same across the rail, in the plane of contact."""

    engine: ClassVar[str] = "rail across"


class OnRail(Protocol):
    """A wheel b on a rail a with directions of rail and axle."""

    a: Any
    b: Any
    rail: Any
    axle: Any


def frames_of(wheel: OnRail) -> tuple[Marker, Marker]:
    """Return markers with x along the rail and z up, and with z along the axle."""
    a, b = wheel.a, wheel.b
    if wheel.rail is not None:
        x, up = np.asarray(wheel.rail), a.A[:, 2]
        x = x / np.sqrt(x @ x)
        z = up - (up @ x) * x
        z = z / np.sqrt(z @ z)
        a = aligned(a, np.stack([x, np.cross(z, x), z], axis=1))
    if wheel.axle is not None:
        b = aligned(b, turn_onto(b.A, wheel.axle))
    return a, b


class RailWheel(Joint, tag="rail-wheel"):
    """A conical wheel that rolls on a straight rail without slip along it: 2 rows, or 3.

    The head of the rail is a cylinder of radius `head` along it, an edge for 0; its top is the
    origin of a. The radius of the tread is ``radius + cone y`` at the distance y along the axle
    from marker b. Rows: the gap between tread and head is 0, the velocity of the point of contact
    along the rail is 0, and with `across` that across the rail, too (nonholonomic).

    A wheelset is one body with two of them, with the conicity l and -l, one of them with `across`:
    it sways with Klingel's wavelength ``2 pi sqrt(radius s / l)``, s half the distance of the
    points of contact (A. H. Wickens, Fundamentals of Rail Vehicle Dynamics, 2003, chapter 2).

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> axle = RigidBody("axle", 1000.0, (600, 80, 600), position=(0, 0, 0.46))
    >>> rail = ground.at((0, 0.75, 0))
    >>> RailWheel("left", rail, axle.at((0, 0.75, 0)), 0.46, -0.05, axle=(0, 1, 0))
    <RailWheel 'left': ground.at(0, 0.75, 0) - axle.at(0, 0.75, 0)>
    """

    radius: Number = field("Radius of the tread at marker b", unit="m", above=0)
    cone: Number = field(
        "Conicity: increase of the radius along the axle over the length; 0 for a cylinder",
        unit="1",
        least=-STEEP,
        most=STEEP,
        default=0.0,
    )
    head: Number = field(
        "Radius of the head of the rail; 0 for an edge",
        unit="m",
        least=0,
        default=0.0,
        kw_only=True,
    )
    across: Flag = field("Whether it does not slip across the rail", default=False, kw_only=True)
    rail: Direction = field(
        "Direction of the rail in the world frame at the initial pose, fixed to a; None for the x "
        "axis of marker a",
        default=None,
        kw_only=True,
    )
    axle: Direction = field(
        "Axle n in the world frame at the initial pose, fixed to b; None for the z axis of "
        "marker b",
        default=None,
        kw_only=True,
    )

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers with x along the rail and z up, and with z along the axle."""
        return frames_of(self)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a rail along its top or along the axle."""
        super().consistent(problems, where)
        if self.rail is not None:
            x, up = np.real(np.asarray(self.rail)), np.real(self.a.A[:, 2])
            if np.linalg.norm(np.cross(x, up)) < ALONG * np.linalg.norm(x):
                problems.add(where, "the rail is along the z axis of marker a, its top", "rail")
                return
        a, b = self.frames
        if abs(float(np.real(a.A[:, 0] @ b.A[:, 2]))) > 1.0 - ALONG:
            problems.add(where, "the axle is along the rail at the initial pose; turn the body")

    def _coordinate(self, kind: type[RailCoordinate], word: str) -> Any:
        sizes = (self.radius, self.cone, self.head)
        return kind(*self.frames, *sizes, name=f"{self.name}.{word}", joint=self)

    @cached_property
    def gap(self) -> RailGap:
        """Distance between tread and rail, m; constant 0."""
        return self._coordinate(RailGap, "gap")  # type: ignore[no-any-return]

    @property
    def held(self) -> tuple[Coordinate, ...]:
        """The gap."""
        return (self.gap,)

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """Rows of the gap, along, and across."""
        rows: list[RailCoordinate] = [self.gap, self._coordinate(RailRolled, "along")]
        if self.across:
            rows.append(self._coordinate(RailAcross, "across"))
        return tuple(Line((s,), (1.0,)) for s in rows)
