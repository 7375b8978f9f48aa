"""rest_on_contacts: equilibrium of a mechanism with contacts, by steps of ROS2 from rest."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, SimulationError
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.scales import largest_speed
from jousto.simulation.contacts import SINCE, contact_states, without_sticking
from jousto.simulation.state import State, put

STEPS = 400  # largest number of steps
FIRST = 0.01  # path of the first step under the largest acceleration / size of the mechanism
STRIDE = 0.2  # largest increment of a step, rad or sizes of the mechanism
LONGEST = 10.0  # longest step over the time in which the mechanism falls by its size
LONGER, SHORTER = 2.0, 0.25  # factors on the step: after a calm one, after one that leads too far
CALM, BUSY = 4, 20  # parts of a step, up to which it is calm, and above which the next is halved
LONG_AGO = 1e6  # age of contacts, s: none is short, which would be resolved by steps of its own
STILL = 1e-12  # increment of a step of the longest length at rest, rad or sizes of the mechanism
STALLED = 1e-9  # the same, of steps that do not become smaller: round-off
FAINT = 1e-6  # shortest step over the longest one


def rest_on_contacts(model: Model, state: State | None) -> State:
    """Return the equilibrium that a mechanism reaches from a state if its motion is stopped often.

    Steps of ROS2, whose matrix contains the closed contacts, start with velocity 0. A step that is
    long beside the periods of the mechanism is one of Newton's method; a short one follows the
    forces. Contacts close, open, stick and slip in these steps as in a run: bristles start without
    stretch, follow the displacement and break at ``mu_static N``. With friction the equilibrium is
    therefore one of many, near the start.

    Raises
    ------
    InputError
        If a joint has friction that sticks.
    SimulationError
        If the mechanism does not come to rest.
    """
    without_sticking(model, "equilibrium")
    for friction in model.frictions:
        if friction.sticks:
            where = f"friction '{friction.name}'"
            text = "sticks beside contacts, so that it would hold the start; give it "
            raise InputError(Problem(where, text + "law=Regularised()"))
    engine = Engine(model)
    start = State(model.q0, np.zeros(model.nv), np.zeros(model.nrow)) if state is None else state
    put(engine, start, "equilibrium")
    engine.v[:] = 0.0
    time, since = float(engine.time[0]), contact_states(model, SINCE)
    a = engine.accelerations()[0]
    pull = max(largest_speed(model, np.array(a)), float(np.linalg.norm(model.gravity)), 1e-300)
    longest = LONGEST * np.sqrt(model.size / pull)
    h = np.sqrt(2.0 * FIRST * model.size / pull)
    before = np.inf
    for _ in range(STEPS):
        done = engine.counts.steps
        moved, h = _step(engine, h, longest, time, since)
        parts = engine.counts.steps - done
        length = moved if h >= longest else np.inf  # a shorter step is no measure of rest
        if length <= STILL or (length <= STALLED and length > 0.5 * before):
            return _found(engine, start, time)
        before = length if h >= longest else np.inf
        h = min((LONGER if parts <= CALM else 0.5 if parts > BUSY else 1.0) * h, longest)
    raise SimulationError(
        f"no static equilibrium found in {STEPS} steps: it still moves by {moved:.1e} rad or of "
        f"its size in a step of {h:.1e} s; if a force acts in a direction in which nothing holds a "
        "body, add a contact or a joint; otherwise start nearer to the equilibrium (state=...)",
        time=time,
    )


def _step(
    engine: Engine, h: float, longest: float, time: float, since: NDArray[np.intp]
) -> tuple[float, float]:
    """Make one step of h or, if it leads too far, of a part; return its increment and length."""
    rewind, q = engine.mark(), np.array(engine.q)
    while True:
        engine.v[:] = 0.0
        try:
            engine.step(engine.native_solver("ros2", h, True))
            moved = _increment(engine, q)
        except SimulationError:
            if h < FAINT * longest:
                raise
            moved = np.inf
        if moved <= STRIDE:
            break
        rewind()
        h *= SHORTER
    engine.time[0] = time  # loads are those of this time
    engine.states[since] = time - LONG_AGO
    engine.v[:] = 0.0
    return moved, h


def _increment(engine: Engine, q: Array) -> float:
    """Return the largest increment of a body from positions q, rad or sizes of the mechanism."""
    model, now = engine.model, np.array(engine.q)
    if not np.isfinite(now).all():
        return np.inf
    most = 0.0
    for b in model.bodies:
        move = np.abs(now[b.iq : b.iq + 3] - q[b.iq : b.iq + 3]).max() / model.size
        turn = 2.0 * np.abs(now[b.iq + 3 : b.iq + 7] - q[b.iq + 3 : b.iq + 7]).max()
        most = max(most, float(move), float(turn))
    return most


def _found(engine: Engine, start: State, time: float) -> State:
    lam = np.array(engine.accelerations()[1])
    return State(
        q=np.array(engine.q),
        v=np.zeros(engine.model.nv),
        lam=lam,
        time=time,
        turn=np.array(engine.turn),
        inputs=start.inputs,
        states=np.array(engine.states),
    )
