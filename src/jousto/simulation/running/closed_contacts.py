"""Check of the step before a run, by contacts that stay closed and are far stiffer than it."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf, sqrt
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.contacts.pair_tables import LAW_ROW, SHAPE_ROW, TIP_ROW
from jousto.model.model import Model
from jousto.model.native.header import named, places
from jousto.simulation.contacts import contacts
from jousto.simulation.solvers.base import Solver
from jousto.simulation.solvers.rosenbrock import ROS2

MANY = 1000.0
"""Steps of a closed contact in a step of the run, above which it is reported."""
STABLE = 0.5
"""Step of an explicit method times the rate of a closed contact (``JO_CONTACT_STABLE``)."""


def closed_contact_warning(model: Model, solver: Solver, step: float) -> str:
    """Return a sentence if a contact at rest would need many steps of an explicit method.

    Under its weight ``m g`` a contact of stiffness K, exponent n and effective mass m is
    ``d = (m g / K)^(1/n)`` deep and has the rate ``sqrt(n K d^(n-1) / m)``.
    """
    g = float(np.linalg.norm(np.real(model.gravity)))
    if solver.adaptive or solver.needs_tangent or isinstance(solver, ROS2) or not g > 0.0:
        return ""
    rate, name = max(
        ((_rate(force, g), force.name) for force in contacts(model)), default=(0.0, "")
    )
    if not rate * step > STABLE * MANY:
        return ""
    longest = STABLE / rate
    return (
        f"contact '{name}' is so stiff that {type(solver).__name__} takes steps of "
        f"{longest:.2g} s while it stays closed, {step / longest:.2g} of them in each step of "
        f"{step:.3g} s; take ROS2 or GeneralizedAlpha, or a softer law"
    )


def _rate(force: Any, g: float) -> float:
    """Return the largest rate of a contact at rest, 1/s; 0 for kinds without these numbers."""
    if force.kind in ("contact", "contact pair"):
        x = named(f"jo_{force.kind.replace(' ', '_')}_data", np.real(force.data))
        return _rate_at_rest(float(x.stiffness), float(x.exponent), 1.0 / float(x.mass), g)
    if force.kind != "contact set":
        return 0.0
    return max((_rate_at_rest(*pair, g) for pair in _pairs(np.real(force.data))), default=0.0)


def _rate_at_rest(K: float, n: float, mobility: float, g: float) -> float:
    if not (K > 0.0 and 0.0 < mobility < inf):
        return 0.0
    depth = (g / (K * mobility)) ** (1.0 / n)
    return sqrt(n * K * depth ** (n - 1.0) * mobility)


def _pairs(data: Array) -> Iterator[tuple[float, float, float]]:
    """Yield stiffness, exponent and largest inverse mass, 1/kg, of each pair of surfaces."""
    x = named("jo_contact_set_data", data)
    ns, nt, k = int(x.shapes), int(x.tips), int(x.surfaces)
    first = max(place.stop for place in places("jo_contact_set_data").values())
    shape = data[first : first + SHAPE_ROW * ns].reshape(ns, SHAPE_ROW)
    at = first + SHAPE_ROW * ns + TIP_ROW * nt
    law = data[at : at + LAW_ROW * k * k].reshape(k, k, LAW_ROW)
    curvature, mobility, surface = shape[:, 8:10], shape[:, 10:12], shape[:, 14].astype(int)
    curved, moves = np.zeros((k, 2)), np.zeros((k, 2))
    np.maximum.at(curved, surface, np.maximum(curvature, 0.0))
    np.maximum.at(moves, surface, mobility)
    for a in range(k):
        for b in range(k):
            hertz, K, n = law[a, b, :3]
            radius = 1.0
            if hertz:
                both = curved[a, 0] + curved[b, 1]
                radius = 1.0 / sqrt(both) if both > 0.0 else 0.0
            yield float(K) * radius, float(n), float(moves[a, 0] + moves[b, 1])
