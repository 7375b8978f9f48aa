"""Matrices without a map of their rows: Matrix Market, NumPy, scipy, Harwell-Boeing."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Sparse, as_csr
from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.base.files import DAMAGED_NPZ
from jousto.parts.matrices.text import from_triplets, read_text, refuse

HARWELL_BOEING = (".hb", ".rb", ".rsa", ".rua")
MOST_EMPTY = 100_000
"""Largest number of rows accepted from a header if the file has no entries."""
SUFFIXES = (".mtx", ".npz", ".npy", *HARWELL_BOEING)


def read_plain(path: Path) -> Sparse:
    """Return the matrix of a .mtx, .npz, .npy or Harwell-Boeing (.hb, .rb, .rsa ...) file.

    Raises
    ------
    InputError
        If the file does not exist, or its content does not fit its ending.
    """
    if not path.is_file():
        raise MissingFileError(Problem(path.name, f"no such file {str(path)!r}"))
    suffix = path.suffix.lower()
    if suffix in HARWELL_BOEING:
        return read_harwell_boeing(path)
    kind = {".mtx": "Matrix Market", ".npz": "scipy sparse", ".npy": "NumPy"}[suffix]
    try:
        matrix: Any
        if suffix == ".mtx":
            import scipy.io

            _check_header(path)
            matrix = scipy.io.mmread(path, spmatrix=False)
        elif suffix == ".npz":
            matrix = sp.load_npz(path)
        else:
            matrix = np.load(path, allow_pickle=False)
        if np.iscomplexobj(matrix):
            raise refuse(path, "is complex; the real part of an undamped matrix is needed")
        if matrix.ndim != 2:
            raise refuse(path, f"has shape {matrix.shape}, a matrix has rows and columns")
        return as_csr(matrix)
    except InputError:
        raise
    except OSError as error:
        raise refuse(path, f"cannot be read as a {kind} file: {error}") from None
    # scipy raises NotImplementedError for unknown sparse formats
    except (ValueError, KeyError, TypeError, EOFError, NotImplementedError) as error:
        reason = str(error).strip().splitlines()
        message = f"cannot be read as a {kind} file: {reason[0] if reason else 'it is damaged'}"
        raise refuse(path, f"{message}; check that the file is complete and of this kind") from None
    except Exception as error:
        if type(error).__module__.startswith("jousto"):
            raise
        raise refuse(path, f"is not a {kind} file, or it is damaged: {error}") from None


def _check_header(path: Path) -> None:
    """Raise InputError if a file is shorter than its Matrix Market header states."""
    size = path.stat().st_size
    with path.open("rb") as file:
        kind = file.readline(1024).lower()
        line = file.readline(1 << 16)
        while line.startswith(b"%") or (line and not line.strip()):
            line = file.readline(1 << 16)
    numbers = [int(word) for word in line.split() if word.isdigit()]
    sparse = b"array" not in kind
    if len(numbers) < 2 or (sparse and len(numbers) < 3):
        return  # the reader reports the problem
    rows, columns = numbers[:2]
    entries = numbers[2] if sparse else rows * columns // (1 if b"general" in kind else 2)
    # an entry has at least "1 1 1" and a line end, or "1" in a full matrix
    if entries * (6 if sparse else 2) > size + 2:
        raise refuse(
            path,
            f"announces {entries} entries, but has {size} bytes; the file is "
            f"truncated or its header damaged",
        )
    # each row of a stiffness or mass matrix has an entry
    if sparse and max(rows, columns) > MOST_EMPTY + 100 * entries:
        raise refuse(
            path,
            f"announces {rows} x {columns} with {entries} entries; its header is probably damaged",
        )


def is_pair(path: Path) -> bool:
    """Return whether a .npz file contains arrays with the names M and K."""
    if path.suffix.lower() != ".npz" or not path.is_file():
        return False
    try:
        with path.open("rb") as raw, np.load(raw, allow_pickle=False) as data:
            return {"M", "K"} <= set(data.files)
    except DAMAGED_NPZ:
        return False


def read_pair(path: Path) -> dict[str, Array]:
    """Return all arrays of a .npz file with M and K."""
    try:
        with path.open("rb") as raw, np.load(raw, allow_pickle=False) as data:
            return {name: np.asarray(data[name]) for name in data.files}
    except DAMAGED_NPZ as error:
        raise refuse(path, f"cannot be read, it is damaged: {error}; write it again") from None


def read_harwell_boeing(path: Path) -> Sparse:
    """Return the real, assembled matrix of a Harwell-Boeing or Rutherford-Boeing file.

    The file has Fortran formats: column pointers, row numbers and values in fields of fixed
    width (Duff, Grimes, Lewis: Users' guide for the Harwell-Boeing sparse matrix collection,
    1992). Symmetric files (RSA) contain the lower triangle.

    Raises
    ------
    InputError
        If the file is truncated, or contains complex numbers, a pattern without values, or
        unassembled element matrices.
    """
    lines = read_text(path).splitlines()
    if len(lines) < 4:
        raise refuse(path, "is no Harwell-Boeing file: the header of four lines is missing")
    try:
        cards = [int(word) for word in lines[1].split()]
        kind, sizes = lines[2][:3].upper(), [int(word) for word in lines[2][3:].split()]
        widths = [_width(lines[3][:16]), _width(lines[3][16:32]), _width(lines[3][32:52])]
        rows, columns, entries = sizes[:3]
    except (ValueError, IndexError):
        raise refuse(path, "is no Harwell-Boeing file: its header cannot be read") from None
    known = {"R": "real", "C": "complex", "P": "a pattern without values", "I": "integer"}
    if kind[:1] not in ("R", "I") or kind[2:] != "A":
        found = known.get(kind[:1], "of unknown kind")
        found = found if kind[2:] == "A" else "of unassembled element matrices"
        raise refuse(
            path, f"contains a matrix of type {kind}, which is {found}; RSA or RUA is needed"
        )

    # blocks of lines: pointers, row numbers, values
    start = 4 + (1 if len(cards) > 4 and cards[4] > 0 else 0)
    blocks = []
    for width, count, wanted in zip(
        widths, cards[1:4], (columns + 1, entries, entries), strict=True
    ):
        try:
            values = _fields(lines[start : start + count], width)
        except ValueError as error:
            raise refuse(path, f"is damaged: {error}") from None
        if len(values) < wanted:
            raise refuse(
                path,
                f"is truncated: one of its blocks has {len(values)} of {wanted} numbers; write or "
                f"copy it again",
            )
        blocks.append(values[:wanted])
        start += count
    pointer, row = blocks[0].astype(np.int64) - 1, blocks[1].astype(np.int64) - 1
    value = blocks[2]
    if rows != columns or np.any(np.diff(pointer) < 0) or pointer[-1] != entries:
        raise refuse(path, f"is damaged: {rows} rows, {columns} columns, bad column pointers")
    column = np.repeat(np.arange(columns), np.diff(pointer))
    return from_triplets(path, row, column, value, rows, symmetric=kind[1] == "S")


def _width(fortran: str) -> int:
    """Return the width of a Fortran format such as (16I5), (1P5E15.8) or (3(1P,E25.17))."""
    found = re.search(r"[IEDFG](\d+)", fortran.upper())
    if found is None:
        raise ValueError(fortran)
    return int(found.group(1))


def _fields(lines: list[str], width: int) -> Array:
    """Return numbers from fields of fixed width, or from words if the fields are not aligned."""
    cut = [line[i : i + width] for line in lines for i in range(0, len(line.rstrip()), width)]
    try:
        return _floats([word for word in cut if word.strip()])
    except ValueError:
        return _floats(" ".join(lines).split())


def _floats(words: list[str]) -> Array:
    return np.array([word.replace("D", "E").replace("d", "e") for word in words], dtype=np.float64)
