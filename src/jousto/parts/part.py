"""Part: one flexible component as nodes, elements, mass and stiffness."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from jousto.base.arrays import Array, Ints, Sparse, read_only, skew, times
from jousto.base.declare import made_by
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.names import check_name
from jousto.base.renames import missing_attribute
from jousto.mesh.area import node_normals
from jousto.mesh.mesh import Mesh
from jousto.mesh.sets import (
    node_index,
    read_elements,
    read_sets,
)
from jousto.parts.form import PartForm
from jousto.parts.frames.deck import BeamDeck
from jousto.parts.frames.forms import ArrayFrame, MemberFrame, StraightBeam
from jousto.parts.frames.outlines import Outlines
from jousto.parts.frames.second_order import SecondOrder
from jousto.parts.frames.stress import StressOperator
from jousto.parts.geometry import Geometry
from jousto.parts.interface import Interface, Tie, resolve
from jousto.parts.loads import Load, load_vector
from jousto.parts.mass import MassPoints
from jousto.parts.matrices.checks import rigid_modes
from jousto.parts.matrices.form import MatrixFiles, PlainMatrices
from jousto.parts.solids.form import MeshSolid
from jousto.parts.solids.model import SolidModel
from jousto.parts.solids.second_order import SolidSecondOrder
from jousto.parts.solids.stress import SolidStress
from jousto.parts.solids.surface import surface_stress


def part_of(form: PartForm) -> Part:
    """Return the part built from an input: beams, a mesh or matrices."""
    return Part.of(form)


@dataclass(frozen=True, eq=False, kw_only=True)
class Part(Geometry):
    """A flexible component before reduction, in its own part frame, free of supports.

    Created by :meth:`beam`, :meth:`frame`, :meth:`from_members`, :meth:`from_deck`, :meth:`solid`,
    :meth:`from_matrices` or :meth:`from_file`.

    Parameters
    ----------
    name : str
        Name of the part.
    nodes : (nn, 3) ndarray
        Undeformed positions in m, part frame.
    elements : (ne, m) ndarray of int
        Node indices from 0; for drawing: rows of two nodes are beams, rows of three nodes are
        triangles of the outer surface of solids with outward normals.
    dofs_per_node : int
        6: ``[ux uy uz rx ry rz]`` for each node, or 3: ``[ux uy uz]``; node after node.
    M, K : (ndof, ndof) sparse array
        Mass and stiffness matrix in SI units, part axes.
    node_sets : mapping of str to tuple of int
        Named nodes; ``node1`` .. ``nodeN`` (counted from 1) are added up to 10000 nodes.
    mass_points : MassPoints, optional
        Mass points from which M was computed.
    stress : StressOperator or SolidStress, optional
        Stress from nodal displacements.
    second_order : SecondOrder or SolidSecondOrder, optional
        Second-order displacements, for geometric stiffness; beams and solids have them.
    interfaces : sequence of Interface
        Surfaces, each tied to one node with six motions.
    faces : sequence of (nf, k) ndarray of int
        Outer faces of solids by kind, k = 3, 4, 6 or 8 node indices each, corners first, then
        mid-side nodes; used for area weights of averages over a surface.
    surfaces : mapping of str to sequence of (nf, k) ndarray of int
        Named faces in the same form; an interface on the node set with the same name uses these
        faces.
    solids : SolidModel, optional
        The solid elements with their materials.
    mesh : Mesh, optional
        The mesh of the solids.
    attached : MassPoints, optional
        Rigid masses that M contains in addition to the consistent mass of solids.
    outlines : Outlines, optional
        Outer edges of the sections of beams, for drawing.
    """

    elements: Ints
    M: Sparse
    K: Sparse
    mass_points: MassPoints | None = None
    stress: StressOperator | SolidStress | Any = None
    second_order: SecondOrder | SolidSecondOrder | None = None
    interfaces: Sequence[Interface] = ()
    solids: SolidModel | None = None
    mesh: Mesh | None = None
    attached: MassPoints | None = None
    outlines: Outlines | None = None

    def __post_init__(self) -> None:
        where, problems = f"part '{self.name}'", Problems()
        check_name(problems, "part", self.name)
        nodes = problems.array(where, "nodes", self.nodes, (None, 3))
        if nodes is not None:
            object.__setattr__(self, "nodes", nodes)
            elements: Ints | None = np.zeros((0, 2), dtype=np.int64)
            if np.size(self.elements):
                elements = read_elements(problems, where, self.elements, len(nodes), None)
            object.__setattr__(self, "elements", elements)
            sets = read_sets(problems, where, self.node_sets, len(nodes))
            object.__setattr__(self, "node_sets", sets)
            ndof = len(nodes) * self.dofs_per_node
            if self.dofs_per_node not in (3, 6):
                problems.add(
                    where, f"dofs_per_node is {self.dofs_per_node}, must be 3 or 6", "dofs_per_node"
                )
            for letter, matrix in (("M", self.M), ("K", self.K)):
                if matrix.shape != (ndof, ndof):
                    problems.add(
                        where,
                        f"{letter} has shape {matrix.shape}, must be {(ndof, ndof)} for"
                        f" {len(nodes)} nodes with {self.dofs_per_node} degrees of freedom",
                    )
            interfaces = problems.several(where, "interfaces", self.interfaces, Interface)
            faces = tuple(np.asarray(group, dtype=np.int64) for group in self.faces)
            object.__setattr__(self, "interfaces", interfaces)
            object.__setattr__(self, "faces", faces)
            if not problems.found:
                ties = resolve(problems, where, self, interfaces)
                object.__setattr__(self, "_ties", ties)
        problems.raise_if_any()

    beam = staticmethod(made_by("Part.beam", StraightBeam, part_of))
    frame = staticmethod(made_by("Part.frame", ArrayFrame, part_of))
    from_members = staticmethod(made_by("Part.from_members", MemberFrame, part_of))
    from_deck = staticmethod(made_by("Part.from_deck", BeamDeck, part_of))
    solid = staticmethod(made_by("Part.solid", MeshSolid, part_of))
    from_matrices = staticmethod(made_by("Part.from_matrices", PlainMatrices, part_of))
    from_file = staticmethod(made_by("Part.from_file", MatrixFiles, part_of))

    @classmethod
    def of(cls, form: PartForm) -> Part:
        """Return the part built from an input: beams, a mesh or matrices."""
        part = cls(**form.assembled())
        form.judge(part)
        return part

    def with_interfaces(self, *interfaces: Interface) -> Part:
        """Return the part with the given interfaces, which replace the present ones.

        Parameters
        ----------
        *interfaces : Interface

        Raises
        ------
        InputError
            If an interface has no nodes, shares nodes with another, or does not determine six
            motions.

        Examples
        --------
        >>> from jousto import Material, Rectangle
        >>> beam = Part.beam(1.0, Rectangle(0.1, 0.1), 2, Material(2e11, 0.3, 7850.0))
        >>> beam.with_interfaces(Interface("tip", "end", at=(1.0, 0.2, 0.0))).ties
        (<Tie 'tip': rigid, 1 nodes about (1, 0.2, 0) m>,)
        """
        return replace(self, interfaces=interfaces)

    @property
    def ties(self) -> tuple[Tie, ...]:
        """Interfaces with the indices of their nodes, reference points and averaging matrices."""
        known: tuple[Tie, ...] | None = self.__dict__.get("_ties")
        if known is None:  # created from other parts field by field, without the constructor
            known = resolve(Problems(), f"part '{self.name}'", self, self.interfaces)
            object.__setattr__(self, "_ties", known)
        return known

    def node(self, name: str) -> int:
        """Return the index of the node of a one-node set.

        Raises
        ------
        InputError
            If there is no such set or it has several nodes.
        """
        try:
            return node_index(name, self.node_sets)
        except KeyError as error:
            raise InputError(Problem(f"part '{self.name}'", str(error.args[0]))) from None

    def rigid_modes(self) -> Array:
        """Return the rigid motions (ndof, 6) of the nodes.

        Three unit translations, then three unit rotations about the origin of the part frame.
        """
        return rigid_modes(self.nodes, self.dofs_per_node)

    def geometric_stiffness(self, d: Any) -> Sparse:
        """Return the geometric stiffness Kg (ndof, ndof) of the stress of a static deformation.

        Under a static load f with the displacements d, ``K d = f``, the stiffness for a further
        small displacement x is K + Kg: tension stiffens a beam, compression softens it. The part
        buckles under c f for the smallest c with ``det(K + c Kg) = 0`` (on the free degrees of
        freedom). For beams, Kg contains the stretch of the elements, ``N int v'^2 + w'^2 + (Iy +
        Iz)/A rx'^2 dx``, the rotation of bending and twisting moments, and rigid arms; for solids
        it is ``x^T Kg x = int s : (grad x^T grad x) dV``.

        Parameters
        ----------
        d : (ndof,) array_like
            Nodal displacements in m and rad, part frame.

        Returns
        -------
        (ndof, ndof) sparse array
            Symmetric; N/m, N, N m.

        Raises
        ------
        InputError
            If the part consists neither of beams nor of solids, or d has another shape.

        Examples
        --------
        The force that buckles a cantilever, over ``pi^2 E I / (4 L^2)``:

        >>> from scipy.linalg import eigh
        >>> from jousto import Circle, Material
        >>> part = Part.beam(1.0, Circle(0.01), 4, Material(2e11, 0.3, 7850.0))
        >>> f = np.zeros(24)
        >>> f[18] = -1.0
        >>> K = part.K.toarray()[6:, 6:]
        >>> Kg = part.geometric_stiffness(np.r_[np.zeros(6), np.linalg.solve(K, f)])
        >>> c = 1.0 / eigh(-Kg.toarray()[6:, 6:], K, eigvals_only=True)[-1]
        >>> f"{c / (np.pi**2 * 2e11 * Circle(0.01).Iy / 4.0):.3f}"
        '1.000'
        """
        where, problems = f"part '{self.name}'", Problems()
        if self.second_order is None:
            problems.add(
                where,
                "has no geometric stiffness, because it was built from matrices; only parts of "
                "beams (Part.beam, Part.frame, Part.from_members) or solids (Part.solid) have "
                "stress data",
            )
        u = problems.array(where, "displacements", d, (self.K.shape[0],))
        problems.raise_if_any()
        assert self.second_order is not None and u is not None
        return self.second_order.geometric_stiffness(u)

    def load(self, *loads: Load) -> Array:
        """Return static loads as nodal forces, the right-hand side of ``K d = f``.

        The forces are work-equivalent for the shape functions: ``f_a = int N_a t dA`` and ``M a``.

        Parameters
        ----------
        *loads : Pressure, Traction, SurfaceLoad, NodalForce, Weight or Spin
            Loads, which are added.

        Returns
        -------
        (ndof,) ndarray
            In N (and N m), part frame.

        Raises
        ------
        InputError
            With all problems: sets that do not exist, nodes without a complete face, moments on
            nodes without rotations.

        Examples
        --------
        >>> from jousto import Circle, Material
        >>> from jousto.parts import NodalForce, Weight
        >>> beam = Part.beam(1.0, Circle(0.01), 2, Material(2e11, 0.3, 7850.0))
        >>> f = beam.load(Weight((0, 0, -9.81)), NodalForce("end", (0, 0, -100)))
        >>> f"{f.reshape(-1, 6)[:, 2].sum():.2f} N, of this {9.81 * beam.mass:.2f} N weight"
        '-106.05 N, of this 6.05 N weight'
        """
        return load_vector(self, self.M, loads)

    @cached_property
    def surface_normals(self) -> Array:
        """Outward unit normals at the surface nodes of solids, (nn, 3), part frame.

        The normals are means over the faces around a node, weighted by area; they are zero at inner
        nodes and in parts without known outer faces. On a free surface normal and shear stress
        vanish: ``s n = 0``.
        """
        return read_only(node_normals(self.nodes, self.faces))

    def surface_stress(self, on: Any = None) -> StressOperator:
        """Return the stress at the nodes of free surfaces of a solid, where no load acts.

        The stress follows from the strain of the outer faces, as measured by strain gauges, and
        from ``s n = 0``, without extrapolation from inside the elements as in `stress`. With
        quadratic elements the error of peaks at holes, fillets and notches is several times
        smaller. Where a pressure acts on the surface, the error is about that pressure.

        Parameters
        ----------
        on : str, array_like of int or pick, optional
            Node set, node indices or a pick, which selects the outer faces whose nodes are all in
            the set. None selects all outer faces except those of interfaces.

        Returns
        -------
        StressOperator
            Sites ``n12`` by the numbers of the nodes in the mesh, part axes. Give it to
            ``part.with_stress`` to use it in a reduction.

        Raises
        ------
        InputError
            If the part does not consist of solids, or no face is selected.

        Examples
        --------
        >>> part.with_stress(part.surface_stress("fillet"))  # doctest: +SKIP
        """
        return surface_stress(self, self.solids, [tie.nodes for tie in self.ties], on)

    def with_stress(self, stress: StressOperator | SolidStress | None) -> Part:
        """Return the part with another stress operator, or without one (None)."""
        return replace(self, stress=stress)

    @property
    def strain(self) -> SolidStress | None:
        """Strain ``[e11 e22 e33 g12 g23 g13]`` at the nodes of solids; None for other parts."""
        return None if self.solids is None else SolidStress.everywhere(self.solids, "strain")

    @cached_property
    def _rigid_mass(self) -> Array:
        R = self.rigid_modes()
        return read_only(R.T @ times(self.M, R))

    def __repr__(self) -> str:
        elements = len(self.elements) if self.solids is None else self.solids.count
        return (
            f"<Part {self.name!r}: {len(self.nodes)} nodes, {elements} elements, "
            f"{self.mass:.6g} kg>"
        )

    @property
    def mass(self) -> float:
        """Total mass in kg."""
        return float(np.trace(self._rigid_mass[:3, :3])) / 3.0

    if not TYPE_CHECKING:  # types of attributes remain known

        def __getattr__(self, name: str) -> NoReturn:
            missing_attribute(self, name)

    @property
    def center(self) -> Array:
        """Centre of mass in m, part frame, (3,)."""
        first = self._rigid_mass[3:, :3]
        S = 0.5 * (first - first.T)
        return np.array([S[2, 1], S[0, 2], S[1, 0]]) / self.mass

    @property
    def inertia(self) -> Array:
        """Inertia tensor about the centre of mass in kg m^2, part axes, (3, 3)."""
        c = skew(self.center)
        J: Array = self._rigid_mass[3:, 3:] + self.mass * c @ c
        return 0.5 * (J + J.T)
