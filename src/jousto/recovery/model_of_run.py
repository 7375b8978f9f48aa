"""The model of a run: its own, or a given one that reproduces the stored values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.model.model import BodyModel, Model
from jousto.model.native.native import Engine
from jousto.model.scales import position_metres, scales_of, velocity_metres
from jousto.simulation.results.records import BodyShape
from jousto.simulation.results.solution import Solution
from jousto.simulation.state import State, put

SAME = 1e-8
"""Deviation / largest value of the run, up to which a recomputed value is the stored one."""
REPRODUCED = 1e-6
"""The same for reactions and sensors: those of dry friction are iterated."""
ITERATED = 0.05
"""The same for reactions and sensors of an implicit method, which stores its own multipliers, and
for accelerations against the stored velocities."""
IMPLICIT = ("GeneralizedAlpha", "Newmark")
TURN = 0.5
"""Angle of a body or phase of a mode, rad, above which three instants are too far apart."""
ROUNDING = 1e-12
RESOLVED = 0.01
"""Deviation of displacements from the integral of the velocities / that of their sizes, above which
the stored instants are too far apart to compare velocities with accelerations."""
TESTED = 8
"""Instants at which a model is compared with a run, besides those of the largest energies."""
ENERGIES = ("kinetic", "strain", "potential", "springs")


def model_of_run(run: Solution, given: Model | None, where: str) -> Model:
    """Return the model of a run: its own if none is given, else the given one after a check.

    Raises
    ------
    InputError
        If the model is unknown, or the given one differs: see `check_model`.
    """
    model = run.model if given is None else given
    if model is None:
        message = (
            f"{run.where} contains no forces and joints, only their results: give its model, "
            "model=jo.compile(mechanism)"
        )
        raise InputError(Problem(where, message))
    check_model(run, model, where)
    return model


def check_model(run: Solution, model: Model, where: str) -> None:
    """Raise an error for a model that is not the one of the run.

    Bodies, modes, joints, internal states, gravity and total mass must be equal. The model is then
    set to the states of several stored instants, at which its energies, reactions and sensors must
    equal the stored ones.

    Raises
    ------
    InputError
        With all differences by name.

    Warns
    -----
    JoustoWarning
        If its accelerations contradict the stored velocities, where these resolve the motion; a
        force along a free direction would change neither energies nor reactions. Not tested with
        springs, friction, controllers and exact beams, whose vibrations may be too fast.
    """
    if model is run.model:
        return
    problems, of = Problems(), f"model '{model.name}' is not that of {run.where}: "
    first = next(run.each_state([0]))
    sizes = {(model.nq, model.nv, model.nrow, names(model.bodies))}
    sizes.add((len(first.q), len(first.v), len(first.lam), names(run.bodies)))
    if len(sizes) > 1:
        raise InputError(Problem(where, of + "other bodies, modes or joints"))
    for text in _other_facts(run, model):
        problems.add(where, of + text)
    for text in _other_values(run, model):
        problems.add(where, of + text)
    problems.raise_if_any()
    for text in _other_accelerations(run, model):
        warn(where, text)


def names(bodies: Sequence[BodyModel | BodyShape]) -> tuple[str, ...]:
    """Return the names of bodies."""
    return tuple(body.name for body in bodies)


def _other_facts(run: Solution, model: Model) -> Iterator[str]:
    """Yield gravity, total mass and sensors that differ."""
    stored, own = run.attributes.get("gravity"), np.real(model.gravity)
    if stored is not None and not np.allclose(stored, own, rtol=SAME, atol=0.0):
        yield f"its gravity is {_triple(own)} m/s2, in the results {_triple(stored)} m/s2"
    scales = run.attributes.get("scales")
    mass = scales_of(model).mass
    if scales is not None and not np.isclose(scales[0], mass, rtol=SAME, atol=0.0):
        yield f"its bodies have {mass:.6g} kg, in the results {scales[0]:.6g} kg"


def _other_values(run: Solution, model: Model) -> Iterator[str]:
    """Yield energies, reactions, sensors and accelerations that the model does not reproduce."""
    energies = np.stack([getattr(run.energy, name) for name in ENERGIES], axis=1)
    instants = _instants(run.nt, energies)
    found = [_at(engine, run, state) for engine, state in _each(run, model, instants)]
    time, same = run.time[instants], _without_events(run, instants)
    # energies are functions of the state alone, in every method
    level = SAME * float(np.abs(energies).max(initial=0.0))
    for i, name in enumerate(ENERGIES):
        own = np.array([values.energy[i] for values in found])
        yield from _deviation(f"{name} energy", time, own, energies[instants, i], level, " J")
    # reactions and sensors
    share = ITERATED if str(run.attributes.get("solver", "")).startswith(IMPLICIT) else REPRODUCED
    kept = np.array([np.real(state.lam) for state in run.each_state(instants)])[same]
    lam, sensed = (np.array([getattr(x, n) for x in found])[same] for n in ("lam", "sensors"))
    level = share * float(np.abs(kept).max(initial=0.0))
    for joint in model.joints:
        rows = slice(joint.row, joint.row + joint.rows)
        what = f"reaction of '{joint.name}'"
        yield from _deviation(what, time[same], lam[:, rows], kept[:, rows], level)
    for sensor in model.sensors:
        if sensor.name not in run.sensors:
            continue  # this item does not change the motion
        values = run[sensor.name].reshape(run.nt, -1)
        own = sensed[:, sensor.offset : sensor.offset + sensor.count]
        if own.shape[1] != values.shape[1]:
            yield f"its sensor '{sensor.name}' has other components"
            continue
        level = share * float(np.abs(values).max(initial=0.0))
        yield from _deviation(
            f"sensor '{sensor.name}'", time[same], own, values[instants][same], level
        )


@dataclass(frozen=True)
class _Values:
    """Energies (4,), multipliers (nrow,), sensors (nout,) and accelerations (nv,) at a state."""

    energy: Array
    lam: Array
    sensors: Array
    a: Array


def _each(run: Solution, model: Model, instants: list[int]) -> Iterator[tuple[Engine, State]]:
    """Yield the engine of a model, in maximal coordinates, set to each state."""
    engine = Engine(replace(model, tree=()))
    for state in run.each_state(instants):
        yield engine, state


def _at(engine: Engine, run: Solution, state: State) -> _Values:
    """Return the values that an engine computes at a state."""
    engine.lam[:] = 0.0  # multipliers of joints that an event has released
    put(engine, replace(state, work=None), run.where)  # kinematics does not use the work
    a = np.real(engine.accelerations()[0]).copy()
    lam, sensors = np.real(engine.lam).copy(), np.real(engine.sensors())
    return _Values(np.real(engine.energy()), lam, sensors, a)


def _deviation(
    what: str, time: Array, own: Array, stored: Array, level: float, unit: str = ""
) -> Iterator[str]:
    """Yield the largest deviation of a quantity (nt,) or (nt, k) if it exceeds a level."""
    if not own.size:
        return
    own, stored = own.reshape(len(time), -1), stored.reshape(len(time), -1)
    known = np.isfinite(stored)
    miss = np.where(known, np.abs(np.where(known, own - stored, 0.0)), 0.0)
    i, j = np.unravel_index(int(miss.argmax()), miss.shape)
    if miss[i, j] <= level:
        return
    yield (
        f"its {what} at {time[i]:g} s is {own[i, j]:.6g}{unit}, "
        f"in the results {stored[i, j]:.6g}{unit}"
    )


def _instants(nt: int, energies: Array) -> list[int]:
    """Return instants spread over nt stored ones, with the instants of extreme energies."""
    spread = np.linspace(0, nt - 1, min(TESTED, nt)).astype(int)
    extreme = (*energies.argmax(axis=0), *energies.argmin(axis=0))
    return [int(k) for k in np.unique([*spread, *extreme])]


def _without_events(run: Solution, instants: list[int]) -> Ints:
    """Return positions in a list of instants at which no event happens."""
    pairs = zip(
        run.each_state([max(k - 1, 0) for k in instants]), run.each_state(instants), strict=True
    )
    kept = [
        i
        for i, (one, two) in enumerate(pairs)
        if one.happened is None
        or two.happened is None
        or np.array_equal(one.happened, two.happened)
    ]
    return np.array(kept, dtype=np.intp)


def _other_accelerations(run: Solution, model: Model) -> Iterator[str]:
    """Yield accelerations that contradict the stored velocities, where these resolve them.

    The check uses Simpson's rule over three instants, with an error estimate by the trapezoidal
    rule. Three quarters of the tested places must deviate, since impacts may occur at a few of
    them.
    """
    # exact beams, springs, friction, controllers: vibrations may be faster than the instants
    fast = any(force.states or force.function for force in model.forces)
    fast = fast or bool(model.beam_shapes or model.frictions or run.energy.springs.any())
    if run.nt < 3 or fast:
        return
    to_v, to_q = velocity_metres(model), position_metres(model)
    places = np.unique(np.linspace(1, run.nt - 2, min(TESTED, run.nt - 2)).astype(int))
    straight, fastest = _straight(model), _fastest(model)
    missed, where = [], []
    for k in map(int, places):
        t = run.time[k - 1 : k + 2]
        states = list(run.each_state([k - 1, k, k + 1]))
        v = np.array([np.real(state.v) for state in states]) * to_v
        q = np.array([np.real(state.q) for state in states]) * to_q
        moved, size, _ = _simpson(t, v[:, straight[1]])
        step = q[2, straight[0]] - q[0, straight[0]]
        far = np.abs(step - moved).max(initial=0.0) > RESOLVED * size.max(initial=0.0)
        turned = np.abs(v[:, _turning(model)]).max(initial=0.0) * (t[2] - t[0])
        short = fastest * (t[2] - t[0]) <= TURN and turned <= TURN * float(np.real(model.size))
        if far or not short:
            continue
        engines = _each(run, model, [k - 1, k, k + 1])
        a = np.array([_at(engine, run, state).a for engine, state in engines]) * to_v
        gained, size, error = _simpson(t, a)
        rest = np.abs(v[2] - v[0] - gained).max() - 10.0 * error.max()
        scale = max(float(size.max()), float(np.abs(v[2] - v[0]).max()))
        # stored velocities have rounding errors relative to their size
        rest -= ROUNDING * float(np.abs(v).max())
        missed.append(max(rest, 0.0) / scale if scale > 0.0 else 0.0)
        where.append(float(t[1]))
    if missed and float(np.quantile(missed, 0.25)) > ITERATED:
        worst = int(np.argmax(missed))
        yield (
            f"the accelerations of model '{model.name}' about {where[worst]:g} s differ by "
            f"{missed[worst]:.1%} from the changes of the stored velocities: it may have other "
            f"forces than {run.where}"
        )


def _straight(model: Model) -> tuple[Ints, Ints]:
    """Return the indices of [R p] among the positions, and of [R' p'] among the velocities."""
    q = [body.iq + np.r_[0:3, 7 : 7 + body.n] for body in model.bodies]
    v = [body.iv + np.r_[0:3, 6 : 6 + body.n] for body in model.bodies]
    return np.concatenate(q).astype(np.intp), np.concatenate(v).astype(np.intp)


def _fastest(model: Model) -> float:
    """Return the highest frequency of the modes of a body, rad/s."""
    K = [float(np.real(body.K).max()) for body in model.bodies if body.n]
    return float(np.sqrt(max(K, default=0.0)))


def _turning(model: Model) -> Ints:
    """Return the indices of the angular velocities."""
    return np.concatenate([body.iv + np.arange(3, 6) for body in model.bodies]).astype(np.intp)


def _simpson(t: Array, y: Array) -> tuple[Array, Array, Array]:
    """Return the integral of y (3, n) over three instants, that of its size, and the error."""
    h, k = t[1] - t[0], t[2] - t[1]
    # integral of the parabola through three points
    weights = (h + k) / 6.0 * np.array([2.0 - k / h, (h + k) ** 2 / (h * k), 2.0 - h / k])
    trapezoid = 0.5 * np.array([h, h + k, k])
    found = weights @ y
    return found, trapezoid @ np.abs(y), np.abs(found - trapezoid @ y)


def _triple(x: Array) -> str:
    return "({:g}, {:g}, {:g})".format(*np.real(x))
