"""Stepper: trapezoidal rule with augmented Lagrangian and two projections.

The equations of motion ``M q'' + Cq^T (alpha C + lam*) = Q`` (S62) with the trapezoidal rule (S64,
S65) are solved for the positions (S67-S71), where lam* increases by ``alpha C`` in every iteration
(S63); then velocities and accelerations are projected onto the constraints with the matrix of the
last iteration (S72, S73).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import SimulationError
from jousto.natural.equations.block_matrix import Solve, Term
from jousto.natural.equations.instant import Action
from jousto.natural.equations.system import Machine, Place

DIVERGED = 1e3  # relative increment from which on an iteration diverges
PENALTY = 1e6  # penalty: alpha h^2 / 4 over the effective mass of a constraint
TOLERANCE = 1e-9  # relative increment at which the iteration of a step has converged
PROJECTIONS = 5  # number of iterations of the velocity multipliers
MOST = 10  # maximum number of iterations of the acceleration multipliers
FRICTION = 30  # maximum number of these iterations if forces depend on multipliers
# velocity residual, relative to its largest term, below which the initial velocities are consistent
CLOSED = 1e-9
AGREED = 1e-12  # change of multipliers over the largest one, below which it is zero


@dataclass(eq=False)
class Motion:
    """State of a machine with accelerations, multipliers and forces.

    Attributes
    ----------
    t : float
        Time, s.
    place : Place
        Position.
    v, a : arrays (N,)
        Velocities and accelerations.
    lam : array (m,)
        Multipliers: forces of constraints are ``-Cq^T lam``.
    lead : array (m,)
        Multipliers of the step minus `lam`, see `Stepper.step`.
    action : Action
        Forces.
    drift, bias : arrays (nm, 4, 3), (m,)
        y'' of the markers and C'' of the constraints for q'' = 0.
    iterations : int
        Number of Newton iterations of the step.
    """

    t: float
    place: Place
    v: Array
    a: Array
    lam: Array
    lead: Array
    action: Action
    drift: Array
    bias: Array
    iterations: int = 0


class Stepper:
    """Stepper of constant step.

    Parameters
    ----------
    machine : Machine
        The machine.
    h : float
        Step, s.
    start : Place
        Initial position, for the scale of the constraints.
    penalty : float
        ``alpha h^2 / 4`` over the effective mass of a constraint.
    tolerance : float
        Largest last increment and largest constraint residual of a converged iteration, relative to
        the size of the machine.
    most : int
        Maximum number of iterations of a step.
    """

    def __init__(
        self,
        machine: Machine,
        h: float,
        start: Place,
        *,
        penalty: float = PENALTY,
        tolerance: float = TOLERANCE,
        most: int = 20,
    ) -> None:
        self.machine, self.h, self.tolerance, self.most = machine, h, tolerance, most
        self.penalty = penalty
        self._weighed: Place | None = None
        self.weigh(start)
        self.scale = self._scale()
        self.limit = machine.limit

    def weigh(self, place: Place) -> None:
        """Set ``alpha h^2 / 4`` of every constraint from its effective mass at a position."""
        if place is not self._weighed:
            self.weight = self.penalty * self.machine.effective(place)
            self.alpha = self.weight * 4.0 / self.h**2
            self._weighed = place

    def _scale(self) -> Array:
        """Return the scales (N,) of increments of the coordinates."""
        bodies, frames = self.machine.bodies, self.machine.frames
        out = np.ones((len(bodies.mass), bodies.width))
        out[:, :3] = self.machine.size
        largest = np.zeros((len(bodies.mass) + 1, bodies.n))
        np.maximum.at(largest, frames.body, np.abs(frames.Phi).max(axis=1, initial=0.0))
        shape = largest[:-1]
        out[:, 12:] = self.machine.size / np.where(shape > 0.0, shape, 1.0)
        return np.asarray(out.ravel())

    def step(self, old: Motion) -> Motion:
        """Return the motion after one step.

        The multipliers of a step belong to the accelerations of the trapezoidal rule, which differ
        from those at the end of the step by ``h/3 q'''``. If friction or work depends on
        multipliers, the step is followed by a solution of the equations of motion for the
        multipliers at its end. The difference of the two sets of multipliers, `lead`, changes
        little from step to step; it is subtracted for the normal forces of friction.

        Raises
        ------
        SimulationError
            If the iteration does not converge.
        """
        machine, h = self.machine, self.h
        t, q0, v0, a0 = old.t + h, old.place.q, old.v, old.a
        hat_v, hat_a = -(2.0 / h * q0 + v0), -(4.0 / h**2 * q0 + 4.0 / h * v0 + a0)
        lam = old.lam + old.lead
        self.weigh(old.place)
        place = machine.place(q0 + h * v0 + 0.5 * h * h * a0, t, old.place.s)
        for iteration in range(1, self.most + 1):
            q = place.q
            v, a = 2.0 / h * q + hat_v, 4.0 / h**2 * q + hat_a
            Q, action = machine.act(place, v, t, lam - old.lead)
            M = machine.mass(place)
            pull = place.Cq.pulled(self.alpha * place.C + lam)
            residual = 0.25 * h * h * (machine.times(M, a) + pull - Q)
            solve = self._factor(M, place, action)
            change = -solve(residual)
            place = machine.place(q + change, t, old.place.s)
            lam = lam + self.alpha * place.C
            moved = float(np.abs(change / self.scale).max())
            open_ = float(np.abs(place.C / self.limit).max())
            if not (np.isfinite(open_) and moved < DIVERGED):
                break
            if moved < self.tolerance and open_ < 1e-3 * self.tolerance:
                return self._projected(old, place, lam, hat_v, hat_a, solve, iteration)
        raise SimulationError(
            f"the moving frame did not converge in {self.most} iterations at {t:.6g} s; take a "
            "shorter step, or a larger penalty if a body has almost no inertia",
            time=t,
        )

    def _factor(self, M: Array, place: Place, action: Action) -> Solve:
        """Return the factors of ``W = M + h/2 D + h^2/4 (Cq^T alpha Cq + K)`` (S71)."""
        machine, h = self.machine, self.h
        own = M.copy()
        n = machine.bodies.n
        k = np.arange(12, 12 + n)
        own[:, k, k] += 0.5 * h * machine.bodies.D + 0.25 * h * h * machine.bodies.K
        terms = []
        for where, K, D in action.slopes:
            H = 0.25 * h * h * K + 0.5 * h * D
            terms.append(
                Term(where[0], where[1], H)
                if isinstance(where, tuple)
                else place.slopes.term(where, H)
            )
        return machine.layout.solver(own, place.Cq, self.weight, terms)

    def _projected(
        self,
        old: Motion,
        place: Place,
        lam: Array,
        hat_v: Array,
        hat_a: Array,
        solve: Solve,
        iterations: int,
    ) -> Motion:
        """Return the motion with velocities and accelerations projected onto the constraints."""
        machine, h, t = self.machine, self.h, old.t + self.h
        v, a = 2.0 / h * place.q + hat_v, 4.0 / h**2 * place.q + hat_a
        for _ in range(2):
            gap = machine.velocity_gaps(place, v, t)
            v = v - solve(place.Cq.pulled(self.weight * gap))
        drift, bias = machine.drift(place, v, t)
        for _ in range(2):
            gap = place.Cq.times(a) + bias
            a = a - solve(place.Cq.pulled(self.weight * gap))
        _, action = machine.act(place, v, t, lam - old.lead)
        none = np.zeros_like(lam)
        motion = Motion(t, place, v, a, lam, none, action, drift, bias, iterations)
        if not machine.pressed:
            return motion
        true = self.balanced(motion)
        return replace(motion, lam=true.lam, lead=lam - true.lam, action=true.action)

    def start(self, place: Place, v: Array, t: float) -> Motion:
        """Return the motion for given positions and velocities, with balanced accelerations."""
        none = np.zeros(len(self.weight))
        drift, bias = self.machine.drift(place, v, t)
        _, action = self.machine.act(place, v, t, none)
        return self.balanced(Motion(t, place, v, 0.0 * v, none, none, action, drift, bias))

    def balanced(self, motion: Motion) -> Motion:
        """Return the motion with the accelerations and multipliers of the equations of motion.

        ``M a + Cq^T (alpha C'' + lam) = Q``, where lam increases by ``alpha C''`` until C'' = 0.
        Multipliers of redundant rows are not unique. Every iteration solves for the residual of the
        last one, which removes the rounding errors of the factors; these errors are large for modes
        in a node frame.
        """
        machine, place, v, t, lam = self.machine, motion.place, motion.v, motion.t, motion.lam
        self.weigh(place)
        M = machine.mass(place)
        solve = self._solver(M, place)
        for _ in range(FRICTION if machine.rubs else 1):
            Q, action = machine.act(place, v, t, lam)
            before, last, a = lam, np.inf, np.zeros_like(v)
            for _ in range(MOST):
                gap = place.Cq.times(a) + motion.bias
                pull = place.Cq.pulled(self.weight * gap + lam)
                a = a + solve(Q - machine.times(M, a) - pull)
                more = self.weight * (place.Cq.times(a) + motion.bias)
                lam = lam + more
                left, last = last, float(np.abs(more).max())
                least = AGREED * float(np.abs(lam).max())
                # the iteration has converged, or stagnates at round-off
                if last <= least or last > 0.5 * left:
                    break
            if float(np.abs(lam - before).max()) <= max(least, 2.0 * last):
                break
        return replace(motion, a=a, lam=lam, action=action)

    def _solver(self, M: Array, place: Place) -> Solve:
        return self.machine.layout.solver(M, place.Cq, self.weight, [])

    def velocities(self, place: Place, v: Array, t: float) -> Array:
        """Return the velocities nearest to v, in the metric of the mass, that satisfy constraints.

        Modal rates change only if the frames alone cannot satisfy the constraints.
        """
        machine = self.machine
        M = machine.mass(place)
        wanted = v
        for held in (True, False):
            own = M.copy()
            if held:
                k = np.arange(12, machine.bodies.width)
                own[:, k, k] *= 1e12
            solve = self._solver(own, place)
            lam = np.zeros(len(self.weight))
            for _ in range(PROJECTIONS):
                gap = machine.velocity_gaps(place, v, t)
                v = v - solve(
                    machine.times(own, v - wanted) + place.Cq.pulled(self.weight * gap + lam)
                )
                lam = lam + self.weight * machine.velocity_gaps(place, v, t)
            gap = machine.velocity_gaps(place, v, t)
            size = place.Cq.sizes(v) + np.abs(machine.rows.driven(t, 1))
            if np.all(np.abs(gap) <= CLOSED * size):
                return v
        return v

    def closed(self, q: Array, t: float, near: Array) -> Place:
        """Return the position nearest to q that satisfies the constraints."""
        machine = self.machine
        place = machine.place(q, t, near)
        for _ in range(self.most):
            if float(np.abs(place.C / self.limit).max(initial=0.0)) < 1e-13:
                break
            solve = self._solver(machine.mass(place), place)
            place = machine.place(place.q - solve(place.Cq.pulled(self.weight * place.C)), t, near)
        return place
