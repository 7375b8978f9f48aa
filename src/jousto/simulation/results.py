"""The results file: written in pieces while a run goes on, readable at any moment."""

from __future__ import annotations

import importlib.metadata
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np
from numpy.typing import NDArray

from jousto.engine import Model
from jousto.errors import InputError, Problem
from jousto.simulation.image import SparseImage

Array = NDArray[np.float64]
FORMAT = "jousto results"
FORMAT_VERSION = 1
DIAGNOSTICS = (
    ("kinetic", "J", "kinetic energy"),
    ("strain", "J", "strain energy of the modes"),
    ("potential", "J", "potential energy in the field of gravity"),
    ("dissipated", "J", "energy lost to modal damping since the start"),
    ("work", "J", "work done by forces and torques since the start"),
    ("position_residual", "m or 1", "largest position constraint residual |C|"),
    ("velocity_residual", "m/s or 1/s", "largest velocity constraint residual |Cq v|"),
)
CONTENTS = ("rows", "time", "state", "diagnostics", "sensors", "bodies", "model")
ENDED = 240  # bytes kept for the sentence that says how a run ended
PIECE_BYTES = 1 << 24


def version() -> str:
    """Return the version of the installed package."""
    try:
        return importlib.metadata.version("jousto")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


class ResultsWriter:
    """Streams rows of the engine into an HDF5 file.

    The file is laid out at its full length before the run (a sparse file takes no space for what
    is not written yet); rows then go to their places with plain writes. So it is valid HDF5 at
    every moment, also when the run is killed, and a full disk is an exception. The dataset `rows`
    counts what has been written; a run that ends early is cut to its length.
    """

    def __init__(
        self, path: Path, model: Model, rows: int, attributes: dict[str, Any], text: str
    ) -> None:
        self.path = path
        self.written = 0
        self._arguments = (model, attributes, text)
        try:
            self._file, self._places = self._lay_out(path, rows)
        except OSError as error:
            raise InputError(
                Problem(str(path), f"cannot write the results here: {_reason(error, path)}")
            ) from error

    def _lay_out(self, path: Path, rows: int) -> tuple[BinaryIO, list[Place]]:
        image = SparseImage()
        with h5py.File(image, "w") as file:
            places = _describe(file, rows, *self._arguments)
        target = open(path, "wb", buffering=0)
        try:
            target.truncate(image.size)
            for offset, page in image.pages():
                _write(target, offset, page)
        except OSError:
            target.close()
            raise
        return target, places

    def append(self, rows: Array) -> None:
        """Add rows (k, row_size) of the engine."""
        if not len(rows):
            return
        _put(self._file, self._places, rows, self.written)
        self.written += len(rows)
        _write(self._file, self._places[0].offset, np.array(self.written, "<i8").tobytes())

    def close(self, complete: bool, facts: dict[str, float | str]) -> None:
        """Close the file, cut it if the run ended early, and note how it ended."""
        self._file.close()
        if not complete:
            self._cut()
        with h5py.File(self.path, "r+", locking=False) as file:
            file.attrs.modify("complete", int(complete))
            for key, value in facts.items():
                kept = np.bytes_(value.encode()[:ENDED]) if isinstance(value, str) else value
                file.attrs.modify(key, kept)

    def _cut(self) -> None:
        """Copy what was written into a file of its length; on a full disk leave it long."""
        short = self.path.with_name(self.path.name + ".cut")
        try:
            target, places = self._lay_out(short, self.written)
            with target, open(self.path, "rb") as source:
                for new, old in zip(places[1:], self._places[1:], strict=True):
                    source.seek(old.offset)
                    left, at = new.width * 8 * self.written, new.offset
                    while left:
                        piece = source.read(min(left, PIECE_BYTES))
                        _write(target, at, piece)
                        at += len(piece)
                        left -= len(piece)
                _write(target, places[0].offset, np.array(self.written, "<i8").tobytes())
            os.replace(short, self.path)
        except OSError:
            short.unlink(missing_ok=True)


@dataclass(frozen=True)
class Place:
    """Where the rows of a dataset lie in the file, and which columns of the engine they hold."""

    offset: int
    first: int
    width: int


def _write(file: BinaryIO, offset: int, data: bytes) -> None:
    file.seek(offset)
    view = memoryview(data)
    while view:
        view = view[file.write(view) :]


def _put(file: BinaryIO, places: list[Place], rows: Array, start: int) -> None:
    for place in places[1:]:
        block = rows[:, place.first : place.first + place.width]
        _write(file, place.offset + 8 * place.width * start, block.astype("<f8").tobytes())


