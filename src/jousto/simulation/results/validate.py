"""Checks of a results file when it is opened: required fields, types, shapes and checksums."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.checksums import Sealed, sealed
from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.base.files import check_input
from jousto.base.hdf5 import Group, check_dataset, damage, open_format
from jousto.simulation.results.row_layout import DIAGNOSTICS
from jousto.simulation.results.stress import BEAMS, knows_stress, read_beam, read_stress
from jousto.simulation.results.writer import CONTENTS, EVENT_COLUMNS, FORMAT, FORMAT_VERSION
from jousto.simulation.state import MEMORY

TEXTS = ("name", "run", "solver")
NUMBERS = ("complete",)


AGAIN = "run the model again, or restore a copy of the file"


def check_results(file: Group) -> None:
    """Check the fields, types and shapes of a results file.

    Raises
    ------
    ValueError, KeyError, InputError
        With the first field that is missing or has a wrong type, shape or value.
    """
    for name in TEXTS:
        _text(file.attrs, name)
    for name in NUMBERS:
        _whole(file.attrs, name)
    length = int(file.array("rows", (), "iu"))
    check_dataset(file["time"], (None,))
    room = len(file["time"])
    if not 0 <= length <= room:
        raise ValueError(f"rows is {length}, the datasets have {room} rows")
    time = file["time"][:length]
    if not np.isfinite(time).all() or (np.diff(time) < 0.0).any():
        raise ValueError("time must be finite and ascending")
    check_dataset(file["model"], (), "OS")
    for name in DIAGNOSTICS:
        check_dataset(file[f"diagnostics/{name}"], (room,))
    nq, nv = _bodies(file)
    check_dataset(file["state/q"], (room, nq))
    check_dataset(file["state/v"], (room, nv))
    check_dataset(file["state/multipliers"], (room, None))
    for name in MEMORY:
        if f"state/{name}" in file:
            check_dataset(file[f"state/{name}"], (room, None))
    if "state/input" in file:
        names = _names(file["state/input"].attrs["names"], "state/input names")
        check_dataset(file["state/input"], (room, len(names)))
    _sensors(file, room)
    _beams(file, nq, nv)
    if "events" in file:
        _events(file)


def _bodies(file: Group) -> tuple[int, int]:
    """Check the bodies and return the numbers of positions and velocities."""
    nq = nv = 0
    for name, body in file.groups("bodies"):
        _text(body.attrs, "kind")
        n, iq, iv = (_whole(body.attrs, key) for key in ("modes", "q_offset", "v_offset"))
        if n < 0 or iq < 0 or iv < 0:
            raise ValueError(f"bodies/{name} has negative offsets or modes")
        nodes = body.array("nodes", (None, 3), finite=True)
        elements = body.array("elements", (None, None), "iu")
        if elements.size and not 0 <= elements.min() <= elements.max() < len(nodes):
            raise ValueError(f"bodies/{name}/elements refers to nodes that do not exist")
        body.array("mode_shapes", (len(nodes), 3, n), finite=True)
        nq, nv = max(nq, iq + 7 + n), max(nv, iv + 6 + n)
        if knows_stress(body):
            stress = read_stress(body)
            if stress is not None and stress.modes.shape[-1] != n:
                raise ValueError(f"bodies/{name}/stress does not have the {n} modes of the body")
    return nq, nv


def _sensors(file: Group, room: int) -> None:
    known = file.group("components")
    for name, sensor in file.group("sensors").items():
        check_dataset(known[name], (None,), "S")
        _names(known[name][()], f"components/{name}")
        check_dataset(sensor, (room, known[name].shape[0]))
        for key in ("unit", "resolved_in", "description"):
            _text(sensor.attrs, key)


def _beams(file: Group, nq: int, nv: int) -> None:
    if BEAMS not in file:
        return
    for name, group in file.groups(BEAMS):
        nodes = len(read_beam(name, group).bodies)
        for key, size, width in (("iq", nq, 7), ("iv", nv, 6)):
            places = group.array(key, (nodes,), "iu")
            if not 0 <= places.min() <= places.max() <= size - width:
                raise ValueError(f"{BEAMS}/{name}/{key} refers to indices beyond the state")


def _events(file: Group) -> None:
    table = file.group("events")
    _whole(table.attrs, "events")
    check_dataset(table["names"], (None,), "S")
    names = _names(table["names"][()], "events/names")
    if "joints" in table:
        check_dataset(table["joints"], (len(names),), "S")
        _names(table["joints"][()], "events/joints")
    count = int(table.array("rows", (), "iu"))
    for name, _, _ in EVENT_COLUMNS:
        check_dataset(table[name], (None,))
        if not 0 <= count <= len(table[name]):
            raise ValueError(f"events/rows is {count}, events/{name} has {len(table[name])}")
        if not np.isfinite(table[name][:count]).all():
            raise ValueError(f"events/{name} contains numbers that are not finite")
    source = table["source"][:count]
    if count and not 0 <= source.min() <= source.max() < len(names):
        raise ValueError("events/source refers to events that do not exist")


def _text(attrs: Any, name: str) -> str:
    found = attrs[name] if name in attrs else None
    if not isinstance(found, str):
        raise ValueError(f"attribute {name} is missing or not a text")
    return found


def _whole(attrs: Any, name: str) -> int:
    found = attrs[name] if name in attrs else None
    if not isinstance(found, (int, np.integer)):
        raise ValueError(f"attribute {name} is missing or not a whole number")
    return int(found)


def _names(found: Any, place: str) -> list[str]:
    try:
        return [name.decode() for name in found]
    except (AttributeError, UnicodeDecodeError) as error:
        raise ValueError(f"{place} contains values that are not names") from error


@contextmanager
def open_results(path: Path) -> Iterator[Group]:
    """Yield the root group of a results file, also during its run or after it was killed.

    Errors of the HDF5 library inside the ``with`` block are reported as damage of the file.

    Raises
    ------
    InputError
        If the file does not exist, is damaged or is not a results file.
    """
    check_input(path)
    if not path.is_file():
        raise MissingFileError(Problem(str(path), "no such results file"))
    with open_format(path, FORMAT, "a results file", AGAIN) as file:
        _check_version(file, path)
        yield file


def examine(path: Path) -> Sealed | None:
    """Check a results file before its first use; return its checksums, None if it has none.

    Valid checksums prove that the file is unchanged. If a file has no checksums (its run was killed
    early, or another program changed it), all fields, types and shapes are checked.

    Raises
    ------
    InputError
        With the first error found.
    """
    if path.is_file():
        with damage(path, AGAIN):
            seal = sealed(path)
        if seal is not None:
            return seal
    with open_results(path) as file:
        missing = [name for name in CONTENTS if name not in file]
        if missing:
            raise ValueError(f"{', '.join(missing)} missing")
        check_results(file)
    return None


def _check_version(file: Group, path: Path) -> None:
    written = int(file.attrs["format_version"])
    if written != FORMAT_VERSION:
        by = file["model"].attrs.get("version", "unknown")
        raise InputError(
            Problem(
                str(path),
                f"results format {written}, this version reads {FORMAT_VERSION}; written by "
                f"jousto {by}: run the model again",
            )
        )
