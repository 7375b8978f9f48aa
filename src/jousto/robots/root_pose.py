"""Where the root of a robot stands."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.bodies.body import Ground, RigidBody
from jousto.mechanism.bodies.marker import Marker
from jousto.robots.description import Frame


@dataclass(frozen=True, eq=False)
class Seat:
    """Where the root of a robot stands.

    Parameters
    ----------
    marker : Marker
        What carries it.
    frame : Frame
        Frame of the root in that of the marker.
    """

    marker: Marker
    frame: Frame = field(default_factory=Frame)

    @property
    def world(self) -> Frame:
        """Frame of the root in the world at the initial pose."""
        return Frame(self.marker.r, self.marker.A) @ self.frame

    @property
    def rigid(self) -> bool:
        """Whether joints may stand anywhere beside the marker."""
        return isinstance(self.marker.body, RigidBody | Ground)

    def at(self, frame: Frame) -> Marker:
        """Return the marker of a frame that is given in that of the root."""
        own = Frame(np.asarray(self.marker.position_local), np.asarray(self.marker.axes))
        there = own @ self.frame @ frame
        body: Any = self.marker.body
        made: Marker = body.at(there.r, there.A)
        return made

    def motion(self, r: Array) -> tuple[Array, Array]:
        """Return velocity and angular velocity of what moves with the carrier at r, world."""
        body: Any = self.marker.body
        zero = np.zeros(3)
        w = np.asarray(getattr(body, "angular_velocity", zero))
        return np.asarray(getattr(body, "velocity", zero)) + np.cross(w, r - body.position), w
