"""Outer faces of a mesh of solids and their triangulation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array, Ints, frozen
from jousto.base.object_repr import described
from jousto.mesh.cells import SOLIDS, SURFACES, Cells, base, faces

# triangles of a face: corners first, then mid-side nodes, with the orientation of the face
_SPLIT = {
    "triangle": [(0, 1, 2)],
    "triangle6": [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)],
    "quad": [(0, 1, 2), (0, 2, 3)],
    "quad8": [(0, 4, 7), (4, 1, 5), (5, 2, 6), (6, 3, 7), (4, 5, 6), (4, 6, 7)],
}
_KIND = {3: "triangle", 4: "quad", 6: "triangle6", 8: "quad8"}


@described
@dataclass(frozen=True, eq=False)
class Faces:
    """Outer faces of one kind, with outward normals.

    Attributes
    ----------
    kind : str
        ``triangle triangle6 quad quad8``.
    nodes : (nf, k) ndarray of int
        Node indices, corners first.
    owners : (nf,) ndarray of int
        Index of the element of each face, over all solid cells from 0.
    sides : (nf,) ndarray of int
        Index of the face in its element, in the order of Abaqus (S1 is 0).
    """

    kind: str
    nodes: Ints
    owners: Ints
    sides: Ints

    def __len__(self) -> int:
        return len(self.nodes)

    @property
    def corners(self) -> Ints:
        """Corner nodes (nf, 3 or 4)."""
        return self.nodes[:, : 3 if base(self.kind) == "triangle" else 4]


def all_faces(cells: Sequence[Cells]) -> list[Faces]:
    """Return every face of every solid cell, one block per kind of face."""
    found: dict[str, list[tuple[Ints, Ints, Ints]]] = {kind: [] for kind in SURFACES}
    first = 0
    for block in cells:
        if block.kind not in SOLIDS:
            continue
        owners = np.arange(first, first + len(block))
        for side, face in enumerate(faces(block.kind)):
            sides = np.full(len(block), side)
            found[_KIND[len(face)]].append((block.nodes[:, face], owners, sides))
        first += len(block)
    out = []
    for kind, parts in found.items():
        if parts:
            nodes, numbers, sides = (np.concatenate(arrays) for arrays in zip(*parts, strict=True))
            out.append(Faces(kind, nodes, numbers, sides))
    return out


def match(blocks: Sequence[Faces]) -> tuple[Ints, Ints]:
    """Return the number of the group of equal faces for every face, and the size of each group."""
    keys = np.full((sum(len(block) for block in blocks), 4), -1, dtype=np.int64)
    row = 0
    for block in blocks:
        corners = block.corners
        keys[row : row + len(block), : corners.shape[1]] = corners
        row += len(block)
    keys.sort(axis=1)
    order = np.lexsort(keys.T)
    sorted_keys = keys[order]
    new = np.ones(len(keys), dtype=bool)
    new[1:] = np.any(sorted_keys[1:] != sorted_keys[:-1], axis=1)
    group = np.empty(len(keys), dtype=np.int64)
    group[order] = np.cumsum(new) - 1
    return group, np.bincount(group, minlength=1)


def outer_faces(cells: Sequence[Cells]) -> tuple[Faces, ...]:
    """Return the faces that belong to a single solid cell."""
    blocks = all_faces(cells)
    if not blocks:
        return ()
    group, number = match(blocks)
    single = number[group] == 1
    out, row = [], 0
    for block in blocks:
        keep = single[row : row + len(block)]
        row += len(block)
        if keep.any():
            arrays = (block.nodes[keep], block.owners[keep], block.sides[keep])
            out.append(Faces(block.kind, *map(frozen, arrays)))
    return tuple(out)


def triangulate(blocks: Sequence[Faces]) -> Ints:
    """Return the faces as triangles (nt, 3); quadratic faces become four or six."""
    parts = [block.nodes[:, _SPLIT[block.kind]].reshape(-1, 3) for block in blocks]
    return frozen(np.concatenate(parts) if parts else np.zeros((0, 3), dtype=np.int64))


def face_kind(columns: int) -> str:
    """Return the kind of a face with a given number of nodes."""
    return _KIND[columns]


def face_normals(nodes: Array, corners: Ints) -> Array:
    """Return normals (nf, 3) of faces, computed from the corners; their length is the area."""
    p = nodes[corners]
    if corners.shape[1] == 3:
        out: Array = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]) / 2.0
    else:
        out = np.cross(p[:, 2] - p[:, 0], p[:, 3] - p[:, 1]) / 2.0
    return out
