"""Nastran: OP4 files and DMIG punch files, with grids from the bulk data.

A superelement (EXTSEOUT) has boundary grids and scalar points of its modes; its punch file contains
the order of the rows (EXTRN). Displacements in local coordinate systems are rotated to the basic
one.
"""

from __future__ import annotations

import re
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, Sparse, as_csr
from jousto.base.errors import InputError, MissingFileError, Problem
from jousto.parts.matrices.nodes import Positions
from jousto.parts.matrices.text import expanded, read_text, refuse

EXTRA = "needs the package pyyeti: pip install pyyeti"
STIFFNESS = ("kaa", "kaax", "kxx", "kgg", "kjj", "k2gg", "k2jj", "k")
MASS = ("maa", "maax", "mxx", "mgg", "mjj", "m2gg", "m2jj", "m")
BULK = (".pch", ".asm", ".bdf", ".nas", ".dat")


def _nastran(path: Path) -> Any:
    try:
        # restore the print options of numpy, which the package changes
        with warnings.catch_warnings(), np.printoptions():
            warnings.simplefilter("ignore")
            from pyyeti import nastran
    except ImportError:
        raise refuse(path, EXTRA) from None
    return nastran


def read_op4(path: Path) -> tuple[Sparse, Sparse]:
    """Return K and M of an OP4 file by name (KAA, KXX, KGG ...; MAA, MXX, MGG ...).

    Raises
    ------
    InputError
        If the file is of another kind or truncated, or does not contain one K and one M.
    """
    if not path.is_file():
        raise MissingFileError(Problem("", f"no such file {str(path)!r}"))
    nastran = _nastran(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = nastran.op4.load(str(path), justmatrix=True, sparse=True)
    except Exception as error:
        # the reader raises the exceptions of its parsers, of any type
        reason = str(error).strip().partition("\n")[0] or "the file ends too early"
        raise refuse(path, f"is not an OP4 file, or it is truncated: {reason}") from None
    matrices = {name: as_csr(sp.csr_array(value)) for name, value in found.items()}
    k, m = _choose(path, matrices, STIFFNESS, "K"), _choose(path, matrices, MASS, "M")
    return matrices[k], matrices[m]


def _choose(path: Path, found: dict[str, Sparse], names: tuple[str, ...], letter: str) -> str:
    """Return the name of the matrix K or M among the names in the file."""
    name = next((name for name in names if name in found), None)
    if name is None:
        known = ", ".join(sorted(found)).upper() or "nothing"
        wanted = ", ".join(names[:4]).upper()
        raise refuse(
            path, f"contains no matrix {letter} under a known name ({wanted}); it has {known}"
        )
    shape = found[name].shape
    if shape[0] != shape[1]:
        raise refuse(path, f"{name.upper()} has shape {shape}, must be square")
    return name


def read_dmig(path: Path) -> tuple[Sparse, Sparse, Ints]:
    """Return K, M and the map of their rows from the DMIG entries of a punch or bulk file.

    Raises
    ------
    InputError
        If there are no such entries, or they are truncated.
    """
    text = read_text(path)
    if not re.search(r"^DMIG", text, flags=re.M | re.I):
        raise refuse(path, "contains no DMIG entries; ask Nastran for EXTSEOUT(ASMBULK,DMIGPCH)")
    nastran = _nastran(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            frames = nastran.rddmig(str(path), square=True)
    except Exception as error:
        reason = str(error).strip().partition("\n")[0] or "the file ends too early"
        raise refuse(path, f"has DMIG entries that cannot be read: {reason}") from None
    maps, values = {}, {}
    for name, frame in frames.items():
        maps[name] = np.array([tuple(i) for i in frame.index], dtype=np.int64)
        values[name] = as_csr(np.asarray(frame.to_numpy()))
    k, m = _choose(path, values, STIFFNESS, "K"), _choose(path, values, MASS, "M")

    # rows that only one of the two matrices has
    dofs = np.unique(np.concatenate([maps[k], maps[m]]), axis=0)
    return expanded(values[k], maps[k], dofs), expanded(values[m], maps[m], dofs), dofs


def read_grids(path: Path) -> tuple[Positions, Ints, dict[int, Array]]:
    """Return the grids of bulk data, the order of rows, and the axes of the displacements.

    Returns
    -------
    positions : Positions
        In the basic coordinate system.
    dofs : (ndof, 2) ndarray of int
        The order of EXTRN if given, else six rows per grid and one per scalar point, in ascending
        order of their numbers.
    axes : dict of int to (3, 3) ndarray
        For grids with local axes: matrix from displacements in basic axes to those in local axes.

    Raises
    ------
    InputError
        If there are no grids, or they cannot be read.
    """
    text = read_text(path)
    if not re.search(r"^GRID", text, flags=re.M | re.I):
        raise refuse(path, "contains no GRID entries; give the bulk data with the grids as nodes")
    nastran = _nastran(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            uset = nastran.bulk2uset(str(path))[0]
            rigid = np.asarray(nastran.n2p.rbgeom_uset(uset))
            extrn = nastran.rdextrn(str(path)) if re.search(r"^EXTRN", text, flags=re.M) else None
            points = nastran.rdspoints(str(path)) if re.search(r"^SPOINT", text, re.M) else None
    except Exception as error:
        reason = str(error).strip().partition("\n")[0] or "the file ends too early"
        raise refuse(path, f"has bulk data that cannot be read: {reason}") from None
    index = np.array([tuple(i) for i in uset.index], dtype=np.int64)
    first = np.flatnonzero(index[:, 1] == 1)
    ids = index[first, 0]
    xyz = np.asarray(uset.to_numpy(), dtype=np.float64)[first][:, 1:4]
    # rows of rigid translations are the components of basic displacements in the grid's axes
    turns = {int(i): rigid[row : row + 3, :3] for i, row in zip(ids, first, strict=True)}
    axes = {i: R for i, R in turns.items() if np.abs(R - np.eye(3)).max() > 1e-12}
    if extrn is not None and len(extrn):
        return Positions(ids, xyz), np.asarray(extrn, dtype=np.int64), axes
    rows = [(int(i), c) for i in ids for c in range(1, 7)]
    if points is not None and np.size(points):
        rows += [(int(p), 0) for p in np.ravel(points)]
    return Positions(ids, xyz), np.array(sorted(rows), dtype=np.int64), axes


def to_basic(matrix: Sparse, dofs: Ints, axes: dict[int, Array], where: str) -> Sparse:
    """Return the matrix for displacements in the basic coordinate system, ``B^T K B``.

    Raises
    ------
    InputError
        If a grid with local axes has only some of its directions in the matrix.
    """
    if not axes:
        return matrix
    n = len(dofs)
    row_of = {tuple(pair): i for i, pair in enumerate(dofs.tolist())}
    turn = sp.lil_array(sp.eye_array(n))
    for grid, R in axes.items():
        for start in (1, 4):
            rows = [row_of.get((grid, start + a)) for a in range(3)]
            present = [row for row in rows if row is not None]
            if present and len(present) < 3:
                raise InputError(
                    Problem(
                        where,
                        f"grid {grid} has local axes and only some of its directions in the "
                        f"matrix; write the matrix in the basic coordinate system (field CD of "
                        f"GRID)",
                    )
                )
            for a, i in enumerate(present):
                for b, j in enumerate(present):
                    turn[i, j] = R[a, b]
    B = as_csr(turn.tocsr())
    return as_csr(B.T @ matrix @ B)
