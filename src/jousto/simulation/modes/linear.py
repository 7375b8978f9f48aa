"""linearise, modes: linear motion of a mechanism about a state, in minimal coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array, skew
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.base.rotations import rotation_matrix
from jousto.model.model import Model
from jousto.model.native.native import IMAGINARY, Engine, displaced
from jousto.model.packing.foreign import without_fmus
from jousto.simulation.contacts import (
    STRETCH,
    bristle_rates,
    contact_states,
    without_sticking,
)
from jousto.simulation.controllers import (
    controllers,
    hold_controllers,
    moving_states,
    without_delays,
    without_states,
)
from jousto.simulation.second_order import where_noticed
from jousto.simulation.state import State, put

Eigenvalues = NDArray[np.complex128]
NOTICED = 1e-3  # spin over the lowest frequency, above which modes at rest warn of it
GROWTH = 1e-6  # rate over |eigenvalue|, above which a mode grows; below, it is rounding error
NOISE = 1e-6  # frequency over the highest one, below which a motion does not oscillate
# rounding error of eigenvalues (rad/s)^2 over the norm of stiffness over mass
ROUND_OFF = 10 * float(np.finfo(float).eps)
NONHOLONOMIC = (
    "rolled",
    "across",
    "rail rolled",
    "rail across",
)  # coordinates with a rate but no value
ROLLING = "rail contact"  # kind of force whose bodies b roll
RANK = 1e-10  # singular value of the scaled constraint matrix over the largest, below it a null


@dataclass(frozen=True, eq=False)
class LinearModel:
    """Linear state-space model about a state, ``x' = A x + B u``, ``y = C x + D u``.

    Attributes
    ----------
    A, B, C, D : arrays (n, n), (n, nu), (ny, n), (ny, nu)
        n = 2f + ns with the mobility f; x = [free positions, free velocities, ns states of forces
        such as `PID`], all as deviations from the state.
    input_names, output_names, state_names : tuples of str
        Inputs by name; sensor components ``sensor.component``; ``y0..``, ``u0..`` and
        ``pid.integral``, ``pid.filtered``.
    """

    A: Array
    B: Array
    C: Array
    D: Array
    input_names: tuple[str, ...]
    output_names: tuple[str, ...]
    state_names: tuple[str, ...]

    def __repr__(self) -> str:
        inputs, outputs = ", ".join(self.input_names), ", ".join(self.output_names)
        return f"<LinearModel: {len(self.A)} states, inputs [{inputs}], outputs [{outputs}]>"

    @property
    def eigenvalues(self) -> Eigenvalues:
        """Eigenvalues of A, 1/s."""
        return np.asarray(np.linalg.eigvals(self.A), dtype=np.complex128)

    def state_space(self) -> Any:
        """Return the matrices as a scipy.signal.StateSpace."""
        from scipy.signal import StateSpace

        return StateSpace(self.A, self.B, self.C, self.D)


@dataclass(frozen=True, eq=False)
class MechanismModes:
    """Natural modes of a mechanism about a state, in ascending order of ``|eigenvalue|``.

    Attributes
    ----------
    frequencies : (k,) array
        Imaginary part of the eigenvalue over 2 pi, Hz; 0 for a motion that does not oscillate.
    damping : (k,) array
        Damping ratios ``-Re(lambda) / |lambda|``; 0 where lambda is 0.
    eigenvalues : (k,) array
        Eigenvalues, 1/s; from each conjugate pair the one with positive imaginary part.
    increments : (nv, k) array
        Mode shapes as increments of R (body frame), rotation (body frame) and p of every body.
    shapes : dict
        Nodal displacements (k, nodes, 3) of each body in the world frame, by its name; maximum of
        a mode 1.
    model : Model
        The mechanism.
    state : State
        State of the linearisation.
    free : (k,) bool array
        Whether a mode is a free motion, without restoring forces and drives; its eigenvalue is 0.
    """

    frequencies: Array
    damping: Array
    eigenvalues: Eigenvalues
    increments: NDArray[Any]
    shapes: dict[str, NDArray[Any]]
    model: Model
    state: State
    free: NDArray[np.bool_]

    def __repr__(self) -> str:
        found = ", ".join(f"{f:.5g}" for f in self.frequencies[:6])
        return f"<MechanismModes: {found}{', ...' if len(self.frequencies) > 6 else ''} Hz>"

    @property
    def grows(self) -> NDArray[np.bool_]:
        """Whether each mode is unstable, (k,), that is, grows with or without oscillation."""
        return np.asarray(self.eigenvalues.real > GROWTH * np.abs(self.eigenvalues))

    def describe_mode(self, mode: int, digits: int = 6) -> str:
        """Return the frequency of a mode as text, with the rate if the mode grows or decays.

        Parameters
        ----------
        mode : int
            Index of the mode, from 0.
        digits : int
            Number of digits.
        """
        value, frequency = self.eigenvalues[mode], f"{self.frequencies[mode]:.{digits}g} Hz"
        if self.free[mode]:
            return "free motion, 0 Hz"
        rate = f"{abs(value.real):.{digits}g} 1/s"
        if self.grows[mode]:
            swing = "" if value.real > abs(value.imag) else f"{frequency}, "
            return f"{swing}unstable, grows with {rate}"
        return frequency if self.frequencies[mode] else f"does not oscillate, decays with {rate}"


@dataclass(frozen=True, eq=False)
class Tangent:
    """First derivatives of the equations of motion at a state, translations in body frames.

    With the free positions y and velocities u: ``dq = N y``, ``dv = P y + N u``,
    ``y' = drift y + u``, ``u' = Ay y + Au u + Ax x + Bu input`` and ``x' = Xy y + Xu u + Xx x +
    Xb input`` of the states x of forces. P adds the velocities that keep ``Cq v = 0``.
    """

    N: Array
    P: Array
    drift: Array
    Ay: Array
    Au: Array
    Ax: Array
    Bu: Array
    Xy: Array
    Xu: Array
    Xx: Array
    Xb: Array
    Cy: Array
    Cu: Array
    Cx: Array
    Du: Array
    a: Array
    lam: Array
    M: Array


def rotations(model: Model, q: Array) -> Array:
    """Return the rotation matrices (nbody, 3, 3) of the body frames from Euler parameters."""
    e = [q[body.iq + 3 : body.iq + 7] for body in model.bodies]
    return np.array([rotation_matrix(x / np.linalg.norm(x)) for x in e]).reshape(-1, 3, 3)


def body_frame_increments(model: Model, q: Array) -> Array:
    """Return T (nv, nv) from increments with body-frame translations to those of the engine."""
    T = np.eye(model.nv)
    for body, A in zip(model.bodies, rotations(model, q), strict=True):
        T[body.iv : body.iv + 3, body.iv : body.iv + 3] = A
    return T


def tangent(model: Model, state: State | None = None) -> Tangent:
    """Return the exact derivatives of the equations of motion at a state, by complex steps.

    Translations are resolved in the frame of their body, so that the matrices of a steadily
    turning mechanism are constant. The free coordinates are those of the null space of the
    constraint matrix, which redundant rows do not change.

    Raises
    ------
    InputError
        If a body or joint is singular at the state.
    """
    without_fmus(model, "linearise", "has no derivatives here")
    without_delays(model, "linearise")
    without_sticking(model, "linearise")
    q, v, time = (model.q0, model.v0, 0.0) if state is None else (state.q, state.v, state.time)
    nv, T = model.nv, body_frame_increments(model, q)
    engine, steps = Engine(model), Engine(model, complex_scalars=True)
    for twin in (engine, steps):
        put(twin, State(q, v, np.zeros(model.nrow), time) if state is None else state, "linearise")
    a, lam = (np.array(x) for x in engine.accelerations())
    M = (
        T.T @ engine.newton_matrix(1.0, 0.0, 0.0)[:nv, :nv] @ T
    )  # mass matrix, including the masses of beams

    moving, bristles = moving_states(model), contact_states(model, STRETCH)
    places = np.concatenate([moving, bristles])

    def slopes(*along: Array) -> tuple[Array, ...]:
        """Return directional derivatives of C, C', a (body frames), sensors and state rates."""
        dq, dv, dx, du = along
        steps.q[:] = displaced(model, q, 1j * IMAGINARY * (T @ dq))
        steps.v[:] = v + 1j * IMAGINARY * (T @ dv)
        steps.states[:] = engine.states
        steps.states[places] += 1j * IMAGINARY * dx
        steps.input[:] = engine.input + 1j * IMAGINARY * du
        steps.time[0] = time
        c, cdot = steps.constraints()
        acceleration, _ = steps.accelerations()
        rates = np.array(steps.state_rates[places])
        parts = (c, cdot, T.T @ acceleration, steps.sensors(), rates)
        return tuple(np.array(part.imag) / IMAGINARY for part in parts)

    sizes = (nv, nv, len(places), len(model.inputs))
    lengths = (model.nrow, model.nrow, nv, model.nout, len(places))

    def columns(which: int) -> list[Array]:
        """Return derivatives (rows, columns) by q, v, states or inputs (which = 0, 1, 2, 3)."""
        out = [np.zeros((length, sizes[which])) for length in lengths]
        for k in range(sizes[which]):
            along = [np.zeros(size) for size in sizes]
            along[which][k] = 1.0
            for matrix, column in zip(out, slopes(*along), strict=True):
                matrix[:, k] = column
        return out

    by_q, by_v, by_x, by_u = (columns(which) for which in range(4))
    # bristles follow the displacement as their rates follow the velocity: they are stiffness
    stuck, n = by_v[4][len(moving) :], len(moving)
    for matrix, bristle in zip(by_q[:4], by_x[:4], strict=True):
        matrix += bristle[:, n:] @ stuck
    by_x = [matrix[:, :n] for matrix in by_x]
    for rows in (by_q, by_v, by_x, by_u):
        rows[4] = rows[4][:n]
    Cq, Cdot = by_q[0], by_q[1]
    N, pseudo = free_motions(Cq)
    P = -pseudo @ (Cdot @ N)
    # terms of the turning body frames in velocities and accelerations
    frames, spins = np.zeros((nv, nv)), np.zeros((nv, nv))
    for body in model.bodies:
        W = skew(v[body.iv + 3 : body.iv + 6])
        for first in (body.iv, body.iv + 3):
            frames[first : first + 3, first : first + 3] = -W
        spins[body.iv : body.iv + 3, body.iv : body.iv + 3] = -W
    aq, av = by_q[2], by_v[2] + spins
    return Tangent(
        N=N,
        P=P,
        drift=N.T @ frames @ N,
        Ay=N.T @ (aq @ N + av @ P),
        Au=N.T @ av @ N,
        Ax=N.T @ by_x[2],
        Bu=N.T @ by_u[2],
        Xy=by_q[4] @ N + by_v[4] @ P,
        Xu=by_v[4] @ N,
        Xx=by_x[4],
        Xb=by_u[4],
        Cy=by_q[3] @ N + by_v[3] @ P,
        Cu=by_v[3] @ N,
        Cx=by_x[3],
        Du=by_u[3],
        a=T.T @ a,
        lam=lam,
        M=M,
    )


