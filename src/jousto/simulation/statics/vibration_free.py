"""vibration_free_state: initial state from which elastic bodies do not vibrate."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, SimulationError
from jousto.model.initial_conditions import MOST, modal_velocities
from jousto.model.model import Model
from jousto.model.native.native import IMAGINARY, Engine, displaced
from jousto.model.packing.foreign import without_fmus
from jousto.model.scales import velocity_metres
from jousto.simulation.controllers import follow_filters, hold_controllers, without_states
from jousto.simulation.modes.linear import free_motions
from jousto.simulation.state import State, put, take

ITERATIONS = 60  # maximum number of iterations
FRESH = 8  # number of iterations with one Jacobian
CLOSE = 1e-12  # increment over the size of the mechanism at which the iteration has converged
FAR = 1e3  # increment over the size of the mechanism above which the iteration has diverged
SLOW = 0.1  # largest relative change of the bending by the inertia of p' and p''
RIGID = 1e-9  # singular value of modal rates, below which a motion does not bend any body
SHORT = 5e-3  # rotation of the fastest body between instants of a finite difference, rad
REST = 1e-5  # smallest speed in the step of differences over the lowest frequency of a body


@explained
def vibration_free_state(model: Model, state: State | None = None) -> State:
    """Return the state in which elastic bodies have the quasi-static shape of the motion.

    Bodies that start undeformed vibrate about the shape in equilibrium with loads and inertia
    forces, no matter whether drives, motors or initial velocities move the machine. In this state
    the modal coordinates p fulfil ``M a + Cq^T lam = Q``, where p' and p'' are the slow change of
    this shape, by finite differences along the motion. In a motion of the frequency W the remaining
    vibration of modes of the frequency w is of the order ``(W / w)^3`` of the bending. Positions
    and velocities of the rigid motions remain; a free pose changes by the smallest rotation that
    the bending requires.

    Parameters
    ----------
    model : Model
        From `compile`, with bodies that are rigid or have modes.
    state : State, optional
        State with the pose, velocities, time and inputs; None: the initial state.

    Returns
    -------
    State
        Initial state for ``simulate(model, t_end, state=...)``.

    Raises
    ------
    InputError
        If the mechanism has exact beams or is too large.
    SimulationError
        If the bodies are too soft for a quasi-static shape in this motion, or an undriven body
        moves about as fast as they vibrate.

    Examples
    --------
    ``run = jo.simulate(model, 2.0, state=jo.simulation.vibration_free_state(model))``
    """
    without_fmus(model, "vibration_free_state", "has no state at rest that is known")
    without_states(model, "vibration_free_state", "start from equilibrium")
    if model.beams or model.nv > MOST:
        why = (
            "exact beams are not supported; start them from equilibrium or steady_rotation"
            if model.beams
            else f"{model.nv} velocities are more than {MOST}; start from rest, slowly"
        )
        raise InputError(Problem(f"vibration_free_state {model.name!r}", why))
    held = hold_controllers(model)
    engine = Engine(held)
    if state is not None:
        put(engine, state, "vibration_free_state")
    engine.assemble()
    engine.accelerations()
    modal = np.flatnonzero(modal_velocities(model))
    if len(modal):
        _Slow(held, modal).settle(engine)
    follow_filters(held, engine)
    engine.accelerations()
    return take(engine)


@dataclass(frozen=True)
class _Motions:
    """Free motions at a position, orthonormal in metres.

    `inverse` is the pseudoinverse of Cq. `rigid` contains the free motions without bending,
    `bending` the other ones, (nv, f) each. `parts` (f, nv) maps a velocity to its coefficients of
    `rigid`, `follow` maps modal rates to coefficients of `bending`.
    """

    inverse: Array
    rigid: Array
    parts: Array
    bending: Array
    follow: Array


class _Scaled:
    """Linear equations with rows and columns scaled to size 1, since they differ by omega^2."""

    def __init__(self, A: Array) -> None:
        self._rows = np.maximum(np.abs(A).max(axis=1, initial=0.0), 1e-300)
        A = A / self._rows[:, None]
        self._columns = np.maximum(np.abs(A).max(axis=0, initial=0.0), 1e-300)
        self._A = A / self._columns

    def solve(self, b: Array) -> Array:
        """Return x from ``A x = b``."""
        x = np.linalg.lstsq(self._A, b / self._rows, rcond=None)[0]
        return np.asarray(x / self._columns)


class _Slow:
    """Solver for the quasi-static modal coordinates p in a motion of a mechanism.

    Parameters
    ----------
    model : Model
    modal : (m,) array
        Indices of the modal velocities in v.
    """

    def __init__(self, model: Model, modal: NDArray[np.int_]) -> None:
        self._model, self._modal = model, modal
        self._metres = velocity_metres(model)
        self._twin = Engine(model, complex_scalars=True)

    def settle(self, engine: Engine) -> None:
        """Set the engine to the quasi-static shape at its time, from its pose and velocities.

        The shapes at this instant and at two later ones are solved with p' = p'' = 0; then the
        shape at this instant with the p' and p'' of their differences. The correction is made
        once, since a second one would amplify round-off by ``1 / (w h)^2``.
        """
        v0, time = np.array(engine.v), float(engine.time[0])
        still = np.zeros(len(self._modal))
        self._bend(engine, v0, still, still)
        here, v, a = np.array(engine.q), np.array(engine.v), np.array(engine.a)
        lam = np.array(engine.lam)
        h = self._step(v, a)
        shapes = [self._p(here)]
        for ahead in (h, 2.0 * h):
            engine.q[:] = displaced(self._model, here, ahead * v + 0.5 * ahead**2 * a)
            engine.time[0], engine.lam[:] = time + ahead, lam
            self._bend(engine, v + ahead * a, still, still)
            shapes.append(self._p(engine.q))
        one, two, three = shapes
        engine.q[:], engine.a[:], engine.lam[:], engine.time[0] = here, a, lam, time
        rates = (-3.0 * one + 4.0 * two - three) / (2.0 * h)
        self._bend(engine, v0, rates, (one - 2.0 * two + three) / h**2)
        self._check_slow(one, self._p(engine.q), time)

    def _check_slow(self, still: Array, settled: Array, time: float) -> None:
        """Raise an error if the inertia of p' and p'' changes the bending by more than SLOW.

        In a slow motion the change is of the order ``(W / w)^2``, in the norm of the elastic
        energy; if this change is large, the neglected terms are large too.
        """
        K = np.concatenate([b.K for b in self._model.bodies])
        energy, other = (float(K @ p**2) for p in (still, settled - still))
        share = np.sqrt(other / energy) if energy > 0.0 else 0.0
        bent = np.abs(still * self._metres[self._modal]).max()
        if share > SLOW and bent > CLOSE * self._model.size:
            raise SimulationError(
                "the elastic bodies would have to bend about as fast as they vibrate (the inertia "
                f"of their bending changes it by {100.0 * share:.3g} %): a body without a "
                "drive, such as a hanging chain, swings too fast from this pose. Start from "
                "equilibrium(model) if the machine begins at rest, with slower drives or "
                "velocities, or from the initial state",
                time=time,
            )

    def _p(self, q: Array) -> Array:
        """Return the modal coordinates (m,)."""
        parts = [q[b.iq + 7 : b.iq + 7 + b.n] for b in self._model.bodies]
        return np.array(np.concatenate(parts))

    def _step(self, v: Array, a: Array) -> float:
        """Return the step s of finite differences, in which the fastest body turns by SHORT."""
        K = np.concatenate([b.K for b in self._model.bodies])
        fastest = REST * float(np.sqrt(K[K > 0.0].min()))
        for b in self._model.bodies:
            rigid = slice(b.iv, b.iv + 6)
            scale = self._metres[rigid] / self._model.size
            fastest = max(fastest, float(np.linalg.norm(v[rigid] * scale)))
            fastest = max(fastest, float(np.sqrt(np.linalg.norm(a[rigid] * scale))))
        return SHORT / fastest

    def _bend(self, engine: Engine, given: Array, rates: Array, accelerations: Array) -> None:
        """Solve for q, v, a and lam at the time of the engine, with given p' and p''.

        Unknowns are y and alpha: increments ``N_b y`` plus the correction that closes the joints,
        accelerations ``a_c + N_0 alpha``. N_0 are the free motions without bending, N_b the others.
        """
        for iteration in range(ITERATIONS):
            if iteration % FRESH == 0:
                free = self._motions(engine)
                count = free.bending.shape[1]
                engine.v[:] = self._velocities(engine, free, given, rates)
                before = np.array(engine.a)
                engine.a[:] = self._accelerations(engine, free, accelerations)
                alpha = free.parts @ (before - engine.a)
                engine.a[:] += free.rigid @ alpha
                K, M = self._slopes(engine)
                along = np.hstack([free.bending, free.rigid])
                system = _Scaled(along.T @ np.hstack([K @ free.bending, M @ free.rigid]))
            r, c = np.array(engine.residual()), np.array(engine.constraints()[0])
            closing = -free.inverse @ c
            solved = system.solve(-along.T @ (r + K @ closing))
            move = closing + free.bending @ solved[:count]
            far = float(np.abs(move * self._metres).max(initial=0.0)) / self._model.size
            if not far < FAR:
                break
            engine.q[:] = displaced(self._model, engine.q, move)
            alpha = alpha + solved[count:]
            left = r + K @ move + M @ (free.rigid @ solved[count:])
            engine.lam[:] -= free.inverse.T @ left
            if far <= CLOSE:  # converged: close the velocities to round-off
                drift = free.rigid @ alpha
                free = self._motions(engine)
                alpha = free.parts @ drift
            engine.v[:] = self._velocities(engine, free, given, rates)
            engine.a[:] = self._accelerations(engine, free, accelerations) + free.rigid @ alpha
            if far <= CLOSE:
                return
        raise SimulationError(
            "the quasi-static deformation did not converge: the elastic bodies are too soft for "
            "this motion; start with lower speeds, or from the initial state",
            time=float(engine.time[0]),
        )

    def _motions(self, engine: Engine) -> _Motions:
        """Return the free motions at the position of the engine."""
        metres, rows = self._metres, engine.row_metres
        N, inverse = free_motions(rows[:, None] * self._jacobian(engine) / metres)
        _, s, Vt = np.linalg.svd(N[self._modal])
        count = int((s > RIGID).sum())
        rigid, bending = N @ Vt[count:].T, N @ Vt[:count].T / metres[:, None]
        return _Motions(
            inverse=inverse / metres[:, None] * rows,
            rigid=rigid / metres[:, None],
            parts=rigid.T * metres,
            bending=bending,
            follow=np.linalg.pinv(bending[self._modal]),
        )

    def _velocities(self, engine: Engine, free: _Motions, given: Array, rates: Array) -> Array:
        """Return velocities (nv,) that satisfy the constraints, with rigid and modal parts."""
        engine.v[:] = 0.0
        v = -free.inverse @ engine.constraints()[1]
        v = v + free.rigid @ (free.parts @ (given - v))
        return np.asarray(v + free.bending @ (free.follow @ (rates - v[self._modal])))

    def _accelerations(self, engine: Engine, free: _Motions, modal: Array) -> Array:
        """Return accelerations (nv,) that satisfy the constraints and have a given modal part.

        Their part along the free rigid motions is zero.
        """
        twin, v = self._twin, np.array(engine.v)
        self._copy(engine)
        twin.q[:] = displaced(self._model, engine.q, 1j * IMAGINARY * v)
        twin.v[:], twin.time[0] = v, engine.time[0] + 1j * IMAGINARY
        a = -free.inverse @ (twin.constraints()[1].imag / IMAGINARY)
        a = a - free.rigid @ (free.parts @ a)
        return np.asarray(a + free.bending @ (free.follow @ (modal - a[self._modal])))

    def _copy(self, engine: Engine) -> None:
        names = ("time", "input", "turn", "locked", "slip", "happened", "states")
        for name in ("q", "v", "a", "lam", *names):
            getattr(self._twin, name)[:] = getattr(engine, name)

    def _jacobian(self, engine: Engine) -> Array:
        """Return the constraint Jacobian Cq (nrow, nv)."""
        model, twin = self._model, self._twin
        self._copy(engine)
        Cq = np.zeros((model.nrow, model.nv))
        for j, move in enumerate(engine.increments().T):
            twin.q[:] = engine.q + 1j * IMAGINARY * move
            Cq[:, j] = twin.constraints()[0].imag / IMAGINARY
        return Cq

    def _slopes(self, engine: Engine) -> tuple[Array, Array]:
        """Return the derivatives (nv, nv) of the residual by q and by a."""
        model, twin = self._model, self._twin
        self._copy(engine)
        K, M = np.zeros((model.nv, model.nv)), np.zeros((model.nv, model.nv))
        for j, move in enumerate(engine.increments().T):
            twin.q[:] = engine.q + 1j * IMAGINARY * move
            K[:, j] = twin.residual().imag / IMAGINARY
        twin.q[:] = engine.q
        for j in range(model.nv):
            twin.a[j] = engine.a[j] + 1j * IMAGINARY
            M[:, j] = twin.residual().imag / IMAGINARY
            twin.a[j] = engine.a[j]
        return K, M
