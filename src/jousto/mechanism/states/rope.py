"""What all ropes over sheaves have: their path, their stretch, and their picture."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.fields import field, kept
from jousto.base.numbers import DefaultNumber, Number, Values
from jousto.base.rotations import Direction, exp_rotation
from jousto.mechanism.bodies.marker import Marker, MarkersField
from jousto.mechanism.joints.rope_span import wrap_angle
from jousto.mechanism.states.block import Block
from jousto.mechanism.states.rope_path import RopePath

ARC = np.radians(30.0)
"""Angle between points of pictures on a sheave, rad."""


class Rope(Block):
    """Base of ropes that run over sheaves on any bodies."""

    symbol = "cable"
    path: MarkersField = field("Markers along the rope: an end or drum, sheaves, the other end")
    radii: Values = field(
        "Radius of the sheave at each marker, negative for the other sense; 0 for an end. Positive "
        "where the rope runs about the axle, the z axis of the marker, by the right hand",
        unit="m",
        shape=(None,),
    )
    stiffness: Number = field("EA, tension over strain", unit="N", above=0, kw_only=True)
    damping: Number = field(
        "c, tension over the rate of the stretch", unit="N s/m", least=0, default=0.0, kw_only=True
    )
    length: DefaultNumber = field(
        "Unstretched length at the start; None for the length at the initial pose",
        unit="m",
        above=0,
        default=None,
        kw_only=True,
    )
    axis: Direction = field(
        "Direction of all axles in the world frame at the initial pose; None for the z axes of the "
        "markers",
        default=None,
        kw_only=True,
    )

    route: Any = kept()

    def keep_path(self, found: RopePath | None) -> None:
        """Keep the path of the rope, or one without parts."""
        object.__setattr__(self, "route", found or RopePath((), (), (), (), (), ()))

    @property
    def parts(self) -> tuple[Any, ...]:
        """Parts of the rope between the markers of its path."""
        return self.route.parts  # type: ignore[no-any-return]

    @property
    def drawn_at(self) -> tuple[Marker | tuple[Any, Array], ...]:
        """Points along the rope at the initial pose, each on the body of its sheave."""
        found: list[Marker | tuple[Any, Array]] = []
        for k, marker in enumerate(self.route.path):
            radius = float(np.real(self.radii[k]))
            ways = [np.real(way) for way in self.route.ways[max(k - 1, 0) : k + 1]]
            if not radius:
                found.append(marker)
                continue
            n = np.real(self.route.axles[k])
            turn = float(np.real(wrap_angle(n, ways[0], ways[-1], radius)))
            for share in np.linspace(0.0, turn, 1 + max(1, round(turn / ARC))):
                rim = radius * np.cross(exp_rotation(np.sign(radius) * share * n) @ ways[0], n)
                found.append((marker.body, marker.position_local + marker.carrier.T @ rim))
        return tuple(found)
