"""Markers: points and axes, linear in the body frame and functions of its modal coordinates."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from jousto.base.arrays import Array, Index, skew
from jousto.mechanism.bodies.body import FlexibleBody, MovingBody
from jousto.mechanism.bodies.marker import Marker
from jousto.natural.equations.bodies import FRAME, Bodies

TERMS = 14  # number of terms of the exponential series; 0.5^14 / 14! is below round-off
GROUND = np.vstack([np.zeros(3), np.eye(3)])


class Frames:
    """Markers of a machine, each with point and axes ``y = (r, f, g, h)`` as rows (4, 3).

    ``y = L(xi) X`` with the rows ``X = (R, a, b, c)`` of its body: the first row of L is
    ``(1, u0 + Phi xi)``, the others are ``(0, columns of exp((Psi xi)~) A0)``.
    """

    def __init__(self, bodies: Sequence[MovingBody], shapes: Bodies) -> None:
        self.bodies = shapes
        self._index = {id(body): i for i, body in enumerate(bodies)}
        self._places: dict[tuple[object, ...], int] = {}
        self._found: list[tuple[int, Array, Array, Array, Array]] = []

    def place(self, marker: Marker) -> int:
        """Return the index of a marker, which is added if it is new; equal markers share one."""
        body = self._index.get(id(marker.body), len(self.bodies.mass))
        u0, A0 = np.asarray(marker.position_local), np.asarray(marker.axes)
        key = (body, marker.site, u0.tobytes(), A0.tobytes())
        if key not in self._places:
            n = self.bodies.n
            Phi, Psi = np.zeros((3, n)), np.zeros((3, n))
            if isinstance(marker.body, FlexibleBody) and marker.site is not None:
                Phi[:, : marker.body.n] = marker.Phi
                Psi[:, : marker.body.n] = marker.Psi
            self._places[key] = len(self._found)
            self._found.append((body, u0, A0, Phi, Psi))
        return self._places[key]

    def index(self, body: MovingBody) -> int:
        """Return the index of a body."""
        return self._index[id(body)]

    def close(self) -> None:
        """Build the arrays; no marker can be added afterwards."""
        n = self.bodies.n
        count = len(self._found)
        found = list(zip(*self._found, strict=True)) if count else [()] * 5
        self.body = np.array(found[0], dtype=np.intp)
        self.u0 = np.array(found[1]).reshape(count, 3)
        self.A0 = np.array(found[2]).reshape(count, 3, 3)
        self.Phi = np.array(found[3]).reshape(count, 3, n)
        self.Psi = np.array(found[4]).reshape(count, 3, n)
        self.bent = np.flatnonzero(self.Psi.any(axis=(1, 2)))

    def _at(self, q: Array) -> tuple[Array, Array]:
        """Return frame (nm, 4, 3) and modal coordinates (nm, n) of the body of every marker."""
        X, xi = self.bodies.split(q)
        still = np.zeros((1, self.bodies.n))
        return np.concatenate([X, GROUND[None]])[self.body], np.concatenate([xi, still])[self.body]

    def turned(self, xi: Array) -> Array:
        """Return ``exp((Psi xi)~) A0`` (nm, 3, 3)."""
        B = self.A0.copy()
        if len(k := self.bent):
            theta = (self.Psi[k] @ xi[k, :, None])[:, :, 0]
            B[k] = Rotation.from_rotvec(theta).as_matrix() @ B[k]
        return B

    def evaluate(self, q: Array) -> Pose:
        """Return points and axes of all markers with their derivatives."""
        X, xi = self._at(q)
        L = np.zeros((len(X), 4, 4))
        L[:, 0, 0] = 1.0
        L[:, 0, 1:] = self.u0 + (self.Phi @ xi[:, :, None])[:, :, 0]
        B = self.turned(xi)
        L[:, 1:, 1:] = np.swapaxes(B, 1, 2)
        y = L @ X
        slopes = np.zeros((len(X), 4, 3, self.bodies.n))
        if self.bodies.n:
            A = np.swapaxes(X[:, 1:], 1, 2)
            slopes[:, 0] = A @ self.Phi
            if len(k := self.bent):
                theta = (self.Psi[k] @ xi[k, :, None])[:, :, 0]
                turn = tangent(theta) @ self.Psi[k]  # omega = T(theta) theta'
                columns = np.swapaxes(B[k], 1, 2)
                slopes[k, 1:] = -A[k, None] @ (skew(columns) @ turn[:, None])
        return Pose(self, y, L, slopes)

    def drift(self, q: Array, v: Array) -> Array:
        """Return y'' (nm, 4, 3) for q'' = 0."""
        (X, xi), (V, rate) = self._at(q), self.rates_at(v)
        L = np.zeros((2, len(X), 4, 4))
        L[0, :, 0, 1:] = (self.Phi @ rate[:, :, None])[:, :, 0]
        if len(k := self.bent):
            theta = (self.Psi[k] @ np.stack([xi[k], rate[k], 0.0 * rate[k]])[..., None])[..., 0]
            B = exponential(theta)[1:] @ self.A0[k]
            L[:, k, 1:, 1:] = np.swapaxes(B, 2, 3)
        return np.asarray(2.0 * (L[0] @ V) + L[1] @ X)

    def rates_at(self, v: Array) -> tuple[Array, Array]:
        """Return the rates of frame (nm, 4, 3) and modes (nm, n) of each marker's body.

        Rates of the ground are zero.
        """
        V, rate = self._at(v)
        V[self.body == len(self.bodies.mass)] = 0.0
        return V, rate


class Pose:
    """Points and axes of all markers at one position, with their derivatives."""

    def __init__(self, frames: Frames, y: Array, L: Array, slopes: Array) -> None:
        self.frames, self.y, self.L, self.slopes = frames, y, L, slopes

    def pulled(self, gradients: Array, markers: Index) -> Array:
        """Return derivatives (..., 12 + n) by the coordinates of the bodies of markers.

        Parameters
        ----------
        gradients : array (..., 4, 3)
            Derivatives by y of a marker.
        markers : int array (...)
            Indices of the markers.
        """
        L, n = self.L[markers], self.frames.bodies.n
        frame = (np.swapaxes(L, -1, -2) @ gradients).reshape(*gradients.shape[:-2], FRAME)
        if not n:
            return np.asarray(frame)
        slopes = self.slopes[markers].reshape(*gradients.shape[:-2], 12, n)
        flat = gradients.reshape(*gradients.shape[:-2], 1, 12)
        return np.concatenate([frame, (flat @ slopes)[..., 0, :]], axis=-1)

    def rates(self, v: Array) -> Array:
        """Return y' (nm, 4, 3) of all markers from velocities of the bodies."""
        frames = self.frames
        V, rate = frames.rates_at(v)
        return np.asarray(self.L @ V + (self.slopes @ rate[:, None, :, None])[..., 0])

    def generalised(self, loads: Array) -> Array:
        """Return the generalised forces (nb, 12 + n) of loads (nm, 4, 3) on y of all markers."""
        frames = self.frames
        nb = len(frames.bodies.mass)
        Q = np.zeros((nb + 1, frames.bodies.width))
        every = np.arange(len(frames.body), dtype=np.intp)
        np.add.at(Q, frames.body, self.pulled(loads, every))
        return Q[:nb]


