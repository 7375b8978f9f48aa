"""Writer of the results file: in pieces during a run, readable at any moment."""

from __future__ import annotations

import os
import shutil
import signal
import sys
import threading
import uuid
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, BinaryIO
from weakref import WeakKeyDictionary

import h5py
import numpy as np

from jousto.base.arrays import Array
from jousto.base.checksums import Seal
from jousto.base.errors import InputError, Problem
from jousto.base.files import beside_of, check_file, create, take_place, unwritable
from jousto.base.version import __version__
from jousto.model.model import Model
from jousto.model.scales import scales_of
from jousto.simulation.results.contact_table import ContactTable
from jousto.simulation.results.events import joints_of, sources
from jousto.simulation.results.row_layout import Column, columns
from jousto.simulation.results.sparse_image import SparseImage, reserve
from jousto.simulation.results.stress import BEAMS, beam_arrays, frame_arrays, stress_arrays
from jousto.simulation.results.symbols import GROUP as SYMBOLS, symbol_arrays

Facts = dict[str, Any]  # how a run ended: ended, wall_time, real_time_factor
FORMAT = "jousto results"
FORMAT_VERSION = 2
CONTENTS = ("rows", "time", "state", "diagnostics", "sensors", "bodies", "model")
ENDED = 240  # size of the attribute `ended`, bytes
EVENTS = 10_000  # maximum number of events in a results file
EVENT_COLUMNS = (
    ("time", "s", "when"),
    ("source", "1", "index into events/names"),
    ("change", "1", "1 rising, -1 falling; of friction the sense of slip after it, 0 sticks"),
    ("count", "1", "number of times that this source has occurred"),
)
PIECE_BYTES = 1 << 24  # size of a piece written at once, bytes
KEPT_BYTES = 1 << 25  # maximum size of a layout cached for the next run, bytes


