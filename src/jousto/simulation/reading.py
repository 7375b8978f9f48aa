"""Opening a results file: whatever is wrong with it is one sentence."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import h5py

from jousto.errors import InputError, MissingFileError, Problem
from jousto.simulation.results import CONTENTS, FORMAT, FORMAT_VERSION


@contextmanager
def open_results(path: Path) -> Iterator[h5py.File]:
    """Open a results file for reading, also one whose run is going on or was killed.

    Raises
    ------
    InputError
        If there is no such file, it is damaged, or it is something else than results.
    """
    if not path.is_file():
        raise MissingFileError(Problem(str(path), "no such results file"))
    try:
        with _open(path) as file:
            _check_kind(file, path)
            yield file
    except InputError:
        raise
    except OSError as error:
        raise InputError(
            Problem(str(path), f"not readable as HDF5, damaged or another kind of file ({error})")
        ) from error
    except (KeyError, RuntimeError, ValueError, TypeError) as error:
        raise InputError(Problem(str(path), f"damaged: {error}; run the model again")) from error


def _open(path: Path) -> h5py.File:
    try:
        return h5py.File(path, "r", locking=False)
    except OSError as error:
        if "locking flag" not in str(error):
            raise
        return h5py.File(path, "r")  # the process has it open with locking


def _check_kind(file: h5py.File, path: Path) -> None:
    found = file.attrs.get("format", "")
    if found != FORMAT:
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
    missing = [name for name in CONTENTS if name not in file]
    if missing:
        raise InputError(
            Problem(str(path), f"damaged: {', '.join(missing)} missing; run the model again")
        )
