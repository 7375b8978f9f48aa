"""Interface and interior, constraint modes and fixed-interface modes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.errors import InputError, Problem, Problems, suggest
from jousto.reduction import eigen
from jousto.reduction.factor import Solver
from jousto.reduction.methods import CraigBampton
from jousto.reduction.rigid import length_scale, rigid_modes
from jousto.reduction.run import Lazy, Report, Run

if TYPE_CHECKING:
    from jousto.parts import Part

Array = NDArray[np.float64]
Index = NDArray[np.intp]

HELD = 1e-7
"""Least independent motion (relative to body size) by which six supports hold a body."""


def dof_label(dof: int, dofs_per_node: int) -> str:
    """Return a name for messages, nodes counted from 1.

    Examples
    --------
    >>> dof_label(8, 6)
    'node2 uz'
    """
    node, kind = divmod(int(dof), dofs_per_node)
    return f"node{node + 1} " + ("ux", "uy", "uz", "rx", "ry", "rz")[kind]


def determinate_dofs(nodes: Array, dofs_per_node: int, candidates: Index) -> Index | None:
    """Return six of the candidate degrees of freedom that hold the body, or None if none do.

    Chosen by pivoted QR of the rigid motions, so that the supports are as independent as possible.
    """
    if len(candidates) < 6:
        return None
    length = length_scale(nodes)
    R = rigid_modes(nodes, dofs_per_node, centre=nodes.mean(axis=0))
    R[:, 3:] /= length
    R[np.arange(len(R)) % dofs_per_node >= 3] *= length
    r, pivots = scipy.linalg.qr(R[candidates].T, mode="r", pivoting=True)
    if abs(r[5, 5]) < HELD * abs(r[0, 0]):
        return None
    return np.sort(candidates[pivots[:6]])


def interface_dofs(part: Part, names: tuple[str, ...]) -> Index:
    """Return the degrees of freedom of the interface nodes, ascending.

    Raises
    ------
    InputError
        An unknown or empty node set, or a node in two interfaces.
    """
    problems = Problems()
    where = f"part '{part.name}'"
    owner: dict[int, str] = {}
    for name in names:
        members = part.node_sets.get(name)
        if members is None:
            problems.add(where, f"no node set '{name}'{suggest(name, part.node_sets)}")
            continue
        if not len(members):
            problems.add(where, f"node set '{name}' is empty, it cannot be an interface")
        for node in members:
            if node in owner and owner[node] != name:
                problems.add(
                    where,
                    f"interfaces '{owner[node]}' and '{name}' share node{node + 1}; keep one",
                )
            owner[int(node)] = name
    problems.raise_if_any()
    d = part.dofs_per_node
    first = d * np.array(sorted(owner), dtype=np.intp)
    return np.asarray((first[:, None] + np.arange(d)).ravel(), dtype=np.intp)


def craig_bampton_basis(
    part: Part, M: sp.csr_array, K: sp.csr_array, method: CraigBampton, run: Run
) -> eigen.Flexibility:
    """Return constraint and fixed-interface modes, held at six interface degrees of freedom.

    With fixed-interface modes of unit stiffness, ``T^T K T = [K_BB + K_BI Phi_C, 0; 0, E]``.

    Raises
    ------
    InputError
        The interface does not hold the body, or there are fewer modes than asked for.
    """
    where = f"part '{part.name}'"
    d = part.dofs_per_node
    ndof = K.shape[0]
    b = interface_dofs(part, method.interfaces)
    i = np.setdiff1d(np.arange(ndof), b)
    held = determinate_dofs(part.nodes, d, b)
    if held is None:
        nodes = len(b) // d
        message = (
            f"the interface {', '.join(method.interfaces)} ({nodes} node{'s'[: nodes != 1]} of "
            f"{d} degrees of freedom) does not hold the body: with nodes that only translate give "
            "at least three interface nodes that are not on one line, or use FreeFree()"
        )
        raise InputError(Problem(where, message))

    # constraint modes Phi_C = -K_II^-1 K_IB
    K_II = sp.csc_array(K[i][:, i])
    K_IB = K[i][:, b]
    solve = Lazy(lambda: run.factorise(K_II, where, lambda k: dof_label(i[k], d)))
    kept = run.found("constraint modes")
    if kept is None:
        solve.prepare()
        with run.stage("constraint modes"):
            Phi_C = -solve(K_IB.toarray())
        run.keep("constraint modes", Phi_C=Phi_C)
    else:
        Phi_C = kept["Phi_C"]
    K_C = K[b][:, b].toarray() + K_IB.T @ Phi_C

    # fixed-interface modes
    kept = run.found("fixed-interface modes")
    if kept is None:
        solve.prepare()
        with run.stage("fixed-interface modes") as report:
            mu, full = _fixed_modes(part, M, i, K_II, solve, method, report)
        run.keep("fixed-interface modes", mu=mu, modes=full)
    else:
        mu, full = kept["mu"], kept["modes"]

    # T without the six columns of the held degrees of freedom
    free = np.flatnonzero(~np.isin(b, held))
    T = np.zeros((ndof, len(free) + len(mu)))
    T[b[free], np.arange(len(free))] = 1.0
    T[np.ix_(i, np.arange(len(free)))] = Phi_C[:, free]
    T[:, len(free) :] = full
    B = np.eye(T.shape[1])
    B[: len(free), : len(free)] = 0.5 * (K_C + K_C.T)[np.ix_(free, free)]
    return eigen.Flexibility(T.shape[1], lambda y: T @ y, lambda f: T.T @ f, B, None)


def _fixed_modes(
    part: Part,
    M: sp.csr_array,
    i: Index,
    K_II: sp.csc_array,
    solve: Solver,
    method: CraigBampton,
    report: Report,
) -> tuple[Array, Array]:
    where = f"part '{part.name}'"
    # modes of all degrees of freedom, zero at the interface: M needs no copy of its interior
    interior = eigen.Flexibility(
        len(i), lambda y: embedded(y, i, M.shape[0]), lambda f: f[i], K_II, solve
    )
    mu, full = eigen.spectrum(
        interior,
        M,
        modes=method.modes,
        frequency_limit=method.frequency_limit,
        where=where,
        report=lambda done: report("fixed-interface modes", done),
    )
    mu, full = eigen.canonical(mu, full, M, part.dofs_per_node, length_scale(part.nodes))
    return eigen.select(mu, full, method.modes, method.frequency_limit, "fixed-interface", where)


def embedded(y: Array, rows: Index, size: int) -> Array:
    """Return y (m, k) at some rows of zeros (size, k)."""
    x = np.zeros((size, y.shape[1]))
    x[rows] = y
    return x


def whole_part_basis(part: Part, K: sp.csr_array, run: Run | None = None) -> eigen.Flexibility:
    """Return all displacements of the part, held at six degrees of freedom.

    Raises
    ------
    InputError
        All nodes lie on a line and do not rotate, or the held stiffness matrix is singular.
    """
    where = f"part '{part.name}'"
    d = part.dofs_per_node
    ndof = K.shape[0]
    held = determinate_dofs(part.nodes, d, np.arange(ndof))
    if held is None:
        message = "the nodes lie on one line and do not rotate: there is no elastic body"
        raise InputError(Problem(where, message))
    free = np.setdiff1d(np.arange(ndof), held)
    K_Z = sp.csc_array(K[free][:, free])
    run = run or Run()
    solve = run.factorise(K_Z, where, lambda k: dof_label(free[k], d))
    return eigen.Flexibility(
        len(free), lambda y: embedded(y, free, ndof), lambda f: f[free], K_Z, solve
    )
