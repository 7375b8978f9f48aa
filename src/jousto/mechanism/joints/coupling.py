"""Couplings and drives: constraint rows that are linear in coordinates of joints."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Name, field
from jousto.base.numbers import Number, Numbers, OptionalNumber
from jousto.mechanism.joints.coordinate import (
    VALUE,
    Angle,
    Coordinate,
    CoordinateField,
    CoordinatesField,
    Line,
    check_coordinate,
)
from jousto.mechanism.signals.base import SignalField


class Coupler(Declared, section="couplings"):
    """A constraint row that is linear in one or two coordinates: a gear, rack, coupling or drive.

    Its multiplier lam acts on coordinate s_i as the force ``-f_i lam``, in the direction of s_i
    on the body of marker b.
    """

    kind = "coupling"
    optional: ClassVar[bool] = False
    """Whether the row acts at times only."""
    name: Name = field("Unique among joints, couplings and drives")

    def __repr__(self) -> str:
        names = ", ".join(s.name for s in self.coordinates)
        return f"<{type(self).__name__} {self.name!r}: {names}>"

    if TYPE_CHECKING:

        @property
        def coordinates(self) -> tuple[Coordinate, ...]:
            """The one or two coordinates."""

    @cached_property
    def lines(self) -> tuple[Line]:
        """The constraint row."""
        raise NotImplementedError

    @property
    def rows(self) -> int:
        """Number of constraint rows, 1."""
        return 1

    @property
    def row_names(self) -> tuple[str]:
        """Name of the row for messages."""
        return (" with ".join(s.name for s in self.coordinates),)


class Gear(Coupler, tag="gear"):
    """Gear pair with a constant ratio of two angles: ``b - b0 = ratio (a - a0)``.

    Index 0 is the initial pose.
    """

    kind = "gear"
    a: CoordinateField = field("An angle, such as ``hinge.angle``")
    b: CoordinateField = field("Another angle")
    ratio: Number = field(
        "Turns of b per turn of a; negative for an external pair of gear wheels", nonzero=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report coordinates that are not angles, or are the same."""
        check_kind(problems, where, "a", self.a, angle=True)
        check_kind(problems, where, "b", self.b, angle=True)
        check_different(problems, where, self.a, self.b)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The angles a and b."""
        return self.a, self.b

    @cached_property
    def lines(self) -> tuple[Line]:
        """``b - ratio a = b0 - ratio a0``."""
        return linked(self.a, self.b, self.ratio)


class Rack(Coupler, tag="rack"):
    """Pinion that rolls on a rack: ``s - s0 = radius (phi - phi0)``.

    Index 0 is the initial pose.
    """

    kind = "rack"
    pinion: CoordinateField = field("Angle phi of the pinion, such as ``hinge.angle``")
    rack: CoordinateField = field("Displacement s of the rack, such as ``slide.displacement``")
    radius: Number = field(
        "Pitch radius; negative if s decreases as the angle increases",
        unit="m",
        nonzero=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report coordinates that are not an angle and a length."""
        check_kind(problems, where, "pinion", self.pinion, angle=True)
        check_kind(problems, where, "rack", self.rack, angle=False)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The angle of the pinion and the displacement of the rack."""
        return self.pinion, self.rack

    @cached_property
    def lines(self) -> tuple[Line]:
        """``s - radius phi = s0 - radius phi0``."""
        return linked(self.pinion, self.rack, self.radius)


class Coupling(Coupler, tag="coupling"):
    """Linear relation of coordinates: ``sum factor_i s_i = offset``."""

    coordinates: CoordinatesField = field("The coordinates s_i")
    factors: Numbers = field("One factor for each coordinate, in SI units")
    offset: OptionalNumber = field(
        "Right-hand side; None for the value at the initial pose",
        unit=replace(VALUE, field="coordinates"),
        default=None,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report more than two coordinates, or the same one twice."""
        terms = self.coordinates
        if not 1 <= len(terms) <= 2:
            problems.add(where, f"has {len(terms)} coordinates, must have one or two")
        elif len(terms) != len(self.factors):
            problems.add(where, f"{len(terms)} coordinates but {len(self.factors)} factors")
        elif len(terms) == 2:
            check_different(problems, where, *terms)

    @cached_property
    def lines(self) -> tuple[Line]:
        """``sum factor_i s_i = offset``."""
        line = Line(self.coordinates, self.factors)
        offset = line.initial if self.offset is None else self.offset
        return (Line(self.coordinates, self.factors, offset),)


class Drive(Coupler, tag="drive"):
    """Coordinate that follows a signal of time: ``s = signal(t)`` (rheonomic).

    Reactions depend on the second derivative of the signal, so use a signal with two
    derivatives: `SCurve`, `Harmonic` or a cubic `Table`. At a kink of the signal the speed
    jumps; a jump of the signal itself cannot be followed.
    """

    kind = "drive"
    coordinate: CoordinateField = field(
        "The driven coordinate, such as ``hinge.angle`` (rad) or ``slide.displacement`` (m)"
    )
    signal: SignalField = field("Value of the coordinate as a function of time", unit=VALUE)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The driven coordinate."""
        return (self.coordinate,)

    @cached_property
    def lines(self) -> tuple[Line]:
        """``s = signal(t)``."""
        return (Line((self.coordinate,), (1.0,), 0.0, self.signal),)

    @property
    def beginning(self) -> tuple[float, float, float]:
        """Initial values of the signal and of the coordinate, and their difference, m or rad.

        Full turns are subtracted from the difference.
        """
        begins, stands = float(self.signal(0.0)), float(self.coordinate.initial)
        gap = begins - stands
        turned = self.coordinate.unit == "rad"
        return begins, stands, math.remainder(gap, math.tau) if turned else gap


def linked(a: Coordinate, b: Coordinate, ratio: float) -> tuple[Line]:
    """Return the row ``b - ratio a = b0 - ratio a0``."""
    return (Line((a, b), (-ratio, 1.0), b.initial - ratio * a.initial),)


def check_kind(problems: Problems, where: str, name: str, value: Any, *, angle: bool) -> None:
    """Report a problem unless the value is an angle or, with ``angle=False``, a length."""
    found = check_coordinate(problems, where, name, value)
    if found is not None and isinstance(found, Angle) != angle:
        wanted = "an angle" if angle else "a displacement or distance"
        other = "an angle" if isinstance(found, Angle) else "a length"
        problems.add(
            where,
            f"{found.name} is {other}, must be {wanted}; "
            "Gear couples two angles, Rack an angle and a length, Coupling any two",
            name,
            named=False,
        )


def check_different(problems: Problems, where: str, a: Any, b: Any) -> None:
    """Report a problem if both coordinates are the same."""
    if isinstance(a, Coordinate) and isinstance(b, Coordinate) and a.same_as(b):
        problems.add(where, f"couples {a.name} with itself")
