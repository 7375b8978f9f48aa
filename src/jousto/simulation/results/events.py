"""What happened in a run: events and transitions of friction, with their times."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.model.model import Model
from jousto.model.native.native import Engine

FRICTION_CHANGES = ("sticks", "slips forward", "slips backward")  # 0, 1, -1 of the engine's log


@dataclass(frozen=True)
class Happening:
    """Something that happened in a run.

    Attributes
    ----------
    time : float
        When, s.
    name : str
        Name of the event or friction.
    change : str
        "rising" or "falling" of the watched value; "sticks", "slips forward" or "slips backward"
        of friction, along its coordinate.
    count : int
        The first, second ... time since the model started.
    joint : str
        Of friction, the joint that it acts in.
    """

    time: float
    name: str
    change: str
    count: int
    joint: str = ""

    def __str__(self) -> str:
        return f"{self.time:.9g} s: {self.name} {self.change}, {ordinal(self.count)} time"


def ordinal(count: int) -> str:
    """Return 1st, 2nd, 3rd ..."""
    if count % 100 in (11, 12, 13):
        return f"{count}th"
    ending = {1: "st", 2: "nd", 3: "rd"}.get(count % 10, "th")
    return f"{count}{ending}"


def sources(model: Model) -> list[str]:
    """Return the names of what may happen: events, then frictions that stick."""
    frictions = [friction.name for friction in model.frictions]
    return [event.name for event in model.events] + (
        frictions if any(friction.sticks for friction in model.frictions) else []
    )


def joints_of(model: Model) -> list[str]:
    """Return the joints of the `sources` that are frictions, empty names for events."""
    joints = [model.joints[friction.joint].name for friction in model.frictions]
    return [*("" for _ in model.events), *joints][: len(sources(model))]


def change_of(is_event: bool, value: int) -> str:
    """Return what a value of the engine's log means."""
    if is_event:
        return "rising" if value > 0 else "falling"
    return FRICTION_CHANGES[1 if value > 0 else -1 if value < 0 else 0]


class Chronicle:
    """Collects what happens, with running counts.

    Parameters
    ----------
    engine : Engine
        In the state from which counting goes on.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._counts = np.zeros(len(sources(engine.model)), dtype=np.int64)
        self._counts[: len(engine.model.events)] = engine.happened

    def follow(self, engine: Engine) -> None:
        """Go on with another engine in the same state."""
        self._engine = engine

    def read(self) -> NDArray[np.float64]:
        """Return time, source, value and count (k, 4) of what the last call of the engine did."""
        log = self._engine.happenings()
        out = np.zeros((len(log), 4))
        for i, (time, source, value) in enumerate(log):
            self._counts[int(source)] += 1
            out[i] = time, source, value, self._counts[int(source)]
        return out


def happenings(
    rows: NDArray[np.float64], names: list[str], events: int, joints: list[str]
) -> tuple[Happening, ...]:
    """Return the entries of a `Chronicle` in words; the first `events` names are of events."""
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
