"""Comparison of measured gauges with virtual ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.base.units import shown_unit
from jousto.measurement.gauges.align import Alignment, align as align_records
from jousto.measurement.gauges.record import Record, record_of
from jousto.measurement.gauges.units import STRAIN
from jousto.mechanism.sensors.bridge import quarter_bridge_strain

if TYPE_CHECKING:
    from jousto.simulation.results.solution import Solution


@described
@dataclass(frozen=True, eq=False)
class GaugePair:
    """One measured channel and its virtual gauge at the instants of the record.

    Attributes
    ----------
    channel, sensor : str
        Names in the record and in the run.
    unit : str
        SI unit of both.
    measured, virtual : (nt,) array
        Values; nan where one of both is unknown.
    correlation : float
        Correlation coefficient of both, -1 to 1.
    scale : float
        Factor on the virtual gauge that fits the measured channel best.
    rms : float
        Root mean square of the difference.
    """

    channel: str
    sensor: str
    unit: str
    measured: Array
    virtual: Array
    correlation: float
    scale: float
    rms: float


@described
@dataclass(frozen=True, eq=False)
class GaugeComparison(Tabular):
    """Measured channels and the gauges of a run, pair by pair.

    Attributes
    ----------
    time : (nt,) array
        Instants of the record on the clock of the run, s.
    pairs : tuple of GaugePair
    alignment : Alignment or None
        Time shift of the record.
    """

    time: Array
    pairs: tuple[GaugePair, ...]
    alignment: Alignment | None = None

    def __str__(self) -> str:
        """Return a table of the pairs: strain in um/m, bridges in mV/V, stress in MPa."""
        width = max(len(p.channel) for p in self.pairs)
        other = max(max(len(p.sensor) for p in self.pairs), 7)
        lines = [
            f"{'channel':{width}}  {'virtual':{other}}  {'unit':5} {'measured':>10} "
            f"{'virtual':>10} {'rms diff.':>10} {'scale':>7} {'corr.':>7}"
        ]
        for p in self.pairs:
            unit, factor = shown_unit(p.unit)
            high = [float(np.nanmax(np.abs(x))) * factor for x in (p.measured, p.virtual)]
            lines.append(
                f"{p.channel:{width}}  {p.sensor:{other}}  {unit:5} {high[0]:10.4g} "
                f"{high[1]:10.4g} {factor * p.rms:10.4g} {p.scale:7.3f} {p.correlation:7.4f}"
            )
        lines += [hint for hint in map(likely_unit, self.pairs) if hint]
        if self.alignment is not None:
            lines.append(f"aligned: {self.alignment}")
        return "\n".join(lines)

    def record(self) -> Record:
        """Return a record with channels ``name measured`` and ``name virtual``."""
        channels, units = {}, {}
        for p in self.pairs:
            for word, x in (("measured", p.measured), ("virtual", p.virtual)):
                channels[f"{p.channel} {word}"] = x
                units[f"{p.channel} {word}"] = p.unit
        return Record(self.time, channels, units, name="comparison")

    def _csv(self) -> Rows:
        """Return the columns of a CSV file: both values of each pair over time."""
        return self.record()._csv()


def likely_unit(pair: GaugePair) -> str:
    """Return a message if the scale suggests another unit of strain; else an empty text."""
    if pair.unit != STRAIN or not abs(pair.correlation) > 0.9:
        return ""
    for factor, unit, remedy in (
        (1e2, "percent", "divide it by 100"),
        (1e6, "um/m", "divide it by 1e6"),
        (1e3, "mm/m", "divide it by 1000"),
        (1e-2, "m/m but was taken as percent", "multiply it by 100"),
        (1e-3, "m/m but was taken as mm/m", "multiply it by 1000"),
        (1e-6, "m/m but was taken as um/m", "multiply it by 1e6"),
    ):
        if 0.5 < abs(pair.scale) / factor < 2.0:
            return (
                f"'{pair.channel}' is about {factor:g} times '{pair.sensor}' with the same course: "
                f"it was probably given in {unit}; {remedy}, or name its unit"
            )
    return ""


@explained
def compare_gauges(
    run: Solution,
    measured: Record,
    *,
    pairs: Mapping[str, str] | None = None,
    align: str | bool = True,
    level: float | None = None,
    max_shift: float | None = None,
    gauge_factor: float = 2.0,
) -> GaugeComparison:
    """Return measured channels and the gauges of a run at the same instants.

    Parameters
    ----------
    run : Solution
        Results with gauges, rosettes or bridges among the sensors (any sensor will do).
    measured : Record
    pairs : mapping of str to str, optional
        Sensor of each channel (``"r.b"`` for a component); by default the sensor of the same name,
        upper or lower case.
    align : str or bool
        Channel for the alignment in time; True: the first pair, False: no alignment.
    level, max_shift : float, optional
        Options of `align`.
    gauge_factor : float
        Gauge factor for channels in V/V whose sensor is a strain (quarter bridges).

    Raises
    ------
    InputError
        With all problems: no pairs, or different units.
    """
    virtual = record_of(run)
    chosen = _pairs(measured, virtual, pairs)
    problems = Problems()
    channels: dict[str, Array] = {}
    for a, b in chosen.items():
        x, unit, wanted = measured[a], measured.units[a], virtual.units[b]
        if unit == "V/V" and wanted == STRAIN:
            x, unit = quarter_bridge_strain(x, gauge_factor), STRAIN
        if unit not in (wanted, "") and wanted != "1":
            problems.add(
                measured.name, f"channel '{a}' is in {unit}, sensor '{b}' of the run in {wanted}"
            )
        channels[a] = x
    problems.raise_if_any()
    record = Record(
        measured.time, channels, {a: virtual.units[b] for a, b in chosen.items()}, measured.name
    )
    alignment = None
    if align is not False:
        by = next(iter(chosen)) if align is True else str(align)
        if by not in chosen:
            raise InputError(Problem("align", f"no channel '{by}'{suggest(by, chosen)}"))
        alignment = align_records(record, virtual, by, chosen[by], level=level, max_shift=max_shift)
        record = alignment.record
    at = virtual.resample(times=record.time, gap=1e9, antialias=False)
    inside = (record.time >= virtual.time[0]) & (record.time <= virtual.time[-1])
    if not inside.any():
        raise InputError(
            Problem(
                measured.name,
                f"its time, {record.time[0]:g} to {record.time[-1]:g} s, does not overlap with the "
                f"run, {virtual.time[0]:g} to {virtual.time[-1]:g} s; align it",
            )
        )
    found = [_pair(a, b, virtual.units[b], record[a], at[b]) for a, b in chosen.items()]
    return GaugeComparison(record.time, tuple(found), alignment)


def _pairs(measured: Record, virtual: Record, given: Mapping[str, str] | None) -> dict[str, str]:
    problems = Problems()
    if given is not None:
        for a, b in given.items():
            if a not in measured:
                problems.add(measured.name, f"no channel '{a}'{suggest(a, measured.channels)}")
            if b not in virtual:
                problems.add(virtual.name, f"no sensor '{b}'{suggest(b, virtual.channels)}")
        if not given:
            problems.add("pairs", "is empty; None takes those of equal names")
        problems.raise_if_any()
        return dict(given)
    lower = {name.lower(): name for name in virtual.channels}
    found = {a: lower[a.lower()] for a in measured.channels if a.lower() in lower}
    if not found:
        raise InputError(
            Problem(
                measured.name,
                f"none of its channels ({', '.join(list(measured.channels)[:6])}) has the name "
                f"of a sensor of the run ({', '.join(list(virtual.channels)[:6])}); name the "
                "pairs, "
                "{channel: sensor}",
            )
        )
    left = [a for a in measured.channels if a not in found]
    if left:
        warn(measured.name, f"channels without a sensor in the run: {', '.join(left)}")
    return found


def _pair(channel: str, sensor: str, unit: str, x: Array, y: Array) -> GaugePair:
    both = np.isfinite(x) & np.isfinite(y)
    u, v = x[both], y[both]
    nothing = float("nan")
    if len(u) < 3:
        return GaugePair(channel, sensor, unit, x, y, nothing, nothing, nothing)
    du, dv = u - u.mean(), v - v.mean()
    uu, vv, uv = float(du @ du), float(dv @ dv), float(du @ dv)
    correlation = uv / np.sqrt(uu * vv) if uu * vv > 0.0 else nothing
    scale = uv / vv if vv > 0.0 else nothing
    rms = float(np.sqrt(np.mean((u - v) ** 2)))
    return GaugePair(channel, sensor, unit, x, y, correlation, scale, rms)
