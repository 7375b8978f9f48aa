"""Small runs of exact beams for the tests of recovery and pictures."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import jousto as jo
from jousto.model.model import BeamModel

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)


def compiled(*items: Any) -> jo.Model:
    model = jo.compile(jo.Mechanism(*items))
    if not model.beams:
        pairs = [(beam, k) for beam in model.beam_shapes for k in range(beam.n)]
        beams = tuple(
            BeamModel(
                f"{b.name}.e{k + 1}", b.name, int(b.bodies[k]), int(b.bodies[k + 1]), b.data[k]
            )
            for b, k in pairs
        )
        model = replace(model, beams=beams)
    return model


def rest(model: jo.Model, steps: int = 2, **options: Any) -> jo.Solution:
    """Return a very short run that begins at rest in equilibrium."""
    state = jo.equilibrium(model, **options)
    return jo.simulate(
        model, t_end=1e-9 * steps, solver=jo.GeneralizedAlpha(step=1e-9), state=state
    )


def cantilever(
    force: Any, elements: int = 8, section: Any = None, plain: bool = False, **options: Any
) -> jo.Solution:
    """Return a 1 m cantilever along x at rest under a dead force at its tip; plain: no material."""
    material = () if plain else (STEEL,)
    section = section or jo.Rectangle(0.02, 0.04)
    points = [(0, 0, 0), (1, 0, 0)]
    beam = jo.BeamBody("beam", points, section, *material, elements=elements, **options)
    return rest(
        compiled(
            beam,
            jo.Fixed("clamp", jo.ground["origin"], beam["start"]),
            jo.Force("pull", beam["end"], np.asarray(force, dtype=float)),
        )
    )
