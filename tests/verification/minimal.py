"""Rigid mechanisms in few coordinates: an independent statement of their motion in plain NumPy.

Nothing here uses the package. A mechanism is a function that places every body, ``q -> (r, A)``:
centre of mass and axes of principal inertia, written with broadcasting (..., n) -> (..., k, 3) and
(..., k, 3, 3) and analytic in q. D'Alembert's principle in Lagrange's form gives the motion:

``sum_k dr.(m r'' - F) + dpi.(J w' + w x J w) = 0``.

First derivatives are complex steps (exact to round-off), the second derivative along the motion is
a coefficient of the Taylor series of r(q + t v), by Cauchy's integral on a circle. Loops are closed
by functions ``C(q) = 0``; redundant ones are allowed (least squares).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[Any]
CIRCLE = np.exp(2j * np.pi * np.arange(16) / 16)
TINY = 1e-40


def turn(axis: int, angle: Array) -> Array:
    """Rotation matrix (..., 3, 3) about the axis x, y or z (0, 1, 2)."""
    angle = np.asarray(angle)
    A = np.zeros((*angle.shape, 3, 3), dtype=angle.dtype)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    A[..., axis, axis] = 1.0
    A[..., i, i] = A[..., j, j] = np.cos(angle)
    A[..., j, i], A[..., i, j] = np.sin(angle), -np.sin(angle)
    return A


def stack(*parts: Array) -> Array:
    """Vectors (..., 3) from components of any shapes that broadcast."""
    return np.stack(np.broadcast_arrays(*parts), axis=-1)


def axial(W: Array) -> Array:
    """Vector (..., 3) of the skew part of W (..., 3, 3)."""
    return 0.5 * stack(
        W[..., 2, 1] - W[..., 1, 2], W[..., 0, 2] - W[..., 2, 0], W[..., 1, 0] - W[..., 0, 1]
    )


def slopes(f: Callable[[Array], Array], q: Array) -> Array:
    """df/dq with the coordinate as the first axis, by complex steps."""
    return np.asarray(f(q + 1j * TINY * np.eye(len(q)))).imag / TINY


def bend(f: Callable[[Array], Array], q: Array, v: Array) -> Array:
    """Second derivative of f(q + t v) at t = 0."""
    h = 0.1 / max(float(np.abs(v).max()), 1e-3)
    values = np.asarray(f(q + h * CIRCLE[:, None] * v))
    return 2 * np.tensordot(CIRCLE**-2, values, axes=1).real / (16 * h**2)


@dataclass(frozen=True, eq=False)
class Minimal:
    """A rigid mechanism in coordinates q.

    place : q (..., n) -> r (..., k, 3), A (..., k, 3, 3)
    mass (k,), inertia (k, 3) principal; gravity (3,)
    close : q (..., n) -> C (..., c), or None
    load : q, v -> generalised force (n,), or None
    """

    place: Callable[[Array], tuple[Array, Array]]
    mass: Array
    inertia: Array
    gravity: Array
    close: Callable[[Array], Array] | None = None
    load: Callable[[Array, Array], Array] | None = None

    def accelerations(self, q: Array, v: Array) -> Array:
        """q'' (n,)."""
        r_q = slopes(lambda x: self.place(x)[0], q)
        A_q = slopes(lambda x: self.place(x)[1], q)
        A = self.place(q)[1]
        w_q = axial(A_q @ np.swapaxes(A, -1, -2))  # (n, k, 3), world
        w = np.tensordot(v, w_q, axes=1)
        bias = bend(lambda x: self.place(x)[0], q, v)
        alpha = axial(bend(lambda x: self.place(x)[1], q, v) @ np.swapaxes(A, -1, -2))
        J = np.einsum("kia,ka,kja->kij", A, self.inertia, A)
        M = np.einsum("k,aki,bki->ab", self.mass, r_q, r_q)
        M += np.einsum("aki,kij,bkj->ab", w_q, J, w_q)
        Q = -np.einsum("k,aki,ki->a", self.mass, r_q, bias - self.gravity)
        gyro = np.einsum("kij,kj->ki", J, alpha) + np.cross(w, np.einsum("kij,kj->ki", J, w))
        Q -= np.einsum("aki,ki->a", w_q, gyro)
        if self.load is not None:
            Q = Q + self.load(q, v)
        if self.close is None:
            return np.linalg.solve(M, Q)
        G = slopes(self.close, q).T
        c = len(G)
        system = np.block([[M, G.T], [G, np.zeros((c, c))]])
        # scaled so that the rank of redundant loops is plain
        size = np.concatenate([1 / np.sqrt(np.diag(M)), np.full(c, 1.0)])
        size[len(q) :] = 1 / np.maximum(np.linalg.norm(G * size[: len(q)], axis=1), 1e-300)
        right = np.concatenate([Q, -bend(self.close, q, v)])
        return (
            size[: len(q)]
            * (
                np.linalg.lstsq(system * np.outer(size, size), right * size, rcond=1e-10)[0][
                    : len(q)
                ]
            )
        )

    def energy(self, q: Array, v: Array) -> float:
        """Kinetic and potential energy, J."""
        r, A = self.place(q)
        r_q = slopes(lambda x: self.place(x)[0], q)
        A_q = slopes(lambda x: self.place(x)[1], q)
        speed = np.tensordot(v, r_q, axes=1)
        w = np.einsum("kia,ki->ka", A, axial(np.tensordot(v, A_q, 1) @ np.swapaxes(A, -1, -2)))
        kinetic = 0.5 * self.mass @ (speed**2).sum(axis=1) + 0.5 * (self.inertia * w**2).sum()
        return float(kinetic - self.mass @ (r @ self.gravity))

    def run(
        self, q: Array, v: Array, times: Array, *, tolerance: float = 1e-11, method: str = "DOP853"
    ) -> tuple[Array, Array]:
        """q and v (nt, n) at the times, integrated from the state at times[0]."""
        n = len(q)
        done = solve_ivp(
            lambda _, y: np.concatenate([y[n:], self.accelerations(y[:n], y[n:])]),
            (times[0], times[-1]),
            np.concatenate([q, v]),
            method=method,
            t_eval=times,
            rtol=tolerance,
            atol=tolerance * 1e-2,
        )
        assert done.success, done.message
        return done.y[:n].T, done.y[n:].T
