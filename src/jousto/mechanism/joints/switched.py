"""Rows that hold a coordinate at times: rigid stops, and locks from one event to another."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.joints.coordinate import RATE, VALUE, Coordinate, CoordinateField, Line
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.signals.switched import EventField, OptionalEventField

UNLIMITED = 1e300
"""Limit of a stop on a side that has none, m or rad."""


class SwitchedRow(Coupler):
    """Base of the rows that hold one coordinate at times."""

    optional = True

    if TYPE_CHECKING:

        @property
        def coordinate(self) -> Coordinate:
            """The coordinate that is held."""

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinate that is held."""
        return (self.coordinate,)

    @cached_property
    def lines(self) -> tuple[Line]:
        """``s = s_held``, which the engine sets."""
        return (Line((self.coordinate,), (1.0,)),)

    @property
    def numbers(self) -> dict[str, float]:
        """Limits, restitution and slowest impact, in the order of the engine."""
        raise NotImplementedError

    def exceeded(self, value: Any) -> str:
        """Return "lower" or "upper", the limit beyond which a value of the coordinate is, or ""."""
        start, numbers = float(np.real(value)), self.numbers
        small = 1e-9 * max(1.0, abs(start))
        if start < float(np.real(numbers["lower"])) - small:
            return "lower"
        return "upper" if start > float(np.real(numbers["upper"])) + small else ""


class RigidStop(SwitchedRow, tag="rigid-stop"):
    """Rigid limits of a coordinate: an impact with a coefficient of restitution e, or rest.

    At a limit all velocities jump in an instant, ``v+ = v- + (1 + e) (v0 - v-)``, where v0 are the
    velocities without approach that are nearest to v- in the norm of the mass matrix, with all
    joints and all stops that rest already. So the coordinate rebounds at e times its speed, the
    impulse is ``L = (1 + e) u / (j M^-1 j^T)`` and ``(1 - e^2)`` of the kinetic energy of the
    approach is dissipated (Newton's law of impact; Pfeiffer and Glocker, Multibody Dynamics with
    Unilateral Contacts, 1996, chapter 8). An approach slower than `slowest` does not rebound: the
    coordinate rests at the limit, as if locked, until the stop would have to pull.

    The events of a run give time and impulse of every impact; a `ReactionSensor` gives the force of
    a stop at rest. `Stop` is the elastic stop, whose force during the impact is finite.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> door = RigidBody("door", 20.0, (1, 1, 2), center=(0.4, 0, 0))
    >>> hinge = Revolute("hinge", ground["origin"], door["origin"])
    >>> RigidStop("stop", hinge.angle, upper=1.6, restitution=0.4)
    <RigidStop 'stop': hinge.angle>
    """

    kind = "rigid stop"
    together = ("lower", "upper")
    coordinate: CoordinateField = field("The limited coordinate, a length or an angle")
    lower: OptionalNumber = field("Lower limit; None for no limit", unit=VALUE, default=None)
    upper: OptionalNumber = field("Upper limit; None for no limit", unit=VALUE, default=None)
    restitution: Number = field(
        "Coefficient of restitution e: speed after an impact over speed before it; 1 for no loss",
        unit="1",
        least=0,
        most=1,
        default=0.5,
        kw_only=True,
    )
    slowest: Number = field(
        "Speed of approach up to which an impact does not rebound, which ends a row of ever "
        "smaller bounces",
        unit=RATE,
        above=0,
        default=1e-3,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report missing limits, limits in the wrong order, and a start beyond them."""
        low, high = self.lower, self.upper
        if low is None and high is None:
            problems.add(where, "has no limit; give lower, upper or both")
            return
        if low is not None and high is not None and np.real(low) >= np.real(high):
            problems.add(
                where, f"lower limit {low:g} is not below the upper one, {high:g}", "lower"
            )
            return
        s: Any = self.coordinate
        if not isinstance(s, Coordinate):
            return
        if name := self.exceeded(s.initial):
            problems.add(
                where,
                f"{s.name} starts at {float(np.real(s.initial)):g} {s.unit}, beyond the {name} "
                f"limit {getattr(self, name):g}; move the bodies or the limit",
                name,
            )

    @property
    def numbers(self) -> dict[str, float]:
        """Limits, restitution and slowest impact."""
        return {
            "lower": -UNLIMITED if self.lower is None else self.lower,
            "upper": UNLIMITED if self.upper is None else self.upper,
            "restitution": self.restitution,
            "slowest": self.slowest,
        }


class Lock(SwitchedRow, tag="lock"):
    """Coordinate that an event locks: a latch that closes, a brake, a docking device.

    From the event on, the coordinate keeps the value that it has at that instant. Its speed is
    stopped by an impulse, as of a `RigidStop` without rebound, and the kinetic energy lost is
    dissipated. A second event may unlock it; each further occurrence of the first one locks it
    again.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> from jousto.mechanism import Event
    >>> door = RigidBody("door", 20.0, (1, 1, 2), center=(0.4, 0, 0))
    >>> hinge = Revolute("hinge", ground["origin"], door["origin"])
    >>> shut = Event("shut", hinge.angle, 1.2, "rising")
    >>> Lock("latch", hinge.angle, shut)
    <Lock 'latch': hinge.angle>
    """

    kind = "lock"
    coordinate: CoordinateField = field("The coordinate that is locked")
    begins: EventField = field("The event that locks it; it must be in the mechanism")
    ends: OptionalEventField = field(
        "The event that unlocks it; None: it stays locked", default=None
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report one event for both."""
        if self.ends is not None and self.ends is self.begins:
            problems.add(where, "begins and ends are the same event; take two events", "ends")

    @property
    def numbers(self) -> dict[str, float]:
        """No limits."""
        return {"lower": -UNLIMITED, "upper": UNLIMITED, "restitution": 0.0, "slowest": 1.0}
