"""Integrals over surface faces: how an even traction is shared among the nodes of a surface."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.parts._arrays import Floats, Ints, Sparse, as_csr

_a, _b = 0.445948490915965, 0.091576213509771
_TRIANGLE = np.array(
    [[_a, _a], [1 - 2 * _a, _a], [_a, 1 - 2 * _a], [_b, _b], [1 - 2 * _b, _b], [_b, 1 - 2 * _b]]
)
_TRIANGLE_WEIGHTS = 0.5 * np.repeat([0.223381589678011, 0.109951743655322], 3)
"""Six points, exact to the fourth degree (Cowper, Int. J. Num. Meth. Eng. 7 (1973) 405)."""

_g, _w = np.polynomial.legendre.leggauss(3)
_SQUARE = np.array([[x, y] for x in _g for y in _g])
_SQUARE_WEIGHTS = np.array([u * v for u in _w for v in _w])

KINDS = {3: "triangles", 4: "quadrangles", 6: "triangles with mid-side nodes", 8: "quadrangles "
         "with mid-side nodes"}  # fmt: skip


def _triangle(x: Floats) -> tuple[Floats, Floats]:
    r, s = x.T
    L = np.stack([1.0 - r - s, r, s], axis=1)
    dL = np.broadcast_to([[-1.0, -1.0], [1.0, 0.0], [0.0, 1.0]], (len(x), 3, 2))
    return L, np.array(dL)


def _triangle6(x: Floats) -> tuple[Floats, Floats]:
    L, dL = _triangle(x)
    i, j = np.array([0, 1, 2]), np.array([1, 2, 0])
    N = np.concatenate([L * (2.0 * L - 1.0), 4.0 * L[:, i] * L[:, j]], axis=1)
    corner = (4.0 * L - 1.0)[:, :, None] * dL
    middle = 4.0 * (L[:, i, None] * dL[:, j] + L[:, j, None] * dL[:, i])
    return N, np.concatenate([corner, middle], axis=1)


_CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def _square(x: Floats) -> tuple[Floats, Floats]:
    u = 1.0 + x[:, None, :] * _CORNERS
    N = 0.25 * u[:, :, 0] * u[:, :, 1]
    return N, 0.25 * _CORNERS * u[:, :, ::-1]


def _square8(x: Floats) -> tuple[Floats, Floats]:
    u = 1.0 + x[:, None, :] * _CORNERS
    lean = (x[:, None, :] * _CORNERS).sum(axis=2) - 1.0
    N = [0.25 * u[:, :, 0] * u[:, :, 1] * lean]
    d = 0.25 * _CORNERS * (u[:, :, ::-1] * lean[:, :, None] + (u[:, :, :1] * u[:, :, 1:]))
    dN = [d]
    for side, (a, b) in enumerate(((0, 1), (1, 0), (0, 1), (1, 0))):
        sign = (-1.0, 1.0, 1.0, -1.0)[side]
        across = 1.0 + sign * x[:, b]
        N.append((0.5 * (1.0 - x[:, a] ** 2) * across)[:, None])
        g = np.empty((len(x), 1, 2))
        g[:, 0, a] = -x[:, a] * across
        g[:, 0, b] = 0.5 * sign * (1.0 - x[:, a] ** 2)
        dN.append(g)
    return np.concatenate(N, axis=1), np.concatenate(dN, axis=1)


_SHAPES = {
    3: (_triangle, _TRIANGLE, _TRIANGLE_WEIGHTS),
    6: (_triangle6, _TRIANGLE, _TRIANGLE_WEIGHTS),
    4: (_square, _SQUARE, _SQUARE_WEIGHTS),
    8: (_square8, _SQUARE, _SQUARE_WEIGHTS),
}


def by_kind(rows: Ints, used: NDArray[np.bool_]) -> tuple[Ints, ...]:
    """Return faces in rows that are filled up behind as one array for each number of nodes.

    Faces of a node that is not there (negative) are left out.

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


