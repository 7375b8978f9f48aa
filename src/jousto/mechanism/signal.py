"""Signals of time: dimensionless factors on a force or torque."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from jousto.errors import Problems
from jousto.mechanism.fields import number, set_fields
from jousto.mechanism.orientation import Array


@dataclass(frozen=True, init=False)
class Harmonic:
    """A sine: ``offset + amplitude sin(2 pi frequency t + phase)``.

    Parameters
    ----------
    frequency : float
        Frequency, Hz.
    amplitude, offset : float
        Dimensionless.
    phase : float
        Phase, rad.

    Examples
    --------
    >>> Harmonic(frequency=0.5, amplitude=3.0, offset=1.0)(1.5).round(12)
    np.float64(-2.0)
    """

    amplitude: float
    frequency: float
    phase: float
    offset: float

    def __init__(
        self, *, frequency: float, amplitude: float = 1.0, phase: float = 0.0, offset: float = 0.0
    ) -> None:
        problems = Problems()
        values = {
            key: number(problems, "Harmonic", key, value)
            for key, value in (
                ("amplitude", amplitude),
                ("frequency", frequency),
                ("phase", phase),
                ("offset", offset),
            )
        }
        hertz = values["frequency"]
        if hertz is not None and hertz < 0:
            problems.add("Harmonic", f"frequency is {hertz:g} Hz, must not be negative")
        problems.raise_if_any()
        set_fields(self, **values)

    def __call__(self, t: ArrayLike) -> Array:
        """Return the factor at time t, s."""
        t = np.asarray(t, dtype=np.float64)
        angle = 2 * np.pi * self.frequency * t + self.phase
        return np.asarray(self.offset + self.amplitude * np.sin(angle))[()]


@dataclass(frozen=True, eq=False, init=False)
class Table:
    """Linear interpolation between points, held constant before the first and after the last.

    Parameters
    ----------
    times : (k,) array_like
        Strictly increasing times, s.
    values : (k,) array_like
        Factors at these times.

    Examples
    --------
    >>> Table((0, 1, 2), (0, 10, 0))([0.5, 5.0])
    array([5., 0.])
    """

    times: Array
    values: Array

    def __init__(self, times: ArrayLike, values: ArrayLike) -> None:
        problems = Problems()
        t = problems.array("Table", "times", times, (None,))
        y = problems.array("Table", "values", values, (None,))
        if t is not None:
            if len(t) == 0:
                problems.add("Table", "times is empty, must have at least one point")
            elif y is not None and len(t) != len(y):
                problems.add("Table", f"{len(t)} times but {len(y)} values, must be as many")
            back = np.flatnonzero(np.diff(t) <= 0)
            if len(back):
                i = int(back[0])
                problems.add(
                    "Table",
                    f"times must increase: times[{i}] = {t[i]:g} s, "
                    f"times[{i + 1}] = {t[i + 1]:g} s",
                )
        problems.raise_if_any()
        set_fields(self, times=t, values=y)

    def __call__(self, t: ArrayLike) -> Array:
        """Return the factor at time t, s."""
        return np.asarray(np.interp(np.asarray(t, dtype=np.float64), self.times, self.values))[()]


@dataclass(frozen=True, init=False)
class Step:
    """A jump: `before` for t < time, `after` from then on.

    Examples
    --------
    >>> Step(1.0)([0.999, 1.0])
    array([0., 1.])
    """

    time: float
    before: float
    after: float

    def __init__(self, time: float, before: float = 0.0, after: float = 1.0) -> None:
        problems = Problems()
        values = {
            key: number(problems, "Step", key, value)
            for key, value in (("time", time), ("before", before), ("after", after))
        }
        problems.raise_if_any()
        set_fields(self, **values)

    def __call__(self, t: ArrayLike) -> Array:
        """Return the factor at time t, s."""
        t = np.asarray(t, dtype=np.float64)
        return np.asarray(np.where(t < self.time, self.before, self.after))[()]


Signal: TypeAlias = Harmonic | Table | Step
SIGNALS: tuple[type[Signal], ...] = (Harmonic, Table, Step)
