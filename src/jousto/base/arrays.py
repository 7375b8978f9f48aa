"""Array types, and small helper functions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from jousto.base.complexstep import floats, is_stepping

A = TypeVar("A", bound=NDArray[Any])

Array = NDArray[np.float64]
Index = NDArray[np.intp]
Ints = NDArray[np.int64]
if TYPE_CHECKING:
    Sparse = scipy.sparse.csr_array[np.float64, tuple[int, int]]
else:
    Sparse = Any

NEXT, LAST = [1, 2, 0], [2, 0, 1]


def read_only(array: ArrayLike) -> Array:
    """Return a contiguous, read-only float copy of an array."""
    return frozen(np.array(floats(array), order="C"))


def frozen(array: A) -> A:
    """Return the same array after it was made read-only."""
    array.setflags(write=False)
    return array


def skew(x: ArrayLike) -> Array:
    """Return the matrices x~ with ``x~ y = x cross y``; shapes (..., 3) -> (..., 3, 3).

    Examples
    --------
    >>> skew([1, 2, 3]) @ [0, 0, 1]
    array([ 2., -1.,  0.])
    """
    x = floats(x)
    out = np.zeros((*x.shape, 3), x.dtype)
    out[..., 0, 1], out[..., 0, 2] = -x[..., 2], x[..., 1]
    out[..., 1, 0], out[..., 1, 2] = x[..., 2], -x[..., 0]
    out[..., 2, 0], out[..., 2, 1] = -x[..., 1], x[..., 0]
    return out


def crossed(a: Array, b: Array) -> Array:
    """Return a cross b, (..., 3); for few vectors much faster than ``numpy.cross``.

    Examples
    --------
    >>> crossed(np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, 1.0]))
    array([ 2., -1.,  0.])
    """
    return np.asarray(a[..., NEXT] * b[..., LAST] - a[..., LAST] * b[..., NEXT])


def transposed(x: Array) -> Array:
    """Return the array with its last two axes exchanged."""
    return np.swapaxes(x, -1, -2)


def as_csr(matrix: object) -> Sparse:
    """Return a float csr array without explicit zeros and with sorted indices.

    A csr array in this form is returned unchanged; other matrices are copied.
    """
    if (
        isinstance(matrix, scipy.sparse.csr_array)
        and (matrix.dtype == np.float64 or is_stepping())
        and matrix.has_canonical_format
        and not np.any(matrix.data == 0.0)
    ):
        return matrix
    kind = (
        np.complex128
        if is_stepping() and getattr(matrix, "dtype", float) == np.complex128
        else np.float64
    )
    out = scipy.sparse.csr_array(matrix, dtype=kind, copy=True)  # type: ignore[call-overload]
    out.sum_duplicates()
    out.eliminate_zeros()
    return out  # type: ignore[no-any-return]


def times(matrix: Sparse, x: Array) -> Array:
    """Return the product of a sparse matrix and a dense vector or matrix."""
    return np.asarray(matrix @ x)


def scatter(blocks: Array, rows: Ints, columns: Ints, shape: tuple[int, int]) -> Sparse:
    """Return the sparse sum of dense blocks (m, r, c) at rows (m, r) and columns (m, c)."""
    i = np.broadcast_to(rows[:, :, None], blocks.shape)
    j = np.broadcast_to(columns[:, None, :], blocks.shape)
    keep = blocks != 0.0
    return as_csr(scipy.sparse.coo_array((blocks[keep], (i[keep], j[keep])), shape=shape).tocsr())


def node_dofs(nodes: Ints, dofs_per_node: int) -> Ints:
    """Return the degrees of freedom of nodes; shapes (..., k) -> (..., k * dofs_per_node)."""
    dofs = nodes[..., None] * dofs_per_node + np.arange(dofs_per_node)
    return dofs.reshape(*nodes.shape[:-1], nodes.shape[-1] * dofs_per_node)


def some(items: list[str], limit: int = 6) -> str:
    """Return the first items joined to one readable text."""
    more = f" and {len(items) - limit} more" if len(items) > limit else ""
    return ", ".join(items[:limit]) + more
