"""Stream of measured channels: lines of numbers from a file or a pipe.

One line is one instant: time, then a value for each channel. No content of a line stops the reader:
invalid lines are counted and reported, and the next line is read. Memory is bounded for streams and
lines of any length.
"""

from __future__ import annotations

import math
import re
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import IO

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, count
from jousto.base.files import ENDLESS, ENDLESS_LINE
from jousto.measurement.gauges.units import UNITS as UNITS_OF_LOGGERS

PIECE = 1 << 16  # bytes per read call
LINES = 512  # lines per block; constant for files, so that repeated runs are identical to the bit
LONGEST = 1 << 16  # longest valid line, bytes
HEADER_WITHIN = 1000  # lines within which the header must occur
CONFIRM = 5  # consecutive lines that confirm a jump of time
LEAP = 1000.0  # length of a jump that needs confirmation, in time steps; see also the next constant
LEAST_LEAP = 10.0  # the same limit in seconds

PRESENT, EMPTY, NOT_A_NUMBER, INFINITE = range(4)
"""Content of a cell."""

STRAINS = ("1", "m/m", "mm/m", "um/m", "ue", "ustrain", "microstrain", "%")
UNITS = {"": 1.0, **{unit: UNITS_OF_LOGGERS[unit][1] for unit in STRAINS}}
SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0}


