"""loads_of: all loads on a body of a run, one by one, with a check of their balance."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem, warn
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.scales import scales_of
from jousto.recovery.instants import bracket_instants
from jousto.recovery.loads.attribution import sources
from jousto.recovery.loads.body_loads import GROUPS, BodyLoad, BodyLoads, BodyMotion
from jousto.recovery.loads.own_loads import OWN, own_loads
from jousto.recovery.model_of_run import model_of_run
from jousto.recovery.shape import find_body, rotation_matrices
from jousto.simulation.results.solution import Solution
from jousto.simulation.state import put

WARNED, REFUSED = 1e-8, 1e-4
"""Unbalanced part of the loads above which there is a warning, and an error: the sum is 0 up to
rounding and to the tolerance of the iteration of dry friction."""


@explained
def loads_of(
    run: Solution, body: str, times: ArrayLike | None = None, *, model: Model | None = None
) -> BodyLoads:
    """Return all loads on a body over a run: those that act on it, and those of its inertia.

    The accelerations and multipliers at each stored state are those of the engine. Every force,
    joint and friction of the model is evaluated by itself; gravity, inertia and elastic forces
    follow from the inertia invariants of the body. The sum of all loads vanishes (d'Alembert;
    Altarriba 2010, eq. 96-98): ``Q_joint + Q_applied + Q_friction + Q_gravity + Q_inertia +
    Q_elastic = 0`` for force, moment and each mode. Runs in joint coordinates have the same loads.

    Parameters
    ----------
    run : Solution
        Results of `simulate`.
    body : str
        Name of a rigid or flexible body.
    times : (nt,) array_like, optional
        Instants within the run, s, with linear interpolation between stored ones; None: all stored
        instants.
    model : Model, optional
        Model of the run; needed for results from a file. None: the model of the run. It must
        reproduce gravity, masses, energies, reactions and sensors of the results.

    Raises
    ------
    InputError
        For an unknown body or an exact beam, a missing model or that of another machine, a time
        outside of the run, or loads whose unbalanced part is above 1e-4.

    Warns
    -----
    JoustoWarning
        If the unbalanced part is above 1e-8.

    Examples
    --------
    >>> import jousto as jo
    >>> ball = jo.RigidBody("ball", 2.0, (1.0, 1.0, 1.0))
    >>> rail = jo.Prismatic("rail", jo.ground["origin"], ball["origin"], axis=(0, 0, 1))
    >>> fall = jo.simulate(jo.compile(jo.Mechanism(ball, rail, jo.Gravity((0, 0, -10)))), 0.1)
    >>> loads = loads_of(fall, "ball")
    >>> list(loads)
    ['rail', 'gravity', 'inertia', 'centrifugal and gyroscopic']
    >>> round(loads["inertia"].force[-1, 2].item(), 6)
    20.0
    """
    if times is None:
        found = _gathered(run, body, range(run.nt), model)
    else:
        before, after, _ = bracket_instants(run.time, times, f"loads on '{body}'")
        found = _gathered(run, body, np.union1d(before, after), model).at(times)
    _judge(found)
    return found


def _gathered(run: Solution, body: str, instants: Ints | range, given: Model | None) -> BodyLoads:
    """Return the loads at stored instants."""
    model = model_of(run, body, given)
    k = [one.name for one in model.bodies].index(body)
    of = model.bodies[k]
    width, place = 6 + of.n, slice(of.iv, of.iv + 6 + of.n)
    # accelerations, multipliers and the loads of every item at each state, in maximal coordinates
    engine = Engine(replace(model, tree=()))
    rows = np.empty((len(instants), len(engine.body_loads(k)), width))
    time, a = np.empty(len(instants)), np.empty((len(instants), width))
    q, v = np.empty((len(instants), width + 1)), np.empty((len(instants), width))
    for i, state in enumerate(run.each_state(instants)):
        engine.lam[:] = 0.0  # multipliers of joints that an event has released
        put(engine, replace(state, work=None), run.where)  # kinematics does not use the work
        a[i] = engine.accelerations()[0][place]
        q[i], v[i] = engine.q[of.iq : of.iq + 1 + width], engine.v[place]
        rows[i], time[i] = engine.body_loads(k), state.time
    # vectors of the motion in the body frame
    A = rotation_matrices(q[:, 3:7])
    v[:, :3], a[:, :3] = (np.einsum("tba,tb->ta", A, x[:, :3]) for x in (v, a))
    felt = np.einsum("tba,b->ta", A, np.real(model.gravity))
    motion = BodyMotion(felt, a[:, :3], v[:, 3:6], a[:, 3:6], q[:, 7:], v[:, 6:], a[:, 6:])
    center = (np.real(of.S0) + motion.p @ np.real(of.I3).T) / float(np.real(of.mass[0]))
    own = own_loads(of, felt, q, v, a)
    loads = []
    for source in sources(model, k):
        row = rows[:, list(source.rows)].sum(axis=1)
        facts = {"place": source.place, "node": source.node, "position": source.position}
        point = source.points(motion.p, center)
        loads.append(_load(source.name, source.kind, row, point, **facts))
    loads += [_load(kind, kind, own[kind], center) for kind in OWN if kind in own]
    scales, shape = scales_of(model), find_body(run, body)
    # radius of the nodes about the centre, or radius of gyration
    mass, moments = float(np.real(of.mass[0])), float(np.real(of.J0[:3]).sum())
    gyration = np.sqrt(abs(0.5 * moments / mass - center[0] @ center[0]))
    extent = np.linalg.norm(shape.nodes - center[0], axis=1).max(initial=0.0)
    return BodyLoads(
        body=body,
        time=time,
        loads=tuple(loads),
        frame="body",
        rotation=A,
        center=center,
        motion=motion,
        nodes=shape.nodes,
        modes=shape.modes,
        arm=float(max(gyration, extent)),
        reach=float(np.abs(shape.modes).max(initial=0.0)),
        floor=np.array([scales.floor("N"), scales.floor("N m")]),
    )


def _load(name: str, kind: str, row: Array, point: Array, **place: Any) -> BodyLoad:
    """Return a load from its force, moment about the origin and modal forces (nt, 6 + n)."""
    force = row[:, :3].copy()
    moment = row[:, 3:6] - np.cross(point, force)
    return BodyLoad(name, kind, point, force, moment, row[:, 6:].copy(), **place)


def model_of(run: Solution, body: str, given: Model | None) -> Model:
    """Return the model of a run that has a body with loads.

    Raises
    ------
    InputError
        If the model is unknown or another one, or the body does not exist or is an exact beam.
    """
    where = f"loads on '{body}'"
    beams = {shape.name: shape for shape in run.beams}
    beam = body if body in beams else body.rpartition(".node")[0]
    if beam in beams:
        message = (
            f"'{beam}' is an exact beam; jo.recovery.section_forces(run, {beam!r}) has the "
            "forces and moments along it"
        )
        raise InputError(Problem(where, message))
    find_body(run, body)
    return model_of_run(run, given, where)


def _judge(loads: BodyLoads) -> None:
    """Warn about loads that are not in balance, or refuse them, with equation and instant."""
    worst = loads.balance.max(axis=0, initial=0.0)
    k = int(np.argmax(worst))
    if not worst[k] > WARNED:
        return
    instant = loads.time[int(np.argmax(loads.balance[:, k]))]
    message = (
        f"are not in balance: at {instant:g} s the sum of the {GROUPS[k]}s is {worst[k]:.1e} of "
        "all loads; the state of the run may not be one of this model, or the iteration of its "
        "friction has not converged"
    )
    if worst[k] > REFUSED:
        raise InputError(Problem(f"loads on '{loads.body}'", message))
    warn(f"loads on '{loads.body}'", message)
