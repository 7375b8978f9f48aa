"""Inertia shape invariants: all mass integrals in the equations of motion of a modal body.

All invariants follow from six integrals: mass, ``int u0 dm``, ``int u0 u0^T dm``, ``int phi_j dm``,
``int u0 phi_j^T dm`` and ``int phi_j phi_k^T dm``; I1..I9 of Rantalainen 2007 (eqs. 3.49-3.67) are
properties derived from these six, so that they are always consistent.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array, frozen
from jousto.base.complexstep import scalar
from jousto.base.errors import Problems
from jousto.base.object_repr import described
from jousto.reduction.modes.rigid import rigid_modes

if TYPE_CHECKING:
    from jousto.parts.mass import MassPoints


# permutation symbol: (a x b)_i = EPS[i, j, k] a_j b_k
EPS = np.zeros((3, 3, 3))
EPS[0, 1, 2] = EPS[1, 2, 0] = EPS[2, 0, 1] = 1.0
EPS[0, 2, 1] = EPS[2, 1, 0] = EPS[1, 0, 2] = -1.0

SYMMETRY = 1e-9
"""Largest relative asymmetry of U0, and of E[k, j] against E[j, k]^T, that counts as rounding."""


@described
@dataclass(frozen=True, eq=False)
class Invariants:
    """Mass integrals of a body with n modes, resolved in the body frame (inertia shape invariants).

    u0 is the undeformed position of a particle (m), phi_j its displacement in mode j (with
    mass-normalised modes in kg^-0.5).

    Parameters
    ----------
    mass : float
        I1 = ``int dm``, kg.
    first_moment : (3,) array
        I2 = ``int u0 dm``, kg m.
    second_moment : (3, 3) array
        U0 = ``int u0 u0^T dm``, kg m2, symmetric.
    I3 : (3, n) array
        ``int phi_j dm`` in column j, kg^0.5.
    N0 : (n, 3, 3) array
        ``N0[j] = int u0 phi_j^T dm``, kg^0.5 m.
    E : (n, n, 3, 3) array
        ``E[j, k] = int phi_j phi_k^T dm = E[k, j]^T``; ``trace E[j, k]`` is the modal mass matrix.

    Raises
    ------
    InputError
        If shapes are wrong, values are not finite, there is no mass, or a symmetry is violated.
    """

    mass: float
    first_moment: Array
    second_moment: Array
    I3: Array
    N0: Array
    E: Array

    def __post_init__(self) -> None:
        problems = Problems()
        where = "Invariants"
        problems.positive(where, "mass", self.mass, "kg")
        n = int(np.shape(self.I3)[-1]) if np.ndim(self.I3) == 2 else 0
        first = problems.array(where, "first_moment", self.first_moment, (3,))
        second = problems.array(where, "second_moment", self.second_moment, (3, 3))
        I3 = problems.array(where, "I3", self.I3, (3, n))
        N0 = problems.array(where, "N0", self.N0, (n, 3, 3))
        E = problems.array(where, "E", self.E, (n, n, 3, 3))
        if second is not None:
            second = _symmetric(second, second.T, "second_moment is not symmetric", problems)
        if E is not None:
            E = _symmetric(E, E.transpose(1, 0, 3, 2), "E[k, j] is not E[j, k]^T", problems)
        problems.raise_if_any()
        object.__setattr__(self, "mass", scalar(self.mass))
        object.__setattr__(self, "first_moment", first)
        object.__setattr__(self, "second_moment", second)
        object.__setattr__(self, "I3", I3)
        object.__setattr__(self, "N0", N0)
        object.__setattr__(self, "E", E)

    @property
    def n(self) -> int:
        """Number of modes."""
        return int(self.I3.shape[1])

    def __add__(self, other: Invariants) -> Invariants:
        """Return the invariants of the combined mass of two bodies with the same modes."""
        return Invariants(
            self.mass + other.mass,
            self.first_moment + other.first_moment,
            self.second_moment + other.second_moment,
            self.I3 + other.I3,
            self.N0 + other.N0,
            self.E + other.E,
        )

    def keep(self, indices: NDArray[np.intp]) -> Invariants:
        """Return the invariants of selected modes, in the given order."""
        return Invariants(
            self.mass,
            self.first_moment,
            self.second_moment,
            self.I3[:, indices],
            self.N0[indices],
            self.E[np.ix_(indices, indices)],
        )

    def rigid_motion(self, momentum: Array) -> Array:
        """Return the rigid motions (6, m) with given momenta (6, m).

        The motions are translations of the origin and rotations ``[t, theta]``; ``int (t + theta x
        u0) dm`` and ``int u0 x (t + theta x u0) dm`` are the linear and the angular momentum.
        """
        first = np.einsum("abc,b->ac", EPS, self.first_moment)
        M = np.block([[self.mass * np.eye(3), first.T], [first, self.I7]])
        scale = 1.0 / np.sqrt(np.diag(M))[:, None]
        return np.asarray(scale * np.linalg.solve(scale * M * scale.T, scale * momentum))

    @property
    def I1(self) -> float:
        """``int dm``, kg."""
        return self.mass

    @property
    def I2(self) -> Array:
        """``int u0 dm`` (3,), kg m."""
        return self.first_moment

    @property
    def I4(self) -> Array:
        """``int u0~ Phi dm`` (3, n): angular momentum of each mode."""
        return np.asarray(np.einsum("abc,jbc->aj", EPS, self.N0))

    @property
    def I5(self) -> Array:
        """``I5[j] = int phi_j~ Phi dm`` (n, 3, n)."""
        return np.asarray(np.einsum("abc,jkbc->jak", EPS, self.E))

    @property
    def I6(self) -> Array:
        """``int Phi^T Phi dm`` (n, n): the identity for mass-normalised modes."""
        return np.asarray(np.einsum("jkaa->jk", self.E))

    @property
    def I7(self) -> Array:
        """``int u0~^T u0~ dm`` (3, 3): inertia tensor about the frame origin, kg m2."""
        return _tilde_tilde(self.second_moment)

    @property
    def I8(self) -> Array:
        """``I8[j] = int u0~^T phi_j~ dm`` (n, 3, 3)."""
        return _tilde_tilde(self.N0)

    @property
    def I9(self) -> Array:
        """``I9[j, k] = int phi_j~^T phi_k~ dm`` (n, n, 3, 3)."""
        return _tilde_tilde(self.E)


def _symmetric(a: Array, b: Array, message: str, problems: Problems) -> Array:
    size = np.abs(a).max(initial=0.0)
    worst = np.abs(a - b).max(initial=0.0)
    if worst > SYMMETRY * size:
        problems.add("Invariants", f"{message} (difference {worst:.1e} of {size:.1e})")
    return frozen(0.5 * (a + b))


def _tilde_tilde(outer: Array) -> Array:
    # a~^T b~ = (a.b) E - b a^T, from a b^T in the last two axes
    trace = np.trace(outer, axis1=-2, axis2=-1)[..., None, None]
    return np.asarray(trace * np.eye(3) - np.swapaxes(outer, -1, -2))


def outer(tilde_tilde: Array) -> Array:
    """Return ``int a b^T dm`` from ``int a~^T b~ dm``, whose trace is twice ``int a . b dm``."""
    trace = 0.5 * np.trace(tilde_tilde, axis1=-2, axis2=-1)[..., None, None]
    return np.asarray(np.swapaxes(trace * np.eye(3) - tilde_tilde, -1, -2))


def invariants_from_points(points: MassPoints, X: Array) -> Invariants:
    """Return the invariants from mass points with second moments.

    A particle at s in point k moves by ``phi_k + psi_k x s`` with ``phi = N d``,
    ``psi = N_rot d``; with ``G = int s s^T dm`` and ``int s dm = 0`` this gives
    ``E[j, k] = sum m phi_j phi_k^T + psi_j~ G psi_k~^T`` and
    ``N0[j] = sum m x phi_j^T + G psi_j~^T``.

    Parameters
    ----------
    points : MassPoints
        Masses (kg), positions (m), second moments (kg m2) and interpolation.
    X : (ndof, n) array
        Mode shapes.
    """
    n = X.shape[1]
    m = points.mass
    x = points.position
    G = points.second_moment
    phi = np.asarray(points.N @ X).reshape(len(m), 3, n)
    psi = np.asarray(points.N_rot @ X).reshape(len(m), 3, n)
    # psi_j~ as (k, 3, 3, n): [a, b] = EPS[a, c, b] psi_c
    tilde = np.einsum("acb,kcj->kabj", EPS, psi)

    weighted = m[:, None, None] * phi
    N0 = np.einsum("ka,kbj->jab", x, weighted) + np.einsum("kac,kbcj->jab", G, tilde)
    E = np.empty((n, n, 3, 3), np.result_type(weighted, tilde, G))
    G_tilde = np.einsum("kcd,kbdj->kcbj", G, tilde)
    for a in range(3):
        for b in range(3):
            E[:, :, a, b] = weighted[:, a].T @ phi[:, b]
            for c in range(3):
                E[:, :, a, b] += tilde[:, a, c].T @ G_tilde[:, c, b]
    return Invariants(
        mass=scalar(m.sum()),
        first_moment=m @ x,
        second_moment=np.einsum("k,ka,kb->ab", m, x, x) + G.sum(axis=0),
        I3=weighted.sum(axis=0),
        N0=N0,
        E=E,
    )


def invariants_from_matrix(
    M: sp.csr_array, nodes: Array, dofs_per_node: int, X: Array
) -> Invariants:
    """Return the invariants as bilinear forms of the mass matrix.

    With C_a the generator of rotation (it replaces every nodal translation and rotation t by ``e_a
    x t``) and r_a the rigid rotation about axis a, ``I8[j][a, b] = r_a^T M C_b phi_j`` and ``I9[j,
    k][a, b] = (C_a phi_j)^T M (C_b phi_k)``. This is exact for isoparametric elements, whose mass
    matrix is a scalar matrix times the identity. For beams with consistent mass it converges with
    the square of the element length, except for the rotary inertia, which cannot be identified from
    a matrix. Momentum and modal mass are always exact: I3 and I4 follow from ``R^T M phi``, and
    ``trace E[j, k]`` is ``phi_j^T M phi_k``.

    Parameters
    ----------
    M : (ndof, ndof) sparse array
        Mass matrix.
    nodes : (nn, 3) array
        Positions, m.
    dofs_per_node : int
        3 or 6.
    X : (ndof, n) array
        Mode shapes.
    """
    n = X.shape[1]
    R = rigid_modes(nodes, dofs_per_node)
    MR = M @ R
    rigid = R.T @ MR
    rigid = 0.5 * (rigid + rigid.T)
    momentum = MR.T @ X
    # C_b phi_j for the three axes b
    vectors = X.reshape(-1, 3, n)
    turned = [np.einsum("ac,kcj->kaj", EPS[:, b, :], vectors).reshape(-1, n) for b in range(3)]
    mass_turned = [M @ t for t in turned]

    kind = np.result_type(momentum, R)
    I8 = np.empty((n, 3, 3), kind)
    I9 = np.empty((n, n, 3, 3), kind)
    for b in range(3):
        I8[:, :, b] = (R[:, 3:].T @ mass_turned[b]).T
        for a in range(3):
            I9[:, :, a, b] = turned[a].T @ mass_turned[b]
    # the angular momentum determines the antisymmetric part of N0
    N0 = outer(I8)
    N0 = 0.5 * (N0 + N0.transpose(0, 2, 1)) + 0.5 * np.einsum("abc,aj->jbc", EPS, momentum[3:])
    # the modal mass determines the trace of E
    E = outer(I9)
    E = 0.5 * (E + E.transpose(1, 0, 3, 2))
    modal_mass = X.T @ (M @ X)
    excess = 0.5 * (modal_mass + modal_mass.T) - np.einsum("jkaa->jk", E)
    E += excess[:, :, None, None] / 3.0 * np.eye(3)
    return Invariants(
        mass=scalar(np.trace(rigid[:3, :3]) / 3.0),
        first_moment=-0.5 * np.einsum("abc,bc->a", EPS, rigid[3:, :3]),
        second_moment=outer(rigid[3:, 3:]),
        I3=momentum[:3],
        N0=N0,
        E=E,
    )
