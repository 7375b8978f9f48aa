"""Writers of matrix files, as the formats' descriptions have them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import scipy.sparse as sp


def full(matrix: object) -> np.ndarray:
    return np.asarray(sp.csr_array(matrix).toarray())


def write_abaqus(path: Path, matrix: object, dofs: np.ndarray, *, lower: bool = True) -> None:
    """FORMAT=MATRIX INPUT: node, direction, node, direction, value of one triangle."""
    A = full(matrix)
    lines = []
    for i in range(len(A)):
        for j in range(i + 1 if lower else len(A)):
            if A[i, j] != 0.0:
                (n, c), (m, d) = dofs[i], dofs[j]
                lines.append(f"{n},{c}, {m},{d}, {A[i, j]:.16e}")
    path.write_text("\n".join(lines) + "\n")


def write_user_element(path: Path, dofs: np.ndarray, **matrices: object) -> None:
    """A substructure: nodes in a comment, directions, lower triangles with four numbers a line."""
    nodes = list(dict.fromkeys(int(n) for n, _ in dofs))
    lines = ["**", "** GENERATION OF SUBSTRUCTURE", f"*USER ELEMENT, NODES= {len(nodes)}, LINEAR"]
    lines += ["** ELEMENT NODES", "** " + ", ".join(str(n) for n in nodes)]
    for place, node in enumerate(nodes, start=1):
        mine = ", ".join(str(c) for n, c in dofs if n == node)
        lines.append(mine if place == 1 else f"{place}, {mine}")
    for kind, matrix in matrices.items():
        lines.append(f"*MATRIX,TYPE={kind.upper()}")
        A = full(matrix)
        for i in range(len(A)):
            for j in range(0, i + 1, 4):
                lines.append(" , ".join(f"{x:.16e}" for x in A[i, j : min(j + 4, i + 1)]))
    path.write_text("\n".join(lines) + "\n")


def write_harwell_boeing(path: Path, matrix: object, kind: str = "RSA") -> None:
    """The lower triangle by columns, numbers in Fortran fields that touch one another."""
    A = full(matrix)
    half = sp.csc_array(np.tril(A) if kind[1] == "S" else A)
    half.sort_indices()
    pointer, row = half.indptr + 1, half.indices + 1

    def cards(words: list[str], per_line: int) -> list[str]:
        return ["".join(words[i : i + per_line]) for i in range(0, len(words), per_line)]

    wide = len(str(max(pointer.max(), row.max())))
    blocks = [
        cards([f"{x:{wide}d}" for x in pointer], 10),
        cards([f"{x:{wide}d}" for x in row], 10),
        cards([f"{x:25.16E}".replace("E", "D") for x in half.data], 3),
    ]
    counts = [len(block) for block in blocks]
    header = [
        f"{'test matrix':<72}{'TEST':<8}",
        "".join(f"{x:14d}" for x in (sum(counts), *counts, 0)),
        f"{kind:<14}" + "".join(f"{x:14d}" for x in (len(A), len(A), len(row), 0)),
        f"{f'(10I{wide})':<16}{f'(10I{wide})':<16}{'(3D25.16)':<20}{'':<20}",
    ]
    path.write_text("\n".join([*header, *(line for block in blocks for line in block)]) + "\n")


def write_calculix(path: Path, matrix: object) -> None:
    """One triangle column by column, a line for each entry."""
    A = full(matrix)
    lines = [
        f"{i + 1} {j + 1} {A[i, j]: .13e}"
        for j in range(len(A))
        for i in range(j + 1)
        if A[i, j] != 0.0 or i == j
    ]
    path.write_text("\n".join(lines) + "\n")
