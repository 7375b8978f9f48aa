"""Positions and stress of vertices and points of a scene at some rows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, Index
from jousto.recovery.beams.strains import exponential, logarithm
from jousto.recovery.shape import bracket, rotation_matrices
from jousto.scene.scene import Body, Rings, Scene, Side

BLOCK = 64 << 20  # bytes of rows per read


def rows_at(scene: Scene, times: ArrayLike) -> Array:
    """Return the rows (nt, nr) of a run at instants, linear between stored rows.

    Euler parameters have the sign nearer to the row before.

    Raises
    ------
    InputError
        If an instant is outside the run.
    """
    assert scene.motion is not None and scene.run is not None
    before, after, share = bracket(scene.run, times)
    needed = np.unique([before, after])
    found = np.empty((len(needed), len(scene.still)))
    step = max(1, BLOCK // (8 * max(len(scene.still), 1)))
    first = 0
    while first < len(needed):
        last = int(np.searchsorted(needed, needed[first] + step))
        low, high = int(needed[first]), int(needed[last - 1]) + 1
        found[first:last] = scene.motion.rows(slice(low, high))[needed[first:last] - low]
        first = last
    a, b = found[np.searchsorted(needed, before)], found[np.searchsorted(needed, after)]
    e = euler_columns(scene.bodies)[:, None] + np.arange(4)
    b[:, e] *= np.where((a[:, e] * b[:, e]).sum(axis=-1, keepdims=True) < 0.0, -1.0, 1.0)
    return np.asarray((1.0 - share[:, None]) * a + share[:, None] * b)


def euler_columns(bodies: Sequence[Body]) -> Index:
    """Return the first column of each body's Euler parameters in a row."""
    places = [np.array([body.place]) for body in bodies if body.place >= 0]
    places += [body.rings.places for body in bodies if body.rings is not None]
    return np.unique(np.concatenate([np.zeros(0, dtype=np.intp), *places])).astype(np.intp) + 3


def vertices(body: Body, rows: Array, *, scale: float = 1.0) -> Array:
    """Return the world positions (k, nv, 3) of a body's vertices, m.

    Parameters
    ----------
    body : Body
    rows : (k, nr) array
    scale : float
        Factor on the deformation in the frame of the body; exact beams are not scaled.
    """
    if body.rings is not None:
        r, Q = _swept(body.rings, rows)
        v = body.rings.vertex_ring
        return np.asarray(r[:, v] + np.einsum("tvij,vj->tvi", Q[:, v, :, 1:], body.rings.yz))
    return body_points(body.place, body.positions, body.shapes, rows, scale)


def points(side: Side, rows: Array, *, scale: float = 1.0) -> Array:
    """Return the world positions (k, 3) of a point, m; see `vertices`."""
    phi = None if side.phi is None else np.asarray(side.phi).T[:, None]
    return body_points(side.place, side.u[None], phi, rows, scale)[:, 0]


def body_points(
    place: int, x: Array, shapes: Array | None, rows: Array, scale: float = 1.0
) -> Array:
    """Return ``R + A(e) (x + scale phi p)`` (k, nv, 3) of points x (nv, 3), m."""
    u = np.broadcast_to(x, (len(rows), *x.shape))
    if place < 0:
        return u
    at = rows[:, place:]
    if shapes is not None and len(shapes):
        n = len(shapes)
        u = u + scale * (at[:, 7 : 7 + n] @ shapes.reshape(n, -1)).reshape(u.shape)
    A = rotation_matrices(at[:, 3:7])
    return np.asarray(at[:, None, :3] + u @ np.swapaxes(A, 1, 2))


def section_axes(rings: Rings, rows: Array) -> Array:
    """Return section axes at the vertices of a beam in the world, as columns (k, nv, 3, 3)."""
    return np.asarray(_swept(rings, rows)[1][:, rings.vertex_ring])


def _swept(rings: Rings, rows: Array) -> tuple[Array, Array]:
    """Return axis points (k, nring, 3), m, and section axes at the rings of a beam."""
    node = rows[:, rings.places[:, None] + np.arange(7)]
    R, A = node[..., :3], rotation_matrices(node[..., 3:])
    own = rotation_matrices(rings.ends[..., 3:])
    e, b = rings.element, rings.share[:, None]
    ends = []
    for side, at in ((0, e), (1, e + 1)):
        arm = np.einsum("tnij,nj->tni", A[:, at], rings.ends[e, side, :3])
        ends.append((R[:, at] + arm, A[:, at] @ own[e, side]))
    (ra, Qa), (rb, Qb) = ends
    Q = Qa @ exponential(b * logarithm(np.swapaxes(Qa, -1, -2) @ Qb))
    size, a = np.linalg.norm(rb - ra, axis=-1, keepdims=True), 1.0 - b
    r = a * a * (1 + 2 * b) * ra + b * b * (1 + 2 * a) * rb
    return r + size * (a * a * b * Qa[..., 0] - a * b * b * Qb[..., 0]), Q


