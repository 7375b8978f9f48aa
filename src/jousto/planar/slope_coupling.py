"""SlopeCoupling: slopes ``r' = (1 + s) R(th) r0'`` as slaves of a rotation and a stretch."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class SlopeCoupling:
    """Changes ``(1 + s) R(th) r0' - r0'`` of slopes, from the rotation th and the stretch s.

    Parameters
    ----------
    turn, stretch : (k,) array of int
        Places of th and s of each slope among the masters.
    start : (k, 2) array
        Unit vectors r0' in the unloaded frame.
    masters : int
        Number of masters.
    """

    def __init__(self, turn: Array, stretch: Array, start: Array, masters: int) -> None:
        self.turn, self.stretch, self.start = turn, stretch, start
        self.shape = (2 * len(turn), masters)
        self.row = 2 * np.arange(len(turn))

    def _turned(self, q: Array) -> tuple[Array, Array, Array]:
        """Return the unit vectors R r0', their normals, and 1 + s, (k, 2), (k, 2), (k, 1)."""
        c, s = np.cos(q[self.turn]), np.sin(q[self.turn])
        x, y = self.start.T
        e = np.stack([c * x - s * y, s * x + c * y], axis=1)
        n = np.stack([-e[:, 1], e[:, 0]], axis=1)
        return e, n, 1.0 + q[self.stretch][:, None]

    def _place(self, by_turn: Array, by_stretch: Array) -> Array:
        B = np.zeros(self.shape, dtype=np.result_type(by_turn, by_stretch))
        for c in range(2):
            B[self.row + c, self.turn] = by_turn[:, c]
            B[self.row + c, self.stretch] = by_stretch[:, c]
        return B

    def f(self, q: Array) -> Array:
        """Return the changes of the slopes."""
        e, _, size = self._turned(q)
        return np.asarray((size * e - self.start).ravel())

    def B(self, q: Array) -> Array:
        """Return the derivatives ``(1 + s) n`` by th and ``e`` by s."""
        e, n, size = self._turned(q)
        return self._place(size * n, e)

    def B1(self, q: Array, v: Array) -> Array:
        """Return the time derivative of B at velocity v."""
        e, n, size = self._turned(q)
        w, ds = v[self.turn][:, None], v[self.stretch][:, None]
        return self._place(ds * n - size * w * e, w * n)

    def B2(self, q: Array, v: Array, a: Array) -> Array:
        """Return the second time derivative of B at velocity v and acceleration a."""
        e, n, size = self._turned(q)
        w, ds = v[self.turn][:, None], v[self.stretch][:, None]
        dw, dds = a[self.turn][:, None], a[self.stretch][:, None]
        by_turn = dds * n - 2.0 * ds * w * e - size * (dw * e + w**2 * n)
        return self._place(by_turn, dw * n - w**2 * e)

    def Kg(self, q: Array, F: Array) -> Array:
        """Return ``d(B^T F)/dq`` at constant F: the Hessian of th times the moment, and more."""
        e, n, size = self._turned(q)
        f = F.reshape(-1, 2)
        along, across = np.sum(e * f, axis=1), np.sum(n * f, axis=1)
        K = np.zeros((self.shape[1], self.shape[1]), dtype=np.result_type(q, F))
        np.add.at(K, (self.turn, self.turn), -size[:, 0] * along)
        np.add.at(K, (self.turn, self.stretch), across)
        np.add.at(K, (self.stretch, self.turn), across)
        return K
