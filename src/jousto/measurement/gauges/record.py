"""Measured records: channels over time, with resampling, cutting and comparison with runs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import (
    LARGE_STRAIN,
    InputError,
    Problem,
    Problems,
    count,
    likely_strain_unit,
    suggest,
)
from jousto.base.files import Rows, Tabular
from jousto.measurement.gauges.resample import resample
from jousto.measurement.gauges.units import STRAIN

if TYPE_CHECKING:
    from jousto.simulation.results.solution import Solution


Raw = tuple[Array, dict[str, Array], dict[str, str | None], str | None, tuple[str, ...]]
"""Content of a file: instants, channels, units, unit of time, notes."""

GAP = 1.5
"""Number of usual steps from which a step is a gap."""


@dataclass(frozen=True, eq=False)
class Record(Tabular):
    """Channels over time in SI units, measured or from a run.

    Parameters
    ----------
    time : (nt,) array
        Instants, s, ascending.
    channels : mapping of str to (nt,) array
        Values in SI units; nan where nothing was measured.
    units : mapping of str to str
        SI unit of each channel: ``m/m``, ``V/V``, ``Pa`` ...; empty if the file names none.
    name : str
        File or run of origin.
    notes : tuple of str
        Notes of the reader: gaps, dropouts, saturated channels.

    Raises
    ------
    InputError
        With all problems: different lengths, or time that does not ascend.
    """

    time: Array
    channels: Mapping[str, Array]
    units: Mapping[str, str] = field(default_factory=dict)
    name: str = "record"
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        problems = Problems()
        time = problems.array(self.name, "time", self.time, (None,))
        nt = 0 if time is None else len(time)
        if time is not None and nt == 0:
            problems.add(self.name, "is empty: there is no instant")
        if time is not None and np.any(np.diff(time) <= 0.0):
            i = int(np.argmax(np.diff(time) <= 0.0))
            problems.add(
                self.name,
                f"time does not increase: {time[i + 1]:g} s follows {time[i]:g} s at sample "
                f"{i + 1}",
            )
        channels: dict[str, Array] = {}
        for key, values in self.channels.items():
            array = np.array(values, dtype=np.float64)
            if array.shape != (nt,):
                problems.add(self.name, f"channel '{key}' has shape {array.shape}, must be ({nt},)")
            array.setflags(write=False)
            channels[str(key)] = array
        for key in self.units:
            if key not in channels:
                problems.add(self.name, f"units: no channel '{key}'{suggest(key, channels)}")
        problems.raise_if_any()
        object.__setattr__(self, "time", time)
        object.__setattr__(self, "channels", MappingProxyType(channels))
        units = {key: str(self.units.get(key, "")) for key in channels}
        object.__setattr__(self, "units", MappingProxyType(units))
        object.__setattr__(self, "notes", tuple(self.notes))

    def __repr__(self) -> str:
        return (
            f"<Record {self.name!r}: {count(len(self.channels), 'channel')}, {len(self.time)} "
            f"instants to {self.time[-1]:g} s>"
        )

    def __str__(self) -> str:
        """Return a table of the channels, and the notes."""
        width = max([len(key) for key in self.channels] + [7])
        lines = [
            f"{self.name}: {len(self.time)} instants, {self.time[0]:g} to {self.time[-1]:g} s, "
            f"usually {self.rate:.6g} per second",
            f"{'channel':{width}}  {'unit':6} {'smallest':>12} {'largest':>12} {'missing':>8}",
        ]
        for key, x in self.channels.items():
            good = x[np.isfinite(x)]
            low, high = (good.min(), good.max()) if len(good) else (np.nan, np.nan)
            lines.append(
                f"{key:{width}}  {self.units[key]:6} {low:12.5g} {high:12.5g} "
                f"{len(x) - len(good):8d}"
            )
        return "\n".join([*lines, *self.notes])

    def __len__(self) -> int:
        return len(self.time)

    def __contains__(self, name: object) -> bool:
        return name in self.channels

    def __getitem__(self, name: str) -> Array:
        """Return the values of a channel, (nt,).

        Raises
        ------
        InputError
            If there is no such channel.
        """
        if name not in self.channels:
            raise InputError(
                Problem(self.name, f"no channel '{name}'{suggest(name, self.channels)}")
            )
        return self.channels[name]

    @property
    def step(self) -> float:
        """Median time step, s."""
        return float(np.median(np.diff(self.time))) if len(self.time) > 1 else float("nan")

    @property
    def rate(self) -> float:
        """Samples per second: 1 / `step`."""
        return 1.0 / self.step

    @property
    def uniform(self) -> bool:
        """Whether all steps are equal within 1 % of a step."""
        steps = np.diff(self.time)
        return bool(len(steps) == 0 or np.ptp(steps) <= 0.01 * self.step)

    def matrix(self, names: Sequence[str] | None = None) -> Array:
        """Return channels as columns of a matrix (nt, nc)."""
        chosen = list(self.channels) if names is None else list(names)
        return np.column_stack([self[name] for name in chosen])

    def strains(self, names: Sequence[str] | None = None) -> Array:
        """Return strain channels as columns (nt, ng), m/m; missing values are nan.

        Raises
        ------
        InputError
            With all problems: a missing channel, another unit, or values so large that they are
            probably in um/m or percent.
        """
        chosen = list(self.channels) if names is None else list(names)
        problems = Problems()
        for name in chosen:
            if name not in self.channels:
                problems.add(self.name, f"no channel '{name}'{suggest(name, self.channels)}")
                continue
            unit = self.units[name]
            if unit not in (STRAIN, "1", ""):
                problems.add(self.name, f"channel '{name}' is in {unit}, must be strain (m/m)")
                continue
            sentence = too_large(name, self.channels[name])
            if sentence:
                problems.add(self.name, sentence)
        problems.raise_if_any()
        return self.matrix(chosen)

    def only(self, names: Iterable[str]) -> Record:
        """Return the record with the named channels only, in their order."""
        chosen = {name: self[name] for name in names}
        return replace(self, channels=chosen, units={name: self.units[name] for name in chosen})

    def during(self, start: float | None = None, end: float | None = None) -> Record:
        """Return the record from `start` to `end`, s, both included."""
        a = -np.inf if start is None else start
        b = np.inf if end is None else end
        keep = (self.time >= a) & (self.time <= b)
        if not np.any(keep):
            raise InputError(
                Problem(
                    self.name,
                    f"nothing from {a:g} to {b:g} s; it goes from {self.time[0]:g} to "
                    f"{self.time[-1]:g} s",
                )
            )
        channels = {name: x[keep] for name, x in self.channels.items()}
        return replace(self, time=self.time[keep], channels=channels)

    def shifted(self, shift: float) -> Record:
        """Return the record with `shift`, s, added to its time."""
        return replace(self, time=self.time + shift)

    def renamed(self, names: Mapping[str, str]) -> Record:
        """Return the record with new channel names, {old: new}."""
        for name in names:
            self[name]
        channels = {names.get(name, name): x for name, x in self.channels.items()}
        units = {names.get(name, name): unit for name, unit in self.units.items()}
        return replace(self, channels=channels, units=units)

    def zeroed(self, start: float, end: float) -> Record:
        """Return the record minus each channel's mean between start and end, s.

        Strain gauges measure changes only: balance them at rest.
        """
        rest = self.during(start, end)
        channels = {}
        for name, x in self.channels.items():
            known = rest.channels[name][np.isfinite(rest.channels[name])]
            channels[name] = x - (known.mean() if len(known) else 0.0)
        return replace(self, channels=channels)

    def resample(
        self,
        rate: float | None = None,
        *,
        times: ArrayLike | None = None,
        gap: float = GAP,
        antialias: bool = True,
    ) -> Record:
        """Return the record at other instants, by cubic splines through the valid samples.

        Parameters
        ----------
        rate : float, optional
            Samples per second, with equal steps from the first instant on; without rate and times
            the usual rate of the record.
        times : (m,) array_like, optional
            Instants, s; outside the record the values are nan.
        gap : float
            Steps longer than this number of usual steps are gaps, in which values are nan.
        antialias : bool
            Whether to remove frequencies that a lower rate cannot represent, by a Butterworth
            filter of order 8, forward and backward, at 0.4 of the new rate.

        Raises
        ------
        InputError
            For invalid rates or times.
        """
        data = self.time, self.channels
        wanted, channels = resample(self.name, *data, rate, times, gap, antialias)
        return replace(self, time=wanted, channels=channels)

    def crossings(self, channel: str, level: float, direction: int = 1) -> Array:
        """Return the times at which a channel crosses a level, s, by linear interpolation.

        Parameters
        ----------
        channel : str
        level : float
            Level in SI units.
        direction : int
            1 rising, -1 falling, 0 both.
        """
        x = self[channel] - level
        a, b = x[:-1], x[1:]
        up, down = (a < 0.0) & (b >= 0.0), (a > 0.0) & (b <= 0.0)
        hit = up | down if direction == 0 else up if direction > 0 else down
        i = np.flatnonzero(hit)
        return np.asarray(self.time[i] + (self.time[i + 1] - self.time[i]) * a[i] / (a[i] - b[i]))

    def _csv(self) -> Rows:
        """Return columns of time and channels headed as ``g1 (m/m)``; missing values are empty."""
        heads = ["time (s)"]
        heads += [f"{k} ({self.units[k]})" if self.units[k] else k for k in self.channels]
        rows = np.column_stack([self.time, self.matrix()]).tolist()
        return heads, (["" if x != x else x for x in row] for row in rows)


def too_large(name: str, values: Array) -> str:
    """Return a message if values are too large for strains in m/m; else an empty text."""
    good = values[np.isfinite(values)]
    if not len(good):
        return ""
    largest = float(np.abs(good).max())
    if largest <= LARGE_STRAIN:
        return ""
    unit = likely_strain_unit(largest)
    return (
        f"channel '{name}' reaches {largest:.4g}: too large for strain in m/m, it was likely given "
        f"in {unit}; give units={{'{name}': '{unit}'}}"
    )


@explained
def record_of(run: Solution, names: Sequence[str] | None = None) -> Record:
    """Return sensors of a run as a record; several components become ``name.part``.

    Parameters
    ----------
    run : Solution
    names : sequence of str, optional
        Names of sensors; by default all.
    """
    channels: dict[str, Array] = {}
    units: dict[str, str] = {}
    for name in run.sensors if names is None else names:
        if name not in run:
            raise InputError(Problem(run.where, f"no sensor '{name}'{suggest(name, run.sensors)}"))
        about: Any = run.about(name)
        values = np.asarray(run[name])
        values = values.reshape(len(values), -1)
        parts = about["components"] if values.shape[1] > 1 else ("",)
        each = str(about["unit"]).split(", ")
        for k, (part, column) in enumerate(zip(parts, values.T, strict=True)):
            key = f"{name}.{part}" if part else name
            channels[key] = column
            units[key] = each[k * len(each) // values.shape[1]]
    return Record(np.asarray(run.time), channels, units, name=str(run.name))
