"""Rigid equivalent of a flexible body: its mass, inertia, named nodes and outline."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.mechanism.bodies.base import Posed
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody
from jousto.mechanism.bodies.inertia import rigid_inertia


def rigid_body(body: FlexibleBody) -> RigidBody:
    """Return the rigid body with the mass, inertia and named nodes of a flexible one."""
    reduced = body.reduced
    center, inertia = rigid_inertia(reduced.invariants)
    return RigidBody(
        **{key: getattr(body, key) for key in Posed.fields},
        mass=reduced.invariants.mass,
        inertia=inertia,
        center=center,
        markers=reduced.named_nodes,
        outline=drawn_outline(reduced.nodes, reduced.elements),
    )


def drawn_outline(nodes: Any, elements: Any) -> Any:
    """Return the triangles (nt, 3, 3) of a solid; for beams a polyline along all elements."""
    if np.ndim(elements) == 2 and np.shape(elements)[1] == 3 and len(elements):
        return np.asarray(nodes)[np.asarray(elements)]
    return round_trip(nodes, elements)


def round_trip(nodes: Any, elements: Any) -> Any:
    """Return a closed polyline (k, 3) that passes along all elements; None without elements."""
    if np.ndim(elements) != 2 or not len(elements):
        return None
    neighbours: dict[int, list[int]] = {}
    for a, b in np.asarray(elements)[:, [0, -1]].tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    way, drawn, here = [int(elements[0][0])], set(), [int(elements[0][0])]
    while here:
        a = here[-1]
        ahead = [b for b in neighbours[a] if frozenset((a, b)) not in drawn]
        if ahead:
            drawn.add(frozenset((a, ahead[0])))
            here.append(ahead[0])
        else:
            here.pop()
        if here:
            way.append(here[-1])
    return np.asarray(nodes)[way]
