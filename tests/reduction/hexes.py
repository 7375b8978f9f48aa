"""Hand-made boxes of 8-node hexahedra for the tests of this folder."""

from __future__ import annotations

import itertools
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.parts.part import Part

Array = NDArray[np.float64]

CORNERS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1),
                    (0, 1, 1)])  # fmt: skip


def element(h: Array, E: float, nu: float, rho: float) -> tuple[Array, Array]:
    """Stiffness (24, 24) and consistent mass of a brick with sides h, 2 x 2 x 2 points."""
    lam, G = E * nu / ((1 + nu) * (1 - 2 * nu)), E / (2 * (1 + nu))
    H = np.diag([lam + 2 * G] * 3 + [G] * 3)
    H[:3, :3] += lam * (1 - np.eye(3))
    side = 2.0 * CORNERS - 1.0
    K, M = np.zeros((24, 24)), np.zeros((8, 8))
    dV = np.prod(h) / 8.0
    for x in itertools.product((-(3**-0.5), 3**-0.5), repeat=3):
        u = 1.0 + side * x
        N = u.prod(axis=1) / 8.0
        g = np.stack([side[:, 0] * u[:, 1] * u[:, 2], side[:, 1] * u[:, 0] * u[:, 2],
                      side[:, 2] * u[:, 0] * u[:, 1]], axis=1) / 8.0 * (2.0 / h)  # fmt: skip
        B = np.zeros((6, 8, 3))
        for a in range(3):
            B[a, :, a] = g[:, a]
        for row, (a, b) in enumerate(((0, 1), (1, 2), (0, 2)), start=3):
            B[row, :, a], B[row, :, b] = g[:, b], g[:, a]
        B = B.reshape(6, 24)
        K += B.T @ H @ B * dV
        M += rho * np.outer(N, N) * dV
    return K, np.kron(M, np.eye(3))


def box(
    size: tuple[float, float, float] = (0.4, 0.1, 0.06),
    counts: tuple[int, int, int] = (6, 3, 2),
    *,
    E: float = 210e9,
    nu: float = 0.3,
    rho: float = 7850.0,
    **options: Any,
) -> Part:
    """A box along x from the origin, its cross section about the x axis.

    Sets: "left" and "right" (x = 0 and x = length); `faces` are the outer quadrangles.
    """
    nx, ny, nz = (n + 1 for n in counts)
    grid = np.meshgrid(*(np.linspace(0, s, n) for s, n in zip(size, (nx, ny, nz), strict=True)),
                       indexing="ij")  # fmt: skip
    nodes = np.stack([g.ravel() for g in grid], axis=1) - [0, size[1] / 2, size[2] / 2]

    def number(i: Any, j: Any, k: Any) -> Any:
        return (i * ny + j) * nz + k

    i, j, k = (g.ravel() for g in np.meshgrid(*map(np.arange, counts), indexing="ij"))
    hexes = np.stack([number(i + a, j + b, k + c) for a, b, c in CORNERS], axis=1)
    Ke, Me = element(np.array(size) / counts, E, nu, rho)
    dofs = (3 * hexes[:, :, None] + np.arange(3)).reshape(len(hexes), 24)
    rows, columns = np.repeat(dofs, 24, axis=1).ravel(), np.tile(dofs, (1, 24)).ravel()
    n = 3 * len(nodes)
    K, M = (
        sp.csr_array((np.tile(e.ravel(), len(hexes)), (rows, columns)), shape=(n, n))
        for e in (Ke, Me)
    )
    part = Part.from_matrices(
        M, K, nodes,
        node_sets={
            "left": np.flatnonzero(nodes[:, 0] == 0.0),
            "right": np.flatnonzero(nodes[:, 0] == nodes[:, 0].max()),
        },
        elements=hexes, name="box",
    )  # fmt: skip
    return replace(part, faces=(outer(hexes),), **options)


def outer(hexes: NDArray[np.int64]) -> NDArray[np.int64]:
    """The quadrangles that belong to one hexahedron only."""
    sides = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (2, 3, 7, 6), (1, 2, 6, 5), (0, 4, 7, 3)]
    faces = np.concatenate([hexes[:, list(s)] for s in sides])
    _, first, times = np.unique(np.sort(faces, axis=1), axis=0, return_index=True,
                                return_counts=True)  # fmt: skip
    return faces[first[times == 1]]
