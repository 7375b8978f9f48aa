"""Stress jumps between elements as quadratic forms in the amplitudes of many shapes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import lapack

from jousto.base.arrays import Array, Ints
from jousto.materials.orthotropic import elasticity
from jousto.mesh.reference import table
from jousto.parts.solids.stress import SolidStress, continuation, point_strains

ROWS = 6
"""Number of eigenvectors stored per site; the remaining ones contribute little."""

BLOCK_BYTES = 64 << 20
"""Memory of the element stresses at the sites of a block, bytes."""

DIVIDED = 25
"""Largest matrix for which LAPACK's ``syevd`` iterates by QR. Larger ones are divided, which starts
threads for each matrix: with two threads it takes up to seventy times as long."""

CELLS = 10
"""Binary digits of the cell of a position along each axis, for an order of neighbours."""

# the von Mises stress of a tensor is the length of these five numbers
MISES = np.array(
    [
        [np.sqrt(0.75), -np.sqrt(0.75), 0, 0, 0, 0],
        [-0.5, -0.5, 1.0, 0, 0, 0],
        [0, 0, 0, np.sqrt(3.0), 0, 0],
        [0, 0, 0, 0, np.sqrt(3.0), 0],
        [0, 0, 0, 0, 0, np.sqrt(3.0)],
    ]
)


@dataclass(frozen=True, eq=False)
class _Corners:
    """Nodes of the elements of a group at sites, by the rank of the site in the order of blocks.

    Parameters
    ----------
    rank : (m,) ndarray of int
        Rank of the site, ascending.
    element, node : (m,) ndarray of int
        Element of the group, and number of the node in the element.
    """

    rank: Ints
    element: Ints
    node: Ints


def place_scatter(stress: SolidStress, X: Array, s: Array, size: Array) -> Array:
    """Return E (ns, r, n) with which ``|E p|`` is the estimated stress error of ``X p``.

    The error is that of `place_errors`, the root mean square of the von Mises stress of ``s_e -
    s*`` over the elements around a site, ``p^T Q p`` with ``Q = sum A_e^T A_e / count``; E contains
    the r largest eigenvalues of Q, for shapes scaled by `size`.

    Parameters
    ----------
    stress : SolidStress
    X : (ndof, n) ndarray
        Displacements of the shapes, m.
    s : (ns, 6, n) ndarray
        Stress of the shapes, ``stress.evaluate(X)``.
    size : (n,) ndarray
        Typical relative amplitudes of the shapes.
    """
    ns, n = len(stress), X.shape[1]
    # single precision is sufficient for an estimate, and makes files smaller
    found = np.zeros((ns, min(ROWS, n), n), dtype=np.float32)
    # neighbours in one block share elements
    order = neighbours_together(stress.positions)
    corners = _corners(stress, order)
    count = np.sum([np.bincount(c.rank, minlength=ns) for c in corners], axis=0)
    ends = np.cumsum(count)
    step = max(1, BLOCK_BYTES // _bytes_per_corner(stress, corners, n))
    start = 0
    while start < ns:
        done = ends[start - 1] if start else 0
        stop = max(start + 1, int(np.searchsorted(ends, done + step, side="right")))
        sites = order[start:stop]
        A = _differences(stress, corners, X, MISES @ s[sites], start)
        found[sites] = _largest(A, count[start:stop], size)
        start = stop
    return found.astype(np.float64)


def neighbours_together(points: Array) -> Ints:
    """Return an order of points (n, 3) in which neighbours are close to each other.

    The points are sorted by cell of a grid, whose coordinates are interlaced digit by digit (G. M.
    Morton, *A computer oriented geodetic data base*, IBM 1966).
    """
    low = points.min(axis=0)
    extent = float(np.max(points.max(axis=0) - low))
    scale = (2**CELLS - 1) / extent if extent > 0.0 else 0.0
    cells = (scale * (points - low)).astype(np.int64)
    code = np.zeros(len(points), dtype=np.int64)
    for digit in range(CELLS):
        for axis in range(3):
            code |= ((cells[:, axis] >> digit) & 1) << (3 * digit + axis)
    return np.argsort(code, kind="stable")


def _corners(stress: SolidStress, order: Ints) -> list[_Corners]:
    """Return the nodes at sites of each group of elements."""
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    found = []
    for group in stress.model.groups:
        at = stress.numbers[group.material][group.nodes]
        element, node = np.nonzero(at >= 0)
        place = rank[at[element, node]]
        sort = np.argsort(place, kind="stable")
        found.append(_Corners(place[sort], element[sort], node[sort]))
    return found


def _bytes_per_corner(stress: SolidStress, corners: list[_Corners], n: int) -> int:
    """Return the mean memory of n shapes per node of an element at a site."""
    total, number = 0, 1
    for group, own in zip(stress.model.groups, corners, strict=True):
        nq = len(table(group.kind, "stress", group.formulation).weights)
        # strain and stress at the points of each element, stress at its nodes; two copies of rows
        total += len(np.unique(own.element)) * (11 * nq + 5 * group.nodes.shape[1])
        total += 10 * len(own.rank)
        number += len(own.rank)
    return max(1, 8 * n * total // number)


def _differences(
    stress: SolidStress, corners: list[_Corners], X: Array, mean: Array, start: int
) -> Array:
    """Return ``s_e - s*`` (m, 5, n) of the elements around sites, site by site, as `MISES` numbers.

    Parameters
    ----------
    stress, corners, X
        See `place_scatter`.
    mean : (k, 5, n) ndarray
        The numbers of s* at the sites of ranks ``start`` to ``start + k - 1``.
    """
    n, model = X.shape[1], stress.model
    at, rows = [], []
    for group, all_ in zip(model.groups, corners, strict=True):
        some = slice(*np.searchsorted(all_.rank, [start, start + len(mean)]))
        elements, which = np.unique(all_.element[some], return_inverse=True)
        nq = len(table(group.kind, "stress", group.formulation).weights)
        strains = np.empty((len(elements) * nq, 6, n))
        point_strains(model, group, elements, X, strains)
        # five numbers at the points of the elements, and at their nodes
        law = MISES @ elasticity(model.materials[group.material])
        own = np.matmul(law, strains).reshape(len(elements), -1, 5 * n)
        own = np.matmul(continuation(group.kind, group.formulation), own)
        place = all_.rank[some] - start
        at.append(place)
        rows.append(own[which, all_.node[some]].reshape(-1, 5, n) - mean[place])
    if len(rows) == 1:
        return np.asarray(rows[0])
    return np.concatenate(rows)[np.argsort(np.concatenate(at), kind="stable")]


def _largest(A: Array, count: Ints, size: Array) -> Array:
    """Return E (m, r, n) of m sites from the differences of all their elements, site by site.

    With ``B = A diag(size) / sqrt(count)``, the rows of E are ``sqrt(mu) v^T / size``, where v are
    the eigenvectors of ``B^T B``, or ``u^T B / size`` with the eigenvectors u of ``B B^T``,
    whichever matrix is smaller.
    """
    n = A.shape[2]
    out = np.zeros((len(count), min(ROWS, n), n))
    first = np.cumsum(count) - count
    for k in np.unique(count[count > 0]):
        # sites with the same number of elements at once
        mine = np.flatnonzero(count == k)
        B = A[first[mine][:, None] + np.arange(k)].reshape(len(mine), 5 * k, n)
        B *= size / np.sqrt(k)
        if 5 * k < n:
            _, u = _eigenvectors(B @ np.swapaxes(B, 1, 2))
            rows = np.swapaxes(u, 1, 2) @ B
        else:
            mu, v = _eigenvectors(np.swapaxes(B, 1, 2) @ B)
            rows = np.sqrt(np.maximum(mu, 0.0))[:, :, None] * np.swapaxes(v, 1, 2)
        out[mine, : rows.shape[1]] = rows / size
    return out


def _eigenvectors(G: Array) -> tuple[Array, Array]:
    """Return the r largest eigenvalues (m, r), descending, of matrices (m, d, d), and vectors."""
    m, d = G.shape[:2]
    r = min(ROWS, d)
    if d <= DIVIDED:
        mu, V = np.linalg.eigh(G)
    else:
        mu, V = np.empty((m, r)), np.empty((m, d, r))
        for i, matrix in enumerate(G):
            mu[i], V[i] = _last(matrix, r)
    # ascending in LAPACK
    return mu[:, : -r - 1 : -1], V[:, :, : -r - 1 : -1]


def _last(G: Array, r: int) -> tuple[Array, Array]:
    """Return the r largest eigenvalues (r,), ascending, of a matrix (d, d), and vectors (d, r)."""
    d = len(G)
    mu, V, _, _, failed = lapack.dsyevr(G, range="I", il=d - r + 1, iu=d, lower=1)
    if failed:
        mu, V = np.linalg.eigh(G)
        return mu[-r:], V[:, -r:]
    return mu[:r], V
