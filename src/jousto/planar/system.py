"""System: equations of motion of a planar frame, with exact tangents.

All displacements u = [nodes; ends of offset beams] are functions u = f(q) of the unknowns q, and

    r(q, v, a, t) = B^T [ F_int(u, u') + M (u'' + alpha u' - g) - F_ext(u, t) ] = 0.

All functions accept complex numbers, so that complex steps can check the tangents.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from jousto.base.object_repr import described
from jousto.planar.element import (
    Middle,
    gradient,
    hessian,
    middle,
    viscous,
)
from jousto.planar.elimination import (
    CoupledMotion,
    Elimination,
)
from jousto.planar.items import PlanarLoad

Array = NDArray[Any]

Tangents: TypeAlias = bool | Literal["symmetric"]
"""Whether Newton's matrix has K_acc and C_acc of eq. 13, or their symmetric part."""


class Loads:
    """External forces on the slaves u at one time or load factor.

    Parameters
    ----------
    loads : sequence of (PlanarLoad, int)
        Loads, each with the index of the first displacement of its node in u.
    weight : (slaves,) array
        Forces of gravity.
    factors : sequence of float
        Factor of each load.
    gravity : float
        Factor of gravity.
    """

    def __init__(
        self,
        loads: Sequence[tuple[PlanarLoad, int]],
        weight: Array,
        factors: Sequence[float],
        gravity: float = 1.0,
    ) -> None:
        self.dead = gravity * weight
        self.following: list[tuple[int, float, float]] = []
        for (load, k), factor in zip(loads, factors, strict=True):
            fx, fy = load.force[0] * factor, load.force[1] * factor
            self.dead[k + 2] += load.moment * factor
            if not load.follow:
                self.dead[k] += fx
                self.dead[k + 1] += fy
            elif fx != 0.0 or fy != 0.0:
                self.following.append((k, fx, fy))

    def force(self, u: Array) -> Array:
        """Return F_ext."""
        if not self.following:
            return self.dead
        F = self.dead.astype(np.result_type(self.dead, u))
        for k, fx, fy in self.following:
            c, s = np.cos(u[k + 2]), np.sin(u[k + 2])
            F[k] += c * fx - s * fy
            F[k + 1] += s * fx + c * fy
        return F

    def add_stiffness(self, u: Array, K: Array) -> None:
        """Subtract dF_ext/du from K, in place."""
        for k, fx, fy in self.following:
            c, s = np.cos(u[k + 2]), np.sin(u[k + 2])
            K[k, k + 2] += s * fx + c * fy
            K[k + 1, k + 2] -= c * fx - s * fy


class Point(NamedTuple):
    """Displacements, strains, forces and residual at one state.

    Attributes
    ----------
    q, v, a : (n,) array
        Unknowns, velocities, accelerations.
    slaves : CoupledMotion
    middle : Middle
        Strains and resultants.
    inner, force : (slaves,) array
        F_int, and the sum in brackets of the equations of motion.
    residual : (n,) array
        ``B^T force``.
    """

    q: Array
    v: Array
    a: Array
    slaves: CoupledMotion
    middle: Middle
    inner: Array
    force: Array
    residual: Array


