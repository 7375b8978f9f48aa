"""Matrices of another program as input of a part."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import AnyField, Label, OptionalText, field
from jousto.mesh.sets import node_graph, pieces, rigid_groups, tied
from jousto.parts.form import Dictionary, PartForm
from jousto.parts.matrices.checks import check_matrices, points_from_blocks


class ForeignMatrices(PartForm):
    """Base of matrices in memory and in files."""

    node_sets: Dictionary = field(
        "Node sets: for files by the node numbers of the other program, for plain matrices by "
        "indices from 0",
        form="node sets",
        noun="mapping of str to nodes",
        default=None,
        kw_only=True,
    )
    interfaces: AnyField = field(
        "Surfaces tied to a node with six directions",
        form="set interfaces",
        noun="sequence of Interface",
        default=(),
        kw_only=True,
    )

    def judge(self, part: Any) -> None:
        """Raise InputError if K has disconnected pieces that no rigid interface joins."""
        if part.interfaces:
            problems = Problems()
            graph = tied(node_graph(part.K, part.dofs_per_node), rigid_groups(part.ties))
            pieces(problems, f"part '{part.name}'", part.nodes, graph)
            problems.raise_if_any()


class PlainMatrices(ForeignMatrices):
    """Part from mass and stiffness matrices of another program.

    Raises
    ------
    InputError
        If a matrix is not square, symmetric and finite, does not fit the nodes, M is not positive
        semidefinite, a node has neither mass nor stiffness, or K has disconnected pieces that are
        not joined by a rigid interface.

    Warns
    -----
    JoustoWarning
        If a rigid motion stores strain energy, which means that K contains supports.

    Examples
    --------
    >>> from jousto import Material, Part, Rectangle
    >>> beam = Part.beam(1.0, Rectangle(0.1, 0.1), 2, Material(2e11, 0.3, 7850.0))
    >>> Part.from_matrices(beam.M, beam.K, beam.nodes).dofs_per_node
    6
    """

    M: AnyField = field(
        "Mass of the unsupported component, SI units, node after node",
        noun="(ndof, ndof) array_like or sparse",
    )
    K: AnyField = field("Its stiffness", noun="(ndof, ndof) array_like or sparse")
    nodes: AnyField = field("Positions, part frame", unit="m", noun="(nn, 3) array_like")
    dofs_per_node: AnyField = field(
        "3 or 6; None for the value that fits the sizes",
        form="count",
        noun="int",
        default=None,
        kw_only=True,
    )
    elements: AnyField = field(
        "Elements, for drawing only",
        form="cells",
        noun="(ne, m) array_like of int",
        default=None,
        kw_only=True,
    )
    name: Label = field("Name of the part", file=False, default="part", kw_only=True)

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part that is built from the matrices."""
        mass, stiff, xyz, dofs = check_matrices(
            self.name,
            self.M,
            self.K,
            self.nodes,
            self.dofs_per_node,
            whole=not self.interfaces,
        )
        return {
            "name": self.name,
            "nodes": xyz,
            "elements": np.zeros((0, 2), np.int64) if self.elements is None else self.elements,
            "dofs_per_node": dofs,
            "M": mass,
            "K": stiff,
            "node_sets": self.node_sets or {},
            "mass_points": points_from_blocks(mass, xyz, dofs),
            "interfaces": self.interfaces,
        }


class MatrixFiles(ForeignMatrices):
    """Part from the matrix files of another program, see `read_matrices`.

    The rows are sorted by node; node sets of the mesh keep their names, and
    ``n17`` is the node with the number 17 in the other program.

    Raises
    ------
    InputError
        With all problems of the files, or with the matrices (`from_matrices`).

    Warns
    -----
    JoustoWarning
        If the units look wrong, or a rigid motion stores strain energy.
    """

    K: AnyField = field(
        "File of the stiffness matrix, or of both: .sti, .full, .op4, .pch, .mtx, .npz, .npy, .rsa",
        form="file",
        noun="str or Path",
    )
    M: AnyField = field(
        "File of the mass matrix, if it is a separate file that cannot be found beside that of K",
        form="file",
        noun="str or Path",
        default=None,
    )
    nodes: AnyField = field(
        "Positions: a mesh, a table of x y z or number x y z (.npy, .csv, .txt), or a list; "
        "None searches beside the matrices of CalculiX, Ansys and Nastran",
        form="positions",
        noun="str, Path or array_like",
        default=None,
        kw_only=True,
    )
    dofs: AnyField = field(
        "File with the node and the direction (1..6, 0 modal) of each row",
        form="file",
        noun="str, Path or array_like",
        default=None,
        kw_only=True,
    )
    format: OptionalText = field(
        "calculix, ansys, op4, dmig, abaqus or plain; None determines it from the ending and "
        "the content",
        default=None,
        kw_only=True,
    )
    units: Label = field(
        "Units of the files, such as SI, mm-t-s, in-lbf-s", default="SI", kw_only=True
    )
    name: OptionalText = field(
        "Name of the part; None for the name of the file", file=False, default=None, kw_only=True
    )

    def assembled(self) -> dict[str, Any]:
        """Return the fields of the part that is built from the files."""
        from jousto.parts.matrices.matrices import nodal
        from jousto.parts.matrices.read import read_matrices

        keys = ("K", "M", "nodes", "dofs", "format", "units", "name")
        found = read_matrices(**{key: getattr(self, key) for key in keys}).with_sets(
            self.node_sets or {}
        )
        ordered = nodal(found)
        plain = PlainMatrices(
            ordered.M,
            ordered.K,
            ordered.nodes,
            dofs_per_node=ordered.dofs_per_node,
            node_sets=ordered.node_sets,
            elements=ordered.elements if len(ordered.elements) else None,
            interfaces=self.interfaces,
            name=found.name,
        )
        return plain.assembled()