@dataclass(frozen=True)
class Header:
    """Meaning of the columns.

    Attributes
    ----------
    names : tuple of str
        Channels, without the time.
    units : tuple of str
        Unit of each channel as written, empty if none was.
    time_factor : float
        Seconds per unit of time.
    separator : str
        Separator between cells.
    comma : bool
        Whether numbers have a decimal comma.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    time_factor: float
    separator: str
    comma: bool


@dataclass(frozen=True)
class Oddity:
    """Invalid content of the stream, with its place.

    Attributes
    ----------
    kind : str
        "garbage", "backwards", "clock", "gap".
    line : int
        Line number from 1.
    time : float
        Last time before it, s; nan if none.
    message : str
    """

    kind: str
    line: int
    time: float
    message: str


@dataclass(frozen=True)
class Block:
    """Consecutive instants of the stream.

    Attributes
    ----------
    time : (k,) array
        s, increasing.
    values : (k, nc) array
        Values in the unit of the source; nan where there was no number.
    cells : (k, nc) uint8 array
        PRESENT, EMPTY, NOT_A_NUMBER or INFINITE.
    oddities : tuple of Oddity
        Invalid lines in this block.
    """

    time: Array
    values: Array
    cells: NDArray[np.uint8]
    oddities: tuple[Oddity, ...] = ()

    def __len__(self) -> int:
        return len(self.time)


@dataclass
class Place:
    """Position in a stream from which reading continues exactly.

    Attributes
    ----------
    offset : int
        Number of bytes before the first unused line.
    line : int
        Number of lines before it.
    time, step, shift : float
        Last time, the step before it, and the shift added to times after the clock was set back, s.
    garbage, backwards, clock, gaps : int
        Numbers of invalid lines, lines whose time goes backwards, clock resets, and pauses.
    """

    offset: int = 0
    line: int = 0
    time: float = math.nan
    step: float = math.nan
    shift: float = 0.0
    garbage: int = 0
    backwards: int = 0
    clock: int = 0
    gaps: int = 0

    def numbers(self) -> Array:
        """Return the position as an array of numbers."""
        return np.array([float(getattr(self, name)) for name in PLACE])

    @classmethod
    def from_numbers(cls, values: Array) -> Place:
        """Return the position from the array of `numbers`."""
        place = cls()
        for name, x in zip(PLACE, values, strict=True):
            setattr(place, name, type(getattr(place, name))(x))
        return place


PLACE = ("offset", "line", "time", "step", "shift", "garbage", "backwards", "clock", "gaps")


@dataclass(frozen=True)
class _Row:
    """Valid line whose time is not confirmed yet."""

    time: float
    values: list[float]
    cells: list[int]
    line: int
    start: int  # byte offset of the line


@dataclass
class Stream:
    """Reader of blocks of instants from an open binary file.

    Parameters
    ----------
    source : binary file
        A file, or a pipe.
    name : str
        Name in messages.
    place : Place, optional
        Position where reading continues; the source must be positioned at ``place.offset``.
    header : Header, optional
        Header from the beginning, if reading continues; by default it is read from the source.

    Raises
    ------
    InputError
        If the source is empty or has no header.
    """

    source: IO[bytes]
    name: str
    place: Place = field(default_factory=Place)
    header: Header | None = None
    _rest: bytearray = field(default_factory=bytearray, repr=False)
    _too_long: bool = False
    _thrown: int = 0  # bytes of a line that exceeds the longest valid length
    _held: deque[_Row] = field(default_factory=deque, repr=False)
    _ended: bool = False
    _read: int = 0  # byte offset of the next line

    def __post_init__(self) -> None:
        self._read = self.place.offset
        self._line = self.place.line
        self._oddities: list[Oddity] = []
        self._queue: deque[tuple[int, bytes]] = deque()
        self._origin: float | None = None  # first time of a pipe, to detect a restart
        self._skip = False
        self._known = 0  # number of invalid lines of a pipe that were reported before its restart
        # invalid lines found before it is known whether the pipe was restarted
        self._unsure: list[Oddity] = []
        self._whole = bool(self.source.seekable())
        self._headed = False  # whether the next line of text may contain the units
        if self.header is None:
            self.header = self._find_header()

    def continue_at(self, place: Place, origin: float | None = None) -> None:
        """Continue at a position after the header.

        Parameters
        ----------
        place : Place
            Position where reading ended before.
        origin : float, optional
            First time of a pipe that was read before. If the pipe begins there again, all
            that was read is skipped.
        """
        if origin is None:
            self._rest.clear()
            self._queue.clear()
            self._ended = False
            self._headed = False
            self.source.seek(place.offset)
            self.place, self._read, self._line = place, place.offset, place.line
            return
        place.offset, place.line = self.place.offset, self.place.line
        self.place, self._origin = place, origin
        self._known, self._unsure, self._oddities = place.garbage, self._oddities, []

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels."""
        assert self.header is not None
        return self.header.names

    def blocks(self) -> Iterator[Block]:
        """Yield blocks of instants until the source ends, without delay for incomplete blocks."""
        queue = self._queue
        while True:
            while len(queue) < LINES and not self._ended:
                queue.extend(self._lines())
                if not self._whole:
                    break
            lines = [queue.popleft() for _ in range(min(LINES, len(queue)))]
            block = self._parse(lines)
            if len(block) or block.oddities:
                yield block
            if self._ended and not queue:
                return

    # -- bytes to lines ---------------------------------------------------------------------------

    def _lines(self) -> list[tuple[int, bytes]]:
        """Return the complete lines (byte offset, text) of the next piece."""
        # bytes that were read beyond the header
        waiting = b"\n" in self._rest
        read = getattr(self.source, "read1", self.source.read)
        piece = b"" if waiting else read(PIECE)
        if not piece and not waiting:
            self._ended = True
            last = bytes(self._rest)
            self._rest.clear()
            return [(self._took(len(last)), last)] if last.strip() or self._too_long else []
        self._rest += piece
        lines: list[tuple[int, bytes]] = []
        at = 0
        while (end := self._rest.find(b"\n", at)) >= 0:
            text = bytes(self._rest[at:end])
            if self._too_long:  # end of a line that was too long
                text, self._too_long = b"\0", False
            lines.append((self._took(end + 1 - at), text))
            at = end + 1
        del self._rest[:at]
        self._thrown = 0 if lines else self._thrown
        if len(self._rest) > LONGEST or self._too_long:
            self._read += len(self._rest)
            self._thrown += len(self._rest)
            self._rest.clear()
            self._too_long = True
        if self._thrown > ENDLESS:
            raise InputError(Problem(self.name, ENDLESS_LINE))
        return lines

    def _took(self, length: int) -> int:
        start = self._read
        self._read += length
        return start

    # -- header -----------------------------------------------------------------------------------

    def _find_header(self) -> Header:
        seen = 0
        while not self._ended:
            lines = self._lines()
            for k, (_, raw) in enumerate(lines):
                text = _text(raw)
                self._line += 1
                if not text or text[0] in "#%":
                    continue
                seen += 1
                found = read_header(text)
                if found is None and seen < HEADER_WITHIN:
                    if _numbers(text):
                        raise InputError(
                            Problem(
                                f"{self.name}:{self._line}",
                                f"numbers before a header: {_shorten(text)}; the first line must "
                                "name the columns, such as time [s],g1 [um/m],g2 [um/m]",
                            )
                        )
                    self._report("garbage", f"no header yet: {_shorten(text)}")
                    self.place.garbage += 1
                    continue
                if found is None:
                    break
                rest = lines[k + 1 :]
                if self._whole:
                    self._read_on(rest)
                # the header of a pipe may not have arrived yet
                self._headed = not any(map(_has_content, rest))
                found, used = _with_unit_row(found, rest)
                # parse the lines after the header again as numbers
                back = b"".join(raw + b"\n" for _, raw in rest[used:])
                self._line += used
                self._read -= len(back)
                self._rest[:0] = back
                self.place.offset, self.place.line = self._read, self._line
                self._ended = False
                return found
            if seen >= HEADER_WITHIN:
                break
        if not seen:
            raise InputError(Problem(self.name, "is empty; nothing was measured"))
        raise InputError(
            Problem(
                self.name,
                f"no header in the first {count(seen, 'line')}; one line must name the columns, "
                "the time first, such as time [s],g1 [um/m],g2 [um/m]",
            )
        )

    def _read_on(self, lines: list[tuple[int, bytes]]) -> None:
        """Read lines until one of them is neither empty nor a comment."""
        while not self._ended and not any(map(_has_content, lines)):
            lines += self._lines()

    # -- lines to numbers -------------------------------------------------------------------------

    def _parse(self, lines: list[tuple[int, bytes]]) -> Block:
        assert self.header is not None
        rows: list[_Row] = []
        for start, raw in lines:
            self._line += 1
            text = _text(raw)
            if not text and b"\0" not in raw:
                continue
            if self._headed and _has_content((start, raw)):
                self._headed = False
                self.header, used = _with_unit_row(self.header, [(start, raw)])
                if used:
                    continue
            row = self._row(text, start) if text else None
            if row is None:
                if not text.startswith("#"):
                    self._report_invalid(text)
                continue
            self._order(row, rows)
        if self._ended and not self._queue:
            for held in self._held:
                self._drop(held)
            self._held.clear()
        first = self._held[0] if self._held else None
        unread = self._queue[0][0] if self._queue else self._read
        self.place.offset = unread if first is None else first.start
        self.place.line = self._line if first is None else first.line - 1
        oddities, self._oddities = tuple(self._oddities), []
        nc = len(self.channels)
        return Block(
            np.array([row.time for row in rows]),
            np.array([row.values for row in rows], dtype=np.float64).reshape(-1, nc),
            np.array([row.cells for row in rows], dtype=np.uint8).reshape(-1, nc),
            oddities,
        )

    def _report_invalid(self, text: str) -> None:
        """Count and report an invalid line, unless it was reported before the pipe's restart."""
        message = f"no line of {len(self.channels) + 1} numbers: {_shorten(text)}"
        if self._origin is not None and len(self._unsure) < self._known:
            self._unsure.append(Oddity("garbage", self._line, self.place.time, message))
        elif self._skip and self._known:
            self._known -= 1
        else:
            self.place.garbage += 1
            self._report("garbage", message)

    def _row(self, text: str, start: int) -> _Row | None:
        header = self.header
        assert header is not None
        cells = text.split(header.separator) if header.separator != " " else text.split()
        if len(cells) != len(header.names) + 1:
            return None
        if header.comma:
            cells = [cell.replace(",", ".") for cell in cells]
        time = _number(cells[0])
        if time is None or not math.isfinite(time):
            return None
        values, kinds = [], []
        for cell in cells[1:]:
            cell = cell.strip()
            x = _number(cell) if cell else None
            if x is not None and math.isfinite(x):
                kind = PRESENT
            elif not cell:
                kind = EMPTY
            else:
                kind = INFINITE if x is not None and math.isinf(x) else NOT_A_NUMBER
            values.append(x if kind == PRESENT and x is not None else math.nan)
            kinds.append(kind)
        return _Row(time * header.time_factor, values, kinds, self._line, start)

    def _order(self, row: _Row, rows: list[_Row]) -> None:
        """Accept a row with increasing time; store other rows until enough of them agree."""
        place = self.place
        time = row.time + place.shift
        if self._origin is not None:
            self._skip = row.time <= self._origin + 1e-9 * abs(self._origin)
            self._origin = None
            if self._skip:
                self._known -= len(self._unsure)
            else:
                place.garbage += len(self._unsure)
                self._oddities += self._unsure
            self._unsure = []
        if self._skip and time <= place.time:
            return
        self._skip = False
        if self._follows(place.time, time, place.step):
            for held in self._held:
                self._drop(held)
            self._held.clear()
            self._take(row, time, rows)
            return
        last = self._held[-1] if self._held else None
        if last is not None and not self._follows(last.time, row.time, place.step):
            for held in self._held:
                self._drop(held)
            self._held.clear()
        self._held.append(row)
        if len(self._held) < CONFIRM:
            return
        # confirmed jump: the clock was set back, or the logger paused
        agreed = list(self._held)
        self._held.clear()
        before = place.time
        if agreed[0].time + place.shift > before:
            place.gaps += 1
            pause = agreed[0].time + place.shift - before
            self._report("gap", f"nothing for {pause:.6g} s", agreed[0].line)
        else:
            step = place.step if math.isfinite(place.step) else agreed[1].time - agreed[0].time
            back = before - agreed[0].time - place.shift
            place.shift = before + step - agreed[0].time
            place.clock += 1
            self._report(
                "clock", f"the clock was set back by {back:.6g} s; time continues", agreed[0].line
            )
        for one in agreed:
            self._take(one, one.time + place.shift, rows)

    @staticmethod
    def _follows(before: float, time: float, step: float) -> bool:
        if math.isnan(before):
            return True
        leap = max(LEAST_LEAP, LEAP * step if math.isfinite(step) else 0.0)
        return 0.0 < time - before <= leap

    def _take(self, row: _Row, time: float, rows: list[_Row]) -> None:
        place = self.place
        if math.isfinite(place.time):
            place.step = time - place.time
        place.time = time
        rows.append(_Row(time, row.values, row.cells, row.line, row.start))

    def _drop(self, row: _Row) -> None:
        time = row.time + self.place.shift
        if time > self.place.time:
            self.place.garbage += 1
            self._report("garbage", f"time {time:.9g} s is far ahead of its neighbours", row.line)
            return
        self.place.backwards += 1
        what = "stands still" if time == self.place.time else "goes backwards"
        self._report("backwards", f"time {what}: {time:.9g} s", row.line)

    def _report(self, kind: str, message: str, line: int | None = None) -> None:
        at = self._line if line is None else line
        self._oddities.append(Oddity(kind, at, self.place.time, message))


