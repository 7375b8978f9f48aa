"""Fields on disk: written piece by piece into a file that is readable at every moment."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import h5py
import numpy as np

from jousto import __version__
from jousto.base.errors import InputError, Problem
from jousto.base.files import create, unwritable
from jousto.recovery.fields.criteria import STRAIN_COMPONENTS, STRESS_COMPONENTS, Criterion
from jousto.simulation.results.image import SparseImage, reserve

if TYPE_CHECKING:
    from jousto.recovery.fields.field import StressField

FORMAT = "jousto stress field"
VERSION = 1


def write_field(
    field: StressField, path: str | Path, criterion: Criterion | None, memory: int
) -> Path:
    """Write a criterion, or all components; see `StressField.write`."""
    out = Path(path)
    if out.suffix.lower() not in (".h5", ".hdf5"):
        raise InputError(
            Problem(str(out), "a field is written as HDF5: the name must end with .h5")
        )
    image, places = _image(field, criterion)
    names = STRAIN_COMPONENTS if field.strain else STRESS_COMPONENTS
    try:
        with create(out) as file:
            # laid out at its full length: HDF5 never writes again, so that it is always valid
            file.truncate(image.size)
            for offset, piece in image.pieces():
                _write(file, offset, piece)
            for what in names if criterion is None else (criterion,):
                offset = places[f"values/{what}"]
                for instants, sites, values in field.blocks(what, memory=memory, along="sites"):
                    if len(range(*sites.indices(field.ns))) == field.ns:
                        start = 8 * instants.start * field.ns
                        _write(file, offset + start, np.ascontiguousarray(values, "<f8").data)
                    else:
                        for i, row in enumerate(values):
                            start = 8 * ((instants.start + i) * field.ns + sites.start)
                            _write(file, offset + start, np.ascontiguousarray(row, "<f8").data)
                    if criterion is not None and sites.stop == field.ns:
                        _write(file, places["rows"], np.array(instants.stop, "<i8").tobytes())
            _write(file, places["rows"], np.array(field.nt, "<i8").tobytes())
    except OSError as error:
        raise unwritable(out, error) from error
    return out


def _image(field: StressField, criterion: Criterion | None) -> tuple[SparseImage, dict[str, int]]:
    image = SparseImage()
    names = STRAIN_COMPONENTS if field.strain else STRESS_COMPONENTS
    with h5py.File(image, "w") as file:
        file.attrs["format"] = FORMAT
        file.attrs["format_version"] = VERSION
        file.attrs["version"] = __version__
        file.attrs["body"] = field.name
        file.attrs["frame"] = field.frame
        file.attrs["quantity"] = "strain" if field.strain else "stress"
        file["labels"] = np.array([label.encode() for label in field.labels], dtype=np.bytes_)
        file["positions"] = field.positions
        file["positions"].attrs["unit"] = "m"
        file["axes"] = field.modes.axes
        if field.modes.nodes is not None:
            file["nodes"] = field.modes.nodes
        file["time"] = field.time
        file["time"].attrs["unit"] = "s"
        made = {"rows": reserve(file, "rows", (), "<i8")}
        made["rows"].attrs["description"] = "instants written so far"
        for what in names if criterion is None else (criterion,):
            key = f"values/{what}"
            made[key] = reserve(file, key, (field.nt, field.ns), "<f8")
            made[key].attrs["unit"] = field.unit
        file.flush()
        places = {key: int(dataset.id.get_offset()) for key, dataset in made.items()}
    return image, places


def _write(file: BinaryIO, offset: int, data: Any) -> None:
    file.seek(offset)
    view = memoryview(data).cast("B")
    while view:
        view = view[file.write(view) :]
