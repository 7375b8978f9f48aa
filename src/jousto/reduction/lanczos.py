"""Block Lanczos iteration for the softest modes of a held body.

It works in flexibility form, ``A y = mu B y`` with ``mu = 1 / omega^2``: the operator
``B^-1 A`` is symmetric in the inner product of B, and its largest eigenvalues, the lowest
frequencies, converge first. Several right-hand sides at a time cost little more than one, and a
block finds as many equal frequencies as it has columns.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.reduction.factor import Solver

Array = NDArray[np.float64]
Apply = Callable[[Array], Array]

BLOCK = 8
"""Columns of a block: the most equal frequencies that are surely found."""

RESIDUAL = 1e-10
"""Largest residual of a mode relative to its mu: mu then is exact to its square."""

ROUND_OFF = 1e-12
"""Part of a direction that is left of it after orthogonalisation when nothing new is in it."""


@dataclass(eq=False)
class _Basis:
    """Orthonormal columns ``Q^T B Q = E``, their products BQ, and ``T = Q^T A Q``."""

    Q: Array
    BQ: Array
    T: Array
    size: int = 0
    # coordinates of what the last block leads to beyond the basis
    R: Array = field(default_factory=lambda: np.zeros((0, 0)))

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
) -> tuple[Array, Array]:
    """Return the largest `count` solutions of ``A y = mu B y``.

    Block Lanczos with full orthogonalisation, restarted with the best vectors found when the basis
    is full (thick restart), and a last projection that repairs rounding.

    Parameters
    ----------
    apply : callable
        ``y (n, m) -> A y``, symmetric positive semidefinite.
    B : (n, n) sparse array
        Symmetric positive definite.
    solve : Solver
        Solves with B.
    count : int
        How many.
    report : callable, optional
        Called after each block with the part of them that has converged, from 0 to 1.

    Returns
    -------
    mu : (count,) array
        Descending.
    Y : (n, count) array
        ``Y^T B Y = E``.
    """
    n = B.shape[0]
    room = min(n, max(2 * count + 8 * BLOCK, 120))
    basis = _Basis(
        np.empty((n, room + BLOCK), order="F"),
        np.empty((n, room + BLOCK), order="F"),
        np.zeros((room + BLOCK, room + BLOCK)),
    )
    # a fixed start makes the result repeatable
    random = np.random.default_rng(20070607)
    W = solve(apply(random.standard_normal((n, BLOCK))))
    W, BW, _ = _orthonormal(basis, W, np.asarray(B @ W))
    basis.append(W, BW)
    new = W.shape[1]
    while True:
        old = slice(basis.size - new, basis.size)
        F = apply(basis.Q[:, old])
        W = solve(F)
        Q, _ = basis.columns()
        T = Q.T @ F
        basis.T[: basis.size, old] = T
        basis.T[old, : basis.size] = T.T
        W, BW, basis.R = _orthonormal(basis, W, F)
        mu, S = np.linalg.eigh(basis.T[: basis.size, : basis.size])
        mu, S = mu[::-1], S[:, ::-1]
        residual = np.linalg.norm(basis.R @ S[old], axis=0)
        wanted = slice(0, min(count, basis.size))
        if report is not None:
            report(float(np.mean(residual[wanted] <= RESIDUAL * mu[wanted])))
        done = basis.size >= count and bool(np.all(residual[wanted] <= RESIDUAL * mu[wanted]))
        if done or not W.shape[1] or basis.size + W.shape[1] > n:
            Q, _ = basis.columns()
            return _projected(apply, B, Q @ S[:, wanted])
        if basis.size + W.shape[1] > room:
            _restart(basis, mu, S, count + BLOCK)
        basis.append(W, BW)
        new = W.shape[1]


def _orthonormal(basis: _Basis, W: Array, BW: Array) -> tuple[Array, Array, Array]:
    """Return W made orthonormal to the basis and in itself, B times it, and R with ``W = . R``."""
    Q, BQ = basis.columns()
    before = np.sqrt(np.abs(np.einsum("ij,ij->j", W, BW)))
    # twice is enough
    for _ in range(2):
        C = BQ.T @ W
        W = W - Q @ C
        BW = BW - BQ @ C
    # column by column within the block; what the basis holds already is left out
    kept: list[int] = []
    R = np.zeros((W.shape[1], W.shape[1]))
    for k in range(W.shape[1]):
        for _ in range(2):
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
    """Return the solution within the span of Y, with true products."""
    A_Y, B_Y = Y.T @ apply(Y), Y.T @ np.asarray(B @ Y)
    mu, S = scipy.linalg.eigh(0.5 * (A_Y + A_Y.T), 0.5 * (B_Y + B_Y.T))
    return mu[::-1], Y @ S[:, ::-1]
