"""Writing the record of a monitoring run: HDF5, complete at every moment, resumable.

As in the results file, HDF5 lays out the file in memory, plain writes put rows at their positions,
and counters written afterwards contain the number of rows. The length of a stream is unknown: the
file has room for a number of rows (a sparse file: unused room takes no disk space). When the room
is full, a file with twice the room is written beside it and replaces it in one step.

The state for a resumed run is written alternately into two slots, each with a checksum: a kill
during one write leaves the other slot intact.
"""

from __future__ import annotations

import io
import os
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np

from jousto.base.arrays import Array
from jousto.base.checksums import Seal, sealed
from jousto.base.errors import InputError, Problem
from jousto.base.files import check_file, create, unwritable
from jousto.base.hdf5 import Group, damage, open_format
from jousto.base.version import __version__
from jousto.simulation.results.sparse_image import SparseImage, reserve
from jousto.simulation.results.writer import uninterrupted

FORMAT = "jousto monitor"
FORMAT_VERSION = 1
ROOM = 1 << 12  # rows allocated for a new table
TEXT = 240  # bytes of a text
ENDED = "ended"
SLOTS = ("a", "b")
NEW = ".new"  # ending of the new file beside the record during a change of layout
AGAIN = "restore a copy of the file, or watch again with another -o"
HEAD = np.dtype([("sequence", "<i8"), ("length", "<i8"), ("checksum", "<u4"), ("unused", "<u4")])


@dataclass(frozen=True)
class Column:
    """Dataset with one row per row of its table.

    Attributes
    ----------
    name : str
        Dataset.
    width : int
        Values of a row; 0 for a single one, shape (rows,).
    kind : str
        NumPy's type, such as "<f8".
    attrs : mapping
        Unit, description.
    """

    name: str
    width: int = 0
    kind: str = "<f8"
    attrs: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class Table:
    """Columns of equal length; `room` is the number of allocated rows."""

    name: str
    columns: tuple[Column, ...]
    room: int = ROOM


@dataclass(frozen=True)
class Layout:
    """Content of the file without its rows.

    Attributes
    ----------
    tables : tuple of Table
        Tables of the file.
    fixed : mapping of str to array or str
        Datasets that do not change.
    attrs : mapping
        Facts, as attributes of the file.
    memory : int
        Bytes of a slot.
    """

    tables: tuple[Table, ...]
    fixed: Mapping[str, Any]
    attrs: Mapping[str, Any]
    memory: int = 1 << 14


