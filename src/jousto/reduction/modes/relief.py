"""Inertia relief: static response of a free part whose own acceleration balances the loads."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.object_repr import described
from jousto.parts.part import Part
from jousto.reduction.methods import FreeFree, ShapeFunctions
from jousto.reduction.modes.eigen import Flexibility
from jousto.reduction.modes.partition import whole_part_basis
from jousto.reduction.modes.residuals import residual_loads, residual_vectors
from jousto.reduction.modes.rigid import (
    RigidBasis,
    check_stiffness_is_free,
    mass_orthonormal_rigid_modes,
)
from jousto.reduction.modes.ties import boundary, coordinates


@described
@dataclass(frozen=True, eq=False)
class InertiaRelief:
    """Loads of a free part with balancing inertia forces, and the elastic response.

    Parameters
    ----------
    accelerations : (6, m) array
        Rigid-body acceleration: acceleration of the origin of the part frame in m/s2, and angular
        acceleration in rad/s2, part axes.
    loads : (ndof, m) array
        Balanced loads minus inertia forces, N and N m.
    displacements : (ndof, m) array
        Elastic displacements relative to the mean axes (``R^T M u = 0``), m and rad.
    """

    accelerations: Array
    loads: Array
    displacements: Array


@explained
def inertia_relief(part: Part, loads: ArrayLike) -> InertiaRelief:
    """Return the static response of a free part to loads that accelerate it.

    ``a = (R^T M R)^-1 R^T F``, ``F_ir = F - M R a`` with the rigid motions R about the origin,
    ``K u = F_ir``; ``u`` has no momentum, ``R^T M u = 0``. Rigid ties of the part are satisfied.

    Parameters
    ----------
    part : Part
        The free part.
    loads : (ndof,) or (ndof, m) array_like
        Nodal loads in N and N m, part axes.

    Returns
    -------
    InertiaRelief
        Result with one column per load.

    Raises
    ------
    InputError
        If loads have another shape, or the part is supported or has no inertia.

    Examples
    --------
    A transverse force at the end of a free beam rotates it about its centre: its start accelerates
    with -2 F/m, its end with 4 F/m.

    >>> from jousto import Material, Rectangle
    >>> beam = Part.beam(1.0, Rectangle(0.02, 0.01), 20, Material(210e9, 0.3, 7850.0))
    >>> F = np.zeros(21 * 6)
    >>> F[-4] = 100.0
    >>> f"{inertia_relief(beam, F).accelerations[2, 0] * beam.mass / 100.0:.2f}"
    '-2.00'
    """
    where, problems = f"part '{part.name}'", Problems()
    ndof = part.K.shape[0]
    F = problems.array(where, "loads", loads, (ndof, None) if np.ndim(loads) == 2 else (ndof,))
    problems.raise_if_any()
    assert F is not None
    F = F.reshape(ndof, -1)
    M, K = sp.csr_array(part.M), sp.csr_array(part.K)
    check_stiffness_is_free(K, part.nodes, part.dofs_per_node, where)
    rigid = mass_orthonormal_rigid_modes(M, part.nodes, part.dofs_per_node, where)
    R = part.rigid_modes()
    # the same motions in terms of the six requested ones
    turn = np.linalg.lstsq(_scaled(R), _scaled(rigid.R), rcond=None)[0]
    turn = turn / np.linalg.norm(R, axis=0)[:, None] * np.linalg.norm(rigid.R, axis=0)
    a = rigid.R.T @ F
    balanced = F - rigid.MR @ a
    balanced = balanced - rigid.MR @ (rigid.R.T @ balanced)
    basis = whole_part_basis(part, K)
    return InertiaRelief(turn @ a, balanced, response(balanced, basis, rigid))


def _scaled(R: Array) -> Array:
    return np.asarray(R / np.linalg.norm(R, axis=0))


def response(F: Array, basis: Flexibility, rigid: RigidBasis) -> Array:
    """Return the elastic response of a free part to balanced loads."""
    assert basis.solve is not None
    return rigid.remove(basis.lift(basis.solve(basis.lower(F))))


def free_loads(part: Part, method: FreeFree | ShapeFunctions) -> Array:
    """Return the loads (ndof, m) for attachment modes and residuals of a free part."""
    residual = residual_loads(part, method.residuals)
    if not method.interfaces:
        return residual
    return np.concatenate([unit_loads(part, method.interfaces), residual], axis=1)


def unit_loads(part: Part, interfaces: tuple[str, ...]) -> Array:
    """Return unit forces and moments (ndof, m) on interfaces or on the nodes of node sets."""
    boundary(part, coordinates(part), interfaces)
    ties = {tie.name: tie for tie in part.ties}
    columns = []
    for name in interfaces:
        tie = ties.get(name)
        d = part.dofs_per_node
        if tie is None:
            dofs = np.concatenate([d * i + np.arange(d) for i in part.node_sets[name]])
            unit = np.eye(len(dofs))
        else:
            dofs, unit = tie.dofs, tie.averaging.T
        f = np.zeros((part.K.shape[0], unit.shape[1]))
        f[dofs] = unit
        columns.append(f)
    return np.concatenate(columns, axis=1)


def with_residuals(
    X: Array, loads: Array, elastic: Flexibility, rigid: RigidBasis, K: sp.csr_array
) -> Array:
    """Return free-free modes and the residual of the inertia-relief response to loads.

    Parameters
    ----------
    X : (ndof, n) array
        Modes of unit stiffness without rigid motion.
    loads : (ndof, m) array
        Any loads.
    elastic : Flexibility
        The part without its rigid motions.
    rigid : RigidBasis
        Rigid motions.
    K : (ndof, ndof) sparse array
        Stiffness.
    """
    balanced = loads - rigid.MR @ (rigid.R.T @ loads)
    y = response(balanced, elastic, rigid)
    return np.concatenate([X, residual_vectors(y, balanced, X, K)], axis=1)
