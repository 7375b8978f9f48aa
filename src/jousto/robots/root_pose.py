"""Pose of the root of a robot on its base."""

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
    """Pose of the root of a robot on a marker of the base.

    Parameters
    ----------
    marker : Marker
        Marker of the base.
    frame : Frame
        Pose of the root in the frame of the marker.
    """

    marker: Marker
    frame: Frame = field(default_factory=Frame)

    @property
    def world(self) -> Frame:
        """Initial pose of the root in the world."""
        return Frame(self.marker.r, self.marker.A) @ self.frame

    @property
    def rigid(self) -> bool:
        """Whether the base is rigid, so that joints may be attached at any point of it."""
        return isinstance(self.marker.body, RigidBody | Ground)

    def at(self, frame: Frame) -> Marker:
        """Return the marker on the base for a frame given relative to the root."""
        own = Frame(np.asarray(self.marker.position_local), np.asarray(self.marker.axes))
        there = own @ self.frame @ frame
        body: Any = self.marker.body
        made: Marker = body.at(there.r, there.A)
        return made

    def motion(self, r: Array) -> tuple[Array, Array]:
        """Return velocity, m/s, of the base at r and its angular velocity, rad/s, world frame."""
        body: Any = self.marker.body
        zero = np.zeros(3)
        w = np.asarray(getattr(body, "angular_velocity", zero))
        return np.asarray(getattr(body, "velocity", zero)) + np.cross(w, r - body.position), w
