"""Rigid masses on nodes of a solid part, which have no rotations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from jousto.base.arrays import Array, Ints, Sparse, as_csr, scatter, skew
from jousto.base.errors import Problems
from jousto.mesh.sets import node_index
from jousto.parts.mass import MassPoints, PointMass, second_moment


def attached_points(
    problems: Problems,
    where: str,
    masses: Sequence[PointMass],
    nodes: Array,
    node_sets: Mapping[str, tuple[int, ...]],
) -> MassPoints | None:
    """Return mass points for masses on nodes of three degrees of freedom; None without masses.

    A mass on one node has the translation of the node. A mass on several nodes has their mean
    translation and the rotation that fits their displacements best: where ``r`` is measured from
    their mean position, ``theta = (sum r^2 E - r r^T)^-1 sum r x u``. The mass adds no stiffness.
    """
    ndof = 3 * len(nodes)
    position, arm, heavy = [], [], []
    N: list[tuple[Array, Ints]] = []
    turn: list[tuple[Array, Ints]] = []
    for mass in masses:
        at = f"{where}: point mass at {mass.node!r}"
        if isinstance(mass.node, str) and mass.node in node_sets:
            members = np.array(node_sets[mass.node], dtype=np.int64)
        else:
            try:
                members = np.array([node_index(mass.node, node_sets)])
            except KeyError as error:
                problems.add(at, str(error.args[0]))
                continue
            if not 0 <= members[0] < len(nodes):
                problems.add(at, f"the node does not exist, must be in 0..{len(nodes) - 1}")
                continue
        if mass.mass < np.finfo(float).tiny:  # no mass, or one below the smallest normal number
            if np.any(mass.inertia != 0.0):
                problems.add(at, f"has an inertia, but a mass of {mass.mass:g} kg; give a mass")
            continue
        spread = _averages(nodes[members])
        rigid = bool(np.any(mass.inertia != 0.0) or np.any(mass.offset != 0.0))
        if rigid and spread is None:
            problems.add(
                at,
                "has an inertia or an offset, which needs a rotation that nodes of solids do "
                "not have; give a node set of at least three nodes that are not on a line",
            )
            continue
        columns = (3 * members[:, None] + np.arange(3)).ravel()
        mean = np.tile(np.eye(3), len(members)) / len(members)
        rotation = np.zeros_like(mean) if spread is None or not rigid else spread
        N.append((mean - skew(mass.offset) @ rotation, columns))
        turn.append((rotation, columns))
        position.append(nodes[members].mean(axis=0) + mass.offset)
        arm.append(mass.offset)
        heavy.append(mass)
    if problems.found or not heavy:
        return None
    moment = second_moment(np.stack([m.inertia for m in heavy]))
    total = np.array([m.mass for m in heavy], dtype=np.float64)
    N_all, turn_all = _rows(N, ndof), _rows(turn, ndof)
    return MassPoints(total, np.array(position), moment, N_all, turn_all, np.array(arm))


def _averages(x: Array) -> Array | None:
    """Return the rotation (3, 3 m) that fits displacements best; None if it is not determined."""
    if len(x) < 3:
        return None
    r = x - x.mean(axis=0)
    J = np.einsum("ka,ka,bc->bc", r, r, np.eye(3)) - r.T @ r
    values = np.linalg.eigvalsh(J)
    if values[0] < 1e-8 * values[-1]:
        return None
    return np.linalg.solve(J, skew(r).transpose(1, 0, 2).reshape(3, -1))


def _rows(blocks: list[tuple[Array, Ints]], ndof: int) -> Sparse:
    parts = [
        scatter(
            block[None], np.arange(3 * i, 3 * i + 3)[None], columns[None], (3 * len(blocks), ndof)
        )
        for i, (block, columns) in enumerate(blocks)
    ]
    total = parts[0]
    for part in parts[1:]:
        total = total + part
    return as_csr(total)
