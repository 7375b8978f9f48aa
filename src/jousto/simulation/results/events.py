"""Events and stick-slip transitions of a run, with their times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import read_only
from jousto.model.model import Model
from jousto.model.native.native import Engine

NOTHING = read_only(np.zeros((0, 4)))  # no events
ROW_CHANGES = ("closes", "opens")  # an impulse, at least 0, or -1 of the engine's log
FRICTION_CHANGES = ("sticks", "slips forward", "slips backward")  # 0, 1, -1 of the engine's log


@dataclass(frozen=True)
class Happening:
    """Event, stick-slip transition, or impact of a rigid stop, a lock or a contact of a run.

    Attributes
    ----------
    time : float
        Instant, s.
    name : str
        Name of the event, friction, stop or lock.
    change : str
        "rising" or "falling" of the watched value; "sticks", "slips forward" or "slips backward"
        of friction, along its coordinate; "closes" or "opens" of a stop or lock; "closes" of a
        contact that strikes by an impulse.
    count : int
        Number of occurrences of this event since the start, this one included.
    joint : str
        Joint of the friction; empty for others.
    impulse : float
        Impulse of a stop or lock that closes, N s or N m s along its coordinate, or of a contact
        along its normal, N s; 0 for others.
    """

    time: float
    name: str
    change: str
    count: int
    joint: str = ""
    impulse: float = 0.0

    def __str__(self) -> str:
        return f"{self.time:.9g} s: {self.name} {self.effect}, {ordinal(self.count)} time"

    @property
    def effect(self) -> str:
        """The change, with the impulse of a stop or lock that closes."""
        return f"{self.change}, impulse {self.impulse:.6g}" if self.impulse else self.change


def ordinal(count: int) -> str:
    """Return the English ordinal of a number: 1st, 2nd, 3rd ..."""
    if count % 100 in (11, 12, 13):
        return f"{count}th"
    ending = {1: "st", 2: "nd", 3: "rd"}.get(count % 10, "th")
    return f"{count}{ending}"


def sources(model: Model) -> list[str]:
    """Return the sources of the event log.

    Events, frictions that stick, stops and locks, then all forces if contacts strike by impulses.
    """
    names = [event.name for event in model.events]
    struck = strikers(model)
    if any(friction.sticks for friction in model.frictions) or model.switched or struck:
        names += [friction.name for friction in model.frictions]
    return names + [row.name for row in model.switched] + struck


def strikers(model: Model) -> list[str]:
    """Return the names of all forces if any of them strikes by impulses, else none."""
    from jousto.simulation.contacts import resolved_by  # readers of results need no contacts

    return [force.name for force in model.forces] if resolved_by(model, "impulse") else []


def joints_of(model: Model) -> list[str]:
    """Return the joint of each source of the event log; an empty name for other sources."""
    joints = [model.joints[friction.joint].name for friction in model.frictions]
    others = len(model.switched) + len(strikers(model))
    frictions = len(sources(model)) - len(model.events) - others
    return ["" for _ in model.events] + joints[:frictions] + [""] * others


def change_of(is_event: bool, is_friction: bool, value: float) -> str:
    """Return the text of a change in the event log of the engine."""
    if is_event:
        return "rising" if value > 0 else "falling"
    if is_friction:
        return FRICTION_CHANGES[1 if value > 0 else -1 if value < 0 else 0]
    return ROW_CHANGES[int(value < 0)]


class Chronicle:
    """Reader of the event log of an engine, with a running count of each source.

    Parameters
    ----------
    engine : Engine
        Engine in the state at which counting begins.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._counts = np.zeros(len(sources(engine.model)), dtype=np.int64)
        self._counts[: len(engine.model.events)] = engine.happened

    def follow(self, engine: Engine) -> None:
        """Continue with the log of another engine in the same state."""
        self._engine = engine

    def read(self) -> NDArray[np.float64]:
        """Return time, source, value and count (k, 4) of the events of the last engine call."""
        log = self._engine.happenings()
        if not len(log):
            return NOTHING
        out = np.zeros((len(log), 4))
        for i, (time, source, value) in enumerate(log):
            self._counts[int(source)] += 1
            out[i] = time, source, value, self._counts[int(source)]
        return out


def happenings(
    rows: NDArray[np.float64], names: list[str], events: int, joints: list[str]
) -> tuple[Happening, ...]:
    """Return the rows of a `Chronicle` as `Happening`; the first `events` names are events."""
    return tuple(
        Happening(
            float(time),
            names[int(source)],
            change_of(source < events, bool(joints[int(source)]), value),
            int(count),
            joints[int(source)],
            0.0 if source < events or joints[int(source)] else max(float(value), 0.0),
        )
        for time, source, value, count in rows
    )
