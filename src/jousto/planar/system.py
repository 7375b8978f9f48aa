"""System: equations of motion of a planar frame, with exact tangents.

All displacements u = [nodes; ends of offset beams; own ones of elements] are functions u = f(q) of
the unknowns q, and

    r(q, v, a, t) = B^T [ F_int(u, u') + M (u'' + alpha u' - g) - F_ext(u, t) ] = 0.

All functions accept complex numbers, so that complex steps can check the tangents.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from jousto.base.object_repr import described
from jousto.planar.element import ElementGroup, GroupState
from jousto.planar.elimination import (
    CoupledMotion,
    Elimination,
)
from jousto.planar.items import PlanarLoad, Prescribed, Signal

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
    groups : tuple of GroupState
        Strains and resultants of the groups of beams.
    inner, force : (slaves,) array
        F_int, and the sum in brackets of the equations of motion.
    residual : (n,) array
        ``B^T force``.
    """

    q: Array
    v: Array
    a: Array
    slaves: CoupledMotion
    groups: tuple[GroupState, ...]
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
    groups : tuple of ElementGroup
        Beams of each element.
    length, D, limits :
        Lengths (ne,), m, stiffness EA, GA, EI (ne, 3), and the largest stable axial force (ne,), N,
        of the beams.
    moved : tuple of (int, function)
        Unknowns with a prescribed motion, which returns value, rate and second rate.
    M : (slaves, slaves) array
    loads : tuple of (PlanarLoad, int)
    weight : (slaves,) array
    gravity_signal : function or None
        Factor of the weight as a function of time.
    alpha, beta : float
        Mass- and stiffness-proportional damping, 1/s and s.
    count : int
        Number of nodes, which precede the ends of offset beams in u.
    """

    elimination: Elimination
    free: Array
    names: tuple[str, ...]
    moved: tuple[tuple[int, Prescribed], ...]
    groups: tuple[ElementGroup, ...]
    length: Array
    D: Array
    limits: Array
    M: Array
    loads: tuple[tuple[PlanarLoad, int], ...]
    weight: Array
    gravity_signal: Signal | None
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
        gravity = 1.0 if self.gravity_signal is None else self.gravity_signal(t)
        return Loads(self.loads, self.weight, factors, gravity)

    def at_factor(self, factor: float) -> Loads:
        """Return the loads of statics, multiplied by a load factor."""
        return Loads(self.loads, self.weight, [factor] * len(self.loads), factor)

    def evaluate(self, q: Array, v: Array, a: Array, loads: Loads) -> Point:
        """Return residual, forces and strains at a state."""
        s = self.elimination.slaves(q, v, a)
        states = tuple(group.state(s.u, s.v, self.beta) for group in self.groups)
        inner = np.zeros(len(self.M), dtype=np.result_type(s.u, s.v))
        for group, state in zip(self.groups, states, strict=True):
            group.add_force(state, inner)
        force = inner + self.M @ (s.a + self.alpha * s.v) - loads.force(s.u)
        return Point(q, v, a, s, states, inner, force, s.B.T @ force)

    def slave_stiffness(self, p: Point, loads: Loads) -> Array:
        """Return dF/du of the slaves at constant B: K_t minus the tangents of the loads."""
        K = np.zeros(self.M.shape, dtype=p.inner.dtype)
        for group, state in zip(self.groups, p.groups, strict=True):
            group.add_stiffness(state, self.beta, K)
        loads.add_stiffness(p.slaves.u, K)
        return K

    def slave_damping(self, p: Point) -> Array:
        """Return dF/du' of the slaves."""
        C = self.alpha * self.M
        if self.beta:
            for group, state in zip(self.groups, p.groups, strict=True):
                group.add_damping(state, self.beta, C)
        return C

    def tangent(
        self,
        p: Point,
        loads: Loads,
        c: float | Array,
        m: float | Array,
        inertia_tangents: Tangents = True,
    ) -> Array:
        """Return ``dr/dq + c dr/dv + m dr/da``.

        Parameters
        ----------
        p : Point
        loads : Loads
        c, m : float or (n,) array
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
        if isinstance(c, np.ndarray):
            inner = K @ B + c * (C @ B) + m * (self.M @ B) + C @ B1
        else:
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
        u = np.abs(p.slaves.u[: 3 * self.count])
        size = max(1e-300, float(u[0::3].max()), float(u[1::3].max()))
        stiff = np.where(np.isfinite(self.D[:, :2]), self.D[:, :2], 0.0).max(axis=1)
        forces = stiff * (1.0 + size / self.length)
        # rows of rotations and stretches have these forces times the length
        forces = forces * np.hypot(1.0, self.length)
        return 4.0 * float(np.finfo(float).eps) * float(np.linalg.norm(forces))

    def energies(self, p: Point) -> tuple[float, float]:
        """Return kinetic and strain energy, J."""
        strain = sum(g.energy(s) for g, s in zip(self.groups, p.groups, strict=True))
        return 0.5 * float(p.slaves.v @ self.M @ p.slaves.v), strain

    def powers(self, p: Point, loads: Loads) -> tuple[float, float]:
        """Return the power of loads, gravity and prescribed motions, and that of damping, W."""
        u, v = p.slaves.u, p.slaves.v
        moved = [k for k, _ in self.moved]
        supplied = float(loads.force(u) @ v) + float(p.residual[moved] @ p.v[moved])
        lost = self.alpha * float(v @ self.M @ v)
        lost += sum(g.dissipation(s, self.beta) for g, s in zip(self.groups, p.groups, strict=True))
        return supplied, lost

    def means(self, p: Point) -> tuple[Array, Array]:
        """Return strains and resultants of the beams, (ne, 3) each, without damping."""
        strains, resultants = np.zeros(self.D.shape), np.zeros(self.D.shape)
        for group, state in zip(self.groups, p.groups, strict=True):
            strains[group.members], resultants[group.members] = group.law.means(state.z)
        return strains, resultants

    @cached_property
    def massless(self) -> Array:
        """Unsupported rotations without mass, but with stiffness, (k,): sections without rotary.

        They follow from the equilibrium of moments at each instant.
        """
        q = np.zeros(self.size)
        p, loads = self.evaluate(q, q, q, self.at_factor(0.0)), self.at_factor(0.0)
        B = p.slaves.B
        mass, stiffness = np.diag(B.T @ self.M @ B), np.diag(self.stiffness(p, loads))
        found = [
            i
            for i in self.free
            if self.names[i].startswith("r of") and mass[i] <= 0.0 < stiffness[i]
        ]
        return np.array(found, dtype=int)
