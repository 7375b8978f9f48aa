"""Page with a running machine: the engine as WebAssembly in one file, without server."""

from __future__ import annotations

import gzip
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.files import written
from jousto.export.ports import Named
from jousto.export.program import Program, program
from jousto.export.web import web_module
from jousto.model.model import Model
from jousto.scene.machine import measures_of
from jousto.scene.scene import Body, Scene
from jousto.simulation.live.machine import INTERVAL
from jousto.simulation.live.ranges import InputRange, input_ranges
from jousto.simulation.solvers.base import Solver
from jousto.simulation.state import State
from jousto.viewer.bundle import standalone_page
from jousto.viewer.container import pack
from jousto.viewer.live.initial_scene import damages, inputs_header, scene_at
from jousto.viewer.packing import scene_header


def write_running(
    model: Model,
    path: str | Path,
    *,
    solver: Solver | None = None,
    state: State | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    named: Sequence[Named] = (),
) -> Path:
    """Write a compiled model as a self-contained page in which it runs.

    Parameters
    ----------
    model : Model
        Model from `compile`.
    path : path
        Ends with .html.
    solver : Solver, optional
        Method of fixed step; None: the choice of `simulate` for 10 s.
    state : State, optional
        Initial state; None: that of the model.
    ranges : dict of str to (float, float), optional
        Ranges of inputs in SI; by default they follow from the driven quantity.
    named : sequence of Named
        Named constants that become parameters, from `named_constants`.

    Raises
    ------
    InputError
        If the model cannot be exported, a range is empty, the page was not built, the package
        ziglang is missing, or the file cannot be written.
    """
    out = Path(path)
    inputs = input_ranges(model, ranges)
    made = program(model, solver, state=state, name="machine", named=named)
    title = model.name or "machine"
    _, scene = scene_at(model, state, title)
    data = gzip.compress(pack(contents(made, scene, inputs)), 9, mtime=0)
    html = standalone_page(title, data, runs=True).encode()
    with written(out) as beside:
        beside.write_bytes(html)
    return out


def contents(made: Program, scene: Scene, inputs: tuple[InputRange, ...]) -> dict[str, Any]:
    """Return the data of the page: initial scene, WebAssembly module, ports."""
    model = made.model
    header = scene_header(_without_resultants(scene, model.nq), None, half=False)
    header["inputs"] = inputs_header(inputs, {})
    bounds = {k: one.bounds for k, one in enumerate(made.named) if one.bounds is not None}
    header["parameters"] = [
        {
            "name": x.name,
            "value": x.start,
            "unit": x.unit,
            "low": bounds[k][0] if k in bounds else None,
            "high": bounds[k][1] if k in bounds else None,
        }
        for k, x in enumerate(made.ports.parameters)
    ]
    step = made.solver.step
    return {
        "kind": "machine",
        "scene": header,
        "code": np.frombuffer(web_module(made), dtype=np.uint8),
        "nq": model.nq,
        "nout": model.nout,
        "step": step,
        "every": max(1, round(INTERVAL / step)),
        "events": [event.name for event in model.events],
        "damages": [{"name": name, "place": at} for name, at in damages(model).items()],
    }


def _without_resultants(scene: Scene, nq: int) -> Scene:
    """Return a scene with rows of positions only: the page does not compute beam resultants."""
    bodies: tuple[Body, ...] = tuple(
        body if body.rings is None else replace(body, rings=replace(body.rings, forces=-1))
        for body in scene.bodies
    )
    still, measures = scene.still[:nq], measures_of(bodies)
    return replace(scene, bodies=bodies, still=still, measures=measures, touches=None)
