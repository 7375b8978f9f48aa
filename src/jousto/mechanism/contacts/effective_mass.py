"""Smallest mass that a force at a point of a body can meet."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.mechanism.bodies.body import FlexibleBody, RigidBody
from jousto.mechanism.bodies.marker import Marker


def mobility(marker: Marker, reach: float) -> float:
    """Return the largest inverse mass at a distance `reach`, m, from a marker, 1/kg.

    Of a rigid body ``1/m + l^2 / I_min``, l being the distance from the centre of mass; a flexible
    body adds the squares of its mass-normalised shapes at the marker. The ground has 0.
    """
    body: Any = marker.body
    if isinstance(body, RigidBody):
        lever = np.linalg.norm(marker.position_local - body.center) + reach
        smallest = float(np.linalg.eigvalsh(np.real(body.inertia))[0])
        return float(1.0 / np.real(body.mass) + lever**2 / smallest)
    if isinstance(body, FlexibleBody):
        invariants = body.reduced.invariants
        m = float(np.real(invariants.mass))
        center = np.real(invariants.I2) / m
        J = np.real(invariants.I7) - m * (center @ center * np.eye(3) - np.outer(center, center))
        lever = np.linalg.norm(marker.position_local - center) + reach
        smallest = max(float(np.linalg.eigvalsh(J)[0]), 1e-12 * float(np.trace(J)))
        shapes = np.real(np.asarray(marker.Phi))
        modal = float(np.linalg.norm(shapes, 2)) ** 2 if shapes.size else 0.0
        return float(1.0 / m + lever**2 / smallest + modal)
    return 0.0
