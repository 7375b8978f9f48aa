"""Coordinates that the rigid ties of a part leave free, and its interface coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array, Index
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.reduction.modes.rigid import length_scale, rigid_modes

if TYPE_CHECKING:
    from jousto.parts.part import Part


@dataclass(frozen=True, eq=False)
class Coordinates:
    """Coordinates z of the motions that the rigid ties of a part leave free, ``u = T z``.

    They are the degrees of freedom of the nodes that are not tied, in their order, and six
    coordinates ``[u, theta]`` of the reference node of each rigid tie. Without rigid ties z is u.

    Parameters
    ----------
    T : (ndof, nz) sparse array or None
        None without rigid ties.
    rigid : (nz, 6) array
        Rigid motions of z. Columns of rotations are about the mean of the nodes and divided by the
        body's size; rows of rotations are multiplied by it.
    nodes, kinds : (nz,) array
        Node of each z, or -1 - number of the rigid tie; and direction 0..5.
    names : tuple of str
        Names of the rigid ties.
    of_dof : (ndof,) array
        Index of z of each degree of freedom; -1 if tied.
    references : mapping of str to (6,) array
        Indices of z of each rigid tie.
    length : float
        Size of the body, m.
    points : (nz, 3) array
        Positions of the nodes, m.
    """

    T: sp.csr_array | None
    rigid: Array
    nodes: Index
    kinds: Index
    names: tuple[str, ...]
    of_dof: Index
    references: dict[str, Index]
    length: float
    points: Array

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.kinds)

    @property
    def motions(self) -> Array:
        """Unscaled rigid motions of z (nz, 6), rotations in rad: ``K_z R = 0``."""
        return self.rigid / np.where(self.kinds < 3, 1.0, self.length)[:, None]

    @property
    def dof(self) -> Index:
        """Degree of freedom of each coordinate (nz,); -1 for coordinates of reference nodes."""
        out = np.full(self.size, -1, dtype=np.intp)
        kept = np.flatnonzero(self.of_dof >= 0)
        out[self.of_dof[kept]] = kept
        return out

    def columns(self, some: Index) -> sp.csr_array:
        """Return selected columns of T (ndof, m)."""
        if self.T is not None:
            return sp.csr_array(self.T[:, some])
        ones = np.ones(len(some))
        place = (some, np.arange(len(some)))
        return sp.csr_array(sp.coo_array((ones, place), shape=(self.size, len(some))))

    def restrict(self, matrix: sp.csr_array) -> sp.csr_array:
        """Return ``T^T A T``."""
        if self.T is None:
            return matrix
        return sp.csr_array(self.T.T @ (matrix @ self.T))

    def spread(self, z: Array) -> Array:
        """Return ``T z``, the displacements of all degrees of freedom."""
        return z if self.T is None else np.asarray(self.T @ z)

    def gather(self, f: Array) -> Array:
        """Return ``T^T f``: loads on the coordinates."""
        return f if self.T is None else np.asarray(self.T.T @ f)

    def label(self, z: int) -> str:
        """Return a name for messages, such as ``node2 uz``, with nodes counted from 1."""
        kind = ("ux", "uy", "uz", "rx", "ry", "rz")[int(self.kinds[z])]
        node = int(self.nodes[z])
        return f"{f'node{node + 1}' if node >= 0 else self.names[-1 - node]} {kind}"


def coordinates(part: Part) -> Coordinates:
    """Return the coordinates left free by the rigid ties of a part."""
    d = part.dofs_per_node
    ndof = part.K.shape[0]
    length = length_scale(part.nodes)
    middle = part.nodes.mean(axis=0)
    rigid = scaled_rigid(part.nodes, d, middle, length)
    dofs = np.arange(ndof, dtype=np.intp)
    ties = [tie for tie in part.ties if tie.kind == "rigid"]
    if not ties:
        places = part.nodes[dofs // d]
        return Coordinates(None, rigid, dofs // d, dofs % d, (), dofs, {}, length, places)

    tied = np.zeros(ndof, dtype=bool)
    for tie in ties:
        tied[tie.dofs] = True
    kept = dofs[~tied]
    of_dof = np.full(ndof, -1, dtype=np.intp)
    of_dof[kept] = np.arange(len(kept))
    nz = len(kept) + 6 * len(ties)
    rows, columns, values = [kept], [of_dof[kept]], [np.ones(len(kept))]
    references: dict[str, Index] = {}
    points = []
    for number, tie in enumerate(ties):
        z = len(kept) + 6 * number + np.arange(6, dtype=np.intp)
        references[tie.name] = z
        block = tie.following.reshape(-1, 6)
        i, j = np.nonzero(block)
        rows.append(np.asarray(tie.dofs[i], dtype=np.intp))
        columns.append(z[j])
        values.append(block[i, j])
        points.append(tie.at)
    T = sp.csr_array(
        sp.coo_array(
            (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
            shape=(ndof, nz),
        )
    )
    count = 6 * len(ties)
    return Coordinates(
        T=T,
        rigid=np.concatenate([rigid[kept], scaled_rigid(np.array(points), 6, middle, length)]),
        nodes=np.concatenate([kept // d, -1 - np.arange(count, dtype=np.intp) // 6]),
        kinds=np.concatenate([kept % d, np.arange(count, dtype=np.intp) % 6]),
        names=tuple(tie.name for tie in ties),
        of_dof=of_dof,
        references=references,
        length=length,
        points=np.concatenate([part.nodes[kept // d], np.repeat(points, 6, axis=0)]),
    )


def scaled_rigid(points: Array, dofs_per_node: int, middle: Array, length: float) -> Array:
    """Return rigid motions of points with comparable translations and rotations."""
    R = rigid_modes(points, dofs_per_node, centre=middle)
    R[:, 3:] /= length
    R[np.arange(len(R)) % dofs_per_node >= 3] *= length
    return R


def embedded(y: Array, rows: Index, size: int) -> Array:
    """Return y (m, k) as rows of an otherwise zero array (size, k)."""
    x = np.zeros((size, y.shape[1]))
    x[rows] = y
    return x


@dataclass(frozen=True, eq=False)
class Boundary:
    """Interfaces of a reduction: coordinates and averages whose motion is given.

    Parameters
    ----------
    held : (nb,) array
        Indices of the coordinates z of nodes and rigid ties, ascending.
    C : (na, nz) sparse array
        Averages, six rows for each averaging tie.
    rigid : (nb + na, 6) array
        Rigid motions of coordinates and averages, scaled as in `Coordinates`.
    """

    held: Index
    C: sp.csr_array
    rigid: Array

    @property
    def size(self) -> int:
        """Number of interface motions."""
        return len(self.rigid)


def boundary(part: Part, z: Coordinates, names: tuple[str, ...]) -> Boundary:
    """Return the coordinates and averages of interfaces and node sets.

    Raises
    ------
    InputError
        If a name is unknown, or a node is in two interfaces.
    """
    problems = Problems()
    where = f"part '{part.name}'"
    ties = {tie.name: tie for tie in part.ties}
    tied = {int(i): tie.name for tie in part.ties for i in tie.nodes if tie.kind == "rigid"}
    owner: dict[int, str] = {}
    held: list[Index] = []
    averages = []
    for name in names:
        tie = ties.get(name)
        members = part.node_sets.get(name) if tie is None else tuple(tie.nodes)
        if members is None:
            problems.add(where, f"no node set '{name}'{suggest(name, [*ties, *part.node_sets])}")
            continue
        if not len(members):
            problems.add(where, f"node set '{name}' is empty, it cannot be an interface")
        for node in members:
            if tie is None and int(node) in tied:
                problems.add(
                    where,
                    f"node{node + 1} of node set '{name}' is tied to interface "
                    f"'{tied[int(node)]}'; use that interface",
                )
                break
            if int(node) in owner and owner[int(node)] != name:
                problems.add(
                    where,
                    f"interfaces '{owner[int(node)]}' and '{name}' share node{node + 1}; keep one",
                )
            owner[int(node)] = name
        if tie is None:
            d = part.dofs_per_node
            first = d * np.array(sorted(members), dtype=np.intp)
            held.append(z.of_dof[(first[:, None] + np.arange(d)).ravel()])
        elif tie.kind == "rigid":
            held.append(z.references[name])
        else:
            averages.append(tie)
    problems.raise_if_any()

    numbers = np.sort(np.concatenate(held)) if held else np.zeros(0, dtype=np.intp)
    blocks, rigid = [], [z.rigid[numbers]]
    middle = part.nodes.mean(axis=0)
    for tie in averages:
        columns = z.of_dof[tie.dofs]
        i, j = np.nonzero(tie.averaging)
        blocks.append(
            sp.coo_array((tie.averaging[i, j], (i, columns[j])), shape=(6, z.size)).tocsr()
        )
        rigid.append(scaled_rigid(tie.at[None, :], 6, middle, z.length))
    C = sp.csr_array(sp.vstack(blocks, format="csr")) if blocks else sp.csr_array((0, z.size))
    return Boundary(numbers, C, np.concatenate(rigid))


def interface_names(part: Part, given: tuple[str, ...]) -> tuple[str, ...]:
    """Return the requested interfaces, or all of the part if none is requested.

    Raises
    ------
    InputError
        If no interface is requested and the part has none.
    """
    names = given or tuple(tie.name for tie in part.ties)
    if not names:
        raise InputError(
            Problem(
                f"part '{part.name}'",
                "has no interfaces and the method contains none: give node sets, "
                'CraigBampton(("start", "end"), modes=4), give the part interfaces, or use '
                "FreeFree()",
            )
        )
    return names
