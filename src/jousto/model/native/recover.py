"""Stress fields by the compiled engine: modes in tiles, and a criterion of each tensor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.model.native import library

Longs = NDArray[np.int64]

LANES: int = library.real_library().JO_LANES


def tiles(rows: Array) -> Array:
    """Return rows (ns, r, k) as tiles (ns / 8, k, r, 8), the last one padded with zeros."""
    ns, r, k = rows.shape
    count = -(-ns // LANES)
    padded = rows
    if count * LANES != ns:
        padded = np.zeros((count * LANES, r, k))
        padded[:ns] = rows
    split = padded.reshape(count, LANES, r, k)
    return np.ascontiguousarray(split.transpose(0, 3, 2, 1))


@dataclass(frozen=True, eq=False)
class Recovery:
    """Input of the engine for one criterion of one field.

    Parameters
    ----------
    packed : (ns / 8, k, r, 8) array
        Rows of each mode in `tiles`: those of a norm, or the six components of a tensor.
    ns : int
        Sites.
    criterion : str
        Name of a ``jo_criterion`` without prefix, such as "NORM".
    scale : float
        Factor of the values.
    """

    packed: Array
    ns: int
    criterion: str
    scale: float = 1.0

    def slice(self, first: int, last: int) -> Recovery:
        """Return the sites from `first`, a multiple of 8, up to but without `last`."""
        assert first % LANES == 0
        part = self.packed[first // LANES : -(-last // LANES)]
        return Recovery(part, last - first, self.criterion, self.scale)

    def values(self, p: Array, w: Array | None = None, out: Array | None = None) -> Array:
        """Return the criterion (nt, ns) at coordinates p (nt, k).

        Parameters
        ----------
        p : (nt, k) array
        w : (nt, r) array, optional
            Weights for "WEIGHTED".
        out : (nt, ns) array, optional
            Array that is filled and returned.
        """
        p = np.ascontiguousarray(p, dtype=np.float64)
        if out is None:
            out = np.empty((len(p), self.ns))
        good = out.shape == (len(p), self.ns) and out.dtype == np.float64
        if not good or (out.size and out.strides[1] != 8):
            raise ValueError(f"out must be a float64 array ({len(p)}, {self.ns}) of adjacent sites")
        if out.size:
            real = library.real_library()
            stride = out.strides[0] // 8
            real.jo_recover(*self._arguments(p, w), _pointer("double *", out), stride)
        return out

    def extremes(
        self,
        p: Array,
        first: int,
        low: Array,
        low_at: Longs,
        high: Array,
        high_at: Longs,
        w: Array | None = None,
    ) -> None:
        """Update low and high (ns,) and their instants with values at p; instants from `first`."""
        p = np.ascontiguousarray(p, dtype=np.float64)
        for x in (low, low_at, high, high_at):
            assert x.shape == (self.ns,) and x.flags.c_contiguous and x.itemsize == 8
        library.real_library().jo_recover_extremes(
            *self._arguments(p, w),
            first,
            _pointer("double *", low),
            _pointer("long long *", low_at),
            _pointer("double *", high),
            _pointer("long long *", high_at),
        )

    def _arguments(self, p: Array, w: Array | None) -> tuple[Any, ...]:
        _, k, r, _ = self.packed.shape
        assert p.shape[1] == k and self.packed.flags.c_contiguous
        if w is not None:
            w = np.ascontiguousarray(w, dtype=np.float64)
            assert w.shape == (len(p), r)
        ffi = library.ffi()
        return (
            _pointer("double *", self.packed),
            self.ns,
            r,
            k,
            _pointer("double *", p),
            len(p),
            ffi.NULL if w is None else _pointer("double *", w),
            getattr(library.real_library(), f"JO_{self.criterion}"),
            self.scale,
        )


def principal(tensors: Array) -> tuple[Array, Array]:
    """Return principal values (..., 3), largest first, and directions (..., 3, 3) in columns.

    Parameters
    ----------
    tensors : (..., 6) array
        Components 11 22 33 12 23 13 of symmetric tensors.
    """
    s = np.ascontiguousarray(tensors, dtype=np.float64)
    values = np.empty((*s.shape[:-1], 3))
    directions = np.empty((*s.shape[:-1], 3, 3))
    if s.size:
        library.real_library().jo_principal(
            _pointer("double *", s),
            s.size // 6,
            _pointer("double *", values),
            _pointer("double *", directions),
        )
    return values, directions


def principal_values(tensors: Array) -> Array:
    """Return principal values (..., 3) of tensors (..., 6), largest first."""
    s = np.ascontiguousarray(tensors, dtype=np.float64)
    values = np.empty((*s.shape[:-1], 3))
    if s.size:
        ffi = library.ffi()
        library.real_library().jo_principal(
            ffi.from_buffer("double[]", s),
            s.size // 6,
            ffi.from_buffer("double[]", values),
            ffi.NULL,
        )
    return values


def _pointer(kind: str, array: NDArray[Any]) -> Any:
    return library.ffi().cast(kind, array.__array_interface__["data"][0])
