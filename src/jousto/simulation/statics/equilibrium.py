"""equilibrium: where a mechanism rests."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.base.arguments import explained
from jousto.base.errors import InputError, SimulationError
from jousto.certificate.load_warnings import warn_loads
from jousto.model.model import Model
from jousto.model.native.native import Engine, displaced
from jousto.model.packing.foreign import without_fmus
from jousto.model.scales import largest_speed
from jousto.simulation.check_bending import warn_far
from jousto.simulation.controllers import hold_controllers, settle_controllers
from jousto.simulation.modes.large import MANY
from jousto.simulation.modes.linear import at_rest, stiffness_modes, turning
from jousto.simulation.state import State, put
from jousto.simulation.statics.equilibrium_sparse import settle
from jousto.simulation.statics.free_bodies import check_adrift
from jousto.simulation.statics.neglected_stiffening import check_second_order

ITERATIONS = 100
TURN = 0.5  # largest rotation of an iteration, rad
TRAVEL = 0.3  # largest translation of an iteration, of the size of the mechanism
FREE = 1e-12  # omega^2 below this share of the largest: a free direction


@explained
def equilibrium(model: Model, state: State | None = None, *, tolerance: float = 1e-10) -> State:
    """Find a static equilibrium near a state: where it comes to rest.

    Steps through a viscous medium lead downhill, so that a hanging pendulum is found, not an
    upright one (a start exactly in an unstable equilibrium stays there); Newton's method ends them.
    Its matrix is that of the engine, sparse, and each step costs about as much as one of an
    implicit method. Where that fails, small mechanisms go by steps ``sum_i x_i c_i / |omega_i^2|``
    over the modes x_i of the exact stiffness, c the forces expanded in ``M x_i``, bounded in turn
    and travel, with the joints closed after each.

    Parameters
    ----------
    model : Model
        From `compile`.
    state : State, optional
        Start; None is the initial state. Time counts for signals.
    tolerance : float
        Largest remaining force of the steps by modes, relative to all forces that act on the free
        coordinates; the other way ends at increments of 1e-10 of the size.

    A `PID` holds its coordinate at its reference, with the integral part that this takes.

    Directions without stiffness, such as the spin of a rope between spherical joints, are no
    obstacle as long as no force works in them.

    Raises
    ------
    SimulationError
        If there is none, or it is not found; the message distinguishes both and names the body.
        If a linear body would buckle there: the loads beyond a critical one are no rest.
    InputError
        If a body or joint is singular at some position on the way.

    Warns
    -----
    JoustoWarning
        A body with modes bends by more than they, which are linear, can follow, or a part without
        ``stiffening=True`` bends otherwise by per cents where loads stiffen or soften it.
    """
    warn_loads(model)
    held, where = hold_controllers(model), f"equilibrium of {model.name!r}"
    found = settle_controllers(model, state, lambda at: _rest(held, at, tolerance))
    far = warn_far(held, found.q, where)
    check_second_order(held, found, where, told=far)
    return found


def _rest(model: Model, state: State | None, tolerance: float) -> State:
    without_fmus(model, "equilibrium", "has no state at rest that is known")
    check_adrift(model, state)
    try:
        return settle(model, state)
    except (SimulationError, RuntimeError, InputError) as error:
        # loads that follow and lead uphill, rows that repeat one another
        if model.nv + model.nrow > MANY:
            raise
        try:
            return _by_modes(model, state, tolerance)
        except SimulationError:
            if isinstance(error, SimulationError):  # it knows more of what is wrong
                raise error from None
            raise


def _by_modes(model: Model, state: State | None, tolerance: float) -> State:
    """Return a static equilibrium by Newton's steps in the modes of the exact stiffness."""
    rest = np.zeros(model.nv)
    start = State(model.q0, rest, np.zeros(model.nrow)) if state is None else state
    time, q = start.time, np.array(start.q)
    engine = Engine(model)
    put(engine, start, "equilibrium")
    bound, largest = 1.0, 0.0
    body = ""
    for _ in range(ITERATIONS):
        t = at_rest(model, replace(start, q=q, v=rest, turn=None, joint=None))
        if t.N.shape[1] == 0:
            return replace(start, q=q, v=rest, lam=t.lam, turn=None, joint=None)
        force = t.N.T @ t.M @ t.a
        squares, shapes = stiffness_modes(t)
        # under follower loads shapes are not orthogonal, least of all those of equal frequencies
        push = np.linalg.lstsq(shapes, force, rcond=None)[0]
        # reach of the forces: a stiff direction at its round-off must not keep the others waiting
        rates = np.abs(squares)
        pull = largest_speed(model, t.a)  # m/s2
        least = FREE * max(float(rates.max()), pull / model.size, 1e-300)
        step = t.N @ np.real(shapes @ (push / np.maximum(rates, least)))
        largest = max(largest, pull, float(np.linalg.norm(model.gravity)))
        moves = [np.abs(step[b.iv : b.iv + 3]).max() for b in model.bodies]
        turns = [np.abs(step[b.iv + 3 : b.iv + 6]).max() for b in model.bodies]
        # a body whose frame is held bends all the same
        bent = max(
            np.abs(s.modes @ step[b.iv + 6 : b.iv + 6 + b.n]).max(initial=0.0)
            for b, s in zip(model.bodies, model.shapes, strict=True)
        )
        reach = max(max(*moves, bent) / (TRAVEL * model.size), max(turns) / TURN, 1e-300)
        body = model.bodies[int(np.argmax(np.array(moves) / model.size + np.array(turns)))].name
        if pull <= tolerance * largest or reach < 1e-13:
            return replace(start, q=q, v=rest, lam=t.lam, turn=None, joint=None)
        before = float(force @ force)
        factor = min(1.0, bound / reach)
        engine.time[0] = time
        engine.q[:] = displaced(model, q, turning(model, q) @ (factor * step))
        engine.v[:] = 0.0
        engine.assemble()
        q = np.array(engine.q)
        engine.v[:] = 0.0
        a, _ = engine.accelerations()
        # went past the bottom and climbed higher on the other side: shorter steps
        after = t.N.T @ t.M @ (turning(model, q).T @ a)
        if float(after @ force) < 0.0 and float(after @ after) > before:
            bound *= 0.5
    raise SimulationError(
        f"no static equilibrium found in {ITERATIONS} iterations, body '{body}' moves most: if "
        "something pushes it in a direction in which nothing holds it, add a joint or take the "
        "load away; else start nearer to the rest position (state=...)",
        time=time,
        body=body,
    )