class ResultsWriter:
    """Writer of rows of the engine into an HDF5 file.

    The file is laid out at its full length before the run; as a sparse file it takes no disk space
    for rows that are not written yet. Ordinary file calls then write the rows at their offsets, so
    that the file is valid HDF5 at every moment, also if the run is killed, and a full disk raises
    an exception. The dataset `rows` is the number of written rows; the file of a run that ends
    early is cut to this number. An existing file at the path is replaced when the first rows are
    written.
    """

    def __init__(
        self, path: Path, model: Model, rows: int, attributes: dict[str, Any], text: str
    ) -> None:
        check_file(path)
        self.path = path
        self._final = Path(os.path.realpath(path))
        self.written = 0
        self.happened = np.zeros((0, len(EVENT_COLUMNS)))
        self.touched = ContactTable()
        self._rows = rows
        self._about = (model, {"run": uuid.uuid4().hex, **attributes}, text)
        running: Facts = {"ended": "running or killed", "wall_time": np.nan}
        if any("approach" in force.state_names for force in model.forces):
            running["contacts"] = "running or killed"
        image = self._begin(rows, running)
        needed, free = image.size, free_bytes(path)
        if needed > free:
            raise InputError(
                Problem(
                    str(path),
                    f"{rows} instants need {needed / 1e9:.3g} GB and {free / 1e9:.3g} GB are free; "
                    "give a larger output_step",
                )
            )
        try:
            self._beside: Path | None = beside_of(self._final)
            with uninterrupted():
                self._file = self._lay_out(self._beside, image)
        except OSError as error:
            raise unwritable(path, error) from error

        self._seal = Seal(image.size, _columns(self._places), rows)
        self._sealed(self._file, self._seal, image, closed=False)
        self._laid = image if image.held <= KEPT_BYTES else None

    def _sealed(self, file: BinaryIO, seal: Seal, image: SparseImage, *, closed: bool) -> None:
        """Write the checksums of the layout; for a closed file also those of counts and events."""
        pieces = [(at, len(piece), zlib.crc32(piece)) for at, piece in image.pieces()]
        if closed:
            counts = [(self._counter, np.array(self.written, "<i8"))]
            if self._event_places:
                happened = [np.array(len(self.happened), "<i8"), *self.happened.T.astype("<f8")]
                offsets = [place.offset for place in self._event_places]
                counts += zip(offsets, happened, strict=True)
            pieces += [(at, x.nbytes, zlib.crc32(x.tobytes())) for at, x in counts]
            pieces += self.touched.checks(self._touch_places)
        seal.finish(pieces, lambda at, data: _write(file, at, data), closed=closed)

    def _begin(self, rows: int, facts: Facts) -> SparseImage:
        """Return the cached layout of the last run with new attributes if it fits, or a new one."""
        model, attributes, text = self._about
        kept = _LAID.get(model)
        if kept is not None and kept.fits(rows, attributes, text):
            image = kept.image.copy()
            known = kept.attributes
            _set(image, {k: x for k, x in attributes.items() if not _same(x, known[k])})
            self._places, self._event_places = kept.places, kept.event_places
            self._touch_places = kept.touch_places
            self._counter = self._places[0].offset
            return image
        image, self._places = self._image(rows, False, facts)
        if image.held <= KEPT_BYTES:
            _LAID[model] = _Laid(
                image.copy(),
                rows,
                attributes,
                text,
                self._places,
                self._event_places,
                self._touch_places,
            )
        return image

    def _image(self, rows: int, complete: bool, facts: Facts) -> tuple[SparseImage, list[Place]]:
        image = SparseImage()
        with h5py.File(image, "w") as file:
            places = _describe(file, rows, complete, facts, *self._about)
            self._event_places = _describe_events(file, self._about[0])
            self._touch_places = ContactTable.describe(file, self._about[0])
        self._counter = places[0].offset
        return image, places

    @staticmethod
    def _lay_out(path: Path, image: SparseImage) -> BinaryIO:
        target = create(path)  # open until the end of the run
        try:
            target.truncate(image.size)
            for offset, piece in image.pieces():
                _write(target, offset, piece)
        except BaseException:
            target.close()
            path.unlink(missing_ok=True)
            raise
        return target

    def append(self, rows: Array) -> None:
        """Add rows (k, row_size) of the engine."""
        if not len(rows):
            return
        blocks = []
        for place in self._places[1:]:
            block = rows[:, place.first : place.first + place.width].astype("<f8").tobytes()
            offset = place.offset + 8 * place.width * self.written
            _write(self._file, offset, block)
            blocks.append(block)
        self._seal.add(blocks, len(rows), lambda at, data: _write(self._file, at, data))
        self.written += len(rows)
        self._count(self._file, self._places)
        if self._beside is not None:
            self._take_place(self._beside)

    def _take_place(self, beside: Path) -> None:
        """Move the file to its path, over an existing file; for Windows it is closed meanwhile."""
        with uninterrupted():
            self._file.close()
            take_place(beside, self._final)
            self._beside = None
            self._file = open(self._final, "r+b", buffering=0)

    def note(self, happened: Array) -> None:
        """Add events (k, 4): time, source, change, count; only the first EVENTS are kept."""
        room = EVENTS - len(self.happened)
        if len(happened) and room > 0:
            self.happened = np.vstack([self.happened, happened[:room]])
            self._note_all(self._file)

    def touch(self, rows: Array, dropped: int) -> None:
        """Add contacts (k, 14) from touch to part, and the number that the engine dropped."""
        first = len(self.touched.rows)
        self.touched.add(rows, dropped)
        if len(rows):
            self.touched.write(self._touch_places, partial(_write, self._file), first)

    def _note_all(self, file: BinaryIO) -> None:
        self.touched.write(self._touch_places, partial(_write, file))
        if not self._event_places:
            return
        for column, place in enumerate(self._event_places[1:]):
            _write(file, place.offset, self.happened[:, column].astype("<f8").tobytes())
        _write(file, self._event_places[0].offset, np.array(len(self.happened), "<i8").tobytes())

    def _count(self, file: BinaryIO, places: list[Place]) -> None:
        _write(file, places[0].offset, np.array(self.written, "<i8").tobytes())

    @property
    def placed(self) -> bool:
        """Whether the file is at its path, where it is from the first row on."""
        return self._beside is None

    def discard(self) -> None:
        """Remove the file; an existing file at the path remains if no rows were written."""
        self._file.close()
        (self._beside or self._final).unlink(missing_ok=True)

    def close(self, complete: bool, facts: Facts) -> None:
        """Write the ending of the run, cut the file if the run ended early, and close it."""
        with uninterrupted(), self._file:
            if (not complete or self.written < self._rows) and self._cut(complete, facts):
                return
            # the layout is unchanged: write the new values of its attributes
            if self._laid is None:
                image, _ = self._image(self._rows, complete, facts)
            else:
                image = self._laid
                _set(image, {"complete": int(complete), **_ending(facts)})
            try:
                self._file.truncate(self._seal.open_end)  # removes the checksums of the open file
                for offset, piece in image.pieces():
                    _write(self._file, offset, piece)
                self._count(self._file, self._places)
                self._note_all(self._file)
                self._sealed(self._file, self._seal, image, closed=True)
            except OSError:
                if complete:
                    raise

    def _cut(self, complete: bool, facts: Facts) -> bool:
        """Replace the file by a copy cut to the written rows; False if the disk is too full."""
        short = self._final.with_name(self._final.name + ".cut")
        image, places = self._image(self.written, complete, facts)
        try:
            with self._lay_out(short, image) as target, open(self._final, "rb") as source:
                for new, old in zip(places[1:], self._places[1:], strict=True):
                    source.seek(old.offset)
                    left, at = new.width * 8 * self.written, new.offset
                    while left:
                        piece = source.read(min(left, PIECE_BYTES))
                        _write(target, at, piece)
                        at += len(piece)
                        left -= len(piece)
                self._count(target, places)
                self._note_all(target)
                seal = self._seal.moved(image.size, _columns(places), self.written)
                self._sealed(target, seal, image, closed=True)
            self._file.close()
            os.replace(short, self._final)
        except OSError:
            short.unlink(missing_ok=True)
            return False
        return True


