"""Bounding box of a scene and size of the machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from jousto.base.arrays import Array
from jousto.recovery.shape import rotation_matrices
from jousto.scene.scene import Body, Side, Symbol
from jousto.simulation.results.records import BodyShape


def bounding_box(bodies: Sequence[Body], symbols: Sequence[Symbol], rows: Array) -> Array:
    """Return the corners (2, 3) of the bounding box over some rows (k, nr), m.

    Flexible bodies contribute the box of their undeformed vertices; beams their nodes with the
    largest extent of the section.
    """
    clouds = [np.zeros((0, 3))]
    for body in bodies:
        if body.rings is not None:
            R = rows[:, body.rings.places[:, None] + np.arange(3)].reshape(-1, 3)
            far = float(np.abs(body.rings.yz).max(initial=0.0))
            clouds += [R.min(axis=0) - far, R.max(axis=0) + far]
        else:
            low, high = body.positions.min(axis=0), body.positions.max(axis=0)
            corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1)), axis=-1).reshape(-1, 3)
            clouds.append(rigid_points(body.place, corners, rows))
    clouds += [
        rigid_points(side.place, side.u[None], rows) for one in symbols for side in one.sides
    ]
    every = np.concatenate([np.atleast_2d(cloud) for cloud in clouds])
    if not len(every):
        return np.array([[-0.5] * 3, [0.5] * 3])
    return np.stack([every.min(axis=0), every.max(axis=0)])


def rigid_points(place: int, points: Array, rows: Array) -> Array:
    """Return points (k, 3) of a rigid body in the world at some rows, m."""
    if place < 0:
        return points
    R, e = rows[:, place : place + 3], rows[:, place + 3 : place + 7]
    turned = np.einsum("tij,kj->tki", rotation_matrices(e), points)
    return np.asarray((R[:, None] + turned).reshape(-1, 3))


def size_of(shapes: Sequence[BodyShape], symbols: Sequence[Symbol], still: Array) -> float:
    """Return the size of a machine at its first instant, m; 1 if it is a single point."""
    row = still[None]
    clouds = [rigid_points(x.q_offset, np.asarray(x.nodes), row) for x in shapes if len(x.nodes)]
    sides: list[Side] = [side for one in symbols for side in one.sides]
    clouds += [rigid_points(side.place, side.u[None], row) for side in sides]
    if not clouds:
        return 1.0
    extent = float(np.ptp(np.concatenate(clouds), axis=0).max())
    return extent if extent > 0.0 else 1.0
