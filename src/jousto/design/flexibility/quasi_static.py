"""Deformation and vibration of elastic bodies along a run in which they are rigid."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.linalg as sl

from jousto.base.arrays import Array, Ints
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.scales import velocity_metres
from jousto.simulation.modes.linear import free_motions
from jousto.simulation.results.solution import Solution
from jousto.simulation.state import MEMORY, State, memory_sizes, put

INDEPENDENT = 1e-9
"""Singular value of the motions of the modes / the largest, below which a motion does not bend."""
OWN = 0.1
"""Share of a body in the strain energy of a mode, from which on it is a mode of the body."""


@dataclass(frozen=True, eq=False)
class HeldBodies:
    """Elastic bodies as the joints hold them, at nt instants of a run in which some are rigid.

    Small deviations u of the full machine from the run, in the motions N that its joints permit,
    obey ``N^T M N u'' + N^T K N u = f`` with the unbalanced force ``f = N^T M (a - a_r)``: a is the
    acceleration of the undeformed elastic machine, a_r that of the run. f is orthogonal to all
    motions that the run had already, so that it is carried by the elastic bodies alone: loads of
    the run with inertia relief, ``K^+ (F - M a_r)``.

    Attributes
    ----------
    time : (nt,) array
        Instants, s.
    states : tuple of State
        States of the full machine with the motion of the run; the rigid bodies are undeformed.
    modal : (n,) int array
        Indices of the modal velocities.
    static : (nt, n) array
        Static deformation p under the loads of the run, kg^0.5 m.
    shapes : tuple of (n, b) array
        Deformation in each of the b natural modes, mass-normalised, kg^0.5 m.
    inverses : tuple of (b, n) array
        Pseudoinverses of the shapes: amplitudes of the modes in a deformation.
    motions : tuple of (nv, b) array
        Increments of all bodies in the modes.
    omega : (nt, b) array
        Natural frequencies, rad/s; of unstable modes 0.
    damping : (nt, b) array
        ``2 zeta omega``, 1/s.
    bodies : (nt, b, nb) array
        Share of each body in the strain energy of each mode.
    """

    time: Array
    states: tuple[State, ...]
    modal: Ints
    static: Array
    shapes: tuple[Array, ...]
    inverses: tuple[Array, ...]
    motions: tuple[Array, ...]
    omega: Array
    damping: Array
    bodies: Array

    def first(self, body: int) -> float:
        """Return the lowest natural frequency of a body as the joints hold it, rad/s."""
        own = self.bodies[:, :, body] >= OWN
        found = np.where(own, self.omega, np.inf)
        return float(found.min(initial=np.inf))

    def increments(self, k: int, p: Array) -> Array:
        """Return the increments (nv,) of all bodies at instant k in a deformation p (n,)."""
        return np.asarray(self.motions[k] @ (self.inverses[k] @ p))


def held_bodies(full: Model, simple: Model, run: Solution, instants: Ints) -> HeldBodies:
    """Return the elastic bodies of the full machine along a run of the simpler one.

    Parameters
    ----------
    full : Model
        Machine with the elastic bodies.
    simple : Model
        The same machine with some of them rigid; model of the run.
    run : Solution
    instants : (nt,) int array
        Indices of stored instants.

    Raises
    ------
    InputError
        If the state of the run does not fit the full machine.
    """
    still, moving = Engine(replace(simple, tree=())), Engine(replace(full, tree=()))
    embed = Embedding(full, simple)
    modal = modal_velocities(full)
    found = []
    for state in run.each_state(instants):
        still.lam[:] = 0.0
        put(still, replace(state, work=None), run.where)
        a_r = embed.velocities(still.accelerations()[0])
        inside = embed.state(state)
        moving.lam[:] = 0.0
        put(moving, inside, run.where)
        a = np.array(moving.accelerations()[0])
        moving.a[:], moving.lam[:] = a_r, state.lam
        found.append((inside, *_held(moving, modal, a - a_r)))
    columns = list(zip(*found, strict=True))
    return HeldBodies(
        time=run.time[instants],
        states=columns[0],
        modal=modal,
        static=np.array(columns[1]),
        shapes=columns[2],
        inverses=tuple(np.linalg.pinv(shapes) for shapes in columns[2]),
        motions=columns[3],
        omega=np.array(columns[4]),
        damping=np.array(columns[5]),
        bodies=np.array(columns[6]),
    )


class Embedding:
    """States of a machine with rigid bodies as states of the machine with elastic ones."""

    def __init__(self, full: Model, simple: Model) -> None:
        self._full, sizes = full, memory_sizes(full)
        q, v = [], []
        for whole, part in zip(full.bodies, simple.bodies, strict=True):
            q += [(whole.iq + j, part.iq + j) for j in range(7 + part.n)]
            v += [(whole.iv + j, part.iv + j) for j in range(6 + part.n)]
        self._q, self._v = np.array(q, dtype=np.intp).T, np.array(v, dtype=np.intp).T
        same = {name for name, size in memory_sizes(simple).items() if sizes[name] == size}
        self._memory = [name for name in MEMORY if name in same and name not in ("input", "joint")]

    def velocities(self, v: Array) -> Array:
        """Return velocities or accelerations (nv,) with zero modal ones for rigid bodies."""
        out = np.zeros(self._full.nv)
        out[self._v[0]] = np.real(v)[self._v[1]]
        return out

    def state(self, state: State) -> State:
        """Return the state with undeformed bodies in place of rigid ones."""
        q = np.zeros(self._full.nq)
        q[self._q[0]] = state.q[self._q[1]]
        memory = {name: getattr(state, name) for name in self._memory if name != "meters"}
        v = self.velocities(state.v)
        return State(q, v, state.lam, state.time, inputs=state.inputs, **memory)


def _held(engine: Engine, modal: Ints, unbalanced: Array) -> tuple[Array, ...]:
    """Return static deformation and natural modes at the state of an engine."""
    model, nv = engine.model, engine.model.nv
    M, C, K = (engine.newton_matrix(*which)[:nv, :nv] for which in np.eye(3).tolist())
    N = admissible_motions(engine)
    stiffness = np.concatenate([np.real(b.K) for b in model.bodies])
    # static deformation by the strain energy alone
    U, s, Vt = np.linalg.svd(N[modal], full_matrices=False)
    b = int((s > INDEPENDENT * s.max(initial=0.0)).sum())
    U, s, Vt = U[:, :b], s[:b], Vt[:b]
    force = Vt @ (N.T @ (M @ unbalanced)) / s
    static = U @ np.linalg.solve(U.T @ (stiffness[:, None] * U), force)
    # natural modes; the b modes with the largest part of strain energy are those of the bodies
    MN, KN, CN = (_symmetric(N.T @ X @ N) for X in (M, K, C))
    values, vectors = sl.eigh(KN, MN)
    strain = stiffness[:, None] * (N[modal] @ vectors) ** 2
    share = strain.sum(axis=0) / np.maximum(np.abs(values), 1e-300)
    share[values <= 0.0] = 0.0
    elastic = np.sort(np.argsort(-share, kind="stable")[:b])
    motions = N @ vectors[:, elastic]
    omega = np.sqrt(np.maximum(values[elastic], 0.0))
    damping = np.einsum("ij,ij->j", vectors[:, elastic], CN @ vectors[:, elastic])
    own = _by_body(model, strain[:, elastic])
    return static, motions[modal], motions, omega, damping, own


def admissible_motions(engine: Engine) -> Array:
    """Return the increments (nv, f) that joints and drives permit, orthonormal in metres."""
    nv, metres = engine.model.nv, velocity_metres(engine.model)
    Cq = engine.newton_matrix(0.0, 1.0, 0.0)[nv:, :nv]
    return np.asarray(free_motions(engine.row_metres[:, None] * Cq / metres)[0] / metres[:, None])


def modal_velocities(model: Model) -> Ints:
    """Return the indices of the modal velocities in v."""
    return np.concatenate(
        [np.arange(b.iv + 6, b.iv + 6 + b.n, dtype=np.intp) for b in model.bodies]
    )


def _symmetric(X: Array) -> Array:
    return np.asarray(0.5 * (X + X.T))


def _by_body(model: Model, strain: Array) -> Array:
    """Return the share (b, nb) of each body in the strain energy (n, b) of modes."""
    ends = np.cumsum([0, *(body.n for body in model.bodies)])
    parts = np.array([strain[i:j].sum(axis=0) for i, j in zip(ends[:-1], ends[1:], strict=True)])
    whole = strain.sum(axis=0)
    return np.asarray((parts / np.where(whole > 0.0, whole, 1.0)).T)