def system_matrix(t: Tangent) -> Array:
    """Return the system matrix A of [free positions, free velocities, states of forces]."""
    f, ns = t.N.shape[1], len(t.Xx)
    return np.block(
        [
            [t.drift, np.eye(f), np.zeros((f, ns))],
            [t.Ay, t.Au, t.Ax],
            [t.Xy, t.Xu, t.Xx],
        ]
    )


@dataclass(frozen=True, eq=False)
class Rest:
    """Stiffness and mass about a state without velocities, translations in body frames.

    The free motions ``dq = N y`` are orthonormal with respect to the mass, ``N^T M N = E``, and
    ``y'' = -K y`` about the state. Neither N nor K contains a division by an inertia, which would
    lose accuracy for tiny inertias, such as about the axis of a slender body. `round_off` is the
    rounding error of the eigenvalues of K, (rad/s)^2.
    """

    N: Array
    K: Array
    M: Array
    a: Array
    lam: Array
    round_off: float


def at_rest(model: Model, state: State) -> Rest:
    """Return stiffness and mass about a state with zero velocities, by complex steps.

    ``K = N^T (dr/dq N + M E)`` with the residual r of the equations of motion at fixed
    accelerations and multipliers; ``E = -Cq^+ d(Cq a)/dq N`` is the change of the constrained
    accelerations with the position.

    Raises
    ------
    InputError
        If a body or joint is singular at the state.
    """
    without_fmus(model, "modes", "has no derivatives here")
    without_delays(model, "modes")
    without_sticking(model, "modes")
    still, T = replace(state, v=np.zeros(model.nv)), body_frame_increments(model, state.q)
    engine, twin = Engine(model), Engine(model, complex_scalars=True)
    for one in (engine, twin):
        put(one, still, "modes")
    a, lam = (np.array(x) for x in engine.accelerations())
    bristles = contact_states(model, STRETCH)
    stuck, stretch = bristle_rates(twin, bristles, T, IMAGINARY), np.array(engine.states[bristles])
    twin.accelerations()  # evaluates the quantities that depend on the state alone
    twin.a[:], twin.lam[:] = a, lam
    M = T.T @ engine.newton_matrix(1.0, 0.0, 0.0)[: model.nv, : model.nv] @ T

    rolls = any(coordinate.kind in NONHOLONOMIC for coordinate in model.coordinates)

    def slopes(move: Array) -> tuple[Array, Array, Array]:
        """Return directional derivatives of C, r and Cq a along a motion."""
        twin.q[:] = displaced(model, state.q, 1j * IMAGINARY * (T @ move))
        twin.v[:] = 0.0
        twin.states[bristles] = stretch + 1j * IMAGINARY * (stuck @ move)
        c, r = twin.constraints()[0], twin.residual()
        twin.v[:] = a
        turned = twin.constraints()[1]
        if rolls:  # rows without slip bind velocities only
            twin.q[:] = state.q
            twin.v[:] = 1j * IMAGINARY * (T @ move)
            c = twin.constraints()[1]
        return tuple(np.array(x.imag) / IMAGINARY for x in (c, T.T @ r, turned))  # type: ignore[return-value]

    by_q = [_columns(rows) for rows in zip(*(slopes(e) for e in np.eye(model.nv)), strict=True)]
    # scaling of the unknowns to unit mass
    scale = 1.0 / np.sqrt(np.diag(M))
    root = np.linalg.cholesky(scale[:, None] * M * scale)
    lift = scale[:, None] * np.linalg.inv(root).T
    N, pseudo = (lift @ x for x in free_motions(by_q[0] @ lift))
    K = by_q[1] - M @ pseudo @ by_q[2]
    # joints may constrain the stiffest directions, but rounding errors have the size of the full K
    round_off = ROUND_OFF * float(np.linalg.norm(lift.T @ K @ lift))
    return Rest(N, N.T @ K @ N, M, T.T @ a, lam, round_off)


