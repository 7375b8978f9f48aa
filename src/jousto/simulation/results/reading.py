"""Opening a results file: whatever is wrong with it is one sentence."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.base.files import check_file
from jousto.base.hdf5 import Group, damage, open_format
from jousto.base.seal import Sealed, sealed
from jousto.simulation.results.validate import check_results
from jousto.simulation.results.writer import CONTENTS, FORMAT, FORMAT_VERSION

AGAIN = "run the model again, or restore a copy of the file"


@contextmanager
def open_results(path: Path) -> Iterator[Group]:
    """Open a results file for reading, also one whose run is going on or was killed.

    What its reader stumbles over in the block is reported as damage of the file.

    Raises
    ------
    InputError
        If there is no such file, it is damaged, or it is something else than results.
    """
    check_file(path)
    if not path.is_file():
        raise MissingFileError(Problem(str(path), "no such results file"))
    with open_format(path, FORMAT, "a results file", AGAIN) as file:
        _check_version(file, path)
        yield file


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
