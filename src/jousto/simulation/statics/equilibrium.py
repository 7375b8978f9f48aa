"""equilibrium: static equilibrium of a mechanism near a state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.base.arguments import explained
from jousto.base.errors import InputError, SimulationError, warn
from jousto.certificate.load_warnings import warn_loads
from jousto.model.model import Model
from jousto.model.native.native import Engine, displaced
from jousto.model.packing.foreign import without_fmus
from jousto.model.scales import largest_speed
from jousto.simulation.check_bending import warn_far
from jousto.simulation.contacts import contacts
from jousto.simulation.controllers import hold_controllers, settle_controllers
from jousto.simulation.modes.large import MANY
from jousto.simulation.modes.linear import at_rest, body_frame_increments, stiffness_modes
from jousto.simulation.state import State, put
from jousto.simulation.statics.contact_rest import rest_on_contacts
from jousto.simulation.statics.equilibrium_sparse import settle
from jousto.simulation.statics.free_bodies import check_adrift
from jousto.simulation.statics.neglected_stiffening import check_second_order
from jousto.simulation.statics.plastic_limit import name_plastic_limit
from jousto.simulation.statics.states_rest import rest_with_states, state_systems, without_memories

ITERATIONS = 100  # maximum number of iterations
TURN = 0.5  # largest rotation of an iteration, rad
TRAVEL = 0.3  # largest translation of an iteration / size of the mechanism
FREE = 1e-12  # omega^2 over the largest one, below which a direction has no stiffness


@explained
def equilibrium(model: Model, state: State | None = None, *, tolerance: float = 1e-10) -> State:
    """Return a static equilibrium of a mechanism near a state.

    Implicit steps of an overdamped motion reduce the potential energy; Newton's method follows near
    the minimum. The equilibrium is therefore stable, such as that of a hanging pendulum, not of an
    upright one (a start exactly at an unstable equilibrium remains there). The matrix is the sparse
    one of the engine, and a step costs about as much as a step of an implicit method. If this
    fails, small mechanisms take steps ``sum_i x_i c_i / |omega_i^2|`` over the modes x_i of the
    exact stiffness, with the forces expanded as ``sum_i c_i M x_i``, bounded in rotation and
    translation; after each step the joints are closed.

    Parameters
    ----------
    model : Model
        From `compile`.
    state : State, optional
        Starting point; None: the initial state. Signals have the values of its time.
    tolerance : float
        Largest residual force of the steps by modes, relative to the forces on the free
        coordinates; the sparse iteration ends at increments of 1e-10 sizes of the mechanism.

    States of blocks do not change: their equations and those of the bodies are solved together, by
    Newton's method, which may end at an unstable equilibrium. A `PID` has its coordinate at the
    reference, with the integral part that balances the loads.
    A mechanism with contacts settles on them by steps that start at rest; its bristles stick or
    slip on the way from the state (`jousto.simulation.statics.contact_rest`). Directions without
    stiffness, such as the spin of a rope between spherical joints, are allowed if no force acts in
    them.

    Raises
    ------
    SimulationError
        If there is no equilibrium, or the iteration does not find one; the message distinguishes
        the two and names the body. If the loads exceed the buckling load of a linear body.
    InputError
        If a body or joint is singular at a position of the iteration.

    Warns
    -----
    JoustoWarning
        If a modal body bends beyond the range of its linear modes, or if geometric stiffness would
        change the deflection of a part without ``stiffening=True`` by per cents.
    """
    warn_loads(model)
    for row in model.switched:
        if row.begin < 0:
            warn(
                f"rigid stop {row.name!r}",
                "an equilibrium is found as if there were no rigid stop; check that its coordinate "
                "is within the limits, or use an elastic Stop",
            )
    held, where = hold_controllers(model), f"equilibrium of {model.name!r}"
    without_memories(model, where)
    if state_systems(model):
        without_fmus(model, "equilibrium", "has no state at rest that is known")
        found = rest_with_states(model, state)
    else:
        found = settle_controllers(model, state, lambda at: _rest(held, at, tolerance))
    far = warn_far(held, found.q, where)
    check_second_order(held, found, where, told=far)
    return found


def _rest(model: Model, state: State | None, tolerance: float) -> State:
    without_fmus(model, "equilibrium", "has no state at rest that is known")
    check_adrift(model, state)
    if contacts(model):
        return rest_on_contacts(model, state)
    try:
        return settle(model, state)
    except (SimulationError, RuntimeError, InputError) as error:
        # follower loads that raise the energy, or redundant constraints: steps by modes
        if model.nv + model.nrow > MANY:
            raise
        try:
            return _by_modes(model, state, tolerance)
        except SimulationError:
            if isinstance(error, SimulationError):  # has the more specific message
                raise error from None
            raise


def _by_modes(model: Model, state: State | None, tolerance: float) -> State:
    """Return a static equilibrium, by bounded Newton steps in the modes of the stiffness."""
    rest = np.zeros(model.nv)
    start = State(model.q0, rest, np.zeros(model.nrow)) if state is None else state
    time, q = start.time, np.array(start.q)
    engine = Engine(model)
    put(engine, start, "equilibrium")
    bound, largest = 1.0, 0.0
    body = ""
    for _ in range(ITERATIONS):
        t = at_rest(model, replace(start, q=q, v=rest, turn=np.array(engine.turn), joint=None))
        if t.N.shape[1] == 0:
            return _yielded(
                engine,
                replace(start, q=q, v=rest, lam=t.lam, turn=np.array(engine.turn), joint=None),
            )
        force = t.N.T @ t.M @ t.a
        squares, shapes = stiffness_modes(t)
        # modal forces c by least squares: under follower loads the shapes are not orthogonal
        push = np.linalg.lstsq(shapes, force, rcond=None)[0]
        # smallest omega^2 of a step, so that round-off in a stiff direction does not limit it
        rates = np.abs(squares)
        pull = largest_speed(model, t.a)  # m/s2
        least = FREE * max(float(rates.max()), pull / model.size, 1e-300)
        step = t.N @ np.real(shapes @ (push / np.maximum(rates, least)))
        largest = max(largest, pull, float(np.linalg.norm(model.gravity)))
        moves = [np.abs(step[b.iv : b.iv + 3]).max() for b in model.bodies]
        turns = [np.abs(step[b.iv + 3 : b.iv + 6]).max() for b in model.bodies]
        # modal coordinates move also if the body frame is fixed
        bent = max(
            np.abs(s.modes @ step[b.iv + 6 : b.iv + 6 + b.n]).max(initial=0.0)
            for b, s in zip(model.bodies, model.shapes, strict=True)
        )
        reach = max(max(*moves, bent) / (TRAVEL * model.size), max(turns) / TURN, 1e-300)
        body = model.bodies[int(np.argmax(np.array(moves) / model.size + np.array(turns)))].name
        if pull <= tolerance * largest or reach < 1e-13:
            return _yielded(
                engine,
                replace(start, q=q, v=rest, lam=t.lam, turn=np.array(engine.turn), joint=None),
            )
        before = float(force @ force)
        factor = min(1.0, bound / reach)
        engine.time[0] = time
        engine.q[:] = displaced(model, q, body_frame_increments(model, q) @ (factor * step))
        engine.v[:] = 0.0
        engine.assemble()
        q = np.array(engine.q)
        engine.v[:] = 0.0
        a, _ = engine.accelerations()
        # the potential energy rose behind the minimum: shorten the steps
        after = t.N.T @ t.M @ (body_frame_increments(model, q).T @ a)
        if float(after @ force) < 0.0 and float(after @ after) > before:
            bound *= 0.5
    remedy = name_plastic_limit(engine, q) or (
        "; if a force acts on it in a direction without stiffness, add a joint or remove the "
        "load; otherwise start nearer to the equilibrium (state=...)"
    )
    raise SimulationError(
        f"no static equilibrium found in {ITERATIONS} iterations, body '{body}' moves most{remedy}",
        time=time,
        body=body,
    )


def _yielded(engine: Engine, found: State) -> State:
    """Return the state with the plastic deformation that occurred on the way to it."""
    if not engine.model.nstate:
        return found
    engine.q[:], engine.v[:] = found.q, found.v
    engine.yield_forces()
    return replace(found, states=np.array(engine.states))
