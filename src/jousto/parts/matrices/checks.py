"""Checks of mass and stiffness matrices of other programs."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array, Sparse, as_csr, node_dofs, scatter, skew, some, times
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.mesh.sets import node_graph, pieces
from jousto.parts.mass import MassPoints, second_moment

# largest number of rows for a complete check of definiteness; above it, nodal blocks only
DENSE_UP_TO = 1200
# largest strain energy of a rigid motion, relative to the energies that cancel in it
RIGID_TOLERANCE = 1e-10
# largest nodal force of a rigid motion of a free matrix, relative to the forces that cancel in it
RIGID_FORCE = 1e-6
MOTIONS = tuple(f"{kind} {x}" for kind in ("translation along", "rotation about") for x in "xyz")


def rigid_modes(nodes: Array, dofs_per_node: int) -> Array:
    """Return the rigid motions (ndof, 6) of nodes about the origin: translations, rotations."""
    R = np.zeros((len(nodes), dofs_per_node, 6))
    R[:, :3, :3] = np.eye(3)
    R[:, :3, 3:] = -skew(nodes)
    if dofs_per_node == 6:
        R[:, 3:, 3:] = np.eye(3)
    return R.reshape(-1, 6)


def check_matrices(
    name: str, M: Any, K: Any, nodes: Any, dofs_per_node: int | None, *, whole: bool = True
) -> tuple[Sparse, Sparse, Array, int]:
    """Return checked M, K, nodes and degrees of freedom per node, or raise with all problems.

    A K of several disconnected pieces is an error only if `whole` is True, for a part without ties.

    Raises
    ------
    InputError
        See ``Part.from_matrices``.

    Warns
    -----
    JoustoWarning
        If a rigid motion stores strain energy.
    """
    where, problems = f"part '{name}'", Problems()
    mass = _read(problems, where, "mass matrix M", M)
    stiff = _read(problems, where, "stiffness matrix K", K)
    xyz = problems.array(where, "nodes", nodes, (None, 3))
    if mass is None or stiff is None or xyz is None:
        problems.raise_if_any()
        raise AssertionError("unreachable")

    # sizes
    nn, ndof = len(xyz), mass.shape[0]
    dofs = dofs_per_node or (ndof // nn if nn else 0)
    if mass.shape != stiff.shape:
        problems.add(where, f"M is {mass.shape} and K is {stiff.shape}, must be of one size", "M")
    if dofs not in (3, 6) or dofs * nn != ndof:
        given = "" if dofs_per_node is None else f" with dofs_per_node = {dofs_per_node}"
        problems.add(
            where,
            f"{ndof} rows in M do not fit {nn} nodes{given}; 3 or 6 rows for each node are needed",
        )
    problems.raise_if_any()

    # physics
    R = rigid_modes(xyz - xyz.mean(axis=0), dofs)
    if _is_free(mass, R) and not _is_free(stiff, R):
        message = (
            "K and M seem to be swapped: rigid motions have no energy in M, as in a stiffness "
            "matrix, but have in K; the order is from_matrices(M, K, nodes)"
        )
        raise InputError(Problem(where, message))
    empty = np.flatnonzero(_node_weight(mass, dofs) + _node_weight(stiff, dofs) == 0.0)
    if len(empty):
        names = some([f"node{i + 1}" for i in empty])
        problems.add(where, f"{names}: neither mass nor stiffness; remove or connect them")
    elif whole:
        pieces(problems, where, xyz, node_graph(stiff, dofs))
    _check_definite(problems, where, "M", mass, dofs)
    _check_definite(problems, where, "K", stiff, dofs)
    if np.trace((R.T @ times(mass, R))[:3, :3]) <= 0.0:
        problems.add(where, "M contains no mass: a rigid translation has no kinetic energy", "M")
    problems.raise_if_any()
    _check_free(where, stiff, mass, R, dofs)
    return mass, stiff, xyz, dofs


def points_from_blocks(M: Sparse, nodes: Array, dofs: int) -> MassPoints | None:
    """Return the mass points of a mass matrix whose blocks are rigid masses on the nodes.

    The result is None if M couples different nodes, or if a block is not of the form
    ``[[m E, -m c~], [m c~, J]]``.
    """
    nn, ndof = len(nodes), M.shape[0]
    coo = M.tocoo()
    row, column = coo.row, coo.col
    if np.any(row // dofs != column // dofs):
        return None
    blocks = np.zeros((nn, dofs, dofs))
    blocks[row // dofs, row % dofs, column % dofs] = coo.data

    m = np.trace(blocks[:, :3, :3], axis1=1, axis2=2) / 3.0
    scale = 1e-9 * np.abs(blocks).max(axis=(1, 2))
    isotropic = blocks[:, :3, :3] - m[:, None, None] * np.eye(3)
    if np.any(np.abs(isotropic).max(axis=(1, 2)) > scale):
        return None
    E = np.broadcast_to(np.eye(3), (nn, 3, 3))
    turn, c, G = np.zeros((nn, 3, 3)), np.zeros((nn, 3)), np.zeros((nn, 3, 3))
    N = E
    if dofs == 6:
        S = blocks[:, 3:, :3]
        if np.any(np.abs(S + np.swapaxes(S, 1, 2)).max(axis=(1, 2)) > scale):
            return None
        first = np.stack([S[:, 2, 1], S[:, 0, 2], S[:, 1, 0]], axis=1)
        c = first / np.where(m > 0.0, m, 1.0)[:, None]
        G = second_moment(blocks[:, 3:, 3:] + m[:, None, None] * skew(c) @ skew(c))
        N, turn = np.concatenate([E, -skew(c)], axis=2), np.concatenate([turn, E], axis=2)

    used = np.flatnonzero((m > 0.0) | np.any(G != 0.0, axis=(1, 2)))
    rows = node_dofs(np.arange(len(used))[:, None], 3)
    columns = node_dofs(used[:, None], dofs)
    shape = (3 * len(used), ndof)
    return MassPoints(
        mass=m[used],
        position=nodes[used] + c[used],
        second_moment=G[used],
        N=scatter(N[used], rows, columns, shape),
        N_rot=scatter(turn[used], rows, columns, shape),
        arm=c[used],
    )


def _read(problems: Problems, where: str, name: str, value: Any) -> Sparse | None:
    """Return a symmetric, finite csr array, or report what is wrong."""
    try:
        if np.iscomplexobj(value):
            raise TypeError
        shape = getattr(value, "shape", None) or np.shape(value)
        if len(shape) != 2 or shape[0] != shape[1] or shape[0] == 0:
            problems.add(where, f"{name} has shape {shape}, must be square", name)
            return None
        matrix = as_csr(value)
    except (TypeError, ValueError):
        problems.add(where, f"{name} is not a matrix of real numbers", name)
        return None
    coo = matrix.tocoo()
    row, column = coo.row, coo.col
    bad = np.flatnonzero(~np.isfinite(coo.data))
    if len(bad):
        i = bad[0]
        problems.add(where, f"{name}[{row[i]}, {column[i]}] is {coo.data[i]}, must be finite", name)
        return None
    difference = (matrix - matrix.T).tocoo()
    worst = np.abs(difference.data)
    if len(worst) and worst.max() > 1e-8 * np.abs(coo.data).max():
        i = int(worst.argmax())
        r, c = int(difference.row[i]), int(difference.col[i])
        hint = ""
        if np.all(row <= column) or np.all(row >= column):
            hint = "; only one triangle is filled: add its transpose without the diagonal"
        problems.add(
            where,
            f"{name} is not symmetric: [{r}, {c}] is {matrix[r, c]:.6g} but [{c}, {r}] is"
            f" {matrix[c, r]:.6g}{hint}",
            name,
        )
        return None
    return as_csr((matrix + matrix.T) * 0.5)


def _node_weight(matrix: Sparse, dofs: int) -> Array:
    weight = times(abs(matrix), np.ones(matrix.shape[0]))
    total: Array = weight.reshape(-1, dofs).sum(axis=1)
    return total


def _check_definite(problems: Problems, where: str, name: str, matrix: Sparse, dofs: int) -> None:
    """Report a matrix with a negative eigenvalue; of large matrices only the nodal blocks."""
    ndof = matrix.shape[0]
    coo = matrix.tocoo()
    row, column = coo.row, coo.col
    own = row // dofs == column // dofs
    blocks = np.zeros((ndof // dofs, dofs, dofs))
    blocks[row[own] // dofs, row[own] % dofs, column[own] % dofs] = coo.data[own]
    lowest = np.linalg.eigvalsh(blocks)[:, 0]
    negative = np.flatnonzero(lowest < -1e-9 * np.abs(blocks).max(axis=(1, 2)))
    if len(negative):
        i = int(negative[0])
        problems.add(
            where,
            f"{name} is not positive semidefinite: the block of node{i + 1} has the eigenvalue"
            f" {lowest[i]:.6g}",
            name,
        )
    elif ndof <= DENSE_UP_TO:
        values = np.linalg.eigvalsh(matrix.toarray())
        if values[0] < -1e-9 * max(abs(values[-1]), abs(values[0])):
            problems.add(
                where,
                f"{name} is not positive semidefinite: its lowest eigenvalue is {values[0]:.6g},"
                f" its highest {values[-1]:.6g}",
                name,
            )


def _is_free(matrix: Any, R: Array) -> bool:
    """Return whether a matrix gives no force for rigid translations, except for round-off."""
    moved = R[:, :3]
    forces = abs(times(matrix, moved)).max(initial=0.0)
    return bool(forces <= RIGID_FORCE * (abs(matrix) @ abs(moved)).max(initial=0.0))


def _check_free(where: str, K: Sparse, M: Sparse, R: Array, dofs: int) -> None:
    """Warn about rigid motions that store strain energy."""
    energy = np.einsum("ij,ij->j", R, times(K, R))
    scale = np.einsum("ij,ij->j", np.abs(R), times(abs(K), np.abs(R)))
    inertia = np.einsum("ij,ij->j", R, times(M, R))
    bad = np.flatnonzero(energy > RIGID_TOLERANCE * scale)
    if not len(bad):
        return
    hertz = [
        f"{MOTIONS[j]} ({np.sqrt(energy[j] / inertia[j]) / (2.0 * np.pi):.3g} Hz)"
        if inertia[j] > 0.0
        else MOTIONS[j]
        for j in bad
    ]
    hint = "remove supports and springs to ground"
    if bad.min() >= 3:
        hint = "check that the node positions are in m and in the order of the matrices"
    # x of all nodes, then y of all nodes, ...
    other = R.reshape(-1, dofs, 6).transpose(1, 0, 2).reshape(R.shape)
    force = np.abs(times(K, other))
    if force.max() < 1e-6 * times(abs(K), np.abs(other)).max():
        hint = (
            "the rows are ordered by direction (x of all nodes, then y ...): order them node by"
            " node"
        )
    warn(where, f"K is not free: a rigid {some(hertz)} stores strain energy; {hint}", "K")
