"""Pairs of triangles of one surface that cross each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array

Pairs = NDArray[np.intp]

ROUND_OFF = 1e-10
"""Volume over the cube of the extent of two triangles, up to which a corner is in a plane."""
AT_ONCE = 500_000
"""Pairs that are compared at once, which bounds the memory."""


def crossing_pairs(p: Array, boxes: Array, leaf: int, enough: int = 100) -> Pairs:
    """Return pairs of triangles (np, 2) that cross: an edge of one passes through the other.

    Triangles that only touch do not cross. The search ends after about `enough` pairs.

    Parameters
    ----------
    p : (nt, 3, 3) array
        Triangles in the order of the tree.
    boxes : (2 nl, 6) array
        Binary tree of boxes: least and largest coordinates of node i, whose children are 2 i and
        2 i + 1.
    leaf : int
        Triangles of a leaf.
    """
    leaves = len(boxes) // 2
    low, high = p.min(axis=1), p.max(axis=1)
    found: list[Pairs] = []
    candidates = _overlapping(boxes[:, :3], boxes[:, 3:])
    step = AT_ONCE // leaf**2
    for start in range(0, len(candidates), step):
        # triangles of one leaf against the other leaf, then against its triangles, each pair once
        pairs = _children(candidates[start : start + step], 0, leaf, len(p))
        pairs = _near(pairs, (low, high), (boxes[leaves:, :3], boxes[leaves:, 3:]))
        pairs = _near(_children(pairs, 1, leaf, len(p)), (low, high), (low, high))
        pairs = pairs[pairs[:, 0] < pairs[:, 1]]
        pairs = pairs[_cross(p[pairs[:, 0]], p[pairs[:, 1]])]
        found.append(pairs)
        if sum(map(len, found)) >= enough:
            break
    return np.concatenate([np.zeros((0, 2), dtype=np.intp), *found])


def _overlapping(low: Array, high: Array) -> Pairs:
    """Return pairs of leaves i <= j whose boxes overlap, level by level from the root."""
    pairs = np.zeros((1, 2), dtype=np.intp)
    first = 1
    while 2 * first < len(low):
        first *= 2
        both = _children(_children(pairs, 0, 2, first), 1, 2, first)
        at = low[first:], high[first:]
        pairs = _near(both[both[:, 0] <= both[:, 1]], at, at)
    return pairs


def _children(pairs: Pairs, side: int, count: int, end: int) -> Pairs:
    """Return the pairs with each of the `count` children, below `end`, of one side."""
    of: Pairs = (count * pairs[:, side, None] + np.arange(count)).ravel()
    other = np.repeat(pairs[:, 1 - side], count)
    both = np.stack([of, other] if side == 0 else [other, of], axis=1)
    return both[of < end]


def _near(pairs: Pairs, one: tuple[Array, Array], other: tuple[Array, Array]) -> Pairs:
    """Return the pairs whose boxes overlap, given the least and largest corners of both sides."""
    i, j = pairs.T
    for k in range(3):
        keep = (one[0][i, k] <= other[1][j, k]) & (other[0][j, k] <= one[1][i, k])
        i, j = i[keep], j[keep]
    return np.stack([i, j], axis=1)


def _cross(p: Array, q: Array) -> NDArray[np.bool_]:
    """Return whether triangles (n, 3, 3) cross: an edge of one passes through the other."""
    both = np.concatenate([p, q], axis=1)
    least = ROUND_OFF * (both.max(axis=1) - both.min(axis=1)).max(axis=1, initial=0.0) ** 3
    found = np.zeros(len(p), dtype=np.bool_)
    (at,) = np.nonzero(_on_both_sides(_heights(p, q), least))
    at = at[_on_both_sides(_heights(q[at], p[at]), least[at])]
    found[at] = _pierces(p[at], q[at], least[at]) | _pierces(q[at], p[at], least[at])
    return found


def _heights(p: Array, q: Array) -> Array:
    """Return six times the volumes (3, n) between the corners of p and the triangles q, m3."""
    normal = np.cross(q[:, 1] - q[:, 0], q[:, 2] - q[:, 0])
    return np.stack([np.einsum("ni,ni->n", normal, p[:, k] - q[:, 0]) for k in range(3)])


def _on_both_sides(height: Array, least: Array) -> NDArray[np.bool_]:
    return np.asarray((height > least).any(axis=0) & (height < -least).any(axis=0))


def _pierces(p: Array, q: Array, least: Array) -> NDArray[np.bool_]:
    """Return whether an edge of the triangles p passes through the inside of the triangles q.

    The ends of the edge are on both sides of the plane of q, and its line turns about all edges of
    q in one direction; volumes up to `least` count as 0.
    """
    found = np.zeros(len(p), dtype=np.bool_)
    height = _heights(p, q)
    for k in range(3):
        a, b = p[:, k], p[:, (k + 1) % 3]
        through = _on_both_sides(height[[k, (k + 1) % 3]], least)
        turns = np.stack([_volume(a, b, q[:, m], q[:, (m + 1) % 3]) for m in range(3)])
        found |= through & ((turns > least).all(axis=0) | (turns < -least).all(axis=0))
    return found


def _volume(a: Array, b: Array, c: Array, d: Array) -> Array:
    """Return six times the signed volume (n,) of the tetrahedra with these corners (n, 3), m3."""
    return np.asarray(np.einsum("ni,ni->n", np.cross(b - a, c - a), d - a))
