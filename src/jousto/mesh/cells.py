"""Cells of a mesh: kinds, faces and edges, in VTK's node order."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Ints
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.object_repr import described
from jousto.mesh import reference as solids
from jousto.mesh.reference import EDGES
from jousto.mesh.sets import read_integers

# kinds with mass and stiffness, and their number of nodes
SOLIDS = solids.KINDS
# kinds for drawing and for names of surfaces and edges only
OTHERS = {
    "pyramid": 5,
    "pyramid13": 13,
    "triangle": 3,
    "triangle6": 6,
    "quad": 4,
    "quad8": 8,
    "line": 2,
    "line3": 3,
    "vertex": 1,
}
KINDS = SOLIDS | OTHERS
SURFACES = ("triangle", "triangle6", "quad", "quad8")
LINES = ("line", "line3", "vertex")


@explained
@described
@dataclass(frozen=True, eq=False)
class Cells:
    """Elements of one kind and one material.

    Parameters
    ----------
    kind : str
        One of meshio's names: ``tetra tetra10 hexahedron hexahedron20 wedge wedge15`` have mass and
        stiffness, ``pyramid pyramid13 triangle triangle6 quad quad8 line line3 vertex`` are for
        drawing and names only.
    nodes : (ne, k) array_like of int
        Node indices from 0, in VTK's order. In a wedge the normal of nodes 0, 1, 2 points towards
        the other triangle, as in Gmsh and Abaqus.
    ids : (ne,) array_like of int
        Element numbers in the file; None to number them from 1.
    material : str
        Name of the material in the file, empty if there is none.
    formulation : {"full", "reduced", "incompatible", "bbar"}
        Formulation of the stiffness of solids, from the element types of the file: exact
        integration; integration at fewer points (``hexahedron hexahedron20 wedge wedge15``; the
        first with hourglass control); nine incompatible modes, or the mean change of volume (both
        for ``hexahedron`` only). See :meth:`Mesh.formulated`.

    Raises
    ------
    InputError
        If the kind is unknown, the arrays do not fit it, or it has no such formulation.
    """

    kind: str
    nodes: Ints | Any
    ids: Ints | Any = ()
    material: str = ""
    formulation: str = "full"

    def __post_init__(self) -> None:
        problems, where = Problems(), f"cells '{self.kind}'"
        if self.kind not in KINDS:
            problems.add(where, f"unknown kind; known: {', '.join(KINDS)}")
        elif self.formulation not in solids.FORMULATIONS.get(self.kind, ("full",)):
            known = ", ".join(solids.FORMULATIONS.get(self.kind, ("full",)))
            problems.add(where, f"has no formulation '{self.formulation}'; it has {known}")
        problems.raise_if_any()
        nodes, ids = read_integers(self.nodes), read_integers(self.ids)
        if nodes is None or nodes.ndim != 2 or nodes.shape[1] != KINDS[self.kind]:
            problems.add(
                where,
                f"nodes has shape {np.shape(self.nodes)}, must be (any, {KINDS[self.kind]})"
                " whole numbers",
            )
        elif ids is None or ids.shape not in ((0,), (len(nodes),)):
            problems.add(where, f"ids has shape {np.shape(self.ids)}, must be ({len(nodes)},)")
        problems.raise_if_any()
        for name, array in (("nodes", nodes), ("ids", ids)):
            assert array is not None
            array.setflags(write=False)
            object.__setattr__(self, name, array)

    def __len__(self) -> int:
        return len(self.nodes)


def instead(kinds: Sequence[str]) -> str:
    """Return the remedy, as the end of a message, for a mesh that has only beams or shells."""
    if any(kind in SURFACES for kind in kinds):
        return (
            "; shells are not supported: mesh plates as solids, or use the matrices of another "
            "program, Part.from_file (type: matrices)"
        )
    if any(kind in LINES for kind in kinds):
        return (
            "; beams of an Abaqus or CalculiX deck become a part by Part.from_deck"
            " (type: beam-deck)"
        )
    return ""


def read_cells(where: str, value: Any) -> tuple[Cells, ...]:
    """Return cells as a tuple, or raise InputError for other objects."""
    cells = (value,) if isinstance(value, Cells) else tuple(value)
    for item in cells:
        if not isinstance(item, Cells):
            found = type(item).__name__
            raise InputError(
                Problem(where, f"cells contains a {found}, must be Cells(kind, nodes)")
            )
    return cells


# ---- faces ---------------------------------------------------------------------------------------

# corners of the faces with outward normals, in the face order of Abaqus
_FACES: dict[str, tuple[tuple[int, ...], ...]] = {
    "tetra": ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)),
    "hexahedron": (
        *((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4)),
        *((1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    ),
    "wedge": ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
}
_QUADRATIC = {"tetra": "tetra10", "hexahedron": "hexahedron20", "wedge": "wedge15"}


def base(kind: str) -> str:
    """Return the kind with corner nodes only: ``tetra`` of ``tetra10``."""
    return kind.rstrip("0123456789")


def is_quadratic(kind: str) -> bool:
    """Return whether cells of this kind have nodes at the middle of their edges."""
    return kind != base(kind)


def edges(kind: str) -> Ints:
    """Return the edges of a solid kind as pairs of corners, in the order of its midside nodes."""
    return np.array(EDGES[_QUADRATIC[base(kind)]])


def _middles(kind: str) -> dict[frozenset[int], int]:
    """Return the mid-side node between each pair of corners."""
    n = SOLIDS[base(kind)]
    return {frozenset((int(a), int(b))): n + i for i, (a, b) in enumerate(edges(kind))}


@cache
def faces(kind: str) -> tuple[tuple[int, ...], ...]:
    """Return the faces of a solid kind: corners with the normal outwards, then midside nodes."""
    corners = _FACES[base(kind)]
    if not is_quadratic(kind):
        return corners
    middle = _middles(kind)
    return tuple(
        (*face, *(middle[frozenset(pair)] for pair in zip(face, face[1:] + face[:1], strict=True)))
        for face in corners
    )


def mirrored(kind: str) -> Ints:
    """Return the node order that turns a cell of negative volume into one of positive volume."""
    swap = {"tetra": [0, 2, 1, 3], "wedge": [3, 4, 5, 0, 1, 2]}
    corners = swap.get(base(kind), [4, 5, 6, 7, 0, 1, 2, 3])
    if not is_quadratic(kind):
        return np.array(corners)
    middle = _middles(kind)
    return np.array(corners + [middle[frozenset((corners[a], corners[b]))] for a, b in edges(kind)])
