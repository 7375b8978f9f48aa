"""Rigid run of an outer cycle: motion and joint forces that the parts get as their loads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.recovery.loads.attribution import sources
from jousto.recovery.loads.own_loads import own_loads
from jousto.recovery.shape import rotation_matrices
from jousto.simulation.results.solution import Solution
from jousto.simulation.state import MEMORY, State, put


@dataclass(frozen=True, eq=False)
class FrozenRun:
    """Stored states of a rigid run with accelerations and multipliers.

    Attributes
    ----------
    model : Model
        Model of the rigid machine.
    states : tuple of State
        Stored states, with the internal states of forces.
    time : (nt,) array
        Instants, s.
    pose, velocity, acceleration : (nt, nb, 7), (nt, nb, 6), (nt, nb, 6) array
        ``[R e]``, ``[R' w]`` and ``[R'' w']`` of each body; R' and R'' in the world frame, w and w'
        in the body frame.
    multipliers : (nt, nrow) array
        Lagrange multipliers of the joints and couplings.
    """

    model: Model
    states: tuple[State, ...]
    time: Array
    pose: Array
    velocity: Array
    acceleration: Array
    multipliers: Array

    def moved(self, slopes: Sequence[FrozenRun], step: Array) -> FrozenRun:
        """Return the run ``self + sum slopes_i step_i``, with unit Euler parameters.

        Parameters
        ----------
        slopes : sequence of FrozenRun
            Derivatives by each parameter.
        step : (nd,) array
            Changes of the parameters.
        """
        found = {
            name: getattr(self, name)
            + sum(h * getattr(one, name) for h, one in zip(step, slopes, strict=True))
            for name in ARRAYS
        }
        e = found["pose"][..., 3:]
        e /= np.linalg.norm(e, axis=-1, keepdims=True)
        return replace(self, **found)

    def slope(self, other: FrozenRun, width: float) -> FrozenRun:
        """Return ``(self - other) / width``."""
        found = {n: (getattr(self, n) - getattr(other, n)) / width for n in ARRAYS}
        return replace(self, **found)


ARRAYS = ("pose", "velocity", "acceleration", "multipliers")
"""Arrays of a `FrozenRun` that depend on the design."""


CLOSED = 1e-6
"""Gap of the joints / size of the machine, above which the rigid machine does not run."""


def frozen_run(run: Solution, model: Model) -> FrozenRun:
    """Return motion and multipliers of a run of a rigid machine at its stored instants.

    Raises
    ------
    InputError
        If joints disagree, such as drives that only an elastic body can follow.
    """
    engine = Engine(replace(model, tree=()))
    at = [(body.iq, body.iv) for body in model.bodies]
    states = tuple(replace(state, work=None, joint=None) for state in run.each_state())
    pose, velocity = np.empty((run.nt, len(at), 7)), np.empty((run.nt, len(at), 6))
    acceleration, multipliers = np.empty_like(velocity), np.empty((run.nt, model.nrow))
    for i, state in enumerate(states):
        engine.lam[:] = 0.0  # multipliers of joints that an event has released
        put(engine, state, run.where)
        a, lam = engine.accelerations()
        gap = engine.residuals()[0]
        if not gap <= CLOSED * model.size:
            message = f"its joints disagree by {gap:.2g} m at {state.time:g} s"
            raise InputError(Problem("", message))
        multipliers[i] = lam
        for k, (q, v) in enumerate(at):
            pose[i, k], velocity[i, k] = engine.q[q : q + 7], engine.v[v : v + 6]
            acceleration[i, k] = a[v : v + 6]
    return FrozenRun(model, states, run.time, pose, velocity, acceleration, multipliers)


@dataclass(frozen=True, eq=False)
class PartLoads:
    """Loads on a flexible body that moves as in a rigid run, undeformed.

    Attributes
    ----------
    rows : (nt, ns, 6 + n) array
        Force, N, moment about the origin of the body frame, N m, and modal forces of each joint,
        force and friction, body frame.
    own : (nt, 6 + n) array
        Inertia forces (d'Alembert) and weight of the body.
    joints : (ns,) bool array
        Mask of the rows that are joints.
    """

    rows: Array
    own: Array
    joints: Array

    @property
    def total(self) -> Array:
        """Sum of all loads (nt, 6 + n)."""
        return np.asarray(self.rows.sum(axis=1) + self.own)

    @property
    def interface(self) -> Array:
        """Loads of the joints (nt, nj, 6): force and moment."""
        return np.asarray(self.rows[:, self.joints, :6])


def loads_on_parts(model: Model, frozen: FrozenRun, bodies: Sequence[int]) -> list[PartLoads]:
    """Return the loads on flexible bodies of a model in the motion of a rigid run.

    Forces and joints act through the modes of the bodies at ``p = 0``, joints with the multipliers
    of the rigid run; inertia forces are those of the rigid accelerations.

    Parameters
    ----------
    model : Model
        Flexible machine with the bodies and joints of the rigid one.
    frozen : FrozenRun
    bodies : sequence of int
        Indices of the bodies.
    """
    engine = Engine(replace(model, tree=()))
    kinds = {k: sources(model, k) for k in bodies}
    rows = {k: np.empty((len(frozen.time), len(kinds[k]), 6 + model.bodies[k].n)) for k in bodies}
    for i, state in enumerate(frozen.states):
        engine.q[:], engine.v[:] = flexible_state(model, frozen, i)
        set_memory(engine, state)
        engine.lam[:] = frozen.multipliers[i]
        for k in bodies:
            every = engine.body_loads(k)
            for j, source in enumerate(kinds[k]):
                rows[k][i, j] = every[list(source.rows)].sum(axis=0)
    found = []
    for k in bodies:
        joints = np.array([source.kind in ("joint", "drive", "coupling") for source in kinds[k]])
        found.append(PartLoads(rows[k], own_part_loads(model, frozen, k), joints))
    return found


def set_memory(engine: Engine, state: State) -> None:
    """Set time, inputs and internal states of an engine to those of a stored state."""
    engine.time[0] = state.time
    for name in MEMORY:
        value = getattr(state, name, None)
        if name not in ("input", "meters", "joint") and value is not None:
            getattr(engine, name)[:] = value
    if state.states is None:
        engine.start_states()
    for i, name in enumerate(engine.model.inputs):
        if state.inputs is not None and name in state.inputs:
            engine.input[i] = state.inputs[name]
    engine.restart()


def flexible_state(model: Model, frozen: FrozenRun, i: int) -> tuple[Array, Array]:
    """Return positions and velocities of the flexible model, undeformed, in a rigid state."""
    q, v = np.zeros(model.nq), np.zeros(model.nv)
    for k, body in enumerate(model.bodies):
        q[body.iq : body.iq + 7] = frozen.pose[i, k]
        v[body.iv : body.iv + 6] = frozen.velocity[i, k]
    return q, v


def own_part_loads(model: Model, frozen: FrozenRun, k: int) -> Array:
    """Return inertia forces and weight (nt, 6 + n) of an undeformed body in a rigid motion."""
    body = model.bodies[k]
    A = rotation_matrices(frozen.pose[:, k, 3:7])
    none = np.zeros((len(A), body.n))
    velocity, acceleration = frozen.velocity[:, k].copy(), frozen.acceleration[:, k].copy()
    for x in (velocity, acceleration):
        x[:, :3] = np.einsum("tba,tb->ta", A, x[:, :3])
    felt = np.einsum("tba,b->ta", A, np.real(model.gravity))
    q = np.hstack([frozen.pose[:, k], none])
    loads = own_loads(body, felt, q, np.hstack([velocity, none]), np.hstack([acceleration, none]))
    return np.asarray(sum(loads.values()))
