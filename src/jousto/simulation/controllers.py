"""Equilibria with PID controllers: the integral parts for rest at the references."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, SimulationError, warn
from jousto.model.model import ForceModel, Model
from jousto.model.native.header import named
from jousto.model.native.native import Engine
from jousto.simulation.state import State, put

SETTLED = 1e-9
"""Of the size of the mechanism, or rad: a coordinate is at the set point of its controller."""
OFF = 1e-6
"""Of the size: a coordinate that rests farther from its reference is worth a warning."""
PROBE = 1e-4
"""Of the integral part that moves a coordinate by the size of the mechanism by its gains."""
ROUNDS = 40
"""Most corrections of the integral parts."""
SECOND = 1.0
"""Time in which an integral part or a derivative is compared with a proportional one, s."""


def controllers(model: Model) -> list[ForceModel]:
    """Return the PID controllers of a model."""
    return [force for force in model.forces if force.kind == "pid"]


def networks(model: Model) -> list[ForceModel]:
    """Return the systems of states of a model."""
    return [force for force in model.forces if force.kind == "network"]


def without_states(model: Model, where: str, remedy: str) -> None:
    """Raise InputError if a model has states with equations of their own."""
    problems = [
        Problem(where, f"states {force.name!r} have equations of their own; {remedy}")
        for force in networks(model)
        if force.states
    ]
    if problems:
        raise InputError(problems)


def without_delays(model: Model, where: str) -> None:
    """Raise InputError if values of a model depend on the motion a fixed time before."""
    problems = [
        Problem(
            where,
            f"{force.state_names[0].partition('.')[0]!r} delays its input; simulate, or take a Lag "
            "or a Pade form as a TransferFunction in its place",
        )
        for force in model.forces
        if force.kind == "delay"
    ]
    if problems:
        raise InputError(problems)


def hold_controllers(model: Model) -> Model:
    """Return a model in which controllers have a constant integral part and no derivative part.

    Near equilibrium the motion is so slow that the filter follows it. The integral part acts over
    time and adds no stiffness.
    """
    if not controllers(model):
        return model
    forces = (_held(force) if force.kind == "pid" else force for force in model.forces)
    return replace(model, forces=tuple(forces)).keeping_tree(model)


def without_controllers(model: Model, where: str) -> None:
    """Raise an error if a controller of the model has an unknown integral or derivative part.

    Raises
    ------
    InputError
        If a controller has an integral part, or a derivative part, whose filter is not in
        equilibrium.
    """
    problems = [
        Problem(
            where,
            f"PID {force.name!r} has states that depend on the motion; use a Servo or a Drive "
            "instead",
        )
        for force in controllers(model)
        if _moves(force)
    ]
    problems += [
        Problem(where, f"states {force.name!r} depend on the motion; leave them out")
        for force in networks(model)
        if force.states
    ]
    if problems:
        raise InputError(problems)


def settle_controllers(
    model: Model, state: State | None, rest: Callable[[State | None], State]
) -> State:
    """Return the equilibrium in which the integral parts no longer change.

    Newton's method solves ``I' = ki (r - s) + (f - u)/tracking = 0``. Its matrix is computed by
    differences at the start, then updated by Broyden's method (Broyden 1965).

    Parameters
    ----------
    model : Model
        Model with the controllers.
    state : State, optional
        Initial state of the iteration.
    rest : callable
        Function that returns the equilibrium for constant integral parts, from a nearby state.

    Raises
    ------
    SimulationError
        If the reference of a rate controller is a motion, or a controller cannot move its
        coordinate to the reference.
    """
    found = controllers(model)
    if not found:
        return rest(state)
    engine = Engine(model)
    if state is not None:
        put(engine, state, "equilibrium")
    places = np.array([force.state for force in found])
    sizes = np.array([_size(model, force) for force in found])
    probes = PROBE * state_sizes(model)[places]
    gains = np.array([float(named("jo_pid_data", force.data).integral) for force in found])
    speeds = np.array([bool(named("jo_pid_data", force.data).speed) for force in found])
    sought = np.flatnonzero((gains > 0.0) & ~speeds)
    parts = np.array(engine.states[places])
    yielding = yielding_states(model)
    yielded = np.array(engine.states[yielding])  # deformation at the start
    begin = State(engine.q, 0.0 * engine.v, engine.lam, float(engine.time[0]))
    wanted = Engine(_without_limits(model))
    put(wanted, replace(begin, states=None), "equilibrium")
    wanted.accelerations()
    moving = np.flatnonzero(speeds & (np.abs(wanted.state_rates[places]) > 0.0))
    if len(moving):
        raise SimulationError(
            f"no static equilibrium: speed PID '{found[moving[0]].name}' has a reference speed "
            "other than 0; set its reference to 0 at this time, or remove it",
            time=float(engine.time[0]),
        )
    at = begin if state is None else state

    def rates(x: Array, near: State) -> tuple[Array, State]:
        """Return the rates of the integral parts at equilibrium, and the equilibrium state."""
        parts[sought] = x
        states = np.array(engine.states)
        states[places] = parts
        there = rest(replace(near, states=states))
        put(engine, replace(there, v=0.0 * there.v, states=None), "equilibrium")
        engine.states[places], engine.states[yielding] = parts, yielded
        engine.accelerations()
        states = np.array(engine.states)
        if there.states is not None:
            states[yielding] = there.states[yielding]
        there = replace(there, states=states)
        return np.array(engine.state_rates[places]), there

    x = np.array(parts[sought])
    r, at = rates(x, at)
    if not len(sought):
        return at
    small = SETTLED * (gains * sizes)[sought]
    J = np.zeros((len(sought), len(sought)))
    for k, i in enumerate(sought):
        probe = np.zeros(len(sought))
        probe[k] = probes[i]
        J[:, k] = (rates(x + probe, at)[0] - r)[sought] / probe[k]
    for _ in range(ROUNDS):
        left = r[sought]
        if (np.abs(left) <= small).all():
            put(wanted, replace(at, v=0.0 * at.v), "equilibrium")
            wanted.accelerations()
            errors = wanted.state_rates[places][sought] / gains[sought]
            _warn_off(model, [found[i] for i in sought], errors)
            return at
        step = np.linalg.lstsq(J, -left, rcond=1e-10)[0]
        r, at = rates(x + step, at)
        x = x + step
        if step @ step > 0.0:
            J += np.outer(r[sought] - left - J @ step, step) / (step @ step)
    worst = found[sought[int(np.argmax(np.abs(r[sought]) / (gains * sizes)[sought]))]].name
    raise SimulationError(
        f"no static equilibrium: PID '{worst}' does not bring its coordinate to its reference; "
        "check that its force acts along the coordinate, that nothing else fixes the "
        "coordinate, and that kp is stiffer than destabilising forces such as gravity",
        time=at.time,
    )


def yielding_states(model: Model) -> NDArray[np.intp]:
    """Return the indices of the states of forces that yield; these have no rates."""
    places = [
        range(force.state, force.state + force.states) for force in model.forces if force.law.yields
    ]
    return np.array([i for some in places for i in some], dtype=np.intp)


def moving_states(model: Model) -> NDArray[np.intp]:
    """Return the indices of the other states, which are integrated from rates."""
    return np.setdiff1d(np.arange(model.nstate), yielding_states(model))


def state_sizes(model: Model) -> Array:
    """Return the scale (nstate,) of force states for an error of the size of the coordinate."""
    out = np.zeros(model.nstate)
    for force in controllers(model):
        data, size = named("jo_pid_data", force.data), _size(model, force)
        gains = data.proportional, data.integral * SECOND, data.derivative / SECOND
        gain = max(float(np.real(one)) for one in gains)
        out[force.state : force.state + 2] = gain * size, size
    return out


def follow_filters(model: Model, engine: Engine) -> None:
    """Set the filters of controllers to the measured values; integral parts keep their values."""
    places = [*(force.state for force in controllers(model)), *yielding_states(model).tolist()]
    parts = {place: float(engine.states[place]) for place in places}
    engine.start_states()
    for place, value in parts.items():
        engine.states[place] = value


def fastest_tracking(model: Model) -> tuple[float, str]:
    """Return the shortest time constant of back-calculation, s, or inf, and its controller."""
    times = {force.name: _tracking_time(force) for force in controllers(model)}
    name = min(times, key=lambda one: times[one], default="")
    return times.get(name, float("inf")), name


def tracking_warning(model: Model, step: float) -> str:
    """Return a warning if the step exceeds the time constant of a back-calculation, else "".

    The integral part of a limited force then jumps from beyond one limit to beyond the other.
    """
    time, name = fastest_tracking(model)
    if step <= time:
        return ""
    return (
        f"PID '{name}' comes back from its limit within {time:.2g} s, less than the step of "
        f"{step:.2g} s, and its force would leap from limit to limit; take a step of {time:.2g} s, "
        "or a longer tracking time"
    )


def _warn_off(model: Model, forces: list[ForceModel], errors: Array) -> None:
    """Warn of controllers that rest at a limit, away from their reference."""
    for force, error in zip(forces, errors.tolist(), strict=True):
        if abs(error) > OFF * _size(model, force):
            unit = "rad" if model.coordinates[force.coordinate].kind == "angle" else "m"
            warn(
                f"equilibrium of {model.name!r}",
                f"PID '{force.name}' is at a limit of its force and stays {abs(error):.3g} {unit} "
                "from its reference; give a larger limit, or another reference",
            )


def _moves(force: ForceModel) -> bool:
    numbers = named("jo_pid_data", force.data)
    return bool(numbers.integral != 0.0 or numbers.derivative != 0.0)


def _tracking_time(force: ForceModel) -> float:
    """Return the time constant of the back-calculation, s; infinite without one."""
    x = named("jo_pid_data", force.data)
    given, ki = float(np.real(x.tracking)), float(np.real(x.integral))
    usual = float(np.real(x.tracking_share * x.proportional)) / ki if ki > 0.0 else 0.0
    time = given or usual
    return time if ki > 0.0 and time > 0.0 else float("inf")


def _held(force: ForceModel) -> ForceModel:
    return _with_zeros(force, "integral", "derivative")


def _without_limits(model: Model) -> Model:
    """Return a model without force limits, so that integral parts depend on the error only."""
    forces = (
        _with_zeros(f, "tracking", "tracking_share") if f.kind == "pid" else f for f in model.forces
    )
    return replace(model, forces=tuple(forces)).keeping_tree(model)


def _with_zeros(force: ForceModel, *names: str) -> ForceModel:
    data = np.array(force.data)
    numbers = named("jo_pid_data", data)
    for name in names:
        getattr(numbers, name)[...] = 0.0
    return replace(force, data=data)


def _size(model: Model, force: ForceModel) -> float:
    """Return the scale of the coordinate: the size of the mechanism, m, or 1 rad."""
    angle = model.coordinates[force.coordinate].kind == "angle"
    return 1.0 if angle else float(model.size)
