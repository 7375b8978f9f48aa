"""Writing of stress fields, piece by piece, into a file that is readable at every moment."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import h5py
import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.files import create, unwritable
from jousto.base.version import __version__
from jousto.recovery.fields.criteria import Criterion
from jousto.simulation.results.sparse_image import SparseImage, reserve

FORMAT = "jousto stress field"
VERSION = 1


def write_field(
    path: str | Path,
    facts: Mapping[str, str],
    data: Mapping[str, Any],
    criteria: Sequence[Criterion],
    unit: str,
    blocks: Callable[[Criterion], Iterable[tuple[slice, slice, Array]]],
) -> Path:
    """Write criteria at all sites and instants; return the path; see `StressField.write`.

    Parameters
    ----------
    path : path
        File that ends with .h5.
    facts : mapping of str to str
        Attributes of the file.
    data : mapping of str to array
        Datasets: labels, positions, axes, nodes and time.
    criteria : sequence of str or Plane
        Criteria to write; with a single one the file contains the current number of rows.
    unit : str
        Unit of the values.
    blocks : callable
        Function of a criterion that returns its instants, sites and values, piece by piece.
    """
    out = Path(path)
    if out.suffix.lower() not in (".h5", ".hdf5"):
        raise InputError(Problem(str(out), "must end with .h5: a field is written as HDF5"))
    nt, ns = len(data["time"]), len(data["labels"])
    image, places = _image(facts, data, criteria, unit)
    try:
        with create(out) as file:
            # HDF5 creates the layout with the full length; it writes nothing afterwards, so that
            # the file remains valid
            file.truncate(image.size)
            for offset, piece in image.pieces():
                _write(file, offset, piece)
            for what in criteria:
                offset = places[f"values/{what}"]
                for instants, sites, values in blocks(what):
                    if len(range(*sites.indices(ns))) == ns:
                        start = 8 * instants.start * ns
                        _write(file, offset + start, np.ascontiguousarray(values, "<f8").data)
                    else:
                        for i, row in enumerate(values):
                            start = 8 * ((instants.start + i) * ns + sites.start)
                            _write(file, offset + start, np.ascontiguousarray(row, "<f8").data)
                    if len(criteria) == 1 and sites.stop == ns:
                        _write(file, places["rows"], np.array(instants.stop, "<i8").tobytes())
            _write(file, places["rows"], np.array(nt, "<i8").tobytes())
    except OSError as error:
        raise unwritable(out, error) from error
    return out


def _image(
    facts: Mapping[str, str], data: Mapping[str, Any], criteria: Sequence[Criterion], unit: str
) -> tuple[SparseImage, dict[str, int]]:
    image = SparseImage()
    with h5py.File(image, "w") as file:
        file.attrs.update({"format": FORMAT, "format_version": VERSION, "version": __version__})
        file.attrs.update(facts)
        for name, values in data.items():
            file[name] = values
        file["positions"].attrs["unit"] = "m"
        file["time"].attrs["unit"] = "s"
        made = {"rows": reserve(file, "rows", (), "<i8")}
        made["rows"].attrs["description"] = "instants written so far"
        for what in criteria:
            key = f"values/{what}"
            made[key] = reserve(file, key, (len(data["time"]), len(data["labels"])), "<f8")
            made[key].attrs["unit"] = unit
        file.flush()
        places = {key: int(dataset.id.get_offset()) for key, dataset in made.items()}
    return image, places


def _write(file: BinaryIO, offset: int, data: Any) -> None:
    file.seek(offset)
    view = memoryview(data).cast("B")
    while view:
        view = view[file.write(view) :]
