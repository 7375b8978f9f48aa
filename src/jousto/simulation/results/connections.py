"""Connections of a mechanism for pictures: which points its joints, springs and actuators join."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.described import described
from jousto.model.model import ForceModel, JointModel, Model
from jousto.model.native.header import named

GROUP = "connections"
KINDS = ("hinge", "slide", "fixed", "rod", "spring", "damper", "actuator", "bushing")


@described
@dataclass(frozen=True, eq=False)
class Side:
    """A point of a body.

    Attributes
    ----------
    body : int
        Its place among the bodies, -1 for ground.
    u0 : (3,) array
        Undeformed position in the body's frame, of ground in the world frame, m.
    modes : (3, n) array
        Translation of the point in each mode of the body.
    """

    body: int
    u0: Array
    modes: Array


@described
@dataclass(frozen=True, eq=False)
class Connection:
    """What joins two points, for pictures.

    Attributes
    ----------
    name : str
        Name of the joint or force.
    kind : str
        One of `KINDS`: "hinge" keeps two points together, "slide" lets one move on the other,
        "fixed" holds all; "rod" keeps a distance; springs, dampers, actuators and bushings push.
    a, b : Side
        The points.
    """

    name: str
    kind: str
    a: Side
    b: Side


def connections(model: Model) -> tuple[Connection, ...]:
    """Return what joins two points of a model; couplings, motors and friction have no place."""
    return tuple(
        Connection(name, kind, _side(model, a), _side(model, b))
        for name, kind, a, b in (*_joints(model), *_forces(model))
    )


def _side(model: Model, place: int) -> Side:
    marker = model.markers[place]
    modes = np.zeros((3, 0)) if marker.Phi is None else np.asarray(marker.Phi)
    return Side(marker.body, np.asarray(marker.u0), modes)


def _joints(model: Model) -> Iterator[tuple[str, str, int, int]]:
    for joint in model.joints:
        kind = _joint_kind(model, joint)
        if kind in ("rod", "actuator"):
            along = model.coordinates[joint.lines[0].coordinates[0]]
            yield joint.name, kind, along.a, along.b
        elif kind:
            yield joint.name, kind, joint.sides[0], joint.sides[1]


def _joint_kind(model: Model, joint: JointModel) -> str:
    """Return the kind of a joint, empty for what has no place of its own."""
    if joint.lock >= 0:  # friction that sticks
        return ""
    if joint.coincident:
        return "fixed" if len(joint.perpendicular) + len(joint.lines) >= 3 else "hinge"
    if joint.perpendicular:
        return "slide"
    first = joint.lines[0]
    kind = model.coordinates[first.coordinates[0]].kind
    if len(first.coordinates) > 1 or kind not in ("along", "distance"):
        return ""  # couplings, motors
    if first.signal >= 0:
        return "actuator"
    return "rod" if kind == "distance" else "slide"


def _forces(model: Model) -> Iterator[tuple[str, str, int, int]]:
    for force in model.forces:
        if force.kind == "bushing":
            yield force.name, "bushing", force.a, force.b
        if force.kind == "along":
            line = model.coordinates[force.coordinate]
            moving = max(model.markers[line.a].body, model.markers[line.b].body) >= 0
            if line.kind in ("along", "distance") and moving:
                yield force.name, _force_kind(force), line.a, line.b


def _force_kind(force: ForceModel) -> str:
    if force.active or force.reference >= 0:
        return "actuator"
    data = named("jo_along_data", force.data)
    if data.stiffness or force.spring >= 0:
        return "spring"
    return "damper" if data.damping or force.damper >= 0 else "actuator"


# -- in a results file ----------------------------------------------------------------------


def connection_arrays(found: tuple[Connection, ...]) -> dict[str, Any]:
    """Return the datasets of a results file; modes of all points stand behind one another."""
    sides = [side for one in found for side in (one.a, one.b)]
    modes = [side.modes.T for side in sides]
    return {
        "names": np.array([one.name.encode() for one in found]),
        "kinds": np.array([KINDS.index(one.kind) for one in found], dtype="<i8"),
        "bodies": np.array([side.body for side in sides], dtype="<i8").reshape(-1, 2),
        "points": np.array([side.u0 for side in sides]).reshape(-1, 2, 3),
        "modes": np.concatenate([*modes, np.zeros((0, 3))]),
        "ends": np.cumsum([len(some) for some in modes], dtype="<i8").reshape(-1, 2),
    }


def read_connections(group: Any) -> tuple[Connection, ...]:
    """Return the connections of their HDF5 group."""
    names, kinds, bodies, points, modes, ends = (
        group[name][()] for name in ("names", "kinds", "bodies", "points", "modes", "ends")
    )
    cuts = np.concatenate([[0], ends.ravel()])
    sides = [
        Side(int(body), u0, modes[first:last].T)
        for body, u0, first, last in zip(
            bodies.ravel(), points.reshape(-1, 3), cuts[:-1], cuts[1:], strict=True
        )
    ]
    return tuple(
        Connection(name.decode(), KINDS[kind], a, b)
        for name, kind, a, b in zip(names, kinds, sides[::2], sides[1::2], strict=True)
    )
