"""Scenes of machines: of a run, or of a model at a state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.model.beam_record import BeamShape
from jousto.model.model import Model
from jousto.recovery.beams.strains import elements
from jousto.scene.beam_tubes import Resultants, beam_body
from jousto.scene.bodies import is_surface, line_body, rigid_body, solid_body
from jousto.scene.bounding_box import bounding_box, size_of
from jousto.scene.frames import frame_body
from jousto.scene.motion import Rows, run_motion
from jousto.scene.scene import MEASURES, Body, Happened, Scene, Sensor, Side, Symbol
from jousto.scene.symbols import (
    attached_points,
    contact_bodies,
    drawn_symbols,
    ground_symbols,
)
from jousto.simulation.results.dataframes import component_units
from jousto.simulation.results.memory import MemoryRecords
from jousto.simulation.results.records import BodyShape
from jousto.simulation.results.row_layout import columns
from jousto.simulation.results.solution import Solution
from jousto.simulation.results.writer import EVENT_COLUMNS
from jousto.simulation.state import State

SAMPLES = 48  # number of instants of a run from which its extent is computed
SAMPLED = 64 << 20  # largest amount of a file that is read for the extent, bytes
CHECKED = 1024  # rows read from a file to check one of them for finite numbers
ARROWS = {"N": "force", "N m": "moment", "m/s": "velocity", "m/s^2": "acceleration"}
ARROWS |= {"m/s2": "acceleration"}
"""What a vector in a unit is drawn as."""


def run_scene(run: Solution) -> Scene:
    """Return the scene of a run; its rows are read on demand.

    Raises
    ------
    InputError
        If the run contains no stored instant yet.
    """
    if not run.nt:
        raise InputError(Problem(run.where, "no instant is stored yet"))
    rows, firsts = rows_of(run)
    motion = run_motion(run, rows)
    count = max(4, min(SAMPLES, SAMPLED // (CHECKED * 8 * max(rows.width, 1))))
    chosen = np.unique(np.linspace(0, run.nt - 1, count).astype(int))
    sampled = np.concatenate([motion.rows(slice(k, k + 1)) for k in chosen])
    scene = _machine(run, firsts, sampled)
    events = tuple(Happened(x.time, x.name) for x in run.events)
    touches = max((one.force for one in run.contacts), default=None)
    return replace(scene, what="run", motion=motion, events=events, run=run, touches=touches)


def model_scene(model: Model) -> Scene:
    """Return the scene of a model at its start."""
    run = at_state(model)
    rows, firsts = rows_of(run)
    return _machine(run, firsts, rows.from_states(*run.states()))


def at_state(model: Model, state: State | None = None) -> Solution:
    """Return results of a model with one instant: its start or a given state."""
    names = {column.place: column for column in columns(model)}
    last = max(names.values(), key=lambda column: column.first)
    row = np.zeros((1, last.first + last.count))
    for place, values in (
        ("state/q", model.q0 if state is None else state.q),
        ("state/v", model.v0 if state is None else state.v),
    ):
        first = names[place].first
        row[0, first : first + names[place].count] = values
    facts = {"complete": 1, "ended": "at its start", "wall_time": 0.0}
    about = {"solver": "", "gravity": model.gravity}
    return Solution(MemoryRecords(model, row, np.zeros((0, len(EVENT_COLUMNS))), facts, about, ""))


def rows_of(run: Solution) -> tuple[Rows, list[int]]:
    """Return the map from states to rows, and the first resultant column of each beam."""
    shapes, stressed = run.bodies, run.stressed
    width = max((shape.q_offset + 7 + shape.n for shape in shapes), default=0)
    known, firsts = [], []
    for beam in run.beams:
        if beam.name not in stressed:
            firsts.append(-1)
            continue
        iq = np.array([shapes[k].q_offset for k in beam.bodies], dtype=np.intp)
        iv = np.array([shapes[k].v_offset for k in beam.bodies], dtype=np.intp)
        known.append(Resultants(elements(beam), iq, iv, width))
        firsts.append(width)
        width += known[-1].width
    return Rows(width, known), firsts


def _machine(run: Solution, firsts: Sequence[int], rows: Array) -> Scene:
    """Return the scene of a machine without motion; `rows` are sample instants."""
    shapes, beams = run.bodies, run.beams
    if not shapes:
        raise InputError(Problem(run.where, "there are no bodies to show"))
    made, marks = drawn_symbols(run.symbols, shapes)
    symbols = (*made, *ground_symbols(made))
    bodies = _bodies(run, shapes, beams, firsts, symbols, rows[0])
    gravity = run.attributes.get("gravity")
    return Scene(
        what="model",
        name=run.name,
        title=run.name,
        still=rows[0],
        bodies=(*bodies, *contact_bodies(run.symbols, shapes)),
        box=bounding_box(bodies, symbols, rows),
        symbols=symbols,
        markers=marks,
        sensors=tuple(sensor_of(run, name, made) for name in run.sensors),
        up=upwards(gravity),
        gravity=None if gravity is None else np.asarray(gravity, dtype=np.float64),
        measures=measures_of(bodies),
    )


def _bodies(
    run: Solution,
    shapes: Sequence[BodyShape],
    beams: Sequence[BeamShape],
    firsts: Sequence[int],
    symbols: Sequence[Symbol],
    still: Array,
) -> tuple[Body, ...]:
    """Return all scene bodies; nodes of beams are part of their beams."""
    nodes = {int(k) for beam in beams for k in beam.bodies}
    held = attached_points(symbols)
    size = size_of(shapes, symbols, still)
    none = np.zeros((0, 3))
    found = []
    for k, shape in enumerate(shapes):
        if k in nodes:
            continue
        modes = run.stress_modes(shape.name) if shape.n else None
        if is_surface(shape.elements):
            body = solid_body(shape, modes)
        elif shape.frame is not None:
            body = frame_body(shape, shape.frame, modes)
        elif shape.n:
            body = line_body(shape)
        else:
            body = rigid_body(shape, held.get(shape.q_offset, none), size)
        found.append(replace(body, mass=shape.mass))
    for beam, first in zip(beams, firsts, strict=True):
        places = np.array([shapes[k].q_offset for k in beam.bodies], dtype=np.intp)
        masses = [shapes[k].mass for k in beam.bodies]
        known = [mass for mass in masses if mass is not None]
        mass = float(sum(known)) if len(known) == len(masses) else None
        found.append(replace(beam_body(beam, places, first), mass=mass))
    return tuple(found)


def sensor_of(run: Solution, name: str, symbols: Sequence[Symbol]) -> Sensor:
    """Return a sensor of a run with the position of its symbol."""
    about = run.about(name)
    units = component_units(about)
    side: Side | None = next((one.sides[-1] for one in symbols if one.sensor == name), None)
    arrow = None
    if side is not None and about["resolved_in"] == "world" and len(units) in (3, 6):
        arrow = ARROWS.get(units[0])
    return Sensor(
        name=name,
        unit=about["unit"],
        units=units,
        components=tuple(about["components"]),
        description=about["description"],
        side=side,
        arrow=arrow,
        columns=(0, 1, 2) if arrow else None,
        floors=tuple(run.floors(name).tolist()),
    )


def upwards(gravity: Any) -> Array:
    """Return the direction opposite to gravity; z without gravity."""
    g = np.zeros(3) if gravity is None else np.asarray(gravity, dtype=np.float64)
    size = float(np.linalg.norm(g))
    return -g / size if size > 0.0 else np.array([0.0, 0.0, 1.0])


def measures_of(bodies: Sequence[Body]) -> tuple[str, ...]:
    """Return the quantities that can colour the bodies."""
    found: list[str] = []
    if any(b.stress is not None or (b.rings and b.rings.forces >= 0) for b in bodies):
        found += MEASURES
    if any(body.modes for body in bodies):
        found.append("displacement")
    if any(body.damage is not None for body in bodies):
        found.append("damage")  # no "life", since it spans decades, which the colours cannot show
    return tuple(found)
