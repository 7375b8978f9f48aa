"""Interface and interior: constraint modes, fixed-interface modes, residual vectors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.reduction.methods import CraigBampton
from jousto.reduction.modes import eigen
from jousto.reduction.modes.fixed_interface_response import (
    Inside,
    cannot_hold,
    determinate,
    rigid_left,
)
from jousto.reduction.modes.residuals import residual_loads, residual_vectors
from jousto.reduction.modes.rigid import length_scale
from jousto.reduction.modes.ties import (
    boundary,
    coordinates,
    embedded,
    interface_names,
)
from jousto.reduction.stages import Report, Run

if TYPE_CHECKING:
    from jousto.parts.part import Part


def dof_label(dof: int, dofs_per_node: int) -> str:
    """Return the name of a degree of freedom for messages, nodes counted from 1.

    Examples
    --------
    >>> dof_label(8, 6)
    'node2 uz'
    """
    node, kind = divmod(int(dof), dofs_per_node)
    return f"node{node + 1} " + ("ux", "uy", "uz", "rx", "ry", "rz")[kind]


def craig_bampton_basis(
    part: Part, M: sp.csr_array, K: sp.csr_array, method: CraigBampton, run: Run
) -> eigen.Flexibility:
    """Return constraint modes, fixed-interface modes and residual vectors, fixed at six motions.

    The vectors are in the coordinates z of ``u = T z``, which rigid ties leave free.
    Fixed-interface modes and residual vectors have unit stiffness, so that the reduced stiffness
    consists of the stiffness of the constraint modes and the identity E.

    Raises
    ------
    InputError
        If the interfaces do not stop all rigid motions, or there are fewer modes than requested.
    """
    where = f"part '{part.name}'"
    d = part.dofs_per_node
    names = interface_names(part, method.interfaces)
    z = coordinates(part)
    b = boundary(part, z, names)
    six = determinate(b.rigid)
    if six is None or (not b.C.shape[0] and rigid_left(z.rigid[b.held]).shape[1]):
        raise cannot_hold(part.name, names, len(b.held) // d, d)
    loads = residual_loads(part, method.residuals)
    if method.inertia_relief:
        loads = np.concatenate([loads, M @ part.rigid_modes()], axis=1)
    inside = Inside(z, b, K, lambda A, *about: run.factorise(A, where, *about))

    kept = run.found("constraint modes")
    if kept is None:
        inside.prepare()
        with run.stage("constraint modes"):
            Phi_C, K_C = inside.constraint_modes()
        run.keep("constraint modes", Phi_C=Phi_C, K_C=K_C)
    else:
        Phi_C, K_C = kept["Phi_C"], kept["K_C"]

    kept = run.found("fixed-interface modes")
    if kept is None:
        inside.prepare()
        with run.stage("fixed-interface modes") as report:
            mu, full = fixed_modes(part, M, inside, method, report)
        run.keep("fixed-interface modes", mu=mu, modes=full)
    else:
        mu, full = kept["mu"], kept["modes"]

    # residual vectors: responses with fixed interfaces minus their projection onto the modes
    if loads.shape[1]:
        kept = run.found("residual vectors")
        if kept is None:
            inside.prepare()
            with run.stage("residual vectors"):
                response = inside.spread(inside.solve(inside.gather(loads)))
                extra = residual_vectors(response, loads, full, K)
            run.keep("residual vectors", vectors=extra)
        else:
            extra = kept["vectors"]
        full = np.concatenate([full, extra], axis=1)

    # T without the six columns of the fixed motions
    free = np.setdiff1d(np.arange(b.size), six)
    n = len(free)
    T = np.zeros((K.shape[0], n + full.shape[1]))
    T[:, n:] = full
    del full
    for start in range(0, n, 64):
        # block by block of columns, since node sets can have very many
        some = free[start : start + 64]
        C = embedded(Phi_C[:, some], inside.rows, z.size)
        own = np.flatnonzero(some < len(b.held))
        C[b.held[some[own]], own] = 1.0
        T[:, start : start + len(some)] = z.spread(C)
    B = np.eye(T.shape[1])
    B[:n, :n] = 0.5 * (K_C + K_C.T)[np.ix_(free, free)]
    return eigen.Flexibility(T.shape[1], lambda y: T @ y, lambda f: T.T @ f, B, None)


def fixed_modes(
    part: Part, M: sp.csr_array, inside: Inside, method: CraigBampton, report: Report
) -> tuple[Array, Array]:
    """Return ``1 / omega^2`` and the fixed-interface modes, with unit stiffness."""
    where = f"part '{part.name}'"
    mu, full = eigen.spectrum(
        inside.problem(),
        M,
        modes=method.modes,
        frequency_limit=method.frequency_limit,
        where=where,
        report=lambda done: report("fixed-interface modes", done),
    )
    mu, full = eigen.canonical(mu, full, M, part.dofs_per_node, length_scale(part.nodes))
    return eigen.select(mu, full, method.modes, method.frequency_limit, "fixed-interface", where)


def whole_part_basis(part: Part, K: sp.csr_array, run: Run | None = None) -> eigen.Flexibility:
    """Return all displacements of a part fixed at six motions that satisfy its rigid ties.

    Raises
    ------
    InputError
        If all nodes lie on a line and have no rotations, or the stiffness matrix of the fixed part
        is singular.
    """
    where = f"part '{part.name}'"
    z = coordinates(part)
    held = determinate(z.rigid)
    if held is None:
        message = (
            "the nodes lie on one line and have no rotations, so that the part is no elastic body"
        )
        raise InputError(Problem(where, message))
    free = np.setdiff1d(np.arange(z.size), held)
    K_Z = sp.csc_array(z.restrict(K)[free][:, free])
    run = run or Run()
    solve = run.factorise(K_Z, where, lambda k: z.label(int(free[k])), z.points[free])
    return eigen.Flexibility(
        len(free),
        lambda y: z.spread(embedded(y, free, z.size)),
        lambda f: z.gather(f)[free],
        K_Z,
        solve,
    )