@described
@dataclass(frozen=True, eq=False)
class System:
    """Equations of motion of a frame in arrays.

    Attributes
    ----------
    elimination : Elimination
        Coupling from unknowns q to displacements u.
    free : (nf,) array of int
        Indices of the unsupported unknowns.
    names : tuple of str
        Names of the unknowns in messages.
    T, z0, length, D :
        Shape matrix (4 ne, slaves), unloaded z (4 ne,), lengths (ne,), m, and stiffness (ne, 3) of
        the elements.
    M : (slaves, slaves) array
    loads : tuple of (PlanarLoad, int)
    weight : (slaves,) array
    alpha, beta : float
        Mass- and stiffness-proportional damping, 1/s and s.
    count : int
        Number of nodes, which precede the ends of offset beams in u.
    """

    elimination: Elimination
    free: Array
    names: tuple[str, ...]
    T: Array
    z0: Array
    length: Array
    D: Array
    M: Array
    loads: tuple[tuple[PlanarLoad, int], ...]
    weight: Array
    alpha: float
    beta: float
    count: int

    @property
    def size(self) -> int:
        """Number of unknowns, including supported ones."""
        return self.elimination.map.shape[1]

    def at_time(self, t: float) -> Loads:
        """Return the loads at a time, by their signals."""
        factors = [1.0 if load.signal is None else load.signal(t) for load, _ in self.loads]
        return Loads(self.loads, self.weight, factors)

    def at_factor(self, factor: float) -> Loads:
        """Return the loads of statics, multiplied by a load factor."""
        return Loads(self.loads, self.weight, [factor] * len(self.loads), factor)

    def evaluate(self, q: Array, v: Array, a: Array, loads: Loads) -> Point:
        """Return residual, forces and strains at a state."""
        s = self.elimination.slaves(q, v, a)
        z = (self.T @ s.u + self.z0).reshape(-1, 4)
        rate = (self.T @ s.v).reshape(-1, 4) if self.beta else None
        m = middle(z, self.D, self.beta, rate)
        inner = (gradient(m) * self.length[:, None]).ravel() @ self.T
        force = inner + self.M @ (s.a + self.alpha * s.v) - loads.force(s.u)
        return Point(q, v, a, s, m, inner, force, s.B.T @ force)

    def slave_stiffness(self, p: Point, loads: Loads) -> Array:
        """Return dF/du of the slaves at constant B: K_t minus the tangents of the loads."""
        H = hessian(p.middle, self.D, self.beta) * self.length[:, None, None]
        n = self.T.shape[1]
        K: Array = self.T.T @ (H @ self.T.reshape(-1, 4, n)).reshape(-1, n)
        loads.add_stiffness(p.slaves.u, K)
        return K

    def slave_damping(self, p: Point) -> Array:
        """Return dF/du' of the slaves."""
        C = self.alpha * self.M
        if self.beta:
            V = viscous(p.middle, self.D, self.beta) * self.length[:, None, None]
            n = self.T.shape[1]
            C = C + self.T.T @ (V @ self.T.reshape(-1, 4, n)).reshape(-1, n)
        return C

    def tangent(
        self, p: Point, loads: Loads, c: float, m: float, inertia_tangents: Tangents = True
    ) -> Array:
        """Return ``dr/dq + c dr/dv + m dr/da``.

        Parameters
        ----------
        p : Point
        loads : Loads
        c, m : float
            Derivatives of velocities, 1/s, and accelerations, 1/s^2, by the unknowns in the method.
        inertia_tangents : bool or "symmetric"
            False omits K_acc and C_acc of eq. 13; "symmetric" takes ``(X + X^T) / 2`` of each.
        """
        if inertia_tangents == "symmetric":
            K, C = self.elimination.inertia_tangents(p.q, p.v, p.a, self.M)
            X = K + c * C
            return self.tangent(p, loads, c, m, False) + 0.5 * (X + X.T)
        s, B, B1 = p.slaves, p.slaves.B, p.slaves.B1
        K, C = self.slave_stiffness(p, loads), self.slave_damping(p)
        inner = (K + c * C + m * self.M) @ B + C @ B1
        held = p.force
        if inertia_tangents:
            inner += self.M @ (self.elimination.map.B2(p.q, p.v, p.a) + (2.0 * c) * B1)
        else:
            held = held - self.M @ s.a
        return np.asarray(B.T @ inner + self.elimination.map.Kg(p.q, held))

    def stiffness(self, p: Point, loads: Loads) -> Array:
        """Return K of eq. 6: the static tangent stiffness, with loads."""
        held = p.inner - loads.force(p.slaves.u)
        K = self.slave_stiffness(p, loads)
        return np.asarray(p.slaves.B.T @ K @ p.slaves.B + self.elimination.map.Kg(p.q, held))

    def scale(self, p: Point, loads: Loads) -> float:
        """Return the largest norm of the forces, N and N m, the scale of relative criteria."""
        B = p.slaves.B
        parts = (p.inner, loads.force(p.slaves.u), self.M @ p.slaves.a)
        return max(float(np.linalg.norm((B.T @ F)[self.free])) for F in parts)

    def rounding(self, p: Point) -> float:
        """Return the rounding error of the residual; strains are differences of coordinates."""
        u = np.abs(p.slaves.u)
        size = max(1e-300, float(u[0::3].max()), float(u[1::3].max()))
        forces = self.D[:, :2].max(axis=1) * (1.0 + size / self.length)
        return 4.0 * float(np.finfo(float).eps) * float(np.linalg.norm(forces))

    def energies(self, p: Point) -> tuple[float, float]:
        """Return kinetic and strain energy, J."""
        strain = 0.5 * np.sum(self.length * np.sum(self.D * p.middle.strains**2, axis=1))
        return 0.5 * float(p.slaves.v @ self.M @ p.slaves.v), float(strain)
