"""Mesh: nodes, cells and named sets of a solid part, as they come from a file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Floats, Ints, some
from jousto.base.described import described
from jousto.base.errors import InputError, Problem, Problems, count, suggest
from jousto.mesh.cells import KINDS, SOLIDS, Cells, read_cells
from jousto.mesh.facing import facing, on_plane
from jousto.mesh.picks import InBox, InCylinder, InSphere, Nearest
from jousto.mesh.quality import Quality, measure, volumes
from jousto.mesh.sets import read_integers
from jousto.mesh.surface import Faces, outer_faces, triangulate

if TYPE_CHECKING:
    from jousto.mesh.holes import Hole
    from jousto.mesh.inspection import Finding

Sets = Mapping[str, Ints]


@explained
@described
@dataclass(frozen=True, eq=False)
class Mesh:
    """Nodes, elements and named sets of a part made of solids; all arrays are read-only.

    Made by :func:`read_mesh` from a file or by :func:`mesh_step` from a CAD file, or from arrays.
    The order of nodes and elements is that of the file.

    Parameters
    ----------
    name : str
        Name of the part.
    nodes : (nn, 3) array_like
        Positions in m, part frame.
    cells : Cells or sequence of Cells
        Elements, one block for each kind and material. Kinds that carry no mass and stiffness
        (shells, lines, pyramids) are kept for drawing and reported by :meth:`check`.
    node_ids : (nn,) array_like of int, optional
        The nodes' numbers in their file; from 1 if not given.
    node_sets : mapping of str to array_like of int
        Node indices (not numbers of the file), kept sorted.
    element_sets : mapping of str to array_like of int
        Elements counted from 0 over all solid cells, block after block.
    surfaces : mapping of str to (nf, k) array_like of int
        Faces as node indices, corner nodes first; rows of shorter faces end with -1.
    source : str
        Name of the file it was read from, empty for a mesh made of arrays. Whether the unit of a
        file can be right is judged by the size; arrays are taken as they are.

    Notes
    -----
    Every element set and every surface is a node set of its name, too, unless there is one.

    Raises
    ------
    InputError
        With everything that is wrong.

    Examples
    --------
    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> mesh = Mesh("wedge", corners, Cells("tetra", [(0, 1, 2, 3)]))
    >>> mesh.volume  # a sixth of a cube
    0.1667
    >>> mesh.box((-0.1, -0.1, -0.1), (1.1, 1.1, 0.1))
    array([0, 1, 2])
    """

    name: str
    nodes: Floats
    cells: tuple[Cells, ...]
    node_ids: Ints = ()  # type: ignore[assignment]
    node_sets: Sets = field(default_factory=dict)
    element_sets: Sets = field(default_factory=dict)
    surfaces: Sets = field(default_factory=dict)
    source: str = ""

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
            node_sets.setdefault(name, _frozen(np.unique(faces[faces >= 0])))
        if element_sets:
            blocks = [block.nodes for block in cells if block.kind in SOLIDS]
            starts = np.cumsum([0, *(len(block) for block in blocks)])
            for name, members in element_sets.items():
                if name not in node_sets:
                    found = [
                        block[members[(members >= a) & (members < b)] - a].ravel()
                        for block, a, b in zip(blocks, starts[:-1], starts[1:], strict=True)
                    ]
                    node_sets[name] = _frozen(np.unique(np.concatenate(found)))
        values = {"nodes": nodes, "cells": cells, "node_ids": ids, "node_sets": node_sets}
        for key, value in (values | {"element_sets": element_sets, "surfaces": surfaces}).items():
            object.__setattr__(self, key, value)

    # ---- what there is ---------------------------------------------------------------------------

    @property
    def solids(self) -> tuple[Cells, ...]:
        """The cells that carry mass and stiffness."""
        return tuple(block for block in self.cells if block.kind in SOLIDS)

    @cached_property
    def element_ids(self) -> Ints:
        """Numbers of the solid elements in their file, (ne,)."""
        ids = [np.zeros(0, dtype=np.int64), *(block.ids for block in self.solids)]
        return _frozen(np.concatenate(ids))

    @cached_property
    def used(self) -> Ints:
        """Indices of the nodes that solid elements use, sorted."""
        found = [np.zeros(0, dtype=np.int64), *(block.nodes.ravel() for block in self.solids)]
        return _frozen(np.unique(np.concatenate(found)))

    @cached_property
    def volume(self) -> float:
        """Volume of the solid elements in m^3, curved edges included."""
        return float(volumes(self.nodes, self.cells).sum())

    @cached_property
    def bounds(self) -> tuple[Floats, Floats]:
        """Smallest and largest x, y, z in m of the nodes that solid elements use."""
        nodes = self.nodes[self.used] if len(self.used) else self.nodes
        if not len(nodes):
            return np.zeros(3), np.zeros(3)
        return nodes.min(axis=0), nodes.max(axis=0)

    @cached_property
    def faces(self) -> tuple[Faces, ...]:
        """Outer faces with the elements they belong to, normals outwards."""
        return outer_faces(self.cells)

    @cached_property
    def triangles(self) -> Ints:
        """The outer surface as triangles (nt, 3), normals outwards; midside nodes are used."""
        return triangulate(self.faces)

    @cached_property
    def surface_nodes(self) -> Ints:
        """Indices of the nodes on the outer faces, sorted."""
        found = [np.zeros(0, dtype=np.int64), *(block.nodes.ravel() for block in self.faces)]
        return _frozen(np.unique(np.concatenate(found)))

    def __str__(self) -> str:
        kinds = dict.fromkeys(KINDS, 0)
        for block in self.cells:
            kinds[block.kind] += len(block)
        low, high = self.bounds
        size = " x ".join(f"{1e3 * x:.4g}" for x in high - low)
        elements = ", ".join(f"{n} {kind}" for kind, n in kinds.items() if n)
        return f"mesh '{self.name}': {count(len(self.nodes), 'node')}, {elements}, {size} mm"

    # ---- picks -----------------------------------------------------------------------------------

    def set(self, name: str) -> Ints:
        """Return the node indices of a set; InputError names the nearest known set."""
        if name not in self.node_sets:
            hint = suggest(name, self.node_sets)
            raise InputError(Problem(f"mesh '{self.name}'", f"no set '{name}'{hint}"))
        return self.node_sets[name]

    @explained
    def box(self, lo: Any, hi: Any, *, surface: bool = False) -> Ints:
        """Return the nodes inside a box, its sides included; see :class:`InBox`.

        Parameters
        ----------
        lo, hi : (3,) array_like
            Corners in m, part frame; ``-inf`` and ``inf`` leave a side open.
        surface : bool
            Only nodes on the outer faces.
        """
        return self._kept(InBox(lo, hi).of(self.nodes), surface)

    def cylinder(
        self,
        point: Any,
        axis: Any,
        radius: float,
        length: float | None = None,
        *,
        surface: bool = False,
    ) -> Ints:
        """Return the nodes inside or on a cylinder: of a bore its wall; see :class:`InCylinder`.

        Parameters
        ----------
        point : (3,) array_like
            A point of the axis in m, the middle if a length is given, part frame.
        axis : (3,) array_like
            Direction of the axis, part frame.
        radius : float
            Radius in m.
        length : float, optional
            Length in m along the axis; without end if not given.
        surface : bool
            Only nodes on the outer faces.
        """
        return self._kept(InCylinder(point, axis, radius, length).of(self.nodes), surface)

    def sphere(self, point: Any, radius: float, *, surface: bool = False) -> Ints:
        """Return the nodes within ``radius`` m of a point of the part frame."""
        return self._kept(InSphere(point, radius).of(self.nodes), surface)

    @explained
    def nearest(self, point: Any, count: int = 1, *, surface: bool = False) -> Ints:
        """Return the nodes of solid elements nearest to a point in m of the part frame, sorted."""
        candidates = self.surface_nodes if surface else self.used
        return candidates[Nearest(point, count).of(self.nodes[candidates])]

    def plane(self, point: Any, normal: Any, tolerance: float | None = None) -> Ints:
        """Return the nodes on a plane through a point, within a tolerance in m."""
        return on_plane(self, point, normal, tolerance)

    def normal_to(self, direction: Any, angle: float = 5.0) -> Ints:
        """Return the nodes of the outer faces whose normal points in a direction.

        Parameters
        ----------
        direction : (3,) array_like
            Outward direction, part frame.
        angle : float
            Largest angle in degrees between normal and direction.
        """
        return facing(self, direction, angle)

    def _kept(self, nodes: Ints, surface: bool) -> Ints:
        return np.intersect1d(nodes, self.surface_nodes) if surface else nodes

    def holes(self, *, radius: tuple[float, float] = (0.0, np.inf)) -> tuple[Hole, ...]:
        """Return the cylindrical holes with centre, axis, radius, length and nodes.

        Parameters
        ----------
        radius : tuple of float
            Smallest and largest radius in m to look for.
        """
        from jousto.mesh.holes import find_holes

        return find_holes(self, radius)

    # ---- judgement -------------------------------------------------------------------------------

    def quality(self) -> Quality:
        """Return the quality of the solid elements."""
        return measure(self.nodes, self.cells)

    def check(self) -> tuple[Finding, ...]:
        """Return what is wrong or doubtful, the errors first; see :class:`Finding`."""
        from jousto.mesh.inspection import inspect

        return inspect(self)

    # ---- meshes made from this one ---------------------------------------------------------------

    @explained
    def with_set(self, name: str, nodes: Any) -> Mesh:
        """Return the mesh with one more node set.

        It takes the place of a node set, element set and surface of that name.
        """
        others = {key: value for key, value in self.element_sets.items() if key != name}
        surfaces = {key: value for key, value in self.surfaces.items() if key != name}
        return replace(
            self,
            node_sets={**self.node_sets, name: nodes},
            element_sets=others,
            surfaces=surfaces,
        )

    def scaled(self, factor: float) -> Mesh:
        """Return the mesh with all positions multiplied: 0.0254 turns inches into m."""
        problems = Problems()
        problems.positive(f"mesh '{self.name}'", "factor", factor, "")
        problems.raise_if_any()
        return replace(self, nodes=self.nodes * factor)

    def solid(self) -> Mesh:
        """Return the mesh of the solid elements alone, without nodes that they do not use."""
        new = np.full(len(self.nodes) + 1, -1)  # the last one stands for the padding of faces
        new[self.used] = np.arange(len(self.used))
        sets = {name: new[old][new[old] >= 0] for name, old in self.node_sets.items()}
        surfaces = {}
        for name, faces in self.surfaces.items():
            kept = new[faces]
            surfaces[name] = kept[np.all((kept >= 0) | (faces < 0), axis=1)]
        return Mesh(
            self.name,
            self.nodes[self.used],
            tuple(Cells(c.kind, new[c.nodes], c.ids, c.material) for c in self.solids),
            self.node_ids[self.used],
            sets,
            self.element_sets,
            surfaces,
            self.source,
        )

    def merged(self, tolerance: float | None = None) -> Mesh:
        """Return the mesh with nodes nearer than a tolerance in m joined into one.

        Without a tolerance it is the one of :meth:`check`: 1e-5 of the mesh's diagonal or a tenth
        of the shortest edge, whichever is smaller.
        """
        from jousto.mesh.inspection import duplicates, merge_tolerance

        limit = merge_tolerance(self) if tolerance is None else tolerance
        keep = np.arange(len(self.nodes) + 1)
        for low, high in duplicates(self, limit):  # pairs in ascending order
            keep[high] = keep[low]
        keep[-1] = -1
        kept = np.unique(keep[:-1])
        new = np.full(len(keep), -1)
        new[:-1] = np.searchsorted(kept, keep[:-1])
        return Mesh(
            self.name,
            self.nodes[kept],
            tuple(Cells(c.kind, new[c.nodes], c.ids, c.material) for c in self.cells),
            self.node_ids[kept],
            {name: np.unique(new[old]) for name, old in self.node_sets.items()},
            self.element_sets,
            {name: new[old] for name, old in self.surfaces.items()},
            self.source,
        )


def _frozen(array: Ints) -> Ints:
    array.setflags(write=False)
    return array


def _number(cells: tuple[Cells, ...]) -> tuple[Cells, ...]:
    """Return the cells with ids; blocks without are counted on from 1."""
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
            problems.add(where, f"{what} '{name}' must hold whole numbers, indices from 0")
            continue
        array = np.unique(array)
        bad = array[(array < 0) | (array >= size)]
        if len(bad):
            problems.add(
                where,
                f"{what} '{name}' holds {some([str(i) for i in bad])}, must be in 0..{size - 1}",
            )
            continue
        sets[str(name)] = _frozen(array)
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
            problems.add(where, f"surface '{name}' holds node indices outside 0..{nn - 1}")
        else:
            out[str(name)] = _frozen(array)
    return out