def read_header(text: str) -> Header | None:
    """Return the content of a header line; None unless its first column is the time.

    Examples
    --------
    >>> read_header("time [ms]; g1 (um/m); g2").names
    ('g1', 'g2')
    """
    for separator in (";", "\t", ",", " "):
        if separator in text.strip():
            break
    cells = [cell.strip().strip('"') for cell in text.split(separator)]
    if separator == " ":
        cells = text.split()
    if len(cells) < 2 or not all(cells):
        return None
    named = [_name_and_unit(cell) for cell in cells]
    first, unit = named[0]
    if first.lower() not in ("t", "time", "zeit", "aika", "seconds", "s", "sec"):
        return None
    if unit not in SECONDS or any(_number(name) is not None for name, _ in named[1:]):
        return None
    return Header(
        tuple(name for name, _ in named[1:]),
        tuple(unit for _, unit in named[1:]),
        SECONDS[unit],
        separator,
        separator == ";",
    )


def factor(unit: str) -> float | None:
    """Return the factor from a unit of strain to m/m; None for an unknown unit."""
    return UNITS.get(unit.replace("µ", "u").replace("μ", "u").replace("ε", "e").strip())


def _with_unit_row(header: Header, lines: list[tuple[int, bytes]]) -> tuple[Header, int]:
    """Return the header with the units of a second heading row, and the number of lines used."""
    at = next((k for k, line in enumerate(lines) if _has_content(line)), None)
    if at is None:
        return header, 0
    cells = [cell.strip().strip("[]() ") for cell in _text(lines[at][1]).split(header.separator)]
    if len(cells) != len(header.names) + 1 or cells[0] not in SECONDS or not cells[0]:
        return header, 0
    if any(_number(cell) is not None and cell != "1" for cell in cells):
        return header, 0
    return (
        Header(
            header.names,
            tuple(u or own for u, own in zip(cells[1:], header.units, strict=True)),
            SECONDS[cells[0]],
            header.separator,
            header.comma,
        ),
        at + 1,
    )


