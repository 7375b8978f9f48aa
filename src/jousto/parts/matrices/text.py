"""Fast readers of numbers in text files, with messages for damaged files."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, Sparse, as_csr
from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.base.files import check_text


def refuse(path: Path, message: str) -> InputError:
    """Return the error for a file with a problem."""
    return InputError(Problem(path.name, message))


def read_text(path: Path) -> str:
    """Return the text of a file.

    Raises
    ------
    InputError
        If the file does not exist, is empty, or is no text.
    """
    check_text(path)
    if not path.is_file():
        raise MissingFileError(Problem("", f"no such file {str(path)!r}"))
    data = path.read_bytes()
    if not data.strip():
        raise refuse(path, "is empty: the program that writes it may have stopped early")
    if b"\0" in data[:4096]:
        raise refuse(path, "is a binary file, text is expected; check the format")
    return data.decode("utf-8", errors="replace")


def read_numbers(path: Path, text: str, columns: int, what: str) -> Array:
    """Return the rows (n, columns) of numbers separated by blanks, commas or line ends.

    Parameters
    ----------
    path : Path
        File, for messages.
    text : str
    columns : int
        Numbers in a line.
    what : str
        Format of a line, for messages (``"i j value"``).

    Raises
    ------
    InputError
        With the first line that has another format; also for a truncated last line.
    """
    plain = _plain(text)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            values = np.fromstring(plain, sep=" ")
        except (DeprecationWarning, ValueError):
            values = np.zeros(0)
    if len(values) and len(values) % columns == 0:
        return values.reshape(-1, columns)
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    for number, line in enumerate(lines):
        try:
            good = len([float(word) for word in _plain(line).split()]) == columns
        except ValueError:
            good = False
        if not good:
            found = line[:60]
            if number == len(lines) - 1 and number:
                raise refuse(
                    path,
                    f"ends with {found!r} where {what} is expected: the file is truncated; write "
                    f"or copy it again",
                )
            raise refuse(path, f"line {number + 1} is {found!r}, {what} is expected")
    raise refuse(path, f"holds no lines of {what}")


def _plain(text: str) -> str:
    """Return numbers separated by blanks; Fortran exponents D are allowed."""
    return text.replace(",", " ").replace("D", "E").replace("d", "e")


def from_triplets(
    path: Path, row: Ints, column: Ints, value: Array, n: int, *, symmetric: bool | None = None
) -> Sparse:
    """Return a matrix (n, n) from indices, counted from 0, and values.

    Parameters
    ----------
    path : Path
        File, for messages.
    row, column : (m,) ndarray of int
    value : (m,) ndarray
    n : int
        Number of rows.
    symmetric : bool, optional
        Whether the file contains one triangle only; None detects it.

    Raises
    ------
    InputError
        If an index is out of range.
    """
    low, high = min(row.min(), column.min()), max(row.max(), column.max())
    if low < 0 or high >= n:
        bad = int(low if low < 0 else high) + 1
        raise refuse(path, f"row {bad} is outside of 1..{n}")
    matrix = as_csr(sp.coo_array((value, (row, column)), shape=(n, n)).tocsr())
    if symmetric is None:
        # no entry has its mirror image (the order of rows may differ from that in the program)
        both = matrix.multiply(matrix.T).tocsr()
        symmetric = bool(both.nnz == np.count_nonzero(matrix.diagonal()))
    return mirrored(matrix) if symmetric else matrix


def mirrored(matrix: Sparse) -> Sparse:
    """Return the full matrix from one triangle with its diagonal."""
    return as_csr(matrix + matrix.T - diagonal(matrix.diagonal()))


def diagonal(values: Array) -> Sparse:
    """Return the diagonal matrix of values (n,)."""
    i = np.arange(len(values))
    return as_csr(sp.coo_array((values, (i, i)), shape=(len(i), len(i))).tocsr())


def expanded(matrix: Sparse, rows: Ints, dofs: Ints) -> Sparse:
    """Return a matrix with the rows ``rows`` (n, 2) enlarged to the rows ``dofs`` (m, 2)."""
    place = {tuple(pair): i for i, pair in enumerate(dofs.tolist())}
    at = np.array([place[tuple(pair)] for pair in rows.tolist()], dtype=np.int64)
    coo = matrix.tocoo()
    shape = (len(dofs), len(dofs))
    return as_csr(sp.coo_array((coo.data, (at[coo.row], at[coo.col])), shape=shape).tocsr())
