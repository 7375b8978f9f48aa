"""State: positions, velocities and internal states of a mechanism at an instant."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.complexstep import floats
from jousto.base.errors import Problems
from jousto.model.model import Model
from jousto.model.native.damage_meter import meter_size
from jousto.model.native.native import Engine


@dataclass(frozen=True, eq=False)
class State:
    """State of a mechanism at an instant.

    Positions and velocities suffice to start a run. The other arrays are internal states that
    depend on the previous motion; a run that starts with all of them continues as if it had not
    been interrupted.

    Attributes
    ----------
    q, v, lam : arrays (nq,), (nv,), (nrow,)
        Positions [R e p], velocities [R' w_local p'] and multipliers.
    time : float
        Instant, s.
    states : array, optional
        First-order states of forces, such as the integral part of a `PID`; None: their initial
        value.
    turn : array, optional Unwrapped angles, rad; with None they are within half a revolution.
    locked, slip, held, direction : arrays, optional
        Stick-slip friction: whether it sticks, sense of slip, coordinate where it sticks, direction
        of slip; None determines them from the velocities.
    happened : array, optional
        Number of occurrences of each event; None is 0.
    inputs : dict, optional
        Values of external inputs by name; those not named keep their initial value.
    work : (3,) array, optional
        Energy lost to damping, energy lost to friction and work done so far, J; None is 0.
    meters : array, optional
        States of the damage meters; None: their initial value.
    joint : array, optional
        Joint coordinates and their rates, for models in joint coordinates; with None they are
        computed from q and v.
    contact_energy : (3,) array, optional
        Of contacts: stored energy, energy lost so far by their normal forces (restitution) and by
        friction, J; None is 0.
    """

    q: Array
    v: Array
    lam: Array
    time: float = 0.0
    turn: Array | None = None
    locked: Array | None = None
    slip: Array | None = None
    held: Array | None = None
    direction: Array | None = None
    happened: Array | None = None
    inputs: Mapping[str, float] | None = None
    work: Array | None = None
    meters: Array | None = None
    joint: Array | None = None
    states: Array | None = None
    contact_energy: Array | None = None

    def __repr__(self) -> str:
        return f"<State: at {self.time:g} s, {len(self.q)} positions, {len(self.v)} velocities>"


# unit and description of the internal states, in the order of the engine's rows after the sensors
MEMORY = {
    "states": ("N, N m, m, rad, m/s or rad/s", "first-order states of forces"),
    "turn": ("rad", "unwrapped angles"),
    "locked": ("1", "1 where friction sticks"),
    "slip": ("1", "0 where friction sticks, else the direction of slip along the coordinate"),
    "held": ("m or rad", "coordinates at which friction sticks"),
    "direction": ("1", "direction of slip"),
    "happened": ("1", "number of occurrences of each event"),
    "input": ("1", "values of the external inputs"),
    "meters": ("1", "states of the damage meters"),
    "joint": ("m, rad, 1, m/s, rad/s", "joint coordinates, then their rates"),
    "contact_energy": (
        "J",
        "of contacts: stored energy, and energy lost since the start by normal forces and friction",
    ),
}


def put(engine: Engine, state: State, where: str) -> None:
    """Set an engine to a state.

    Raises
    ------
    InputError
        If the sizes or values of the state do not fit the model of the engine.
    """
    problems = Problems()
    pairs: list[tuple[str, Any, Any]] = [
        ("positions", state.q, engine.q),
        ("velocities", state.v, engine.v),
    ]
    for name in MEMORY:
        if name == "joint" and state.joint is not None and len(state.joint) != len(engine.joint):
            continue  # joint coordinates of another core: q and v determine them
        if name != "input" and getattr(state, name) is not None:
            pairs.append((name, getattr(state, name), getattr(engine, name)))
    if state.work is not None:
        pairs.append(("work", state.work, engine.work))
    for name, value, room in pairs:
        try:
            given = floats(value)
        except (TypeError, ValueError):
            problems.add(where, f"the {name} of the state are not all numbers: {value!r:.60}")
            continue
        if given.shape != room.shape:
            found = f"{given.size} {name}" if name.endswith("s") else f"'{name}' of {given.size}"
            problems.add(where, f"state has {found}, the model {room.size}; take one of this model")
        elif name == "meters":  # contains damage, which may be infinite
            if engine.meters_valid(given):
                room[:] = given
            else:
                problems.add(
                    where,
                    "the meters of the state do not belong to the damage sensors of this model",
                )
        elif not np.isfinite(given).all():
            problems.add(where, f"the {name} of the state are not finite")
        else:
            room[:] = given
            if name == "states":
                _check_states(problems, where, engine.model, np.real(given))
    if not np.isfinite(state.time):
        problems.add(where, f"the time of the state is {state.time}, must be finite")
    problems.raise_if_any()
    engine.time[0] = state.time
    if state.states is None:
        engine.start_states()
    for i, name in enumerate(engine.model.inputs):
        if state.inputs is not None and name in state.inputs:
            engine.input[i] = state.inputs[name]
    engine.restart()


def _check_states(problems: Problems, where: str, model: Model, states: Array) -> None:
    """Report states of forces that the laws of these forces cannot reach."""
    for force in model.forces:
        law = force.law
        own = states[force.state : force.state + force.states] if force.states else states[:0]
        # energies may have the rounding errors of the other states
        small = 1e-12 * float(np.abs(own).max(initial=0.0))
        for name, value in zip(force.state_names, own.tolist(), strict=True):
            what = f"state '{name}' of {force.element or force.kind} '{force.name}' is {value:g}"
            if name in law.grows and value < -small:
                problems.add(where, f"{what}, must not be negative")
            if name in law.signs and value not in (-1.0, 0.0, 1.0):
                problems.add(where, f"{what}, must be -1, 0 or 1")


def take(engine: Engine) -> State:
    """Return the state of an engine, after `accelerations` or `row`."""
    memory = {name: np.array(getattr(engine, name)) for name in MEMORY if name != "input"}
    return State(
        q=engine.q.copy(),
        v=engine.v.copy(),
        lam=engine.lam.copy(),
        time=float(engine.time[0].real),
        inputs={name: float(engine.input[i]) for i, name in enumerate(engine.model.inputs)},
        work=engine.work.copy(),
        **memory,
    )


def memory_sizes(model: Model) -> dict[str, int]:
    """Return the lengths of the internal states, in the order of the engine's rows."""
    locks = sum(joint.lock >= 0 for joint in model.joints)
    return {
        "states": model.nstate,
        "turn": sum(coordinate.kind == "angle" for coordinate in model.coordinates),
        "locked": locks,
        "slip": len(model.frictions),
        "held": 2 * locks,
        "direction": 2 * len(model.frictions),
        "happened": len(model.events),
        "input": len(model.inputs),
        "meters": sum(meter_size(meter.rule) for meter in model.meters),
        "joint": model.nx + model.nu,
        "contact_energy": 3 if model.touches else 0,
    }
