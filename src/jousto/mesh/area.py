"""Integrals over surface faces: distribution of a constant traction over the nodes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array, Ints, Sparse, as_csr
from jousto.mesh.reference import Table, face_table

KINDS = {3: "triangles", 4: "quadrangles", 6: "triangles with mid-side nodes", 8: "quadrangles "
         "with mid-side nodes"}  # fmt: skip


def by_kind(rows: Ints, used: NDArray[np.bool_]) -> tuple[Ints, ...]:
    """Return faces in padded rows as one array per number of nodes.

    Faces with a missing node (negative index) are left out.

    Examples
    --------
    >>> rows = np.array([[0, 1, 2, 3], [3, 2, 4, -1], [5, 3, -1, -1]])
    >>> [group.tolist() for group in by_kind(rows, rows >= 0)]
    [[[3, 2, 4]], [[0, 1, 2, 3]]]
    """
    count = used.sum(axis=1)
    whole = np.all((rows >= 0) | ~used, axis=1)
    groups = (rows[whole & (count == k), :k] for k in KINDS)
    return tuple(group for group in groups if len(group))


def area_matrix(nodes: Array, faces: Sequence[Ints]) -> Sparse:
    """Return the matrix ``int N N^T dA`` over faces, (nn, nn) in m2.

    ``area_matrix @ t`` are the nodal forces of a traction with nodal values t. The row sums are the
    shares of the nodes in a constant traction (zero at the corners of quadratic triangles).

    Parameters
    ----------
    nodes : (nn, 3) ndarray
        Positions in m.
    faces : sequence of (nf, k) ndarray
        Node indices with k = 3, 4, 6 or 8, corners first, then mid-side nodes.
    """
    nn = len(nodes)
    total: Sparse = sp.csr_array((nn, nn))
    for group in faces:
        if not len(group):
            continue
        t = face_table(group.shape[1])
        dA = np.linalg.norm(_across(t, nodes[group])[1], axis=2) * t.weights
        blocks = np.einsum("fq,qi,qj->fij", dA, t.N, t.N)
        rows = np.broadcast_to(group[:, :, None], blocks.shape).ravel()
        columns = np.broadcast_to(group[:, None, :], blocks.shape).ravel()
        total = total + as_csr(sp.coo_array((blocks.ravel(), (rows, columns)), shape=(nn, nn)))
    return as_csr(total)


def face_points(nodes: Array, faces: Ints) -> tuple[Array, Array, Array]:
    """Return shape functions, areas and positions at the quadrature points of faces of one kind.

    Returns
    -------
    N : (nq, k) ndarray
        Shape functions of the faces' nodes.
    area : (nf, nq, 3) ndarray
        Weighted area times the unit normal in m2; outwards for outer faces of a mesh.
    x : (nf, nq, 3) ndarray
        Positions in m.
    """
    t = face_table(faces.shape[1])
    area = _across(t, nodes[faces])[1] * t.weights[:, None]
    return t.N, area, np.einsum("qk,fkx->fqx", t.N, nodes[faces])


def node_normals(nodes: Array, faces: Sequence[Ints]) -> Array:
    """Return unit normals (nn, 3) at the nodes of faces, weighted by area; zero elsewhere."""
    total = np.zeros(nodes.shape)
    for group in faces:
        if not len(group):
            continue
        across = _across(face_table(group.shape[1], at_nodes=True), nodes[group])[1]
        np.add.at(total, group, across)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(total / np.where(length > 0.0, length, 1.0))


def face_node_tangents(nodes: Array, faces: Ints) -> tuple[Array, Array]:
    """Return derivatives along a face and its normal, at the nodes of faces of one kind.

    Returns
    -------
    B : (nf, k, 3, k) ndarray
        At node q of a face: derivatives along x, y, z within the face's plane of the shape function
        of node a, ``B[:, q, :, a]``, in 1/m.
    normal : (nf, k, 3) ndarray
        Unit normals at the nodes.
    """
    t = face_table(faces.shape[1], at_nodes=True)
    tangents, across = _across(t, nodes[faces])
    area = np.linalg.norm(across, axis=2, keepdims=True)
    normal = across / area
    # dual vectors in the plane: g_a . t_b = delta_ab
    dual = np.stack([np.cross(tangents[:, :, 1], normal), np.cross(normal, tangents[:, :, 0])], 2)
    return np.einsum("fqcx,qck->fqxk", dual / area[:, :, None], t.dN), normal


def _across(t: Table, x: Array) -> tuple[Array, Array]:
    """Return tangents (nf, nq, 2, 3) of faces with nodes x (nf, k, 3), and their cross products."""
    tangents = np.einsum("qck,fkx->fqcx", t.dN, x)
    return tangents, np.cross(tangents[:, :, 0], tangents[:, :, 1])
