"""Ritz bases: independent shape functions at the nodes, without rigid motion, with unit energy."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.reduction.modes.rigid import RigidBasis
from jousto.reduction.modes.ties import coordinates

if TYPE_CHECKING:
    from jousto.parts.part import Part

RIGID = 1e-10
"""Root of (strain energy / energies that cancel in it) below which a motion is rigid."""

DEPENDENT = 1e-7
"""Smallest independent part of a function, in the norm of strain energy / function."""

SAME = 1e-10
"""Smallest independent part of a function at the nodes / function."""

ZERO = "zero at all nodes"
SUM = (
    "at the nodes a linear combination of the previous ones; leave it out, ask for a lower "
    "order or number, or refine the mesh"
)
MOVED = "a rigid motion, which the body frame already has; leave it out"
MOVED_SUM = "a linear combination of the previous ones and a rigid motion; leave it out"

SPIN = 1e-10
"""Relative stiffness added against rotations of beam nodes that have no energy."""


@dataclass(frozen=True, eq=False)
class Ritz:
    """Shape functions as vectors of unit strain energy.

    Parameters
    ----------
    Q : (ndof, n) array
        ``Q^T K Q = E``, without rigid motion.
    G : (6, n) array
        Rigid motion in the given functions, which span ``Q + R G``.
    """

    Q: Array
    G: Array


def ritz(part: Part, K: sp.csr_array, rigid: RigidBasis, functions: tuple[Any, ...]) -> Ritz:
    """Return shape functions on the mesh of a part, scaled by the matrices of the part.

    Raises
    ------
    InputError
        With all functions that are not finite, vanish, are rigid motions or linear combinations.
    """
    names, T, family = _at_nodes(part, K, functions)
    weight = np.sqrt(K.diagonal())
    size = np.linalg.norm(weight[:, None] * T, axis=0)
    T = T / np.where(size > 0.0, size, 1.0)
    shift = rigid.MR.T @ T
    E = T - rigid.R @ shift
    again = rigid.MR.T @ E
    E, shift = E - rigid.R @ again, shift + again
    found = Ritz(np.zeros((len(T), 0)), np.zeros((6, 0)))
    raw, KQ = found.Q, found.Q
    faults: dict[tuple[int, str], list[str]] = {}
    for j, name in enumerate(names):
        # independent at the nodes
        rest = _less(weight * T[:, j], raw, raw)
        fault = ZERO if not size[j] > 0.0 else SUM if np.linalg.norm(rest) < SAME else ""
        if not fault:
            raw = np.column_stack([raw, rest / np.linalg.norm(rest)])
            energy = _root(E[:, j], K)
            e, g = E[:, j] / max(energy, RIGID), shift[:, j] / max(energy, RIGID)
            c = KQ.T @ e
            e, g = e - found.Q @ c, g - found.G @ c
            c = KQ.T @ e
            e, g = e - found.Q @ c, g - found.G @ c
            left = _root(e, K)
            if energy >= RIGID and left >= DEPENDENT:
                Q, G = np.column_stack([found.Q, e / left]), np.column_stack([found.G, g / left])
                found, KQ = Ritz(Q, G), np.column_stack([KQ, K @ Q[:, -1]])
            elif not functions[family[j]].whole:
                fault = MOVED if energy < RIGID else MOVED_SUM
        if fault:
            faults.setdefault((family[j], fault), []).append(name)
    problems = Problems()
    for (_, fault), some in faults.items():
        shown = ", ".join(some[:3]) + (f" and {len(some) - 3} more" if len(some) > 3 else "")
        problems.add(
            f"part '{part.name}'", f"shape function{'s'[: len(some) > 1]} {shown}: {fault}"
        )
    problems.raise_if_any()
    if not found.Q.shape[1]:
        message = "its shape functions are rigid motions only; ask for a higher order"
        raise InputError(Problem(f"part '{part.name}'", message))
    return found


def _less(x: Array, basis: Array, dual: Array) -> Array:
    """Return the part of x outside of the basis, with two projections for accuracy."""
    for _ in range(2):
        x = x - basis @ (dual.T @ x)
    return x


def _root(e: Array, K: sp.csr_array) -> float:
    return float(np.sqrt(max(e @ (K @ e), 0.0)))


def _at_nodes(
    part: Part, K: sp.csr_array, functions: tuple[Any, ...]
) -> tuple[list[str], Array, list[int]]:
    """Return names, displacements (ndof, m), and the index of the function of each column."""
    names: list[str] = []
    family: list[int] = []
    found: list[Array] = []
    problems = Problems()
    for number, function in enumerate(functions):
        columns = function.columns(part)
        values = columns.values
        bad = np.argwhere(~np.isfinite(values))
        if len(bad):
            node, _, j = bad[0]
            message = f"shape function {columns.names[j]} is not finite at node{node + 1}"
            problems.add(f"part '{part.name}'", message)
            continue
        if not columns.turned:
            values = _least_energy(K, values)
        names += columns.names
        family += [number] * len(columns.names)
        found.append(values.reshape(len(part.nodes) * part.dofs_per_node, -1))
    problems.raise_if_any()
    T = np.concatenate(found, axis=1)
    z = coordinates(part)
    if z.T is not None:
        # nearest displacements compatible with the rigid ties
        normal = sp.csc_array(z.T.T @ z.T)
        T = z.spread(scipy.sparse.linalg.splu(normal).solve(z.gather(T)))
    return names, T, family


def _least_energy(K: sp.csr_array, values: Array) -> Array:
    """Return displacements (nn, 6, m) with the rotations of minimal strain energy."""
    nn, _, m = values.shape
    moves = np.arange(6 * nn) % 6 < 3
    turning = sp.csr_array(K[~moves][:, ~moves])
    held = sp.csc_array(turning + SPIN * sp.diags_array(turning.diagonal()))
    load = K[~moves][:, moves] @ values[:, :3].reshape(3 * nn, m)
    out = values.copy()
    out[:, 3:] = -scipy.sparse.linalg.splu(held).solve(load).reshape(nn, 3, m)
    return out