def _columns(rows: Sequence[Array]) -> Array:
    return np.array(rows).T


def free_motions(Cq: Array) -> tuple[Array, Array]:
    """Return the orthonormal null space N (nv, f) and the pseudoinverse (nv, nrow) of Cq."""
    if not Cq.size:
        return np.eye(Cq.shape[1]), np.zeros(Cq.shape[::-1])
    U, s, Vt = np.linalg.svd(Cq)
    rank = int((s > RANK * s[0]).sum())
    return Vt[rank:].T, Vt[:rank].T @ (U[:, :rank] / s[:rank]).T


@explained
def linearise(
    model: Model,
    state: State | None = None,
    inputs: Sequence[str] | None = None,
    outputs: Sequence[str] | None = None,
) -> LinearModel:
    """Return the exact linear model of a mechanism about a state, in minimal coordinates.

    Parameters
    ----------
    model : Model
        From `compile`.
    state : State, optional
        State of the linearisation; None: the initial state.
    inputs : names, optional
        External inputs to keep; None keeps all.
    outputs : names, optional
        Sensors to keep; None keeps all.

    Raises
    ------
    InputError
        If a name does not exist, or a body or joint is singular at the state.

    Warns
    -----
    JoustoWarning
        If a wheel rolls on a rail (`RailContact`): the axes turn with it.
    """
    sensors = [sensor.name for sensor in model.sensors]
    chosen = _known("input", model.inputs, inputs)
    kept = _known("sensor", sensors, outputs)
    _warn_rolling(model, state, "linearise")
    t = tangent(model, state)
    f = t.N.shape[1]
    places = [model.inputs.index(name) for name in chosen]
    rows, names = [], []
    for name in kept:
        sensor = model.sensors[sensors.index(name)]
        for k in range(sensor.count):
            rows.append(sensor.offset + k)
            part = sensor.components[k] if k < len(sensor.components) else str(k)
            names.append(name if sensor.count == 1 else f"{name}.{part}")
    return LinearModel(
        A=system_matrix(t),
        B=np.vstack([np.zeros((f, len(places))), t.Bu[:, places], t.Xb[:, places]]),
        C=np.hstack([t.Cy, t.Cu, t.Cx])[rows],
        D=t.Du[np.ix_(rows, places)],
        input_names=tuple(chosen),
        output_names=tuple(names),
        state_names=(
            *(f"y{k}" for k in range(f)),
            *(f"u{k}" for k in range(f)),
            *(model.state_names[i] for i in moving_states(model)),
        ),
    )


