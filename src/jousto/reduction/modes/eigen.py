"""Eigenproblems in flexibility form, ``M y = mu K y``, exact for massless degrees of freedom.

Vibration modes solve ``K y = omega^2 M y``. A lumped mass matrix without rotary inertia is
singular, so the roles of K and M are exchanged: K is positive definite for a supported body, and
``mu = 1 / omega^2`` is zero for motions without mass, which are left out.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, warn
from jousto.reduction.modes.lanczos import lanczos
from jousto.reduction.sparse.factor import Solver


class MissingModesError(InputError):
    """Error raised if there are fewer modes than requested, or none."""


DENSE_LIMIT = 500
"""Size up to which problems are solved with dense matrices, for all modes."""

ALL_LIMIT = 6000
"""Size above which problems are never solved with dense matrices."""

MASSLESS = 1e-12
"""Smallest mu of modes with mass / largest mu (a million times its frequency)."""

STAND_IN = 1e-8
"""mu of kept motions without mass / largest mu: ten thousand times the lowest frequency. These
motions then respond statically; the relative error of a mode of frequency f is of the order
``(f / 1e4 f_1)^2``."""

CLUSTER = 1e-8
"""Relative difference of mu below which frequencies count as equal."""


@dataclass(frozen=True, eq=False)
class Flexibility:
    """Supported body in coordinates y: stiffness B, positive definite, and displacements ``X0 y``.

    Parameters
    ----------
    size : int
        Length of y.
    lift : callable
        ``y (size, m) -> X0 y (ndof, m)``, the displacements of all degrees of freedom.
    lower : callable
        ``f (ndof, m) -> X0^T f (size, m)``.
    B : (size, size) array or sparse array
        Stiffness.
    solve : Solver or None
        Solver with B; None for problems small enough for dense matrices.
    explicit : callable, optional
        The same body in coordinates for dense matrices; needed if B is positive definite only
        within the subspace of `solve`.
    """

    size: int
    lift: Callable[[Array], Array]
    lower: Callable[[Array], Array]
    B: Array | sp.csc_array
    solve: Solver | None
    explicit: Callable[[], Flexibility] | None = None


def spectrum(
    problem: Flexibility,
    M: sp.csr_array,
    *,
    modes: int | None,
    frequency_limit: float | None,
    where: str,
    report: Callable[[float], None] | None = None,
    massless: bool = False,
) -> tuple[Array, Array]:
    """Solve ``X0^T M X0 y = mu B y`` for at least the requested number of softest modes.

    Parameters
    ----------
    problem : Flexibility
        The pair to solve.
    M : (ndof, ndof) sparse array
        Mass matrix of the lifted displacements.
    modes : int or None
        Number of requested modes.
    frequency_limit : float or None
        Highest requested frequency, Hz.
    where : str
        Name for errors.
    report : callable, optional
        Function called with the fraction of the modes found, 0 to 1.
    massless : bool
        Whether motions without mass are returned too, after the others, with mu = 0; for small
        problems only, ``solve=None``.

    Returns
    -------
    mu : (m,) array
        ``1 / omega^2``, s2, descending; only modes with mass unless `massless`.
    X : (ndof, m) array
        Modes normalised to unit stiffness, ``X^T K X = E``.

    Raises
    ------
    InputError
        If the mass matrix is not positive semidefinite, or modes do not converge.
    """
    if problem.size == 0:
        return np.zeros(0), problem.lift(np.zeros((0, 0)))
    count = modes if modes is not None else 20
    solved = problem
    if problem.solve is None or problem.size <= DENSE_LIMIT or count + 8 > problem.size // 3:
        solved, mu, Y = _dense(problem, M, where)
    else:
        mu, Y = lanczos(_operator(problem, M), problem.B, problem.solve, count + 4, report, where)
        wanted = 0.0 if frequency_limit is None else 1.0 / (2.0 * np.pi * frequency_limit) ** 2
        # without a number, double the count until the limit is passed
        while modes is None and mu[-1] > max(wanted, MASSLESS * mu[0]):
            count *= 2
            if count + 8 > problem.size // 3:
                solved, mu, Y = _dense(problem, M, where)
                break
            mu, Y = lanczos(
                _operator(problem, M), problem.B, problem.solve, count + 4, report, where
            )
    if mu[-1] < -1e-9 * abs(mu[0]):
        raise InputError(
            Problem(
                where,
                "the mass matrix is not positive semidefinite: some motion has negative kinetic "
                f"energy ({mu[-1] / mu[0]:.1e} of the largest)",
            )
        )
    moving = mu > MASSLESS * mu[0]
    mu, X = polish(solved.lift(Y[:, moving]), M)
    if not massless:
        return mu, X
    still = solved.lift(Y[:, ~moving])
    return np.append(mu, np.zeros(still.shape[1])), np.concatenate([X, still], axis=1)


def _operator(problem: Flexibility, M: sp.csr_array) -> Callable[[Array], Array]:
    return lambda y: problem.lower(np.asarray(M @ problem.lift(y)))


def _dense(problem: Flexibility, M: sp.csr_array, where: str) -> tuple[Flexibility, Array, Array]:
    if problem.size > ALL_LIMIT:
        raise InputError(
            Problem(
                where,
                f"more than a third of all {problem.size} modes are requested; request fewer modes "
                "or a lower frequency_limit",
            )
        )
    if problem.explicit is not None:
        problem = problem.explicit()
    X0 = problem.lift(np.eye(problem.size))
    A = X0.T @ (M @ X0)
    B = problem.B if isinstance(problem.B, np.ndarray) else problem.B.toarray()
    # unit diagonal of B, so that Cholesky does not depend on units
    scale = 1.0 / np.sqrt(np.diag(B))
    mu, Y = scipy.linalg.eigh(scale[:, None] * A * scale, scale[:, None] * B * scale)
    return problem, mu[::-1], (scale[:, None] * Y)[:, ::-1]


def polish(X: Array, M: sp.csr_array) -> tuple[Array, Array]:
    """Return mu and modes with full relative accuracy, also for small mu.

    An eigensolver leaves an error of ``eps * mu[0]`` in every mu. Recomputing ``A = X^T M X`` has
    errors of ``eps * sqrt(mu_i mu_j)`` only, and simultaneous Jacobi rotations by
    ``theta_ij = atan(2 A_ij / (mu_j - mu_i)) / 2``, which keep ``X^T K X = E``, remove the
    off-diagonal terms. Equal frequencies are treated in `canonical`.
    """
    for _ in range(8):
        A = X.T @ (M @ X)
        mu = np.diag(A)
        scale = np.sqrt(np.multiply.outer(mu, mu))
        gap = mu[None, :] - mu[:, None]
        apart = np.abs(gap) > CLUSTER * scale
        if np.abs(np.where(apart, A / scale, 0.0)).max(initial=0.0) < 1e-14:
            break  # A belongs to X
        theta = np.where(apart, 0.5 * np.arctan(2.0 * A / np.where(apart, gap, 1.0)), 0.0)
        half = 0.25 * (theta - theta.T)
        # Cayley transform, exactly orthogonal
        E = np.eye(len(mu))
        X = X @ np.linalg.solve(E - half, E + half)
    else:
        mu = np.einsum("ij,ij->j", X, M @ X)
    order = np.argsort(-mu, kind="stable")
    return mu[order], X[:, order]


def clusters(mu: Array) -> list[slice]:
    """Return index ranges of equal frequencies.

    Examples
    --------
    >>> clusters(np.array([4.0, 4.0, 1.0]))
    [slice(0, 2, None), slice(2, 3, None)]
    """
    edges = np.flatnonzero(np.abs(np.diff(mu)) > CLUSTER * mu[:-1]) + 1
    bounds = [0, *(int(e) for e in edges), len(mu)]
    return [slice(a, b) for a, b in zip(bounds[:-1], bounds[1:], strict=True) if b > a]


# largest component of a mode that counts as round-off / largest translation or rotation
ROUND_OFF = 1e-14
DIRECTION_WEIGHTS = np.array([1.0, 2.0, 4.37, 10.1, 13.3, 17.9])


def canonical(
    mu: Array, X: Array, M: sp.csr_array, dofs_per_node: int, length: float
) -> tuple[Array, Array]:
    """Make modes of equal frequency unique, and the signs of all modes.

    Within a cluster the modes are rotated such that they diagonalise the kinetic energy weighted by
    direction, ``sum_a w_a (D_a X)^T M (D_a X)``: the two bending modes of a square beam become
    planar, and components of round-off size become zero. The largest translation (or rotation,
    without translations) of each mode is positive.

    Parameters
    ----------
    mu : (n,) array
        ``1 / omega^2``, descending.
    X : (ndof, n) array
        Modes with ``X^T K X = E``.
    M : (ndof, ndof) sparse array
        Mass matrix.
    dofs_per_node : int
        3 or 6.
    length : float
        Size of the body, m, to compare rotations with translations.
    """
    X = X.copy()
    kind = np.arange(X.shape[0]) % dofs_per_node
    for c in clusters(mu):
        if c.stop - c.start > 1:
            # first orthogonalise with respect to M
            A = X[:, c].T @ (M @ X[:, c])
            values, vectors = np.linalg.eigh(0.5 * (A + A.T))
            block = X[:, c] @ (vectors / np.sqrt(values / values.mean())) @ vectors.T
            W = np.zeros_like(A)
            for a in range(dofs_per_node):
                part = np.where((kind == a)[:, None], block, 0.0)
                W += DIRECTION_WEIGHTS[a] * (part.T @ (M @ part))
            X[:, c] = block @ np.linalg.eigh(W)[1]
    for j in range(X.shape[1]):
        X[:, j] *= _sign(X[:, j], kind, length)
    # set components of round-off size to zero: they would grow in directions without stiffness
    nodal = np.abs(X).reshape(len(X) // dofs_per_node, dofs_per_node, X.shape[1])
    for some in (slice(0, 3), slice(3, None)):
        size = nodal[:, some]
        X.reshape(nodal.shape)[:, some][size < ROUND_OFF * size.max(axis=(0, 1), initial=0.0)] = 0.0
    mu = np.einsum("ij,ij->j", X, M @ X)
    return mu, X


def settled(X: Array, dofs_per_node: int, length: float) -> Array:
    """Make motions without mass unique by their displacements, like `canonical`.

    They are rotated such that they diagonalise ``sum_a w_a (D_a X)^T (D_a X)``, rotations times the
    size of the body; ``X^T K X = E`` remains valid.
    """
    kind = np.arange(X.shape[0]) % dofs_per_node
    weights = DIRECTION_WEIGHTS[kind] * np.where(kind < 3, 1.0, length**2)
    X = X @ np.linalg.eigh(X.T @ (weights[:, None] * X))[1]
    return np.asarray(X * [_sign(x, kind, length) for x in X.T])


def _sign(x: Array, kind: NDArray[np.int_], length: float) -> float:
    size = np.abs(x)
    translation = np.where(kind < 3, size, 0.0)
    rotation = np.where(kind >= 3, size * length, 0.0)
    chosen = translation if translation.max() > 1e-6 * rotation.max() else rotation
    # of equally large components the first one determines the sign
    first = int(np.argmax(chosen >= (1.0 - 1e-6) * chosen.max()))
    return -1.0 if x[first] < 0.0 else 1.0


def select(
    mu: Array, X: Array, modes: int | None, frequency_limit: float | None, kind: str, where: str
) -> tuple[Array, Array]:
    """Return the lowest modes, by number or up to a frequency.

    Raises
    ------
    InputError
        If there are fewer modes than requested.
    """
    if modes is not None and modes > len(mu):
        raise MissingModesError(
            Problem(
                where,
                f"{modes} {kind} modes are requested, but there are only {len(mu)}: motions "
                "without mass (rotations of nodes without rotary inertia) have no frequency; "
                "request "
                "fewer modes, use more elements, or give rotary_inertia=True",
            )
        )
    count = len(mu) if modes is None else modes
    if frequency_limit is not None:
        frequency = 1.0 / (2.0 * np.pi * np.sqrt(mu))
        count = min(count, int(np.searchsorted(frequency, frequency_limit, side="right")))
    if 0 < count < len(mu) and mu[count - 1] - mu[count] < 1e-6 * mu[count]:
        warn(
            where,
            f"{kind} modes {count} and {count + 1} have the same frequency and only the first is "
            f"kept, so that a symmetric body becomes unsymmetric; request one mode more or less",
        )
    return mu[:count], X[:, :count]