def area_matrix(nodes: Floats, faces: Sequence[Ints]) -> Sparse:
    """Return ``int N N^T dA`` over faces, (nn, nn) in m2.

    Nodal forces ``area_matrix @ t`` are those of the traction with nodal values t; row sums are the
    share of each node in an even traction (zero at the corners of quadratic triangles).

    Parameters
    ----------
    nodes : (nn, 3) ndarray
        Positions in m.
    faces : sequence of (nf, k) ndarray
        Node indices with k = 3, 4, 6 or 8, corners first, then the middles of the sides.
    """
    nn = len(nodes)
    total: Sparse = sp.csr_array((nn, nn))
    for group in faces:
        if not len(group):
            continue
        shape, points, weights = _SHAPES[group.shape[1]]
        N, dN = shape(points)
        tangents = np.einsum("qkc,fkx->fqcx", dN, nodes[group])
        dA = np.linalg.norm(np.cross(tangents[:, :, 0], tangents[:, :, 1]), axis=2) * weights
        blocks = np.einsum("fq,qi,qj->fij", dA, N, N)
        rows = np.broadcast_to(group[:, :, None], blocks.shape).ravel()
        columns = np.broadcast_to(group[:, None, :], blocks.shape).ravel()
        total = total + as_csr(sp.coo_array((blocks.ravel(), (rows, columns)), shape=(nn, nn)))
    return as_csr(total)


def face_points(nodes: Floats, faces: Ints) -> tuple[Floats, Floats, Floats]:
    """Return shape functions, areas and positions at the points of faces of one kind.

    Returns
    -------
    N : (nq, k) ndarray
        Shape functions of the faces' nodes.
    area : (nf, nq, 3) ndarray
        Weighted area times the unit normal in m2; outwards for outer faces of a mesh.
    x : (nf, nq, 3) ndarray
        Positions in m.
    """
    shape, points, weights = _SHAPES[faces.shape[1]]
    N, dN = shape(points)
    tangents = np.einsum("qkc,fkx->fqcx", dN, nodes[faces])
    area = np.cross(tangents[:, :, 0], tangents[:, :, 1]) * weights[:, None]
    return N, area, np.einsum("qk,fkx->fqx", N, nodes[faces])


_PLACES = {
    "triangle": np.array([[0.0, 0.0], [1, 0], [0, 1], [0.5, 0], [0.5, 0.5], [0, 0.5]]),
    "square": np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1], [0, -1], [1, 0], [0, 1], [-1, 0]]),
}


def node_normals(nodes: Floats, faces: Sequence[Ints]) -> Floats:
    """Return unit normals (nn, 3) at the nodes of faces, weighed by area; zero elsewhere."""
    total = np.zeros(nodes.shape)
    for group in faces:
        if not len(group):
            continue
        k = group.shape[1]
        places = _PLACES["triangle" if k in (3, 6) else "square"][:k]
        tangents = np.einsum("qkc,fkx->fqcx", _SHAPES[k][0](places)[1], nodes[group])
        np.add.at(total, group, np.cross(tangents[:, :, 0], tangents[:, :, 1]))
    length = np.linalg.norm(total, axis=1, keepdims=True)
    return np.asarray(total / np.where(length > 0.0, length, 1.0))


def face_node_tangents(nodes: Floats, faces: Ints) -> tuple[Floats, Floats]:
    """Return derivatives along a face and its normal, at the nodes of faces of one kind.

    Returns
    -------
    B : (nf, k, 3, k) ndarray
        At node q of a face: derivatives along x, y, z within the face's plane of the shape function
        of node a, ``B[:, q, :, a]``, in 1/m.
    normal : (nf, k, 3) ndarray
        Unit normals at the nodes.
    """
    k = faces.shape[1]
    places = _PLACES["triangle" if k in (3, 6) else "square"][:k]
    dN = _SHAPES[k][0](places)[1]
    tangents = np.einsum("qkc,fkx->fqcx", dN, nodes[faces])
    across = np.cross(tangents[:, :, 0], tangents[:, :, 1])
    area = np.linalg.norm(across, axis=2, keepdims=True)
    normal = across / area
    # dual vectors in the plane: g_a . t_b = delta_ab
    dual = np.stack([np.cross(tangents[:, :, 1], normal), np.cross(normal, tangents[:, :, 0])], 2)
    return np.einsum("fqcx,qkc->fqxk", dual / area[:, :, None], dN), normal
