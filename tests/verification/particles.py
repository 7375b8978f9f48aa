"""Bodies as heaps of particles: an independent statement of their mechanics in plain NumPy.

Nothing here uses the mass points, invariants or matrices of the package. A particle of mass m with
undeformed position u0 and mode shapes Phi is at ``r = R + A (u0 + Phi p)``; every law is a sum over
particles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto import FlexibleBody, Material

Array = NDArray[Any]


def skew(x: Array) -> Array:
    """x~ with ``x~ y = x cross y``, also of complex vectors."""
    return np.array([[0, -x[2], x[1]], [x[2], 0, -x[0]], [-x[1], x[0], 0]])


def rotation(e: Array) -> Array:
    """A of unit Euler parameters: ``A y = y + 2 e0 e~ y + 2 e~ e~ y``."""
    W = skew(e[1:])
    return np.eye(3) + 2 * e[0] * W + 2 * W @ W


def exponential(theta: Array) -> Array:
    """exp(theta~) by its power series, real or complex."""
    W, term, total = skew(theta), np.eye(3), np.eye(3)
    for k in range(1, 40):
        term = term @ W / k
        total = total + term
    return total


@dataclass(frozen=True, eq=False)
class Particles:
    """Masses m (k,), undeformed positions u0 (k, 3), mode shapes Phi (k, 3, n)."""

    m: Array
    u0: Array
    Phi: Array

    @property
    def n(self) -> int:
        return self.Phi.shape[2]

    def shape(self, p: Array) -> Array:
        """Deformed local positions (k, 3)."""
        return self.u0 + self.Phi @ p

    def jacobian(self, p: Array) -> Array:
        """Local velocities of the particles from [A^T R', w, p']: (k, 3, 6 + n)."""
        u = self.shape(p)
        J = np.zeros((len(self.m), 3, 6 + self.n))
        J[:, :, :3] = np.eye(3)
        J[:, :, 3:6] = [-skew(x) for x in u]
        J[:, :, 6:] = self.Phi
        return J

    def mass_matrix(self, p: Array) -> Array:
        """M (6+n, 6+n) for [A^T R'', w', p'']."""
        J = self.jacobian(p)
        return np.einsum("k,kai,kaj->ij", self.m, J, J, optimize=True)

    def bias(self, p: Array, w: Array, pd: Array) -> Array:
        """Local accelerations (k, 3) while R'', w', p'' vanish."""
        rate = self.Phi @ pd
        return np.cross(w, np.cross(w, self.shape(p))) + 2 * np.cross(w, rate)

    def forces(self, q: Array, v: Array, gravity: Array, K: Array, D: Array) -> Array:
        """Q (6+n,) for [A^T R'', w', p'']: inertia, gravity, springs and dampers of the modes."""
        A, p, w, pd = rotation(q[3:7]), q[7:], v[3:6], v[6:]
        loads = self.m[:, None] * (A.T @ gravity - self.bias(p, w, pd))
        Q = np.einsum("kai,ka->i", self.jacobian(p), loads)
        Q[6:] -= K * p + D * pd
        return Q

    def positions(self, q: Array) -> Array:
        """World positions (k, 3)."""
        return q[:3] + self.shape(q[7:]) @ rotation(q[3:7]).T

    def velocities(self, q: Array, v: Array) -> Array:
        """World velocities (k, 3)."""
        local = np.cross(v[3:6], self.shape(q[7:])) + self.Phi @ v[6:]
        return v[:3] + local @ rotation(q[3:7]).T

    def accelerations(self, q: Array, v: Array, a: Array) -> Array:
        """World accelerations (k, 3)."""
        local = np.cross(a[3:6], self.shape(q[7:])) + self.Phi @ a[6:]
        local = local + self.bias(q[7:], v[3:6], v[6:])
        return a[:3] + local @ rotation(q[3:7]).T

    def momentum(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Linear momentum and angular momentum about the world's origin."""
        P = self.m[:, None] * self.velocities(q, v)
        return P.sum(axis=0), np.cross(self.positions(q), P).sum(axis=0)

    def kinetic(self, q: Array, v: Array) -> float:
        return 0.5 * float(np.einsum("k,ka,ka", self.m, *2 * [self.velocities(q, v)]))


def rigid_particles(mass: float, inertia: Array, center: Array) -> Particles:
    """Six equal masses on the principal axes with the given inertia about the centre."""
    G = 0.5 * np.trace(inertia) * np.eye(3) - inertia
    values, axes = np.linalg.eigh(G)
    arms = np.sqrt(3 * np.maximum(values, 0) / mass) * axes
    u0 = center + np.concatenate([arms.T, -arms.T])
    return Particles(np.full(6, mass / 6), u0, np.zeros((6, 3, 0)))


def cross_axes(a: Array, b: Array) -> tuple[float, Array]:
    """Length and axes (columns) of a straight member, z up, or along x if it stands upright."""
    length = float(np.linalg.norm(b - a))
    x = (b - a) / length
    up = np.array([0.0, 0.0, 1.0]) if np.hypot(x[0], x[1]) > 1e-6 else np.array([1.0, 0.0, 0.0])
    z = up - (up @ x) * x
    z /= np.linalg.norm(z)
    return length, np.stack([x, np.cross(z, x), z], axis=1)


def hermite(xi: float, L: float) -> tuple[Array, Array]:
    """Section translation (3, 12) and rotation (3, 12) from local end displacements at x = xi L.

    Cubic Hermite polynomials in bending (rz = v', ry = -w'), linear in stretching and twisting.
    """
    f = [1 - 3 * xi**2 + 2 * xi**3, L * (xi - 2 * xi**2 + xi**3)]
    f += [3 * xi**2 - 2 * xi**3, L * (xi**3 - xi**2)]
    d = [6 * (xi**2 - xi) / L, 1 - 4 * xi + 3 * xi**2]
    d += [6 * (xi - xi**2) / L, 3 * xi**2 - 2 * xi]
    N, T = np.zeros((3, 12)), np.zeros((3, 12))
    for i, line in ((0, N), (3, T)):
        line[0, [i, i + 6]] = 1 - xi, xi
    N[1, [1, 5, 7, 11]] = f
    N[2, [2, 4, 8, 10]] = f[0], -f[1], f[2], -f[3]
    T[2, [1, 5, 7, 11]] = d
    T[1, [2, 4, 8, 10]] = -d[0], d[1], -d[2], d[3]
    return N, T


def frame_particles(
    nodes: Array,
    elements: Array,
    section: Any,
    material: Material,
    translations: Array,
    rotations: Array,
    *,
    lumped: bool,
    rotary: bool,
) -> Particles:
    """Particles of a frame of Euler-Bernoulli beams with nodal mode shapes (nn, 3, n).

    Consistent mass: six Gauss points along each element, exact for the product of two cubic
    displacements. Every section is four particles at (+-sqrt(Iz/A), +-sqrt(Iy/A)), which have its
    second moments, or one at its centre without rotary inertia. Lumped mass: the two half elements
    turn with their nodes.
    """
    arms = np.zeros((1, 3))
    if rotary:
        y, z = np.sqrt(section.Iz / section.A), np.sqrt(section.Iy / section.A)
        arms = np.array([[0, y, z], [0, -y, z], [0, y, -z], [0, -y, -z]])
    m, u0, Phi = [], [], []
    for ends in elements:
        a, b = nodes[ends[0]], nodes[ends[1]]
        L, A = cross_axes(a, b)
        local = np.concatenate([A.T @ x[i] for i in ends for x in (translations, rotations)])
        if lumped:
            places = [(0.0, 0.5), (1.0, 0.5)]
        else:
            x, weight = np.polynomial.legendre.leggauss(6)
            places = list(zip((x + 1) / 2, weight / 2, strict=True))
        for xi, share in places:
            N, T = hermite(xi, L)
            if lumped:  # the section turns with the node, not with the slope
                N, T = np.zeros((3, 12)), np.zeros((3, 12))
                N[:, 6 * round(xi) : 6 * round(xi) + 3] = np.eye(3)
                T[:, 6 * round(xi) + 3 : 6 * round(xi) + 6] = np.eye(3)
            for s in arms:
                m.append(material.rho * section.A * L * share / len(arms))
                u0.append(a + xi * (b - a) + A @ s)
                Phi.append(A @ (N - skew(s) @ T) @ local)
    return Particles(np.array(m), np.array(u0), np.array(Phi))


def beam_particles(
    body: FlexibleBody, section: Any, material: Material, *, lumped: bool, rotary: bool
) -> Particles:
    """Particles of a flexible body made of Euler-Bernoulli beams of one section."""
    reduced = body.reduced
    assert reduced.rotations is not None
    return frame_particles(
        reduced.nodes,
        reduced.elements,
        section,
        material,
        reduced.modes,
        reduced.rotations,
        lumped=lumped,
        rotary=rotary,
    )
