"""Scenes of modes: of a reduced part, or of a machine about a state."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.rotations import rotation_matrix
from jousto.model.compile import part_shape
from jousto.reduction.reduced import ReducedPart
from jousto.scene.bodies import is_surface, line_body, solid_body
from jousto.scene.bounding_box import bounding_box
from jousto.scene.frames import frame_body
from jousto.scene.machine import at_state, measures_of, model_scene, rows_of
from jousto.scene.motion import Rows
from jousto.scene.scene import Body, Mark, Mode, Scene, Side
from jousto.simulation.modes.linear import MechanismModes
from jousto.simulation.results.records import BodyShape

SHARE = 0.1  # largest displacement relative to the size
STEP = 1e-6  # step for the slope of resultants, relative to the amplitude


def part_modes(reduced: ReducedPart) -> Scene:
    """Return the scene of the modes of a part in the part frame."""
    shape, n = part_shape(reduced), reduced.n
    drawn = BodyShape(
        reduced.name,
        shape.kind,
        0,
        0,
        n,
        shape.nodes,
        shape.elements,
        shape.modes,
        float(np.real(reduced.invariants.mass)),
        shape.frame,
    )
    if is_surface(drawn.elements):
        body = solid_body(drawn, shape.stress)
    elif drawn.frame is not None:
        body = frame_body(drawn, drawn.frame, shape.stress)
    else:
        body = line_body(drawn)
    body = replace(body, mass=drawn.mass)
    still = np.zeros(7 + n)
    still[3] = 1.0
    box = bounding_box([body], (), still[None])
    assert body.shapes is not None
    modes = []
    for j, frequency in enumerate(np.asarray(reduced.frequencies, dtype=np.float64)):
        row = np.zeros(7 + n)
        row[7 + j] = 1.0
        largest = float(np.linalg.norm(body.shapes[j], axis=1).max(initial=0.0))
        modes.append(Mode(f"mode {j + 1}", float(frequency), None, row, None, _scale(box, largest)))
    marks = tuple(
        Mark(name, Side(0, n, shape.nodes[k], shape.modes[k]))
        for name in reduced.interfaces
        if len(reduced.node_sets[name]) == 1
        for k in reduced.node_sets[name]
    )
    return Scene(
        what="modes",
        name=reduced.name,
        title=f"{reduced.name}, {n} modes",
        still=still,
        bodies=(body,),
        box=box,
        markers=marks,
        modes=tuple(modes),
        measures=measures_of([body]),
    )


def machine_modes(found: MechanismModes) -> Scene:
    """Return the scene of the modes of a machine about its state.

    A mode with the increments x (translation) and theta (rotation), both in the frames of the
    bodies, changes the row by ``[A x, e * (0, theta) / 2, p]``, and the resultants of exact beams
    by their derivative along the mode.
    """
    run = at_state(found.model, found.state)
    rows, _ = rows_of(run)
    q, v = run.states()
    base = rows.from_states(q, v)[0]
    scene = model_scene(found.model)
    box = bounding_box(scene.bodies, scene.symbols, base[None])
    modes = []
    for j in range(len(found.eigenvalues)):
        change = _change(found, j, q[0])
        largest = max((_largest(body, change, q[0]) for body in scene.bodies), default=0.0)
        amplitude = _scale(box, largest)
        whole = np.concatenate([change, np.zeros(rows.width - len(change))])
        if rows.beams:
            whole[len(change) :] = _slopes(rows, q, v, change, STEP * amplitude)
        imag = whole.imag if np.any(whole.imag) else None
        note = "" if found.frequencies[j] else "does not oscillate"
        if found.grows[j]:
            note = "grows"
        if found.free[j]:
            note = "free motion"
        damping = float(found.damping[j])
        frequency = float(found.frequencies[j])
        modes.append(Mode(f"mode {j + 1}", frequency, damping, whole.real, imag, amplitude, note))
    return replace(
        scene,
        what="modes",
        title=f"{scene.name}, {len(modes)} modes",
        still=base,
        box=box,
        modes=tuple(modes),
    )


def _change(found: MechanismModes, j: int, q: Array) -> Any:
    """Return the complex change of the engine's positions (nq,) in a mode."""
    shape = np.asarray(found.increments[:, j])
    out = np.zeros(len(q), dtype=np.complex128)
    for body in found.model.bodies:
        e = q[body.iq + 3 : body.iq + 7]
        x = shape[body.iv : body.iv + 6 + body.n]
        out[body.iq : body.iq + 3] = rotation_matrix(e) @ x[:3]
        w = x[3:6]
        out[body.iq + 3] = -0.5 * (e[1:] @ w)
        out[body.iq + 4 : body.iq + 7] = 0.5 * (e[0] * w + np.cross(e[1:], w))
        out[body.iq + 7 : body.iq + 7 + body.n] = x[6:]
    return out


def _largest(body: Body, change: Any, q: Array) -> float:
    """Return the largest displacement of a body's vertices in a mode, m."""
    if body.rings is not None:
        moved = change[body.rings.places[:, None] + np.arange(3)]
    elif body.place < 0:
        return 0.0
    else:
        at = body.place
        e, de = q[at + 3 : at + 7], change[at + 3 : at + 7]
        A, h = rotation_matrix(e), 1e-6
        dA = sum(
            (rotation_matrix(e + h * part) - rotation_matrix(e - h * part)) / (2.0 * h) * unit
            for part, unit in ((de.real, 1.0), (de.imag, 1j))
        )
        p = q[at + 7 : at + 7 + body.modes]
        dp = change[at + 7 : at + 7 + body.modes]
        x, dx = body.positions, np.zeros_like(body.positions, dtype=np.complex128)
        if body.shapes is not None:
            x = x + np.einsum("j,jvi->vi", p, body.shapes)
            dx = np.einsum("j,jvi->vi", dp, body.shapes)
        moved = change[at : at + 3] + x @ np.asarray(dA).T + dx @ A.T
    return float(np.sqrt((np.abs(moved) ** 2).sum(axis=-1)).max(initial=0.0))


def _slopes(rows: Rows, q: Array, v: Array | None, change: Any, h: float) -> Any:
    """Return the complex derivative of beam resultants along a change of positions."""
    out: Any = 0.0
    still = None if v is None else np.zeros_like(v)
    for part, unit in ((change.real, 1.0), (change.imag, 1j)):
        if np.any(part):
            up, down = (
                rows.from_states(q + s * h * part, still)[0, len(part) :] for s in (1.0, -1.0)
            )
            out = out + unit * (up - down) / (2.0 * h)
    return out


def _scale(box: Array, largest: float) -> float:
    """Return the factor that scales the largest displacement to a tenth of the size."""
    size = float(np.ptp(box, axis=0).max())
    return SHARE * size / largest if largest > 0.0 else 1.0
