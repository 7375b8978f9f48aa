"""Structured meshes of every solid kind: a block, and whatever it is bent into.

Node order is that of VTK, which is that of Abaqus and CalculiX for these kinds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

LINEAR = {"tetra": 4, "wedge": 6, "hexahedron": 8}
QUADRATIC = {"tetra10": "tetra", "wedge15": "wedge", "hexahedron20": "hexahedron"}
KINDS = ("tetra", "tetra10", "wedge", "wedge15", "hexahedron", "hexahedron20")

EDGES = {  # corners whose middles follow the corners, in this order
    "tetra": ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3)),
    "wedge": ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)),
    "hexahedron": tuple((i, (i + 1) % 4) for i in range(4))
    + tuple((4 + i, 4 + (i + 1) % 4) for i in range(4))
    + tuple((i, i + 4) for i in range(4)),
}
PIECES = {  # how a hexahedron is cut; neighbours fit one another
    "tetra": (
        (0, 1, 2, 6),
        (0, 2, 3, 6),
        (0, 3, 7, 6),
        (0, 7, 4, 6),
        (0, 4, 5, 6),
        (0, 5, 1, 6),
    ),
    "wedge": ((0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)),
    "hexahedron": (tuple(range(8)),),
}


@dataclass(frozen=True)
class Cells:
    """Elements of one kind: (ne, k) node indices from 0."""

    kind: str
    nodes: np.ndarray


@dataclass(frozen=True)
class Grid:
    """Nodes (nn, 3) in m and the cells on them."""

    nodes: np.ndarray
    cells: tuple[Cells, ...]

    def where(self, test: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Return the indices of the nodes whose position (3, nn) passes the test."""
        return np.flatnonzero(test(self.nodes.T))

    def plane(self, axis: int, value: float) -> np.ndarray:
        """Return the indices of the nodes in a coordinate plane."""
        return np.flatnonzero(np.abs(self.nodes[:, axis] - value) < 1e-9 * np.ptp(self.nodes))


def block(
    kind: str,
    size: tuple[float, float, float],
    counts: tuple[int, int, int],
    *,
    bend: Callable[[np.ndarray], np.ndarray] | None = None,
    curved: bool = True,
) -> Grid:
    """Return a box from the origin to `size`, cut into `counts` hexahedra and these into `kind`.

    Parameters
    ----------
    bend : callable, optional
        Maps positions (n, 3) of the box to where they shall be; nodes that meet are made one.
    curved : bool
        Whether middle nodes are bent too, or lie in the middle of their edge.
    """
    corner = QUADRATIC.get(kind, kind)
    nx, ny, nz = counts
    axes = [np.linspace(0.0, length, n + 1) for length, n in zip(size, counts, strict=True)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    nodes = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    number = np.arange(len(nodes)).reshape(nx + 1, ny + 1, nz + 1)
    a, b = slice(None, -1), slice(1, None)
    hexahedra = np.stack(
        [
            number[i, j, k]
            for i, j, k in (
                (a, a, a),
                (b, a, a),
                (b, b, a),
                (a, b, a),
                (a, a, b),
                (b, a, b),
                (b, b, b),
                (a, b, b),
            )
        ],
        axis=-1,
    ).reshape(-1, 8)
    cells = hexahedra[:, np.array(PIECES[corner])].reshape(-1, LINEAR[corner])
    if bend is not None and not curved:
        nodes = bend(nodes)
    if kind in QUADRATIC:
        nodes, cells = with_middles(nodes, cells, corner)
    if bend is not None:
        nodes, cells = weld(bend(nodes) if curved else nodes, cells)
    return Grid(nodes, (Cells(kind, cells),))


def with_middles(
    nodes: np.ndarray, cells: np.ndarray, corner: str
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and cells with a node in the middle of every edge."""
    edges = np.sort(cells[:, np.array(EDGES[corner])].reshape(-1, 2), axis=1)
    unique, place = np.unique(edges, axis=0, return_inverse=True)
    middles = len(nodes) + place.reshape(len(cells), -1)
    return np.vstack([nodes, nodes[unique].mean(axis=1)]), np.hstack([cells, middles])


def weld(nodes: np.ndarray, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and cells with coinciding nodes made one."""
    digits = np.round(nodes / (1e-9 * np.ptp(nodes))).astype(np.int64)
    _, first, place = np.unique(digits, axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)  # keep the numbering as it was
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return nodes[first[order]], rank[place.reshape(-1)][cells]


def ring(kind: str, radii: tuple[float, float], width: float, counts: tuple[int, int, int]) -> Grid:
    """Return a full ring about z from z = 0; counts: radial, around, along z."""
    inner, outer = radii

    def bend(x: np.ndarray) -> np.ndarray:
        r, phi = inner + x[:, 0], x[:, 1]
        return np.stack([r * np.cos(phi), r * np.sin(phi), x[:, 2]], axis=1)

    return block(kind, (outer - inner, 2.0 * np.pi, width), counts, bend=bend)


def rod(kind: str, radius: float, length: float, counts: tuple[int, int]) -> Grid:
    """Return a round bar along x from the origin; counts: across, along.

    The square section is bent into a disc by ``(y, z) -> (y sqrt(1 - z^2/2), z sqrt(1 - y^2/2))``.
    """
    across, along = counts

    def bend(x: np.ndarray) -> np.ndarray:
        y, z = x[:, 1] - 1.0, x[:, 2] - 1.0
        return np.stack(
            [
                x[:, 0],
                radius * y * np.sqrt(1.0 - z**2 / 2.0),
                radius * z * np.sqrt(1.0 - y**2 / 2.0),
            ],
            axis=1,
        )

    return block(kind, (length, 2.0, 2.0), (along, across, across), bend=bend)
