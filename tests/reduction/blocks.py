"""Structured blocks of 8-node hexahedra: large matrices in a moment, without a mesh."""

from __future__ import annotations

import numpy as np
import scipy.sparse as sp

from jousto.parts.part import Part

E_STEEL, NU, RHO = 2.1e11, 0.3, 7850.0
CORNERS = np.array(
    [[-1, -1, -1], [1, -1, -1], [1, 1, -1], [-1, 1, -1],
     [-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float)  # fmt: skip


def element(h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness (24, 24) and mass (24, 24) of a box with edges h, 2 x 2 x 2 Gauss points."""
    lam, G = E_STEEL * NU / ((1 + NU) * (1 - 2 * NU)), E_STEEL / (2 * (1 + NU))
    H = np.diag([2 * G] * 3 + [G] * 3)
    H[:3, :3] += lam
    k, m = np.zeros((24, 24)), np.zeros((8, 8))
    for point in CORNERS / np.sqrt(3.0):
        factors = 0.5 * (1.0 + CORNERS * point)
        N = factors.prod(axis=1)
        d = np.stack([CORNERS[:, a] * np.delete(factors, a, 1).prod(axis=1) for a in range(3)])
        d /= h[:, None]
        B = np.zeros((6, 24))
        for a, (b, c) in enumerate(((0, 1), (1, 2), (0, 2))):
            B[a, a::3] = d[a]
            B[3 + a, b::3], B[3 + a, c::3] = d[c], d[b]
        k += h.prod() / 8.0 * B.T @ H @ B
        m += h.prod() / 8.0 * RHO * np.outer(N, N)
    return k, np.kron(m, np.eye(3))


def block(cells: tuple[int, int, int], size: tuple[float, float, float] = (1.0, 0.1, 0.07)) -> Part:
    """A box of steel along x, with the node sets of its two ends, "left" and "right"."""
    n = np.array(cells)
    h = np.array(size) / n
    grid = np.stack(np.meshgrid(*(np.arange(k + 1) for k in n), indexing="ij"), axis=-1)
    number = np.arange(grid[..., 0].size).reshape(grid.shape[:3])
    corner = ((CORNERS + 1) / 2).astype(int)
    elements = np.stack(
        [number[a : n[0] + a, b : n[1] + b, c : n[2] + c].ravel() for a, b, c in corner], axis=1
    )
    nodes = grid.reshape(-1, 3) * h
    dofs = (3 * elements[:, :, None] + np.arange(3)).reshape(len(elements), 24)

    def assembled(e: np.ndarray) -> sp.csr_array:
        rows, columns = np.repeat(dofs, 24, axis=1), np.tile(dofs, (1, 24))
        values = np.tile(e.ravel(), len(dofs))
        shape = (3 * len(nodes), 3 * len(nodes))
        return sp.coo_array((values, (rows.ravel(), columns.ravel())), shape=shape).tocsr()

    k, m = element(h)
    left, right = np.flatnonzero(grid[..., 0] == 0), np.flatnonzero(grid[..., 0] == n[0])
    return Part(
        name="block",
        nodes=nodes,
        elements=elements,
        dofs_per_node=3,
        M=assembled(m),
        K=assembled(k),
        node_sets={"left": tuple(left), "right": tuple(right)},
    )
