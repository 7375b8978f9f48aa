"""How sure the found values are: covariance, intervals, and combinations that cannot be seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.design.identification.unknowns import Unknown
from jousto.design.identification.unseen import Unseen, find_unseen
from jousto.design.identification.whiteness import autocovariance, autoregression


@described
@dataclass(frozen=True, eq=False)
class Certainty:
    """Covariance of the coordinates u at the minimum.

    Attributes
    ----------
    covariance : (p, p) array
        Covariance of u; of unseen unknowns nan.
    within : (p, p) array
        The same with all unknowns, along the directions that are seen.
    plain : (p, p) array
        The same if the residuals were white noise of the given deviation.
    memory : tuple of int
        Order of the autoregression of each comparison's residuals; 0 for white noise.
    hidden : (p, k) array
        Orthonormal basis of the unseen directions of u / size.
    unseen : tuple of Unseen
        Combinations that the measurement does not show.
    seen : (p,) array of bool
        Unknowns that no such combination contains.
    information : (p, k) array
        Share of each comparison in the information about each unknown.
    """

    covariance: Array
    within: Array
    plain: Array
    memory: tuple[int, ...]
    hidden: Array
    unseen: tuple[Unseen, ...]
    seen: NDArray[np.bool_]
    information: Array

    def _facts(self) -> str:
        return f"{int(self.seen.sum())} of {len(self.seen)} unknowns are seen"


def certainty(
    J: Array,
    priors: Array,
    psi: Array,
    curvature: Array,
    sizes: Sequence[int],
    unknowns: Sequence[Unknown],
    u: Array,
    trusted: Sequence[bool],
) -> Certainty:
    """Return how sure the found values are.

    ``C = A^-1 B A^-1``, ``A = sum psi' J_i'J_i + P0^-1``,
    ``B = sum_ik cov(psi)_|i-k| J_i'J_k + P0^-1`` with the covariance of an autoregression of psi
    within each comparison (White, Econometrica 50, 1982); for white noise and the linear loss it is
    ``(J'J + P0^-1)^-1``.

    Parameters
    ----------
    J : (n, p) array
        Derivatives of the residuals by u.
    priors : (m, p) array
        Derivatives of the residuals of priors.
    psi, curvature : (n,) array
        Derivatives of the loss by the residuals: first and second.
    sizes : sequence of int
        Number of samples of each comparison.
    unknowns : sequence of Unknown
    u : (p,) array
        The found coordinates.
    trusted : sequence of bool
        Whether residuals without memory have the deviation of the given noise; else that of psi.
    """
    scale = np.array([own.size for own in unknowns])
    unseen, N = find_unseen(np.vstack([J, priors]) * scale, unknowns, u)
    basis = _complement(N, len(u))
    Js, Ps = J * scale @ basis, priors * scale @ basis
    prior = Ps.T @ Ps
    A = Js.T @ (curvature[:, None] * Js) + prior
    inverse = np.linalg.inv(A) if len(A) else A
    orders: list[int] = []
    B, first = prior.copy(), 0
    for size, trust in zip(sizes, trusted, strict=True):
        rows = slice(first, first + size)
        first += size
        coefficients, spread = autoregression(psi[rows])
        orders.append(len(coefficients))
        if trust and not len(coefficients):
            B += Js[rows].T @ Js[rows]
            continue
        memory = autocovariance(coefficients, spread, size)
        B += Js[rows].T @ _convolved(memory, Js[rows])
    whole = basis @ (inverse @ B @ inverse) @ basis.T * np.outer(scale, scale)
    plain = basis @ inverse @ basis.T * np.outer(scale, scale)
    seen = np.linalg.norm(N, axis=1) < 1e-3 if N.size else np.ones(len(u), dtype=bool)
    within = whole.copy()
    for C in (whole, plain):
        C[~seen, :] = C[:, ~seen] = np.nan
    return Certainty(
        whole, within, plain, tuple(orders), N, unseen, seen, _shares(J * scale, sizes)
    )


def _complement(N: Array, p: int) -> Array:
    """Return an orthonormal basis (p, r) of the directions that are seen."""
    if not N.size:
        return np.eye(p)
    left, _, _ = np.linalg.svd(N, full_matrices=True)
    return np.asarray(left[:, N.shape[1] :])


def _convolved(memory: Array, J: Array) -> Array:
    """Return T J with the symmetric Toeplitz matrix T of a covariance."""
    from scipy.linalg import matmul_toeplitz

    return np.asarray(matmul_toeplitz((memory, memory), J))


def _shares(J: Array, sizes: Sequence[int]) -> Array:
    """Return the share of each comparison in the information about each unknown (p, k)."""
    ends = np.cumsum([0, *sizes])
    each = np.array([(J[a:b] ** 2).sum(axis=0) for a, b in zip(ends[:-1], ends[1:], strict=True)])
    total = each.sum(axis=0)
    return np.asarray((each / np.where(total > 0.0, total, 1.0)).T)
