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
    found = _mass_properties(marker)
    if found is None:
        return 0.0
    mass, center, smallest = found
    lever = np.linalg.norm(marker.position_local - center) + reach
    shapes = _shapes(marker, "Phi")
    return float(1.0 / mass + lever**2 / smallest + shapes)


def lightest(a: Marker, b: Marker) -> float:
    """Return the mass of two bodies in series against a push without turning, kg."""
    found = (_mass_properties(marker) for marker in (a, b))
    return 1.0 / sum(1.0 / one[0] for one in found if one is not None)


def angular_mobility(marker: Marker) -> float:
    """Return the largest inverse moment of inertia of the body of a marker there, 1/(kg m^2)."""
    found = _mass_properties(marker)
    return 0.0 if found is None else float(1.0 / found[2] + _shapes(marker, "Psi"))


def _mass_properties(marker: Marker) -> tuple[float, Any, float] | None:
    """Return mass, centre of mass and smallest moment of inertia about it; None for the ground."""
    body: Any = marker.body
    if isinstance(body, RigidBody):
        smallest = float(np.linalg.eigvalsh(np.real(body.inertia))[0])
        return float(np.real(body.mass)), body.center, smallest
    if isinstance(body, FlexibleBody):
        invariants = body.reduced.invariants
        m = float(np.real(invariants.mass))
        center = np.real(invariants.I2) / m
        J = np.real(invariants.I7) - m * (center @ center * np.eye(3) - np.outer(center, center))
        smallest = max(float(np.linalg.eigvalsh(J)[0]), 1e-12 * float(np.trace(J)))
        return m, center, smallest
    return None


def _shapes(marker: Marker, name: str) -> float:
    """Return the square of the norm of the shapes of a flexible body at a marker; else 0."""
    if not isinstance(marker.body, FlexibleBody):
        return 0.0
    shapes = np.real(np.asarray(getattr(marker, name)))
    return float(np.linalg.norm(shapes, 2)) ** 2 if shapes.size else 0.0
