"""State: all that a run needs to continue from an instant."""

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
    """Where a mechanism stands at an instant, and what it remembers.

    Positions and velocities suffice to start a run there. What follows them is what the mechanism
    remembers of the way it came; with all of it a run continues as if it had not been interrupted.

    Attributes
    ----------
    q, v, lam : arrays (nq,), (nv,), (nrow,)
        Positions [R e p], velocities [R' w_local p'] and multipliers.
    time : float
        Instant, s.
    states : array, optional
        First-order states of forces, such as the integral part of a `PID`; None starts them anew.
    turn : array, optional
        Unwrapped angles, rad; None counts from within half a turn.
    locked, slip, held, direction : arrays, optional
        Friction with stick and slip: what sticks, what slips which way, where it sticks, and the
        direction of slip; None decides anew.
    happened : array, optional
        How often each event has happened; None is never.
    inputs : dict, optional
        Values of external inputs by name; those not named keep their initial value.
    work : (3,) array, optional
        Energy lost to damping and friction and work done so far, J; None starts from zero.
    meters : array, optional
        What the damage meters remember; None starts them anew.
    joint : array, optional
        Joint coordinates and their rates, of models that run in them; None takes them from q and v.
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

    def __repr__(self) -> str:
        return f"<State: at {self.time:g} s, {len(self.q)} positions, {len(self.v)} velocities>"


# further arrays of a state and what they are, in the order of the engine's rows after the sensors
MEMORY = {
    "states": ("N, N m, m, rad, m/s or rad/s", "first-order states of forces"),
    "turn": ("rad", "unwrapped angles"),
    "locked": ("1", "1 where friction sticks"),
    "slip": ("1", "0 where friction sticks, else the direction of slip along the coordinate"),
    "held": ("m or rad", "where coordinates are held by sticking friction"),
    "direction": ("1", "direction of slip"),
    "happened": ("1", "how often each event has happened"),
    "input": ("1", "values of the external inputs"),
    "meters": ("1", "memory of the damage meters"),
    "joint": ("m, rad, 1, m/s, rad/s", "joint coordinates, then their rates"),
}


def put(engine: Engine, state: State, where: str) -> None:
    """Bring an engine into a state.

    Raises
    ------
    InputError
        If the state is none of the engine's model.
    """
    problems = Problems()
    pairs: list[tuple[str, Any, Any]] = [
        ("positions", state.q, engine.q),
        ("velocities", state.v, engine.v),
    ]
    for name in MEMORY:
        if name == "joint" and state.joint is not None and len(state.joint) != len(engine.joint):
            continue  # of a model that runs otherwise: q and v say it
        if name != "input" and getattr(state, name) is not None:
            pairs.append((name, getattr(state, name), getattr(engine, name)))
    if state.work is not None:
        pairs.append(("work", state.work, engine.work))
    for name, value, room in pairs:
        given = floats(value)
        if given.shape != room.shape:
            found = f"{given.size} {name}" if name.endswith("s") else f"'{name}' of {given.size}"
            problems.add(where, f"state has {found}, the model {room.size}; take one of this model")
        elif name == "meters":  # damage may be infinite
            if engine.meters_valid(given):
                room[:] = given
            else:
                problems.add(where, "the meters of the state are not those of damage sensors")
        elif not np.isfinite(given).all():
            problems.add(where, f"the {name} of the state are not finite")
        else:
            room[:] = given
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


def take(engine: Engine) -> State:
    """Return where an engine stands, after `accelerations` or `row`."""
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
    """Return the lengths of the further arrays of a state, in the order of the engine's rows."""
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
    }
