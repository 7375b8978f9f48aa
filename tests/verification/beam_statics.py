"""Cantilevers of exact beams under a load "load" at their end, for the tests of static beams."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

import jousto as jo
from jousto.engine.native import displaced

Array = NDArray[np.float64]
ZERO = (0.0, 0.0, 0.0)


def section(*diagonal: float, mass: float = 1.0) -> jo.BeamSection:
    """A section of stiffness EA, GAy, GAz, GJ, EIy, EIz; its inertia is of no account at rest."""
    return jo.BeamSection(diagonal, mass, (2e-2, 1e-2, 1e-2))


def thin(EI: float = 1.0, length: float = 1.0, ratio: float = 1e8) -> jo.BeamSection:
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
) -> tuple[jo.State, list[float]]:
    """Newton's iteration on the residual of the engine while loads grow: state, last norms.

    Plain and quick: no predictor, no shorter steps, no look at stability (`jo.load_path` has all
    that). `way` is a number of equal steps of all inputs to 1, or their values (k, inputs).
    """
    engine = jo.Engine(model)
    nv, norms = model.nv, []
    if isinstance(way, int):
        way = np.arange(1, way + 1)[:, None] / way
    for values in np.asarray(way):
        engine.input[:] = values
        norms = []
        for _ in range(60):
            r = np.concatenate([engine.residual(), engine.constraints()[0]])
            norms.append(float(np.abs(r).max()))
            step = -np.linalg.solve(engine.newton_matrix(0.0, 1.0, 1.0), r)
            moves = step[:nv].reshape(-1, 2, 3)
            engine.q[:] = displaced(model, engine.q, step[:nv])
            engine.lam[:] += step[nv:]
            if np.abs(moves[:, 1]).max() + np.abs(moves[:, 0]).max() / model.size < tolerance:
                break
        else:
            raise AssertionError(f"no equilibrium at {values}: {norms}")
    inputs = dict(zip(model.inputs, map(float, engine.input), strict=True))
    return jo.State(np.array(engine.q), np.zeros(nv), np.array(engine.lam), inputs=inputs), norms


def tip(model: jo.Model, way: int | ArrayLike = 4) -> Array:
    """Where the last node is at rest, m."""
    state, _ = rest(model, way)
    return np.array(state.q[model.bodies[-1].iq :][:3])
