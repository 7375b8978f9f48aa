"""Nodes of a mesh on faces that look in one direction."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Ints
from jousto.base.errors import Problems
from jousto.mesh.grid import Grid
from jousto.mesh.picks import unit_vector
from jousto.mesh.surface import face_normals


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
