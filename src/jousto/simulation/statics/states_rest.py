"""Equilibria of machines with states: x' = 0 and no acceleration, solved together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, SimulationError
from jousto.model.model import ForceModel, Model
from jousto.model.native.header import places
from jousto.model.native.native import Engine, displaced
from jousto.simulation.contacts import contacts
from jousto.simulation.controllers import moving_states, networks, state_sizes
from jousto.simulation.modes.linear import body_frame_increments, tangent
from jousto.simulation.state import State, put

SINGULAR = 1e-11
"""Singular value over the largest one, below which forces and rates do not depend on a motion."""
FOUND = 1e-10
"""Increment over the size of the machine, 1 rad or the size of a state, at which they are found."""
LEFT = 1e-8
"""Residual over its first value, or over the largest change by an increment of size 1."""
ROUNDS = 100
"""Largest number of increments."""
TRAVEL = 0.3
"""Largest increment over the size of the machine, 1 rad or the size of a state."""


def rest_with_states(model: Model, state: State | None) -> State:
    """Return a state at rest in which no state of a block or controller changes.

    Newton's method for ``a = 0`` and ``x' = 0`` with the exact derivatives of `linearise`, in
    bounded increments. Sums of states on which nothing depends, such as the oil in closed volumes,
    keep their initial values: increments are the smallest ones. The equilibrium may be unstable.

    Parameters
    ----------
    model : Model
        Model with states.
    state : State, optional
        Initial state of the iteration.

    Raises
    ------
    SimulationError
        If no equilibrium is found.
    InputError
        If the model has contacts.
    """
    if contacts(model):
        raise InputError(
            Problem(
                f"equilibrium of {model.name!r}",
                "contacts and states of blocks are not solved together; simulate until the machine "
                "has come to rest",
            )
        )
    engine = Engine(model)
    if state is not None:
        put(engine, state, "equilibrium")
    moving, sizes = moving_states(model), _sizes(model, np.array(engine.states))
    at = State(
        q=np.array(engine.q),
        v=np.zeros(model.nv),
        lam=np.zeros(model.nrow),
        time=float(engine.time[0]),
        states=np.array(engine.states),
        turn=np.array(engine.turn),
    )
    first: Array | None = None
    residual = np.zeros(0)
    for _ in range(ROUNDS):
        put(engine, at, "equilibrium")
        engine.accelerations()
        rates = np.array(engine.state_rates[moving])
        t = tangent(model, at)
        lengths = _lengths(model) @ np.abs(t.N)
        lengths = np.where(lengths > 0.0, lengths, 1.0)
        # increments z of size 1: y = z / lengths, x = z sizes
        columns = np.concatenate([1.0 / lengths, sizes[moving]])
        J = np.block([[t.Ay, t.Ax], [t.Xy, t.Xx]]) * columns
        residual = np.concatenate([t.N.T @ t.a, rates])
        rows = np.maximum(np.abs(J).max(axis=1, initial=0.0), np.abs(residual))
        rows = np.where(rows > 0.0, rows, 1.0)
        J, residual = J / rows[:, None], residual / rows
        step = np.linalg.lstsq(J, -residual, rcond=SINGULAR)[0]
        if first is None:
            first = np.abs(residual)
        largest = float(np.abs(step).max(initial=0.0))
        if largest <= FOUND and (np.abs(residual) <= LEFT).all():
            return replace(at, lam=t.lam)
        step *= min(1.0, TRAVEL / max(largest, 1e-300)) * columns
        f = t.N.shape[1]
        increment = body_frame_increments(model, at.q) @ (t.N @ step[:f])
        states = np.array(at.states)
        states[moving] += step[f:]
        engine.q[:], engine.v[:] = displaced(model, at.q, increment), 0.0
        engine.states[:] = states
        engine.assemble()
        at = replace(at, q=np.array(engine.q), states=states, turn=np.array(engine.turn))
    raise SimulationError(
        f"no static equilibrium found in {ROUNDS} increments: {_worst(model, residual)}; "
        "check that its rate can be 0, or simulate until the machine has come to rest",
        time=at.time,
    )


def _worst(model: Model, residual: Array) -> str:
    """Return what is farthest from rest in words."""
    names = [
        name if force.kind == "network" else f"{force.name}.{name}"
        for force in model.forces
        for name in force.state_names
    ]
    moving = moving_states(model)
    worst = int(np.argmax(np.abs(residual)))
    at = worst - (len(residual) - len(moving))
    return f"state '{names[moving[at]]}' still changes" if at >= 0 else "the bodies accelerate"


def _sizes(model: Model, states: Array) -> Array:
    """Return the sizes (nstate,) of the states: nominal values, or larger initial ones."""
    sizes = state_sizes(model)
    for force in networks(model):
        first = max(place.stop for place in places("jo_network_data").values()) + force.states
        own = np.abs(np.real(force.data[first : first + force.states]))
        sizes[force.state : force.state + force.states] = own
    sizes = np.maximum(sizes, np.abs(states))
    return np.where(sizes > 0.0, sizes, 1.0)


def _lengths(model: Model) -> NDArray[np.float64]:
    """Return factors (nv,) that make increments 1 for the size of the machine or 1 rad."""
    out = np.ones(model.nv)
    for body in model.bodies:
        out[body.iv : body.iv + 3] = 1.0 / model.size
    return out


def state_systems(model: Model) -> list[ForceModel]:
    """Return the systems of a model that have states."""
    return [force for force in networks(model) if force.states]


def without_memories(model: Model, where: str) -> None:
    """Raise InputError if blocks of a model keep values from the steps before."""
    problems = [
        Problem(
            where,
            f"{force.state_names[0].partition('.')[0]!r} keeps values from the steps before; "
            "simulate until the machine has come to rest",
        )
        for force in model.forces
        if force.kind in ("memory", "delay")
    ]
    if problems:
        raise InputError(problems)
