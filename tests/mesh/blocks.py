"""Blocks of every kind of solid, as truth for the tests of meshes."""

from __future__ import annotations

import numpy as np

import jousto as jo
from jousto.mesh.cells import base, edges, is_quadratic

# tetrahedra of a cube: Kuhn's six along the diagonal from corner 0 to corner 6, VTK's numbers
_TETRAHEDRA = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
_WEDGES = [(0, 1, 2, 4, 5, 6), (0, 2, 3, 4, 6, 7)]


def block(kind: str, divisions: tuple[int, int, int], size: tuple[float, float, float]) -> jo.Mesh:
    """A box from the origin along +x, +y, +z, of hexahedra or of hexahedra cut up."""
    nx, ny, nz = divisions
    axes = [np.linspace(0.0, s, n + 1) for s, n in zip(size, divisions, strict=True)]
    x, y, z = np.meshgrid(*axes, indexing="ij")
    nodes = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    number = np.arange(len(nodes)).reshape(nx + 1, ny + 1, nz + 1)
    corner = [
        (0, 0, 0),
        (1, 0, 0),
        (1, 1, 0),
        (0, 1, 0),
        (0, 0, 1),
        (1, 0, 1),
        (1, 1, 1),
        (0, 1, 1),
    ]
    cubes = np.stack(
        [number[i : i + nx, j : j + ny, k : k + nz].ravel() for i, j, k in corner], axis=1
    )
    cut = {"tetra": _TETRAHEDRA, "wedge": _WEDGES}.get(base(kind), [tuple(range(8))])
    cells = cubes[:, np.array(cut)].reshape(-1, len(cut[0]))
    if is_quadratic(kind):
        pairs = np.sort(cells[:, np.array(edges(kind))], axis=2)
        unique, middle = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
        cells = np.concatenate([cells, middle.reshape(len(cells), -1) + len(nodes)], axis=1)
        nodes = np.concatenate([nodes, nodes[unique].mean(axis=1)])
    return jo.Mesh(f"block of {kind}", nodes, jo.mesh.Cells(kind, cells))
