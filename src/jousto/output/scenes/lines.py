"""Bodies as smooth lines, splines through the nodes of their beams; solids are surfaces."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from jousto.base.arrays import Array, Index
from jousto.output.scenes.surface import Surface, is_surface, make_surface
from jousto.simulation.results.records import BodyShape

STRAIGHT = np.cos(np.deg2rad(5.0))  # elements that meet at a larger angle have a corner there
FINE = 6  # pieces of an element in a smooth line


@dataclass(frozen=True, eq=False)
class Chain:
    """A smooth line through nodes.

    Attributes
    ----------
    nodes : (m,) int array
        The nodes in order.
    weights : (k, m) array
        Points of the line = weights @ positions of the nodes.
    """

    nodes: Index
    weights: Array


@dataclass(frozen=True, eq=False)
class Outline:
    """What is drawn of a body: its chains, and the nodes that get a dot; or its surface."""

    chains: tuple[Chain, ...]
    dots: Index
    surface: Surface | None = None


def drawn(shape: BodyShape) -> tuple[BodyShape, Outline]:
    """Return a body with the nodes that its picture needs, and what is drawn of it."""
    if not is_surface(shape.elements):
        return shape, outline(shape)
    surface = make_surface(shape.nodes, shape.elements)
    kept = replace(
        shape,
        nodes=shape.nodes[surface.nodes],
        modes=shape.modes[surface.nodes],
        elements=surface.triangles,
    )
    return kept, Outline((), np.zeros(0, dtype=np.intp), surface)


def outline(shape: BodyShape) -> Outline:
    """Return the lines of a body; without elements only its nodes.

    Elements of two nodes that go on without a corner form one line, which is a cubic spline
    through the nodes; all other elements are drawn with their edges.
    """
    edges = _edges(np.asarray(shape.elements))
    if not len(edges):
        return Outline((), np.arange(len(shape.nodes)))
    neighbours: dict[int, list[int]] = {}
    for a, b in edges:
        neighbours.setdefault(int(a), []).append(int(b))
        neighbours.setdefault(int(b), []).append(int(a))
    stops = {k for k in neighbours if not _goes_on(shape.nodes, k, neighbours[k])}
    smooth = shape.kind in ("flexible", "beam")
    chains = []
    left = {(int(min(e)), int(max(e))) for e in edges}
    starts = [*sorted(stops), *sorted(neighbours)]  # the second part is for closed rings
    for start in starts:
        for other in neighbours[start]:
            if (min(start, other), max(start, other)) in left:
                chain = _walk(start, other, neighbours, stops, left)
                chains.append(_chain(shape.nodes, chain, smooth))
    ends = [k for k in sorted(neighbours) if len(neighbours[k]) == 1 or not smooth]
    return Outline(tuple(chains), np.array(ends, dtype=np.intp))


def _edges(elements: Index) -> Index:
    """Return the edges (k, 2), each once; elements of more than two nodes become closed loops."""
    if elements.size == 0 or elements.shape[1] < 2:
        return np.zeros((0, 2), dtype=np.intp)
    pairs = (
        elements
        if elements.shape[1] == 2
        else np.stack([elements, np.roll(elements, -1, axis=1)], axis=2).reshape(-1, 2)
    )
    pairs = np.unique(np.sort(pairs, axis=1), axis=0)
    return np.asarray(pairs[pairs[:, 0] != pairs[:, 1]], dtype=np.intp)


def _goes_on(nodes: Array, k: int, others: list[int]) -> bool:
    if len(others) != 2:
        return False
    before, after = nodes[k] - nodes[others[0]], nodes[others[1]] - nodes[k]
    size = np.linalg.norm(before) * np.linalg.norm(after)
    return bool(size > 0.0 and before @ after >= STRAIGHT * size)


def _walk(
    start: int,
    other: int,
    neighbours: dict[int, list[int]],
    stops: set[int],
    left: set[tuple[int, int]],
) -> list[int]:
    """Return the nodes from `start` over `other` to the next stop, and take the edges away."""
    chain = [start]
    while True:
        left.discard((min(chain[-1], other), max(chain[-1], other)))
        chain.append(other)
        if other in stops or other == start:
            return chain
        a, b = neighbours[other]
        other = b if a == chain[-2] else a


def _chain(nodes: Array, chain: list[int], smooth: bool) -> Chain:
    index = np.array(chain, dtype=np.intp)
    m = len(index)
    if not smooth or m < 3:
        return Chain(index, np.eye(m))
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes[index], axis=0), axis=1))])
    fine = np.interp(np.arange((m - 1) * FINE + 1) / FINE, np.arange(m), s)
    return Chain(index, np.asarray(CubicSpline(s, np.eye(m))(fine)))
