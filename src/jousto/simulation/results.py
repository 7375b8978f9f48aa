"""The results file: written in pieces while a run goes on, readable at any moment."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from jousto.engine import Model
from jousto.errors import InputError, Problem

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
CHUNK_BYTES = 1 << 16


def version() -> str:
    """Return the version of the installed package."""
    try:
        return importlib.metadata.version("jousto")
    except importlib.metadata.PackageNotFoundError:
        return "unknown"


class ResultsWriter:
    """Streams rows of the engine into an HDF5 file.

    The file is in single-writer-multiple-reader mode while the run goes on: every `append` leaves
    it consistent, so that a killed run is readable up to its last append.
    """

    def __init__(self, path: Path, model: Model, attributes: dict[str, Any], text: str) -> None:
        self.path = path
        self._model = model
        try:
            self._file = h5py.File(path, "w", libver=("v110", "v110"), locking=False)
        except OSError as error:
            raise InputError(
                Problem(str(path), f"cannot write the results here: {_reason(error, path)}")
            ) from error
        try:
            self._create(attributes, text)
            self._file.swmr_mode = True
        except BaseException:
            self._file.close()
            raise

    def _create(self, attributes: dict[str, Any], text: str) -> None:
        file, model = self._file, self._model
        file.attrs["format"] = FORMAT
        file.attrs["format_version"] = FORMAT_VERSION
        file.attrs["complete"] = 0
        file.attrs["name"] = model.name
        for key, value in attributes.items():
            file.attrs[key] = value
        file["model"] = text
        file["model"].attrs["version"] = version()
        self._columns: list[tuple[h5py.Dataset, slice | int]] = []
        at = 0

        def column(place: str, width: int | None, **attrs: Any) -> None:
            nonlocal at
            shape = () if width is None else (width,)
            count = 1 if width is None else width
            if count:
                rows = max(1, min(4096, CHUNK_BYTES // (8 * count)))
                dataset = file.create_dataset(
                    place,
                    shape=(0, *shape),
                    maxshape=(None, *shape),
                    dtype="f8",
                    chunks=(rows, *shape),
                )
                self._columns.append((dataset, at if width is None else slice(at, at + width)))
                at += count
            else:  # nothing of this kind in the model
                dataset = file.create_dataset(place, shape=(0, 0), dtype="f8")
            for key, value in attrs.items():
                dataset.attrs[key] = value

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
        file.create_group("sensors")
        for sensor in model.sensors:
            column(
                f"sensors/{_safe(sensor.name)}",
                sensor.count,
                unit=sensor.unit,
                resolved_in=sensor.resolved_in,
                description=sensor.description,
                components=list(sensor.components),
                name=sensor.name,
            )
        bodies = file.create_group("bodies", track_order=True)
        for body, shape in zip(model.bodies, model.shapes, strict=True):
            group = bodies.create_group(_safe(body.name))
            group.attrs["name"] = body.name
            group.attrs["kind"] = shape.kind
            group.attrs["q_offset"] = body.iq
            group.attrs["v_offset"] = body.iv
            group.attrs["modes"] = body.n
            group["nodes"] = shape.nodes
            group["elements"] = shape.elements
            group["mode_shapes"] = shape.modes
        joints = file.create_group("joints", track_order=True)
        for joint in model.joints:
            group = joints.create_group(_safe(joint.name))
            group.attrs["name"] = joint.name
            group.attrs["row"] = joint.row
            group.attrs["rows"] = joint.rows

    def append(self, rows: Array) -> None:
        """Add rows (k, row_size) of the engine."""
        if not len(rows):
            return
        for dataset, columns in self._columns:
            start = dataset.shape[0]
            dataset.resize(start + len(rows), axis=0)
            dataset[start:] = rows[:, columns]
        for dataset, _ in self._columns:
            dataset.flush()

    def close(self, attributes: dict[str, Any] | None = None) -> None:
        """Close the file; with attributes also mark how the run ended."""
        try:
            self._file.close()
        finally:
            if attributes is not None:
                with h5py.File(self.path, "r+", locking=False) as file:
                    for key, value in attributes.items():
                        file.attrs[key] = value


def _safe(name: str) -> str:
    """Return a name HDF5 does not take for a path."""
    return name.replace("/", "\u2215")


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
    file = None
    for swmr in (False, True):
        try:
            file = h5py.File(path, "r", swmr=swmr, locking=False)
            break
        except OSError as error:
            reason = str(error)
    if file is None:
        raise InputError(
            Problem(str(path), f"not readable as HDF5, damaged or another kind of file ({reason})")
        )
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
    return file
