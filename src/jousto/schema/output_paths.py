"""Output paths of the command line: next to the input, never over input or other data."""

from __future__ import annotations

import os
from pathlib import Path

from jousto.base.errors import InputError, Problem
from jousto.base.files import check_file, check_input
from jousto.schema.file.document import DOCUMENTS, is_hdf5

RESULTS, REDUCED_PART = "jousto results", "jousto reduced part"
MONITOR = "jousto monitor"
DAMAGED = "damaged"
WORDS = {
    RESULTS: "results",
    REDUCED_PART: "a reduced part",
    MONITOR: "the record of a monitoring run",
}

# file types that a picture must not overwrite
DATA = (*DOCUMENTS, ".h5", ".hdf5")


def output_path(given: Path | None, source: Path, name: str, *, kind: str = "") -> Path:
    """Return the output path, by default next to the input; raise an error if it is an input.

    Parameters
    ----------
    given : Path or None
        Path requested by the user.
    source : Path
        The input file.
    name : str
        Default file name, or ending such as ``.h5`` for the name of the input.
    kind : str
        Format of the HDF5 file that will be written, `RESULTS` or `REDUCED_PART`; empty for
        pictures. Only files of that kind are overwritten.

    Raises
    ------
    InputError
        If the path is the input, a folder, in a missing folder, or contains other data; or if the
        input is a folder.
    """
    check_input(source)
    if given is not None:
        path = given
    else:
        path = source.with_suffix(name) if name.startswith(".") else source.parent / name
    if path.exists() and source.exists() and path.samefile(source):
        raise InputError(Problem(str(path), "is the input, it would be overwritten; give -o FILE"))
    check_file(path)
    if not path.parent.is_dir():
        raise InputError(Problem(str(path), f"there is no folder {str(path.parent)!r}"))
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InputError(Problem(str(path), "must not be written to (no permission)"))
    content = worth_keeping(path, kind)
    if content:
        raise InputError(Problem(str(path), f"holds {content}; give -o FILE"))
    return path


def worth_keeping(path: Path, kind: str) -> str:
    """Return the kind of content at a path that output must not replace; empty if none."""
    if not path.is_file() or not path.stat().st_size:
        return ""
    if not kind:
        return "data, not a picture" if path.suffix.lower() in DATA or is_hdf5(path) else ""
    found = hdf5_format(path)
    if found in (kind, DAMAGED):
        return ""
    return WORDS.get(found, f"something other than {WORDS[kind]}")


def hdf5_format(path: Path) -> str:
    """Return the format attribute of an HDF5 file; empty for files of other programs."""
    if not is_hdf5(path):
        return ""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return str(file.attrs.get("format", ""))
    except OSError:
        return DAMAGED