class Record:
    """Writer of the tables of a monitoring run.

    Parameters
    ----------
    path : Path
        File; `create` overwrites it, `resume` continues it.
    layout : Layout
        Content of the file without its rows.
    """

    def __init__(self, path: Path, layout: Layout) -> None:
        self.path = path
        self.layout = layout
        self.rows = {table.name: 0 for table in layout.tables}
        self._sequence = 0
        self._memory = b""
        self._file: BinaryIO | None = None
        self._places: dict[str, int] = {}

    @classmethod
    def create(cls, path: Path, layout: Layout) -> Record:
        """Return an empty record in a new file.

        Raises
        ------
        InputError
            If the file cannot be written.
        """
        record = cls(path, layout)
        try:
            check_file(path)
            new = path.with_name(path.name + NEW)
            with uninterrupted():
                record._places, record._file = _lay_out(new, layout)
                record._put(ENDED, _sentence("running or killed"))
                # the file is complete from the beginning
                os.replace(new, path)
        except OSError as error:
            raise unwritable(path, error) from error
        return record

    @classmethod
    def resume(cls, path: Path, layout: Layout) -> tuple[Record, dict[str, Array]]:
        """Return a record that continues an existing file, and the state of its last checkpoint.

        Rows after the checkpoint are written again. The state is empty if the run ended before its
        first checkpoint.

        Raises
        ------
        InputError
            If the record does not exist, or has other channels or hot spots.
        """
        with open_record(path) as file:
            problem = _differs(file, layout)
            if problem:
                raise InputError(Problem(str(path), f"{problem}; give another -o, or no --resume"))
            slots = [_slot(file, name) for name in SLOTS]
            good = [slot for slot in slots if slot is not None]
            # no checkpoint: killed before the first block
            sequence, memory = max(good, key=lambda slot: slot[0], default=(0, b""))
            tables = tuple(
                replace(table, room=len(file[f"{table.name}/{table.columns[0].name}"]))
                for table in layout.tables
            )
            layout = replace(
                layout, tables=tables, memory=len(file["checkpoint/a"]) - HEAD.itemsize
            )
            places = _places(file, layout)
        record = cls(path, layout)
        record._places, record._sequence = places, sequence
        state = _unpack(memory) if memory else {}
        record._memory = memory
        record._file = open(path, "r+b", buffering=0)
        kept = state.pop("rows", np.zeros(len(record.rows)))
        for name, rows in zip(record.rows, kept, strict=True):
            record.rows[name] = int(rows)
            record._count(name)
        record._put("complete", np.array(0, "<i8").tobytes())
        record._put(ENDED, _sentence("running or killed"))
        return record, state

    # -- writing ----------------------------------------------------------------------------------

    def append(self, table: str, rows: Mapping[str, Any]) -> None:
        """Add rows (k, width) to all columns of a table."""
        spec = next(t for t in self.layout.tables if t.name == table)
        number = len(next(iter(rows.values())))
        if not number:
            return
        if self.rows[table] + number > spec.room:
            self._grow(table, self.rows[table] + number)
            spec = next(t for t in self.layout.tables if t.name == table)
        for column in spec.columns:
            kind = np.dtype(column.kind)
            data = np.ascontiguousarray(rows[column.name], dtype=kind)
            at = self.rows[table] * kind.itemsize * max(column.width, 1)
            self._put(f"{table}/{column.name}", data.tobytes(), at)
        self.rows[table] += number
        self._count(table)

    def checkpoint(self, memory: Mapping[str, Array]) -> None:
        """Store the state from which the run can continue after the present rows."""
        data = _pack({**memory, "rows": np.array(list(self.rows.values()), dtype=np.float64)})
        if len(data) > self.layout.memory:
            self._memory = data
            with self._named():
                self._lay_out_again(replace(self.layout, memory=2 * len(data)))
        self._memory = data
        self._sequence += 1
        self._put(f"checkpoint/{SLOTS[self._sequence % 2]}", _packed_slot(self._sequence, data))

    def close(self, ended: str, *, complete: bool) -> None:
        """Write the reason of the end, cut the tables to their length, and close the file."""
        if self._file is None:
            return
        with uninterrupted():
            tables = tuple(
                replace(table, room=max(1, self.rows[table.name])) for table in self.layout.tables
            )
            try:
                self._lay_out_again(replace(self.layout, tables=tables))
            except OSError:
                pass  # the disk is full: keep the file with its unused rows
            self._put("complete", np.array(int(complete), "<i8").tobytes())
            self._put(ENDED, _sentence(ended))
            self._file.close()
            self._file = None

    def _put(self, place: str, data: bytes, at: int = 0) -> None:
        assert self._file is not None
        with self._named():
            _write(self._file, self._places[place] + at, data)

    @contextmanager
    def _named(self) -> Iterator[None]:
        """Convert disk errors to errors that name the record."""
        try:
            yield
        except OSError as error:
            raise OSError(error.errno, error.strerror, str(self.path)) from error

    def _count(self, table: str) -> None:
        self._put(f"{table}/rows", np.array(self.rows[table], "<i8").tobytes())

    def _grow(self, table: str, least: int) -> None:
        tables = tuple(
            replace(t, room=max(2 * t.room, least + ROOM)) if t.name == table else t
            for t in self.layout.tables
        )
        with self._named():
            self._lay_out_again(replace(self.layout, tables=tables))

    def _lay_out_again(self, layout: Layout) -> None:
        """Replace the file by one with a different layout and the same rows."""
        assert self._file is not None
        new = self.path.with_name(self.path.name + NEW)
        with uninterrupted():
            try:
                places, target = _lay_out(new, layout)
            except OSError:
                new.unlink(missing_ok=True)
                raise
            try:
                with open(self.path, "rb") as source:
                    for table in layout.tables:
                        for column in table.columns:
                            width = np.dtype(column.kind).itemsize * max(column.width, 1)
                            name = f"{table.name}/{column.name}"
                            size = width * self.rows[table.name]
                            _copy(source, self._places[name], target, places[name], size)
                        count = np.array(self.rows[table.name], "<i8").tobytes()
                        _write(target, places[f"{table.name}/rows"], count)
                _write(target, places[ENDED], _sentence("running or killed"))
                if self._memory and self._sequence:
                    # active checkpoint slot, copied unchanged
                    with open_record(self.path) as file:
                        slots = [s for s in (_slot(file, n) for n in SLOTS) if s is not None]
                    if slots:
                        sequence, memory = max(slots, key=lambda slot: slot[0])
                        name = f"checkpoint/{SLOTS[sequence % 2]}"
                        _write(target, places[name], _packed_slot(sequence, memory))
                os.replace(new, self.path)
            except OSError:
                target.close()
                new.unlink(missing_ok=True)
                raise
            self._file.close()
            self._file, self._places, self.layout = target, places, layout


