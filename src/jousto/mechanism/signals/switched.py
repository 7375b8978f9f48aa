"""Signal that an event switches from one signal to another."""

from __future__ import annotations

from typing import Any

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.fields import Field, field
from jousto.mechanism.signals.base import USE, Jet, Law, Signal, SignalField


class EventField(Field[Any, Any]):
    """Field of an event; a model file contains its name."""

    form = "event"
    noun = "Event"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the event, or report a value of another type."""
        if getattr(type(value), "kind", "") != "event":
            problems.add(where, f"{self.name} is {value!r}, must be an Event")
        return value


class OptionalEventField(EventField):
    """Field of an event, or None."""

    noun = "Event or None"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the event or None, or report a value of another type."""
        return None if value is None else super().check(problems, where, value)


class Switched(Signal, tag="switched"):
    """Signal that equals `before` until an event occurs first, and `after` from then on.

    The time of the event depends on the motion, so the signal is not a function of time. In a drive
    both signals must agree at the event, since positions cannot jump.
    """

    event: EventField = field("The event; it must be in the mechanism")
    before: SignalField = field("The signal until the event", unit=USE)
    after: SignalField = field("The signal from the event on", unit=USE)

    def __repr__(self) -> str:
        return f"Switched({self.event.name!r}, {self.before!r}, {self.after!r})"

    @property
    def parts(self) -> tuple[Signal, ...]:
        """The signals before and after the event."""
        return self.before, self.after

    @property
    def law(self) -> Law:
        """Law of the two signals and the event."""
        return Law("switched", {}, event=self.event)

    def jet(self, t: Array) -> Jet:
        """Raise InputError: the signal is not a function of time."""
        raise InputError(
            Problem(
                f"signal switched by event {self.event.name!r}",
                "depends on the motion and has no value as a function of time",
            )
        )
