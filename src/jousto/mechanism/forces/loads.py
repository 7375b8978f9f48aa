"""Gravity, point forces and torques."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.base.complexstep import floats
from jousto.base.declare import Declared
from jousto.base.fields import Flag, field
from jousto.base.numbers import Vector
from jousto.mechanism.bodies.marker import Marker, MarkerField
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.law import EngineLaw
from jousto.mechanism.signals.base import OptionalSignal


class Gravity(Declared):
    """Uniform gravity: the acceleration of all bodies in free fall."""

    kind = "gravity"
    acceleration: Vector = field(
        "Acceleration of free fall, world frame, for example ``(0, -9.81, 0)``", unit="m/s2"
    )


EngineLaw("load", units={"force": "N", "torque": "N m"}, side_by_side=True).declared()


class PointLoad(ForceElement):
    """Base of a force or a torque at a marker."""

    ties = False
    marker: MarkerField = field("Where it acts")
    follow: Flag = field("Whether the vector turns with the marker", default=False, kw_only=True)
    signal: OptionalSignal = field(
        "Factor on the vector: a function of time or a constant; None for 1",
        unit="1",
        default=None,
        kw_only=True,
    )

    @property
    def drawn_at(self) -> tuple[Marker, ...]:
        """The marker of the load."""
        return (self.marker,)

    @property
    def direction(self) -> tuple[Array, bool]:
        """Direction of the vector, in the body frame if it follows the body."""
        vector = np.array(floats(getattr(self, "vector", (0.0, 0.0, 0.0))))
        return (floats(self.marker.axes) @ vector if self.follow else vector), self.follow

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.name!r}: at {self.marker.label}>"

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """The marker, if the load follows it."""
        return (("marker", self.marker),) if self.follow else ()


class Force(PointLoad, tag="force"):
    """A force at a marker: ``Q_R = F``, ``Q_w = u~ A^T F``, ``Q_p = Phi^T A^T F``."""

    measured = ("force",)

    vector: Vector = field(
        "Force F: in the world frame, or in the marker's axes if `follow`", unit="N"
    )

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The force as a law of the engine."""
        data = {"force": self.vector, "torque": np.zeros(3)}
        turns = self.follow
        return (Push("load", data, b=self.marker, turns=turns, follow=turns, signal=self.signal),)


class Torque(PointLoad, tag="torque"):
    """A torque at a marker: ``Q_w = A^T T``, ``Q_p = (T(theta) Psi)^T A^T T``.

    T(theta) is the tangent operator of the marker's elastic rotation theta = Psi p.
    """

    kind = "torque"
    measured = ("moment",)
    vector: Vector = field(
        "Torque T: in the world frame, or in the marker's axes if `follow`", unit="N m"
    )

    @property
    def symbol(self) -> str:
        """Symbol of a torque, a curved arrow."""
        return "moment"

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """The marker of the load."""
        return (("marker", self.marker),)

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The torque as a law of the engine."""
        data = {"force": np.zeros(3), "torque": self.vector}
        return (Push("load", data, b=self.marker, follow=self.follow, signal=self.signal),)