def _known(kind: str, names: Sequence[str], wanted: Sequence[str] | None) -> list[str]:
    """Return the wanted names, or all names for None; raise an error for unknown names."""
    if wanted is None:
        return list(names)
    unknown = [name for name in wanted if name not in names]
    if unknown:
        have = ", ".join(names) or "none"
        raise InputError(Problem("linearise", f"no {kind} {unknown[0]!r}; there are: {have}"))
    return list(wanted)


@explained
def modes(
    model: Model, state: State | None = None, *, damped: bool = False, count: int | None = None
) -> MechanismModes:
    """Return the natural modes of a mechanism about a state.

    Undamped modes solve ``K x = omega^2 M x`` in the free coordinates with zero velocities; K is
    the exact derivative of the static forces, gravity, loads and prestress included. Under follower
    loads K is not symmetric, and two modes may form a flutter pair: one decays, the other grows
    (damping below 0). Damped modes are those of the linearised motion at the velocities of the
    state, gyroscopic terms included. Modal bodies have geometric stiffness of loads and spin, also
    if their parts were reduced without ``stiffening=True``.

    Parameters
    ----------
    model : Model
        From `compile`.
    state : State, optional
        State of the linearisation, usually from `equilibrium`; None: the initial state. If it is
        not in equilibrium, the mechanism accelerates and K contains the change of the inertia
        forces with the position; frequencies of beams with an eccentric mass then have errors of
        many per cent.
    damped : bool
        Whether damping and velocities are included. With False a rotating state is treated as at
        rest, with a warning.
    count : int, optional
        Maximum number of modes, the lowest first. None computes all modes, or 20 by sparse matrices
        for mechanisms with more than 600 velocities and constraint rows.

    Raises
    ------
    InputError
        If a body or joint is singular at the state.

    Warns
    -----
    JoustoWarning
        If the state turns and `damped` is False, or loads change the stiffness of a body whose part
        comes from matrices or from a file without stiffening.
    """
    from jousto.simulation.modes.large import MANY, USUAL, large_modes

    if count is not None:
        problems = Problems()
        problems.number("modes", "count", count, "", "1 or more", lambda x: x >= 1)
        problems.raise_if_any()
    without_sticking(model, "modes")
    loaded = where_noticed(model, state, f"modes of {model.name!r}")
    state = State(model.q0, model.v0, np.zeros(model.nrow)) if state is None else state
    if not damped or model.nv + model.nrow > MANY:
        without_states(
            model,
            f"modes of {model.name!r}",
            "their eigenvalues are those of damped modes by dense matrices, damped=True"
            + ("" if model.nv + model.nrow > MANY else ", or of linearise(model).A"),
        )
    if model.nv + model.nrow > MANY:
        if damped:
            _warn_held(model)
        found, x, round_off = large_modes(hold_controllers(loaded), state, damped, count or USUAL)
        if not damped:
            _warn_turning(model, state, found)
        return _modes(model, state, found, x, round_off)
    if damped:
        _warn_rolling(model, state, f"modes of {model.name!r}")
        t = tangent(loaded, state)
        N, f = t.N, t.N.shape[1]
        values, vectors = np.linalg.eig(system_matrix(t))
        keep = values.imag >= 0.0
        eigenvalues, free = values[keep].astype(np.complex128), vectors[:f, keep]
        # a double eigenvalue 0 splits by the root of the rounding errors
        round_off = ROUND_OFF * len(values) * float(np.abs(values).max(initial=0.0)) ** 2
    else:
        rest = at_rest(hold_controllers(loaded), state)
        N, (squares, free), round_off = rest.N, stiffness_modes(rest), rest.round_off
        roots = np.sqrt(-squares.astype(np.complex128))
        eigenvalues = np.where(roots.imag < 0.0, -roots, roots)
    order = np.argsort(np.abs(eigenvalues), kind="stable")[:count]
    if not damped:
        _warn_turning(model, state, eigenvalues)
    return _modes(model, state, eigenvalues[order], N @ free[:, order], round_off)


