"""Block Lanczos iteration for the lowest modes of a supported body.

The flexibility form ``A y = mu B y`` with ``mu = 1 / omega^2`` is used: the operator
``B^-1 A`` is symmetric in the inner product of B, and its largest eigenvalues, the lowest
frequencies, converge first. Several right-hand sides at a time cost little more than one, and a
block converges to as many equal frequencies as it has columns.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.reduction.sparse.factor import Solver

Apply = Callable[[Array], Array]

BLOCK = 4
"""Columns of a block, and multiplicity of frequencies found without a repetition."""

CLUSTER = 1e-8
"""Relative difference of mu below which frequencies count as equal."""

RESIDUAL = 1e-10
"""Largest residual of a mode / its mu; the relative error of mu is the square of that."""

FLOOR = 1e-13
"""Residual / largest mu at rounding level."""

PATIENCE = 10
"""Number of restarts within which the residuals must decrease."""

PROGRESS = 0.99
"""Relative decrease of the sum of the logarithms of the residuals that counts as progress."""

TOLERABLE = 1e-6
"""Residual / mu that is accepted if rounding prevents a smaller one."""

INTERVAL = 20
"""Inverse relative growth of the basis after which convergence is checked again."""

ROUND_OFF = 1e-12
"""Relative length of a direction after orthogonalisation below which it is dependent."""

SMALL = 1e-9
"""Relative length after orthogonalisation above which no second one is needed."""


@dataclass(eq=False)
class _Basis:
    """Orthonormal columns ``Q^T B Q = E`` with the products BQ and ``T = Q^T A Q``."""

    Q: Array
    BQ: Array
    T: Array
    size: int = 0

    def columns(self) -> tuple[Array, Array]:
        return self.Q[:, : self.size], self.BQ[:, : self.size]

    def append(self, W: Array, BW: Array) -> None:
        new = slice(self.size, self.size + W.shape[1])
        self.Q[:, new], self.BQ[:, new] = W, BW
        self.size += W.shape[1]


def lanczos(
    apply: Apply,
    B: Array | sp.csc_array | sp.csr_array,
    solve: Solver,
    count: int,
    report: Callable[[float], None] | None = None,
    where: str = "eigenvalue problem",
) -> tuple[Array, Array]:
    """Return the largest `count` solutions of ``A y = mu B y``.

    Block Lanczos with full orthogonalisation, thick restart (with the best vectors when the basis
    is full), and a final projection that removes rounding errors. If the multiplicity of a
    frequency reaches the number of columns of a block, the iteration is repeated with wider blocks.
    The iteration continues as long as the residuals decrease.

    Parameters
    ----------
    apply : callable
        ``y (n, m) -> A y``, symmetric positive semidefinite.
    B : (n, n) sparse array
        Symmetric positive definite.
    solve : Solver Solver with B.
    count : int
        Number of solutions.
    report : callable, optional
        Function called with the converged fraction, 0 to 1.
    where : str
        Name for errors.

    Returns
    -------
    mu : (count,) array
        Eigenvalues, descending; fewer if all others are zero.
    Y : (n, count) array
        ``Y^T B Y = E``.

    Raises
    ------
    InputError
        If the iteration does not converge.
    """
    width = BLOCK
    while True:
        mu, Y = _iterate(apply, B, solve, count, width, report, where)
        if _equal(mu) < width or 8 * width > len(Y):
            return mu, Y
        width *= 2


def _equal(mu: Array) -> int:
    """Return the size of the largest group of equal neighbours."""
    ends = np.flatnonzero(np.abs(np.diff(mu)) > CLUSTER * np.abs(mu[:-1])) + 1
    return int(np.diff(np.r_[0, ends, len(mu)]).max(initial=0))


def _iterate(
    apply: Apply,
    B: Array | sp.csc_array | sp.csr_array,
    solve: Solver,
    count: int,
    width: int,
    report: Callable[[float], None] | None,
    where: str,
) -> tuple[Array, Array]:
    n = B.shape[0]
    room = min(n, max(2 * count + 8 * width, 100))
    basis = _Basis(
        np.empty((n, room + width), order="F"),
        np.empty((n, room + width), order="F"),
        np.zeros((room + width, room + width)),
    )
    # a fixed start vector makes the result repeatable
    random = np.random.default_rng(20070607)
    W = np.asfortranarray(solve(apply(random.standard_normal((n, width)))))
    W, BW, _ = _orthonormal(basis, W, B, np.zeros(width))
    basis.append(W, BW)
    new, near = W.shape[1], 0
    due, far, waited = 0, np.inf, 0
    while True:
        old = slice(basis.size - new, basis.size)
        F = apply(basis.Q[:, old])
        W = np.asfortranarray(solve(F))
        Q, _ = basis.columns()
        T = Q.T @ F
        basis.T[: basis.size, old] = T
        basis.T[old, : basis.size] = T.T
        # B W = F
        before = np.sqrt(np.maximum(np.einsum("ij,ij->j", W, F), 0.0))
        # W reaches back only to the previous block (three-term recurrence)
        W -= _combined(Q[:, near:], T[near:])
        W, BW, R = _orthonormal(basis, W, B, before)
        full = not W.shape[1] or basis.size + W.shape[1] > n
        filled = basis.size + W.shape[1] > room
        near = old.start
        # not after every block, since the cost is cubic in the size
        if full or filled or basis.size >= due:
            mu, S = np.linalg.eigh(basis.T[: basis.size, : basis.size])
            mu, S = mu[::-1], S[:, ::-1]
            wanted = slice(0, min(count, basis.size))
            residual = np.linalg.norm(R @ S[old, wanted], axis=0)
            limit = RESIDUAL * mu[wanted] + FLOOR * mu[0]
            found = residual <= limit
            if report is not None:
                report(float(np.sum(found)) / count)
            if full or (basis.size >= count and bool(np.all(found))):
                return _projected(apply, B, Q @ S[:, wanted])
            if filled:
                left = float(np.sum(np.log(np.maximum(residual / limit, 1.0))))
                far, waited = (left, 0) if left < PROGRESS * far else (far, waited + 1)
                if waited >= PATIENCE:
                    tolerable = residual <= np.maximum(limit, TOLERABLE * mu[wanted])
                    _require(int(np.sum(tolerable)), count, where)
                    return _projected(apply, B, Q @ S[:, wanted])
                _restart(basis, mu, S, count + 2 * width)
                near = 0
            due = basis.size + max(width, basis.size // INTERVAL)
        basis.append(W, BW)
        new = W.shape[1]


def _combined(Q: Array, C: Array) -> Array:
    """Return ``Q C``, column after column in memory like the basis."""
    return np.asarray((C.T @ Q.T).T)


def _require(found: int, count: int, where: str) -> None:
    """Raise InputError if not all frequencies have converged."""
    if found < count:
        raise InputError(
            Problem(
                where,
                f"only {found} of {count} frequencies converge, the residuals of the others no "
                f"longer decrease; ask for fewer modes or a lower frequency_limit, and check for "
                f"stiffnesses or masses of very different size, which cause rounding errors",
            )
        )


def _orthonormal(
    basis: _Basis, W: Array, B: Array | sp.csc_array | sp.csr_array, before: Array
) -> tuple[Array, Array, Array]:
    """Return W made orthonormal to the basis and in itself, B W, and R with ``W_given = W R``.

    Columns whose remainder is at round-off level are left out, since they depend on the basis.
    """
    Q, BQ = basis.columns()
    # repeat if little remains, since the remainder then contains round-off
    for _ in range(3 if basis.size else 0):
        C = BQ.T @ W
        W -= _combined(Q, C)
        # in the norm of B, the columns of Q C have the same lengths as the columns of C
        if np.all(np.linalg.norm(C, axis=0) < SMALL * before):
            break
    # explicit product, since errors of a recurrence would grow from block to block
    BW = np.asfortranarray(B @ W)
    kept: list[int] = []
    R = np.zeros((W.shape[1], W.shape[1]))
    for k in range(W.shape[1]):
        for _ in range(2 if kept else 0):
            c = BW[:, kept].T @ W[:, k]
            W[:, k] -= W[:, kept] @ c
            BW[:, k] -= BW[:, kept] @ c
            R[kept, k] += c
        length = np.sqrt(max(float(W[:, k] @ BW[:, k]), 0.0))
        if length > ROUND_OFF * before[k]:
            W[:, k] /= length
            BW[:, k] /= length
            R[k, k] = length
            kept.append(k)
    if len(kept) == len(R):
        return W, BW, R
    return W[:, kept], BW[:, kept], R[kept]


def _restart(basis: _Basis, mu: Array, S: Array, keep: int) -> None:
    Q, BQ = basis.columns()
    keep = min(keep, basis.size)
    basis.Q[:, :keep], basis.BQ[:, :keep] = Q @ S[:, :keep], BQ @ S[:, :keep]
    basis.T[:] = 0.0
    basis.T[range(keep), range(keep)] = mu[:keep]
    basis.size = keep


def _projected(
    apply: Apply, B: Array | sp.csc_array | sp.csr_array, Y: Array
) -> tuple[Array, Array]:
    """Return the solution within the span of Y; products with A and B are computed explicitly."""
    A_Y, B_Y = Y.T @ apply(Y), Y.T @ np.asarray(B @ Y)
    mu, S = scipy.linalg.eigh(0.5 * (A_Y + A_Y.T), 0.5 * (B_Y + B_Y.T))
    return mu[::-1], Y @ S[:, ::-1]
