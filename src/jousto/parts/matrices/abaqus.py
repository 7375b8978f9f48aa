"""Abaqus: .mtx files of ``*MATRIX GENERATE`` and ``*SUBSTRUCTURE MATRIX OUTPUT``.

``FORMAT=MATRIX INPUT`` writes ``node, direction, node, direction, value``, ``FORMAT=COORDINATE``
writes ``row column value``. Substructures are written as a user element: a comment with the node
numbers, the directions of each node, and the lower triangle row by row. CalculiX writes its
substructures in the same way.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from jousto.base.arrays import Array, Ints, Sparse, as_csr
from jousto.parts.matrices.text import diagonal, from_triplets, read_numbers, read_text, refuse

HELD = 1e30
"""Stiffness of a fixed row: Abaqus writes 1e36 on the diagonal for boundary conditions."""


def is_matrix_market(path: Path) -> bool:
    """Return whether a .mtx file is a Matrix Market file."""
    with path.open("rb") as file:
        return file.read(14) == b"%%MatrixMarket"


def is_abaqus(path: Path) -> bool:
    """Return whether a .mtx file has the form of Abaqus: lines of numbers, or keywords."""
    with path.open("rb") as file:
        head = file.read(200).decode("ascii", errors="replace").strip()
    return bool(re.match(r"\*\*|\*\w|\d+[\s,]+\d+[\s,]", head))


def is_substructure(path: Path) -> bool:
    """Return whether a .mtx file contains a user element."""
    with path.open("rb") as file:
        return b"*USER ELEMENT" in file.read(20000).upper()


def read_global(path: Path) -> tuple[Sparse, Ints | None]:
    """Return the matrix of a .mtx file of ``*MATRIX GENERATE`` and the map of its rows.

    The map is None for ``FORMAT=COORDINATE``, which does not contain it.

    Raises
    ------
    InputError
        If the file is truncated, of another kind, or contains internal degrees of freedom.
    """
    text = "\n".join(
        line for line in read_text(path).splitlines() if not line.lstrip().startswith("*")
    )
    first = text.strip().partition("\n")[0].replace(",", " ").split()
    if len(first) == 3:
        entries = read_numbers(path, text, 3, "row column value")
        index = entries[:, :2].astype(np.int64) - 1
        n = int(index.max()) + 1
        return from_triplets(path, index[:, 0], index[:, 1], entries[:, 2], n), None
    if len(first) != 5:
        raise refuse(
            path,
            f"begins with {' '.join(first)[:40]!r}; Abaqus's FORMAT=MATRIX INPUT (node, direction,"
            " node, direction, value), FORMAT=COORDINATE or a Matrix Market header is expected",
        )
    entries = read_numbers(path, text, 5, "node, direction, node, direction, value")
    labels = entries[:, :4].astype(np.int64).reshape(-1, 2)
    if labels.min() < 1:
        bad = labels[np.any(labels < 1, axis=1)][0]
        raise refuse(
            path,
            f"has rows of node {bad[0]} direction {bad[1]}, which is internal to Abaqus (contact,"
            " hybrid elements, couplings): remove these features from the model, or condense the "
            "model to a substructure",
        )
    # combine node and direction to one number, which sorts quickly
    key, row = np.unique(labels[:, 0] * 64 + labels[:, 1], return_inverse=True)
    dofs, row = np.stack([key // 64, key % 64], axis=1), row.reshape(-1, 2)
    return from_triplets(path, row[:, 0], row[:, 1], entries[:, 4], len(dofs)), dofs


def take_out_held(K: Sparse, M: Sparse, dofs: Ints) -> tuple[Sparse, Sparse, Ints]:
    """Return K and M with empty rows at the boundary conditions, and the map of these rows."""
    held = np.flatnonzero(np.abs(K.diagonal()) > HELD)
    if not len(held):
        return K, M, np.zeros((0, 2), dtype=np.int64)
    free = np.ones(K.shape[0])
    free[held] = 0.0
    D = diagonal(free)
    return as_csr(D @ K @ D), as_csr(D @ M @ D), dofs[held]


def read_substructure(path: Path) -> tuple[Sparse | None, Sparse | None, Ints]:
    """Return K and M of a user element and the map of their rows.

    Raises
    ------
    InputError
        If the file is truncated or does not contain its node numbers.
    """
    text = read_text(path)
    blocks = re.split(r"^\*MATRIX\s*,\s*TYPE\s*=\s*(\w+).*$", text, flags=re.M | re.I)
    dofs = _element_dofs(path, blocks[0])
    found: dict[str, Sparse] = {}
    for kind, body in zip(blocks[1::2], blocks[2::2], strict=True):
        numbers = "\n".join(line for line in body.splitlines() if not line.startswith("*"))
        values = read_numbers(path, numbers, 1, "numbers")[:, 0]
        found[kind.upper()] = _lower_triangle(path, kind, values, len(dofs))
    return found.get("STIFFNESS"), found.get("MASS"), dofs


def _element_dofs(path: Path, header: str) -> Ints:
    lines = header.splitlines()
    start = next((i for i, line in enumerate(lines) if "ELEMENT NODES" in line.upper()), None)
    if start is None:
        raise refuse(path, "has no node numbers in a line after '** ELEMENT NODES'")
    nodes: list[int] = []
    rest = start + 1
    while rest < len(lines) and lines[rest].startswith("**"):
        nodes += [int(word) for word in re.findall(r"\d+", lines[rest])]
        rest += 1
    rows: list[tuple[int, int]] = []
    # a line of directions applies to all nodes up to the one at which the next line begins
    data = [
        [int(word) for word in re.findall(r"\d+", line)]
        for line in lines[rest:]
        if line.strip() and not line.startswith("*")
    ]
    if not data or not nodes:
        raise refuse(path, "has no line with the directions of its nodes")
    directions, following = data[0], {line[0]: line[1:] for line in data[1:]}
    for place, node in enumerate(nodes, start=1):
        directions = following.get(place, directions)
        rows += [(node, c) for c in directions]
    return np.array(rows, dtype=np.int64)


def _lower_triangle(path: Path, kind: str, values: Array, n: int) -> Sparse:
    if len(values) != n * (n + 1) // 2:
        raise refuse(
            path,
            f"has {len(values)} numbers of {kind.lower()}, {n * (n + 1) // 2} are needed for {n} "
            f"rows: the file is truncated, or the matrix is not symmetric",
        )
    full = np.zeros((n, n))
    full[np.tril_indices(n)] = values
    return as_csr(full + np.tril(full, -1).T)
