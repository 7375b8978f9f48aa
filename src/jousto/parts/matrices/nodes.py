"""Positions of the nodes of matrices."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, MissingFileError, Problem, Problems
from jousto.base.files import check_input
from jousto.parts.matrices.text import refuse

TABLES = (".npy", ".csv", ".txt")


@dataclass(frozen=True, eq=False)
class Positions:
    """Positions of numbered nodes.

    Parameters
    ----------
    ids : (nn,) ndarray of int or None
        Node numbers; None if only the order is known.
    xyz : (nn, 3) ndarray
        Positions in the unit of the files, or in m.
    node_sets : mapping of str to node numbers
    elements : (ne, m) ndarray of int
        Rows of xyz.
    metres : bool
        Whether xyz is in m.
    """

    ids: Ints | None
    xyz: Array
    node_sets: Mapping[str, Ints] = field(default_factory=dict)
    elements: Ints = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    metres: bool = False


def read_positions(nodes: Any, unit: str) -> Positions:
    """Return the positions of a mesh, a mesh file, a table or an array.

    Parameters
    ----------
    nodes : Mesh, str, Path or array_like
        Arrays and tables have three columns x, y, z, sorted by node number, or four columns with
        the node number first.
    unit : str
        Unit of length of files and arrays; a Mesh is in m.

    Raises
    ------
    InputError
        If the file does not exist, or does not have these columns.
    """
    if isinstance(nodes, (str, Path)):
        path = Path(nodes)
        if path.suffix.lower() in TABLES:
            return from_table(_table(path), path.name)
        from jousto.mesh.readers.files import read_mesh

        nodes = read_mesh(path, unit=unit)
    if hasattr(nodes, "node_ids") and hasattr(nodes, "cells"):
        return from_mesh(nodes)
    return from_table(nodes, "nodes")


def from_table(table: Any, name: str) -> Positions:
    """Return the positions of an array (nn, 3) or (nn, 4)."""
    problems = Problems()
    columns = 4 if np.ndim(table) == 2 and np.shape(table)[1] == 4 else 3
    array = problems.array("nodes", name, table, (None, columns))
    problems.raise_if_any()
    assert array is not None
    if columns == 3:
        return Positions(None, array)
    ids = array[:, 0].astype(np.int64)
    if np.any(ids != array[:, 0]) or len(np.unique(ids)) < len(ids):
        message = "the first of four columns must be the node number, without duplicates"
        raise InputError(Problem(name, message))
    return Positions(ids, array[:, 1:])


def from_mesh(mesh: Any) -> Positions:
    """Return the positions, sets and outer surface of a Mesh."""
    ids = np.asarray(mesh.node_ids, dtype=np.int64)
    sets = {name: ids[np.asarray(members)] for name, members in mesh.node_sets.items()}
    return Positions(ids, np.asarray(mesh.nodes), sets, np.asarray(mesh.triangles), True)


def _table(path: Path) -> Any:
    check_input(path)
    if not path.is_file():
        raise MissingFileError(Problem("", f"no such file {str(path)!r}"))
    try:
        if path.suffix.lower() == ".npy":
            return np.load(path, allow_pickle=False)
        comma = "," in path.read_text(encoding="utf-8")
        return np.loadtxt(path, delimiter="," if comma else None, ndmin=2)
    except (ValueError, OSError, UnicodeDecodeError) as error:
        raise refuse(path, f"is no table of positions: {error}") from None
