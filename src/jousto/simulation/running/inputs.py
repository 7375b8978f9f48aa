"""Values of external inputs during a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems, SimulationError, suggest
from jousto.mechanism.signals.base import Constant, Input, Signal, leaves
from jousto.mechanism.signals.switched import Switched
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.packing.inputs import substitute


class InputFailed(SimulationError):
    """Error raised if the function of an input fails or returns a value that is not finite."""


@dataclass(frozen=True)
class HeldInput:
    """External input with a piecewise constant value.

    Attributes
    ----------
    name : str
        Name of the input.
    place : int
        Index among the inputs of the engine.
    every : int
        Steps between two values.
    value : callable
        Value as a function (k, t) of the number of the interval and its first instant, s.
    """

    name: str
    place: int
    every: int
    value: Callable[[int, float], float]


class Feed:
    """Piecewise constant inputs of a run, set before every call of the engine."""

    def __init__(self, held: tuple[HeldInput, ...]) -> None:
        self._held = held

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(h.name for h in self._held)

    def ahead(self, done: int) -> int:
        """Return the number of steps to the next change of an input, after `done` steps."""
        return min((h.every - done % h.every for h in self._held), default=1 << 62)

    def set(self, engine: Engine, done: int) -> None:
        """Set all inputs whose interval begins after `done` steps.

        Raises
        ------
        InputFailed
            If a function of the user raises, or its value is not a finite number.
        """
        if not self._held:
            return
        time = float(engine.time[0].real)
        for h in self._held:
            if done % h.every == 0:
                engine.input[h.place] = _ask(h, done // h.every, time)


def _ask(held: HeldInput, interval: int, time: float) -> float:
    try:
        answer: Any = held.value(interval, time)
    except Exception as error:
        raise InputFailed(
            f"input '{held.name}': its function raised {type(error).__name__}: {error}", time=time
        ) from error
    try:
        value = float(answer)
    except (TypeError, ValueError):
        value = np.nan
    if not np.isfinite(value):
        raise InputFailed(
            f"input '{held.name}': its function returned {answer!r} at {time:g} s, must be a "
            "finite number",
            time=time,
        )
    return value


def connect(
    model: Model, inputs: Mapping[str, Any] | None, steps: int, every: int, where: str = "simulate"
) -> tuple[Model, Feed]:
    """Return the model with its inputs replaced by signals, and the piecewise constant inputs.

    Parameters
    ----------
    model : Model
        Model with external inputs.
    inputs : dict, optional
        Name to Signal, number, function of time or samples.
    steps, every : int
        Steps of the run and steps between two rows.

    Raises
    ------
    InputError
        If an input does not exist or its value is invalid.
    """
    if not inputs:
        return model, Feed(())
    problems = Problems()
    signals: dict[str, Signal] = {}
    waiting: list[tuple[str, int, Callable[[int, float], float]]] = []
    for name, value in inputs.items():
        place = f"{where}: input {name!r}"
        if name not in model.inputs:
            problems.add(where, f"inputs: no input {name!r}{suggest(name, model.inputs)}")
        elif isinstance(value, Signal):
            if _uses_outside(value):
                problems.add(
                    place,
                    "its signal depends on an input or an event; give a signal that "
                    "depends on time only",
                )
            signals[name] = value
        elif isinstance(value, bool) or value is None or isinstance(value, str):
            problems.add(place, f"is {value!r}, {EXPECTED}")
        elif callable(value):
            waiting.append((name, 1, _function(value)))
        elif np.ndim(value) == 0:
            number = problems.array(place, "value", value, ())
            if number is not None:
                signals[name] = Constant(float(number))
        else:
            samples = problems.array(place, "samples", value, (None,))
            rows = steps // every
            if samples is not None and steps and len(samples) not in (rows, rows + 1):
                problems.add(
                    place,
                    f"has {len(samples)} samples, the run has {rows} intervals between outputs; "
                    f"give {rows} values, one for each interval, or Table(times, values)",
                )
            elif samples is not None:
                waiting.append((name, every, _samples(samples)))
    problems.raise_if_any()
    fed = substitute(model, signals)
    held = (HeldInput(name, fed.inputs.index(name), each, value) for name, each, value in waiting)
    return fed, Feed(tuple(held))


def drive(model: Model, inputs: Mapping[str, Any], where: str) -> Model:
    """Return the model with signals of time, or numbers, in place of inputs: for many runs.

    Raises
    ------
    InputError
        If an input does not exist, or its value is neither.
    """
    driven, feed = connect(model, inputs, 0, 1, where)
    problems = Problems()
    for name in feed.names:
        problems.add(
            f"{where}: input {name!r}",
            "must be a signal of time or a number; give jo.Table(times, values) for samples",
        )
    problems.raise_if_any()
    return driven


EXPECTED = "must be a Signal, a number, a function of time or an array of samples"


def _uses_outside(signal: Signal) -> bool:
    return any(isinstance(part, Input | Switched) for part in leaves(signal))


def _function(function: Callable[[float], Any]) -> Callable[[int, float], Any]:
    return lambda interval, time: function(time)


def _samples(samples: Array) -> Callable[[int, float], float]:
    return lambda interval, time: float(samples[min(interval, len(samples) - 1)])
