"""Natural modes of a machine drawn over its equilibrium."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems, SimulationError
from jousto.model.model import Model
from jousto.model.native.native import Engine, displaced
from jousto.output.scenes.animate import overlay
from jousto.output.scenes.backdrop import new_picture
from jousto.output.scenes.stage import make_stage
from jousto.output.scenes.view import View
from jousto.output.style import MUTED, Picture, drawing
from jousto.simulation.modes.linear import (
    MechanismModes,
    body_frame_increments,
    nodal_displacements,
    rotations,
)
from jousto.simulation.results.memory import MemoryRecords
from jousto.simulation.results.row_layout import columns
from jousto.simulation.results.solution import Solution
from jousto.simulation.results.writer import Facts

AMPLITUDE = 0.12  # largest displacement in a picture, relative to the size of the machine


@drawing
def plot_modes(
    data: MechanismModes,
    mode: int = 0,
    *,
    scale: float = AMPLITUDE,
    view: View | str | None = None,
) -> Picture:
    """Draw a machine in a mode over a pale picture of its equilibrium.

    The points of a damped mode do not move in phase: the picture shows the instant of the largest
    displacement.

    Parameters
    ----------
    data : MechanismModes
        Result of `modes`.
    mode : int
        Index of the mode from 0; the title counts from 1.
    scale : float
        Largest displacement in the picture, by the size of the machine.
    view : View or str, optional
        Direction of view, as for `animate`.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown mode, a scale that is not positive, an unknown view or
        suffix, or an unwritable path.
    """
    problems, count = Problems(), len(data.frequencies)
    given: object = mode
    whole = isinstance(given, int | np.integer) and not isinstance(given, bool)
    if not whole or not 0 <= mode < count:
        known = f"0 to {count - 1}" if count else "none, nothing is free to move"
        problems.add("plot", f"no mode {mode!r}; they are {known}")
    problems.positive("plot", "scale", scale, "")
    problems.raise_if_any()
    run = in_mode(data, int(mode), scale)
    stage = make_stage(run, np.array([0.0, 1.0]), scale=1.0, view=view, trail=None)
    title = f"{data.model.name}, mode {mode + 1}: {data.describe_mode(mode, 5)}"
    figure, ax = new_picture(stage, title, "")
    overlay(ax, stage)
    figure.text(
        ax.get_position().x1,
        1 - 0.3 / figure.get_figheight(),
        "at rest and in the mode",
        color=MUTED,
        ha="right",
        va="center",
    )
    return figure


def in_mode(data: MechanismModes, mode: int, scale: float) -> Solution:
    """Return a run of two instants: equilibrium, and mode shape with closed joints."""
    model, q = data.model, data.state.q
    x = data.increments[:, mode]
    moved = [u.ravel() for u in nodal_displacements(model, q, x[:, None]).values()]
    # point-like bodies: use their rotations if there are no displacements
    seen = [u for u in moved if u.any()] or [x]
    farthest = max((u[np.abs(u).argmax()] for u in seen), key=abs)
    # complex phase at which that point has its largest displacement
    x = np.real(x * np.conj(farthest)) / abs(farthest)
    size = max(
        np.abs(u).max(initial=0.0) for u in nodal_displacements(model, q, x[:, None]).values()
    )
    size = size or _extent(model, q) * np.abs(x).max()
    engine = Engine(model)
    engine.q[:] = displaced(
        model, q, scale * _extent(model, q) / size * (body_frame_increments(model, q) @ x)
    )
    engine.time[0] = data.state.time
    far = np.array(engine.q)
    with suppress(SimulationError):  # joints that do not close are drawn with gaps
        engine.assemble()
        far = np.array(engine.q)
    pieces = columns(model)
    rows = np.zeros((2, pieces[-1].first + pieces[-1].count))
    rows[1, 0] = 1.0
    place = next(piece for piece in pieces if piece.place == "state/q")
    rows[:, place.first : place.first + place.count] = q, far
    facts: Facts = {"complete": True}
    about = {"gravity": np.asarray(model.gravity)}
    return Solution(MemoryRecords(model, rows, np.zeros((0, 4)), facts, about, ""))


def _extent(model: Model, q: Array) -> float:
    """Return the size of the machine from its nodes and markers, m."""
    points = [marker.u0[None] for marker in model.markers if marker.body < 0]
    frames = zip(model.bodies, model.shapes, rotations(model, q), strict=True)
    for k, (body, shape, A) in enumerate(frames):
        own = [marker.u0[None] for marker in model.markers if marker.body == k]
        points.append(q[body.iq : body.iq + 3] + np.concatenate([shape.nodes, *own]) @ A.T)
    cloud = np.concatenate(points)
    return float(np.linalg.norm(np.ptp(cloud, axis=0))) or 1.0
