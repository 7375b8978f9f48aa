"""Loads on modal bodies outside of interfaces, for the load check of the certificate."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import count
from jousto.base.object_repr import described
from jousto.base.rotations import rotation_matrix
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.loads import Torque
from jousto.mechanism.forces.springs import ModalLoad
from jousto.mechanism.mechanism import Mechanism

if TYPE_CHECKING:
    from jousto.reduction.reduced import ReducedPart


@described
@dataclass(frozen=True, eq=False)
class ModeLoad:
    """Load outside of the interfaces, which the modes of a body have to represent.

    Attributes
    ----------
    where : str
        Name of the force, or of the body for its weight, for messages.
    body : str
        Name of the body.
    reduced : ReducedPart
        Modes of the body.
    place : str
        Description of the load and its position, for messages.
    pattern : array
        Forces on the nodes (nodes, 3), N; [node, 0 for a force or 3 for a moment] (2,); the
        acceleration of gravity in the axes of the body (3,), m/s2; or, for a point between nodes,
        node numbers and six loads per node for three unit loads, (k, 7, 3).
    weight : float
        Weight, N; 0 for other loads.
    """

    where: str
    body: str
    reduced: ReducedPart
    place: str
    pattern: Array
    weight: float = 0.0

    def _facts(self) -> str:
        return f"{self.place} on body {self.body!r}"


class ModeLoads(tuple[ModeLoad, ...]):
    """Loads of one model; copies for other processes are empty, since parts are large."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"<ModeLoads: {count(len(self), 'load')}>"

    def __reduce__(self) -> Any:
        return type(self), ()


def mode_loads(mechanism: Mechanism) -> ModeLoads:
    """Return the loads of a mechanism on modal bodies outside of interfaces."""
    flexible = [
        body
        for body in mechanism.bodies
        if isinstance(body, FlexibleBody) and body.reduced.source is not None
    ]
    if not flexible:
        return ModeLoads()
    found = [
        ModeLoad(f"{type(force).__name__} '{force.name}'", body.name, body.reduced, place, pattern)
        for force in mechanism.forces
        for body, place, pattern in _loads(force)
        if body.reduced.source is not None
    ]
    if mechanism.gravity.any():
        for body in flexible:
            if body.reduced.interfaces:
                g = rotation_matrix(body.orientation).T @ mechanism.gravity
                weight = body.reduced.invariants.mass * float(np.linalg.norm(g))
                where = f"body '{body.name}'"
                found.append(ModeLoad(where, body.name, body.reduced, "its weight", g, weight))
    return ModeLoads(found)


def _loads(force: object) -> Iterator[tuple[FlexibleBody, str, Array]]:
    """Yield body, position and pattern of the loads of a force outside of interfaces."""
    if isinstance(force, ModalLoad):
        yield force.body, f"pattern '{force.name}'", force.pattern
        return
    for name in ("marker", "a", "b"):
        marker = getattr(force, name, None)
        if not isinstance(marker, Marker) or not isinstance(marker.body, FlexibleBody):
            continue
        reduced, node = marker.body.reduced, marker.node
        first = 3 * isinstance(force, Torque)
        if marker.followed is not None:
            nodes, weights = marker.followed.nodes, marker.followed.weights
            number = np.broadcast_to(nodes[:, None, None], (len(nodes), 1, 3))
            unit = weights[first : first + 3].transpose(1, 2, 0)
            yield marker.body, f"a load at {marker.point}", np.concatenate([number, unit], axis=1)
        elif node is not None and not any(node in reduced.node_sets[i] for i in reduced.interfaces):
            yield marker.body, f"a load at node{node + 1}", np.array([node, first])
