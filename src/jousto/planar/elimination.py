"""Master-slave elimination for any holonomic coupling ``u = f(um)``.

J. Makinen, H. Marjamaki, S. Pajunen, *Nopeudesta riippuvien hitausvoimatermien vaikutus
palkkilaskentaan* (Tampere University of Technology), equations 2 to 13; signs checked by complex
steps. A coupling has `f`, its derivative `B`, the time derivatives `B1` and `B2` of B, and `Kg`;
forces, stiffness and inertia follow from these by the same formulas for all couplings.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.base.object_repr import described
from jousto.planar.jets import derivatives

Array = NDArray[Any]


class PlanarCoupling(Protocol):
    """Interface of a coupling: slave displacements as a function of master displacements.

    Attributes
    ----------
    shape : (int, int)
        Numbers of slaves and masters.
    """

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of slaves and masters."""

    def f(self, q: Array) -> Array:
        """Return the slave displacements (slaves,), eq. 2."""

    def B(self, q: Array) -> Array:
        """Return ``B = df/dq`` (slaves, masters), eq. 3."""

    def B1(self, q: Array, v: Array) -> Array:
        """Return the time derivative of B at velocity v."""

    def B2(self, q: Array, v: Array, a: Array) -> Array:
        """Return the second time derivative of B at velocity v and acceleration a."""

    def Kg(self, q: Array, F: Array) -> Array:
        """Return ``d(B^T F)/dq`` (masters, masters) at constant F, eq. 6."""


