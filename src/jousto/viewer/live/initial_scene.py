"""Initial scene of a running machine: bodies, inputs and damage meters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from jousto.model.model import Model
from jousto.scene.machine import at_state, run_scene
from jousto.scene.scene import Scene
from jousto.simulation.live.ranges import InputRange
from jousto.simulation.results.solution import Solution
from jousto.simulation.state import State

AROUND = 0.15  # margin around the initial box, relative, for the coming motion


def scene_at(model: Model, state: State | None, title: str) -> tuple[Solution, Scene]:
    """Return a machine at its start as one-instant results and as a scene."""
    run = at_state(model, state)
    scene = run_scene(run)
    low, high = np.asarray(scene.box)
    edge = AROUND * float(np.linalg.norm(high - low))
    box = np.array([low - edge, high + edge])
    touches = 0.0 if model.touches else None
    seen: Scene = replace(
        scene, what="live", title=title, box=box, motion=None, run=None, touches=touches
    )
    return run, seen


def inputs_header(
    inputs: Iterable[InputRange], values: Mapping[str, float]
) -> list[dict[str, Any]]:
    """Return the header entries of the inputs, with changed values."""
    return [
        {
            "name": x.name,
            "unit": x.unit,
            "low": x.low,
            "high": x.high,
            "value": values.get(x.name, x.value),
        }
        for x in inputs
    ]


def damages(model: Model) -> dict[str, int]:
    """Return damage meters by their names on the page, with their sensor columns."""
    return {
        f"{sensor.name} {label}": sensor.offset + 2 * k
        for sensor in model.sensors
        if sensor.kind == "damage"
        for k, label in enumerate(sensor.components[::2])
    }