@contextmanager
def uninterrupted() -> Iterator[None]:
    """Delay Ctrl-C to the end of the block; only the main thread receives it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    pressed: list[Any] = []
    before = signal.signal(signal.SIGINT, lambda *event: pressed.append(event))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if pressed:
        raise KeyboardInterrupt


def free_bytes(path: Path) -> int:
    """Return the free space on the disk of a file, bytes; infinite for a missing folder."""
    try:
        return shutil.disk_usage(path.parent).free
    except (OSError, ValueError):
        return sys.maxsize


def _ending(facts: Facts) -> dict[str, Any]:
    """Return the attributes of the ending of a run, in fixed lengths."""
    texts = {key: str(facts[key]) for key in ("ended", "contacts") if key in facts}
    return {
        **{key: np.bytes_(text.encode()[:ENDED].ljust(ENDED)) for key, text in texts.items()},
        "wall_time": float(facts["wall_time"]),
        "real_time_factor": float(facts.get("real_time_factor", np.nan)),
    }


def _set(image: SparseImage, attributes: dict[str, Any]) -> None:
    """Overwrite attributes of the layout by values of the same type."""
    with h5py.File(image, "r+") as file:
        for name, value in attributes.items():
            file.attrs.modify(name, value)


def _same(x: Any, y: Any) -> bool:
    return bool(np.array_equal(x, y))


@dataclass(frozen=True)
class Place:
    """Offset of a dataset in the file, and the columns of the engine's row that it contains."""

    offset: int
    first: int
    width: int


@dataclass(frozen=True)
class _Laid:
    """Cached layout of a results file, for the next run with the same number of rows."""

    image: SparseImage
    rows: int
    attributes: dict[str, Any]
    text: str
    places: list[Place]
    event_places: list[Place]
    touch_places: tuple[int, ...]

    def fits(self, rows: int, attributes: dict[str, Any], text: str) -> bool:
        """Return whether a run has the same layout, except for the values of its attributes."""
        return (rows, text, *_kinds(attributes)) == (self.rows, self.text, *_kinds(self.attributes))


_LAID: WeakKeyDictionary[Model, _Laid] = WeakKeyDictionary()


def _kinds(attributes: dict[str, Any]) -> list[tuple[str, type, tuple[int, ...]]]:
    return [(name, type(value), np.shape(value)) for name, value in attributes.items()]


def _columns(places: list[Place]) -> list[tuple[int, int]]:
    """Return offset and bytes per row of each dataset."""
    return [(place.offset, 8 * place.width) for place in places[1:]]


def _write(file: BinaryIO, offset: int, data: bytes) -> None:
    file.seek(offset)
    view = memoryview(data)
    while view:
        view = view[file.write(view) :]


