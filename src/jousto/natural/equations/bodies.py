"""Masses of rigid and modal bodies in the coordinates ``[R, a, b, c, xi]``.

A particle with the deformed local position ``u = u0 + Phi xi = (X, Y, Z)`` is at
``r = R + X a + Y b + Z c``: linear in R and in the axes a, b, c of the body frame. With
``E = (1, X, Y, Z)`` two integrals make the mass matrix, whatever the mesh (spec: S47-S60)::

    G = int E E^T dm       (4, 4), quadratic in xi
    C = int E phi_j^T dm   (4, 3) for every mode j, linear in xi
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.mechanism.bodies.body import FlexibleBody, MovingBody

FRAME = 12
"""Number of coordinates of a body frame: origin and three axes."""
LEAST = 1e-10
"""Smallest inertia of a body over its largest one, in the scale of constraints."""


@dataclass(frozen=True, eq=False)
class Shape:
    """Frames and deformed shapes of all bodies, with their mass integrals.

    Attributes
    ----------
    X : array (nb, 4, 3)
        Rows R, a, b, c.
    xi : array (nb, n)
        Modal coordinates.
    G, C : arrays (nb, 4, 4), (nb, 4, 3, n)
        Mass integrals.
    """

    X: Array
    xi: Array
    G: Array
    C: Array


@dataclass(frozen=True, eq=False)
class Bodies:
    """Mass integrals of all bodies, padded to equal numbers of modes by modes without motion.

    Attributes
    ----------
    mass, first, second : arrays (nb,), (nb, 3), (nb, 3, 3)
        ``int dm``, ``int u0 dm``, ``int u0 u0^T dm``.
    I3, N0, E : arrays (nb, 3, n), (nb, n, 3, 3), (nb, n, n, 3, 3)
        ``int phi_j dm``, ``int u0 phi_j^T dm``, ``int phi_j phi_k^T dm``.
    modal : array (nb, n, n)
        ``Phi^T M Phi``.
    K, D : arrays (nb, n)
        Diagonals of the modal stiffness, 1/s2, and damping, 1/s.
    """

    mass: Array
    first: Array
    second: Array
    I3: Array
    N0: Array
    E: Array
    modal: Array
    K: Array
    D: Array

    @classmethod
    def of(cls, bodies: Sequence[MovingBody]) -> Bodies:
        """Return the integrals of declared bodies."""
        nb = len(bodies)
        n = max([body.n for body in bodies if isinstance(body, FlexibleBody)], default=0)
        made = cls(
            mass=np.zeros(nb),
            first=np.zeros((nb, 3)),
            second=np.zeros((nb, 3, 3)),
            I3=np.zeros((nb, 3, n)),
            N0=np.zeros((nb, n, 3, 3)),
            E=np.zeros((nb, n, n, 3, 3)),
            modal=np.tile(np.eye(n), (nb, 1, 1)),
            K=np.zeros((nb, n)),
            D=np.zeros((nb, n)),
        )
        for i, body in enumerate(bodies):
            if isinstance(body, FlexibleBody):
                made._modal(i, body)
                continue
            J, c = np.asarray(body.inertia), np.asarray(body.center)
            made.mass[i] = body.mass
            made.first[i] = body.mass * c
            made.second[i] = 0.5 * np.trace(J) * np.eye(3) - J + body.mass * np.outer(c, c)
        return made

    def _modal(self, i: int, body: FlexibleBody) -> None:
        part, n = body.reduced.invariants, body.n
        self.mass[i] = part.mass
        self.first[i] = part.first_moment
        self.second[i] = part.second_moment
        self.I3[i, :, :n] = part.I3
        self.N0[i, :n] = part.N0
        self.E[i, :n, :n] = part.E
        self.modal[i, :n, :n] = np.trace(part.E, axis1=2, axis2=3)
        self.K[i, :n] = body.reduced.stiffness
        self.D[i, :n] = body.modal_damping

    @property
    def n(self) -> int:
        """Number of modes per body, with padding."""
        return int(self.K.shape[1])

    @property
    def width(self) -> int:
        """Number of coordinates of a body, 12 + n."""
        return FRAME + self.n

    def split(self, q: Array) -> tuple[Array, Array]:
        """Return frames (nb, 4, 3), rows R, a, b, c, and modal coordinates (nb, n)."""
        rows = q.reshape(len(self.mass), self.width)
        return rows[:, :FRAME].reshape(-1, 4, 3), rows[:, FRAME:]

    def integrals(self, xi: Array) -> tuple[Array, Array]:
        """Return G (nb, 4, 4) and C (nb, 4, 3, n) of deformed bodies."""
        nb, n = xi.shape
        N = self.N0
        G = np.zeros((nb, 4, 4))
        G[:, 0, 0] = self.mass
        G[:, 1:, 1:] = self.second
        S = self.first
        if n:
            turned = (xi[:, None] @ self.E.reshape(nb, n, -1)).reshape(nb, n, 3, 3)
            N = self.N0 + turned
            both = np.swapaxes(self.N0, 2, 3) + N
            G[:, 1:, 1:] += (xi[:, None] @ both.reshape(nb, n, 9)).reshape(nb, 3, 3)
            S = S + (self.I3 @ xi[:, :, None])[:, :, 0]
        G[:, 0, 1:] = G[:, 1:, 0] = S
        C = np.concatenate([self.I3[:, None], np.transpose(N, (0, 2, 3, 1))], axis=1)
        return G, C

    def shaped(self, q: Array) -> Shape:
        """Return frames, deformed shapes and mass integrals of the bodies at a position."""
        X, xi = self.split(q)
        return Shape(X, xi, *self.integrals(xi))

    def mass_matrix(self, shape: Shape) -> Array:
        """Return M (nb, 12 + n, 12 + n): ``G (x) I3``, ``A C_a`` and ``Phi^T M Phi`` (S60)."""
        X, G, C = shape.X, shape.G, shape.C
        M = np.zeros((len(X), self.width, self.width))
        frame = np.zeros((len(X), 4, 3, 4, 3))
        for k in range(3):
            frame[:, :, k, :, k] = G
        M[:, :FRAME, :FRAME] = frame.reshape(-1, FRAME, FRAME)
        cross = np.swapaxes(X[:, 1:], 1, 2)[:, None] @ C
        M[:, :FRAME, FRAME:] = cross.reshape(len(X), FRAME, self.n)
        M[:, FRAME:, :FRAME] = np.swapaxes(M[:, :FRAME, FRAME:], 1, 2)
        M[:, FRAME:, FRAME:] = self.modal
        return M

    def loads(self, shape: Shape, v: Array, gravity: Array) -> Array:
        """Return the forces ``Q_v + Q_g - K xi - D xi'`` (nb, 12 + n) of inertia, weight and modes.

        ``Q_v = -B^T M B' q'`` with ``B' q' = 2 A' Phi xi'`` (S61): the part of the frame is
        ``-2 A' C_a xi'``, the part of mode j ``-2 sum_k (A^T A') : E_jk xi'_k``.
        """
        X, xi, G, C = shape.X, shape.xi, shape.G, shape.C
        V, rate = self.split(v)
        A, spin = np.swapaxes(X[:, 1:], 1, 2), np.swapaxes(V[:, 1:], 1, 2)
        Q = np.zeros((len(X), self.width))
        frame = G[:, :, :1] * gravity
        if self.n:
            moved = (C @ rate[:, None, :, None])[..., 0]
            frame = frame - 2.0 * (moved @ np.swapaxes(spin, 1, 2))
            turn = (np.swapaxes(A, 1, 2) @ spin).reshape(len(X), 9, 1)
            coupled = (self.E.reshape(len(X), -1, 9) @ turn).reshape(len(X), self.n, self.n)
            Q[:, FRAME:] = (
                (gravity @ A)[:, None] @ self.I3
                - 2.0 * np.swapaxes(coupled @ rate[:, :, None], 1, 2)
            )[:, 0]
            Q[:, FRAME:] -= self.K * xi + self.D * rate
        Q[:, :FRAME] = frame.reshape(len(X), FRAME)
        return Q

    def potential(self, shape: Shape, gravity: Array) -> float:
        """Return the potential energy ``-g . int r dm``, J."""
        return -float(np.einsum("ba,bak,k->", shape.G[:, 0], shape.X, gravity))

    def strain(self, shape: Shape) -> float:
        """Return the strain energy of the modes, J."""
        return 0.5 * float(np.sum(self.K * shape.xi * shape.xi))

    def yielding(self, shape: Shape, gradients: Array, held: Index) -> Array:
        """Return y (m, k, 6 + n) of constraints, ``y_i . y_j = Cq_i M^-1 Cq_j^T`` per body.

        M is approximated by the rigid body of the deformed shape and unit modal masses.

        Parameters
        ----------
        shape : Shape
            The bodies at a position.
        gradients : array (m, k, 12 + n)
            Derivatives of the constraints by the coordinates of their bodies.
        held : int array (m, k)
            Indices of these bodies; nb is none.
        """
        axes, G = shape.X[:, 1:], shape.G
        centre = ((G[:, :1, 1:] / self.mass[:, None, None]) @ axes)[:, 0]
        easy = np.linalg.inv(np.linalg.cholesky(self.inertia(G)))
        # any index stands for "none", where the derivatives are zero
        at = np.minimum(held, len(axes) - 1)
        g = gradients[:, :, :FRAME].reshape(*held.shape, 4, 3)
        force, axes = g[:, :, 0], axes[at]
        # torque about the centre of mass: antisymmetric part of T_ij = sum of axis i times load j
        T = np.swapaxes(axes, -1, -2) @ g[:, :, 1:] - centre[at][..., None] * force[:, :, None]
        torque = np.stack(
            [
                T[..., 1, 2] - T[..., 2, 1],
                T[..., 2, 0] - T[..., 0, 2],
                T[..., 0, 1] - T[..., 1, 0],
            ],
            axis=-1,
        )
        turn = axes @ torque[..., None]
        moved = force / np.sqrt(self.mass[at])[..., None]
        turned = (easy[at] @ turn)[..., 0]
        return np.concatenate([moved, turned, gradients[:, :, FRAME:]], axis=2)

    def inertia(self, G: Array) -> Array:
        """Return the inertia tensors (nb, 3, 3) about the centres of mass, bounded from below."""
        U = G[:, 1:, 1:] - G[:, 1:, :1] * G[:, :1, 1:] / self.mass[:, None, None]
        size = np.trace(U, axis1=1, axis2=2)[:, None, None]
        return np.asarray(((1.0 + LEAST) * size + 1e-300) * np.eye(3) - U)

    def stiffness_of_axes(self, shape: Shape) -> Array:
        """Return an effective mass (nb, 6) of each axis condition, a.a, b.b, c.c, a.b, a.c, b.c.

        For b.c it is the inertia about a, for a.a the smaller of the inertias about b and c.
        """
        U = shape.G[:, [1, 2, 3], [1, 2, 3]]
        x, y, z = (U.sum(axis=1, keepdims=True) * (1.0 + LEAST) + 1e-300 - U).T
        return (
            np.stack(
                [np.minimum(y, z), np.minimum(x, z), np.minimum(x, y), 4 * z, 4 * y, 4 * x], axis=1
            )
            / 4.0
        )
