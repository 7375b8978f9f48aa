"""equilibrium: where a mechanism rests."""

from __future__ import annotations

import numpy as np

from jousto.engine import Engine, Model
from jousto.engine.native import displaced
from jousto.errors import InputError, SimulationError
from jousto.simulation.bent import warn_far
from jousto.simulation.large import MANY
from jousto.simulation.linear import at_rest, stiffness_modes, turning
from jousto.simulation.settle import settle
from jousto.simulation.state import State

ITERATIONS = 200
TURN = 0.5  # largest rotation of an iteration, rad
TRAVEL = 0.3  # largest translation of an iteration, of the size of the mechanism
FREE = 1e-12  # omega^2 below this share of the largest: a free direction


def equilibrium(model: Model, state: State | None = None, *, tolerance: float = 1e-10) -> State:
    """Find a static equilibrium near a state by a damped Newton iteration.

    The forces on the free coordinates, ``N^T M a`` at v = 0, are brought to zero by steps
    ``sum_i x_i (x_i . N^T M a) / |omega_i^2|`` over the modes x_i of the exact stiffness. The
    absolute value leads downhill, so that a hanging pendulum is found, not an upright one (a start
    exactly in an unstable equilibrium stays there). Steps are bounded in turn and travel and the
    joints are closed after each.

    Parameters
    ----------
    model : Model
        From `compile`.
    state : State, optional
        Start; None is the initial state. Time counts for signals.
    tolerance : float
        Largest remaining force, relative to all forces that act on the free coordinates.

    Directions without stiffness, such as the spin of a rope between spherical joints, are no
    obstacle as long as no force works in them. Mechanisms with beams, large ones, and those where
    this fails go a slower and surer way, steps through a viscous medium.

    Raises
    ------
    SimulationError
        If there is none, or it is not found: the message says which, and names the body.
    InputError
        If a body or joint is singular at some position on the way.

    Warns
    -----
    JoustoWarning
        A body with modes bends by more than they, which are linear, can follow.
    """
    found = _rest(model, state, tolerance)
    warn_far(model, found.q, f"equilibrium of {model.name!r}")
    return found


def _rest(model: Model, state: State | None, tolerance: float) -> State:
    large = model.nv + model.nrow > MANY
    if large or model.beams:  # beams travel far and have many coordinates
        try:
            return settle(model, state)
        except RuntimeError:  # rows that repeat one another make the sparse matrix singular
            if large:
                raise
    time = 0.0 if state is None else state.time
    q = np.array(model.q0 if state is None else state.q)
    rest = np.zeros(model.nv)
    engine = Engine(model)
    bound, largest = 1.0, 0.0
    exact = polished = False
    body = ""
    for iteration in range(ITERATIONS):
        t = at_rest(model, State(q, rest, np.zeros(model.nrow), time))
        if t.N.shape[1] == 0:
            return State(q, rest, t.lam, time)
        force = t.N.T @ t.M @ t.a
        squares, shapes = stiffness_modes(t)
        # reach of the forces: a stiff direction at its round-off must not keep the others waiting
        if iteration == ITERATIONS // 2:
            exact, bound = True, 1.0
        if not exact:  # shapes as if they were orthogonal: finds the way from afar
            push = np.real(shapes.T @ force)
            push = push / np.maximum(np.abs(np.einsum("ij,ij->j", shapes, shapes)), 1e-300)
        else:  # under follower loads they are not, least of all those of equal frequencies
            push = np.linalg.lstsq(shapes, force, rcond=None)[0]
        rates = np.abs(squares)
        amounts = push / np.maximum(rates, FREE * max(float(rates.max()), 1.0))
        step = t.N @ np.real(shapes @ amounts)
        largest = max(largest, float(np.abs(t.a).max()), float(np.linalg.norm(model.gravity)))
        moves = [np.abs(step[b.iv : b.iv + 3]).max() for b in model.bodies]
        turns = [np.abs(step[b.iv + 3 : b.iv + 6]).max() for b in model.bodies]
        # a body whose frame is held bends all the same
        bent = max(
            np.abs(s.modes @ step[b.iv + 6 : b.iv + 6 + b.n]).max(initial=0.0)
            for b, s in zip(model.bodies, model.shapes, strict=True)
        )
        reach = max(max(*moves, bent) / (TRAVEL * model.size), max(turns) / TURN, 1e-300)
        body = model.bodies[int(np.argmax(np.array(moves) / model.size + np.array(turns)))].name
        small = np.abs(t.a).max() <= tolerance * max(largest, 1e-300)
        if small or reach < 1e-13:
            if polished:
                return State(q, rest, t.lam, time)
            polished = exact  # one exact step more
            if not exact:
                exact, bound = True, 1.0
                continue
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
    if not model.beams:  # a way that is slower and surer
        try:
            return settle(model, state)
        except (RuntimeError, InputError):  # friction that sticks, rows that repeat one another
            pass
    raise SimulationError(
        f"no static equilibrium found in {ITERATIONS} iterations, body '{body}' moves most: if "
        "something pushes it in a direction in which nothing holds it, add a joint or take the "
        "load away; else start nearer to the rest position (state=...)",
        time=time,
        body=body,
    )
