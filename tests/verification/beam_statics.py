"""Cantilevers of exact beams under a load "load" at their end, for the tests of static beams."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import jousto as jo
from jousto.model.native.native import displaced

Array = NDArray[np.float64]
ZERO = (0.0, 0.0, 0.0)


def section(*diagonal: float, mass: float = 1.0) -> jo.mechanism.BeamSection:
    """A section of stiffness EA, GAy, GAz, GJ, EIy, EIz; its inertia is of no account at rest."""
    return jo.mechanism.BeamSection(diagonal, mass, (2e-2, 1e-2, 1e-2))


def thin(EI: float = 1.0, length: float = 1.0, ratio: float = 1e8) -> jo.mechanism.BeamSection:
    """A section that bends and twists with EI and neither stretches nor shears: 1 / `ratio`."""
    stiff = ratio * EI / length**2
    return section(stiff, stiff, stiff, EI, EI, EI)


def cantilever(
    beam: jo.BeamBody,
    force: ArrayLike = ZERO,
    torque: ArrayLike = ZERO,
    *more: Any,
    follow: bool = False,
) -> jo.Model:
    """The beam, held at its start, with loads at its end times the input "load"."""
    load = jo.Input("load")
    wall = jo.ground.at(beam.nodes[0], axes=beam.frames[0], name="wall")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", jo.JoustoWarning)
        return jo.compile(
            jo.Mechanism(
                beam,
                jo.Fixed("clamp", wall, beam["start"]),
                jo.Force("force", beam["end"], force, follow=follow, signal=load),
                jo.Torque("torque", beam["end"], torque, follow=follow, signal=load),
                jo.PositionSensor("tip", beam["end"]),
                jo.OrientationSensor("turn", beam["end"]),
                *more,
            )
        )


def straight(length: float, elements: int, sec: Any, **more: Any) -> jo.BeamBody:
    """A straight beam along x, its section's y axis along y."""
    return jo.BeamBody(
        "beam", [ZERO, (length, 0.0, 0.0)], sec, elements=elements, up=(0, 0, 1), **more
    )


def arc(radius: float, angle: float, elements: int, sec: Any, **more: Any) -> jo.BeamBody:
    """An arc that leaves the origin along x and turns towards y."""
    t = np.linspace(0.0, angle, elements + 1)
    points = radius * np.stack([np.sin(t), 1.0 - np.cos(t), 0.0 * t], axis=1)
    return jo.BeamBody("beam", points, sec, up=(0, 0, 1), **more)


def rest(
    model: jo.Model, way: int | ArrayLike = 4, *, tolerance: float = 1e-10
) -> tuple[jo.simulation.State, list[float]]:
    """Newton's iteration on the residual of the engine while loads grow: state, sizes of steps.

    Plain and quick, without predictor and without a look at stability, which
    `jo.simulation.load_path` has; a step that fails is halved. `way` is a number of equal steps of
    all inputs to 1, or their values (k, inputs).
    """
    engine = jo.model.Engine(model)
    if isinstance(way, int):
        way = np.arange(1, way + 1)[:, None] / way
    todo = [np.broadcast_to(x, engine.input.shape).astype(float) for x in np.asarray(way)]
    last, q, lam = np.array(engine.input), np.array(engine.q), np.array(engine.lam)
    norms: list[float] = []
    while todo:
        engine.input[:] = todo[0]
        norms = iterate(engine, tolerance)
        if norms:
            last, q, lam = todo.pop(0), np.array(engine.q), np.array(engine.lam)
            continue
        engine.q[:], engine.lam[:] = q, lam
        todo.insert(0, 0.5 * (last + todo[0]))
        if np.abs(todo[1] - todo[0]).max() < 1e-5:
            raise AssertionError(f"no equilibrium beyond {last}")
    inputs = dict(zip(model.inputs, map(float, engine.input), strict=True))
    return jo.simulation.State(q, np.zeros(model.nv), lam, inputs=inputs), norms


def iterate(engine: jo.model.Engine, tolerance: float = 1e-10) -> list[float]:
    """Newton's iteration at given loads: sizes of its steps, none if it fails."""
    model, norms = engine.model, []
    try:
        for _ in range(14):
            r = np.concatenate([engine.residual(), engine.constraints()[0]])
            step = -np.linalg.solve(engine.newton_matrix(0.0, 1.0, 1.0), r)
            moves = step[: model.nv].reshape(-1, 2, 3)
            engine.q[:] = displaced(model, engine.q, step[: model.nv])
            engine.lam[:] += step[model.nv :]
            norms.append(float(np.abs(moves[:, 1]).max() + np.abs(moves[:, 0]).max() / model.size))
            if norms[-1] < tolerance:
                return norms
    except jo.SimulationError:
        pass
    return []


def tip(model: jo.Model, way: int | ArrayLike = 4) -> Array:
    """Where the last node is at rest, m."""
    state, _ = rest(model, way)
    return np.array(state.q[model.bodies[-1].iq :][:3])
