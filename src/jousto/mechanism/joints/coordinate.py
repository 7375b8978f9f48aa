"""Coordinates: scalar functions of two marker frames a and b, and linear relations of them.

Joints have coordinates as properties (``hinge.angle``); drives, couplings, springs, servos and
sensors take a coordinate as argument. There are three kinds: angle, displacement and distance.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from jousto.base.complexstep import arctan2, floats, norm, scalar
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import AnyField, Choice, Field, OptionalText, field
from jousto.mechanism.bodies.marker import Marker, MarkerField

if TYPE_CHECKING:
    from jousto.mechanism.signals.base import Signal

AXES = ("x", "y", "z")


class Coordinate(Declared, section="coordinates"):
    """A scalar function of the frames of two markers.

    Attributes
    ----------
    unit, force_unit : str
        Unit of the coordinate, and of a force along it.
    """

    unit: ClassVar[str] = "m"
    force_unit: ClassVar[str] = "N"
    engine: ClassVar[str] = "distance"
    """Name of the kind in the engine."""
    a: MarkerField = field("Frame a")
    b: MarkerField = field("Frame b; not both on one rigid body")
    name: OptionalText = field(
        "Name for messages and results; None to build it from the labels of the markers",
        default=None,
        kw_only=True,
        file=False,
    )
    joint: AnyField = field(
        "The joint that has this coordinate, if there is one",
        default=None,
        kw_only=True,
        file=False,
    )

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages: the name, or the kind of a coordinate without a name."""
        kind, name = type(self).__name__.lower(), self.__dict__["name"]
        return kind if name is None else f"{kind} {name!r}"

    def consistent(self, problems: Problems, where: str) -> None:
        """Report markers without relative motion; build the name."""
        a, b, name = self.a, self.b, self.__dict__["name"]
        label = f"{where}({a.label}, {b.label})" if name is None else name
        if a.body is b.body and (a.site is None or a.site == b.site):
            place = label if name is None else where
            problems.add(place, f"both markers are on {a.body.name!r}: the coordinate is constant")
        object.__setattr__(self, "name", label)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name!r}>"

    @property
    def column(self) -> int:
        """Number of the axis of frame a: 0, 1 or 2."""
        return 2

    @property
    def initial(self) -> float:
        """Value at the initial pose, m or rad."""
        raise NotImplementedError

    @property
    def turns_a(self) -> bool:
        """Whether the coordinate depends on the orientation of frame a."""
        return True

    @property
    def turns_b(self) -> bool:
        """Whether the coordinate depends on the orientation of frame b."""
        return False

    def same_as(self, other: Coordinate) -> bool:
        """Return whether another coordinate is the same function of the same frames."""
        return self.key == other.key

    @property
    def key(self) -> tuple[Any, ...]:
        """Key that is equal for coordinates that are the same function of the same frames."""
        frames = frame_key(self.a, self.turns_a), frame_key(self.b, self.turns_b)
        return (type(self), getattr(self, "axis", None), *frames)


class Angle(Coordinate, tag="angle"):
    """Rotation of b relative to a about the z axis of a, ``atan2(y_a . x_b, x_a . x_b)``, rad.

    The angle is 0 where the x axes agree, and is continuous over several turns. The x axis of b
    must not become parallel to the z axis of a; joints with an angle ensure this.
    """

    unit: ClassVar[str] = "rad"
    force_unit: ClassVar[str] = "N m"
    engine: ClassVar[str] = "angle"

    @property
    def initial(self) -> float:
        """Value at the initial pose in (-pi, pi], rad."""
        A, x = self.a.A, self.b.A[:, 0]
        return scalar(arctan2(A[:, 1] @ x, A[:, 0] @ x))

    @property
    def turns_b(self) -> bool:
        """Whether the coordinate depends on the orientation of frame b."""
        return True


class Displacement(Coordinate, tag="displacement"):
    """The displacement of b along an axis of a, ``axis . (r_b - r_a)``, m."""

    engine: ClassVar[str] = "along"
    axis: Choice = field("Axis of frame a", words=AXES, default="z")

    @property
    def column(self) -> int:
        """Number of the axis: 0, 1 or 2."""
        return AXES.index(self.axis)

    @property
    def initial(self) -> float:
        """Value at the initial pose, m."""
        return scalar(self.a.A[:, self.column] @ (self.b.r - self.a.r))


