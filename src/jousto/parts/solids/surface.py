"""Stress of free surfaces of solids from the strain of their skin, as strain gauges would tell."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jousto.parts._arrays import Floats, Ints, node_dofs, scatter
from jousto.parts.area import face_node_tangents
from jousto.parts.material import Material
from jousto.parts.orthotropic import elasticity
from jousto.parts.solids.model import VOIGT, SolidModel
from jousto.parts.solids.stress import labels
from jousto.parts.stress import StressOperator

PAIRS = ((0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2))


def surface_stress(
    model: SolidModel, faces: Sequence[Ints], materials: Sequence[Ints]
) -> StressOperator:
    """Return the stress at the nodes of outer faces on which no load acts.

    Each face knows the strain of its own plane, ``grad_t u``, at its nodes; the rest of the strain
    follows from ``s n = 0``: with ``A = n . C . n`` and the stress ``t = s n`` of the tangential
    strain alone, ``s <- s - C : (A^-1 t) n``. The mean over the faces of one material around a node
    is its stress. No value is continued from inside the body.

    Parameters
    ----------
    model : SolidModel
    faces : sequence of (nf, k) ndarray
        Outer faces by kind, normals outwards.
    materials : sequence of (nf,) ndarray
        Index of the material behind each face.
    """
    n_mat = len(model.materials)
    pairs = [np.unique(face * n_mat + m[:, None]) for face, m in zip(faces, materials, strict=True)]
    both = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *pairs]))
    node, material = both // n_mat, both % n_mat
    ns, ndof = len(both), 3 * len(model.nodes)
    count = np.zeros(ns)
    blocks, rows, columns = [], [], []
    for face, m in zip(faces, materials, strict=True):
        k = face.shape[1]
        B, normal = face_node_tangents(model.nodes, face)  # (f, k nodes, 3, k), (f, k nodes, 3)
        for index in np.unique(m):
            mine = m == index
            Q = _free_stiffness(elasticity(model.materials[index]), normal[mine])
            # strain rows from nodal displacements: (f, q, 6, k, 3)
            b = B[mine]
            L = np.zeros((*b.shape[:2], 6, k, 3))
            for c, (i, j) in enumerate(PAIRS):
                L[:, :, c, :, j] += b[:, :, i]
                if i != j:
                    L[:, :, c, :, i] += b[:, :, j]
            site = np.searchsorted(both, face[mine] * n_mat + index)
            np.add.at(count, site.ravel(), 1.0)
            operator = np.matmul(Q, L.reshape(*b.shape[:2], 6, 3 * k))
            blocks.append(operator.reshape(-1, 6, 3 * k))
            rows.append(node_dofs(site.reshape(-1, 1), 6))
            columns.append(np.repeat(node_dofs(face[mine], 3), k, axis=0))
    total = None
    for block, row, column in zip(blocks, rows, columns, strict=True):
        mean = block / count[row[:, 0] // 6][:, None, None]
        part = scatter(mean, row, column, (6 * ns, ndof))
        total = part if total is None else total + part
    constants = [(x.E, x.nu) if isinstance(x, Material) else (np.nan,) * 2 for x in model.materials]
    known = np.array(constants)[material]
    assert total is not None
    return StressOperator(
        labels(model, node, material),
        model.nodes[node],
        np.broadcast_to(np.eye(3), (ns, 3, 3)),
        total,
        None if np.any(np.isnan(known)) else known,
    )


def _free_stiffness(C: Floats, n: Floats) -> Floats:
    """Return matrices (..., 6, 6) from tangential strain to stress with ``s n = 0``."""
    # t = T s and C : (a n) = C T^T a with T (3, 6) made of the normal
    T = np.zeros((*n.shape[:-1], 3, 6))
    for i in range(3):
        for j in range(3):
            T[..., i, VOIGT[i, j]] += n[..., j]
    CT = C @ np.swapaxes(T, -1, -2)
    A = T @ CT
    return np.asarray(C - CT @ np.linalg.solve(A, T @ C))
