"""Matrices of machines as sums of blocks of bodies, dense for small machines, sparse for large.

Products are of blocks of single bodies, since large dense products would start threads of BLAS,
which cost more time than the product.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg.lapack import dgetrf, dgetrs
from scipy.sparse.linalg import splu

from jousto.base.arrays import Array, Index

LARGE = 199
"""Number of coordinates above which matrices are sparse."""
CHUNK = 8
"""Number of constraints multiplied at a time."""

Solve = Callable[[Array], Array]


@dataclass(frozen=True, eq=False)
class Term:
    """Matrix ``B^T H B`` with derivatives B of functions by the coordinates of a few bodies.

    Attributes
    ----------
    bodies : int array (k, 2)
        Bodies of both ends of each function; index nb is the ground.
    blocks : array (k, 2, w)
        Derivatives B by the coordinates of these bodies.
    H : array (k, k)
        Inner matrix, e.g. stiffness.
    """

    bodies: Index
    blocks: Array
    H: Array

    def add(self, W: Array | list[tuple[Index, Index, Array]], nb: int) -> None:
        """Add the matrix to a dense one (nb, w, nb, w), or append its blocks to a list."""
        found, place = np.unique(self.bodies, return_inverse=True)
        place = place.reshape(self.bodies.shape)
        w = self.blocks.shape[2]
        B = np.zeros((len(place), len(found), w))
        for side in (0, 1):
            B[np.arange(len(place)), place[:, side]] += self.blocks[:, side]
        if found[-1] == nb:
            found, B = found[:-1], B[:, :-1]
        flat = B.reshape(len(B), -1)
        local = (flat.T @ (self.H @ flat)).reshape(len(found), w, len(found), w)
        p, q = (x.ravel() for x in np.meshgrid(found, found, indexing="ij"))
        blocks = np.swapaxes(local, 1, 2).reshape(-1, w, w)
        if isinstance(W, list):
            W.append((p, q, blocks))
        else:
            W[p, :, q] += blocks


class Ends:
    """Bodies on which functions depend.

    Parameters
    ----------
    bodies : int array (k, e)
        Bodies of every function; index nb is the ground or none.
    nb : int
        Number of bodies.
    """

    def __init__(self, bodies: Index, nb: int) -> None:
        self.bodies, self.nb = bodies, nb
        flat = bodies.ravel()
        moving = np.flatnonzero(flat < nb)
        self.gather = csr(flat[moving], moving, np.ones(len(moving)), (nb, len(flat)))


class Slopes:
    """Derivatives of functions by the coordinates of bodies.

    Parameters
    ----------
    ends : Ends
        Bodies on which each function depends.
    blocks : array (k, e, w)
        Derivatives by the coordinates of each of these bodies.
    """

    def __init__(self, ends: Ends, blocks: Array) -> None:
        self.ends, self.blocks = ends, blocks

    def times(self, v: Array) -> Array:
        """Return the rates (k,) with velocities v (N,)."""
        V = np.zeros((self.ends.nb + 1, self.blocks.shape[2]))
        V[:-1] = v.reshape(self.ends.nb, -1)
        return np.asarray(np.einsum("kew,kew->k", self.blocks, V[self.ends.bodies]))

    def sizes(self, v: Array) -> Array:
        """Return the largest summand (k,) of each rate, the scale of its round-off error."""
        V = np.zeros((self.ends.nb + 1, self.blocks.shape[2]))
        V[:-1] = v.reshape(self.ends.nb, -1)
        return np.asarray(np.abs(self.blocks * V[self.ends.bodies]).max(axis=(1, 2), initial=0.0))

    def pulled(self, f: Array) -> Array:
        """Return the generalised forces (N,) of forces f (k,) along the functions."""
        flat = (f[:, None, None] * self.blocks).reshape(-1, self.blocks.shape[2])
        return np.asarray((self.ends.gather @ flat).ravel())

    def term(self, numbers: Index, H: Array) -> Term:
        """Return the matrix ``B^T H B`` of the scalar functions with given indices."""
        return Term(self.ends.bodies[numbers], self.blocks[numbers], H)


class Layout:
    """Sparsity of a machine: bodies of its scalar functions and constraints.

    Parameters
    ----------
    F : array (m, ns)
        Constraint factors, ``C = F s``.
    bodies : int array (ns, 2)
        Bodies of both ends of every function; index nb is the ground.
    modes : int array (nb,)
        Number of modes of every body.
    w : int
        Number of coordinates per body, with padding.

    Attributes
    ----------
    functions, constraints : Ends
        The two bodies of every function, and the bodies of every constraint.
    """

    def __init__(self, F: Array, bodies: Index, modes: Index, w: int) -> None:
        self.nb, self.w = len(modes), w
        self.F: Any = sp.csr_array(F)
        self.functions = Ends(bodies, self.nb)
        used = np.arange(w) < w - max(modes, default=0) + np.asarray(modes, dtype=int)[:, None]
        self.used = np.flatnonzero(used.ravel())
        self.constraints = Ends(self._held(bodies), self.nb)
        self._pair()

    def rows(self, slopes: Slopes) -> Slopes:
        """Return the derivatives of the constraints from those of the scalar functions."""
        flat = self._select @ slopes.blocks.reshape(-1, self.w)
        shape = (*self.constraints.bodies.shape, self.w)
        return Slopes(self.constraints, np.asarray(flat).reshape(shape))

    def _held(self, bodies: Index) -> Index:
        """Return the bodies (m, k) of every constraint, each once, padded by nb."""
        rows: list[dict[int, int]] = [{} for _ in range(self.F.shape[0])]
        at, which, factors = [], [], []
        entries = self.F.tocoo()
        for r, i, f in zip(entries.row.tolist(), entries.col.tolist(), entries.data, strict=True):
            for side in (0, 1):
                if (body := int(bodies[i, side])) < self.nb:
                    at.append((r, rows[r].setdefault(body, len(rows[r]))))
                    which.append(2 * i + side)
                    factors.append(f)
        k = max(map(len, rows), default=1)
        held = np.full((len(rows), k), self.nb, dtype=np.intp)
        for r, row in enumerate(rows):
            held[r, : len(row)] = list(row)
        slots = np.array([r * k + slot for r, slot in at], dtype=np.intp)
        shape = (held.size, bodies.size)
        self._select = csr(slots, np.array(which, dtype=np.intp), np.array(factors), shape)
        return held

    def _pair(self) -> None:
        """Set the index arrays of the constraint rows of each block of the matrix, in chunks."""
        held = self.constraints.bodies
        m, k = held.shape
        met: dict[tuple[int, int], list[tuple[int, int]]] = {}
        for r, row in enumerate(held.tolist()):
            for i, p in enumerate(row):
                for j, q in enumerate(row):
                    if p <= q < self.nb:
                        met.setdefault((p, q), []).append((r * k + i, r * k + j))
        chunks: list[list[tuple[int, int]]] = []
        self._starts: list[int] = []
        for found in met.values():
            self._starts.append(len(chunks))
            for first in range(0, len(found), CHUNK):
                some = found[first : first + CHUNK]
                chunks.append(some + [(m * k, m * k)] * (CHUNK - len(some)))
        self._left, self._right = np.array(chunks, dtype=np.intp).reshape(-1, CHUNK, 2).T
        self._p, self._q = np.array(list(met), dtype=np.intp).reshape(-1, 2).T
        self._mirrored = np.flatnonzero(self._p < self._q)

    def squares(self, Cq: Slopes, weight: Array) -> tuple[Index, Index, Array]:
        """Return ``Cq^T diag(weight) Cq`` as blocks (w, w) of pairs of bodies.

        Parameters
        ----------
        Cq : Slopes
            Derivatives of constraints.
        weight : array (m,)
            Weight of each constraint.
        """
        rows, w = Cq.blocks, self.w
        none = np.zeros((1, w))
        one = np.concatenate([rows.reshape(-1, w), none])
        other = np.concatenate([(weight[:, None, None] * rows).reshape(-1, w), none])
        # left and right factors (CHUNK, chunks, w)
        left, right = one[self._left.T], other[self._right.T]
        blocks = np.swapaxes(left, 1, 2) @ right
        if len(self._starts):
            blocks = np.add.reduceat(blocks, self._starts, axis=0)
        turned = np.swapaxes(blocks[self._mirrored], 1, 2)
        return (
            np.concatenate([self._p, self._q[self._mirrored]]),
            np.concatenate([self._q, self._p[self._mirrored]]),
            np.concatenate([blocks, turned]),
        )

    def solver(self, M: Array, Cq: Slopes, weight: Array, terms: list[Term]) -> Solve:
        """Return the solver of ``(blockdiag(M) + Cq^T diag(weight) Cq + terms) x = r``.

        Parameters
        ----------
        M : array (nb, w, w)
            Matrices of bodies.
        Cq : Slopes
            Derivatives of the constraints.
        weight : array (m,)
            Weights of the constraints.
        terms : list of Term
            Stiffness and damping terms of forces.
        """
        p, q, blocks = self.squares(Cq, weight)
        each = np.arange(self.nb)
        nb, w, used = self.nb, self.w, self.used
        N = nb * w
        if len(used) <= LARGE:
            W = np.zeros((nb, w, nb, w))
            W[p, :, q] = blocks
            W[each, :, each] += M
            for term in terms:
                term.add(W, nb)
            dense = W.reshape(N, N)
            solve = factorised(dense if len(used) == N else dense[used[:, None], used])
        else:
            parts = [(p, q, blocks), (each, each, M)]
            for term in terms:
                term.add(parts, nb)
            i, j, x = (np.concatenate(part) for part in zip(*parts, strict=True))
            along = np.arange(w)
            row = np.broadcast_to((i[:, None] * w + along)[:, :, None], x.shape)
            column = np.broadcast_to((j[:, None] * w + along)[:, None, :], x.shape)
            entries = (x.ravel(), (row.ravel(), column.ravel()))
            sparse = sp.csc_array(sp.coo_array(entries, shape=(N, N)))
            solve = splu(sparse if len(used) == N else sparse[used][:, used]).solve
        if len(used) == N:
            return solve

        def spread(r: Array) -> Array:
            x = np.zeros(N)
            x[used] = solve(r[used])
            return x

        return spread


def csr(rows: Index, columns: Index, values: Array, shape: tuple[int, int]) -> Any:
    """Return a sparse matrix of given entries."""
    return sp.csr_array(sp.coo_array((values, (rows, columns)), shape=shape))


def factorised(W: Array) -> Solve:
    """Return the solver of ``W x = r`` with a dense matrix."""
    lu, pivots, _ = dgetrf(W.T, overwrite_a=True)  # column order of LAPACK, without a copy
    return lambda r: np.asarray(dgetrs(lu, pivots, r, trans=1)[0])