def stresses(body: Body, rows: Array) -> Array | None:
    """Return the stress (k, nv, 6) of the vertices, Pa, nan where unknown; None without stress.

    ``sigma = static + sum_j Sigma_j p_j``; for exact beams, the rows of the section times the
    resultants, which are linear along an element.
    """
    if body.rings is not None:
        found = _ring_stress(body.rings, rows)
    else:
        found = None if body.static is None else np.tile(body.static, (len(rows), 1, 1))
        if body.stress is not None and body.place >= 0:
            n, nv = body.stress.shape[:2]
            p = rows[:, body.place + 7 : body.place + 7 + n]
            own = (p @ body.stress.reshape(n, -1)).reshape(-1, nv, 6)
            found = own if found is None else found + own
    if found is not None and body.known is not None:
        found[:, ~body.known] = np.nan
    return found


def _ring_stress(rings: Rings, rows: Array) -> Array | None:
    if rings.forces < 0:
        return None
    count = 12 * (len(rings.places) - 1)
    ends = rows[:, rings.forces : rings.forces + count].reshape(len(rows), -1, 2, 6)
    ends, b = ends[:, rings.element], rings.share[:, None]
    p = ((1.0 - b) * ends[:, :, 0] + b * ends[:, :, 1])[:, rings.vertex_ring]
    return np.asarray(np.einsum("vcj,tvj->tvc", rings.rows[rings.corner], p))


def select_vertices(body: Body, which: Index) -> Body:
    """Return a body with a subset of its vertices, without triangles, lines and edges."""

    def some(values: Array | None) -> Array | None:
        return None if values is None else values[which]

    def of_modes(values: Array | None) -> Array | None:
        return None if values is None else values[:, which]

    rings = body.rings
    if rings is not None:
        rings = replace(
            rings,
            vertex_ring=rings.vertex_ring[which],
            yz=rings.yz[which],
            corner=rings.corner[which],
        )
    sections = body.sections
    if sections is not None:
        sections = replace(sections, vertex_ring=sections.vertex_ring[which], yz=sections.yz[which])
    return replace(
        body,
        positions=body.positions[which],
        triangles=None,
        lines=None,
        edges=None,
        shapes=of_modes(body.shapes),
        stress=of_modes(body.stress),
        static=some(body.static),
        known=None if body.known is None else body.known[which],
        nodes=None if body.nodes is None else body.nodes[which],
        damage=some(body.damage),
        life=some(body.life),
        sections=sections,
        rings=rings,
    )


def thicken_body(body: Body, least: float) -> Body:
    """Return a beam or frame with sections of at least a thickness, m, for visibility."""
    rings = body.rings
    if rings is not None:
        yz = rings.yz * _factor(rings.yz, rings.vertex_ring, least)[:, None]
        return replace(body, rings=replace(rings, yz=yz))
    if body.sections is None:
        return body
    at = body.sections.vertex_ring
    centre = _means(body.positions, at)
    factor = _factor(body.positions - centre, at, least)[:, None]
    shapes = body.shapes
    if shapes is not None:
        # displacement is linear over a section
        middle = np.stack([_means(shape, at) for shape in shapes]) if len(shapes) else shapes
        shapes = middle + factor * (shapes - middle)
    return replace(body, positions=centre + factor * (body.positions - centre), shapes=shapes)


def _means(x: Array, group: Index) -> Array:
    """Return the mean of each row's group of x (nv, 3), one per row."""
    count = np.maximum(np.bincount(group), 1)
    means = np.stack([np.bincount(group, column) / count for column in x.T], axis=1)
    return np.asarray(means[group])


def _factor(x: Array, group: Index, least: float) -> Array:
    """Return the factor (nv,) that enlarges each group to at least the thickness."""
    low = np.full((int(group.max()) + 1, x.shape[1]), np.inf)
    high = -low
    np.minimum.at(low, group, x)
    np.maximum.at(high, group, x)
    extent = (high - low).max(axis=1)[group]
    return np.asarray(np.maximum(1.0, least / np.maximum(extent, 1e-300)))
