"""spectrum: the lowest modes of small and of large constrained systems."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.linalg as sl
import scipy.sparse as sp
import scipy.sparse.linalg as spl
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.model.native.native import Engine

blocks: Any = sp.bmat  # Any, since its type information is incomplete
DENSE = 360  # number of unknowns up to which all modes are computed by dense matrices
SYMMETRIC = 1e-6  # skew coupling of modes i, j over sqrt(wi^2 wj^2), below which it is ignored
FLOOR = 1e-14  # skew coupling over the largest omega^2, below which it is ignored
ROUND_OFF = 1e-13  # relative asymmetry of sparse matrices, below which they count as symmetric
RANK = (
    1e-10  # pivot of the scaled constraint matrix over the largest, below which a row is redundant
)
SHIFT = 1e-14  # shift of the eigensolver over the largest stiffness over mass


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Modes ``K x = omega^2 M x`` under ``C x = 0``, sorted by ``|omega^2|``.

    Attributes
    ----------
    squares : (k,) array
        Real part of omega^2, rad2/s2; a mode below 0 is unstable.
    shapes : (n, k) array
        Mode shapes as increments, of unit modal mass.
    """

    squares: NDArray[Any]
    shapes: NDArray[Any]

    @property
    def unstable(self) -> int:
        """Number of unstable modes, omega^2 < 0."""
        return int((np.real(self.squares) < 0.0).sum())


def null_basis(C: Any, n: int) -> Array:
    """Return an orthonormal basis (n, f) of the null space of the constraint rows C (m, n)."""
    rows: Any = C.toarray() if hasattr(C, "toarray") else np.asarray(C)
    size = np.linalg.norm(rows, axis=1) if rows.size else np.zeros(0)
    rows = rows[size > 0.0] / size[size > 0.0, None]
    if not rows.size:
        return np.eye(n)
    Q, R, _ = sl.qr(rows.T, mode="full", pivoting=True, check_finite=False)
    pivots = np.abs(np.diag(R))
    rank = int((pivots > RANK * pivots[0]).sum())
    return np.asarray(Q[:, rank:])


def small_modes(K: Array, M: Array) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return omega^2 (f,) and shapes (f, f) of ``K x = omega^2 M x``, complex for flutter pairs.

    The skew part of K from follower loads is tiny beside the axial stiffness of beams but not
    beside the lowest modes. Therefore the skew part is transformed to the modes of the symmetric
    part; if it couples two of them, the unsymmetric problem is solved in these modes.
    """
    squares, X = sl.eigh(0.5 * (K + K.T), 0.5 * (M + M.T))
    skew = X.T @ (0.5 * (K - K.T)) @ X
    size = np.abs(squares)
    allowed = SYMMETRIC * np.sqrt(np.outer(size, size)) + FLOOR * size.max(initial=0.0)
    if (np.abs(skew) <= allowed).all():
        return squares, X
    values, vectors = sl.eig(np.diag(squares) + skew)
    if not np.iscomplex(values).any():
        values, vectors = np.real(values), np.real(vectors)
    return values, X @ vectors


def lowest_modes(K: Any, M: Any, C: Any, count: int, *, dense: bool | None = None) -> Spectrum:
    """Return the `count` modes of smallest ``|omega^2|`` of ``K x = omega^2 M x``, ``C x = 0``.

    Small systems are solved by dense matrices in the free motions, large ones by shift-invert
    Lanczos or Arnoldi on the saddle-point matrix ``[K - s M, C^T; C, 0]``.

    Parameters
    ----------
    K, M : sparse matrices (n, n)
        Stiffness and mass.
    C : sparse matrix (m, n)
        Constraints.
    count : int
    dense : bool, optional
        Whether to use dense matrices; None decides by the size.
    """
    n, m = K.shape[0], C.shape[0]
    if dense if dense is not None else n + m <= DENSE:
        # scaling to unit mass, since m, rad and modal coordinates differ in size
        unit = 1.0 / np.sqrt(M.diagonal())
        N = unit[:, None] * null_basis(C @ sp.diags(unit), n)
        if not N.shape[1]:
            return Spectrum(np.zeros(0), np.zeros((n, 0)))
        k = N.T @ (K @ N)
        values, vectors = small_modes(k, N.T @ (M @ N))
        order = np.argsort(np.abs(values), kind="stable")[:count]
        return Spectrum(values[order], _unit(N @ vectors[:, order], M))
    return _sparse(K, M, C, count)


def _sparse(K: Any, M: Any, C: Any, count: int) -> Spectrum:
    n, m = K.shape[0], C.shape[0]
    free = n - m
    count = max(1, min(count, free - 2))
    asymmetry = abs(K - K.T).max()
    symmetric = asymmetry <= ROUND_OFF * abs(K).max()
    ratio = float(np.max(np.abs(K.diagonal()) / np.maximum(M.diagonal(), 1e-300)))
    shift = -SHIFT * ratio
    A = K - shift * M
    try:
        solve = saddle(A, C)
    except RuntimeError:
        shift = -1e-9 * ratio
        solve = saddle(K - shift * M, C)
    inverse = spl.LinearOperator((n, n), matvec=lambda b: solve(b), dtype=np.float64)
    start = solve(M @ np.random.default_rng(7).standard_normal(n))
    if symmetric:
        sym = 0.5 * (K + K.T)
        values, vectors = spl.eigsh(
            sym, k=count, M=0.5 * (M + M.T), sigma=shift, OPinv=inverse, v0=start
        )
    else:
        values, vectors = spl.eigs(K, k=count, M=M, sigma=shift, OPinv=inverse, v0=start)
    order = np.argsort(np.abs(values), kind="stable")
    return Spectrum(values[order], _unit(vectors[:, order], M))


def newton_sparse(engine: Engine, ca: float, cv: float, cq: float) -> Any:
    """Return Newton's matrix ``ca M + cv dr/dv + cq dr/dq``, bordered by Cq, as a sparse matrix."""
    made = getattr(engine, "newton_sparse", None)
    if made is not None:
        return made(ca, cv, cq)
    return sp.csr_matrix(engine.newton_matrix(ca, cv, cq))


def saddle(A: Any, C: Any) -> Any:
    """Return a function that solves ``A x + C^T y = b, C x = 0`` for x.

    Raises
    ------
    RuntimeError
        If the matrix is singular.
    """
    n, m = A.shape[0], C.shape[0]
    whole = blocks([[A, C.T], [C, None if not m else _soft(A, C)]], format="csc")
    lu = spl.splu(whole)

    def solve(b: Any) -> Any:
        b = np.concatenate([b, np.zeros(m)])
        x = lu.solve(b)
        # iterative refinement: axial stiffness 1e10 times that of the lowest modes costs 10 digits
        return (x + lu.solve(b - whole @ x))[:n]

    return solve


def _soft(A: Any, C: Any) -> Any:
    """Return the compliance (m, m) of the rows, at round-off, which regularises redundant rows."""
    square = float((C.multiply(C)).sum(axis=1).max()) if C.nnz else 1.0
    stiff = float(abs(A).max())
    return -1e-13 * square / max(stiff, 1e-300) * sp.eye(C.shape[0])


def _unit(shapes: NDArray[Any], M: Any) -> NDArray[Any]:
    size = np.sqrt(np.abs(np.einsum("ij,ij->j", shapes.conj(), M @ shapes)))
    return np.asarray(shapes / np.where(size > 0.0, size, 1.0))
