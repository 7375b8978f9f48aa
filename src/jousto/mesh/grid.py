"""Grid: checked nodes, cells and named sets of a solid part, and quantities derived from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.arrays import Array, Ints, frozen, some
from jousto.base.errors import Problems, count
from jousto.mesh.cells import KINDS, SOLIDS, Cells, read_cells
from jousto.mesh.quality import Quality, measure, volumes
from jousto.mesh.sets import read_integers
from jousto.mesh.surface import Faces, outer_faces, triangulate

Sets = Mapping[str, Ints]


@dataclass(frozen=True, eq=False)
class Grid:
    """Data of a `Mesh` without picks, checks and changes; see `Mesh` for the attributes."""

    name: str
    nodes: Array
    cells: tuple[Cells, ...]
    node_ids: Ints = ()  # type: ignore[assignment]
    node_sets: Sets = field(default_factory=dict)
    element_sets: Sets = field(default_factory=dict)
    surfaces: Sets = field(default_factory=dict)
    source: str = ""
    cad_volume: float | None = None

    def __post_init__(self) -> None:
        where, problems = f"mesh '{self.name}'", Problems()
        cells = read_cells(where, self.cells)
        nodes = problems.array(where, "nodes", self.nodes, (None, 3))
        ids = read_integers(self.node_ids)
        problems.raise_if_any()
        assert nodes is not None
        nn = len(nodes)
        if ids is None or ids.shape not in ((0,), (nn,)):
            problems.add(where, f"node_ids has shape {np.shape(self.node_ids)}, must be ({nn},)")
        else:
            ids = ids if len(ids) or not nn else np.arange(1, nn + 1)
            ids.setflags(write=False)
        for block in cells:
            bad = np.argwhere((block.nodes < 0) | (block.nodes >= nn))
            if len(bad):
                i, j = (int(x) for x in bad[0])
                problems.add(
                    where,
                    f"{block.kind} element {i} has node index {block.nodes[i, j]}, must be in"
                    f" 0..{nn - 1}",
                )
        cells = _number(cells)
        ne = sum(len(block) for block in cells if block.kind in SOLIDS)
        node_sets = _read_sets(problems, where, "node set", self.node_sets, nn)
        element_sets = _read_sets(problems, where, "element set", self.element_sets, ne)
        surfaces = _read_surfaces(problems, where, self.surfaces, nn)
        problems.raise_if_any()

        # surfaces and element sets as node sets
        for name, faces in surfaces.items():
            node_sets.setdefault(name, frozen(np.unique(faces[faces >= 0])))
        if element_sets:
            blocks = [block.nodes for block in cells if block.kind in SOLIDS]
            starts = np.cumsum([0, *(len(block) for block in blocks)])
            for name, members in element_sets.items():
                if name not in node_sets:
                    found = [
                        block[members[(members >= a) & (members < b)] - a].ravel()
                        for block, a, b in zip(blocks, starts[:-1], starts[1:], strict=True)
                    ]
                    node_sets[name] = frozen(
                        np.unique(np.concatenate([*found, np.zeros(0, np.int64)]))
                    )
        values = {"nodes": nodes, "cells": cells, "node_ids": ids, "node_sets": node_sets}
        for key, value in (values | {"element_sets": element_sets, "surfaces": surfaces}).items():
            object.__setattr__(self, key, value)

    @property
    def solids(self) -> tuple[Cells, ...]:
        """Cells with mass and stiffness."""
        return tuple(block for block in self.cells if block.kind in SOLIDS)

    @cached_property
    def element_ids(self) -> Ints:
        """Numbers of the solid elements in their file, (ne,)."""
        ids = [np.zeros(0, dtype=np.int64), *(block.ids for block in self.solids)]
        return frozen(np.concatenate(ids))

    @cached_property
    def used(self) -> Ints:
        """Indices of the nodes that solid elements use, sorted."""
        found = [np.zeros(0, dtype=np.int64), *(block.nodes.ravel() for block in self.solids)]
        return frozen(np.unique(np.concatenate(found)))

    @cached_property
    def volume(self) -> float:
        """Volume of the solid elements in m^3, curved edges included."""
        return float(volumes(self.nodes, self.cells).sum())

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Smallest and largest x, y, z in m of the nodes that solid elements use."""
        nodes = self.nodes[self.used] if len(self.used) else self.nodes
        if not len(nodes):
            return np.zeros(3), np.zeros(3)
        return nodes.min(axis=0), nodes.max(axis=0)

    @cached_property
    def faces(self) -> tuple[Faces, ...]:
        """Outer faces with outward normals, and the elements to which they belong."""
        return outer_faces(self.cells)

    @cached_property
    def triangles(self) -> Ints:
        """Outer surface as triangles (nt, 3) with outward normals, mid-side nodes included."""
        return triangulate(self.faces)

    @cached_property
    def surface_nodes(self) -> Ints:
        """Indices of the nodes on the outer faces, sorted."""
        found = [np.zeros(0, dtype=np.int64), *(block.nodes.ravel() for block in self.faces)]
        return frozen(np.unique(np.concatenate(found)))

    def __str__(self) -> str:
        kinds = dict.fromkeys(KINDS, 0)
        for block in self.cells:
            kinds[block.kind] += len(block)
        low, high = self.bounds
        size = " x ".join(f"{1e3 * x:.4g}" for x in high - low)
        elements = ", ".join(f"{n} {kind}" for kind, n in kinds.items() if n)
        return f"mesh '{self.name}': {count(len(self.nodes), 'node')}, {elements}, {size} mm"

    def quality(self) -> Quality:
        """Return the quality of the solid elements."""
        return measure(self.nodes, self.cells)


def _number(cells: tuple[Cells, ...]) -> tuple[Cells, ...]:
    """Return the cells with element numbers; blocks without numbers are numbered from 1."""
    out, first = [], 1
    for block in cells:
        if not len(block.ids) and len(block):
            ids = np.arange(first, first + len(block))
            block = replace(block, ids=ids)
        first += len(block)
        out.append(block)
    return tuple(out)


def _read_sets(
    problems: Problems, where: str, what: str, given: Mapping[str, Any], size: int
) -> dict[str, Ints]:
    sets = {}
    for name, value in given.items():
        array = read_integers(value)
        if array is None or array.ndim > 1:
            problems.add(where, f"{what} '{name}' must contain whole numbers, indices from 0")
            continue
        array = np.unique(array)
        bad = array[(array < 0) | (array >= size)]
        if len(bad):
            problems.add(
                where,
                f"{what} '{name}' contains {some([str(i) for i in bad])}, must be in 0..{size - 1}",
            )
            continue
        sets[str(name)] = frozen(array)
    return sets


def _read_surfaces(
    problems: Problems, where: str, given: Mapping[str, Any], nn: int
) -> dict[str, Ints]:
    out = {}
    for name, value in given.items():
        array = read_integers(value)
        if array is not None and array.size == 0:
            array = np.zeros((0, 3), dtype=np.int64)
        if array is None or array.ndim != 2 or array.shape[1] not in (3, 4, 6, 8):
            found = np.shape(value)
            problems.add(where, f"surface '{name}' has shape {found}, must be (any, 3 4 6 or 8)")
        elif np.any(array[:, :3] < 0) or np.any(array < -1) or np.any(array >= nn):
            problems.add(where, f"surface '{name}' contains node indices outside 0..{nn - 1}")
        else:
            out[str(name)] = frozen(array)
    return out
