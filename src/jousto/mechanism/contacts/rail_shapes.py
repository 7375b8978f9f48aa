"""Surfaces of a wheel and of the head of its rail, for pictures."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.bodies.shapes import revolved
from jousto.mechanism.contacts.rail_patch import RailPatch

OUTSIDE = 0.095
"""Width of the tread beyond the middle of the rail, away from the flange, m (EN 13715)."""
INSIDE, RISE = 0.04, 0.028
"""Width towards the flange from the middle of the rail, and height of the flange, m (EN 13715)."""
DEEP = 0.05
"""Height of the head of the rail that is shown, m."""
LONG = 20.0
"""Half the length of the rail that is shown over the radius of the wheel."""
POINTS = 24
"""Points of a profile."""


class RailShape(NamedTuple):
    """Surface of a wheel or a rail: triangles (nt, 3, 3), m, in the frame of its marker."""

    tag: str
    triangles: Array


def wheel_shape(patches: tuple[RailPatch, ...]) -> RailShape:
    """Return the wheel about the z axis of its marker, from the sections of tread and flange."""
    tread, flange = patches[0], patches[-1]
    side = float(np.sign(flange.slope)) or 1.0
    rise = RISE if len(patches) > 1 else 0.0
    y = side * np.linspace(-OUTSIDE, INSIDE + rise, POINTS)
    radius = tread.radius + tread.slope * y - 0.5 * tread.curvature * y * y
    if rise:
        cone = flange.radius + flange.slope * (y - flange.place)
        radius = np.minimum(np.maximum(radius, cone), tread.radius + rise)
    order = np.argsort(y)
    y, radius = y[order], radius[order]
    profile = np.column_stack([np.r_[0.0, radius, 0.0], np.r_[y[0], y, y[-1]]])
    return RailShape("wheel", revolved(profile))


def rail_shape(head: float, corner: float, half: float, radius: float) -> RailShape:
    """Return the head of a rail along x, its top at the marker."""
    # half of the section: crown, round corner, side
    flat = np.linspace(0.0, half - corner, POINTS // 3)
    turn = np.linspace(0.0, 0.5 * np.pi, POINTS // 3)[1:]
    crown = np.column_stack([flat, -np.minimum(0.5 * flat**2 / head, DEEP)])
    low = crown[-1, 1]
    arc = np.column_stack(
        [half - corner + corner * np.sin(turn), low - corner * (1 - np.cos(turn))]
    )
    right = np.vstack([crown, arc, [half, low - DEEP]])
    left = (right * (-1, 1))[::-1]
    outline = np.vstack([left, right[1:]])
    ends = [np.column_stack([np.full(len(outline), x * LONG * radius), outline]) for x in (-1, 1)]
    back, front = ends
    strips = [(back[:-1], front[:-1], front[1:]), (back[:-1], front[1:], back[1:])]
    return RailShape("rail", np.concatenate([np.stack(strip, axis=1) for strip in strips]))
