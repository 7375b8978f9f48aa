"""Sensors of the motion of a marker, absolute or as seen from another marker.

An observer o at the origin of the marker `relative_to`, who moves and turns with its axes, sees of
a marker m, with d = r_m - r_o and the angular velocity W and acceleration W' of his axes::

    position              d
    velocity              u = v_m - v_o - W x d
    acceleration          a_m - a_o - W' x d - W x (W x d) - 2 W x u
    angular velocity      w = w_m - w_o
    angular acceleration  w_m' - w_o' - W x w

so that in his own axes, which the components are in unless `resolved_in` says otherwise, each is
the time derivative of the one before. (Modelica's relative sensors and Adams' functions with a
reference frame measure this. The plain difference of two velocities is that of two sensors without
`relative_to`.) With `resolved_in` alone the motion is that in the world, in the axes of a marker:
what a gyroscope fixed to it would show, and an accelerometer but for gravity (here free fall is
the acceleration of gravity, there zero).
"""

from __future__ import annotations

from typing import ClassVar

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.mechanism.bodies.marker import Marker, MarkerField, OptionalMarker
from jousto.mechanism.sensors.base import Reading, Sensor

XYZ = ("x", "y", "z")


class MotionSensor(Sensor):
    """What all sensors of the motion of a marker have in common."""

    quantity: ClassVar[str]
    unit: ClassVar[str]
    components: ClassVar[tuple[str, ...]] = XYZ
    turns: ClassVar[bool] = False
    """Whether the orientation of the marker itself matters."""
    marker: MarkerField = field("What is observed")
    relative_to: OptionalMarker = field(
        "The observer, who moves and turns with this marker; None for one at rest at the world's "
        "origin",
        default=None,
        kw_only=True,
    )
    resolved_in: OptionalMarker = field(
        "Axes of the components; None for those of the observer, the world without one; "
        '``ground["origin"]`` gives the world\'s',
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Note a marker that observes itself."""
        if self.marker is self.relative_to:
            problems.add(
                where,
                f"relative_to is the marker itself, {self.marker.label}: always zero",
                "relative_to",
            )

    @property
    def axes(self) -> Marker | None:
        """The marker whose axes the components are in, None for the world's."""
        return self.relative_to if self.resolved_in is None else self.resolved_in

    @property
    def frame(self) -> str:
        """Name of the axes that the components are in."""
        return frame_name(self.axes)

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """The markers whose orientation matters, with the name of the argument."""
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
        """What the engine reads."""
        return Reading(self.quantity, self.marker, self.relative_to, self.axes)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        seen = "" if self.relative_to is None else f" seen from {self.relative_to.label}"
        return f"{self.quantity} of {self.marker.label}{seen}"


class PositionSensor(MotionSensor, tag="position"):
    """Position of a marker, (3,) m: from the world's origin, or from another marker."""

    quantity: ClassVar[str] = "position"
    unit: ClassVar[str] = "m"


class VelocitySensor(MotionSensor, tag="velocity"):
    """Velocity of a marker, (3,) m/s: in the world, or as seen from another marker.

    As seen from a marker, the motion of that marker's axes is taken out: ``v - v_o - W x d``.
    """

    quantity: ClassVar[str] = "velocity"
    unit: ClassVar[str] = "m/s"


class AccelerationSensor(MotionSensor, tag="acceleration"):
    """Acceleration of a marker, (3,) m/s2: in the world, or as seen from another marker.

    ``r'' = R'' + A (w' x u + w x (w x u) + 2 w x Phi p' + Phi p'')``: exact, from the accelerations
    that the engine solves for. Gravity is included: a body in free fall has ``a = g``. As seen from
    a marker the accelerations of that marker's axes are taken out, with Euler's, the centripetal
    and Coriolis' part.
    """

    quantity: ClassVar[str] = "acceleration"
    unit: ClassVar[str] = "m/s2"


class AccelerationPartsSensor(MotionSensor, tag="acceleration-parts"):
    """Parts of the acceleration of a marker, (15,) m/s2: five vectors after each other.

    With the moving frame at R, its angular velocity w and u the way from it to the marker::

        frame       R''              acceleration of the moving frame's origin
        normal      w x (w x u)      towards the axis of turning
        tangential  w' x u
        coriolis    2 w x u'
        relative    u''              as seen in the moving frame

    (Rantalainen 2007, eq. 3.23; u' and u'' are derivatives in the moving frame.) Their sum is what
    `AccelerationSensor` measures in the world. On a flexible body seen from its own frame the
    relative part is the elastic one, ``A Phi p''``; on a rigid body it is zero, and the Coriolis
    part as well.
    """

    quantity: ClassVar[str] = "acceleration parts"
    unit: ClassVar[str] = "m/s2"
    components: ClassVar[tuple[str, ...]] = tuple(
        f"{part}:{x}"
        for part in ("frame", "normal", "tangential", "coriolis", "relative")
        for x in XYZ
    )
    relative_to: OptionalMarker = field(
        "The moving frame, whose motion the parts separate; None for the frame of the marker's "
        "own body",
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Seen from itself a marker has the first part only, which is allowed."""


class OrientationSensor(MotionSensor, tag="orientation"):
    """Euler parameters (4,) of a marker's axes, scalar first and not negative.

    Of the turn from the axes of `relative_to`, or of the world, to those of the marker; its axis is
    resolved as asked.
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
    """Angular velocity of a marker, (3,) rad/s: in the world, or as seen from another marker."""

    quantity: ClassVar[str] = "angular velocity"
    unit: ClassVar[str] = "rad/s"
    turns: ClassVar[bool] = True


class AngularAccelerationSensor(MotionSensor, tag="angular-acceleration"):
    """Angular acceleration of a marker, (3,) rad/s2: in the world, or seen from another marker.

    Exact, from the accelerations that the engine solves for, with the rotation mode shapes of
    flexible nodes.
    """

    quantity: ClassVar[str] = "angular acceleration"
    unit: ClassVar[str] = "rad/s2"
    turns: ClassVar[bool] = True


def frame_name(marker: Marker | None) -> str:
    """Return the name of the axes of a marker, ``world`` for None and the ground's own."""
    if marker is None or marker.label == "ground.origin" and (marker.axes.diagonal() == 1.0).all():
        return "world"
    return marker.label
