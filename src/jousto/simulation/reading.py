"""Opening a results file: whatever is wrong with it is one sentence."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from jousto.errors import InputError, MissingFileError, Problem
from jousto.files import check_file
from jousto.hdf5 import DAMAGE, Group, damage, opened, said
from jousto.seal import Sealed, sealed
from jousto.simulation.results import CONTENTS, FORMAT, FORMAT_VERSION
from jousto.simulation.validate import check_results

AGAIN = "run the model again, or restore a copy of the file"


@contextmanager
def open_results(path: Path) -> Iterator[Group]:
    """Open a results file for reading, also one whose run is going on or was killed.

    What its reader stumbles over in the block is told as damage of the file.

    Raises
    ------
    InputError
        If there is no such file, it is damaged, or it is something else than results.
    """
    check_file(path)
    if not path.is_file():
        raise MissingFileError(Problem(str(path), "no such results file"))
    try:
        file = opened(path)
    except DAMAGE as error:
        raise InputError(
            Problem(
                str(path), f"not readable as HDF5, damaged or another kind of file ({said(error)})"
            )
        ) from error
    with file, damage(path, AGAIN):
        group = Group(file)
        _check_kind(group, path)
        yield group


def examine(path: Path) -> Sealed | None:
    """Check a results file before it is used; return its checksums.

    With checksums the file is as it was written. Without (killed before they were, or written to
    by another program) everything that it holds must have its place, type and shape.

    Raises
    ------
    InputError
        Naming what is wrong with it.
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


def _check_kind(file: Group, path: Path) -> None:
    found = file.attrs.get("format", "")
    if not isinstance(found, str) or found != FORMAT:
        kind = f"it is a file of {found!r}" if found else "it is some other HDF5 file"
        raise InputError(Problem(str(path), f"not a results file; {kind}"))
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
