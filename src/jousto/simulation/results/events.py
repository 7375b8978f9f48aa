"""Events and stick-slip transitions of a run, with their times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import read_only
from jousto.model.model import Model
from jousto.model.native.native import Engine

NOTHING = read_only(np.zeros((0, 4)))  # no events
FRICTION_CHANGES = ("sticks", "slips forward", "slips backward")  # 0, 1, -1 of the engine's log


@dataclass(frozen=True)
class Happening:
    """Event or stick-slip transition of a run.

    Attributes
    ----------
    time : float
        Instant, s.
    name : str
        Name of the event or friction.
    change : str
        "rising" or "falling" of the watched value; "sticks", "slips forward" or "slips backward"
        of friction, along its coordinate.
    count : int
        Number of occurrences of this event since the start, this one included.
    joint : str
        Joint of the friction; empty for an event.
    """

    time: float
    name: str
    change: str
    count: int
    joint: str = ""

    def __str__(self) -> str:
        return f"{self.time:.9g} s: {self.name} {self.change}, {ordinal(self.count)} time"


def ordinal(count: int) -> str:
    """Return the English ordinal of a number: 1st, 2nd, 3rd ..."""
    if count % 100 in (11, 12, 13):
        return f"{count}th"
    ending = {1: "st", 2: "nd", 3: "rd"}.get(count % 10, "th")
    return f"{count}{ending}"


def sources(model: Model) -> list[str]:
    """Return the names of the sources of the event log: events, then frictions that stick."""
    frictions = [friction.name for friction in model.frictions]
    return [event.name for event in model.events] + (
        frictions if any(friction.sticks for friction in model.frictions) else []
    )


def joints_of(model: Model) -> list[str]:
    """Return the joint of each source of the event log; an empty name for an event."""
    joints = [model.joints[friction.joint].name for friction in model.frictions]
    return [*("" for _ in model.events), *joints][: len(sources(model))]


def change_of(is_event: bool, value: int) -> str:
    """Return the text of a change in the event log of the engine."""
    if is_event:
        return "rising" if value > 0 else "falling"
    return FRICTION_CHANGES[1 if value > 0 else -1 if value < 0 else 0]


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
            change_of(source < events, int(value)),
            int(count),
            joints[int(source)],
        )
        for time, source, value, count in rows
    )
