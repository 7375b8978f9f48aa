"""Quality of the elements of a mesh."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from jousto.base.arrays import Array, Ints, frozen
from jousto.base.errors import count
from jousto.base.object_repr import described
from jousto.mesh.cells import SOLIDS, Cells, base, edges
from jousto.mesh.reference import jacobians, places, shape_functions, table

# scaled Jacobian below which an element causes large local errors
POOR = 0.05
# number of elements per block, to limit memory
_CHUNK = 4096
# 1 / sine of the solid angle at a corner of the ideal cell
_IDEAL = {"tetra": np.sqrt(2.0), "hexahedron": 1.0, "wedge": 2.0 / np.sqrt(3.0)}


@described
@dataclass(frozen=True, eq=False)
class Quality:
    """Quality of the elements of a mesh; all arrays run over all solid cells.

    Attributes
    ----------
    ids : (ne,) ndarray of int
        Element numbers in the file.
    scaled_jacobian : (ne,) ndarray
        Smallest value over the corners of ``det(t1, t2, t3) / (|t1| |t2| |t3|)``, t the tangents
        of the (curved) edges, divided by its value in the ideal element: 1 for a regular
        tetrahedron, a cube or a prism on a regular triangle, 0 for a flat element, negative for an
        inverted one.
    jacobian_ratio : (ne,) ndarray
        Smallest divided by largest Jacobian determinant over nodes and centre: 1 for straight
        tetrahedra and parallelepipeds, at most 0 for an element that is folded somewhere.
    aspect : (ne,) ndarray
        Longest edge divided by the shortest edge, measured from corner to corner.
    """

    ids: Ints
    scaled_jacobian: Array
    jacobian_ratio: Array
    aspect: Array

    def _facts(self) -> str:
        worst = self.scaled_jacobian.min(initial=np.inf)
        return f"{len(self.ids)} elements, scaled Jacobian from {worst:.3g}"

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def negative(self) -> Ints:
        """Indices (from 0) of the elements whose Jacobian is not positive everywhere."""
        return np.flatnonzero((self.scaled_jacobian <= 0.0) | (self.jacobian_ratio <= 0.0))

    def worst(self, count: int = 5) -> tuple[tuple[int, float], ...]:
        """Return the elements with the smallest scaled Jacobians as (id, scaled Jacobian)."""
        order = np.argsort(self.scaled_jacobian, kind="stable")[:count]
        return tuple((int(self.ids[i]), float(self.scaled_jacobian[i])) for i in order)

    def __str__(self) -> str:
        if not len(self):
            return "no solid elements"
        low = int(np.argmin(self.scaled_jacobian))
        long = int(np.argmax(self.aspect))
        poor = int(np.sum(self.scaled_jacobian < POOR))
        text = (
            f"{count(len(self), 'element')}: scaled Jacobian {self.scaled_jacobian[low]:.3g}"
            f" (element {self.ids[low]}) to {self.scaled_jacobian.max():.3g},"
            f" median {np.median(self.scaled_jacobian):.3g}; longest to shortest edge up to"
            f" {self.aspect[long]:.3g} (element {self.ids[long]})"
        )
        if poor:
            text += f"; {count(poor, 'element')} below {POOR:g}"
        if len(self.negative):
            text += f"; {len(self.negative)} inverted or folded"
        return text


@cache
def _corner_edges(kind: str) -> tuple[Ints, Ints, Array]:
    """Return corners (m,), their three neighbours (m, 3) right-handed, and reference vectors."""
    r = places(base(kind))
    near: list[list[int]] = [[] for _ in r]
    for a, b in edges(kind):
        near[int(a)].append(int(b))
        near[int(b)].append(int(a))
    neighbours = np.array(near)
    vectors = r[neighbours] - r[:, None, :]
    turned = np.linalg.det(vectors) < 0.0
    neighbours[turned] = neighbours[turned][:, [0, 2, 1]]
    vectors = r[neighbours] - r[:, None, :]
    return np.arange(len(r)), neighbours, vectors


def _chunks(cells: Sequence[Cells]) -> Iterator[tuple[str, Ints, slice]]:
    first = 0
    for block in cells:
        if block.kind not in SOLIDS:
            continue
        for i in range(0, len(block), _CHUNK):
            part = block.nodes[i : i + _CHUNK]
            yield block.kind, part, slice(first + i, first + i + len(part))
        first += len(block)


@cache
def _at_nodes(kind: str) -> Array:
    """Return derivatives of the shape functions (m, 3, k) at the nodes and the centre."""
    points = places(kind)
    centre = points[: SOLIDS[base(kind)]].mean(axis=0)
    return shape_functions(kind, np.concatenate([points, centre[None]]))[1]


def measure(nodes: Array, cells: Sequence[Cells]) -> Quality:
    """Return the quality of all solid cells."""
    solid = [block for block in cells if block.kind in SOLIDS]
    ids = np.concatenate([np.zeros(0, dtype=np.int64), *(block.ids for block in solid)])
    scaled, ratio, aspect = np.ones(len(ids)), np.ones(len(ids)), np.ones(len(ids))
    for kind, part, here in _chunks(cells):
        X = nodes[part]
        dN = _at_nodes(kind)
        J = np.einsum("ekx,mrk->emxr", X, dN, optimize=True)
        det = jacobians(dN, X)

        # largest absolute determinant as scale, so that an inverted cell is negative
        top = np.abs(det).max(axis=1)
        ratio[here] = det.min(axis=1) / np.where(top > 0.0, top, 1.0)

        # scaled Jacobian from the tangents at the corners
        corner, _, vectors = _corner_edges(kind)
        t = np.einsum("emxr,mjr->emjx", J[:, corner], vectors, optimize=True)
        length = np.prod(np.linalg.norm(t, axis=3), axis=2)
        triple = np.einsum("emx,emx->em", t[:, :, 0], np.cross(t[:, :, 1], t[:, :, 2]))
        value = triple / np.where(length > 0.0, length, 1.0) * _IDEAL[base(kind)]
        # tangents of curved edges may enclose larger angles than those of the ideal cell
        scaled[here] = np.minimum(value.min(axis=1), 1.0)

        ends = edges(kind)
        span = np.linalg.norm(X[:, ends[:, 0]] - X[:, ends[:, 1]], axis=2)
        low, high = span.min(axis=1), span.max(axis=1)
        # limited to 1e100 for an edge of zero length
        aspect[here] = high / np.maximum(low, 1e-100 * high + np.finfo(float).tiny)
    return Quality(ids, *map(frozen, (scaled, ratio, aspect)))


def volumes(nodes: Array, cells: Sequence[Cells]) -> Array:
    """Return the volume of every solid cell in m^3, curved edges included."""
    total = sum(len(block) for block in cells if block.kind in SOLIDS)
    out = np.zeros(total)
    for kind, part, here in _chunks(cells):
        t = table(kind, "mass")
        out[here] = jacobians(t.dN, nodes[part]) @ t.weights
    return out
