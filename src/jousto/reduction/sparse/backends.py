"""Libraries that factorise sparse symmetric positive definite matrices, with one interface.

The arguments of each library are a matrix (both triangles, unit diagonal, sorted, without
duplicates), the position of each unknown (n, 3) for orderings by position, and the available memory
in bytes, which is checked by libraries that can predict their need. Libraries are imported only
when they are used.
"""

from __future__ import annotations

import ctypes
import weakref
from typing import Any, Protocol

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from jousto.base.arrays import Array

PIVOT = 1e-14
"""Smallest allowed pivot of a matrix with unit diagonal."""


class NotPositiveDefinite(Exception):
    """Error raised if a pivot of a factorisation is not positive.

    Parameters
    ----------
    row : int
        Row of the pivot in the order of the matrix; -1 if the library does not report it.
    """

    def __init__(self, row: int = -1) -> None:
        self.row = row
        super().__init__(f"pivot {row}")


class Backend(Protocol):
    """Base of the factors of a matrix."""

    memory: int

    def solve(self, f: Array) -> Array:
        """Return x (n, m) for right-hand sides f (n, m)."""
        ...


class SuperLU:
    """Scipy's SuperLU in symmetric mode."""

    def __init__(
        self, matrix: sp.csr_array, points: Array | None = None, limit: float = np.inf
    ) -> None:
        import scipy.sparse.linalg as spl

        try:
            self._lu = spl.splu(
                sp.csc_array((matrix.data, matrix.indices, matrix.indptr), shape=matrix.shape),
                permc_spec="MMD_AT_PLUS_A",
                diag_pivot_thresh=0.0,
                options={"SymmetricMode": True},
            )
        except RuntimeError:
            raise NotPositiveDefinite from None
        if self._lu.U.diagonal().min() < PIVOT:
            raise NotPositiveDefinite
        self.memory = 12 * int(self._lu.nnz)

    def solve(self, f: Array) -> Array:
        """Return x (n, m) for right-hand sides f (n, m)."""
        return np.asarray(self._lu.solve(np.ascontiguousarray(f)))


class Multifrontal:
    """Cholesky factors of dense fronts, ordered by nested dissection of positions."""

    def __init__(
        self, matrix: sp.csr_array, points: Array | None = None, limit: float = np.inf
    ) -> None:
        from jousto.reduction.sparse.multifrontal import Cholesky, IndefiniteBlock

        if points is None:
            raise RuntimeError("the positions of the unknowns are not known")
        try:
            self._factor = Cholesky(matrix, points, least_pivot=PIVOT, limit=limit)
        except IndefiniteBlock as error:
            raise NotPositiveDefinite(error.row) from None
        self.memory = self._factor.memory

    def solve(self, f: Array) -> Array:
        """Return x (n, m) for right-hand sides f (n, m)."""
        return self._factor.solve(f)


class Pardiso:
    """PARDISO of Intel MKL: nested dissection, supernodal Cholesky factorisation.

    The matrix is symmetric positive definite, with its upper triangle and indices from 0.
    """

    def __init__(
        self, matrix: sp.csr_array, points: Array | None = None, limit: float = np.inf
    ) -> None:
        from jousto.reduction.sparse.mkl import mkl_runtime

        # own function object, so that other users of the library keep their argument types
        self._call: Any = mkl_runtime()["pardiso"]
        self._call.restype = None
        self._call.argtypes = [ctypes.c_void_p] * 16
        self._n = matrix.shape[0]
        self._a, self._ja, self._ia = upper_triangle(matrix)
        self._pt = np.zeros(64, dtype=np.int64)
        self._iparm = np.zeros(64, dtype=np.int32)
        self._iparm[0] = 1  # use the values below
        self._iparm[1] = 2  # nested dissection
        self._iparm[17] = -1  # report the number of entries of the factor
        self._iparm[34] = 1  # indices from 0
        self._release = weakref.finalize(
            self, _free, self._call, self._pt, self._iparm, self._ia, self._ja, self._n
        )
        self._run(11)
        # KiB for the factor and for additional arrays in solves
        self.memory = 1024 * (int(self._iparm[15]) + int(self._iparm[16]))
        if self.memory > limit:
            raise MemoryError(
                f"it needs {self.memory / 2**30:.1f} GiB, this machine has {limit / 2**30:.1f} GiB"
            )
        self._run(22)

    def solve(self, f: Array) -> Array:
        """Return x (n, m) for right-hand sides f (n, m)."""
        f = np.asfortranarray(f)
        x = np.empty(f.shape, order="F")
        self._run(33, f, x)
        return x

    def _run(self, phase: int, f: Array | None = None, x: Array | None = None) -> None:
        error = _pardiso(
            self._call, self._pt, self._iparm, phase, self._n, self._a, self._ia, self._ja, f, x
        )
        if error == -4:
            raise NotPositiveDefinite(int(self._iparm[29]) - 1)
        if error == -2:
            raise MemoryError("PARDISO ran out of memory")
        if error:
            raise RuntimeError(f"PARDISO stopped with error {error} in phase {phase}")