def _describe(
    file: h5py.File, rows: int, model: Model, attributes: dict[str, Any], text: str
) -> list[Place]:
    """Create all groups, datasets and attributes; return the places, that of `rows` first."""
    file.attrs["format"] = FORMAT
    file.attrs["format_version"] = FORMAT_VERSION
    file.attrs["complete"] = 0
    file.attrs["name"] = model.name
    file.attrs["ended"] = np.bytes_("running or killed".ljust(ENDED))
    file.attrs["wall_time"] = np.nan
    file.attrs["real_time_factor"] = np.nan
    for key, value in attributes.items():
        file.attrs[key] = value
    file["model"] = text
    file["model"].attrs["version"] = version()
    datasets: list[tuple[h5py.Dataset, int, int]] = []
    at = 0

    def reserve(place: str, shape: tuple[int, ...], kind: str) -> h5py.Dataset:
        # contiguous, allocated now and never filled: the data gets a fixed place in the file
        layout = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
        layout.set_layout(h5py.h5d.CONTIGUOUS)
        layout.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
        layout.set_fill_time(h5py.h5d.FILL_TIME_NEVER)
        links = h5py.h5p.create(h5py.h5p.LINK_CREATE)
        links.set_create_intermediate_group(True)
        space = h5py.h5s.create_simple(shape) if shape else h5py.h5s.create(h5py.h5s.SCALAR)
        numbers = h5py.h5t.py_create(np.dtype(kind))
        name = place.encode()
        return h5py.Dataset(h5py.h5d.create(file.id, name, numbers, space, layout, links))

    def column(place: str, width: int | None, **attrs: Any) -> None:
        nonlocal at
        count = 1 if width is None else width
        shape = (rows,) if width is None else (rows, width)
        if count:
            dataset = reserve(place, shape, "<f8")
            datasets.append((dataset, at, count))
            at += count
        else:  # nothing of this kind in the model
            dataset = file.create_dataset(place, shape=shape, dtype="<f8")
        for key, value in attrs.items():
            dataset.attrs[key] = value

    counter = reserve("rows", (), "<i8")
    counter.attrs["description"] = "instants written so far"
    column("time", None, unit="s")
    column("state/q", model.nq, unit="m, 1, kg^0.5 m", description="[R e p] of every body")
    column(
        "state/v",
        model.nv,
        unit="m/s, rad/s, kg^0.5 m/s",
        description="[R' w_local p'] of every body",
    )
    column(
        "state/multipliers",
        model.nrow,
        unit="N or N m",
        description="lam in M a + Cq^T lam = Q, joint after joint",
    )
    for name, unit, description in DIAGNOSTICS:
        column(f"diagnostics/{name}", None, unit=unit, description=description)
    file.create_group("sensors", track_order=True)
    for sensor in model.sensors:
        column(
            f"sensors/{sensor.name}",
            sensor.count,
            unit=sensor.unit,
            resolved_in=sensor.resolved_in,
            description=sensor.description,
            components=list(sensor.components),
        )
    bodies = file.create_group("bodies", track_order=True)
    for body, shape in zip(model.bodies, model.shapes, strict=True):
        group = bodies.create_group(body.name)
        group.attrs["kind"] = shape.kind
        group.attrs["q_offset"] = body.iq
        group.attrs["v_offset"] = body.iv
        group.attrs["modes"] = body.n
        group["nodes"] = shape.nodes
        group["elements"] = shape.elements
        group["mode_shapes"] = shape.modes
    joints = file.create_group("joints", track_order=True)
    for joint in model.joints:
        group = joints.create_group(joint.name)
        group.attrs["row"] = joint.row
        group.attrs["rows"] = joint.rows
    file.flush()
    return [
        Place(counter.id.get_offset(), 0, 0),
        *(Place(dataset.id.get_offset(), first, width) for dataset, first, width in datasets),
    ]


def _reason(error: OSError, path: Path) -> str:
    if path.is_dir():
        return "it is a folder; give a file name"
    if not path.parent.exists():
        return f"the folder {path.parent} does not exist; create it first"
    return f"{error.strerror or error}; choose another place"


def open_results(path: Path) -> h5py.File:
    """Open a results file for reading, also one whose run is going on or was killed.

    Raises
    ------
    InputError
        If there is no such file, it is damaged, or it is something else than results.
    """
    if not path.is_file():
        raise InputError(Problem(str(path), "no such results file"))
    try:
        file = h5py.File(path, "r", locking=False)
    except OSError as error:
        raise InputError(
            Problem(str(path), f"not readable as HDF5, damaged or another kind of file ({error})")
        ) from error
    found = file.attrs.get("format", "")
    if found != FORMAT:
        file.close()
        kind = f"it is a file of {found!r}" if found else "it is some other HDF5 file"
        raise InputError(Problem(str(path), f"not a results file; {kind}"))
    written = int(file.attrs["format_version"])
    if written != FORMAT_VERSION:
        by = file["model"].attrs.get("version", "unknown")
        file.close()
        raise InputError(
            Problem(
                str(path),
                f"results format {written}, this version reads {FORMAT_VERSION}; written by "
                f"jousto {by}: run the model again",
            )
        )
    missing = [name for name in CONTENTS if name not in file]
    if missing:
        file.close()
        raise InputError(
            Problem(str(path), f"damaged: {', '.join(missing)} missing; run the model again")
        )
    return file
