"""Where the command line writes: next to the input, never over it or over other data."""

from __future__ import annotations

import os
from pathlib import Path

from jousto.errors import InputError, Problem
from jousto.schema.document import is_hdf5


def output_path(given: Path | None, source: Path, name: str, *, keep: str = "") -> Path:
    """Return where to write, next to the input by default, never over an input.

    Parameters
    ----------
    given : Path or None
        What the user asked for.
    source : Path
        The input file.
    name : str
        Default file name, or ending such as ``.h5`` for the name of the input.
    keep : str
        Format of HDF5 files that must not be overwritten.

    Raises
    ------
    InputError
        If it is the input, a folder, in a folder that does not exist, or holds other data.
    """
    default = source.with_suffix(name) if name.startswith(".") else source.with_name(name)
    path = default if given is None else given
    if path.exists() and source.exists() and path.samefile(source):
        raise InputError(Problem(str(path), "is the input, it would be overwritten; give -o FILE"))
    if path.is_dir():
        raise InputError(Problem(str(path), "is a folder, must be a file"))
    if not path.parent.is_dir():
        raise InputError(Problem(str(path), f"there is no folder {str(path.parent)!r}"))
    if not os.access(path if path.exists() else path.parent, os.W_OK):
        raise InputError(Problem(str(path), "must not be written to (no permission)"))
    if keep and path.is_file() and hdf5_format(path) == keep:
        content = keep.removeprefix("jousto ").replace("reduced", "a reduced")
        raise InputError(Problem(str(path), f"holds {content}; give -o FILE"))
    return path


def hdf5_format(path: Path) -> str:
    """Return the format attribute of an HDF5 file, empty if it is none of jousto's."""
    if not is_hdf5(path):
        return ""
    import h5py

    try:
        with h5py.File(path, "r") as file:
            return str(file.attrs.get("format", ""))
    except OSError:
        return ""
