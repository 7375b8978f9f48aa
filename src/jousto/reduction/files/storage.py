"""Reduced parts in HDF5 files, written atomically and checked when read."""

from __future__ import annotations

import hashlib
import json
import os
import uuid
import zlib
from dataclasses import fields
from pathlib import Path
from typing import Any, TypeVar

import h5py
import numpy as np
from numpy.typing import NDArray

from jousto.base.checksums import Seal, sealed
from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.base.files import check_input, written
from jousto.base.hdf5 import DAMAGE, Group
from jousto.parts.frames.element import BeamElements
from jousto.parts.frames.outlines import Outlines
from jousto.reduction.content import Content
from jousto.reduction.fields.invariants import Invariants
from jousto.reduction.fields.residual_stress import ResidualStress
from jousto.reduction.fields.stiffening import Stiffening
from jousto.reduction.fields.stress import StressModes

FORMAT = "jousto reduced part"
VERSION = 5
"""2 adds `rotation_nodes`, 3 `faces`, 4 `beams`, 5 `outlines`; files of older versions are read."""
AGAIN = "reduce the part again and save it"

UNITS = {
    "nodes": "m",
    "frequencies": "Hz",
    "modes": "kg^-0.5",
    "rotations": "kg^-0.5 m^-1",
    "beams/origin": "m",
    "beams/length": "m",
    "beams/offsets": "m",
    "beams/EA": "N",
    "beams/GJ": "N m^2",
    "beams/EIy": "N m^2",
    "beams/EIz": "N m^2",
    "invariants/mass": "kg",
    "invariants/first_moment": "kg m",
    "invariants/second_moment": "kg m^2",
    "invariants/I3": "kg^0.5",
    "invariants/N0": "kg^0.5 m",
    "invariants/E": "1",
    "stress/positions": "m",
    "stress/modes": "Pa kg^-0.5 m^-1",
    "stress/elasticity": "Pa, 1",
    "stress/compliance": "1/Pa",
    "stress/scatter": "Pa kg^-0.5 m^-1",
    "stiffening/second_moment": "1",
    "stiffening/translations": "kg^-1 m^-1",
    "stiffening/rotations": "kg^-1 m^-2",
}

Arrays = dict[str, NDArray[Any]]
P = TypeVar("P", bound=Content)


def save(part: Content, path: Path) -> None:
    """Write a reduced part; see `ReducedPart.save`."""
    arrays = _arrays(part)
    about = {
        "name": part.name,
        "interfaces": list(part.interfaces),
        "node_sets": {k: list(v) for k, v in part.node_sets.items()},
        "labels": None if part.stress is None else list(part.stress.labels),
        "provenance": dict(part.provenance),
    }
    if part.stress is not None and part.stress.residual is not None:
        about["residual"] = list(part.stress.residual.names)
    header = json.dumps(about, ensure_ascii=False)
    # created in memory, since HDF5 may crash the process if a disk is full
    # with a unique name, since threads may save at the same time
    unique = uuid.uuid4().hex
    with h5py.File(unique, "w", driver="core", backing_store=False) as file:
        file.attrs["format"] = FORMAT
        file.attrs["version"] = VERSION
        file.attrs["checksum"] = _checksum(header, arrays)
        # stored as bytes, for any length and any characters
        file["header"] = np.frombuffer(header.encode(), dtype=np.uint8)
        for key, array in arrays.items():
            dataset = file.create_dataset(key, data=array)
            if key in UNITS:
                dataset.attrs["unit"] = UNITS[key]
        file.flush()
        image = file.id.get_file_image()
    with written(path) as beside, beside.open("wb") as target:
        target.write(image)

        def write(at: int, data: bytes) -> None:
            target.seek(at)
            target.write(data)

        seal = Seal(len(image), [], 0)
        seal.finish([(0, len(image), zlib.crc32(image))], write, closed=True)
        target.flush()
        os.fsync(target.fileno())


def load(path: Path, kind: type[P]) -> P:
    """Read a reduced part; see `ReducedPart.load`."""
    where = str(path)
    if path.is_dir():
        raise InputError(Problem(where, "is a folder, not a reduced part"))
    check_input(path)
    if not path.exists():
        raise MissingFileError(Problem(where, f"there is no such file; {AGAIN}"))
    try:
        sealed(path)  # check before opening, since HDF5 may crash on damaged files
        with h5py.File(path, "r") as opened:
            file = Group(opened)
            _check_version(file, where)
            header = bytes(np.asarray(file["header"])).decode()
            arrays = _read(file)
            checksum = str(file.attrs["checksum"])
    except InputError:
        raise
    except PermissionError as error:
        raise InputError(Problem(where, f"cannot be read: {error.strerror}")) from error
    except OSError as error:
        state = "damaged or truncated" if _looks_like_hdf5(path) else "not an HDF5 file"
        raise InputError(Problem(where, f"is {state} ({_short(error)}); {AGAIN}")) from error
    except DAMAGE as error:
        raise InputError(
            Problem(where, f"is incomplete or damaged ({_short(error)}); {AGAIN}")
        ) from error
    try:
        part = _part(header, arrays, kind)
    except InputError as error:
        raise InputError(
            [Problem(where, f"{problem.sentence}; {AGAIN}") for problem in error.problems]
        ) from error
    except KeyError as error:
        raise InputError(Problem(where, f"{error.args[0]} is missing; {AGAIN}")) from error
    except DAMAGE as error:
        raise InputError(Problem(where, f"is damaged ({_short(error)}); {AGAIN}")) from error
    if checksum != _checksum(header, arrays):
        raise InputError(
            Problem(where, f"its content was changed after writing (wrong checksum); {AGAIN}")
        )
    return part