def _warn_held(model: Model) -> None:
    """Warn of controllers whose states are omitted in damped modes by sparse matrices."""
    if held := controllers(model):
        warn(
            f"modes of {model.name!r}",
            f"PID '{held[0].name}' is included with its proportional part only: modes of "
            "mechanisms as large as this one omit the states of forces",
        )


def _warn_rolling(model: Model, state: State | None, where: str) -> None:
    """Warn of wheels that roll on rails: in axes that turn with them, the rail is not constant."""
    v = model.v0 if state is None else state.v
    for force in model.forces:
        if force.element != ROLLING:
            continue
        body = model.bodies[model.markers[force.b].body]
        spin = float(np.linalg.norm(np.real(v[body.iv + 3 : body.iv + 6])))
        if spin > 0.0:
            warn(
                where,
                f"wheel '{body.name}' rolls at {spin:.3g} rad/s; the axes of the linear motion "
                "turn with each body, in which the force of the rail changes, so that eigenvalues "
                "do not tell whether the motion grows: simulate a small motion instead, as "
                "examples/wheelset_hunting.py does",
            )
            return


def _warn_turning(model: Model, state: State, eigenvalues: Eigenvalues) -> None:
    """Warn of turning bodies, since modes at rest omit gyroscopic and centrifugal terms."""
    spins = [np.linalg.norm(state.v[b.iv + 3 : b.iv + 6]) for b in model.bodies]
    fastest = int(np.argmax(spins)) if spins else 0
    rates = np.abs(eigenvalues.imag)
    lowest = rates[rates > NOISE * rates.max(initial=0.0)].min(initial=np.inf)
    if spins and NOTICED * lowest < spins[fastest] and np.isfinite(lowest):
        warn(
            f"modes of {model.name!r}",
            f"body '{model.bodies[fastest].name}' rotates at {spins[fastest]:.3g} rad/s, but these "
            "are the modes at rest in this position: gyroscopic and centrifugal terms are omitted; "
            "damped=True includes them and damping; for modes at rest set the velocities of the "
            "state to zero",
        )


