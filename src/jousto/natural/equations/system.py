"""Machine: positions, constraints and forces of a mechanism in natural coordinates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.mechanism import Mechanism
from jousto.natural.equations.block_matrix import Layout, Slopes
from jousto.natural.equations.bodies import Bodies, Shape
from jousto.natural.equations.constraints import Rows
from jousto.natural.equations.coordinates import Scalars
from jousto.natural.equations.force_laws import LAWS
from jousto.natural.equations.frames import Frames, Pose
from jousto.natural.equations.friction import friction_law
from jousto.natural.equations.instant import Action, Instant, Law
from jousto.natural.equations.supported import check_known

LEAST = 1e-12
"""Regularisation of the matrix of a joint, relative to constraints of size 1."""


@dataclass(eq=False)
class Place:
    """Position with the quantities that depend on it alone.

    Attributes
    ----------
    q : array (N,)
        Coordinates.
    shape : Shape
        Bodies with their mass integrals.
    pose : Pose
        Markers with their derivatives.
    s : array (ns,)
        Values of the scalar functions.
    gradients : array (ns, 2, 4, 3)
        Their derivatives by both markers.
    slopes, Cq : Slopes
        Derivatives of the scalar functions and of the constraints by the coordinates of bodies.
    C : array (m,)
        Constraint residuals.
    """

    q: Array
    shape: Shape
    pose: Pose
    s: Array
    gradients: Array
    slopes: Slopes
    Cq: Slopes
    C: Array


class Moving(Protocol):
    """Interface of a position with velocities and forces."""

    place: Place
    v: Array
    action: Action


class Machine:
    """Bodies, markers, constraint rows and force laws of a mechanism.

    Parameters
    ----------
    mechanism : Mechanism
        Mechanism that passes `check_known`.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        check_known(mechanism)
        self.mechanism = mechanism
        self.gravity = np.asarray(mechanism.gravity)
        self.bodies = Bodies.of(mechanism.bodies)
        self.frames = Frames(mechanism.bodies, self.bodies)
        self.scalars = Scalars(self.frames)
        self.rows = Rows(mechanism, self.frames, self.scalars)
        self.laws: list[Law] = []
        self.felt: dict[int, int] = {}
        for force in mechanism.forces:
            self.felt[id(force)] = len(self.laws)
            self.laws += [LAWS[p.kind](p, self.frames, self.scalars) for p in force.pushes]
        for friction in mechanism.frictions:
            self.felt[id(friction)] = len(self.laws)
            self.laws.append(friction_law(friction, self.rows, self.scalars))
        self.rubs = bool(mechanism.frictions)
        self.pressed = self.rubs or bool(
            self.rows.signals
        )  # whether friction or work depends on multipliers
        self.size = float(mechanism.size)

    def close(self) -> None:
        """Build the arrays after sensors have added their markers and coordinates."""
        self.frames.close()
        self.scalars.close()
        self.rows.close(self.scalars)
        self.limit = self.rows.scales(self.scalars, self.size)
        self.N = len(self.bodies.mass) * self.bodies.width
        ends = self.frames.body[self.scalars.ends]
        modes = [b.n if isinstance(b, FlexibleBody) else 0 for b in self.mechanism.bodies]
        self.layout = Layout(self.rows.F, ends, np.array(modes), self.bodies.width)

    def place(self, q: Array, t: float, near: Array) -> Place:
        """Return a position; angles are nearest to the values `near` of the previous instant."""
        pose = self.frames.evaluate(q)
        s = self.scalars.values(pose.y, near)
        gradients = self.scalars.gradients(pose.y)
        slopes = Slopes(self.layout.functions, self.scalars.blocks(pose, gradients))
        Cq = self.layout.rows(slopes)
        C = np.asarray(self.layout.F @ s) - self.rows.offset - self.rows.driven(t, 0)
        return Place(q, self.bodies.shaped(q), pose, s, gradients, slopes, Cq, C)

    def act(self, place: Place, v: Array, t: float, lam: Array) -> tuple[Array, Action]:
        """Return the generalised forces Q (N,) without constraint forces, and their parts."""
        nb, w = len(self.bodies.mass), self.bodies.width
        rate = place.slopes.times(v)
        now = Instant(t, place.q, v, place.pose, place.s, rate, place.gradients, lam)
        out = Action(np.zeros(self.scalars.count), np.zeros_like(place.pose.y), np.zeros((nb, w)))
        for law in self.laws:
            law(now, out)
        Q = self.bodies.loads(place.shape, v, self.gravity) + out.direct
        if self.laws:
            Q = Q + place.pose.generalised(out.loads)
        return Q.ravel() + place.slopes.pulled(out.along), out

    def velocity_gaps(self, place: Place, v: Array, t: float) -> Array:
        """Return ``C' = Cq q' + C_t`` (m,)."""
        return place.Cq.times(v) - self.rows.driven(t, 1)

    def drift(self, place: Place, v: Array, t: float) -> tuple[Array, Array]:
        """Return y'' (nm, 4, 3) and ``C''`` (m,) for q'' = 0."""
        drift = self.frames.drift(place.q, v)
        seconds = self.scalars.seconds((place.pose.y, place.pose.rates(v), drift))
        return drift, np.asarray(self.layout.F @ seconds) - self.rows.driven(t, 2)

    def mass(self, place: Place) -> Array:
        """Return the mass matrices (nb, 12 + n, 12 + n)."""
        return self.bodies.mass_matrix(place.shape)

    def times(self, M: Array, x: Array) -> Array:
        """Return ``M x`` (N,) of mass matrices."""
        return np.asarray((M @ x.reshape(len(M), -1, 1)).ravel())

    def energies(self, motion: Moving) -> dict[str, float]:
        """Return the terms of the energy balance, J; losses and work are zero here."""
        place, v = motion.place, motion.v
        return {
            "kinetic": 0.5 * float(v @ self.times(self.mass(place), v)),
            "strain": self.bodies.strain(place.shape),
            "potential": self.bodies.potential(place.shape, self.gravity),
            "springs": motion.action.stored,
            "dissipated": 0.0,
            "friction": 0.0,
            "work": 0.0,
        }

    def effective(self, place: Place) -> Array:
        """Return the effective mass (m,) of each constraint, with its joint's other constraints.

        The effective mass is a diagonal entry of the inverse of ``Cq M^-1 Cq^T`` of the joint.
        """
        first = self.rows.joints
        held = self.layout.constraints.bodies[:first]
        each = self.bodies.yielding(place.shape, place.Cq.blocks[:first], held)
        joints = np.zeros(first)
        for rows in self.rows.together:
            y, of = each[rows], held[rows]
            same = of[:, :, None, :, None] == of[:, None, :, None, :]
            S = np.sum(np.einsum("aiew,ajfw->aijef", y, y) * same, axis=(3, 4))
            own = np.maximum(np.diagonal(S, axis1=1, axis2=2), 1e-300)
            size = np.sqrt(own)
            S = S / (size[:, :, None] * size[:, None, :]) + LEAST * np.eye(rows.shape[1])
            joints[rows] = np.diagonal(np.linalg.inv(S), axis1=1, axis2=2) / own
        joints = np.minimum(joints, 1e12 * joints.min(initial=np.inf))
        return np.concatenate([joints, self.bodies.stiffness_of_axes(place.shape).ravel()])