class Distance(Coordinate, tag="distance"):
    """Distance of the origins, ``|r_b - r_a|``, m; it must stay above zero."""

    @property
    def initial(self) -> float:
        """Value at the initial pose, m."""
        return scalar(norm(self.b.r - self.a.r))

    @property
    def turns_a(self) -> bool:
        """Whether the coordinate depends on the orientation of frame a."""
        return False


@dataclass(frozen=True, eq=False)
class Line:
    """One constraint row, linear in one or two coordinates: ``sum f_i s_i = offset + signal(t)``.

    Parameters
    ----------
    coordinates : tuple of Coordinate
        One or two coordinates s_i.
    factors : tuple of float
        Their factors f_i.
    offset : float
        Constant right-hand side.
    signal : Signal, optional
        Right-hand side as a function of time (rheonomic); None for zero.
    """

    coordinates: tuple[Coordinate, ...]
    factors: tuple[float, ...]
    offset: float = 0.0
    signal: Signal | None = None

    @property
    def initial(self) -> float:
        """Sum of the factors times the coordinates at the initial pose."""
        return sum(f * s.initial for f, s in zip(self.factors, self.coordinates, strict=True))


def frame_key(marker: Marker, axes: bool) -> tuple[Any, ...]:
    """Return a key that is equal for markers at the same point (with equal axes if `axes`)."""
    arrays = (marker.position_local, marker.axes) if axes else (marker.position_local,)
    numbers = ((floats(x) + 0.0).tobytes() for x in arrays)  # -0 becomes 0
    return (id(marker.body), marker.site, *numbers)


class CoordinateField(Field[Coordinate, Coordinate]):
    """Field of a coordinate; a model file contains ``hinge.angle`` or a mapping."""

    form = "coordinate"
    noun = "Coordinate"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the coordinate, or report a value of another type."""
        return check_coordinate(problems, where, self.name, value)


class CoordinatesField(Field["Coordinate | Iterable[Coordinate]", "tuple[Coordinate, ...]"]):
    """Field of one or two coordinates."""

    form = "coordinates"
    noun = "Coordinate or sequence of one or two Coordinate"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the coordinates as a tuple, or report wrong ones."""
        terms = tuple(value) if isinstance(value, Iterable) else (value,)
        for i, term in enumerate(terms):
            check_coordinate(problems, where, f"{self.name}[{i}]", term)
        return terms


@dataclass(frozen=True)
class Along:
    """Unit that depends on the coordinate in another field: for a length or an angle.

    Parameters
    ----------
    length, angle : str
        SI unit for a length and for an angle.
    field : str
        Name of the field with the coordinate.
    """

    length: str
    angle: str
    field: str = "coordinate"

    def of(self, coordinate: Coordinate) -> str:
        """Return the unit for a coordinate."""
        return self.angle if coordinate.unit == "rad" else self.length

    def __str__(self) -> str:
        return f"{self.length} or {self.angle}"


VALUE = Along("m", "rad")
RATE = Along("m/s", "rad/s")
FORCE = Along("N", "N m")
STIFFNESS = Along("N/m", "N m/rad")
DAMPING = Along("N s/m", "N m s/rad")


def check_coordinate(problems: Problems, where: str, name: str, value: Any) -> Coordinate | None:
    """Return `value` if it is a coordinate; else report how to get one."""
    if isinstance(value, Coordinate):
        return value
    owned = [key for key in ("angle", "displacement") if hasattr(value, key)]
    if owned and hasattr(value, "name"):
        hint = f"is the joint {value.name!r}; name a coordinate of it, {value.name}.{owned[0]}"
    else:
        hint = f"is {value!r}, must be a coordinate such as hinge.angle or Distance(a, b)"
        if isinstance(value, Marker) and where.startswith("spring"):
            hint += "; between two markers there is Spring.between(name, a, b, stiffness, ...)"
    problems.add(where, f"{name} {hint}", name)
    return None