def tangent(theta: Array) -> Array:
    """Return T (..., 3, 3) of ``exp(theta~)' = (T theta')~ exp(theta~)``.

    ``T = E + (1 - cos t)/t^2 theta~ + (t - sin t)/t^3 theta~^2`` with ``t = |theta|``.
    """
    W = skew(theta)
    s = np.sum(theta * theta, axis=-1)[..., None, None]
    small = s < 1e-4
    safe = np.where(small, 1.0, s)
    t = np.sqrt(safe)
    one = np.where(small, 0.5 - s / 24.0 + s * s / 720.0, (1.0 - np.cos(t)) / safe)
    two = np.where(small, 1.0 / 6.0 - s / 120.0 + s * s / 5040.0, (t - np.sin(t)) / (safe * t))
    return np.asarray(np.eye(3) + one * W + two * (W @ W))


def exponential(theta: Array) -> Array:
    """Return ``exp(theta~)`` and its first two derivatives in time, (3, k, 3, 3).

    The exponential of the block matrix ``[[W, W', W''/2], [0, W, W'], [0, 0, W]]`` has these
    matrices in its first row; it is summed as a series, scaled by powers of two.

    Parameters
    ----------
    theta : array (3, k, 3)
        Rotation vectors, their rates and second derivatives.
    """
    W = skew(theta)
    Z = np.zeros((W.shape[1], 9, 9))
    for i in range(3):
        Z[:, 3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = W[0]
        if i < 2:
            Z[:, 3 * i : 3 * i + 3, 3 * i + 3 : 3 * i + 6] = W[1]
    Z[:, :3, 6:] = 0.5 * W[2]
    largest = float(np.sqrt(np.sum(theta[0] ** 2, axis=-1)).max(initial=0.0))
    halvings = max(0, int(np.ceil(np.log2(max(largest, 1e-3) / 0.5))))
    Z /= 2.0**halvings
    out = term = np.broadcast_to(np.eye(9), Z.shape)
    for k in range(1, TERMS + 1):
        term = term @ Z / k
        out = out + term
    for _ in range(halvings):
        out = out @ out
    return np.stack([out[:, :3, :3], out[:, :3, 3:6], 2.0 * out[:, :3, 6:]])
