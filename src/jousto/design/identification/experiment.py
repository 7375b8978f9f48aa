"""Experiment: a measured record with what drives the model and what is compared with it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.expressions import measure
from jousto.base.object_repr import described
from jousto.design.studies.parameters.parameter import Parameter
from jousto.measurement.gauges.read import read_record
from jousto.measurement.gauges.record import Record

Number = float | Parameter
"""A fixed number, or a `Parameter` that is sought."""

LEAST = 4
"""Samples that a compared channel must have."""


@explained
@described
@dataclass(frozen=True, eq=False)
class Experiment:
    """A record of a machine in motion: its inputs, and channels to compare with sensors.

    A compared channel is modelled as ``y(t) = gain h(t - shift) + bias``, h the sensor.

    Parameters
    ----------
    record : Record or path
        The measurement; its time is that of the model, which starts at 0 s.
    outputs : dict of str to str, or sequence of str, optional
        Sensors of the model with the channel of each, ``{"x1": "laser"}``; by default every sensor
        component with a channel of its name. ``"-laser"`` is a channel of the other sign.
    inputs : dict of str to str, optional
        Inputs of the model with the channel that drives each; by default every input with a channel
        of its name. Values between samples are on straight lines, or held, see `held`.
    held : sequence of str
        Inputs whose value stays that of a sample until the next one.
    noise : dict, optional
        Standard deviation of each channel in SI units: a number, an array (nt,), the name of a
        channel that contains it, or a text such as ``"2 %"`` of the reading; also a pair of a text
        and a number. A channel that is left out has unknown noise, which is estimated.
    gain, bias, shift : dict of str to float or Parameter, optional
        For channels: factor, offset (SI units) and delay (s). A `Parameter` is sought.
    state : State or callable, optional
        State at 0 s, or a function of the model that returns it, such as `jo.equilibrium`; by
        default that of the model.
    rest : dict of str to float, optional
        The machine is at rest at 0 s, with these values of inputs: ``rest={"load": 4.0}`` for a
        load that is let go, ``rest={}`` for the position of rest.
    window : (float, float), optional
        Instants between which samples are compared, s.
    model : callable, ModelFile, Mechanism or Model, optional
        Machine of this experiment, if it is not that of the others (with a payload, for instance).
    name : str, optional
        Name for tables; by default that of the record.

    Raises
    ------
    InputError
        With all problems of the record and of what is given for its channels.

    Examples
    --------
    >>> from jousto.gauges import Record
    >>> record = Record(np.linspace(0, 1, 11), {"x": np.zeros(11)}, {"x": "m"}, "test")
    >>> Experiment(record, noise={"x": 1e-4})
    <Experiment 'test': 11 instants to 1 s>
    """

    record: Any
    outputs: Any = None
    inputs: Mapping[str, str] | None = None
    held: Sequence[str] = ()
    noise: Mapping[str, Any] = field(default_factory=dict)
    gain: Mapping[str, Number] = field(default_factory=dict)
    bias: Mapping[str, Number] = field(default_factory=dict)
    shift: Mapping[str, Number] = field(default_factory=dict)
    state: Any = None
    rest: Mapping[str, float] | None = None
    window: tuple[float, float] | None = None
    model: Any = None
    name: str = ""

    def __post_init__(self) -> None:
        if isinstance(self.record, str | Path):
            object.__setattr__(self, "record", read_record(self.record))
        if not isinstance(self.record, Record):
            message = f"record is {self.record!r:.60}, must be a Record or the path of a file"
            raise InputError(Problem("experiment", message))
        if not self.name:
            object.__setattr__(self, "name", self.record.name)
        problems = Problems()
        self._check_channels(problems)
        if self.rest is not None and self.state is not None:
            problems.add(self.where, "has a state and a rest; leave one of them out")
        for name, value in (self.rest or {}).items():
            problems.number(self.where, f"rest: {name}", value, "")
        if self.record.time[0] < 0.0:
            message = f"its time starts at {self.record.time[0]:g} s, the model at 0 s"
            problems.add(self.where, f"{message}; move it by record.shifted(...)")
        if self.window is not None:
            ends = problems.array(self.where, "window", self.window, (2,))
            if ends is not None and not ends[0] < ends[1]:
                problems.add(self.where, "window: the first instant must be below the second")
        problems.raise_if_any()

    @property
    def where(self) -> str:
        """Name in messages."""
        return f"experiment {self.name!r}"

    def _check_channels(self, problems: Problems) -> None:
        """Check the names of channels and the numbers given for them."""
        known = self.record.channels
        for what in ("noise", "gain", "bias", "shift"):
            given = getattr(self, what)
            if not isinstance(given, Mapping):
                problems.add(self.where, f"{what} is {given!r:.40}, must be a dict by channel")
                continue
            for channel, value in given.items():
                if channel not in known:
                    message = f"{what}: no channel {channel!r}{suggest(channel, known)}"
                    problems.add(self.where, message)
                elif what != "noise" and not isinstance(value, Parameter):
                    problems.number(self.where, f"{what} of {channel}", value, "")
        for name, channel in (self.inputs or {}).items():
            if channel not in known:
                message = f"input {name!r}: no channel {channel!r}{suggest(channel, known)}"
                problems.add(self.where, message)

    @property
    def free(self) -> tuple[Parameter, ...]:
        """Sought gains, biases and shifts."""
        given = (*self.gain.values(), *self.bias.values(), *self.shift.values())
        return tuple(dict.fromkeys(one for one in given if isinstance(one, Parameter)))

    def _facts(self) -> str:
        return f"{len(self.record)} instants to {self.record.time[-1]:g} s"


@dataclass(frozen=True, eq=False)
class Comparison:
    """One channel of an experiment compared with one sensor component.

    Attributes
    ----------
    channel, sensor : str
        Names.
    unit : str
        SI unit of both.
    time, y : (n,) array
        Instants, s, and measured values, without missing ones.
    sd : (n,) array or None
        Standard deviation of the noise; None if it is unknown.
    gain, bias, shift : float or Parameter
        As in `Experiment`.
    """

    channel: str
    sensor: str
    unit: str
    time: Array
    y: Array
    sd: Array | None
    gain: Number
    bias: Number
    shift: Number


def comparisons(
    problems: Problems, experiment: Experiment, sensors: Mapping[str, str]
) -> tuple[Comparison, ...]:
    """Return what is compared in an experiment, and report all problems.

    Parameters
    ----------
    problems : Problems
    experiment : Experiment
    sensors : mapping of str to str
        Names of sensor components and their SI units.
    """
    record, where = experiment.record, experiment.where
    pairs = _pairs(problems, experiment, sensors)
    driving = set((experiment.inputs or {}).values())
    found: list[Comparison] = []
    for sensor, (channel, sign) in pairs.items():
        if channel in driving:
            problems.add(where, f"channel {channel!r} drives the model and is compared, too")
        unit = record.units[channel]
        if not unit or measure(unit) != measure(sensors[sensor]):
            message = f"channel {channel!r} has {f'the unit {unit}' if unit else 'no unit'}"
            say = f"read_record(..., units={{{channel!r}: ...}})"
            problems.add(where, f"{message}; sensor {sensor!r} is in {sensors[sensor]}: {say}")
            continue
        time, y, keep = _samples(problems, experiment, channel)
        if keep is None:
            continue
        sd = _noise(problems, experiment, channel, keep)
        found.append(
            Comparison(
                channel,
                sensor,
                unit,
                time,
                sign * y,
                sd,
                experiment.gain.get(channel, 1.0),
                experiment.bias.get(channel, 0.0),
                experiment.shift.get(channel, 0.0),
            )
        )
    if not pairs:
        heads, known = ", ".join(record.channels), ", ".join(sensors) or "none"
        message = f"nothing to compare: channels {heads}; sensors {known}"
        problems.add(where, f"{message}; give outputs={{sensor: channel}}")
    compared = {one.channel for one in found}
    for what in ("noise", "gain", "bias", "shift"):
        for channel in getattr(experiment, what):
            if found and channel not in compared:
                problems.add(where, f"{what}: channel {channel!r} is not compared with a sensor")
    return tuple(found)


def _pairs(
    problems: Problems, experiment: Experiment, sensors: Mapping[str, str]
) -> dict[str, tuple[str, float]]:
    """Return the channel and its sign for each compared sensor component."""
    record, given = experiment.record, experiment.outputs
    if given is None:
        driving = set((experiment.inputs or {}).values())
        return {s: (s, 1.0) for s in sensors if s in record.channels and s not in driving}
    if isinstance(given, str):
        given = [given]
    if not isinstance(given, Mapping):
        given = {name: name for name in given}
    pairs: dict[str, tuple[str, float]] = {}
    for sensor, text in given.items():
        sign = -1.0 if text not in record and str(text).startswith("-") else 1.0
        channel = str(text)[1:] if sign < 0.0 else str(text)
        good = True
        if sensor not in sensors:
            message = f"outputs: no sensor {sensor!r}{suggest(sensor, sensors)}"
            problems.add(experiment.where, message)
            good = False
        if channel not in record:
            message = f"outputs: no channel {channel!r}{suggest(channel, record.channels)}"
            problems.add(experiment.where, message)
            good = False
        if good:
            pairs[sensor] = (channel, sign)
    return pairs


def _samples(
    problems: Problems, experiment: Experiment, channel: str
) -> tuple[Array, Array, Array | None]:
    """Return instants and values of a channel within the window, and which samples they are."""
    record = experiment.record
    y = record[channel]
    keep = np.isfinite(y)
    if experiment.window is not None:
        keep &= (record.time >= experiment.window[0]) & (record.time <= experiment.window[1])
    n = int(np.count_nonzero(keep))
    if n < LEAST:
        message = f"channel {channel!r} has {n} values to compare, must have {LEAST}"
        problems.add(experiment.where, message)
        return record.time, y, None
    if np.ptp(y[keep]) == 0.0:
        message = f"channel {channel!r} is constant ({y[keep][0]:g}): dead or not connected"
        problems.add(experiment.where, f"{message}; leave it out of outputs")
        return record.time, y, None
    return record.time[keep], y[keep], keep


def _noise(problems: Problems, experiment: Experiment, channel: str, keep: Array) -> Array | None:
    """Return the standard deviation of each kept sample; None if it is unknown."""
    given = experiment.noise.get(channel)
    if given is None:
        return None
    parts = given if isinstance(given, tuple) else (given,)
    variance = np.zeros(int(np.count_nonzero(keep)))
    for part in parts:
        sd = _sd(experiment, channel, part, keep)
        if sd is None:
            expected = "a positive number, an array (nt,), a channel, or '2 %'"
            problems.add(
                experiment.where, f"noise of {channel!r} is {part!r:.40}, must be {expected}"
            )
            return None
        variance += sd**2
    sd = np.sqrt(variance)
    if not np.all(sd > 0.0):
        message = f"noise of {channel!r} is 0 at {np.count_nonzero(sd == 0.0)} samples"
        problems.add(experiment.where, f"{message}; add an absolute part: ('2 %', 1e-6)")
        return None
    return sd


def _sd(experiment: Experiment, channel: str, part: Any, keep: Array) -> Array | None:
    """Return one part of the standard deviation; None for something else."""
    record = experiment.record
    if isinstance(part, str):
        if part in record:
            return np.asarray(np.abs(record[part][keep]))
        number, percent, rest = part.partition("%")
        try:
            share = float(number) / 100.0
        except ValueError:
            return None
        if not percent or rest.strip():
            return None
        return np.asarray(share * np.abs(record[channel][keep]))
    try:
        sd = np.asarray(part, dtype=float)
    except (TypeError, ValueError):
        return None
    if isinstance(part, bool) or not np.all(np.isfinite(sd)) or np.any(sd < 0.0):
        return None
    if sd.ndim == 0:
        return np.full(int(np.count_nonzero(keep)), float(sd)) if sd > 0.0 else None
    return np.asarray(sd[keep]) if sd.shape == keep.shape else None
