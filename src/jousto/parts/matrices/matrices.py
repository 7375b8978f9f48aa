"""Matrices: mass and stiffness of another program, and node and direction of each row."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from jousto.base.arrays import Array, Ints, Sparse, as_csr, some
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.mesh.sets import NODE_NAMES_UP_TO

DIRECTIONS = ("modal", "ux", "uy", "uz", "rx", "ry", "rz")


@dataclass(frozen=True, eq=False, kw_only=True)
class Matrices:
    """Mass and stiffness of another program, in SI units and the axes of the part.

    Created by `read_matrices`. The class is the same for a full model and for a condensed one
    (superelement), which may also have modal coordinates.

    Parameters
    ----------
    name : str Name in messages.
    M, K : (ndof, ndof) sparse array
    dofs : (ndof, 2) ndarray of int
        Number of the node in the other program and direction of each row: 1, 2, 3 translations,
        4, 5, 6 rotations, 0 for a modal coordinate.
    node_ids : (nn,) ndarray of int
        Numbers of the nodes in the other program.
    nodes : (nn, 3) ndarray
        Their positions in m.
    node_sets : mapping of str to node numbers, optional
    elements : (ne, m) ndarray of int, optional
        Rows of ``nodes``; for drawing.
    held : (m, 2) ndarray of int, optional
        Node and direction of rows fixed by the other program, if its files contain them.

    Raises
    ------
    InputError
        With all inconsistencies of the arguments.
    """

    name: str
    M: Sparse
    K: Sparse
    dofs: Ints
    node_ids: Ints
    nodes: Array
    node_sets: Mapping[str, Ints] = field(default_factory=dict)
    elements: Ints = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))
    held: Ints = field(default_factory=lambda: np.zeros((0, 2), dtype=np.int64))

    def __post_init__(self) -> None:
        where, problems = f"matrices '{self.name}'", Problems()
        object.__setattr__(self, "M", as_csr(self.M))
        object.__setattr__(self, "K", as_csr(self.K))
        dofs = np.asarray(self.dofs, dtype=np.int64).reshape(-1, 2)
        object.__setattr__(self, "dofs", dofs)
        for letter, matrix in (("M", self.M), ("K", self.K)):
            if matrix.shape != (len(dofs), len(dofs)):
                problems.add(
                    where,
                    f"{letter} has shape {matrix.shape} but the map has {len(dofs)} rows; the "
                    f"files must be of the same run",
                )
        xyz = problems.array(where, "nodes", self.nodes, (len(self.node_ids), 3))
        object.__setattr__(self, "nodes", xyz)
        if np.any((dofs[:, 1] < 0) | (dofs[:, 1] > 6)):
            bad = dofs[(dofs[:, 1] < 0) | (dofs[:, 1] > 6)][0]
            problems.add(
                where,
                f"node {bad[0]} has the direction {bad[1]}, must be 1..6 (temperatures and "
                f"pressures cannot be used)",
                "node",
            )
        twice, times = np.unique(dofs, axis=0, return_counts=True)
        if np.any(times > 1):
            row = twice[times > 1][0]
            problems.add(where, f"two rows are node {row[0]} direction {row[1]}")
        unknown = np.setdiff1d(dofs[dofs[:, 1] > 0, 0], self.node_ids)
        if len(unknown):
            names = some([str(i) for i in unknown])
            problems.add(
                where,
                f"the matrices have rows of node {names} without a position; give the nodes of the"
                " same model (they are numbered as in the other program)",
            )
        problems.raise_if_any()

    def __repr__(self) -> str:
        q = int(np.sum(self.dofs[:, 1] == 0))
        modal = f", {q} modal coordinates" if q else ""
        nodes = len(np.unique(self.dofs[self.dofs[:, 1] > 0, 0]))
        return f"<Matrices {self.name!r}: {len(self.dofs)} rows, {nodes} nodes{modal}>"

    @property
    def modal(self) -> Ints:
        """Indices of the rows of modal coordinates."""
        return np.flatnonzero(self.dofs[:, 1] == 0)

    @property
    def used(self) -> Ints:
        """Rows with mass or stiffness."""
        size = len(self.dofs)
        weight = np.asarray(abs(self.M) @ np.ones(size) + abs(self.K) @ np.ones(size))
        return np.flatnonzero(weight > 0.0)

    def with_sets(self, node_sets: Mapping[str, object]) -> Matrices:
        """Return the matrices with additional node sets, in the numbering of the other program.

        Raises
        ------
        InputError
            If a set contains a node that does not exist.
        """
        where, problems = f"matrices '{self.name}'", Problems()
        sets = dict(self.node_sets)
        for name, given in node_sets.items():
            members = np.atleast_1d(np.asarray(given))
            unknown = np.setdiff1d(members, self.node_ids)
            if members.dtype.kind not in "iu" or len(unknown) or not len(members):
                found = some([str(n) for n in unknown]) or "no whole number"
                problems.add(
                    where,
                    f"node_sets['{name}'] names node {found}, must be numbers of nodes as in the"
                    f" other program ({self.node_ids.min()}..{self.node_ids.max()})",
                    "node_sets",
                )
            sets[name] = members
        problems.raise_if_any()
        return replace(self, node_sets=sets)

    def check_free(self) -> None:
        """Raise InputError if the other program fixed rows of the part.

        Raises
        ------
        InputError
        """
        if not len(self.held):
            return
        names = some([f"{n} {DIRECTIONS[c]}" for n, c in self.held])
        raise InputError(
            Problem(
                f"matrices '{self.name}'",
                f"were written with supports ({len(self.held)} directions held: node {names})."
                " Write the matrices of the free part; the joints of jousto support it later",
            )
        )


@dataclass(frozen=True, eq=False)
class Nodal:
    """Matrices in the order of a `Part`: node by node, with 3 or 6 rows for each node.

    Parameters
    ----------
    M, K : (ndof, ndof) sparse array
    nodes : (nn, 3) ndarray
    dofs_per_node : int
    node_sets : dict of str to tuple of int
        Node indices; ``n17`` is the node with the number 17 in the other program.
    elements : (ne, m) ndarray of int
    """

    M: Sparse
    K: Sparse
    nodes: Array
    dofs_per_node: int
    node_sets: dict[str, tuple[int, ...]]
    elements: Ints


def nodal(matrices: Matrices) -> Nodal:
    """Return the matrices in the order node by node.

    Rows without mass and stiffness are left out (Nastran writes rotations of solids).

    Raises
    ------
    InputError
        If directions of a node are missing, nodes with and without rotations are mixed, or there
        are modal coordinates.
    """
    where, problems = f"matrices '{matrices.name}'", Problems()
    matrices.check_free()
    rows = matrices.used
    dofs = matrices.dofs[rows]
    if np.any(dofs[:, 1] == 0):
        problems.add(
            where,
            f"{int(np.sum(dofs[:, 1] == 0))} of its rows are modal coordinates: this is a"
            " superelement of Craig-Bampton type; use reduce_superelement",
        )
        problems.raise_if_any()

    # directions of each node as bits
    ids, node = np.unique(dofs[:, 0], return_inverse=True)
    bits = np.zeros(len(ids), dtype=np.int64)
    np.bitwise_or.at(bits, node, 1 << (dofs[:, 1] - 1))
    only, all_six = bits == 0b000111, bits == 0b111111
    odd = np.flatnonzero(~(only | all_six))
    if len(odd):
        have = [c for c in range(1, 7) if bits[odd[0]] >> (c - 1) & 1]
        lack = [DIRECTIONS[c] for c in range(1, 7 if max(have) > 3 else 4) if c not in have]
        problems.add(
            where,
            f"{len(odd)} of {len(ids)} nodes lack a direction, such as node {ids[odd[0]]}, which"
            f" has no {', '.join(lack)}: it was fixed or constrained. Write the matrices of the"
            " free part, without supports and constraint equations",
        )
    gone = np.setdiff1d(matrices.node_ids[np.unique(matrices.elements)], ids)
    # (a condensed model contains few nodes of its mesh)
    if 0 < len(gone) < len(ids):
        problems.add(
            where,
            f"{len(gone)} nodes of the mesh have no rows (node {some([str(i) for i in gone])}): "
            f"they were fixed, or the mesh is that of another model. Write the matrices of the "
            f"free part,"
            " without supports",
        )
    if not len(odd) and np.any(only) and np.any(all_six):
        problems.add(
            where,
            f"{int(np.sum(only))} nodes have three directions and {int(np.sum(all_six))} have six"
            f" (such as node {ids[all_six][0]}): write the solids only and tie their surfaces to"
            " a node with an Interface, or condense the model in the other program and use"
            " reduce_superelement",
        )
    problems.raise_if_any()

    # sort by position, then by direction
    d = 6 if np.any(all_six) else 3
    place = {int(number): i for i, number in enumerate(matrices.node_ids)}
    where_of = np.array([place[int(number)] for number in ids], dtype=np.int64)
    order = rows[np.lexsort((dofs[:, 1], where_of[node]))]
    keep = np.sort(where_of)
    M, K = as_csr(matrices.M[order][:, order]), as_csr(matrices.K[order][:, order])
    _notice_condensed(where, M, d, len(keep))
    return Nodal(
        M=M,
        K=K,
        nodes=matrices.nodes[keep],
        dofs_per_node=d,
        node_sets=sets_of(matrices, keep),
        elements=elements_of(matrices, keep),
    )


def _notice_condensed(where: str, M: Sparse, d: int, nn: int) -> None:
    """Warn about a mass matrix that couples every node with every other node."""
    if nn < 3 or (d == 3 and nn <= 27):
        return  # a single element couples all its nodes, too
    coo = M.tocoo()
    pairs = np.unique(coo.row // d * nn + coo.col // d)
    if len(pairs) == nn * nn:
        warn(
            where,
            "every node is coupled with every other: if these matrices are condensed, use "
            "reduce_superelement; a Part would estimate its inertia from these few nodes",
            "every",
        )


def sets_of(matrices: Matrices, keep: Ints) -> dict[str, tuple[int, ...]]:
    """Return the node sets with indices of kept rows of ``nodes``, and sets ``n<number>``."""
    ids = matrices.node_ids[keep]
    index = {int(number): i for i, number in enumerate(ids)}
    sets: dict[str, tuple[int, ...]] = {}
    if len(ids) <= NODE_NAMES_UP_TO:
        sets = {f"n{number}": (i,) for number, i in index.items()}
    for name, members in matrices.node_sets.items():
        inside = tuple(sorted({index[int(n)] for n in members if int(n) in index}))
        if inside:
            sets[name] = inside
    return sets


def elements_of(matrices: Matrices, keep: Ints) -> Ints:
    """Return the elements whose nodes are all kept, with indices of kept rows."""
    if not matrices.elements.size:
        return np.zeros((0, 2), dtype=np.int64)
    new = np.full(len(matrices.nodes), -1, dtype=np.int64)
    new[keep] = np.arange(len(keep))
    renumbered: Ints = new[matrices.elements]
    return renumbered[np.all(renumbered >= 0, axis=1)]