@described
@dataclass(frozen=True, eq=False)
class LinearCoupling:
    """Linear coupling ``u = T q + u0``: ties, symmetry, gears, interpolation.

    Parameters
    ----------
    T : (slaves, masters) array
    u0 : (slaves,) array, optional
    """

    T: Array
    u0: Array | float = 0.0

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of slaves and masters."""
        return self.T.shape[0], self.T.shape[1]

    def f(self, q: Array) -> Array:
        """Return the slave displacements."""
        return np.asarray(self.T @ q + self.u0)

    def B(self, q: Array) -> Array:
        """Return T."""
        return self.T

    def B1(self, q: Array, v: Array) -> Array:
        """Return zero."""
        return np.zeros_like(self.T)

    def B2(self, q: Array, v: Array, a: Array) -> Array:
        """Return zero."""
        return np.zeros_like(self.T)

    def Kg(self, q: Array, F: Array) -> Array:
        """Return zero."""
        return np.zeros((self.T.shape[1], self.T.shape[1]))


class ArmCoupling:
    """Slave points at the ends of rigid arms: ``(x, y) + R(theta) (X, Y) - (X, Y)``, eqs. 20 to 25.

    Masters and slaves have the displacements x, y and rotation; without ``rotation`` the slaves are
    hinged and have x and y only.

    Parameters
    ----------
    nodes : int
        Number of master nodes.
    master : (k,) array of int
        Master node of each arm; a node may have several arms.
    arms : (k, 2) array
        Vector (X, Y) from master to slave in the unloaded frame, m.
    rotation : bool
        Whether the slaves rotate with their masters.
    """

    def __init__(self, nodes: int, master: Array, arms: Array, rotation: bool = True) -> None:
        k, width = len(master), 3 if rotation else 2
        self.shape = (width * k, 3 * nodes)
        self.X, self.Y = np.array(arms, dtype=float).reshape(k, 2).T
        self.turn = 3 * np.asarray(master, dtype=int) + 2
        self.row = width * np.arange(k)
        self.rigid = np.zeros(self.shape)
        for c in range(width):
            self.rigid[self.row + c, self.turn - 2 + c] = 1.0
        # matrix that sums the contributions of all arms of a node
        self.sum = np.zeros((3 * nodes, k))
        self.sum[self.turn, np.arange(k)] = 1.0

    def _fill(self, base: Array, first: Array, second: Array) -> Array:
        """Return a copy of `base` with `first` and `second` in rows x and y of rotation columns."""
        B = base.astype(np.result_type(base, first))
        B[self.row, self.turn] = first
        B[self.row + 1, self.turn] = second
        return B

    def _arm(self, q: Array) -> tuple[Array, Array, Array, Array]:
        th = q[self.turn]
        return np.cos(th), np.sin(th), self.X, self.Y

    def f(self, q: Array) -> Array:
        """Return the slave displacements, eq. 20."""
        c, s, X, Y = self._arm(q)
        u: Array = self.rigid @ q
        u[self.row] += X * c - Y * s - X
        u[self.row + 1] += X * s + Y * c - Y
        return u

    def B(self, q: Array) -> Array:
        """Return the kinematic matrix B, eq. 22."""
        c, s, X, Y = self._arm(q)
        return self._fill(self.rigid, -X * s - Y * c, X * c - Y * s)

    def B1(self, q: Array, v: Array) -> Array:
        """Return the time derivative of B, eq. 24."""
        c, s, X, Y = self._arm(q)
        w = v[self.turn]
        return self._fill(0.0 * self.rigid, w * (Y * s - X * c), -w * (X * s + Y * c))

    def B2(self, q: Array, v: Array, a: Array) -> Array:
        """Return the second time derivative of B, eq. 25, with a minus sign missing in print."""
        c, s, X, Y = self._arm(q)
        w2, dw = v[self.turn] ** 2, a[self.turn]
        A, B = Y * w2 - X * dw, Y * dw + X * w2
        return self._fill(0.0 * self.rigid, A * c + B * s, A * s - B * c)

    def Kg(self, q: Array, F: Array) -> Array:
        """Return the geometric stiffness, eq. 23: ``-F1 B23 + F2 B13`` at the rotation."""
        c, s, X, Y = self._arm(q)
        F1, F2 = F[self.row], F[self.row + 1]
        return np.diag(self.sum @ (F2 * (-X * s - Y * c) - F1 * (X * c - Y * s)))


class FunctionCoupling:
    """Coupling by a function, with derivatives exact to round-off (`jets`).

    Parameters
    ----------
    function : function
        Function of master coordinates (masters,) that returns slave displacements (slaves,),
        written with NumPy's ``sin, cos, tan, exp, log, sqrt, arctan`` and arithmetic, without
        ``if`` on coordinates.
    slaves, masters : int
    """

    def __init__(self, function: Callable[[Array], Any], slaves: int, masters: int) -> None:
        self.function, self.shape = function, (slaves, masters)

    def f(self, q: Array) -> Array:
        """Return the slave displacements."""
        u = np.asarray(self.function(q))
        return u.astype(np.result_type(q, float)).reshape(-1)

    def B(self, q: Array) -> Array:
        """Return the derivative of the function."""
        n = self.shape[1]
        still = np.zeros((n, n))
        return derivatives(self.function, q, np.eye(n), still, still)[0].T

    def B1(self, q: Array, v: Array) -> Array:
        """Return the coefficient of t of the derivative along ``q + v t``."""
        n = self.shape[1]
        path = np.broadcast_to(v, (n, n))
        return derivatives(self.function, q, np.eye(n), path, 0.0 * path)[1].T

    def B2(self, q: Array, v: Array, a: Array) -> Array:
        """Return twice the coefficient of t^2 of the derivative along ``q + v t + a t^2 / 2``."""
        n = self.shape[1]
        c1, c2 = np.broadcast_to(v, (n, n)), np.broadcast_to(0.5 * a, (n, n))
        return 2.0 * derivatives(self.function, q, np.eye(n), c1, c2)[2].T

    def Kg(self, q: Array, F: Array) -> Array:
        """Return the second derivatives contracted with F: changes of ``B^T F`` along each axis."""
        n = self.shape[1]
        e = np.eye(n)
        along, path = np.repeat(e, n, axis=0), np.tile(e, (n, 1))
        second = derivatives(self.function, q, along, path, 0.0 * path)[1]
        return np.asarray((second @ F).reshape(n, n))


class BlockCoupling:
    """Couplings of groups of coordinates, ``u[rows] = f(q[columns])``.

    Parameters
    ----------
    shape : (int, int)
        Numbers of all slaves and masters.
    blocks : sequence of (rows, columns, PlanarCoupling)
        Blocks; a slave is in one block, a master may be in several.
    """

    def __init__(
        self, shape: tuple[int, int], blocks: Sequence[tuple[Array, Array, PlanarCoupling]]
    ) -> None:
        self.shape = shape
        self.blocks = [(_run(r), _run(c), m) for r, c, m in blocks]

    def f(self, q: Array) -> Array:
        """Return the slave displacements."""
        u = np.zeros(self.shape[0], dtype=q.dtype)
        for rows, columns, part in self.blocks:
            u[rows] = part.f(q[columns])
        return u

    def _place(self, parts: Sequence[Array]) -> Array:
        B = np.zeros(self.shape, dtype=np.result_type(float, *parts))
        for (rows, columns, _), part in zip(self.blocks, parts, strict=True):
            B[_grid(rows, columns)] = part
        return B

    def B(self, q: Array) -> Array:
        """Return the kinematic matrix B, assembled from the blocks."""
        return self._place([m.B(q[c]) for _, c, m in self.blocks])

    def B1(self, q: Array, v: Array) -> Array:
        """Return the time derivative of B."""
        return self._place([m.B1(q[c], v[c]) for _, c, m in self.blocks])

    def B2(self, q: Array, v: Array, a: Array) -> Array:
        """Return the second time derivative of B."""
        return self._place([m.B2(q[c], v[c], a[c]) for _, c, m in self.blocks])

    def Kg(self, q: Array, F: Array) -> Array:
        """Return the sum of the geometric stiffness of the blocks."""
        K = np.zeros((self.shape[1], self.shape[1]), dtype=np.result_type(q, F))
        for rows, columns, part in self.blocks:
            K[_grid(columns, columns)] += part.Kg(q[columns], F[rows])
        return K


def _run(index: Array) -> Array | slice:
    """Return indices as a slice if they follow each other, which is faster."""
    index = np.asarray(index)
    if len(index) and np.array_equal(index, np.arange(index[0], index[0] + len(index))):
        return slice(int(index[0]), int(index[0]) + len(index))
    return index


def _grid(rows: Array | slice, columns: Array | slice) -> tuple[Any, Any]:
    """Return the index of the entries of a matrix in given rows and columns."""
    if isinstance(rows, slice) or isinstance(columns, slice):
        return rows, columns
    return rows[:, None], columns


@dataclass(frozen=True)
class ChainCoupling:
    """Composed coupling ``u = outer(inner(q))``, such as an offset on a slave node.

    Parameters
    ----------
    outer, inner : PlanarCoupling
    """

    outer: PlanarCoupling
    inner: PlanarCoupling

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of slaves and masters."""
        return self.outer.shape[0], self.inner.shape[1]

    def f(self, q: Array) -> Array:
        """Return the slave displacements."""
        return self.outer.f(self.inner.f(q))

    def B(self, q: Array) -> Array:
        """Return ``B_outer B_inner`` (chain rule)."""
        return np.asarray(self.outer.B(self.inner.f(q)) @ self.inner.B(q))

    def B1(self, q: Array, v: Array) -> Array:
        """Return the time derivative of ``B_outer B_inner`` by the product rule."""
        w, b = self.inner.f(q), self.inner.B(q)
        return np.asarray(self.outer.B1(w, b @ v) @ b + self.outer.B(w) @ self.inner.B1(q, v))

    def B2(self, q: Array, v: Array, a: Array) -> Array:
        """Return the second time derivative of ``B_outer B_inner`` by the product rule."""
        w, b, b1 = self.inner.f(q), self.inner.B(q), self.inner.B1(q, v)
        wv, wa = b @ v, b @ a + b1 @ v
        return np.asarray(
            self.outer.B2(w, wv, wa) @ b
            + 2.0 * self.outer.B1(w, wv) @ b1
            + self.outer.B(w) @ self.inner.B2(q, v, a)
        )

    def Kg(self, q: Array, F: Array) -> Array:
        """Return Kg of the inner coupling under ``B_outer^T F``, plus ``B^T Kg_outer B``."""
        w, b = self.inner.f(q), self.inner.B(q)
        return np.asarray(b.T @ self.outer.Kg(w, F) @ b + self.inner.Kg(q, self.outer.B(w).T @ F))


