"""Mesh: a grid of solids with picks of nodes, checks and changes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Ints
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.object_repr import described
from jousto.mesh.grid import Grid
from jousto.mesh.holes import Hole, find_holes
from jousto.mesh.inspection import Finding, duplicates, inspect, merge_tolerance
from jousto.mesh.picks import InBox, InCylinder, InSphere, Nearest, OnPlane, Pick, unit_vector
from jousto.mesh.reference import FORMULATIONS
from jousto.mesh.surface import face_normals


@explained
@described
@dataclass(frozen=True, eq=False)
class Mesh(Grid):
    """Nodes, elements and named sets of a part of solids; all arrays are read-only.

    Created by :func:`read_mesh` from a mesh file, by :func:`mesh_cad` from a CAD file, or from
    arrays. The order of nodes and elements is that of the file.

    Parameters
    ----------
    name : str
        Name of the part.
    nodes : (nn, 3) array_like
        Positions in m, part frame.
    cells : Cells or sequence of Cells
        Elements, one block per kind and material. Kinds without mass and stiffness (shells, lines,
        pyramids) are for drawing and reported by :meth:`check`.
    node_ids : (nn,) array_like of int, optional
        Node numbers in the file; None to number them from 1.
    node_sets : mapping of str to array_like of int
        Node indices (not numbers of the file), kept sorted.
    element_sets : mapping of str to array_like of int
        Elements counted from 0 over all solid cells, block after block.
    surfaces : mapping of str to (nf, k) array_like of int
        Faces as node indices, corner nodes first; rows of shorter faces end with -1.
    source : str
        Name of the mesh file, empty for a mesh from arrays. The unit of a file is checked by the
        size of the mesh; the unit of arrays is not checked.
    cad_volume : float, optional
        Volume of the CAD solids in m^3; the certificate compares it with that of the mesh.

    Notes
    -----
    Every element set and every surface is also a node set of the same name, unless a node set of
    that name exists.

    Raises
    ------
    InputError
        With all problems of the arguments.

    Examples
    --------
    >>> from jousto.mesh.cells import Cells
    >>> corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    >>> mesh = Mesh("wedge", corners, Cells("tetra", [(0, 1, 2, 3)]))
    >>> mesh.volume  # a sixth of a cube
    0.1667
    >>> mesh.box((-0.1, -0.1, -0.1), (1.1, 1.1, 0.1))
    array([0, 1, 2])
    """

    # ---- picks -----------------------------------------------------------------------------------

    def set(self, name: str) -> Ints:
        """Return the node indices of a set.

        The error of an unknown name suggests the most similar one.
        """
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
        return self.picked(InBox(lo, hi), surface=surface)

    def cylinder(
        self,
        point: Any,
        axis: Any,
        radius: float,
        length: float | None = None,
        *,
        surface: bool = False,
    ) -> Ints:
        """Return the nodes inside or on a cylinder; for a bore these are the nodes of its wall.

        See :class:`InCylinder`.

        Parameters
        ----------
        point : (3,) array_like
            A point of the axis, m, part frame; the middle of the cylinder if a length is given.
        axis : (3,) array_like
            Direction of the axis, part frame.
        radius : float
            Radius in m.
        length : float, optional
            Length in m along the axis; infinite if not given.
        surface : bool
            Only nodes on the outer faces.
        """
        return self.picked(InCylinder(point, axis, radius, length), surface=surface)

    def sphere(self, point: Any, radius: float, *, surface: bool = False) -> Ints:
        """Return the nodes within ``radius`` m of a point of the part frame."""
        return self.picked(InSphere(point, radius), surface=surface)

    @explained
    def nearest(self, point: Any, count: int = 1, *, surface: bool = False) -> Ints:
        """Return the nodes of solid elements nearest to a point in m of the part frame, sorted."""
        return self.picked(Nearest(point, count), surface=surface)

    def plane(self, point: Any, normal: Any, tolerance: float | None = None) -> Ints:
        """Return the nodes on a plane through a point, within a tolerance in m."""
        return self.picked(OnPlane(point, normal, tolerance))

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

    @explained
    def picked(self, pick: Pick, *, surface: bool = False) -> Ints:
        """Return the nodes of a pick such as :class:`InBox`, sorted.

        Parameters
        ----------
        pick : Pick
            Pick of nodes; `Nearest` uses nodes of solid elements only.
        surface : bool
            Only nodes on the outer faces.
        """
        if isinstance(pick, Nearest):
            candidates = self.surface_nodes if surface else self.used
            return candidates[pick.of(self.nodes[candidates])]
        nodes = pick.of(self.nodes)
        return np.intersect1d(nodes, self.surface_nodes) if surface else nodes

    def holes(self, *, radius: tuple[float, float] = (0.0, np.inf)) -> tuple[Hole, ...]:
        """Return the cylindrical holes with centre, axis, radius, length and nodes.

        Parameters
        ----------
        radius : tuple of float
            Smallest and largest radius, m.
        """
        return find_holes(self, radius)

    # ---- checks ----------------------------------------------------------------------------------

    def check(self) -> tuple[Finding, ...]:
        """Return errors and doubtful points, errors first; see :class:`Finding`."""
        return inspect(self)

    # ---- derived meshes --------------------------------------------------------------------------

    @explained
    def with_set(self, name: str, nodes: Any) -> Mesh:
        """Return the mesh with one more node set.

        It replaces a node set, element set and surface of the same name.
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
        """Return the mesh with all positions times a factor: 0.0254 converts inches to m."""
        problems = Problems()
        problems.positive(f"mesh '{self.name}'", "factor", factor, "")
        problems.raise_if_any()
        volume = None if self.cad_volume is None else self.cad_volume * factor**3
        return replace(self, nodes=self.nodes * factor, cad_volume=volume)

    def formulated(self, formulation: str) -> Mesh:
        """Return the mesh with another formulation of its elements, see :class:`Cells`.

        Parameters
        ----------
        formulation : {"full", "reduced", "incompatible", "bbar"}
            Formulation of all elements whose kind supports it; the others keep theirs.

        Raises
        ------
        InputError
            If no element of the mesh has this formulation.
        """
        having = {kind for kind, names in FORMULATIONS.items() if formulation in names}
        if not any(c.kind in having for c in self.cells):
            known = ", ".join(dict.fromkeys(x for names in FORMULATIONS.values() for x in names))
            hint = f"only {', '.join(sorted(having))} have it" if having else f"known: {known}"
            found = ", ".join(dict.fromkeys(c.kind for c in self.solids)) or "no solids"
            where = f"mesh '{self.name}'"
            message = f"no element has the formulation '{formulation}' ({hint}); it has {found}"
            raise InputError(Problem(where, message))
        cells = (replace(c, formulation=formulation) if c.kind in having else c for c in self.cells)
        return replace(self, cells=tuple(cells))

    def solid(self) -> Mesh:
        """Return the mesh of the solid elements only, without unused nodes."""
        new = np.full(len(self.nodes) + 1, -1)  # the last entry is for the padding of faces
        new[self.used] = np.arange(len(self.used))
        sets = {name: new[old][new[old] >= 0] for name, old in self.node_sets.items()}
        surfaces = {}
        for name, faces in self.surfaces.items():
            kept = new[faces]
            surfaces[name] = kept[np.all((kept >= 0) | (faces < 0), axis=1)]
        return Mesh(
            self.name,
            self.nodes[self.used],
            tuple(replace(c, nodes=new[c.nodes]) for c in self.solids),
            self.node_ids[self.used],
            sets,
            self.element_sets,
            surfaces,
            self.source,
            self.cad_volume,
        )

    def merged(self, tolerance: float | None = None) -> Mesh:
        """Return the mesh with nodes closer than a tolerance, m, joined into one.

        With None the tolerance is that of :meth:`check`: the smaller of 1e-5 times the diagonal of
        the mesh and a tenth of the shortest edge.
        """
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
            tuple(replace(c, nodes=new[c.nodes]) for c in self.cells),
            self.node_ids[kept],
            {name: np.unique(new[old]) for name, old in self.node_sets.items()},
            self.element_sets,
            {name: new[old] for name, old in self.surfaces.items()},
            self.source,
            self.cad_volume,
        )


def facing(mesh: Grid, direction: Any, angle: float) -> Ints:
    """Return the nodes of outer faces whose normal is near a direction."""
    where, problems = f"mesh '{mesh.name}', normal_to", Problems()
    d = unit_vector(problems, where, "direction", direction)
    if not 0.0 < angle <= 180.0:
        problems.add(where, f"angle is {angle:g} degrees, must be above 0 and at most 180", "angle")
    problems.raise_if_any()
    assert d is not None
    mask = np.zeros(len(mesh.nodes), dtype=bool)
    for block in mesh.faces:
        normals = face_normals(mesh.nodes, block.corners)
        long = np.linalg.norm(normals, axis=1)
        near = normals @ d >= (np.cos(np.radians(angle)) - 1e-12) * long
        mask[block.nodes[near]] = True
    return np.flatnonzero(mask)
