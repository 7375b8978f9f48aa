"""Meshes of boxes (and what boxes are bent into) for the tests of solids."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from jousto.mesh.cells import Cells
from jousto.mesh.mesh import Mesh
from jousto.mesh.reference import EDGES, KINDS, places

Array = NDArray[np.float64]
ALL = tuple(KINDS)
SPRUCE = {
    "E1": 11e9,
    "E2": 0.9e9,
    "E3": 0.5e9,
    "nu12": 0.37,
    "nu13": 0.42,
    "nu23": 0.47,
    "G12": 0.75e9,
    "G13": 0.72e9,
    "G23": 0.04e9,
    "rho": 450.0,
}
"""Constants of an orthotropic material, Pa and kg/m^3."""
# six tetrahedra around a diagonal of the cube, two wedges
_TETS = [
    *([0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6]),
    *([0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]),
]
_WEDGES = [[0, 1, 3, 4, 5, 7], [1, 2, 3, 5, 6, 7]]


def grid(
    kind: str,
    counts: Sequence[int],
    size: Sequence[float] = (1.0, 1.0, 1.0),
    *,
    distort: float = 0.0,
    bend: Callable[[Array], Array] | None = None,
    materials: Callable[[Array], NDArray[np.str_]] | None = None,
) -> Mesh:
    """A box of elements of one kind; inner nodes are moved by up to ``distort`` of their cell.

    ``bend`` maps positions, of mid nodes too; ``materials`` names elements by their centre.
    """
    nx, ny, nz = counts
    axes = [np.linspace(0.0, 1.0, n + 1) for n in counts]
    x = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    if distort:
        inner = np.all((x > 1e-9) & (x < 1.0 - 1e-9), axis=1)
        shift = np.random.default_rng(1).uniform(-distort, distort, x.shape) / np.array(counts)
        x[inner] += shift[inner]
    i, j, k = (a.ravel() for a in np.meshgrid(range(nx), range(ny), range(nz), indexing="ij"))
    corner = np.array(places("hexahedron"), dtype=np.int64)
    cells = ((i[:, None] + corner[:, 0]) * (ny + 1) + j[:, None] + corner[:, 1]) * (nz + 1)
    cells = cells + k[:, None] + corner[:, 2]
    if kind.startswith("tetra"):
        cells = cells[:, _TETS].reshape(-1, 4)
    elif kind.startswith("wedge"):
        cells = cells[:, _WEDGES].reshape(-1, 6)
    if kind in EDGES:
        pairs = np.sort(cells[:, EDGES[kind]], axis=2)
        unique, number = np.unique(pairs.reshape(-1, 2), axis=0, return_inverse=True)
        cells = np.concatenate([cells, len(x) + number.reshape(len(cells), -1)], axis=1)
        x = np.concatenate([x, x[unique].mean(axis=1)])
    x = x * np.asarray(size)
    if bend is not None:
        x = bend(x)
    sets = {}
    if materials is not None:
        label = materials(x[cells].mean(axis=1))
        sets = {str(name): np.flatnonzero(label == name) for name in np.unique(label)}
    return Mesh("box", x, Cells(kind, cells), element_sets=sets)