@contextmanager
def open_record(path: Path) -> Iterator[Group]:
    """Return the HDF5 file of a record, also of a running or a killed run.

    Raises
    ------
    InputError
        If the file does not exist or is not a record.
    """
    if not path.is_file():
        raise InputError(Problem(str(path), "no such record of a monitoring run"))
    with damage(path, AGAIN):
        sealed(path)
    with open_format(path, FORMAT, "the record of a monitoring run", AGAIN) as group:
        version = int(group.attrs["format_version"])
        if version != FORMAT_VERSION:
            raise InputError(
                Problem(str(path), f"record format {version}, this version reads {FORMAT_VERSION}")
            )
        yield group


def _lay_out(path: Path, layout: Layout) -> tuple[dict[str, int], BinaryIO]:
    image = SparseImage()
    with h5py.File(image, "w") as file:
        _describe(file, layout)
        places = _places(file, layout)
    target = create(path)
    try:
        target.truncate(image.size)
        for offset, piece in image.pieces():
            _write(target, offset, piece)
        pieces = [(at, len(piece), zlib.crc32(piece)) for at, piece in image.pieces()]
        seal = Seal(image.size, [], 0)
        seal.finish(pieces, lambda at, data: _write(target, at, data), closed=False)
    except BaseException:
        target.close()
        path.unlink(missing_ok=True)
        raise
    # rows can be read while the file grows
    target.close()
    return places, open(path, "r+b", buffering=0)


def _describe(file: h5py.File, layout: Layout) -> None:
    file.attrs["format"], file.attrs["format_version"] = FORMAT, FORMAT_VERSION
    file.attrs["version"] = __version__
    for name, value in layout.attrs.items():
        file.attrs[name] = value
    for name, value in layout.fixed.items():
        if isinstance(value, tuple):
            value = np.array([text.encode() for text in value])
        file[name] = value
    for table in layout.tables:
        reserve(file, f"{table.name}/rows", (), "<i8")
        for column in table.columns:
            shape = (table.room, column.width) if column.width else (table.room,)
            dataset = reserve(file, f"{table.name}/{column.name}", shape, column.kind)
            for key, value in (column.attrs or {}).items():
                dataset.attrs[key] = value
    reserve(file, "complete", (), "<i8")
    reserve(file, ENDED, (TEXT,), "|u1")
    for name in SLOTS:
        reserve(file, f"checkpoint/{name}", (HEAD.itemsize + layout.memory,), "|u1")
    file.flush()


def _places(file: h5py.File | Group, layout: Layout) -> dict[str, int]:
    names = ["complete", ENDED, *(f"checkpoint/{name}" for name in SLOTS)]
    for table in layout.tables:
        names += [f"{table.name}/rows", *(f"{table.name}/{c.name}" for c in table.columns)]
    return {name: int(file[name].id.get_offset()) for name in names}


def _differs(file: Group, layout: Layout) -> str:
    """Return the difference of a file from this layout; empty if there is none."""
    for name, value in layout.fixed.items():
        if name not in file:
            return f"has no {name}"
        found = file[name][()]
        if isinstance(value, tuple):
            old = tuple(text.decode() for text in found)
            if old != value:
                return f"its {name} are {', '.join(old)}, not {', '.join(value)}"
        elif isinstance(value, str):
            continue  # texts may differ
        elif not np.array_equal(found, np.asarray(value)):
            return f"was made with another {name}"
    return ""


def _slot(file: Group, name: str) -> tuple[int, bytes] | None:
    raw = file[f"checkpoint/{name}"][()].tobytes()
    head = np.frombuffer(raw[: HEAD.itemsize], dtype=HEAD)[0]
    length = int(head["length"])
    if not 0 < length <= len(raw) - HEAD.itemsize:
        return None
    data = raw[HEAD.itemsize : HEAD.itemsize + length]
    if zlib.crc32(data, int(head["sequence"]) & 0xFFFFFFFF) != int(head["checksum"]):
        return None
    return int(head["sequence"]), data


def _packed_slot(sequence: int, data: bytes) -> bytes:
    checksum = zlib.crc32(data, sequence & 0xFFFFFFFF)
    return np.array([(sequence, len(data), checksum, 0)], dtype=HEAD).tobytes() + data


def _pack(arrays: Mapping[str, Array]) -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, **dict(arrays))  # type: ignore[arg-type]
    return buffer.getvalue()


def _unpack(data: bytes) -> dict[str, Array]:
    with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
        return {name: arrays[name] for name in arrays.files}


def _sentence(text: str) -> bytes:
    return text.encode()[:TEXT].ljust(TEXT)


def _copy(source: BinaryIO, at: int, target: BinaryIO, to: int, size: int) -> None:
    source.seek(at)
    while size:
        piece = source.read(min(size, 1 << 24))
        if not piece:
            break
        _write(target, to, piece)
        to += len(piece)
        size -= len(piece)


def _write(file: BinaryIO, offset: int, data: bytes) -> None:
    file.seek(offset)
    view = memoryview(data)
    while view:
        view = view[file.write(view) :]