def _arrays(part: Content) -> Arrays:
    v = part.invariants
    arrays: Arrays = {
        "nodes": part.nodes,
        "elements": part.elements.astype(np.int64),
        "frequencies": part.frequencies,
        "modes": part.modes,
        "invariants/mass": np.array(v.mass),
        "invariants/first_moment": v.first_moment,
        "invariants/second_moment": v.second_moment,
        "invariants/I3": v.I3,
        "invariants/N0": v.N0,
        "invariants/E": v.E,
    }
    if part.rotations is not None:
        arrays["rotations"] = part.rotations
    if part.rotation_nodes is not None:
        arrays["rotation_nodes"] = part.rotation_nodes.astype(np.int64)
    for face in part.faces:
        arrays[f"faces/{face.shape[1]}"] = face.astype(np.int64)
    if part.beams is not None:
        arrays |= {f"beams/{f.name}": getattr(part.beams, f.name) for f in fields(part.beams)}
    if part.outlines is not None:
        arrays["outlines/which"] = part.outlines.which.astype(np.int64)
        for k, edge in enumerate(part.outlines.edges):
            arrays[f"outlines/edges/{k}"] = edge
    if part.stress is not None:
        arrays["stress/positions"] = part.stress.positions
        arrays["stress/axes"] = part.stress.axes
        arrays["stress/modes"] = part.stress.modes
        for name in ("elasticity", "compliance"):
            if getattr(part.stress, name) is not None:
                arrays[f"stress/{name}"] = getattr(part.stress, name)
        if part.stress.residual is not None:
            arrays["stress/residual/columns"] = part.stress.residual.columns
            arrays["stress/residual/static"] = part.stress.residual.static
        if part.stress.scatter is not None:
            arrays["stress/scatter"] = part.stress.scatter.astype(np.float32)
    if part.stiffening is not None:
        arrays["stiffening/second_moment"] = part.stiffening.second_moment
        arrays["stiffening/translations"] = part.stiffening.translations
        arrays["stiffening/rotations"] = part.stiffening.rotations
    return arrays


def _part(header: str, arrays: Arrays, kind: type[P]) -> P:
    text = json.loads(header)
    stress = residual = None
    if text.get("residual"):
        residual = ResidualStress(
            tuple(text["residual"]),
            arrays["stress/residual/columns"],
            arrays["stress/residual/static"],
        )
    if text["labels"] is not None:
        stress = StressModes(
            tuple(text["labels"]),
            arrays["stress/positions"],
            arrays["stress/axes"],
            arrays["stress/modes"],
            arrays.get("stress/elasticity"),
            arrays.get("stress/compliance"),
            residual=residual,
            scatter=arrays.get("stress/scatter"),
        )
    field = None
    if any(key.startswith("stiffening/") for key in arrays):
        field = Stiffening(
            arrays["stiffening/second_moment"],
            arrays["stiffening/translations"],
            arrays["stiffening/rotations"],
        )
    beams = None
    if "beams/length" in arrays:
        beams = BeamElements(**{f.name: arrays[f"beams/{f.name}"] for f in fields(BeamElements)})
    outlines = None
    if "outlines/which" in arrays:
        count = sum(key.startswith("outlines/edges/") for key in arrays)
        outlines = Outlines(
            tuple(arrays[f"outlines/edges/{k}"] for k in range(count)), arrays["outlines/which"]
        )
    return kind(
        name=text["name"],
        nodes=arrays["nodes"],
        elements=arrays["elements"].astype(np.intp),
        node_sets={k: tuple(v) for k, v in text["node_sets"].items()},
        modes=arrays["modes"],
        rotations=arrays.get("rotations"),
        rotation_nodes=arrays.get("rotation_nodes"),
        frequencies=arrays["frequencies"],
        invariants=Invariants(
            float(arrays["invariants/mass"]),
            arrays["invariants/first_moment"],
            arrays["invariants/second_moment"],
            arrays["invariants/I3"],
            arrays["invariants/N0"],
            arrays["invariants/E"],
        ),
        stress=stress,
        interfaces=tuple(text["interfaces"]),
        provenance=text["provenance"],
        stiffening=field,
        faces=tuple(
            arrays[key].astype(np.intp) for key in sorted(arrays) if key.startswith("faces/")
        ),
        beams=beams,
        outlines=outlines,
    )


def _check_version(file: Group, where: str) -> None:
    found = file.attrs.get("format")
    if found != FORMAT:
        shown = f"its format is {found!r}" if found is not None else "it names no format"
        raise InputError(Problem(where, f"is not a reduced part: {shown}; {AGAIN}"))
    version = file.attrs.get("version")
    if not isinstance(version, (int, np.integer)) or not 1 <= version <= VERSION:
        raise InputError(
            Problem(
                where,
                f"has version {version} of the format, this jousto reads versions up to {VERSION}; "
                f"{AGAIN}",
            )
        )


def _read(group: Group, place: str = "") -> Arrays:
    arrays: Arrays = {}
    for name, item in group.items():
        if isinstance(item, Group):
            arrays |= _read(item, f"{place}{name}/")
        elif (place, name) != ("", "header"):
            arrays[place + name] = np.asarray(item[()])
    return arrays


def _checksum(header: str, arrays: Arrays) -> str:
    digest = hashlib.sha256(header.encode())
    for key in sorted(arrays):
        array = np.ascontiguousarray(arrays[key])
        digest.update(f"{key} {array.shape} {array.dtype.str}".encode())
        digest.update(array.data)
    return digest.hexdigest()


def _looks_like_hdf5(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(8) == b"\x89HDF\r\n\x1a\n"


def _short(error: Exception) -> str:
    text = str(error.args[0]) if error.args else type(error).__name__
    return text if len(text) <= 120 else text[:117] + "..."
