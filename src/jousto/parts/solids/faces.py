"""Stress at the nodes of outer faces, from the strain of the face and the traction on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Ints, Sparse, as_csr, node_dofs, scatter, times
from jousto.base.voigt import PAIRS
from jousto.materials.orthotropic import elasticity
from jousto.mesh.area import face_node_tangents
from jousto.parts.solids.model import VOIGT, SolidModel

QUADRATIC = (6, 8)
"""Numbers of nodes of faces whose own strain is more accurate than that of the element."""


@dataclass(frozen=True, eq=False)
class FaceStress:
    """Stress at sites on outer faces: ``s = D d + R s_inside``.

    Attributes
    ----------
    at : (m,) ndarray of int Indices of the sites.
    D : (6 m, ndof) sparse array
        Matrix from displacements to the stress that has their in-plane strain and no traction,
        Pa/m.
    R : (m, 6, 6) ndarray
        Matrix from a stress to the stress that has the same traction ``t = s n`` and no in-plane
        strain.
    """

    at: Ints
    D: Sparse
    R: Array

    def correct(self, s: Array, d: Array) -> None:
        """Replace stress (ns, 6, n) at the sites by stress of faces for displacements (ndof, n)."""
        tangential = times(self.D, d).reshape(len(self.at), 6, d.shape[1])
        s[self.at] = tangential + self.R @ s[self.at]


def face_stress(model: SolidModel, site: Ints, ns: int) -> FaceStress:
    """Return the stress at the sites on quadratic outer faces.

    The in-plane strain is computed from the face at its nodes, which is more accurate than the
    strain extrapolated from inside the element; the traction follows from the stress extrapolated
    from inside. The stress of a node is the mean over the faces of one material around it. Linear
    fields are reproduced exactly.

    Parameters
    ----------
    model : SolidModel
    site : (n materials, nn) ndarray of int
        Number of the site of each node in each material, -1 if there is no site.
    ns : int
        Number of sites.
    """
    count, R = np.zeros(ns), np.zeros((ns, 6, 6))
    blocks: list[tuple[Array, Ints, Ints]] = []
    for faces, behind in zip(model.faces, model.face_materials, strict=True):
        k = faces.shape[1]
        if k not in QUADRATIC:
            continue
        for m in np.unique(behind):
            mine = faces[behind == m]
            mine = mine[np.any(site[m][mine] >= 0, axis=1)]
            if not len(mine):
                continue
            D, across = face_operators(elasticity(model.materials[m]), model.nodes, mine)
            number = site[m][mine].ravel()
            kept = number >= 0
            np.add.at(count, number[kept], 1.0)
            np.add.at(R, number[kept], across.reshape(-1, 6, 6)[kept])
            columns = np.repeat(node_dofs(mine, 3), k, axis=0)
            blocks.append((D.reshape(-1, 6, 3 * k)[kept], number[kept], columns[kept]))
    at = np.flatnonzero(count)
    place = np.cumsum(count > 0) - 1
    shape = (6 * len(at), 3 * len(model.nodes))
    total: Sparse = sp.csr_array(shape)
    for block, number, columns in blocks:
        mean = block / count[number][:, None, None]
        total = total + scatter(mean, node_dofs(place[number][:, None], 6), columns, shape)
    return FaceStress(at, as_csr(total), R[at] / count[at][:, None, None])


def face_operators(C: Array, nodes: Array, faces: Ints) -> tuple[Array, Array]:
    """Return operators of the stress at the nodes of faces, from displacements and traction.

    With ``T s = s n``, ``A = T C T^T`` and the strain e of the face's plane, the stress ``s = (C -
    C T^T A^-1 T C) e + C T^T A^-1 t`` has the in-plane strain e and the traction t.

    Parameters
    ----------
    C : (6, 6) ndarray
        Elasticity in Pa.
    nodes : (nn, 3) ndarray
        Positions in m.
    faces : (nf, k) ndarray
        Outer faces of one kind.

    Returns
    -------
    D : (nf, k, 6, 3 k) ndarray
        Matrix from displacements of the nodes of the face to stress, with t = 0, Pa/m.
    R : (nf, k, 6, 6) ndarray
        Matrix from a stress with the traction t to stress, with e = 0.
    """
    k = faces.shape[1]
    B, n = face_node_tangents(nodes, faces)  # (f, k nodes, 3, k), (f, k nodes, 3)
    T = np.zeros((*n.shape[:-1], 3, 6))
    for i in range(3):
        for j in range(3):
            T[..., i, VOIGT[i, j]] += n[..., j]
    CT = C @ np.swapaxes(T, -1, -2)
    R = CT @ np.linalg.solve(T @ CT, T)
    # strain rows from nodal displacements: (f, q, 6, k, 3)
    L = np.zeros((*B.shape[:2], 6, k, 3))
    for c, (i, j) in enumerate(PAIRS):
        L[:, :, c, :, j] += B[:, :, i]
        if i != j:
            L[:, :, c, :, i] += B[:, :, j]
    D = np.matmul(C - R @ C, L.reshape(*B.shape[:2], 6, 3 * k))
    return D, R
