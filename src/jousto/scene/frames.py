"""Modal frames of beam elements: swept sections with mode shapes and stress."""

from __future__ import annotations

import math
import re

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array, Index
from jousto.model.frame_record import FrameShape
from jousto.parts.frames.element import BeamElements, end_displacements, shape_functions
from jousto.reduction.fields.stress import StressModes
from jousto.scene.scene import Body, Sections
from jousto.scene.sections import fan, outline_weights, outlines, walls
from jousto.scene.surfaces import feature_edges
from jousto.simulation.results.records import BodyShape

PIECES = 24  # smallest number of pieces of all elements together, for smooth bending
MOST = 6  # largest number of pieces of an element
SITE = re.compile(r"e(\d+)\.([ab])\.(.*)")


def frame_body(shape: BodyShape, frame: FrameShape, modes: StressModes | None) -> Body:
    """Return a modal frame as a solid of its swept sections.

    Translation u and rotation theta of a section follow from the nodes by the shape functions of
    its element; a vertex with arm s moves in mode j by ``phi_j = u_j + theta_j x s``. Stress is
    interpolated linearly between the section points at both ends, like the resultants of an element
    loaded at its ends.

    Parameters
    ----------
    shape : BodyShape
    frame : FrameShape
        Beam elements of the body.
    modes : StressModes or None
        Stress of each mode at the points of the sections.
    """
    ne, pairs = len(frame.length), np.asarray(shape.elements, dtype=np.intp)
    edges = outlines(frame.edges, float(frame.length.sum()))
    k = edges.shape[1]
    pieces = int(np.clip(-(-PIECES // ne), 1, MOST))
    xi = np.linspace(0.0, 1.0, pieces + 1)
    yz = edges[frame.which]  # (ne, k, 2)
    arms = np.einsum("eij,ekj->eki", frame.axes[:, :, 1:], yz)
    centre = (
        frame.origin[:, None] + xi[:, None] * (frame.length[:, None] * frame.axes[:, :, 0])[:, None]
    )
    positions = (centre[:, :, None] + arms[:, None]).reshape(-1, 3)
    stress, known = (None, None) if modes is None else _stress(modes, frame, edges, xi)
    triangles = _skin(pairs, frame, pieces, k)
    ends = np.where(xi[None, :, None] < 0.5, pairs[:, :1, None], pairs[:, 1:, None])
    return Body(
        name=shape.name,
        kind="frame",
        place=shape.q_offset,
        modes=shape.n,
        positions=positions,
        triangles=triangles,
        edges=feature_edges(positions, triangles),
        shapes=_shapes(shape, frame, pairs, arms, xi),
        stress=stress,
        known=known,
        nodes=np.broadcast_to(ends, (ne, pieces + 1, k)).ravel() + 1,
        sections=Sections(
            element=np.repeat(np.arange(ne), pieces + 1),
            share=np.tile(xi, ne),
            vertex_ring=np.repeat(np.arange(ne * (pieces + 1)), k),
            yz=np.repeat(yz, pieces + 1, axis=0).reshape(-1, 2),
        ),
        about=f"{shape.n} modes, {ne} beam elements, {len(frame.edges)} sections",
    )


def beam_elements(frame: FrameShape) -> BeamElements:
    """Return the elements in the form of the shape functions."""
    none = np.zeros(len(frame.length))
    return BeamElements(
        frame.origin,
        frame.axes,
        frame.length,
        frame.offsets,
        none,
        none,
        none,
        none,
        frame.phi,
    )


def _shapes(shape: BodyShape, frame: FrameShape, pairs: Index, arms: Array, xi: Array) -> Array:
    """Return the displacement (n, nv, 3) of all vertices in each mode, ring by ring."""
    beams = beam_elements(frame)
    nodal = np.concatenate([np.asarray(shape.modes), frame.rotations], axis=1)  # (nn, 6, n)
    ends = end_displacements(beams) @ nodal[pairs].reshape(len(pairs), 12, shape.n)
    out = np.empty((shape.n, len(pairs), len(xi), arms.shape[1], 3))
    for i, x in enumerate(xi):
        local = shape_functions(beams, float(x)) @ ends  # (ne, 6, n)
        u = np.einsum("eij,ejm->mei", frame.axes, local[:, :3])
        theta = np.einsum("eij,ejm->mei", frame.axes, local[:, 3:])
        out[:, :, i] = u[:, :, None] + np.cross(theta[:, :, None], arms[None])
    return out.reshape(shape.n, math.prod(out.shape[1:4]), 3)


def _stress(
    modes: StressModes, frame: FrameShape, edges: Array, xi: Array
) -> tuple[Array | None, NDArray[np.bool_] | None]:
    """Return the stress (n, nv, 6) of all vertices in each mode, and a mask of known ones."""
    ne, k, n = len(frame.length), edges.shape[1], modes.modes.shape[2]
    ends = np.zeros((ne, 2, k, 6, n))
    known = np.zeros((ne, 2), dtype=bool)
    sites: dict[tuple[int, int], list[int]] = {}
    for place, label in enumerate(modes.labels):
        match = SITE.fullmatch(label)
        if match and int(match[1]) <= ne:
            sites.setdefault((int(match[1]) - 1, "ab".index(match[2])), []).append(place)
    weights: dict[bytes, tuple[Array, Array | None]] = {}
    for (e, end), places in sites.items():
        middle = frame.origin[e] + end * frame.length[e] * frame.axes[e, :, 0]
        points = ((modes.positions[places] - middle) @ frame.axes[e])[:, 1:]
        edge = edges[frame.which[e]]
        size = max(float(np.abs(edge).max()), 1e-300)
        # equal sections share their weights
        key = np.round(points / size, 9).tobytes() + edge.tobytes()
        if key not in weights:
            weights[key] = outline_weights(points, edge)
        around, plane = weights[key]
        values = modes.modes[places]
        ends[e, end] = np.einsum("kp,pcn->kcn", around, values)
        if plane is not None:  # normal stress is linear over the section
            ends[e, end, :, 0] = plane @ values[:, 0]
        known[e, end] = True
    if not known.any():
        return None, None
    share = xi[None, :, None, None, None]
    every = (1.0 - share) * ends[:, :1] + share * ends[:, 1:]
    both = known.all(axis=1)
    mask = None if both.all() else np.repeat(both, len(xi) * k)
    return np.ascontiguousarray(np.moveaxis(every.reshape(-1, 6, n), 2, 0)), mask


def _skin(pairs: Index, frame: FrameShape, pieces: int, k: int) -> Index:
    """Return the triangles of all elements, closed at ends without a following element."""
    ring = (pieces + 1) * k
    found = [walls(pieces + 1, k) + e * ring for e in range(len(pairs))]
    at: dict[int, list[tuple[int, int]]] = {}
    for e, pair in enumerate(pairs):
        for end, node in enumerate(pair):
            at.setdefault(int(node), []).append((e, end))
    cap = fan(k)
    for members in at.values():
        if len(members) == 2 and _goes_on(frame, *members):
            continue
        for e, end in members:
            found.append((cap + e * ring + pieces * k) if end else (cap[:, ::-1] + e * ring))
    return np.concatenate(found).astype(np.intp)


def _goes_on(frame: FrameShape, one: tuple[int, int], other: tuple[int, int]) -> bool:
    """Return whether two elements join end to end in one direction, with the same section."""
    (e, i), (f, j) = one, other
    ends = [frame.origin[m] + s * frame.length[m] * frame.axes[m, :, 0] for m, s in (one, other)]
    near = np.linalg.norm(ends[0] - ends[1]) <= 1e-9 * frame.length[e]
    same = bool(np.allclose(frame.axes[e], frame.axes[f], rtol=0.0, atol=1e-9))
    return bool(near) and i != j and same and bool(frame.which[e] == frame.which[f])
