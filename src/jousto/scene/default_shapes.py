"""Default shapes: rods between the points of a body, a ball at its centre of mass."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.mechanism.bodies.shapes import sphere

STEEL = 7850.0  # kg/m3, density for the size of a ball
ROD = 0.02  # radius of a rod relative to the extent of the body's points
ROUND = 12  # corners of a rod's section
BALL = (1.6, 6.0)  # smallest and largest ball radius relative to the rod radius
SMALL = 0.02  # extent of a single-point body relative to the machine


def default_shape(
    points: Array, pairs: Index, centre: Array | None, mass: float | None, size: float
) -> tuple[Array, Index]:
    """Return vertices (nv, 3), m, and triangles of rods between points and of a ball.

    The ball is a steel ball of the body's mass, within limits of visibility.

    Parameters
    ----------
    points : (k, 3) array
        Points in the frame of the body, m.
    pairs : (m, 2) int array
        Points with a rod between them.
    centre : (3,) array or None
        Centre of mass, m; no ball without one.
    mass : float or None
        kg.
    size : float
        Size of the machine, m.
    """
    every = points if centre is None else np.vstack([points, centre])
    extent = float(np.ptp(every, axis=0).max(initial=0.0)) if len(every) else 0.0
    if extent <= 1e-9 * size:
        extent = SMALL * size / ROD * 0.5
    radius = ROD * extent
    pieces: list[Array] = []
    for a, b in pairs:
        if np.linalg.norm(points[b] - points[a]) > 1e-9 * size:
            pieces.append(rod(points[a], points[b], radius))
    if centre is not None or not pieces:
        middle = points.mean(axis=0) if centre is None else centre
        wanted = radius if mass is None else (0.75 * mass / (np.pi * STEEL)) ** (1.0 / 3.0)
        ball = float(np.clip(wanted, BALL[0] * radius, BALL[1] * radius))
        pieces.append(sphere(ball).triangles + middle)
    return join_triangles(pieces)


def rod(a: Array, b: Array, radius: float) -> Array:
    """Return the triangles (nt, 3, 3) of a closed cylinder between two points, m."""
    along = b - a
    along = along / np.linalg.norm(along)
    across = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    across /= np.linalg.norm(across)
    third = np.cross(along, across)
    angle = 2.0 * np.pi * np.arange(ROUND) / ROUND
    ring = radius * (np.cos(angle)[:, None] * across + np.sin(angle)[:, None] * third)
    low, high = a + ring, b + ring
    on, after = np.arange(ROUND), (np.arange(ROUND) + 1) % ROUND
    sides = [
        np.stack([low[on], low[after], high[after]], axis=1),
        np.stack([low[on], high[after], high[on]], axis=1),
        np.stack([np.broadcast_to(a, low.shape), low[after], low[on]], axis=1),
        np.stack([np.broadcast_to(b, low.shape), high[on], high[after]], axis=1),
    ]
    return np.concatenate(sides)


def join_triangles(pieces: list[Array]) -> tuple[Array, Index]:
    """Return vertices and indices of triangles (nt, 3, 3), with shared vertices per piece."""
    vertices, triangles, first = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=np.intp)], 0
    for piece in pieces:
        x, corners = np.unique(piece.reshape(-1, 3), axis=0, return_inverse=True)
        vertices.append(x)
        triangles.append(corners.reshape(-1, 3) + first)
        first += len(x)
    return np.concatenate(vertices), np.concatenate(triangles).astype(np.intp)
