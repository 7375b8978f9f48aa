"""Solid parts of the verification, and their natural frequencies under any supports."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import eigsh, spsolve

import jousto as jo
from verification.boxes import Grid


def solid(grid: Grid, material: Any, sets: dict[str, Any] | None = None) -> jo.Part:
    """Return a part of this grid."""
    return jo.Part.solid(mesh(grid, sets), material)


def mesh(grid: Grid, sets: dict[str, Any] | None = None) -> jo.Mesh:
    """Return the grid as a mesh with node sets."""
    cells = [jo.mesh.Cells(c.kind, c.nodes) for c in grid.cells]
    return jo.Mesh("grid", grid.nodes, cells, node_sets=sets or {})


def dofs(nodes: Any, directions: str = "xyz") -> np.ndarray:
    """Return the degrees of freedom of nodes in some directions."""
    axes = np.array(["xyz".index(d) for d in directions])
    return (3 * np.asarray(nodes)[:, None] + axes).ravel()


def supported(
    part: jo.Part, held: Any, number: int, *, shift: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest frequencies in Hz and mass-normalised modes (ndof, number).

    A shift below zero (1/s2) is needed where the supports let the body move; the frequency of such
    a motion comes out as near zero.
    """
    ndof = part.K.shape[0]
    free = np.setdiff1d(np.arange(ndof), held)
    K, M = (sp.csc_array(A)[free][:, free] for A in (part.K, part.M))
    start = np.random.default_rng(0).standard_normal(len(free))
    square, shapes = eigsh(K, number, M, sigma=shift, v0=start)
    order = np.argsort(square)
    modes = np.zeros((ndof, number))
    modes[free] = shapes[:, order]
    return np.sqrt(np.maximum(square[order], 0.0)) / (2.0 * np.pi), modes


def like(modes: np.ndarray, M: Any, shape: np.ndarray) -> np.ndarray:
    """Return how much each mass-normalised mode is like a shape, 0 to 1 (squared cosine)."""
    w = M @ shape
    return (modes.T @ w) ** 2 / (shape @ w)


def at_rest(part: jo.Part, held: Any, load: np.ndarray) -> np.ndarray:
    """Return the static displacements (ndof,) under a load (ndof,)."""
    ndof = part.K.shape[0]
    free = np.setdiff1d(np.arange(ndof), held)
    d = np.zeros(ndof)
    d[free] = spsolve(sp.csc_array(part.K)[free][:, free], load[free])
    return d
