"""A signal that an event switches from one to another."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from jousto.base.errors import InputError, Problem, Problems
from jousto.base.numbers import set_fields
from jousto.base.rotations import Array
from jousto.mechanism.signals.base import Jet, Signal, check_signal

if TYPE_CHECKING:
    from jousto.mechanism.signals.event import Event


@dataclass(frozen=True, eq=False, init=False)
class Switched(Signal):
    """`before` until an event has happened for the first time, `after` from then on.

    When that is depends on the motion, so it has no value as a function of time. In a drive both
    signals have to agree at the event, since positions cannot jump.

    Parameters
    ----------
    event : Event
        The event; it must be in the mechanism.
    before, after : Signal or float
        What holds until the event, and from the event on.
    """

    event: Event
    before: Signal
    after: Signal

    def __init__(self, event: Event, before: Signal | float, after: Signal | float) -> None:
        problems = Problems()
        checked: Any = event
        if getattr(type(checked), "kind", "") != "event":
            problems.add("Switched", f"event is {event!r}, must be an Event")
        first = check_signal(problems, "Switched", "before", before)
        then = check_signal(problems, "Switched", "after", after)
        problems.raise_if_any()
        set_fields(self, event=event, before=first, after=then)

    def __repr__(self) -> str:
        return f"Switched({self.event.name!r}, {self.before!r}, {self.after!r})"

    @property
    def parts(self) -> tuple[Signal, ...]:
        """The signals before and after."""
        return self.before, self.after

    def jet(self, t: Array) -> Jet:
        """Raise InputError: the value is not known as a function of time."""
        raise InputError(
            Problem(
                f"signal switched by event {self.event.name!r}",
                "depends on the motion and has no value as a function of time",
            )
        )
