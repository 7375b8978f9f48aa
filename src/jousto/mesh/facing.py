"""Nodes of a mesh on a plane, or on faces that look in one direction."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Floats, Ints
from jousto.base.errors import Problems
from jousto.mesh.grid import Grid
from jousto.mesh.picks import NEAR
from jousto.mesh.surface import face_normals


def on_plane(mesh: Grid, point: Any, normal: Any, tolerance: float | None) -> Ints:
    """Return the nodes near a plane through a point, see :meth:`Mesh.plane`."""
    where, problems = f"mesh '{mesh.name}', plane", Problems()
    p = problems.array(where, "point", point, (3,))
    n = unit_vector(problems, where, "normal", normal)
    if tolerance is not None:
        problems.positive(where, "tolerance", tolerance, "m")
    problems.raise_if_any()
    assert p is not None and n is not None
    low, high = mesh.bounds
    slack = NEAR * float(np.max(high - low)) if tolerance is None else tolerance
    return np.flatnonzero(np.abs((mesh.nodes - p) @ n) <= slack)


def facing(mesh: Grid, direction: Any, angle: float) -> Ints:
    """Return the nodes of outer faces whose normal is near a direction."""
    where, problems = f"mesh '{mesh.name}', normal_to", Problems()
    d = unit_vector(problems, where, "direction", direction)
    if not 0.0 < angle <= 180.0:
        problems.add(where, f"angle is {angle:g} degrees, must be above 0 and at most 180")
    problems.raise_if_any()
    assert d is not None
    mask = np.zeros(len(mesh.nodes), dtype=bool)
    for block in mesh.faces:
        normals = face_normals(mesh.nodes, block.corners)
        long = np.linalg.norm(normals, axis=1)
        near = normals @ d >= (np.cos(np.radians(angle)) - 1e-12) * long
        mask[block.nodes[near]] = True
    return np.flatnonzero(mask)


def unit_vector(problems: Problems, where: str, name: str, value: Any) -> Floats | None:
    """Return a vector divided by its length, or note why it has no direction."""
    vector = problems.array(where, name, value, (3,))
    if vector is None:
        return None
    long = float(np.linalg.norm(vector))
    if long == 0.0:
        problems.add(where, f"{name} is zero, must have a direction")
        return None
    return vector / long
