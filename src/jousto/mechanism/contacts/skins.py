"""Skins of flexible bodies: the nodes of their surface, and the area that each stands for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

from jousto.base.arrays import Array, Ints
from jousto.base.errors import Problems, suggest
from jousto.base.fields import Reference
from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.marker import NO_TURN, Marker

SkinBody: TypeAlias = FlexibleBody | BeamBody

LEAST = 1e-9
"""Weight of a node over the largest one up to which it counts as 0: corners of curved faces."""
MID_SIDES = 8
"""Nodes of a quadrangle with mid-side nodes, whose consistent weights are negative at corners."""


class SkinBodyField(Reference[SkinBody, SkinBody]):
    """Field of a flexible body or an exact beam; a model file contains its name."""

    section = "bodies"
    word = "body"
    noun = "FlexibleBody or BeamBody"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the body, or report a value of another type."""
        if not isinstance(value, FlexibleBody | BeamBody):
            problems.add(
                where, f"{self.label} is {value!r}, must be a FlexibleBody or a BeamBody", self.key
            )
        return value


def check_skin(problems: Problems, where: str, body: SkinBody, nodes: Sequence[str]) -> None:
    """Report names of node sets that do not exist, and skins without area."""
    if isinstance(body, BeamBody):
        if nodes:
            problems.add(where, "an exact beam has no node sets; leave out nodes", "nodes")
        return
    sets = body.reduced.node_sets
    for name in nodes:
        if name not in sets:
            problems.add(where, f"no node set {name!r}{suggest(name, sets)}", "nodes")
    if problems.found:
        return
    if not np.any(node_weights(body, nodes) > 0.0):
        what = "no face has all its nodes in nodes" if nodes else "the part has no faces or beams"
        problems.add(
            where,
            f"body {body.name!r} has no skin there: {what}; name a node set that contains faces",
            "nodes",
        )


def skin_markers(body: SkinBody, nodes: Sequence[str]) -> list[tuple[Marker, float]]:
    """Return the markers of the nodes of a skin with their areas, m2; of a beam lengths, m."""
    if isinstance(body, BeamBody):
        return [
            (body.node(i), float(weight))
            for i, weight in enumerate(
                _lengths(np.diff(np.real(body.s)), _chain(body.n), body.n + 1)
            )
        ]
    weights = node_weights(body, nodes)
    (at,) = np.nonzero(weights > LEAST * weights.max())
    x = np.asarray(body.reduced.nodes)
    return [
        (Marker(body, f"node{k + 1}", x[k], k, NO_TURN), float(weights[k])) for k in at.tolist()
    ]


def node_weights(body: FlexibleBody, nodes: Sequence[str]) -> Array:
    """Return the area of the skin for which each node stands (nn,), m2; of beams the length, m.

    These are the shares of the nodes in the load of a constant pressure on the faces all of whose
    nodes are in the node sets `nodes`; on all faces if there are none. Of quadratic faces the
    mid-side nodes carry.
    """
    reduced = body.reduced
    x = np.real(np.asarray(reduced.nodes))
    inside = np.ones(len(x), dtype=np.bool_)
    if nodes:
        inside[:] = False
        for name in nodes:
            inside[list(reduced.node_sets[name])] = True
    total = np.zeros(len(x))
    for group in reduced.faces:
        faces = group[inside[group].all(axis=1)]
        if len(faces):
            np.add.at(total, faces, _shares(x, faces))
    if len(reduced.faces):
        return total
    elements = np.asarray(reduced.elements)
    elements = elements[inside[elements].all(axis=1)][:, :2]
    lengths = np.linalg.norm(x[elements[:, 1]] - x[elements[:, 0]], axis=1)
    return _lengths(lengths, elements, len(x))


def _shares(x: Array, faces: Ints) -> Array:
    """Return the shares (nf, k) of the nodes in the areas of faces of one kind, m2."""
    from jousto.mesh.area import face_points

    N, area, _ = face_points(x, faces)
    dA = np.linalg.norm(area, axis=2)
    if faces.shape[1] == MID_SIDES:
        quarter = 0.25 * dA.sum(axis=1)
        return np.stack([0.0 * quarter] * 4 + [quarter] * 4, axis=1)
    return np.asarray(dA @ N)


def _chain(n: int) -> Ints:
    """Return the end nodes (n, 2) of the elements of a beam."""
    return np.stack([np.arange(n), np.arange(1, n + 1)], axis=1)


def _lengths(lengths: Array, elements: Ints, count: int) -> Array:
    """Return half the lengths of the elements at each node (count,), m."""
    return np.asarray(np.bincount(elements.ravel(), np.repeat(0.5 * lengths, 2), minlength=count))
