"""Response of the interior of a part to loads with fixed interfaces.

Nodes and rigid ties are fixed by removing their coordinates. Averages are fixed by forces ``C^T
lam`` instead. The response follows from one sparse factorisation of the part, pinned at a few more
coordinates if necessary, and one small dense system:

    ``F f = Z f - W S^-1 W^T f``,  ``W = [Z C^T, N]``,  ``S = [C Z C^T, C N; N^T C^T, 0]``,

where Z is the solution with the pins and N are the rigid motions left free by the interfaces: the
forces on the pins vanish, ``N^T (f + C^T lam) = 0``, and so do the averages, ``C F f = 0``. F is
symmetric and does not depend on the pins.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy.linalg
import scipy.sparse as sp

from jousto.base.arrays import Array, Index
from jousto.base.errors import InputError, Problem
from jousto.reduction.modes import eigen
from jousto.reduction.modes.ties import Boundary, Coordinates, embedded
from jousto.reduction.sparse.factor import Solver

HELD = 1e-7
"""Smallest independent motion (relative to body size) of the supports that fix a body."""


class Inside:
    """Interior of a part: its free coordinates if the interfaces are fixed.

    Parameters
    ----------
    z, b : Coordinates, Boundary
        Coordinates and interfaces.
    K : (ndof, ndof) sparse array
        Stiffness of the part.
    factorise : callable
        Function ``(matrix, name of an unknown, positions of the unknowns) -> solve``.

    Attributes
    ----------
    rows : (ni,) array
        Free coordinates z.
    K_II : (ni, ni) sparse array
        Stiffness of the free coordinates.
    C : (na, ni) sparse array
        Averages of the free coordinates.
    """

    def __init__(
        self,
        z: Coordinates,
        b: Boundary,
        K: sp.csr_array,
        factorise: Callable[[sp.csc_array, Callable[[int], str], Array], Solver],
    ) -> None:
        self.z, self.b = z, b
        self.rows = np.setdiff1d(np.arange(z.size), b.held)
        self._factorise = factorise
        K_z, inside, held = K, z.dof[self.rows], z.columns(b.held)
        if np.any(inside < 0):
            # a rigid tie that is not an interface: its reference node belongs to the interior
            K_z, inside = z.restrict(K), self.rows
            held = sp.csr_array(sp.eye_array(z.size, format="csr")[:, b.held])
        K_I, K_T = K_z[inside], sp.csr_array(K_z @ held)
        self.K_II = sp.csc_array(K_I[:, inside])
        self.K_IB, self.K_BB = K_T[inside], sp.csr_array(held.T @ K_T)
        self.C = sp.csr_array(b.C[:, self.rows])
        # as many pins remove the rigid motions that the fixed coordinates leave free
        rest = rigid_left(z.rigid[b.held])
        self._N = z.motions[self.rows] @ rest
        self._free = np.arange(len(self.rows))
        if rest.shape[1]:
            comparable = z.rigid[self.rows] @ rest
            _, pivots = scipy.linalg.qr(comparable.T, mode="r", pivoting=True)
            self._free = np.setdiff1d(self._free, pivots[: rest.shape[1]])
        self._Z: Solver | None = None
        self._W = np.zeros((len(self.rows), 0))
        self._small: Callable[[Array], Array] = lambda f: f

    def prepare(self) -> None:
        """Factorise the stiffness, if not done before."""
        if self._Z is not None:
            return
        f, r = self._free, self._N.shape[1]
        pinned = self.K_II if not r else sp.csc_array(self.K_II[f][:, f])
        numbers = self.rows[f]
        self._Z = self._factorise(
            pinned, lambda k: self.z.label(int(numbers[k])), self.z.points[numbers]
        )
        na = self.C.shape[0]
        if not na:
            return
        Y = np.zeros((len(self.rows), na))
        Y[f] = self._Z(self.C.T.toarray()[f])
        self._W = np.concatenate([Y, self._N], axis=1)
        S = np.zeros((na + r, na + r))
        S[:na] = self.C @ self._W
        S[:na, :na] = 0.5 * (S[:na, :na] + S[:na, :na].T)
        S[na:, :na] = S[:na, na:].T
        self._small = _solver(S)

    def solve(self, f: Array, /) -> Array:
        """Return the response F f to loads (ni,) or (ni, m) on the interior."""
        self.prepare()
        assert self._Z is not None
        na = self.C.shape[0]
        if not na:
            return self._Z(f)
        y = np.zeros(f.shape)
        y[self._free] = self._Z(f[self._free])
        return y - self._W @ self._small(np.concatenate([self.C @ y, self._N.T @ f]))

    def constraint_modes(self) -> tuple[Array, Array]:
        """Return interior displacements (ni, nb + na) for unit interface motions, and stiffness.

        ``Phi_C = [-F K_IB, U]`` with U for the averages, ``K_C = Phi^T K Phi``.
        """
        Phi = -self.solve(self.K_IB.toarray())
        K_C = self.K_BB.toarray() + self.K_IB.T @ Phi
        na = self.C.shape[0]
        if not na:
            return Phi, K_C
        x = self._small(np.eye(self._W.shape[1])[:, :na])
        U, K_A = self._W @ x, 0.5 * (x[:na] + x[:na].T)
        K_BA = self.K_IB.T @ U
        return np.concatenate([Phi, U], axis=1), np.block([[K_C, K_BA], [K_BA.T, K_A]])

    def spread(self, y: Array) -> Array:
        """Return the displacements (ndof, m) of the part with fixed interfaces."""
        return self.z.spread(embedded(y, self.rows, self.z.size))

    def gather(self, f: Array) -> Array:
        """Return loads (ndof, m) on the part as loads on the interior."""
        return self.z.gather(f)[self.rows]

    def problem(self) -> eigen.Flexibility:
        """Return the eigenproblem of the interior as a `Flexibility`."""
        explicit = self._explicit if self.C.shape[0] else None
        return eigen.Flexibility(
            len(self.rows), self.spread, self.gather, self.K_II, self.solve, explicit
        )

    def _explicit(self) -> eigen.Flexibility:
        # small parts: eliminate six displacements per average
        C = self.C.toarray()
        na, n = C.shape
        _, pivots = scipy.linalg.qr(C, mode="r", pivoting=True)
        pinned, others = (np.sort(np.asarray(p, dtype=np.intp)) for p in np.split(pivots, [na]))
        E = embedded(np.eye(n - na), others, n)
        E[pinned] = -np.linalg.solve(C[:, pinned], C[:, others])
        B = E.T @ (self.K_II @ E)
        return eigen.Flexibility(
            n - na,
            lambda y: self.spread(E @ y),
            lambda f: E.T @ self.gather(f),
            0.5 * (B + B.T),
            None,
        )


def _solver(S: Array) -> Callable[[Array], Array]:
    # balance rows and columns, since forces and displacements differ in size
    scale = np.ones(len(S))
    for _ in range(4):
        scale /= np.sqrt(np.abs(scale[:, None] * S * scale).max(axis=1))
    factors = scipy.linalg.lu_factor(scale[:, None] * S * scale)

    def solve(f: Array) -> Array:
        s = scale if f.ndim == 1 else scale[:, None]
        return np.asarray(s * scipy.linalg.lu_solve(factors, s * f))

    return solve


def rigid_left(R: Array) -> Array:
    """Return the combinations (6, r) of rigid motions that are zero in the coordinates with rows R.

    Examples
    --------
    >>> rigid_left(np.eye(6)[:4]).shape
    (6, 2)
    """
    if not len(R):
        return np.eye(6)
    # from the triangular factor, since an SVD of many rows would need a large square matrix
    _, s, V = np.linalg.svd(np.linalg.qr(R, mode="r"), full_matrices=True)
    rank = int(np.sum(s > HELD * s[0]))
    return np.asarray(V[rank:].T)


def determinate(R: Array, candidates: Index | None = None) -> Index | None:
    """Return six coordinates, with rigid motions R, that fix the body; None if there are none.

    They are chosen by pivoted QR, so that the supports are as independent as possible.
    """
    rows = R if candidates is None else R[candidates]
    if len(rows) < 6:
        return None
    r, pivots = scipy.linalg.qr(rows.T, mode="r", pivoting=True)
    if abs(r[5, 5]) < HELD * abs(r[0, 0]):
        return None
    chosen = np.sort(pivots[:6])
    return np.asarray(chosen if candidates is None else candidates[chosen], dtype=np.intp)


def cannot_hold(part_name: str, names: tuple[str, ...], nodes: int, d: int) -> InputError:
    """Return the error for interfaces that do not fix all rigid motions of the body."""
    return InputError(
        Problem(
            f"part '{part_name}'",
            f"the interface {', '.join(names)} ({nodes} node{'s'[: nodes != 1]} of "
            f"{d} degrees of freedom) does not stop all rigid motions: of nodes without rotations "
            f"use at least three that are not on one line, tie them to a node with rotations, "
            f"Interface(name, nodes), or use FreeFree()",
        )
    )
