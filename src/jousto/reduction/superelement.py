"""Superelements: matrices condensed by another program."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array, Index
from jousto.base.declare import Declared, maker
from jousto.base.errors import InputError, Problem, Problems, count, warn
from jousto.base.fields import AnyField, field
from jousto.base.numbers import OptionalNumber
from jousto.reduction.fields.invariants import EPS, Invariants
from jousto.reduction.modes.eigen import STAND_IN
from jousto.reduction.modes.rigid import length_scale
from jousto.reduction.reduced import ReducedPart, package_versions

if TYPE_CHECKING:
    from jousto.parts.matrices.matrices import Matrices


DENSE_UP_TO = 6000
"""Largest number of rows of condensed matrices."""

FREE = 1e-6
"""Largest force of a rigid motion / bound from the energies that cancel in it."""

MASSLESS = 1e-13
"""Smallest ``(w_1 / w)^2`` of motions that count as modes; the others have no mass."""


class Condensed(Declared):
    """Reduced part from a condensed model of another program, with orthonormal modes.

    The rows may be nodes with three or six directions, and modal coordinates, as after Guyan or
    Craig-Bampton reduction. With the rigid motions R, ``R^T M R = E``, the modes are those of ``K x
    = w^2 M x`` with ``R^T M x = 0``.

    Mass, centre, inertia, momentum and energy of the modes follow from the matrices exactly. The
    change of the inertia tensor with deformation is left out, since the matrices do not contain the
    distribution of mass between the nodes; this is a relative error of the inertia of the order
    deflection / length.

    Node sets of the reduced part are the node sets of the mesh, and ``n17`` for the node with the
    number 17 in the other program. Without limits the static response to loads on the nodes equals
    that of the superelement.

    Raises
    ------
    InputError
        If the matrices have supports or are too large, K has more free motions than the six rigid
        ones, M has no mass or is indefinite, or no node has three translations.

    Warns
    -----
    JoustoWarning
        If nodes without all three translations are left out.
    """

    matrices: AnyField = field("From `read_matrices`", noun="Matrices", file=False)
    modes: AnyField = field(
        "Number of modes, lowest first; None for all",
        form="count",
        noun="int",
        default=None,
        kw_only=True,
    )
    frequency_limit: OptionalNumber = field(
        "Highest frequency of the modes; None for all", unit="Hz", default=None, kw_only=True
    )

    @property
    def made(self) -> ReducedPart:
        """Reduced part."""
        return _reduced(self.matrices, self.modes, self.frequency_limit)


reduce_superelement = maker("reduce_superelement", Condensed, "ReducedPart")


def _reduced(matrices: Matrices, modes: int | None, frequency_limit: float | None) -> ReducedPart:
    where = f"matrices '{matrices.name}'"
    matrices.check_free()
    rows = matrices.used.astype(np.intp)
    dofs = matrices.dofs[rows]
    n = len(rows)
    if n > DENSE_UP_TO:
        message = (
            f"{n} rows are too many for a condensed model (at most {DENSE_UP_TO}); build a Part "
            f"(Part.from_file) and reduce it"
        )
        raise InputError(Problem(where, message))
    K = sp.csr_array(matrices.K)[rows][:, rows].toarray()
    M = sp.csr_array(matrices.M)[rows][:, rows].toarray()
    _check_symmetric(where, K, M)
    place = {int(number): i for i, number in enumerate(matrices.node_ids)}
    nodal = dofs[:, 1] > 0
    index = np.array([place[int(i)] if c else -1 for i, c in dofs], dtype=np.intp)
    position = np.zeros((n, 3))
    position[nodal] = matrices.nodes[index[nodal]]

    # modal coordinates are zero in rigid motions
    G = np.zeros((n, 6))
    for row in np.flatnonzero(nodal):
        G[row] = _rigid_row(position[row], int(dofs[row, 1]))
    _check_free(where, K, G, position[nodal], dofs)
    R = _orthonormal(where, G, M, position[nodal])
    X, frequencies = _elastic(where, K, M, R, modes, frequency_limit)

    kept, turning = _marker_nodes(where, dofs, index)
    from jousto.parts.matrices.matrices import elements_of, sets_of

    sets = sets_of(matrices, np.asarray(kept, dtype=np.int64))
    sets = {f"node{i + 1}": (i,) for i in range(len(kept))} | sets
    whole = modes is None and frequency_limit is None
    names = tuple(f"n{matrices.node_ids[i]}" for i in kept)
    return ReducedPart(
        name=matrices.name,
        nodes=matrices.nodes[kept],
        elements=np.asarray(elements_of(matrices, np.asarray(kept, dtype=np.int64)), np.intp),
        node_sets=sets,
        modes=_nodal_modes(X, dofs, index, kept, 1),
        rotations=_nodal_modes(X, dofs, index, turning, 4) if len(turning) else None,
        frequencies=frequencies,
        invariants=_invariants(M, G, X),
        interfaces=names if whole else (),
        provenance=_provenance(K, M, dofs, matrices.nodes, modes, frequency_limit),
        rotation_nodes=np.searchsorted(kept, turning) if 0 < len(turning) < len(kept) else None,
    )


def _rigid_row(x: Array, direction: int) -> Array:
    """Return the motion of a row of the matrix in the six rigid motions about the origin."""
    out = np.zeros(6)
    axis = (direction - 1) % 3
    if direction <= 3:
        out[axis] = 1.0
        for a in range(3):
            out[3 + a] = np.cross(np.eye(3)[a], x)[axis]
    else:
        out[3 + axis] = 1.0
    return out


def _check_symmetric(where: str, K: Array, M: Array) -> None:
    problems = Problems()
    for letter, matrix in (("K", K), ("M", M)):
        if not np.all(np.isfinite(matrix)):
            problems.add(where, f"{letter} has values that are not finite numbers")
        elif np.abs(matrix - matrix.T).max() > 1e-8 * np.abs(matrix).max():
            problems.add(where, f"{letter} is not symmetric; check that one triangle is complete")
    problems.raise_if_any()


def _check_free(where: str, K: Array, G: Array, nodes: Array, dofs: NDArray[np.int64]) -> None:
    """Raise InputError if rigid motions cause forces: supports, other axes, wrong positions."""
    scaled = G.copy()
    centre = nodes.mean(axis=0)
    for a in range(3):
        scaled[:, 3 + a] -= G[:, :3] @ np.cross(np.eye(3)[a], centre)
    scaled[:, 3:] /= length_scale(nodes)
    force = np.abs(K @ scaled)
    # no force exceeds sqrt(K_ii) times the root of the energy that cancels in the motion
    energy = np.einsum("ij,ij->j", np.abs(scaled), np.abs(K) @ np.abs(scaled))
    bound = np.sqrt(np.abs(np.diag(K))[:, None] * energy)
    ratio = force / np.maximum(bound, np.finfo(float).tiny)
    row, column = np.unravel_index(int(np.argmax(ratio)), ratio.shape)
    if ratio[row, column] <= FREE:
        return
    kind, axis = ("translation", "rotation")[int(column) // 3], "xyz"[int(column) % 3]
    number, direction = dofs[row]
    label = f"node {number} direction {direction}" if direction else f"modal row {number}"
    raise InputError(
        Problem(
            where,
            f"K is not free: a rigid {kind} ({axis}) leaves a force at {label},"
            f" {ratio[row, column]:.1e} of the upper bound. Condense the part without supports, "
            f"with displacements in basic axes, and check that the positions belong to this model "
            f"and are in the right unit",
        )
    )


def _orthonormal(where: str, G: Array, M: Array, nodes: Array) -> Array:
    """Return rigid motions with ``R^T M R = E``."""
    A = G.T @ M @ G
    m = float(np.trace(A[:3, :3])) / 3.0
    if not m > 0.0:
        raise InputError(
            Problem(where, f"M contains no mass: {m:g} kg; check that it is the mass matrix")
        )
    if np.abs(A[:3, :3] - m * np.eye(3)).max() > 1e-6 * m:
        x, y, z = np.diag(A)[:3]
        message = (
            f"the mass is not the same in all directions: {x:g}, {y:g}, {z:g} kg in x, y, z;"
            " condense the free part, without supports"
        )
        raise InputError(Problem(where, message))
    scale = 1.0 / np.sqrt(np.maximum(np.diag(A), 1e-30))
    values, vectors = np.linalg.eigh(scale[:, None] * A * scale)
    if values[0] < 1e-13 * values[-1]:
        message = "all mass lies on a line or point: the rotation of the body would be undetermined"
        raise InputError(Problem(where, message))
    return np.asarray((G * scale) @ (vectors / np.sqrt(values)))


def _elastic(
    where: str, K: Array, M: Array, R: Array, modes: int | None, frequency_limit: float | None
) -> tuple[Array, Array]:
    """Return mass-normalised elastic modes and their frequencies in Hz, ascending.

    The modes follow from ``(M - MR R^T M) x = mu (K + s MR R^T M) x``. Elastic modes have ``mu =
    1/w^2`` and ``R^T M x = 0``; rigid motions and massless motions have mu = 0.
    """
    MR = M @ R
    gram = MR @ MR.T
    stiff = 0.5 * (K + K.T) + np.trace(K) / np.trace(gram) * gram
    scale = 1.0 / np.sqrt(np.maximum(np.diag(stiff), np.finfo(float).tiny))
    try:
        C = np.linalg.cholesky(scale[:, None] * stiff * scale)
    except np.linalg.LinAlgError:
        message = (
            "K has more free motions than the six of a rigid body (or negative stiffness): rows"
            " without stiffness, or parts that are not connected"
        )
        raise InputError(Problem(where, message)) from None
    mass = scale[:, None] * (0.5 * (M + M.T) - gram) * scale
    half = scipy.linalg.solve_triangular(C, mass, lower=True)
    S = scipy.linalg.solve_triangular(C, half.T, lower=True)
    mu, Y = np.linalg.eigh(0.5 * (S + S.T))
    mu, Y = mu[::-1], Y[:, ::-1]
    if mu[-1] < -1e-8 * mu[0]:
        raise InputError(
            Problem(where, f"M is not positive semidefinite: a mode has the mass {mu[-1]:.2g}")
        )
    good = int(np.sum(mu > MASSLESS * mu[0]))
    frequencies = 1.0 / (2.0 * np.pi * np.sqrt(mu[:good]))
    if frequency_limit is not None:
        good = int(np.sum(frequencies <= frequency_limit))
    if modes is not None:
        if modes > good and frequency_limit is None:
            message = f"{modes} modes are requested, the superelement has {count(good, 'mode')}"
            raise InputError(Problem(where, message, path=("modes",)))
        good = min(good, modes)
    if not good:
        raise InputError(Problem(where, "no elastic mode is left; request more modes"))
    X = scale[:, None] * scipy.linalg.solve_triangular(C.T, Y[:, :good], lower=False)
    X /= np.sqrt(mu[:good])
    if modes is None and frequency_limit is None and good < len(mu):
        Z = scale[:, None] * scipy.linalg.solve_triangular(C.T, Y[:, good:], lower=False)
        X, frequencies = _with_massless(X, frequencies, Z, K)
        good = X.shape[1]
    # the sign is free: let the largest motion be positive
    X *= np.sign(X[np.argmax(np.abs(X), axis=0), np.arange(good)])
    return X, frequencies[:good]


def _with_massless(X: Array, frequencies: Array, Z: Array, K: Array) -> tuple[Array, Array]:
    """Return the modes, then the massless static shapes Z without their rigid motions."""
    energy, turn = np.linalg.eigh(Z.T @ (K @ Z))  # 0 for rigid motions, 1 for others
    still = Z @ turn[:, energy > 0.5]
    still = still @ np.linalg.eigh(still.T @ still)[1]
    fast = frequencies[0] / np.sqrt(STAND_IN)
    w = np.append(frequencies, np.full(still.shape[1], fast))
    X = np.concatenate([X, 2.0 * np.pi * fast * still], axis=1)
    order = np.argsort(w, kind="stable")
    return X[:, order], w[order]


def _invariants(M: Array, G: Array, X: Array) -> Invariants:
    """Return the mass integrals without the terms that the matrices do not determine.

    ``int u0 phi^T dm`` has a known antisymmetric part, the angular momentum, and ``int phi_j
    phi_k^T dm`` a known trace, the modal mass, which is distributed equally over the axes.
    """
    A = G.T @ M @ G
    A = 0.5 * (A + A.T)
    momentum = G.T @ (M @ X)
    J = A[3:, 3:]
    E = (X.T @ (M @ X))[:, :, None, None] / 3.0 * np.eye(3)
    return Invariants(
        mass=float(np.trace(A[:3, :3]) / 3.0),
        first_moment=-0.5 * np.einsum("abc,bc->a", EPS, A[3:, :3]),
        second_moment=0.5 * np.trace(J) * np.eye(3) - J,
        I3=momentum[:3],
        N0=0.5 * np.einsum("abc,aj->jbc", EPS, momentum[3:]),
        E=0.5 * (E + E.transpose(1, 0, 2, 3)),
    )


def _marker_nodes(where: str, dofs: NDArray[np.int64], index: Index) -> tuple[Index, Index]:
    """Return the rows of nodes with all translations, and the rows of nodes with all rotations."""
    have: dict[int, set[int]] = {}
    for i, (_, c) in zip(index, dofs, strict=True):
        if c:
            have.setdefault(int(i), set()).add(int(c))
    complete = sorted(i for i, found in have.items() if found >= {1, 2, 3})
    if not complete:
        message = "no node has all three translations, which joints and forces need"
        raise InputError(Problem(where, message))
    if len(complete) < len(have):
        lost = len(have) - len(complete)
        warn(where, f"{count(lost, 'node')} without all translations cannot carry markers")
    turning = [i for i in complete if have[i] >= {4, 5, 6}]
    return np.array(complete, dtype=np.intp), np.array(turning, dtype=np.intp)


def _nodal_modes(X: Array, dofs: NDArray[np.int64], index: Index, kept: Index, first: int) -> Array:
    """Return the directions first .. first + 2 of the modes at the kept nodes (nk, 3, n)."""
    place = {int(i): k for k, i in enumerate(kept)}
    nodal = np.zeros((len(kept), 3, X.shape[1]))
    for row, (i, (_, c)) in enumerate(zip(index, dofs, strict=True)):
        if first <= c < first + 3 and int(i) in place:
            nodal[place[int(i)], c - first] = X[row]
    return nodal


def _provenance(
    K: Array,
    M: Array,
    dofs: NDArray[np.int64],
    nodes: Array,
    modes: int | None,
    frequency_limit: float | None,
) -> dict[str, str]:
    digest = hashlib.sha256()
    for array in (nodes, K, M):
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    digest.update(np.ascontiguousarray(dofs, dtype="<i8").tobytes())
    method = f"superelement(modes={modes}, frequency_limit={frequency_limit})"
    return {"method": method, "input": "sha256:" + digest.hexdigest(), **package_versions()}