def _modes(
    model: Model,
    state: State,
    eigenvalues: Eigenvalues,
    increments: NDArray[Any],
    round_off: float,
) -> MechanismModes:
    """Return the modes; eigenvalues whose square is below the rounding error become 0."""
    free = np.abs(eigenvalues) ** 2 <= round_off
    eigenvalues = np.where(free, 0.0, eigenvalues)
    size = np.abs(eigenvalues)
    damping = np.divide(-eigenvalues.real, size, out=np.zeros_like(size), where=size > 0.0)
    return MechanismModes(
        np.abs(eigenvalues.imag) / (2 * np.pi),
        damping,
        eigenvalues,
        increments,
        normalised_shapes(model, state.q, increments),
        model,
        state,
        free,
    )


def local(model: Model, q: Array, increments: NDArray[Any]) -> NDArray[Any]:
    """Return increments (nv, k) of the engine with translations in body frames."""
    out = np.array(increments)
    for body, A in zip(model.bodies, rotations(model, q), strict=True):
        out[body.iv : body.iv + 3] = A.T @ out[body.iv : body.iv + 3]
    return out


def stiffness_modes(rest: Rest) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return omega^2 (f,) and mode shapes (f, f) of ``K x = omega^2 x``."""
    from jousto.simulation.modes.spectrum import small_modes

    if not rest.K.size:
        return np.zeros(0), np.zeros((0, 0))
    return small_modes(rest.K, np.eye(len(rest.K)))


def normalised_shapes(model: Model, q: Array, increments: NDArray[Any]) -> dict[str, NDArray[Any]]:
    """Return nodal displacements (k, nodes, 3) of each body, world frame, maximum of a mode 1."""
    out = nodal_displacements(model, q, increments)
    largest = np.zeros(increments.shape[1])
    for moved in out.values():
        if moved.size:
            largest = np.maximum(largest, np.abs(moved).max(axis=(1, 2)))
    scale = np.where(largest > 0.0, largest, 1.0)
    return {name: moved / scale[:, None, None] for name, moved in out.items()}


def nodal_displacements(
    model: Model, q: Array, increments: NDArray[Any]
) -> dict[str, NDArray[Any]]:
    """Return nodal displacements (k, nodes, 3) of each body, world frame, of increments (nv, k)."""
    out: dict[str, NDArray[Any]] = {}
    for body, shape, A in zip(model.bodies, model.shapes, rotations(model, q), strict=True):
        dx = increments[body.iv : body.iv + 6 + body.n].T
        u = shape.nodes
        flexible = np.zeros((len(dx), *u.shape), dtype=dx.dtype)
        if body.n:
            u = u + shape.modes @ q[body.iq + 7 : body.iq + 7 + body.n]
            flexible = np.einsum("icj,kj->kic", shape.modes, dx[:, 6:])
        local = dx[:, None, :3] + np.cross(dx[:, None, 3:6], u[None]) + flexible
        out[body.name] = local @ A.T
    return out