def upper_triangle(
    matrix: sp.csr_array,
) -> tuple[Array, NDArray[np.int32], NDArray[np.int32]]:
    """Return values, column indices and row starts of the upper triangle of a sorted matrix."""
    n = matrix.shape[0]
    rows = np.repeat(np.arange(n, dtype=np.int32), np.diff(matrix.indptr))
    kept = matrix.indices >= rows
    indptr = np.zeros(n + 1, dtype=np.int32)
    np.cumsum(np.bincount(rows[kept], minlength=n), out=indptr[1:])
    return matrix.data[kept], matrix.indices[kept].astype(np.int32, copy=False), indptr


def _pardiso(
    call: Any,
    pt: NDArray[np.int64],
    iparm: NDArray[np.int32],
    phase: int,
    n: int,
    a: Array | None,
    ia: NDArray[np.int32],
    ja: NDArray[np.int32],
    f: Array | None,
    x: Array | None,
) -> int:
    def number(value: int) -> Any:
        return ctypes.byref(ctypes.c_int32(value))

    def address(array: NDArray[Any] | None) -> Any:
        return None if array is None else array.ctypes.data_as(ctypes.c_void_p)

    error = ctypes.c_int32(0)
    call(
        address(pt),
        number(1),
        number(1),
        number(2),  # real, symmetric, positive definite
        number(phase),
        number(n),
        address(a),
        address(ia),
        address(ja),
        None,
        number(1 if f is None else f.shape[1]),
        address(iparm),
        number(0),
        address(f),
        address(x),
        ctypes.byref(error),
    )
    return int(error.value)


def _free(
    call: Any,
    pt: NDArray[np.int64],
    iparm: NDArray[np.int32],
    ia: NDArray[np.int32],
    ja: NDArray[np.int32],
    n: int,
) -> None:
    _pardiso(call, pt, iparm, -1, n, None, ia, ja, None, None)


class NGSolve:
    """The sparse Cholesky factorisation of NGSolve."""

    def __init__(
        self, matrix: sp.csr_array, points: Array | None = None, limit: float = np.inf
    ) -> None:
        from ngsolve import TaskManager
        from ngsolve.la import SparseMatrixd

        n = matrix.shape[0]
        rows = np.repeat(np.arange(n, dtype=np.int32), np.diff(matrix.indptr))
        own = SparseMatrixd.CreateFromCOO(
            rows, matrix.indices.astype(np.int32), np.ascontiguousarray(matrix.data), n, n
        )
        with TaskManager():
            self._inverse = own.Inverse(inverse="sparsecholesky")
        self._f, self._x = own.CreateColVector(), own.CreateColVector()
        # entries of eight bytes; the pattern of supernodes is negligible
        self.memory = 8 * int(self._inverse.nze)

    def solve(self, f: Array) -> Array:
        """Return x (n, m) for right-hand sides f (n, m)."""
        out = np.empty(f.shape)
        for k in range(f.shape[1]):
            self._f.FV().NumPy()[:] = f[:, k]
            self._x.data = self._inverse * self._f
            out[:, k] = self._x.FV().NumPy()
        return out


class Cholmod:
    """CHOLMOD of SuiteSparse by scikit-sparse."""

    def __init__(
        self, matrix: sp.csr_array, points: Array | None = None, limit: float = np.inf
    ) -> None:
        from sksparse import cholmod

        columns = sp.csc_matrix((matrix.data, matrix.indices, matrix.indptr), shape=matrix.shape)
        try:
            # version 0.5 renamed the function for factors
            if hasattr(cholmod, "cho_factor"):
                factor = cholmod.cho_factor(columns, supernodal_mode="supernodal")
                self._solve = factor.solve
            else:
                self._solve = cholmod.cholesky(columns, mode="supernodal")
        except cholmod.CholmodNotPositiveDefiniteError as error:
            raise NotPositiveDefinite(int(getattr(error, "column", -1))) from None
        self.memory = 0

    def solve(self, f: Array) -> Array:
        """Return x (n, m) for right-hand sides f (n, m)."""
        return np.asarray(self._solve(np.asfortranarray(f)))
