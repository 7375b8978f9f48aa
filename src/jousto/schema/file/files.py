"""Readers of the matrices and tables that a model file refers to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.base.files import check_input


def read_matrix(path: Path) -> Any:
    """Return a matrix from a Matrix Market, scipy, NumPy or Harwell-Boeing file.

    Raises
    ------
    InputError
        If the file does not exist, its ending is unknown or its content is not a matrix.
    """
    from jousto.parts.matrices.plain import SUFFIXES, read_plain

    return _read(path, dict.fromkeys(SUFFIXES, read_plain))


def read_points(path: Path) -> NDArray[np.float64]:
    """Return the rows of a table of positions from a .npy, .csv or .txt file.

    Raises
    ------
    InputError
        If the file does not exist, its ending is unknown or its content is not a table of numbers.
    """

    def table(file: Path) -> NDArray[np.float64]:
        comma = "," in file.read_text(encoding="utf-8")
        return np.loadtxt(file, delimiter="," if comma else None, ndmin=2)

    return np.asarray(_read(path, {".npy": np.load, ".csv": table, ".txt": table}))


def _read(path: Path, readers: dict[str, Any]) -> Any:
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise InputError(
            Problem("", f"{path.name!r} cannot be read, must end with {', '.join(readers)}")
        )
    check_input(path)
    if not path.is_file():
        raise MissingFileError(Problem("", f"no such file {str(path)!r}"))
    try:
        return reader(path)
    except InputError:
        raise
    except Exception as error:
        # the readers pass on exceptions of any type from their parsers
        raise InputError(Problem("", f"{path.name!r} cannot be read: {error}")) from None
