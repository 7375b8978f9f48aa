"""Beams as solids in pictures: the section swept along the bent axis, with stress on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, Index
from jousto.model.beam_record import BeamShape
from jousto.recovery.beams.forces import state_forces
from jousto.recovery.beams.strains import elements, exponential, logarithm, poses
from jousto.recovery.fields.criteria import evaluate
from jousto.recovery.shape import bracket, rotation_matrices
from jousto.simulation.results.solution import Solution

RINGS = 48  # along a beam at least
MOST_RINGS = 400
THIN = 0.01  # side of a section whose outline is not known, by the length of the beam


@dataclass(frozen=True, eq=False)
class BeamSkin:
    """The surface of a beam at some instants.

    Attributes
    ----------
    x : (nt, nv, 3) array
        Corners, world, m: ring after ring.
    triangles : (m, 3) int array
        Counterclockwise seen from outside, both ends closed.
    axes : (nt, nv, 3, 3) array
        Axes of the section at every corner, world, as columns.
    tensors : (nt, nv, 6) array or None
        Stress ``[s11 s22 s33 s12 s23 s13]`` in these axes, Pa; None if it is not known.
    """

    x: Array
    triangles: Index
    axes: Array
    tensors: Array | None

    @property
    def mises(self) -> Array | None:
        """Von Mises stress (nt, nv), Pa; None if it is not known."""
        return None if self.tensors is None else evaluate(self.tensors, "von-mises")


def beam_skin(
    run: Solution,
    beam: BeamShape,
    times: ArrayLike,
    *,
    stress: bool = True,
    least: float = 0.0,
) -> BeamSkin:
    """Return the swept section of a beam at instants between the stored ones.

    Between the nodes the section turns evenly and the axis is a cubic along the axes at its ends;
    the resultants are linear. On the edge between the points of a section, normal stress is linear
    over the section and shear stress is that between the nearest points.

    Parameters
    ----------
    run : Solution
    beam : BeamShape
    times : (nt,) array_like
        s.
    stress : bool
        Whether stress is worked out where it is known.
    least : float
        Thickness of a section in a picture at least, by the extent of the motion: thin beams are
        drawn thicker.

    Raises
    ------
    InputError
        If an instant is outside the run.
    """
    at, nt = elements(beam), len(np.atleast_1d(np.asarray(times, dtype=np.float64)))
    q, v = _states(run, beam, times)
    ends = poses(at, q[..., :3], rotation_matrices(q[..., 3:]))
    # rings: element and share of its length
    sub, stride = max(1, -(-RINGS // beam.n)), max(1, beam.n // MOST_RINGS)
    first = np.arange(0, beam.n, stride)
    element = np.append(np.repeat(first, sub), beam.n - 1)
    share = np.append(np.tile(np.arange(sub) / sub, len(first)), 1.0)[:, None]
    Qa = ends.Qa[:, element]
    phi = logarithm(np.swapaxes(Qa, -1, -2) @ ends.Qb[:, element])
    Q = Qa @ exponential(share * phi)
    ra, rb = ends.ra[:, element], ends.rb[:, element]
    size = np.linalg.norm(rb - ra, axis=-1, keepdims=True)
    ta, tb = size * Qa[..., 0], size * ends.Qb[:, element][..., 0]
    a, b = 1.0 - share, share
    r = a * a * (1 + 2 * b) * ra + b * b * (1 + 2 * a) * rb + a * a * b * ta - a * b * b * tb
    outlines = _outlines(beam)
    k = outlines.shape[1]
    extent = float(np.ptp(q[..., :3].reshape(-1, 3), axis=0).max())
    thick = np.ptp(outlines, axis=1).max(axis=1)[:, None, None]
    shown = outlines * np.maximum(1.0, least * extent / np.maximum(thick, 1e-300))
    yz = shown[beam.which[element]]
    x = r[:, :, None, :] + np.einsum("trij,rkj->trki", Q[..., 1:], yz)
    axes = np.broadcast_to(Q[:, :, None], (nt, len(element), k, 3, 3))
    tensors = None
    if stress and beam.stressed:
        s = state_forces(at, q, v)[2]
        p = a * s[:, element, 0] + b * s[:, element, 1]
        rows = np.stack([outline_rows(x, y) for x, y in zip(beam.sections, outlines, strict=True)])
        tensors = np.einsum("rkcj,trj->trkc", rows[beam.which[element]], p).reshape(nt, -1, 6)
    return BeamSkin(
        x.reshape(nt, -1, 3),
        tube(len(element), k),
        axes.reshape(nt, -1, 3, 3),
        tensors,
    )


def tube(rings: int, k: int) -> Index:
    """Return the triangles of a tube of rings of k corners, with both ends closed."""
    i = np.arange(k)
    j = (i + 1) % k
    side = np.concatenate([np.stack([i, j, j + k], 1), np.stack([i, j + k, i + k], 1)])
    sides = (side[None] + k * np.arange(rings - 1)[:, None, None]).reshape(-1, 3)
    fan = np.stack([np.zeros(k - 2, dtype=int), i[1:-1], i[2:]], axis=1)
    caps = [fan[:, ::-1], fan + k * (rings - 1)]
    return np.concatenate([sides, *caps]).astype(np.intp)


def _states(run: Solution, beam: BeamShape, times: ArrayLike) -> tuple[Array, Array]:
    """Return node states (nt, n + 1, 7) and (nt, n + 1, 6) at instants."""
    before, after, share = bracket(run, times)
    low, high = int(before.min()), int(after.max()) + 1
    q, v = run.beam_states(beam.name, slice(low, high))
    f = share[:, None, None]
    qa, qb = q[before - low], q[after - low]
    # q and -q are the same rotation
    sign = np.where((qa[..., 3:] * qb[..., 3:]).sum(-1, keepdims=True) < 0.0, -1.0, 1.0)
    qb = np.concatenate([qb[..., :3], sign * qb[..., 3:]], axis=-1)
    return (1 - f) * qa + f * qb, (1 - f) * v[before - low] + f * v[after - low]


def _outlines(beam: BeamShape) -> Array:
    """Return the outlines (number of sections, k, 2) with the same number of corners."""
    side = 0.5 * THIN * float(beam.s[-1])
    square = np.array([[-side, -side], [side, -side], [side, side], [-side, side]])
    found = []
    for section in beam.sections:
        edge = section.outline if len(section.outline) else square
        if len(edge) == 4:  # the middles of the sides are points of stress, too
            edge = np.stack([edge, 0.5 * (edge + np.roll(edge, -1, axis=0))], 1).reshape(-1, 2)
        found.append(edge)
    k = max(len(edge) for edge in found)
    return np.stack([edge if len(edge) == k else _resampled(edge, k) for edge in found])


def _resampled(edge: Array, k: int) -> Array:
    closed = np.concatenate([edge, edge[:1]])
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    at = np.arange(k) / k * s[-1]
    return np.stack([np.interp(at, s, closed[:, i]) for i in range(2)], axis=1)


def outline_rows(section: Any, edge: Array) -> Array:
    """Return the stress (k, 6, 6) for unit resultants at the corners (k, 2) of an outline."""
    out = np.zeros((len(edge), 6, 6))
    points, rows = section.points, section.rows
    if not len(points):
        return np.full_like(out, np.nan)
    centre = edge.mean(axis=0)
    arms = points - centre
    outer = np.linalg.norm(arms, axis=1) > 0.3 * np.linalg.norm(edge - centre, axis=1).max()
    angle = np.arctan2(arms[outer, 1], arms[outer, 0])
    order = np.argsort(angle)
    if outer.any():
        around = rows[outer][order]
        corner = np.arctan2(*(edge - centre).T[::-1])
        for c in range(6):
            for j in range(6):
                values = around[:, c, j]
                out[:, c, j] = np.interp(corner, angle[order], values, period=2.0 * np.pi)
    else:
        out[:] = rows[0]
    basis = np.column_stack([np.ones(len(points)), points])
    if np.linalg.matrix_rank(basis) == 3:
        plane = np.linalg.lstsq(basis, rows[:, 0], rcond=None)[0]
        if np.allclose(basis @ plane, rows[:, 0], rtol=0.0, atol=1e-9 * np.abs(rows).max()):
            out[:, 0] = np.column_stack([np.ones(len(edge)), edge]) @ plane
    # corners that are points of the section have its own values
    away = np.linalg.norm(edge[:, None] - points[None], axis=2)
    near = away.argmin(axis=1)
    same = away.min(axis=1) < 1e-9 * np.ptp(edge)
    out[same] = rows[near[same]]
    return out
