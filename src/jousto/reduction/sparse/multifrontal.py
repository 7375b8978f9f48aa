"""Multifrontal Cholesky factorisation: the sparse factor as a tree of dense factors.

Blocks of unknowns are eliminated in an order of nested dissection. The front of a block is the
dense matrix of its own unknowns (index 1) and of the later unknowns coupled with them (index 2),

    ``F11 = L11 L11^T``,  ``L21 = F21 L11^-T``,  ``U = F22 - L21 L21^T``;

U is added to the front of the separator block above. All dense operations are those of LAPACK and
BLAS (Duff and Reid, ACM Trans. Math. Softw. 9 (1983) 302-325; Liu, SIAM Review 34 (1992) 82-109).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from scipy.linalg.blas import dgemm, dsyrk, dtrsm
from scipy.linalg.lapack import dpotrf

from jousto.base.arrays import Array, Index
from jousto.reduction.sparse.dissection import Dissection, dissect


@dataclass(frozen=True, eq=False)
class Front:
    """Block of unknowns from start to stop, in elimination order, and the unknowns coupled with it.

    Parameters
    ----------
    start, stop : int
        Range of the unknowns of the block.
    border : (m,) array
        Later unknowns, ascending.
    parent : int
        Index of the front to which the remainder U is added; -1 for none.
    """

    start: int
    stop: int
    border: Index
    parent: int


class IndefiniteBlock(Exception):
    """Error raised if a pivot is not positive.

    Parameters
    ----------
    row : int
        Row of the pivot in the order of the matrix.
    """

    def __init__(self, row: int) -> None:
        self.row = row
        super().__init__(f"pivot {row}")


class Cholesky:
    """Factor of a sparse symmetric positive definite matrix.

    Parameters
    ----------
    matrix : (n, n) sparse array
        Both triangles.
    points : (n, 3) array
        Position of each unknown.
    least_pivot : float
        Smallest allowed square of a diagonal entry of L.
    limit : float
        Available memory, bytes.

    Raises
    ------
    IndefiniteBlock
        If the matrix is not positive definite.
    MemoryError
        If the factor needs more than the limit; checked before the factorisation.
    """

    def __init__(
        self, matrix: sp.csr_array, points: Array, *, least_pivot: float, limit: float = np.inf
    ) -> None:
        cut = dissect(matrix, points)
        self._order = cut.order
        place = np.empty(len(cut.order), dtype=np.intp)
        place[cut.order] = np.arange(len(cut.order))
        lower = _lower(matrix, place)
        self._fronts = fronts(lower, cut)
        self.memory, needed = _bytes(self._fronts)
        if needed > limit:
            raise MemoryError(
                f"it needs {needed / 2**30:.1f} GiB, this machine has {limit / 2**30:.1f} GiB"
            )
        self._blocks = self._factorised(lower, least_pivot)

    def solve(self, f: Array) -> Array:
        """Return x (n, m) for right-hand sides f (n, m)."""
        x = f[self._order]
        for front, (L11, L21) in zip(self._fronts, self._blocks, strict=True):
            own = slice(front.start, front.stop)
            y = dtrsm(1.0, L11, x[own], lower=1)
            x[own] = y
            if len(front.border):
                x[front.border] -= dgemm(1.0, L21, y)
        for front, (L11, L21) in zip(self._fronts[::-1], self._blocks[::-1], strict=True):
            own = slice(front.start, front.stop)
            y = x[own]
            if len(front.border):
                y = y - dgemm(1.0, L21, x[front.border], trans_a=1)
            x[own] = dtrsm(1.0, L11, y, lower=1, trans_a=1)
        out = np.empty_like(x)
        out[self._order] = x
        return out

    def _factorised(self, lower: sp.csc_array, least_pivot: float) -> list[tuple[Array, Array]]:
        """Return L11 and L21 of each front."""
        blocks = []
        waiting: dict[int, list[tuple[Index, Array]]] = {}
        for number, front in enumerate(self._fronts):
            # assemble the front: entries of the matrix, remainders of earlier fronts
            F11, F21, F22 = _entries(lower, front)
            for border, U in waiting.pop(number, []):
                _extend(front, F11, F21, F22, border, U)
            # F11 = L11 L11^T
            L11, info = dpotrf(F11, lower=1, clean=1, overwrite_a=1)
            bad = np.flatnonzero(np.diagonal(L11) ** 2 < least_pivot) if info == 0 else [info - 1]
            if len(bad):
                raise IndefiniteBlock(int(self._order[front.start + bad[0]]))
            # L21 = F21 L11^-T, U = F22 - L21 L21^T
            L21 = F21
            if len(front.border):
                L21 = dtrsm(1.0, L11, F21, side=1, lower=1, trans_a=1, overwrite_b=1)
                U = dsyrk(-1.0, L21, beta=1.0, c=F22, lower=1, overwrite_c=1)
                waiting.setdefault(front.parent, []).append((front.border, U))
            blocks.append((L11, L21))
        return blocks


def _lower(matrix: sp.csr_array, place: Index) -> sp.csc_array:
    """Return the lower triangle of the matrix in the order of elimination."""
    coo = matrix.tocoo()
    row, column = place[coo.row], place[coo.col]
    kept = row >= column
    found = sp.coo_array((coo.data[kept], (row[kept], column[kept])), shape=matrix.shape)
    return sp.csc_array(found)


def fronts(lower: sp.csc_array, cut: Dissection) -> list[Front]:
    """Return the fronts: unknowns coupled with each block, directly or by earlier eliminations."""
    out: list[Front] = []
    touched: dict[int, list[Index]] = {}
    for number, parent in enumerate(cut.parents):
        start, stop = int(cut.starts[number]), int(cut.starts[number + 1])
        own = lower.indices[lower.indptr[start] : lower.indptr[stop]]
        rows = np.unique(np.concatenate([own, *touched.pop(number, [])]))
        border = rows[np.searchsorted(rows, stop) :].astype(np.intp)
        out.append(Front(start, stop, border, int(parent)))
        touched.setdefault(int(parent), []).append(border)
    return out


def _bytes(tree: list[Front]) -> tuple[int, int]:
    """Return the bytes of the factor, and the largest total memory of the factorisation."""
    factor = stack = most = 0
    waiting: dict[int, int] = {}
    for number, front in enumerate(tree):
        k, m = front.stop - front.start, len(front.border)
        factor += 8 * k * (k + m)
        stack += 8 * m * m
        most = max(most, factor + stack)
        stack -= waiting.pop(number, 0)
        waiting[front.parent] = waiting.get(front.parent, 0) + 8 * m * m
    return factor, most


def _entries(lower: sp.csc_array, front: Front) -> tuple[Array, Array, Array]:
    """Return the entries of the matrix in F11 and F21, and a zero matrix F22."""
    k, m = front.stop - front.start, len(front.border)
    F11, F21, F22 = (np.zeros(shape, order="F") for shape in ((k, k), (m, k), (m, m)))
    part = slice(lower.indptr[front.start], lower.indptr[front.stop])
    rows, values = lower.indices[part], lower.data[part]
    columns = np.repeat(np.arange(k), np.diff(lower.indptr[front.start : front.stop + 1]))
    own = rows < front.stop
    F11[rows[own] - front.start, columns[own]] = values[own]
    F21[np.searchsorted(front.border, rows[~own]), columns[~own]] = values[~own]
    return F11, F21, F22


def _extend(front: Front, F11: Array, F21: Array, F22: Array, border: Index, U: Array) -> None:
    """Add the remainder U of an earlier front, whose unknowns are `border`."""
    inner = int(np.searchsorted(border, front.stop))
    i = border[:inner] - front.start
    j = np.searchsorted(front.border, border[inner:])
    for target, rows, columns, values in (
        (F11, i, i, U[:inner, :inner]),
        (F21, j, i, U[inner:, :inner]),
        (F22, j, j, U[inner:, inner:]),
    ):
        # transposed, since the columns of these arrays are contiguous
        target.T[np.ix_(columns, rows)] += values.T
