"""Beam sections: outlines with equal numbers of corners, tubes between them, stress."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.model.beam_record import BeamShape

THIN = 0.01  # side of a default section without outline, relative to the beam length


def tube(rings: int, k: int) -> Index:
    """Return the triangles of a tube of rings of k corners, with both ends closed."""
    caps = [fan(k)[:, ::-1], fan(k) + k * (rings - 1)]
    return np.concatenate([walls(rings, k), *caps]).astype(np.intp)


def walls(rings: int, k: int) -> Index:
    """Return the triangles between consecutive rings of k corners."""
    i = np.arange(k)
    j = (i + 1) % k
    side = np.concatenate([np.stack([i, j, j + k], 1), np.stack([i, j + k, i + k], 1)])
    return np.asarray(side[None] + k * np.arange(rings - 1)[:, None, None]).reshape(-1, 3)


def fan(k: int) -> Index:
    """Return the triangles that fill a ring of k corners, outward in the beam direction."""
    i = np.arange(k)
    return np.stack([np.zeros(k - 2, dtype=int), i[1:-1], i[2:]], axis=1)


def beam_outlines(beam: BeamShape) -> Array:
    """Return the outlines (number of sections, k, 2) of a beam, with equal k for all."""
    return outlines([section.outline for section in beam.sections], float(beam.s[-1]))


def outlines(edges: Sequence[Array], length: float) -> Array:
    """Return outlines (number, k, 2), m, resampled to an equal number of corners.

    Parameters
    ----------
    edges : sequence of (k, 2) arrays
        Outer edges; empty if unknown, for a thin square instead.
    length : float
        Length of the beam, m.
    """
    side = 0.5 * THIN * length
    square = np.array([[-side, -side], [side, -side], [side, side], [-side, side]])
    found = []
    for given in edges:
        edge = given if len(given) else square
        if len(edge) == 4:  # rectangles: the middles of the sides are stress points as well
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
    """Return the stress (k, 6, 6) for unit resultants at the corners (k, 2) of an outline.

    On the edge between the points of a section, normal stress is linear over the section if the
    values at its points are, and shear stress is interpolated between the nearest points.
    """
    points, rows = section.points, section.rows
    if not len(points):
        return np.full((len(edge), 6, 6), np.nan)
    around, plane = outline_weights(points, edge)
    out = np.einsum("kp,pcj->kcj", around, rows)
    if plane is not None:
        basis = np.column_stack([np.ones(len(points)), points])
        fitted = basis @ np.linalg.lstsq(basis, rows[:, 0], rcond=None)[0]
        if np.allclose(fitted, rows[:, 0], rtol=0.0, atol=1e-9 * np.abs(rows).max()):
            out[:, 0] = plane @ rows[:, 0]
    return np.asarray(out)


def outline_weights(points: Array, edge: Array) -> tuple[Array, Array | None]:
    """Return weights of corner values (k, 2) from values at stress points (np, 2).

    Returns
    -------
    around : (k, np) array
        Linear in the angle between the outer points.
    plane : (k, np) array or None
        Plane of values that are linear over the section; None if the points span no plane.
    """
    centre = edge.mean(axis=0)
    arms = points - centre
    outer = np.flatnonzero(
        np.linalg.norm(arms, axis=1) > 0.3 * np.linalg.norm(edge - centre, axis=1).max()
    )
    around = np.zeros((len(edge), len(points)))
    if len(outer):
        angle = np.arctan2(arms[outer, 1], arms[outer, 0])
        order = np.argsort(angle)
        corner = np.arctan2(*(edge - centre).T[::-1])
        for i, unit in zip(outer[order], np.eye(len(outer)), strict=True):
            around[:, i] = np.interp(corner, angle[order], unit, period=2.0 * np.pi)
    else:
        around[:, 0] = 1.0
    basis = np.column_stack([np.ones(len(points)), points])
    plane = None
    if np.linalg.matrix_rank(basis) == 3:
        plane = np.column_stack([np.ones(len(edge)), edge]) @ np.linalg.pinv(basis)
    # corners that are stress points take the values of these points
    away = np.linalg.norm(edge[:, None] - points[None], axis=2)
    near = away.argmin(axis=1)
    same = np.flatnonzero(away.min(axis=1) < 1e-9 * np.ptp(edge))
    for weights in (around, plane):
        if weights is not None:
            weights[same] = np.eye(len(points))[near[same]]
    return around, plane