def _has_content(line: tuple[int, bytes]) -> bool:
    """Return whether a line is neither empty nor a comment."""
    text = _text(line[1])
    return bool(text) and text[0] not in "#%"


def _name_and_unit(cell: str) -> tuple[str, str]:
    if not cell.endswith(("]", ")")):
        return cell, ""
    # the first bracket from which every bracket is closed
    start = max(cell.rfind("]", 0, -1), cell.rfind(")", 0, -1)) + 1
    at = min((i for i in (cell.find("[", start), cell.find("(", start)) if i >= 0), default=-1)
    return (cell[:at].rstrip(), cell[at + 1 : -1].strip()) if at >= 0 else (cell, "")


def _text(raw: bytes) -> str:
    return raw.decode("utf-8", errors="replace").lstrip("\ufeff").strip()


def _number(text: str) -> float | None:
    text = text.strip()
    if "_" in text:  # Python accepts 1_000, other programs do not
        return None
    try:
        return float(text)
    except ValueError:
        return None


def _numbers(text: str) -> bool:
    cells = re.split(r"[;,\t ]+", text.strip())
    return len(cells) > 1 and all(_number(cell) is not None for cell in cells)


def _shorten(text: str, most: int = 40) -> str:
    shown = "".join(c if c.isprintable() else "?" for c in text[:most])
    return repr(shown + ("..." if len(text) > most else ""))
