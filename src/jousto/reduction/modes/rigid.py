"""Rigid motions of a free body: the modes, their removal, and the check that K leaves them free."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, warn

STIFFNESS_FREEDOM = 1e-6
"""Largest nodal force of a rigid motion / forces that cancel in it."""

LINE_ERROR, LINE_WARNING = 1e-14, 1e-12
"""Smallest ratio of the smallest to the largest principal moment of inertia."""


def rigid_modes(
    nodes: Array, dofs_per_node: int, centre: Array | None = None, axes: Array | None = None
) -> Array:
    """Return the six small rigid motions as columns: three translations, three rotations.

    Column a moves every node by ``e_a``, column 3 + a by ``e_a x (x - c)`` and rotates it by
    ``e_a``.

    Parameters
    ----------
    nodes : (nn, 3) array
        Positions in the part frame, m.
    dofs_per_node : int
        6, or 3 for nodes without rotations.
    centre : (3,) array, optional
        Point c that the rotations leave at rest, m; the origin if not given.
    axes : (3, 3) array, optional
        Directions ``e_a`` as columns, in the part frame; the identity if not given.

    Returns
    -------
    (ndof, 6) array
    """
    nn = len(nodes)
    arm = nodes - (np.zeros(3) if centre is None else centre)
    directions = np.eye(3) if axes is None else axes
    modes = np.zeros((nn, dofs_per_node, 6), np.result_type(arm, directions))
    for a in range(3):
        modes[:, :3, a] = directions[:, a]
        modes[:, :3, 3 + a] = np.cross(directions[:, a], arm)
        if dofs_per_node == 6:
            modes[:, 3:, 3 + a] = directions[:, a]
    return modes.reshape(nn * dofs_per_node, 6)


def length_scale(nodes: Array) -> float:
    """Return the size of the body, m: its largest extent, or 1 for a single point."""
    extent = float(np.max(np.ptp(nodes, axis=0)))
    return extent if extent > 0.0 else 1.0


def check_stiffness_is_free(K: sp.csr_array, nodes: Array, dofs_per_node: int, where: str) -> None:
    """Raise InputError unless rigid motions cause no force: ``K R = 0``.

    Each row of K R is compared with the forces that cancel in it, so that a support at one node is
    found for any size of the model and any units.

    Raises
    ------
    InputError
        With node and direction of the largest remaining force.
    """
    R = rigid_modes(nodes, dofs_per_node, centre=nodes.mean(axis=0))
    R[:, 3:] /= length_scale(nodes)
    force = np.abs(K @ R)
    cancelling = abs(K) @ np.abs(R)
    # rows that a motion hardly affects contain only rounding errors: compare them with the other
    # motions
    floor = 1e-3 * cancelling.max(axis=1, keepdims=True)
    ratio = force / np.maximum(np.maximum(cancelling, floor), np.finfo(float).tiny)
    row, column = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    if ratio[row, column] > STIFFNESS_FREEDOM:
        kind = ("translation", "rotation")[int(column) // 3]
        node, dof = divmod(int(row), dofs_per_node)
        name = ("ux", "uy", "uz", "rx", "ry", "rz")[dof]
        raise InputError(
            Problem(
                where,
                f"the stiffness matrix is not free: a rigid {kind} "
                f"({'xyz'[int(column) % 3]}) leaves {ratio[row, column]:.1e} of the nodal force "
                f"at node{node + 1} {name}, must be below {STIFFNESS_FREEDOM:.0e}. Remove supports "
                "and springs to ground before reducing, and check that node coordinates and "
                "matrix are consistent (order, units, digits)",
            )
        )


@dataclass(frozen=True, eq=False)
class RigidBasis:
    """Mass-orthonormal rigid motions R, ``R^T M R = E``.

    Parameters
    ----------
    R : (ndof, 6) array
        The motions.
    MR : (ndof, 6) array
        M times R.
    """

    R: Array
    MR: Array

    def remove(self, X: Array) -> Array:
        """Return ``(E - R R^T M) X``: the columns without their rigid part."""
        # twice, for columns with a large rigid part
        for _ in range(2):
            X = X - self.R @ (self.MR.T @ X)
        return X


def mass_orthonormal_rigid_modes(
    M: sp.csr_array, nodes: Array, dofs_per_node: int, where: str
) -> RigidBasis:
    """Return the rigid motions orthonormal with respect to M.

    The rotations are about the principal axes through the centre of mass, so that a moment of
    inertia far below the others (a slender body about its axis) is computed accurately.

    Raises
    ------
    InputError
        If the mass vanishes, is not the same in all directions, or lies at a point or on a line.
    """
    mass, centre, J = mass_properties(M, nodes, dofs_per_node, where)
    axes = np.linalg.eigh(J)[1]
    R = rigid_modes(nodes, dofs_per_node, centre, axes)
    moments = np.einsum("ij,ij->j", R, M @ R)[3:]
    _check_moments(moments, mass * length_scale(nodes) ** 2, axes, where)

    # remaining coupling terms, scaled to a unit diagonal
    gram = R.T @ (M @ R)
    scale = 1.0 / np.sqrt(np.diag(gram))
    values, vectors = scipy.linalg.eigh(scale[:, None] * gram * scale)
    R = (R * scale) @ (vectors / np.sqrt(values))
    return RigidBasis(R, M @ R)


def mass_properties(
    M: sp.csr_array, nodes: Array, dofs_per_node: int, where: str
) -> tuple[float, Array, Array]:
    """Return mass (kg), centre (3,) (m) and inertia about it (3, 3) (kg m2) from ``R^T M R``.

    Raises
    ------
    InputError
        If the mass is not positive or not the same in x, y and z.
    """
    middle = nodes.mean(axis=0)
    R = rigid_modes(nodes, dofs_per_node, middle)
    G = R.T @ (M @ R)
    G = 0.5 * (G + G.T)
    masses = np.diag(G)[:3]
    mass = float(masses.mean())
    if not mass > 0.0:
        raise InputError(Problem(where, f"the mass is {mass:g} kg, must be positive"))
    if np.abs(G[:3, :3] - mass * np.eye(3)).max() > 1e-6 * mass:
        x, y, z = masses
        raise InputError(
            Problem(
                where,
                f"the mass is not the same in all directions: {x:g}, {y:g}, {z:g} kg in x, y, z. "
                "Give the mass matrix of the free part, without supports",
            )
        )
    # G[3 + a, b] = (c~)_ab m: the skew matrix of the first moment
    first = 0.5 * np.array([G[5, 1] - G[4, 2], G[3, 2] - G[5, 0], G[4, 0] - G[3, 1]])
    offset = first / mass
    J = G[3:, 3:] - mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return mass, middle + offset, J


def _check_moments(moments: Array, reference: float, axes: Array, where: str) -> None:
    largest = float(moments.max())
    remedy = (
        "give the section its rotary inertia (rotary_inertia=True), or add a point mass with "
        "inertia"
    )
    if largest <= LINE_ERROR * reference:
        raise InputError(
            Problem(where, f"all mass lies at one point: there is no inertia about it; {remedy}")
        )
    least = int(np.argmin(moments))
    ratio = float(moments[least]) / largest
    direction = np.array2string(axes[:, least], precision=3, suppress_small=True)
    if ratio < LINE_ERROR:
        raise InputError(
            Problem(
                where,
                f"all mass lies on a line along {direction}: the body has no inertia about it "
                f"({moments[least]:.1e} kg m2 against {largest:.3g} kg m2) and its rotation would "
                f"be undetermined; {remedy}",
            )
        )
    if ratio < LINE_WARNING:
        warn(
            where,
            f"almost all mass lies on a line along {direction}: {moments[least]:.1e} kg m2 about "
            f"it against {largest:.3g} kg m2; {remedy}",
        )
