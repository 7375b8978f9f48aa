"""Windows of time: deviation of modal coordinates from the chord between two instants."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array, Index

BLOCK = 1 << 21  # number of values in memory at a time
UNIT = 2.0**-53  # unit round-off of double precision
SAFETY = 64.0  # upper bound of floating-point operations per value, besides sums


@dataclass(frozen=True, eq=False)
class Windows:
    """Windows of a path y(t) between knots at a constant number of instants.

    Every instant of a window is ``y = (1 - x) y_a + x y_b + d`` with the knots y_a, y_b at its ends
    and 0 <= x <= 1. A convex F with ``|F(s) - F(s')| <= |B (y - y')|`` is at most
    ``max(F(y_a), F(y_b)) + |B d|`` in the window, and ``|B d|`` is at most the smallest of
    ``sum_j |B_j| h_j``, ``reach sqrt(sum_j |B_j|^2 h_j^2)`` and ``|B| far``.

    Attributes
    ----------
    stride : int
        Number of instants between knots.
    knots : (nw + 1, n) array
        The path at the knots.
    h : (nw, n) array
        Largest ``|d_j|`` in each window.
    reach : (nw,) array
        Largest ``sqrt(sum_j (d_j / h_j)^2)``.
    far : (nw,) array
        Largest ``|d|``.
    """

    stride: int
    knots: Array
    h: Array
    reach: Array
    far: Array

    def strays(self, columns: Array, norm: Array) -> Array:
        """Return bounds (nk, nw) of ``|B d|`` for column norms (nk, n) and norms (nk,) of B."""
        out = columns @ self.h.T
        ellipsoid = np.sqrt((columns**2) @ (self.h**2).T)
        ellipsoid *= self.reach
        np.minimum(out, ellipsoid, out=out)
        np.minimum(out, norm[:, None] * self.far, out=out)
        return out

    def strays_of_pairs(self, columns: Array, norm: Array, at: Index) -> Array:
        """Return bounds (np, k) of ``|B d|`` for np sites (np, n), each in k windows (np, k)."""
        h = self.h[at]
        box = np.einsum("pkj,pj->pk", h, columns)
        ellipsoid = np.sqrt(np.einsum("pkj,pj->pk", h**2, columns**2)) * self.reach[at]
        return np.asarray(np.minimum(np.minimum(box, ellipsoid), norm[:, None] * self.far[at]))


def cut_windows(y: Array, stride: int) -> Windows:
    """Return the windows of a path (k stride + 1, n)."""
    count = (len(y) - 1) // stride
    n = y.shape[1]
    h, reach, far = np.empty((count, n)), np.empty(count), np.empty(count)
    rows = max(1, BLOCK // (stride * n))
    for first in range(0, count, rows):
        last = min(first + rows, count)
        inner = y[first * stride : last * stride].reshape(last - first, stride, n)
        a = y[first * stride : last * stride : stride]
        e = y[(first + 1) * stride : last * stride + 1 : stride] - a
        away = inner - a[:, None]
        along = np.einsum("wtj,wj->wt", away, e)
        share = np.clip(along / np.maximum((e**2).sum(axis=1), 1e-300)[:, None], 0.0, 1.0)
        d = np.abs(away - share[:, :, None] * e[:, None])
        top = d.max(axis=1)
        h[first:last] = top
        far[first:last] = np.sqrt((d**2).sum(axis=2)).max(axis=1)
        d /= np.where(top > 0.0, top, 1.0)[:, None]
        reach[first:last] = np.sqrt((d**2).sum(axis=2)).max(axis=1)
    # rounding errors of the lines above, relative to the size of y because of its differences
    n_ops = UNIT * (n + SAFETY)
    h += n_ops * np.abs(y).max(axis=0)
    far += n_ops * np.sqrt((np.abs(y).max(axis=0) ** 2).sum())
    return Windows(stride, np.ascontiguousarray(y[::stride]), h, reach * (1.0 + n_ops), far)


def spectral(B: Array) -> Array:
    """Return upper bounds (nk,) of the 2-norms of matrices B (nk, r, n), at most 1.06 times them.

    ``|B|_2^16 <= trace (B B^T)^8``, the sum of the 8th powers of the eigenvalues of ``B B^T``,
    which costs a few products instead of the eigenvalues.
    """
    A = B @ np.swapaxes(B, 1, 2)
    size = np.maximum(np.einsum("kii->k", A), 1e-300)
    A = A / size[:, None, None]
    for _ in range(2):
        A = A @ A
    trace = np.einsum("kij,kij->k", A, A)
    n_ops = UNIT * (B.shape[2] + SAFETY)
    # rounding error of the trace; after normalisation all values are at most 1
    return np.asarray(np.sqrt(size) * (trace + 8.0 * n_ops) ** 0.0625 * (1.0 + n_ops))
