"""Laws that several hydraulic elements share: flow through an edge, opening of a valve."""

from __future__ import annotations

import math
from typing import Any

from jousto.mechanism.states.expression import clip, edge_flow, minimum, where

SMOOTHED = 0.01
"""Share of the stroke of a spool over which an edge begins to open."""


def edge(dp: Any, transition: float) -> Any:
    """Return ``dp/(dp^2 + t^2)^(1/4)``: laminar below t, then ``sqrt(dp)``."""
    return edge_flow(dp, transition)


def coefficient(flow: float, drop: float) -> float:
    """Return the flow coefficient ``Q/sqrt(dp)`` of an edge with a nominal flow, m3/s."""
    kv: float = flow / drop**0.5
    return kv


def area_coefficient(area: float, discharge: float, density: float) -> float:
    """Return the flow coefficient ``Cd A sqrt(2/rho)`` of an opening."""
    kv: float = discharge * area * (2.0 / density) ** 0.5
    return kv


def gap_conductance(
    diameter: float, clearance: float, length: float, eccentricity: float, viscosity: float
) -> float:
    """Return ``Q/dp`` of a laminar annular gap, ``pi D c^3 (1 + 1.5 e^2)/(12 mu l)``."""
    round_it = math.pi * diameter * clearance**3 / (12.0 * viscosity * length)
    return round_it * (1.0 + 1.5 * eccentricity**2)


def spool_opening(x: Any, overlap: float) -> Any:
    """Return the opening ``r((x - d)/(1 - d))`` of an edge with the overlap d.

    r is 0 below 0, ``z^2/(2 w)`` up to w, ``z - w/2`` above, over its value at 1.
    """
    z, w = (x - overlap) / (1.0 - overlap), SMOOTHED
    return clip(where(z, where(z - w, z - w / 2, z * z / (2 * w)), 0.0) / (1.0 - w / 2), 0.0, 1.0)


def held_drop(dp: Any, margin: float, full: float) -> Any:
    """Return the drop of a metering edge whose compensator closes by ``S((dp - p1)/full)``.

    Its slope over the whole drop is ``1 - S``, with the smooth step S and p1 = margin - full/2: it
    is dp below p1, and the margin from p1 + full on.
    """
    first = margin - full / 2.0
    z = clip((dp - first) / full, 0.0, 1.0)
    return minimum(dp, first) + full * z * (1.0 - z * z * (1.0 - z / 2.0))