def _describe_events(file: h5py.File, model: Model) -> list[Place]:
    """Create the table of events; return the offsets of its length and of its columns."""
    names = sources(model)
    if not names:
        return []
    counter = reserve(file, "events/rows", (), "<i8")
    counter.attrs["description"] = "entries written so far"
    made = [counter]
    for name, unit, description in EVENT_COLUMNS:
        dataset = reserve(file, f"events/{name}", (EVENTS,), "<f8")
        dataset.attrs["unit"] = unit
        dataset.attrs["description"] = description
        made.append(dataset)
    file["events/names"] = np.array([name.encode() for name in names])
    file["events/joints"] = np.array([name.encode() for name in joints_of(model)])
    file["events"].attrs["events"] = len(
        model.events
    )  # number of events in `names`; frictions follow
    file.flush()
    return [Place(dataset.id.get_offset(), 0, 1) for dataset in made]


def _describe(
    file: h5py.File,
    rows: int,
    complete: bool,
    facts: Facts,
    model: Model,
    attributes: dict[str, Any],
    text: str,
) -> list[Place]:
    """Create all groups, datasets and attributes; return the datasets of rows, first `rows`."""
    file.attrs["format"] = FORMAT
    file.attrs["format_version"] = FORMAT_VERSION
    file.attrs["complete"] = int(complete)
    file.attrs["name"] = model.name
    file.attrs["scales"] = scales_of(model).array()
    for about, fact in {**_ending(facts), **attributes}.items():
        file.attrs[about] = fact
    file["model"] = text
    file["model"].attrs["version"] = __version__
    counter = reserve(file, "rows", (), "<i8")
    counter.attrs["description"] = "instants written so far"
    file.create_group("sensors", track_order=True)
    file.create_group("components", track_order=True)
    datasets: list[tuple[h5py.Dataset, Column]] = []
    for column in columns(model):
        size = (rows,) if column.width is None else (rows, column.width)
        if column.count:
            dataset = reserve(file, column.place, size, "<f8")
            datasets.append((dataset, column))
        else:  # the model has no columns of this dataset
            dataset = file.create_dataset(column.place, shape=size, dtype="<f8")
        for key, value in column.facts.items():
            dataset.attrs[key] = value
    for sensor in model.sensors:
        # a dataset, since attributes may not exceed 64 kB
        names = np.array([c.encode() for c in sensor.components])
        file.create_dataset(f"components/{sensor.name}", data=names)
    if model.inputs:
        file["state/input"].attrs["names"] = np.array([name.encode() for name in model.inputs])
    bodies = file.create_group("bodies", track_order=True)
    known: dict[
        tuple[Any, ...], h5py.Dataset
    ] = {}  # equal arrays of several bodies are written once
    for body, shape in zip(model.bodies, model.shapes, strict=True):
        group = bodies.create_group(body.name)
        group.attrs["kind"] = shape.kind
        group.attrs["q_offset"] = body.iq
        group.attrs["v_offset"] = body.iv
        group.attrs["modes"] = body.n
        group.attrs["mass"] = float(body.mass[0])
        arrays: dict[str, Any] = {
            "nodes": shape.nodes,
            "elements": shape.elements,
            "mode_shapes": shape.modes,
        }
        if shape.stress is not None:
            arrays |= stress_arrays(shape.stress)
        if shape.frame is not None:
            arrays |= frame_arrays(shape.frame)
        for name, array in arrays.items():
            content = (array.shape, array.dtype.str, array.tobytes())
            if content in known:
                group[name] = known[content]
            else:
                known[content] = group.create_dataset(name, data=array)
    if model.beam_shapes:
        beams = file.create_group(BEAMS, track_order=True)
        for beam in model.beam_shapes:
            group = beams.create_group(beam.name)
            for name, array in beam_arrays(beam).items():
                group.create_dataset(name, data=array)
            # first indices of the nodes in q
            group["iq"] = np.array([model.bodies[k].iq for k in beam.bodies])
            group["iv"] = np.array([model.bodies[k].iv for k in beam.bodies])
    if model.symbols:
        group = file.create_group(SYMBOLS)
        for name, array in symbol_arrays(model.symbols).items():
            group.create_dataset(name, data=array)
    joints = file.create_group("joints", track_order=True)
    for joint in model.joints:
        group = joints.create_group(joint.name)
        group.attrs["row"] = joint.row
        group.attrs["rows"] = joint.rows
    file.flush()
    return [
        Place(counter.id.get_offset(), 0, 0),
        *(Place(data.id.get_offset(), column.first, column.count) for data, column in datasets),
    ]
