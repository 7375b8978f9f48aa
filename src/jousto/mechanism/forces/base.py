"""Base of force elements: their markers and coordinates, and the numbers of their laws."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.fields import Name, field
from jousto.base.object_repr import described
from jousto.mechanism.bodies.body import MovingBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.signals.base import Signal


@dataclass(frozen=True, eq=False)
class Packed:
    """Numbers of a law that refers to other objects of the model.

    Parameters
    ----------
    data : array
        The numbers.
    touches : tuple of int
        Markers at which the forces of a set of contacts may act.
    coupled : tuple of tuple of int
        Bodies any two of which may touch.
    dense : int
        Number of bodies that touch one another if they are too many for an implicit method, else 0.
    slots : int
        Number of the following forces that belong to the set.
    shapes : tuple of str
        Names of the shapes of a set.
    sizes : tuple of float
        Largest distance of a place of each shape from its marker, m; 0 for shapes without end.
    surfaces : tuple of int
        Number of the surface of each shape.
    restitution : tuple of tuple of float
        Coefficients of restitution that are asked for between any two surfaces; 0: not known.
    slowest : tuple of tuple of float
        Speeds of approach between any two surfaces above which a touch has that restitution, m/s.
    """

    data: Array
    touches: tuple[int, ...] = ()
    coupled: tuple[tuple[int, ...], ...] = ()
    dense: int = 0
    slots: int = 0
    shapes: tuple[str, ...] = ()
    sizes: tuple[float, ...] = ()
    surfaces: tuple[int, ...] = ()
    restitution: tuple[tuple[float, ...], ...] = ()
    slowest: tuple[tuple[float, ...], ...] = ()


@described
@dataclass(frozen=True, eq=False)
class Push:
    """Force law of the engine: its numbers, and the markers or coordinates that it acts on.

    Parameters
    ----------
    kind : str
        Name of the law in the header of the engine, ``jousto.h``.
    data : mapping of str to array_like
        Numbers of the law by their names in the header.
    rest : tuple of array_like
        Further numbers, of any count.
    a, b : Marker, optional
        The force acts on the body of b, and the opposite force on the body of a.
    turns : bool
        Whether the orientation of b matters.
    coordinate, other : Coordinate, optional
        Coordinate along which the force acts, and a second coordinate.
    body : FlexibleBody or RigidBody, optional
        Body on which the law acts as a whole.
    follow : bool
        Whether the force turns with the marker or the body.
    active : bool
        Whether the power counts as external work; otherwise it counts as stored or dissipated
        energy.
    signal, reference, spring, damper : Signal, optional
        Functions of time, and of the coordinate and its rate.
    function : callable, optional
        Function of the user.
    states : tuple of str
        Names of the first-order states of the law.
    openings : tuple of str
        Names of the openings whose largest change in a step of ROS2 the engine notes.
    numbers : callable, optional
        Function that returns the `Packed` numbers that follow `data`, given the builder of the
        model.
    pressure : float
        Largest pressure of a contact under 1 N by Hertz, Pa, which grows with ``F^(1/3)``; 0: not
        known.
    thickness, restitution : float
        Of a contact: size of the smaller shape, m, and coefficient of restitution that is asked
        for; 0: not known.
    slowest : float
        Of a contact: speed of approach above which a touch has that restitution, m/s; infinite
        where faster touches are impulses, which are no forces.
    """

    kind: str
    data: Mapping[str, ArrayLike]
    rest: tuple[ArrayLike, ...] = ()
    a: Marker | None = None
    b: Marker | None = None
    turns: bool = True
    coordinate: Coordinate | None = None
    other: Coordinate | None = None
    body: MovingBody | None = None
    follow: bool = False
    active: bool = False
    signal: Signal | None = None
    reference: Signal | None = None
    spring: Signal | None = None
    damper: Signal | None = None
    function: Any = None
    states: tuple[str, ...] = ()
    openings: tuple[str, ...] = ()
    numbers: Callable[[Any], Packed] | None = None
    pressure: float = 0.0
    thickness: float = 0.0
    restitution: float = 0.0
    slowest: float = 0.0


class ForceElement(Declared, section="forces"):
    """Base of the force elements.

    A new force element is one class, with its fields and the laws of the engine that it uses.

    Attributes
    ----------
    ties : bool
        Whether the force connects bodies with each other: true for springs, false for loads.
    measured : tuple of str
        Quantities that a `ForceSensor` measures if the force does not act along coordinates:
        "force", "moment".
    unmeasured : str
        Reason why a `ForceSensor` cannot measure the force, with the remedy; empty if it can.
    summed : bool
        Whether a `ForceSensor` measures the sum of all its laws.
    pushes : tuple of Push
        Laws of the engine that make up the force, often one.
    """

    kind = "force"
    ties: ClassVar[bool] = True
    measured: ClassVar[tuple[str, ...]] = ("force", "moment")
    unmeasured: ClassVar[str] = ""
    summed: ClassVar[bool] = False
    name: Name = field("Unique among the forces")

    @property
    def pushes(self) -> tuple[Push, ...]:
        """Laws of the engine that compute the force."""
        raise NotImplementedError

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates along which the force acts; none if it acts at markers or on a body."""
        return tuple(value for value in vars(self).values() if isinstance(value, Coordinate))

    @property
    def touching_shapes(self) -> tuple[tuple[Marker, Any], ...]:
        """Shapes of a contact with their markers, for pictures."""
        return ()

    @property
    def turns(self) -> bool:
        """Whether the force acts along an angle."""
        return any(s.unit == "rad" for s in self.coordinates)

    @property
    def symbol(self) -> str:
        """Name of the symbol in pictures: the tag in model files, or a more specific name."""
        return self.tag

    @property
    def drawn_at(self) -> tuple[Marker | tuple[MovingBody, Array], ...]:
        """Markers, and points of bodies (body frame, m), at which pictures show the symbol.

        Empty for a force along coordinates, which is shown between their markers, and for a force
        on a whole body, which is shown at the middle of the body.
        """
        push = self.pushes[0]
        if self.coordinates or push.coordinate is not None:
            return ()
        return tuple(marker for marker in (push.a, push.b) if marker is not None)

    @property
    def direction(self) -> tuple[Array, bool] | None:
        """Direction (3,) of the force, and whether it turns with the body.

        Resolved in the world frame, or in the body frame if it turns; None without a direction.
        """
        return None

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """Markers whose orientation matters, each with the name of the argument."""
        return tuple((key, value) for key, value in vars(self).items() if isinstance(value, Marker))


class Actuator(ForceElement):
    """Force along a coordinate, as of a motor or a cylinder."""

    @property
    def symbol(self) -> str:
        """Symbol of a motor (about an axis) or an actuator (along an axis)."""
        return "motor" if self.turns else "actuator"
