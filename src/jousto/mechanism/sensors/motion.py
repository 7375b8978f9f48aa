"""Sensors of the motion of a marker, absolute or as seen from another marker.

In the frame of an observer o, the marker `relative_to`, the motion of a marker m is as follows,
with d = r_m - r_o and the angular velocity W and acceleration W' of the frame of o::

    position              d
    velocity              u = v_m - v_o - W x d
    acceleration          a_m - a_o - W' x d - W x (W x d) - 2 W x u
    angular velocity      w = w_m - w_o
    angular acceleration  w_m' - w_o' - W x w

In the axes of o, the default of `resolved_in`, each row is the time derivative of the one before.
(Modelica's relative sensors and Adams' functions with a reference frame use the same definition.
The plain difference of two velocities is the difference between the values of two sensors without
`relative_to`.) With `resolved_in` only, the motion relative to the world is resolved in the axes of
a marker: the output of a gyroscope fixed to the marker, or of an accelerometer except for gravity
(in free fall the sensor measures the acceleration of gravity, an accelerometer zero).
"""

from __future__ import annotations

from typing import ClassVar

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.mechanism.bodies.marker import Marker, MarkerField, OptionalMarker
from jousto.mechanism.sensors.base import Reading, Sensor

XYZ = ("x", "y", "z")


class MotionSensor(Sensor):
    """Base of all sensors of the motion of a marker."""

    quantity: ClassVar[str]
    unit: ClassVar[str]
    components: ClassVar[tuple[str, ...]] = XYZ
    turns: ClassVar[bool] = False
    """Whether the orientation of the marker itself matters."""
    marker: MarkerField = field("The observed marker")
    relative_to: OptionalMarker = field(
        "The observer, a marker whose frame may move; None for the world frame",
        default=None,
        kw_only=True,
    )
    resolved_in: OptionalMarker = field(
        "Axes of the components; None for the axes of the observer, or of the world without an "
        'observer; ``ground["origin"]`` for the axes of the world',
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a marker that is its own reference."""
        if self.marker is self.relative_to:
            problems.add(
                where,
                f"relative_to is the marker itself, {self.marker.label}: always zero",
                "relative_to",
            )

    @property
    def axes(self) -> Marker | None:
        """Marker in whose axes the components are resolved; None for the world."""
        return self.relative_to if self.resolved_in is None else self.resolved_in

    @property
    def frame(self) -> str:
        """Name of the axes in which the components are resolved."""
        return frame_name(self.axes)

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """Markers whose orientation matters, each with the name of the argument."""
        found = [("marker", self.marker)] if self.turns else []
        if self.relative_to is not None and (
            self.axes is self.relative_to or not isinstance(self, PositionSensor)
        ):
            found.append(("relative_to", self.relative_to))
        if self.resolved_in is not None:
            found.append(("resolved_in", self.resolved_in))
        return tuple(found)

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        return Reading(self.quantity, self.marker, self.relative_to, self.axes)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        seen = "" if self.relative_to is None else f" seen from {self.relative_to.label}"
        return f"{self.quantity} of {self.marker.label}{seen}"


class PositionSensor(MotionSensor, tag="position"):
    """Position of a marker, (3,) m, relative to the world origin or to another marker."""

    quantity: ClassVar[str] = "position"
    unit: ClassVar[str] = "m"


class VelocitySensor(MotionSensor, tag="velocity"):
    """Velocity of a marker, (3,) m/s, in the world or as seen from another marker.

    As seen from a marker, the motion of its frame is subtracted: ``v - v_o - W x d``.
    """

    quantity: ClassVar[str] = "velocity"
    unit: ClassVar[str] = "m/s"


class AccelerationSensor(MotionSensor, tag="acceleration"):
    """Acceleration of a marker, (3,) m/s2, in the world or as seen from another marker.

    ``r'' = R'' + A (w' x u + w x (w x u) + 2 w x Phi p' + Phi p'')``: exact, from the accelerations
    that the engine solves for. Gravity is included: a body in free fall has ``a = g``. As seen from
    a marker, the acceleration of its frame is subtracted, with the Euler, centripetal and Coriolis
    terms.
    """

    quantity: ClassVar[str] = "acceleration"
    unit: ClassVar[str] = "m/s2"


class AccelerationPartsSensor(MotionSensor, tag="acceleration-parts"):
    """Acceleration of a marker in five parts, (15,) m/s2, vector after vector.

    With the moving frame at R, its angular velocity w and u the vector from R to the marker::

        frame       R''              acceleration of the moving frame's origin
        normal      w x (w x u)      towards the axis of turning
        tangential  w' x u
        coriolis    2 w x u'
        relative    u''              as seen in the moving frame

    (Rantalainen 2007, eq. 3.23; u' and u'' are derivatives in the moving frame.) Their sum is the
    acceleration that `AccelerationSensor` measures in the world. On a flexible body seen from its
    own frame the relative part is the elastic one, ``A Phi p''``; on a rigid body it is zero, like
    the Coriolis part.
    """

    quantity: ClassVar[str] = "acceleration parts"
    unit: ClassVar[str] = "m/s2"
    components: ClassVar[tuple[str, ...]] = tuple(
        f"{part}:{x}"
        for part in ("frame", "normal", "tangential", "coriolis", "relative")
        for x in XYZ
    )
    relative_to: OptionalMarker = field(
        "Moving frame of the five parts; None for the frame of the marker's own body",
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Accept a marker that is its own reference: only the first part is nonzero then."""


class OrientationSensor(MotionSensor, tag="orientation"):
    """Euler parameters (4,) of the axes of a marker, scalar first and not negative.

    They describe the rotation from the axes of `relative_to` (or of the world) to those of the
    marker; its axis is resolved in the axes of `resolved_in`.
    """

    quantity: ClassVar[str] = "orientation"
    unit: ClassVar[str] = "1"
    components: ClassVar[tuple[str, ...]] = ("e0", "e1", "e2", "e3")
    turns: ClassVar[bool] = True

    @property
    def description(self) -> str:
        """One line for results and plots."""
        return f"{super().description} (Euler parameters, scalar first)"


class AngularVelocitySensor(MotionSensor, tag="angular-velocity"):
    """Angular velocity of a marker, (3,) rad/s, in the world or as seen from another marker."""

    quantity: ClassVar[str] = "angular velocity"
    unit: ClassVar[str] = "rad/s"
    turns: ClassVar[bool] = True


class AngularAccelerationSensor(MotionSensor, tag="angular-acceleration"):
    """Angular acceleration of a marker, (3,) rad/s2, in the world or as seen from a marker.

    Exact, from the accelerations that the engine solves for, with the rotation mode shapes of
    flexible nodes.
    """

    quantity: ClassVar[str] = "angular acceleration"
    unit: ClassVar[str] = "rad/s2"
    turns: ClassVar[bool] = True


def frame_name(marker: Marker | None) -> str:
    """Return the name of the axes of a marker: ``world`` for None and for the ground's own axes."""
    if marker is None or marker.label == "ground.origin" and (marker.axes.diagonal() == 1.0).all():
        return "world"
    return marker.label
