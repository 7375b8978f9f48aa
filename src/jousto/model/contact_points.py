"""Points at which bodies touch in the state of an engine, and the pairs that may touch."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.model.model import Model
from jousto.model.native.header import named
from jousto.model.native.native import Engine

PHASES = ("apart", "sticks", "slips", "slips", "apart", "no friction")
"""Phases of a contact as the engine numbers them; the second "slips" does within the present step,
the second "apart" after an impulse."""
KINDS = ("vertex", "edge", "face", "rim", "surface")
"""Parts of shapes (``jo_part_kind``)."""
ROUND = 9
"""First number of a pair of parts with a round shape (``JO_ROUND_PAIR``)."""
SIDES = 3
"""Sides of a triangle (``JO_MESH_SIDES``)."""
BASE = 1024
"""Vertices or faces of a polytope that a code can name (``JO_MAX_VERTICES``)."""


@described
@dataclass(frozen=True, eq=False)
class ContactPoint:
    """Point at which two bodies touch.

    Attributes
    ----------
    contact : str
        Name of the contact, or of the set.
    a, b : str
        Shapes of a set, or bodies: that is touched, and the other one.
    tip : int
        Number of the tip, for shapes with several tips, or of the point of two polytopes.
    features : str
        Features of two polytopes that touch: ``"face 0, vertex 3"``; empty for other shapes.
    phase : str
        "sticks", "slips", "no friction" of a contact without any, or "apart".
    gap : float
        Distance, m; negative in contact.
    point, normal : (3,) arrays
        Contact point, m, and outward normal of a, world frame.
    force : float
        Normal force, N.
    friction : (3,) array
        Friction force on b, N, world frame.
    pressure : float
        Largest pressure, Pa, where the law is that of Hertz; else NaN.
    approach : float
        Speed of approach at the touch, m/s.
    age : float
        Time since the touch, s; NaN for a point that does not touch.
    stored : float
        Energy stored in the normal force and in the bristle, J.
    """

    contact: str
    a: str
    b: str
    tip: int
    features: str
    phase: str
    gap: float
    point: Array
    normal: Array
    force: float
    friction: Array
    pressure: float
    approach: float
    age: float
    stored: float


def contact_sources(model: Model) -> dict[str, Any]:
    """Return what the numbers of forces and shapes in contacts mean, as JSON.

    "contacts" has ``[force, name, tip, body a, body b, thickness, restitution, slowest]`` of each
    contact of two shapes: size of the smaller shape, m, the restitution that is asked for, 0 if not
    known, and the speed of approach above which touches have it, m/s; None for impulses.
    "sets" has ``[first slot, last slot, name, shapes, bodies, sizes, surfaces, restitutions,
    slowest]`` of each set: names, bodies, sizes (m) and surfaces of its shapes, and restitution and
    speed between surfaces.
    """
    contacts: list[Any] = []
    sets: list[Any] = []
    tips: dict[str, int] = {}
    for i, force in enumerate(model.forces):
        if force.slots:
            at = [_body_of(model, marker) for marker in force.touches]
            about = [force.shapes, at, force.sizes, force.surfaces, force.restitutions]
            about.append([[_finite(x) for x in row] for row in force.slowest_each])
            sets.append([i + 1, i + force.slots, force.name, *about])
        elif force.points and not (sets and i <= sets[-1][1]):
            tip = tips[force.name] = tips.get(force.name, -1) + 1
            bodies = (_body_of(model, force.a), _body_of(model, force.b))
            rebound = (force.thickness, force.restitution, _finite(force.slowest))
            contacts.append([i, force.name, tip, *bodies, *rebound])
    return {"contacts": contacts, "sets": sets}


def _finite(number: float) -> float | None:
    """Return a number, None if it is infinite, which JSON does not have."""
    return number if isfinite(number) else None


def _body_of(model: Model, marker: int) -> str:
    if marker < 0:  # a track through several markers
        return "track"
    place = model.markers[marker].body
    return "ground" if place < 0 else model.bodies[place].name


def points_of(engine: Engine, *, near: bool = False) -> list[ContactPoint]:
    """Return the points at which bodies touch in the state of an engine."""
    model, time = engine.model, float(engine.time[0].real)
    if any(friction.contact >= 0 for friction in model.frictions):
        engine.accelerations()  # forces of rows that hold points
    rows = named("jo_touch", engine.contacts())
    sources = contact_sources(model)
    single = {force: (name, tip, a, b) for force, name, tip, a, b, *_ in sources["contacts"]}
    owner = {k: one for one in sources["sets"] for k in range(one[0], one[1] + 1)}
    found = []
    for i in range(len(rows.force)):
        if not near and not rows.phase[i]:
            continue
        force = int(rows.force[i])
        if force in single:
            name, tip, a, b = single[force]
        else:
            _, _, name, shapes, *_ = owner[force]
            a, b = (shapes[int(k)] for k in rows.shapes[i])
            tip = 0
        if rows.feature[i]:
            tip = int(rows.number[i])
        touches = rows.phase[i] > 0
        found.append(
            ContactPoint(
                contact=name,
                a=a,
                b=b,
                tip=tip,
                features=features_of(rows.feature[i]),
                phase=PHASES[int(rows.phase[i])],
                gap=float(rows.gap[i]),
                point=rows.place[i].copy(),
                normal=rows.normal[i].copy(),
                force=float(rows.N[i]),
                friction=rows.friction[i].copy(),
                pressure=_pressure(model, rows, i),
                approach=float(rows.speed[i]),
                age=time - float(rows.since[i]) if touches else np.nan,
                stored=float(rows.stored[i].sum()),
            )
        )
    return found


def features_of(code: float) -> str:
    """Return the features that a code of two polytopes names; empty for 0."""
    if not code:
        return ""
    if code < 0.0:  # of a surface of triangles, see jo_mesh_code
        triangle, vertex = divmod((int(-code) - 1) // SIDES, BASE)
        return f"triangle {triangle}, vertex {vertex}"
    number, parts = int(code) - 1, list[int]()
    for _ in range(4):
        number, part = divmod(number, BASE)
        parts.insert(0, part)
    a, b = divmod(number, 3) if number < ROUND else divmod(number - ROUND, len(KINDS))
    return f"{_part(KINDS[a], *parts[:2])}, {_part(KINDS[b], *parts[2:])}"


def _part(kind: str, first: int, second: int) -> str:
    """Return the name of a part of a shape; the side of a cylinder is an edge with equal ends."""
    if kind == "edge":
        return f"edge {first}-{second}" if first != second else "side"
    return kind if kind == "surface" else f"{kind} {first}"


def _pressure(model: Model, rows: Any, i: int) -> float:
    """Return the largest pressure at a point by Hertz, Pa; NaN for other laws."""
    force = model.forces[int(rows.force[i])]
    if force.pressure:
        return float(force.pressure * rows.N[i] ** (1.0 / 3.0))
    hertz = rows.pressure[i] > 0.0 or not rows.N[i]
    return float(rows.pressure[i]) if force.points and hertz else float("nan")