class CoupledMotion(NamedTuple):
    """Motion of the slaves for a motion of the masters, eq. 8.

    Attributes
    ----------
    u, v, a : (slaves,) array
        Displacements f(q), velocities ``B v`` and accelerations ``B a + B1 v``.
    B, B1 : (slaves, masters) array
    """

    u: Array
    v: Array
    a: Array
    B: Array
    B1: Array


@described
@dataclass(frozen=True)
class Elimination:
    """Elimination of slaves: forces, stiffness and inertia in the coordinates of the masters.

    Parameters
    ----------
    map : PlanarCoupling
        The coupling.
    """

    map: PlanarCoupling

    def slaves(self, q: Array, v: Array, a: Array) -> CoupledMotion:
        """Return the motion of the slaves."""
        B, B1 = self.map.B(q), self.map.B1(q, v)
        return CoupledMotion(self.map.f(q), B @ v, B @ a + B1 @ v, B, B1)

    def force(self, q: Array, F: Array) -> Array:
        """Return the force on the masters, ``F_m = B^T F``, eq. 5."""
        return np.asarray(self.map.B(q).T @ F)

    def stiffness(self, q: Array, F: Array, K: Array) -> Array:
        """Return the stiffness of the masters, ``K_m = B^T K B + Kg(F)``, eq. 6."""
        B = self.map.B(q)
        return np.asarray(B.T @ K @ B + self.map.Kg(q, F))

    def mass(self, q: Array, M: Array) -> Array:
        """Return the mass matrix of the masters, ``M_m = B^T M B``, eq. 10."""
        B = self.map.B(q)
        return np.asarray(B.T @ M @ B)

    def centrifugal(self, q: Array, v: Array, M: Array) -> Array:
        """Return the centrifugal force ``F_cent = B^T M B1 v``, quadratic in velocities, eq. 10."""
        return np.asarray(self.map.B(q).T @ (M @ (self.map.B1(q, v) @ v)))

    def inertia_tangents(self, q: Array, v: Array, a: Array, M: Array) -> tuple[Array, Array]:
        """Return ``K_acc = B^T M B2 + Kg(M u'')`` and ``C_acc = 2 B^T M B1``, eq. 13.

        These are the derivatives of ``M_m a + F_cent`` by q and v, and not symmetric.
        """
        s = self.slaves(q, v, a)
        MB = M @ s.B
        K = MB.T @ self.map.B2(q, v, a) + self.map.Kg(q, M @ s.a)
        return np.asarray(K), np.asarray(2.0 * MB.T @ s.B1)
