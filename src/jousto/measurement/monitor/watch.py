"""Monitoring of a stream: read, check, estimate, count and record until it ends."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import (
    LARGE_STRAIN,
    InputError,
    Problem,
    Problems,
    SimulationError,
    suggest,
    warn,
)
from jousto.base.files import reason
from jousto.measurement.monitor.alarms import Alarm
from jousto.measurement.monitor.health import STATES, Change
from jousto.measurement.monitor.monitor import Monitor, Summary, Update
from jousto.measurement.monitor.record_reader import KINDS, MonitorRecord, duration
from jousto.measurement.monitor.record_writer import Column, Layout, Record, Table
from jousto.measurement.monitor.stream import UNITS, Block, Oddity, Place, Stream, factor
from jousto.simulation.results.writer import uninterrupted

Show = Callable[["Progress"], None]

TEXT = 160  # bytes of the text of an event
# number of invalid lines that are recorded one by one; all invalid lines are counted
MOST_ODDITIES = 1000
UNLIKELY = LARGE_STRAIN  # m/m; a channel without unit that mostly exceeds this is not in m/m


@dataclass(frozen=True, eq=False)
class Progress:
    """Progress after a block, the argument of `show`.

    Attributes
    ----------
    monitor : Monitor
        Monitor with the present states, alarms and life.
    update : Update
        Results of the block.
    place : Place
        Position in the stream, with the numbers of lines and oddities.
    events : tuple of (time, kind, text)
        Events recorded with the block.
    """

    monitor: Monitor
    update: Update
    place: Place
    events: tuple[tuple[float, str, str], ...]


@explained
def watch(
    monitor: Monitor,
    source: str | Path | IO[bytes],
    path: str | Path,
    *,
    columns: Mapping[str, str] | None = None,
    unit: str | None = None,
    resume: bool = False,
    show: Show | None = None,
    text: str = "",
) -> MonitorRecord:
    """Read measured strains to their end and record the results of a monitor.

    The record is complete at every moment; after a kill `resume` continues where the last block
    ended. A file is then read from that position; of a pipe that starts again, known samples are
    skipped. Ctrl-C ends the watch and closes the record.

    Parameters
    ----------
    monitor : Monitor
        New monitor, not used before.
    source : path, "-" or binary file
        Lines of time and channels, the first of which names them: ``time [s],g1 [um/m],..``; "-"
        is the standard input.
    path : path
        Record, an HDF5 file.
    columns : mapping of str to str, optional
        Column of the source for each channel of the monitor; by default the column of the same
        name.
    unit : str, optional
        Unit of columns without a unit: "m/m", "um/m", "mm/m" or "%".
    resume : bool
        Continue the record at `path`; if there is none, a new one begins, with a warning.
    show : callable, optional
        Called with a `Progress` after every block.
    text : str
        Text stored in the record, such as the model file.

    Raises
    ------
    InputError
        If the source is empty, has no header or lacks channels, a unit is not known, or the record
        cannot be written.
    SimulationError
        If the disk is full; the record up to then remains.
    OSError
        If the source fails, after closing the record.
    """
    path = Path(path)
    with _opened(source) as (file, name):
        stream = Stream(file, name)
        pick, factors = _columns(monitor, stream, columns or {}, unit)
        unused = [name for i, name in enumerate(stream.channels) if i not in pick]
        if unused:
            warn(stream.name, f"columns that no gauge uses: {', '.join(unused)}")
        layout = _layout(monitor, text)
        if resume and not path.exists():
            warn(str(path), "no such record to continue; a new one begins")
            resume = False
        if resume:
            record, memory = Record.resume(path, layout)
            try:
                if memory:
                    _go_on(stream, memory)
                    monitor.load(memory)
            except BaseException:
                record.close("could not go on", complete=False)
                raise
        else:
            record = Record.create(path, layout)
        run = _Run(monitor, stream, record, pick, factors, columns or {}, unit, show)
        run.note(stream.place.time, "resumed" if resume else "start", f"watching {name}")
        try:
            _to_its_end(run)
        except OSError as error:
            if error.filename != str(path):
                raise
            raise SimulationError(
                f"{path}: cannot be written: {reason(path, error)}, and go on with resume; what was"
                " recorded is kept",
                time=stream.place.time,
            ) from error
    return MonitorRecord(path)


def _to_its_end(run: _Run) -> None:
    """Process all blocks of the source and close the record, also after an exception."""
    ended, complete = "stopped", False
    try:
        run.all()
        ended, complete = "the source ended", True
    except KeyboardInterrupt:
        ended = "stopped by Ctrl-C"
    except BaseException as error:
        ended = f"{type(error).__name__}: {error}"
        raise
    finally:
        with uninterrupted():
            try:
                run.finish(ended)
            finally:
                run.record.close(ended, complete=complete)


class _Run:
    """Processing of the blocks of one monitoring run."""

    def __init__(
        self,
        monitor: Monitor,
        stream: Stream,
        record: Record,
        pick: NDArray[np.intp],
        factors: Array,
        columns: Mapping[str, str],
        unit: str | None,
        show: Show | None,
    ) -> None:
        self.monitor = monitor
        self.stream = stream
        self.record = record
        self.pick = pick
        self.factors = factors
        self.header = stream.header
        self.columns = columns
        self.unit = unit
        self.show = show
        self.events: list[tuple[float, str, str]] = []
        self.odd = 0

    def all(self) -> None:
        for block in self.stream.blocks():
            with uninterrupted():
                self.take(block)

    def take(self, block: Block) -> None:
        if self.stream.header is not self.header:  # the units followed the names
            self.header = self.stream.header
            self.pick, self.factors = _columns(self.monitor, self.stream, self.columns, self.unit)
        values = block.values[:, self.pick] * self.factors
        self._plausible(values)
        for oddity in block.oddities:
            self._record_invalid_line(oddity)
        update = self.monitor.push(block.time, values, block.cells[:, self.pick])
        for change in update.changes:
            self._changed(change)
        for alarm in update.alarms:
            self.note(alarm.time, "alarm", alarm_text(alarm))
        self.record.append(
            "samples",
            {
                "time": update.time,
                "strain": values,
                "states": update.states,
                "stress": update.stress,
                "low": update.low,
                "high": update.high,
            },
        )
        self._summaries(update.summaries)
        shown = self._write_events()
        place = self.stream.place
        memory = self.monitor.save()
        self.record.checkpoint({**memory, "place": place.numbers(), "odd": np.array([self.odd])})
        if self.show is not None:
            self.show(Progress(self.monitor, update, place, shown))

    def finish(self, ended: str) -> None:
        alarms, summaries = self.monitor.finish()
        for alarm in alarms:
            self.note(alarm.time, "alarm", alarm_text(alarm))
        self._summaries(summaries)
        self.note(self.stream.place.time, "end", ended)
        self._write_events()

    def note(self, time: float, kind: str, text: str) -> None:
        self.events.append((time, kind, text))

    def _record_invalid_line(self, oddity: Oddity) -> None:
        self.odd += 1
        if self.odd <= MOST_ODDITIES or oddity.kind in ("clock", "gap"):
            self.note(oddity.time, oddity.kind, f"line {oddity.line}: {oddity.message}")

    def _changed(self, change: Change) -> None:
        if change.after != "back":
            before = "" if change.before == "back" else f", was {change.before}"
            self.note(change.time, "channel", f"{change.channel}: {change.after}{before}")

    def _summaries(self, summaries: tuple[Summary, ...]) -> None:
        if not summaries:
            return
        place = self.stream.place
        rows: dict[str, Any] = {
            "time": [s.time for s in summaries],
            "samples": [s.samples for s in summaries],
            "blind": [s.blind for s in summaries],
            "garbage": len(summaries) * [place.garbage],
            "backwards": len(summaries) * [place.backwards],
            "peak": [s.peak for s in summaries],
        }
        if self.monitor.meter is not None:
            rows["watched"] = [s.life.watched for s in summaries if s.life]
            for name in LIFE:
                rows[name] = [getattr(s.life, name) for s in summaries]
        self.record.append("summary", rows)

    def _write_events(self) -> tuple[tuple[float, str, str], ...]:
        self.events.sort(key=lambda event: -np.inf if np.isnan(event[0]) else event[0])
        texts = np.zeros((len(self.events), TEXT), dtype=np.uint8)
        for row, (_, _, text) in zip(texts, self.events, strict=True):
            data = text.encode()[:TEXT]
            row[: len(data)] = np.frombuffer(data, dtype=np.uint8)
        self.record.append(
            "events",
            {
                "time": np.array([time for time, _, _ in self.events]),
                "kind": np.array([KINDS.index(kind) for _, kind, _ in self.events], dtype=np.uint8),
                "text": texts,
            },
        )
        written = tuple(self.events)
        self.events.clear()
        return written

    def _plausible(self, values: Array) -> None:
        """Raise InputError if the first values of a stream are too large for strains in m/m."""
        if np.isfinite(self.stream.place.step) and self.record.rows["samples"]:
            return
        wrong = [
            self.monitor.channels[c]
            for c in range(values.shape[1])
            if self.unit is None
            and self.factors[c] == 1.0
            and np.isfinite(values[:, c]).any()
            and np.nanmedian(np.abs(values[:, c])) > UNLIKELY
        ]
        if wrong:
            size = np.nanmax(np.abs(values[:, self.monitor.channels.index(wrong[0])]))
            raise InputError(
                Problem(
                    self.stream.name,
                    f"{', '.join(wrong)}: values up to {size:.4g} are not strains in m/m; give "
                    f"the unit in the header, {wrong[0]} [um/m], or with unit: um/m",
                )
            )


LIFE = (
    "damage",
    "damage_low",
    "damage_high",
    "remaining",
    "remaining_low",
    "remaining_high",
)


def alarm_text(alarm: Alarm) -> str:
    """Return the text of an alarm."""
    at = f" at {alarm.place}" if alarm.place else ""
    if alarm.kind == "stress":
        what = f"stress {alarm.value / 1e6:.4g} MPa{at}, limit {alarm.limit / 1e6:.4g} MPa"
    elif alarm.kind == "damage":
        what = f"damage {alarm.value:.4g}{at}, limit {alarm.limit:.4g}"
    elif alarm.kind == "life":
        what = f"remaining life {duration(alarm.value)}{at}, limit {duration(alarm.limit)}"
    else:
        what = f"{alarm.value:.0f} channels are left, at least {alarm.limit:.0f} wanted"
    return f"{'ALARM' if alarm.on else 'over'}: {what}"


@contextmanager
def _opened(source: str | Path | IO[bytes]) -> Iterator[tuple[IO[bytes], str]]:
    if isinstance(source, str | Path):
        if str(source) == "-":
            yield sys.stdin.buffer, "standard input"
            return
        path = Path(source)
        try:
            file = open(path, "rb")
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputError(Problem(str(path), f"cannot be read: {reason}")) from error
        with file:
            yield file, path.name
        return
    yield source, str(getattr(source, "name", "stream"))


def _columns(
    monitor: Monitor, stream: Stream, columns: Mapping[str, str], unit: str | None
) -> tuple[NDArray[np.intp], Array]:
    """Return the column of each channel and its factor to m/m."""
    problems = Problems()
    header = stream.header
    assert header is not None
    known = list(header.names)
    for name in known:
        if known.count(name) > 1:
            problems.add(stream.name, f"column '{name}' is there more than once")
            break
    for name in columns:
        if name not in monitor.channels:
            problems.add("columns", f"no channel '{name}'{suggest(name, monitor.channels)}")
    pick, factors = [], []
    for name in monitor.channels:
        column = columns.get(name, name)
        if column not in known:
            problems.add(stream.name, f"no column '{column}' for '{name}'{suggest(column, known)}")
            continue
        at = known.index(column)
        pick.append(at)
        written = header.units[at] or (unit or "")
        scale = factor(written)
        if scale is None:
            problems.add(
                stream.name,
                f"column '{column}' is in '{written}', which is not a unit of strain; known: "
                f"{', '.join(u for u in UNITS if u)}",
            )
        factors.append(scale or 1.0)
    problems.raise_if_any()
    return np.array(pick, dtype=np.intp), np.array(factors)


def _go_on(stream: Stream, memory: dict[str, Array]) -> None:
    """Move a stream to the position at which the record ended."""
    place = Place.from_numbers(memory.pop("place"))
    if stream.source.seekable():
        end = stream.source.seek(0, 2)
        if place.offset > end:
            raise InputError(
                Problem(
                    stream.name,
                    f"has {end} bytes, but {place.offset} were read before; it is another file",
                )
            )
        stream.continue_at(place)
    else:
        stream.continue_at(place, origin=float(memory["monitor"][2]))


def _layout(monitor: Monitor, text: str) -> Layout:
    nc, ns = len(monitor.channels), len(monitor.spots)

    def column(
        name: str, width: int = 0, unit: str = "1", about: str = "", kind: str = "<f8"
    ) -> Column:
        return Column(name, width, kind, {"unit": unit, "description": about})

    summary = [
        column("time", 0, "s", "last instant of the interval"),
        column("samples", 0, "1", "instants of the interval", "<i8"),
        column("blind", 0, "1", "instants at which too few channels were left", "<i8"),
        column("garbage", 0, "1", "invalid lines so far", "<i8"),
        column("backwards", 0, "1", "lines whose time goes backwards so far", "<i8"),
        column("peak", ns, "Pa", "largest magnitude in the interval"),
    ]
    if monitor.meter is not None:
        summary.append(column("watched", 0, "s", "time that was watched so far"))
        for name in LIFE:
            unit = "1" if name.startswith("damage") else "s"
            summary.append(column(name, ns, unit, name.replace("_", ", ") + " end of the band"))
    tables = (
        Table(
            "samples",
            (
                column("time", 0, "s"),
                column("strain", nc, "m/m", "as measured"),
                column("states", nc, "1", f"of the channels: {', '.join(STATES)}", "|u1"),
                column("stress", ns, "Pa", monitor.criterion),
                column("low", ns, "Pa", f"{100 * monitor.level:g} % band, lower end"),
                column("high", ns, "Pa", f"{100 * monitor.level:g} % band, upper end"),
            ),
        ),
        Table("summary", tuple(summary)),
        Table(
            "events",
            (
                column("time", 0, "s"),
                column("kind", 0, "1", ", ".join(KINDS), "|u1"),
                column("text", TEXT, "1", "UTF-8", "|u1"),
            ),
        ),
    )
    limits = monitor.limits
    attrs = {
        "criterion": monitor.criterion,
        "level": monitor.level,
        "every": monitor.every,
        "residue": monitor.residue if monitor.meter is not None else "",
        "curve": str(monitor.sn) if monitor.sn is not None else "",
        **{
            f"limit_{name}": float(value)
            for name in ("stress", "damage", "life", "channels")
            if (value := getattr(limits, name)) is not None
        },
    }
    fixed = {"channels": monitor.channels, "spots": monitor.spots, "model": text}
    return Layout(tables, fixed, attrs)
