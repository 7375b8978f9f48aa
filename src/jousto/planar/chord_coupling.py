"""ChordCoupling: deviations from a turned chord, ``d_i = l0 t_i n``, as slaves of both ends.

With e, n the unit vector of the chord and its normal, g = n/l and ``p_i = n + t_i e``

    t_i = th_i - psi,   d psi = g . dx,   d d_i = l0 (n d th_i - p_i (g . dx))

Mass that is constant for the slaves makes the mass matrix M(q) of the ends with all velocity terms,
by the formulas of `jousto.planar.elimination`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


def turned(chord: Array, change: Array) -> Array:
    """Return the angle psi from `chord` to ``chord + change``, (...,), within (-pi, pi].

    Parameters
    ----------
    chord, change : (..., 2) array
        Unloaded chord and its change, m; the change may be complex.
    """
    now = chord + change
    dot = np.sum(chord * now, axis=-1)
    # chord x chord = 0: small angles keep their digits
    cross = chord[..., 0] * change[..., 1] - chord[..., 1] * change[..., 0]
    psi = np.arctan2(np.real(cross), np.real(dot))
    if not np.iscomplexobj(change):
        return np.asarray(psi)
    c, s = np.cos(psi), np.sin(psi)
    return np.asarray(psi + np.arctan((cross * c - dot * s) / (dot * c + cross * s)))


class _Chord(NamedTuple):
    """Chord of each beam: vector x, square of its length, g = Jx/x^2, e, n, and angles t."""

    x: Array
    square: Array
    g: Array
    e: Array
    n: Array
    t: Array


def _J(x: Array) -> Array:
    """Return vectors (..., 2) turned by a right angle."""
    return np.stack([-x[..., 1], x[..., 0]], axis=-1)


def _dot(a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * b, axis=-1))


class ChordCoupling:
    """Deviations ``d_i = l0 t_i n`` (m) of the ends of beams, tangential to the turned chord.

    Parameters
    ----------
    chord : (ne, 2) array
        Unloaded chords, m.
    ends : (ne, 6) array of int
        Places of x, y, rotation of both ends among the masters.
    masters : int
        Number of masters.
    """

    def __init__(self, chord: Array, ends: Array, masters: int) -> None:
        self.chord, self.ends = chord, ends
        self.l0 = np.hypot(chord[:, 0], chord[:, 1])
        self.shape = (4 * len(chord), masters)
        self.row = np.arange(4 * len(chord)).reshape(-1, 2, 2)

    def _change(self, q: Array) -> tuple[Array, Array]:
        """Return the change of the chord (ne, 2) and the rotations (ne, 2) in q."""
        u = q[self.ends]
        return u[:, 3:5] - u[:, :2], u[:, [2, 5]]

    def _chord(self, q: Array) -> _Chord:
        change, th = self._change(q)
        x = self.chord + change
        square = _dot(x, x)
        t = th - turned(self.chord, change)[:, None]
        t = t - 2.0 * np.pi * np.round(np.real(t) / (2.0 * np.pi))
        e = x / np.sqrt(square)[:, None]
        return _Chord(x, square, _J(x) / square[:, None], e, _J(e), t)

    def _rates(self, k: _Chord, v: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Return the rates of x, of psi, of t, of g, and the rate of 1/x^2."""
        dx, dth = self._change(v)
        dpsi = _dot(k.g, dx)
        dG = -2.0 * _dot(k.x, dx) / k.square**2
        dg = _J(dx) / k.square[:, None] + _J(k.x) * dG[:, None]
        return dx, dpsi, dth - dpsi[:, None], dg, dG

    def f(self, q: Array) -> Array:
        """Return the slave displacements."""
        k = self._chord(q)
        return np.asarray((self.l0[:, None, None] * k.t[:, :, None] * k.n[:, None]).ravel())

    def _place(self, by_turn: Array, by_chord: Array) -> Array:
        """Return a matrix from d d/d th (ne, 2, 2) and d d/dx (ne, 2, 2, 2), both over l0."""
        B = np.zeros(self.shape, dtype=np.result_type(by_turn, by_chord))
        L = self.l0[:, None, None]
        for i, turn in ((0, 2), (1, 5)):
            rows = self.row[:, i]
            B[rows, self.ends[:, turn, None]] += L[:, 0] * by_turn[:, i]
            for c in range(2):
                B[rows, self.ends[:, 3 + c, None]] += L[:, 0] * by_chord[:, i, :, c]
                B[rows, self.ends[:, c, None]] -= L[:, 0] * by_chord[:, i, :, c]
        return B

    def B(self, q: Array) -> Array:
        """Return the derivative ``n`` by th_i, ``-p_i g^T`` by the chord, times l0."""
        k = self._chord(q)
        p = k.n[:, None] + k.t[:, :, None] * k.e[:, None]
        return self._place(_both(k.n), -_outer(p, k.g))

    def B1(self, q: Array, v: Array) -> Array:
        """Return the time derivative of B at velocity v."""
        k = self._chord(q)
        _, dpsi, dt, dg, _ = self._rates(k, v)
        p, dp = self._arm(k, dpsi, dt)
        return self._place(_both(-dpsi[:, None] * k.e), -_outer(dp, k.g) - _outer(p, dg))

    def _arm(self, k: _Chord, dpsi: Array, dt: Array) -> tuple[Array, Array]:
        """Return p and its rate ``(t' - psi') e + t psi' n``, (ne, 2, 2)."""
        e, n, t = k.e[:, None], k.n[:, None], k.t[:, :, None]
        w = dpsi[:, None, None]
        return n + t * e, (dt[:, :, None] - w) * e + t * w * n

    def B2(self, q: Array, v: Array, a: Array) -> Array:
        """Return the second time derivative of B at velocity v and acceleration a."""
        k = self._chord(q)
        dx, dpsi, dt, dg, dG = self._rates(k, v)
        ddx, ddth = self._change(a)
        ddpsi = _dot(dg, dx) + _dot(k.g, ddx)
        ddt = ddth - ddpsi[:, None]
        # second rate of g = Jx G, G = 1/x^2
        rise = 2.0 * (_dot(dx, dx) + _dot(k.x, ddx))
        ddG = -rise / k.square**2 + 2.0 * (2.0 * _dot(k.x, dx)) ** 2 / k.square**3
        ddg = _J(ddx) / k.square[:, None] + 2.0 * _J(dx) * dG[:, None] + _J(k.x) * ddG[:, None]
        p, dp = self._arm(k, dpsi, dt)
        e, n, t = k.e[:, None], k.n[:, None], k.t[:, :, None]
        w, dw, s, ds = dpsi[:, None, None], ddpsi[:, None, None], dt[:, :, None], ddt[:, :, None]
        # second rate of p = n + t e
        ddp = (ds - dw - t * w**2) * e + ((2.0 * s - w) * w + t * dw) * n
        ddn = -ddpsi[:, None] * k.e - dpsi[:, None] ** 2 * k.n
        by_chord = _outer(ddp, k.g) + 2.0 * _outer(dp, dg) + _outer(p, ddg)
        return self._place(_both(ddn), -by_chord)

    def Kg(self, q: Array, F: Array) -> Array:
        """Return ``d(B^T F)/dq`` at constant F."""
        k = self._chord(q)
        f = F.reshape(-1, 2, 2)
        e, n = _dot(f, k.e[:, None]), _dot(f, k.n[:, None])
        p = n + k.t * e
        g = k.g
        # by the chord twice: -(t n.F - 2 e.F) g g^T - (p.F) dg/dx
        ne = k.n[:, :, None] * k.e[:, None, :]
        dg = -(ne + np.swapaxes(ne, 1, 2)) / k.square[:, None, None]
        gg = g[:, :, None] * g[:, None, :]
        by_gg, by_dg = np.sum(2.0 * e - k.t * n, axis=1), np.sum(p, axis=1)
        xx = by_gg[:, None, None] * gg - by_dg[:, None, None] * dg
        # by th_i and the chord: -(e.F) g
        tx = -e[:, :, None] * g[:, None, :]
        local = np.zeros((len(f), 6, 6), dtype=np.result_type(q, F))
        for a, sign in ((0, -1.0), (3, 1.0)):
            for b, other in ((0, -1.0), (3, 1.0)):
                local[:, a : a + 2, b : b + 2] = sign * other * xx
            for i, turn in ((0, 2), (1, 5)):
                local[:, turn, a : a + 2] = sign * tx[:, i]
                local[:, a : a + 2, turn] = sign * tx[:, i]
        K = np.zeros((self.shape[1], self.shape[1]), dtype=local.dtype)
        scaled = self.l0[:, None, None] * local
        np.add.at(K, (self.ends[:, :, None], self.ends[:, None, :]), scaled)
        return K


def _both(x: Array) -> Array:
    """Return vectors (ne, 2) for both ends, (ne, 2, 2)."""
    return np.stack([x, x], axis=1)


def _outer(p: Array, g: Array) -> Array:
    """Return p_i g^T, (ne, 2, 2, 2)."""
    return np.asarray(p[:, :, :, None] * g[:, None, None, :])
