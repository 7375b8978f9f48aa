"""Couplings and drives: constraint rows that are linear in coordinates of joints."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

from jousto.errors import Problems
from jousto.mechanism.coordinate import Angle, Coordinate, Line, check_coordinate
from jousto.mechanism.fields import number, set_fields
from jousto.mechanism.signals import Signal, check_signal
from jousto.names import check_name


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Coupler(ABC):
    """One constraint row that is linear in one or two coordinates.

    Its multiplier lam acts on coordinate s_i as the force ``-f_i lam``, along s_i on the body
    of its marker b.
    """

    kind: ClassVar[str] = "coupling"
    name: str

    def __repr__(self) -> str:
        names = ", ".join(s.name for s in self.coordinates)
        return f"<{type(self).__name__} {self.name!r}: {names}>"

    @property
    @abstractmethod
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The one or two coordinates."""

    @cached_property
    @abstractmethod
    def lines(self) -> tuple[Line]:
        """The row."""

    @property
    def rows(self) -> int:
        """Number of constraint rows, 1."""
        return 1

    @property
    def row_names(self) -> tuple[str]:
        """What the row holds, for messages."""
        return (" with ".join(s.name for s in self.coordinates),)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Gear(Coupler):
    """Two angles turn in a ratio: ``b - b0 = ratio (a - a0)``; index 0 is the initial pose.

    Parameters
    ----------
    name : str
        Name, unique among joints, couplings and drives.
    a, b : Coordinate
        Two angles, such as ``hinge.angle``.
    ratio : float
        Turns of b for one of a; negative for an external pair of wheels.
    """

    kind: ClassVar[str] = "gear"
    a: Coordinate
    b: Coordinate
    ratio: float

    def __init__(self, name: str, a: Coordinate, b: Coordinate, ratio: float) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        for key, value in (("a", a), ("b", b)):
            check_kind(problems, where, key, value, angle=True)
        factor = nonzero(problems, where, "ratio", ratio)
        check_different(problems, where, a, b)
        problems.raise_if_any()
        set_fields(self, name=name, a=a, b=b, ratio=factor)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The angles a and b."""
        return self.a, self.b

    @cached_property
    def lines(self) -> tuple[Line]:
        """``b - ratio a = b0 - ratio a0``."""
        return linked(self.a, self.b, self.ratio)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Rack(Coupler):
    """A pinion rolls on a rack: ``s - s0 = radius (phi - phi0)``; 0 is the initial pose.

    Parameters
    ----------
    name : str
        Name, unique among joints, couplings and drives.
    pinion : Coordinate
        Angle phi of the pinion, such as ``hinge.angle``.
    rack : Coordinate
        Displacement s of the rack, such as ``slide.displacement``.
    radius : float
        Pitch radius, m; negative where the rack goes back as the angle grows.
    """

    kind: ClassVar[str] = "rack"
    pinion: Coordinate
    rack: Coordinate
    radius: float

    def __init__(self, name: str, pinion: Coordinate, rack: Coordinate, radius: float) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        check_kind(problems, where, "pinion", pinion, angle=True)
        check_kind(problems, where, "rack", rack, angle=False)
        factor = nonzero(problems, where, "radius", radius)
        problems.raise_if_any()
        set_fields(self, name=name, pinion=pinion, rack=rack, radius=factor)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The angle of the pinion and the displacement of the rack."""
        return self.pinion, self.rack

    @cached_property
    def lines(self) -> tuple[Line]:
        """``s - radius phi = s0 - radius phi0``."""
        return linked(self.pinion, self.rack, self.radius)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Coupling(Coupler):
    """A linear relation: ``sum factor_i s_i = offset``.

    Parameters
    ----------
    name : str
        Name, unique among joints, couplings and drives.
    coordinates : Coordinate or sequence of one or two Coordinate
        The coordinates s_i.
    factors : float or sequence of float
        One factor for each coordinate, not zero.
    offset : float, optional
        Right-hand side; None for the value at the initial pose.
    """

    terms: tuple[Coordinate, ...]
    factors: tuple[float, ...]
    offset: float | None

    def __init__(
        self,
        name: str,
        coordinates: Coordinate | Iterable[Coordinate],
        factors: float | Iterable[float],
        offset: float | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        terms = tuple(coordinates) if isinstance(coordinates, Iterable) else (coordinates,)
        given: tuple[Any, ...] = tuple(factors) if isinstance(factors, Iterable) else (factors,)
        for i, term in enumerate(terms):
            check_coordinate(problems, where, f"coordinates[{i}]", term)
        values = tuple(nonzero(problems, where, f"factors[{i}]", f) for i, f in enumerate(given))
        if not 1 <= len(terms) <= 2:
            problems.add(where, f"has {len(terms)} coordinates, must have one or two")
        elif len(terms) != len(values):
            problems.add(where, f"{len(terms)} coordinates but {len(values)} factors")
        elif len(terms) == 2:
            check_different(problems, where, *terms)
        right = None if offset is None else number(problems, where, "offset", offset)
        problems.raise_if_any()
        set_fields(self, name=name, terms=terms, factors=values, offset=right)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates s_i."""
        return self.terms

    @cached_property
    def lines(self) -> tuple[Line]:
        """``sum factor_i s_i = offset``."""
        line = Line(self.terms, self.factors)
        offset = line.initial if self.offset is None else self.offset
        return (Line(self.terms, self.factors, offset),)


@dataclass(frozen=True, eq=False, init=False, repr=False)
class Drive(Coupler):
    """A coordinate follows a signal of time: ``s = signal(t)`` (rheonomic).

    Reactions follow from its acceleration, so the signal should have two derivatives: `SCurve`,
    `Harmonic` or a cubic `Table`. At a kink of the signal the speed jumps; a jump of the
    signal itself cannot be followed.

    Parameters
    ----------
    name : str
        Name, unique among joints, couplings and drives.
    coordinate : Coordinate
        What is driven, such as ``hinge.angle`` (rad) or ``slide.displacement`` (m).
    signal : Signal or float
        Its value as a function of time, rad or m.
    """

    kind: ClassVar[str] = "drive"
    coordinate: Coordinate
    signal: Signal

    def __init__(self, name: str, coordinate: Coordinate, signal: Signal | float) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        check_coordinate(problems, where, "coordinate", coordinate)
        value = check_signal(problems, where, "signal", signal)
        problems.raise_if_any()
        set_fields(self, name=name, coordinate=coordinate, signal=value)

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The driven coordinate."""
        return (self.coordinate,)

    @cached_property
    def lines(self) -> tuple[Line]:
        """``s = signal(t)``."""
        return (Line((self.coordinate,), (1.0,), 0.0, self.signal),)


COUPLINGS: tuple[type[Coupler], ...] = (Gear, Rack, Coupling, Drive)


def linked(a: Coordinate, b: Coordinate, ratio: float) -> tuple[Line]:
    """Return the row ``b - ratio a = b0 - ratio a0``."""
    return (Line((a, b), (-ratio, 1.0), b.initial - ratio * a.initial),)


def nonzero(problems: Problems, where: str, name: str, value: Any) -> float | None:
    """Return a finite number other than zero, or note why it is none."""
    found = number(problems, where, name, value)
    if found == 0.0:
        problems.add(where, f"{name} is 0, must not be zero")
    return found


def check_kind(problems: Problems, where: str, name: str, value: Any, *, angle: bool) -> None:
    """Note a problem unless the value is an angle, or a length if not `angle`."""
    found = check_coordinate(problems, where, name, value)
    if found is not None and isinstance(found, Angle) != angle:
        wanted = "an angle" if angle else "a displacement or distance"
        other = "an angle" if isinstance(found, Angle) else "a length"
        problems.add(
            where,
            f"{name}: {found.name} is {other}, must be {wanted}; "
            "Gear couples two angles, Rack an angle and a length, Coupling any two",
        )


def check_different(problems: Problems, where: str, a: Any, b: Any) -> None:
    """Note that both coordinates are the same one."""
    if isinstance(a, Coordinate) and isinstance(b, Coordinate) and a.same_as(b):
        problems.add(where, f"couples {a.name} with itself")
