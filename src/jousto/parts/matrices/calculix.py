"""CalculiX: the matrices of ``*FREQUENCY, SOLVER=MATRIXSTORAGE``.

JOB.sti and JOB.mas contain one triangle of the matrix with a line ``i j value`` for each entry.
JOB.dof contains the node and the direction of each row as ``node.direction``.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from jousto.base.arrays import Ints, Sparse
from jousto.parts.matrices.text import from_triplets, read_numbers, read_text, refuse


def read_dofs(path: Path) -> Ints:
    """Return node and direction (ndof, 2) of each row from a .dof file."""
    dofs = []
    for number, line in enumerate(read_text(path).splitlines()):
        node, dot, direction = line.strip().partition(".")
        if not line.strip():
            continue
        if not (dot and node.isdigit() and direction in "123456" and direction):
            raise refuse(
                path,
                f"line {number + 1} is {line.strip()[:40]!r}, node.direction such as 17.3 is"
                " expected",
            )
        dofs.append((int(node), int(direction)))
    return np.array(dofs, dtype=np.int64)


def read_triangle(path: Path, n: int) -> Sparse:
    """Return the full matrix of a .sti or .mas file for n rows."""
    entries = read_numbers(path, read_text(path), 3, "i j value")
    index = entries[:, :2].astype(np.int64)
    if np.any(index != entries[:, :2]) or index.min() < 1:
        raise refuse(
            path, "has row numbers that are not whole numbers from 1, so it is no matrix file"
        )
    last = int(index.max())
    if last != n:
        reason = "the file is truncated, or the files are of different runs"
        raise refuse(path, f"has {last} rows but the .dof file has {n}: {reason}")
    return from_triplets(path, index[:, 0] - 1, index[:, 1] - 1, entries[:, 2], n)
