"""Ansys: .full files of the assembled matrices, nodes from .rst and .cdb files."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, Sparse, as_csr
from jousto.base.errors import MissingFileError, Problem
from jousto.mesh.readers.subprocess_reader import apart
from jousto.parts.matrices.nodes import Positions
from jousto.parts.matrices.text import mirrored, refuse

DAMAGED = "the file is probably damaged: copy it again or solve the model again"
EXTRA = "needs the package ansys-mapdl-reader: pip install ansys-mapdl-reader"


def read_full(path: Path) -> tuple[Sparse, Sparse, Ints, Ints]:
    """Return K, M, the map of their rows and the fixed directions, from a .full file.

    The file stores upper triangles; rows of fixed directions are empty.

    Raises
    ------
    InputError
        If the file is of another kind, or its mass matrix is missing or lumped.
    """
    _check_binary(path, ".full")
    found = apart(path, f"{__name__}:full_arrays", DAMAGED)
    dofs, held = found["dofs"], found["held"]
    for kind, letter, remedy in (
        ("stiffness", "K", "solve a modal analysis (ANTYPE,MODAL) and keep its .full file"),
        ("mass", "M", "a static analysis has none: solve a modal analysis (ANTYPE,MODAL)"),
    ):
        if found[letter] is None:
            raise refuse(path, f"contains no {kind} matrix; {remedy}")
    K, M = (_matrix(found[letter]) for letter in "KM")
    map_of = np.asarray(dofs, dtype=np.int64) + np.array([0, 1])
    held = held + np.array([0, 1])
    return mirrored(K), mirrored(M), map_of, held[np.lexsort(held.T[::-1])]


def read_result_nodes(path: Path) -> Positions:
    """Return the nodes of a .rst file.

    Raises
    ------
    InputError
        If the file is of another kind.
    """
    _check_binary(path, ".rst")
    found = apart(path, f"{__name__}:result_arrays", DAMAGED)
    return Positions(found["ids"], found["xyz"])


# ---- in a separate process, since the reader may crash -------------------------------------------


def full_arrays(path: Path) -> dict[str, Any]:
    """Return the matrices of a .full file (None if missing), their map, and fixed directions."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        full = _open(path, ".full")
        try:
            dofs, K, M = full.load_km(sort=True)
            held = np.asarray(full.const, dtype=np.int64).reshape(-1, 2)
        except Exception as error:
            # the reader raises the exceptions of its parsers, of any type
            raise refuse(path, f"is damaged: {error}") from None
    return {
        "dofs": np.asarray(dofs, dtype=np.int64),
        "held": held,
        "K": _pieces(K),
        "M": _pieces(M),
    }


def result_arrays(path: Path) -> dict[str, Any]:
    """Return numbers and positions of the nodes of a .rst file."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        mesh = _open(path, ".rst").mesh
        ids: Ints = np.asarray(mesh.nnum, dtype=np.int64)
        xyz: Array = np.asarray(mesh.nodes, dtype=np.float64)[:, :3]
    return {"ids": ids, "xyz": xyz}


def _pieces(matrix: Any) -> list[Any] | None:
    if matrix is None:
        return None
    csr = as_csr(matrix)
    return [csr.data, csr.indices, csr.indptr, list(csr.shape)]


def _matrix(pieces: list[Any]) -> Sparse:
    data, indices, indptr, shape = pieces
    return as_csr(sp.csr_matrix((data, indices, indptr), shape=tuple(shape)))


def _check_binary(path: Path, kind: str) -> None:
    """Raise InputError unless a file is complete and of the kind, since the reader may crash.

    The file has Fortran records of 4-byte words: length, a mark, and the standard header of 100
    words, which begins with the number of the kind of file. In .full files a second header follows
    at word 103; its items 23 and 24 contain the length of the file.
    """
    if not path.is_file():
        raise MissingFileError(Problem("", f"no such file {str(path)!r}"))
    number = {".full": 4, ".rst": 12}[kind]
    words = np.fromfile(path, dtype="<i4", count=205)
    if len(words) < 4 or words[0] != 100 or words[1] != -(2**31):
        raise refuse(path, f"is not an Ansys {kind} file, or it is damaged")
    if words[2] != number:
        raise refuse(path, f"is a binary file of Ansys of another kind; a {kind} file is needed")
    if kind == ".full":
        size = path.stat().st_size
        if len(words) < 129:
            raise refuse(path, f"is truncated: it ends after {size} bytes; copy it again")
        end = 4 * (int(words[127]) + (int(words[128]) << 32))
        if size < end:
            raise refuse(path, f"is truncated: it has {size} of {end} bytes; copy it again")


def _open(path: Path, kind: str) -> Any:
    try:
        with np.printoptions():
            from ansys.mapdl import reader
    except ImportError:
        raise refuse(path, EXTRA) from None
    try:
        return reader.read_binary(str(path))
    except NotImplementedError as error:  # raised by the reader for unknown kinds of files
        raise refuse(path, f"cannot be used: {error}") from None
    except Exception:
        raise refuse(path, f"is not an Ansys {kind} file, or it is damaged") from None
