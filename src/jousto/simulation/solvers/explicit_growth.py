"""Growth rate of small motions caused by springs and bushings at a given step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError
from jousto.model.model import Model
from jousto.model.native.native import Engine, displaced
from jousto.model.scales import velocity_metres
from jousto.simulation.controllers import state_sizes
from jousto.simulation.solvers.base import Solver, prepared
from jousto.simulation.solvers.implicit import Newmark
from jousto.simulation.solvers.stability import DENSE

DISTANCE = 1e-7  # step of the differences, over the size of the mechanism, or rad
SPEED = 1e-8  # step of the differences of velocities, over the size of the mechanism in a step


def excess(model: Model, solver: Solver, step: float) -> float:
    """Return the growth rate, 1/s, that the method adds to small motions about the start.

    The rate is that of the largest eigenvalue of the map of one step, by central differences, minus
    that of the trapezoidal rule, for which only physically unstable motions grow. Python force
    functions are left out. The rate is 0 for machines without springs and bushings, and for those
    with more than 300 states, which are not examined.
    """
    if not any(force.law.between for force in model.forces) or 2 * model.nv + model.nstate > DENSE:
        return 0.0
    model = _without_functions(model)
    try:
        whole = _largest(model, solver, step)
        own = _largest(model, Newmark(step=step), step) if whole > 1.0 else 1.0
    except (InputError, np.linalg.LinAlgError):
        return 0.0  # the run itself reports the error
    return max(0.0, float(np.log(whole / max(1.0, own)))) / step


def _without_functions(model: Model) -> Model:
    """Return a model without Python force functions, which must be called in the run only."""
    forces = (
        replace(force, function=_nothing) if force.kind == "user" else force
        for force in model.forces
    )
    return replace(model, forces=tuple(forces))


def _nothing(t: float, x: Array) -> Array:
    return np.zeros(6)


def _largest(model: Model, solver: Solver, step: float) -> float:
    """Return the largest magnitude of the eigenvalues of the map of one step."""
    engine = Engine(model)
    native = prepared(engine, solver, step)
    nv = model.nv

    states = np.array(engine.states)
    free = np.flatnonzero(state_sizes(model))  # plastic deformation stays

    def after(x: Array) -> tuple[Array, Array]:
        engine.time[0] = 0.0
        engine.q[:] = displaced(model, model.q0, x[:nv])
        engine.v[:] = model.v0 + x[nv : 2 * nv]
        engine.states[:] = states
        engine.states[free] += x[2 * nv :]
        engine.restart()
        engine.step(native)
        return engine.q.copy(), np.concatenate([engine.v, engine.states[free]])

    after(np.zeros(2 * nv + len(free)))
    back = np.linalg.pinv(engine.increments())  # map from small changes of q to increments
    unit = model.size / velocity_metres(model)
    sizes = [DISTANCE * unit, SPEED * unit / step, DISTANCE * state_sizes(model)[free]]
    columns = []
    scale = np.concatenate(sizes)
    for x in np.diag(scale):
        (q1, v1), (q0, v0) = after(x), after(-x)
        change = np.concatenate([back @ (q1 - q0), v1 - v0])
        columns.append(change / (2.0 * scale))
    matrix = np.stack(columns, axis=1)
    if not np.isfinite(matrix).all():
        return float("inf")
    return float(np.abs(np.linalg.eigvals(matrix)).max(initial=0.0))
