"""Elimination order of a finite element matrix: nested dissection by node positions.

The nodes are cut into two halves along their longest extent; the nodes of one half that touch the
other form the separator and are eliminated after both halves. Each half is cut in the same way,
until the pieces are small and dense. The factor of a solid of n nodes then has ``O(n^(4/3))``
nonzero numbers, the optimal order (George, SIAM J. Numer. Anal. 10 (1973) 345-363).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array, Index

LEAF = 40
"""Largest number of nodes of a piece that is not cut further: a front of about 100 unknowns."""

HUB = 10.0
"""Number of neighbours / ``sqrt(nodes)`` above which a node is eliminated last, as in approximate
minimum degree (Amestoy, Davis and Duff, SIAM J. Matrix Anal. Appl. 17 (1996) 886-905, section
4.1)."""


@dataclass(frozen=True, eq=False)
class Dissection:
    """Order of the unknowns in blocks that are eliminated one after the other.

    Parameters
    ----------
    order : (n,) array
        Unknowns in the order of their elimination.
    starts : (nb + 1,) array
        Index in `order` at which each block begins.
    parents : (nb,) array
        Index of the separator block above each block, a later block; -1 for the last block.
    """

    order: Index
    starts: Index
    parents: Index


def dissect(matrix: sp.csr_array, points: Array) -> Dissection:
    """Return the order of elimination of a matrix.

    Parameters
    ----------
    matrix : (n, n) sparse array
        Both triangles; only the pattern is used.
    points : (n, 3) array
        Position of each unknown, m. Unknowns at one position stay together.
    """
    places, owner = np.unique(points, axis=0, return_inverse=True)
    owner = owner.ravel()
    count = len(places)
    coo = matrix.tocoo()
    ones = np.ones(len(coo.data), dtype=np.float32)
    graph = sp.csr_array(sp.coo_array((ones, (owner[coo.row], owner[coo.col])), (count, count)))
    hubs = np.diff(graph.indptr) > HUB * np.sqrt(count)
    blocks: list[Index] = []
    parents: list[int] = []
    side = np.zeros(count, dtype=np.int8)

    def add(own: Index) -> int:
        blocks.append(own)
        parents.append(-1)
        return len(blocks) - 1

    def cut(nodes: Index) -> int:
        """Add the blocks of a piece and return the index of its last block."""
        if len(nodes) <= LEAF:
            return add(nodes)
        a, b, between = _halves(graph, places, nodes, side)
        halves = [cut(half) for half in (a, b) if len(half)]
        last = add(between)
        for half in halves:
            parents[half] = last
        return last

    # nodes that are connected to a large part of the body, such as nodes of ties, do not become
    # separators
    plain = np.flatnonzero(~hubs)
    below = cut(plain) if len(plain) else -1
    if hubs.any():
        last = add(np.flatnonzero(hubs))
        if below >= 0:
            parents[below] = last
    nodes = np.concatenate(blocks)
    of_place = np.argsort(owner, kind="stable")
    first = np.concatenate([[0], np.cumsum(np.bincount(owner, minlength=count))])
    sizes = np.diff(first)[nodes]
    ends = np.cumsum(sizes)
    order = of_place[np.repeat(first[nodes] - (ends - sizes), sizes) + np.arange(len(owner))]
    lengths = np.cumsum([0, *(len(block) for block in blocks)])
    return Dissection(order, np.concatenate([[0], ends])[lengths], np.array(parents, dtype=np.intp))


def _halves(
    graph: sp.csr_array, places: Array, nodes: Index, side: NDArray[np.int8]
) -> tuple[Index, Index, Index]:
    """Return two disconnected pieces and the separator nodes between them.

    Two cuts are tried: across the longest coordinate (good for grids) and across the longest axis
    of inertia (good for inclined parts). `side` must be zero for all nodes, and is reset to zero.
    """
    x = places[nodes] - places[nodes].mean(axis=0)
    longest = np.eye(3)[np.argmax(np.ptp(x, axis=0))]
    axis = np.linalg.eigh(x.T @ x)[1][:, 2]
    rows = graph[nodes]
    from_ = np.repeat(np.arange(len(nodes)), np.diff(rows.indptr))
    best: tuple[Index, Index, Index] | None = None
    for direction in (longest, axis):
        rank = np.argsort(x @ direction, kind="stable")
        first, second = nodes[rank[: len(nodes) // 2]], nodes[rank[len(nodes) // 2 :]]
        side[first], side[second] = 1, 2
        own, other = side[nodes], side[rows.indices]
        crossing = (other > 0) & (other != own[from_])
        border = np.unique(from_[crossing])
        of_first, of_second = nodes[border[own[border] == 1]], nodes[border[own[border] == 2]]
        side[nodes] = 0
        if len(of_first) <= len(of_second):
            found = np.setdiff1d(first, of_first, assume_unique=True), second, of_first
        else:
            found = first, np.setdiff1d(second, of_second, assume_unique=True), of_second
        if best is None or len(found[2]) < len(best[2]):
            best = found
    assert best is not None
    a, b, between = best
    # disconnected pieces: any node may be the separator
    return best if len(between) else (a[1:], b, a[:1])
