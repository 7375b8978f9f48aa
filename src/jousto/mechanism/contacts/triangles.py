"""Surfaces of triangles: what is wrong with them, and their tables as the engine reads them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import count
from jousto.mechanism.contacts.crossings import crossing_pairs

LEAF = 4
"""Triangles of a leaf of the tree of boxes (``JO_MESH_LEAF``)."""
MARK = -1.0
"""First number of a surface (``JO_MESH_MARK``)."""
MOST_TRIANGLES = 2_000_000
"""Largest number of triangles; a triangle takes some 180 bytes."""
SAME_PLANE = 1e-6
"""Angle of two triangles of one plane, rad."""
FLAT = 1e-12
"""Height over size up to which a place is in a plane."""
PLANE = 1e-9
"""Height over size up to which triangles joined by flat edges are one plane."""
SHALLOW = np.sin(np.radians(1.0))
"""Sine of the angle of a concave edge up to which its triangles are one part of the surface."""
THIN = 1e-14
"""Area over the square of the longest edge, up to which a triangle has none."""
BITS = 21
"""Bits of a coordinate in the order of the triangles."""


@dataclass(frozen=True, eq=False)
class Triangles:
    """Surface of triangles, counterclockwise seen from the front.

    Attributes
    ----------
    vertices : (nv, 3) array
        m.
    corners : (nt, 3) array of int
        Vertices of each triangle.
    radius : float
        Half the thickness, m.
    """

    vertices: Array
    corners: NDArray[np.int_]
    radius: float = 0.0

    @classmethod
    def of(cls, triangles: Array, radius: float = 0.0) -> Triangles:
        """Return the surface of triangles (nt, 3, 3), m; equal corners become one vertex."""
        points, inverse = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
        return cls(points, np.asarray(inverse).reshape(-1, 3), radius)

    @cached_property
    def size(self) -> float:
        """Largest extent along an axis, m."""
        return float(np.ptp(self.vertices, axis=0).max(initial=0.0)) if len(self.vertices) else 0.0

    @cached_property
    def areas(self) -> Array:
        """Normals of the triangles times twice their areas (nt, 3), m2."""
        a, b, c = (self.vertices[self.corners[:, i]] for i in range(3))
        return np.cross(b - a, c - a)

    @cached_property
    def edges(self) -> tuple[NDArray[np.int_], NDArray[np.int_]]:
        """Triangle beyond each edge (nt, 3), -1 for none; times that each edge is there (nt, 3)."""
        start = self.corners
        end = np.roll(self.corners, -1, axis=1)
        low, high = np.minimum(start, end).ravel(), np.maximum(start, end).ravel()
        key = low.astype(np.int64) * len(self.vertices) + high
        order = np.argsort(key, kind="stable")
        sorted_key = key[order]
        first = np.flatnonzero(np.r_[True, sorted_key[1:] != sorted_key[:-1]])
        times = np.diff(np.r_[first, len(order)])
        number = np.empty(len(order), dtype=np.int_)
        number[order] = np.repeat(times, times)
        beyond = np.full(len(order), -1)
        pairs = first[times == 2]
        beyond[order[pairs]], beyond[order[pairs + 1]] = order[pairs + 1] // 3, order[pairs] // 3
        return beyond.reshape(-1, 3), number.reshape(-1, 3)

    @property
    def closed(self) -> bool:
        """Whether each edge belongs to two triangles."""
        return bool((self.edges[1] == 2).all())

    @cached_property
    def faults(self) -> list[str]:
        """Sentences on what makes the surface useless, without those on its numbers."""
        if not len(self.corners):
            return ["the surface has no triangles"]
        if len(self.corners) > MOST_TRIANGLES:
            return [
                f"the surface has {len(self.corners)} triangles, at most {MOST_TRIANGLES} are "
                "possible; take a coarser surface"
            ]
        if not np.isfinite(self.vertices).all():
            wrong = ~np.isfinite(self.vertices[self.corners]).all(axis=(1, 2))
            return [f"{_some(np.asarray(wrong))} corners that are not finite"]
        return [*self._bad_triangles(), *self._bad_edges()]

    def _bad_triangles(self) -> list[str]:
        found = []
        p = self.vertices[self.corners]
        longest = (np.linalg.norm(p - np.roll(p, 1, axis=1), axis=2) ** 2).max(axis=1)
        thin = ~(np.linalg.norm(self.areas, axis=1) > THIN * longest)
        if thin.any():
            found.append(f"{_some(thin)} no area; remove them")
        sorted_corners = np.sort(self.corners, axis=1)
        _, first, times = np.unique(sorted_corners, axis=0, return_index=True, return_counts=True)
        if (times > 1).any():
            twice = np.zeros(len(self.corners), dtype=bool)
            twice[first[times > 1]] = True
            found.append(f"{_some(twice)} a double with the same corners; remove the doubles")
        return found

    def _bad_edges(self) -> list[str]:
        found = []
        beyond, times = self.edges
        if (times > 2).any():
            several = np.asarray((times > 2).any(axis=1))
            found.append(
                f"{_some(several)} an edge with more than two triangles; split the surface there "
                "into several shapes"
            )
        row, i = np.nonzero(beyond >= 0)
        here = np.stack([self.corners[row, i], self.corners[row, (i + 1) % 3]], axis=1)
        other = self.corners[beyond[row, i]]
        ahead = np.roll(other, -1, axis=1)
        same = ((other == here[:, :1]) & (ahead == here[:, 1:])).any(axis=1)
        if same.any():
            wrong = np.zeros(len(self.corners), dtype=bool)
            wrong[row[same]] = True
            found.append(
                f"{_some(wrong)} a neighbour with the opposite orientation; let the program that "
                "made it repair the normals"
            )
        elif self.closed and not found and self.volume < 0.0:
            found.append(
                f"its triangles face inwards (it encloses {self.volume:.4g} m3); reverse their "
                "corners"
            )
        return found

    @property
    def crossings(self) -> list[str]:
        """Sentence on triangles of a surface without other faults that cross each other."""
        order = self._order
        p = self.vertices[self.corners[order]]
        pairs = crossing_pairs(p, _boxes(p)[0], LEAF)
        if not len(pairs):
            return []
        a, b = min(map(sorted, order[pairs].tolist()))
        several = f" (the first of {len(pairs)} pairs that were found)" if len(pairs) > 1 else ""
        return [
            f"triangles {a} and {b}{several} cross each other, so that the surface intersects "
            "itself; let the program that made it unite its parts, or give each part as a shape "
            "of its own"
        ]

    @property
    def volume(self) -> float:
        """Volume that a closed surface encloses, m3; negative if its triangles face inwards."""
        middle = self.vertices.mean(axis=0)
        centre = self.vertices[self.corners].mean(axis=1) - middle
        return float(np.einsum("ti,ti->", centre, self.areas) / 6.0)

    @cached_property
    def numbers(self) -> Array:
        """Data of the engine: see ``jo_mesh_read`` in ``mesh.c``."""
        ordered = Triangles(self.vertices, self.corners[self._order], self.radius)
        planes, group, patch = _parts(ordered)
        corners = ordered.corners
        boxes, leaves = _boxes(self.vertices[corners])
        fan = np.argsort(corners.ravel(), kind="stable") // 3
        first = np.r_[0, np.cumsum(np.bincount(corners.ravel(), minlength=len(self.vertices)))]
        sizes = [MARK, len(self.vertices), len(corners), len(planes), self.radius]
        parts: list[Any] = [
            [*sizes, float(self.closed), leaves],
            self.vertices,
            planes,
            corners,
            ordered.edges[0],
            group,
            patch,
            first,
            fan,
            boxes,
        ]
        return np.concatenate([np.ravel(np.asarray(part, dtype=float)) for part in parts])

    @property
    def _order(self) -> NDArray[np.intp]:
        """Order of the triangles in which neighbours in space are near: that of Morton (1966)."""
        centre = self.vertices[self.corners].mean(axis=1)
        low = centre.min(axis=0)
        scale = (2**BITS - 1) / (self.size or 1.0)
        cell = ((centre - low) * scale).astype(np.uint64)
        key = np.zeros(len(centre), dtype=np.uint64)
        for bit in range(BITS):
            for axis in range(3):
                there = (cell[:, axis] >> np.uint64(bit)) & np.uint64(1)
                key |= there << np.uint64(3 * bit + axis)
        return np.argsort(key, kind="stable")


def _some(wrong: NDArray[np.bool_]) -> str:
    """Return how many triangles there are, the first of them, and "have" or "has"."""
    (where,) = np.nonzero(wrong)
    verb = "has" if len(where) == 1 else "have"
    first = "" if len(where) == 1 else f" (the first is {where[0]})"
    named = f"triangle {where[0]}" if len(where) == 1 else count(len(where), "triangle")
    return f"{named}{first} {verb}"


def _boxes(p: Array) -> tuple[Array, int]:
    """Return the boxes (2 nl, 6) of a binary tree of triangles (nt, 3, 3), and its leaves nl."""
    low, high = p.min(axis=1), p.max(axis=1)
    starts = np.arange(0, len(p), LEAF)
    leaves = 1 << max(len(starts) - 1, 0).bit_length()
    boxes = np.empty((2 * leaves, 6))
    boxes[:, :3], boxes[:, 3:] = 1e150, -1e150  # none
    boxes[leaves : leaves + len(starts), :3] = np.minimum.reduceat(low, starts)
    boxes[leaves : leaves + len(starts), 3:] = np.maximum.reduceat(high, starts)
    level = leaves
    while level > 1:
        children = boxes[level : 2 * level].reshape(-1, 2, 6)
        level //= 2
        boxes[level : 2 * level, :3] = children[:, :, :3].min(axis=1)
        boxes[level : 2 * level, 3:] = children[:, :, 3:].max(axis=1)
    return boxes, leaves


def _parts(mesh: Triangles) -> tuple[Array, NDArray[np.int_], NDArray[np.int_]]:
    """Return planes (ng, 4), the plane of each triangle, and the part of the surface of each.

    Triangles belong to one plane if edges without an angle join them. A part is joined by edges
    that are not concave; of an open surface, which has two sides, by edges that are nearly flat.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    def joined(which: NDArray[np.bool_]) -> NDArray[np.int_]:
        n = len(mesh.corners)
        links = coo_array((np.ones(which.sum()), (row[which], other[which])), shape=(n, n))
        return np.asarray(connected_components(links, directed=False)[1])

    row, i = np.nonzero(mesh.edges[0] >= 0)
    other = mesh.edges[0][row, i]
    length = np.linalg.norm(mesh.areas, axis=1)
    normal = mesh.areas / length[:, None]
    start, end = mesh.corners[row, i], mesh.corners[row, (i + 1) % 3]
    along = mesh.vertices[end] - mesh.vertices[start]
    along /= np.linalg.norm(along, axis=1)[:, None]
    sine = np.einsum("ei,ei->e", np.cross(normal[row], normal[other]), along)
    cosine = np.einsum("ei,ei->e", normal[row], normal[other])
    facing = cosine > 0.0
    # of a narrow triangle the normal is inexact: its farthest corner is in the plane of the other
    large = length[row] >= length[other]
    opposite = np.where(large, other, row)
    base = np.where(large, row, other)
    heights = np.abs(
        np.einsum(
            "eci,ei->ec",
            mesh.vertices[mesh.corners[opposite]] - mesh.vertices[start][:, None],
            normal[base],
        )
    ).max(axis=1, initial=0.0)
    flat = facing & ((np.abs(sine) < SAME_PLANE) | (heights < FLAT * mesh.size))
    group = joined(flat)
    planes = _planes(mesh, group)
    over = np.einsum("tci,ti->tc", mesh.vertices[mesh.corners], planes[group, :3])
    off = np.abs(over - planes[group, 3:]).max(axis=1) > PLANE * mesh.size
    bent = np.isin(group, np.unique(group[off]))  # curved by many small angles: no plane
    single = group.max() + 1 + np.arange(len(group))
    group = np.unique(np.where(bent, single, group), return_inverse=True)[1]
    level = facing & (np.abs(sine) < SHALLOW)
    return _planes(mesh, group), group, joined(level | (sine >= 0.0) if mesh.closed else level)


def _planes(mesh: Triangles, group: NDArray[np.int_]) -> Array:
    """Return the mean planes of groups of triangles (ng, 4): normal and offset."""
    n: Array = np.stack([np.bincount(group, mesh.areas[:, k]) for k in range(3)], axis=1)
    n = n / np.linalg.norm(n, axis=1)[:, None]
    weight = np.linalg.norm(mesh.areas, axis=1)
    centre = mesh.vertices[mesh.corners].mean(axis=1)
    height = np.einsum("ti,ti->t", centre, n[group])
    offset = np.bincount(group, weight * height) / np.bincount(group, weight)
    return np.column_stack([n, offset])
