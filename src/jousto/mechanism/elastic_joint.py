"""Elastic joints: a motor behind an elastic gear, as in robots with flexible joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.arrays import Array, read_only
from jousto.base.complexstep import magnitude
from jousto.base.errors import Problems
from jousto.base.fields import Choice, Field, Flag, Name, field, kept
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.assembly import Assembly
from jousto.mechanism.bodies.body import Ground, RigidBody, ground
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.gear_spring import (
    RATIO,
    GearLawField,
    GearSpring,
    check_stiffness,
)
from jousto.mechanism.forces.springs import Spring
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import (
    DAMPING,
    STIFFNESS,
    VALUE,
    Angle,
    Coordinate,
    CoordinateField,
    Displacement,
)
from jousto.mechanism.joints.coupling import Drive
from jousto.mechanism.joints.hinges import Revolute
from jousto.mechanism.joints.slides import Fixed
from jousto.mechanism.signals.base import Constant
from jousto.mechanism.signals.piecewise import Table

TINY = 1e-9
"""Mass of a rotor without mass over that of the driven body, and its inertia across its axis over
that about it: both count with the carrier, and bodies need some."""
SLOW = {"rad": 0.01, "m": 1e-3}
"""Smallest speed of the joint at which dry friction of its motor is full, rad/s or m/s."""
SOON = 2e-3
"""Shortest time in which full dry friction stops the rotor alone, s."""


class AxialInertia(Field[Any, Array]):
    """Field of the moments of inertia of a rotor, the last one about its axis."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the inertia tensor (3, 3); the mass about the axis alone is no real body."""
        return read_only(np.diag(value))


class Rotor(RigidBody):
    """Rotor with inertia about its z axis; that across the axis counts with its carrier."""

    inertia: AxialInertia = field("Moments of inertia (3,)", unit="kg m2")


class ElasticJoint(Assembly, section="elastic_joints"):
    """Elasticity of a joint's gear with the rotor of its motor (robots with flexible joints).

    The rotor rides on the body of marker a of the joint's coordinate q and turns by phi about the
    axis of the joint. With the gear ratio N the motor's angle on the side of the joint is
    ``theta = q(0) + windup + phi / N``; the gear carries ``s = K (theta - q) + D (theta' - q')``
    to the joint (Spong, Journal of Dynamic Systems, Measurement and Control 109, 1987, 310-319).

    * ``coupling="exact"``: the rotor has the kinetic energy ``J (phi' + a . w)^2 / 2``, w the
      angular velocity of its carrier, a its axis (De Luca and Book, Springer Handbook of Robotics,
      2016, ch. 11).
    * ``"reduced"``: ``J phi'^2 / 2``, and J about the axis rides with the carrier (Spong's
      assumption, for large N).

    It is an argument of `Mechanism` like a body; the joint itself is another one. The equations
    have one more coordinate and no more rows: a tree stays in joint coordinates.

    Attributes
    ----------
    motor : Angle
        Angle phi of the rotor on its carrier, for motors, drives and sensors: the torque of a
        motor acts along it on the side of the motor, ``tau / N`` for tau on that of the joint.
    gear : GearSpring
        The elastic gear; ``ForceSensor("torque", joint.gear)`` reads s and its share on the motor.
    rotor : RigidBody
    bearing : Revolute
        The rotor's joint, for a `Friction` with stick-slip.

    Examples
    --------
    >>> from jousto import JointForce, Revolute, RigidBody, ground
    >>> link = RigidBody("link", 4.0, (0.1, 0.2, 0.2), center=(0.4, 0, 0))
    >>> shoulder = Revolute("shoulder", ground["origin"], link["origin"], axis=(0, 0, 1))
    >>> drive = ElasticJoint("shoulder", shoulder.angle, 100, 3.5e-5, 900.0)
    >>> torque = JointForce("torque", drive.motor, 0.2)
    """

    kind = "elastic joint"
    together = ("name", "coordinate", "ratio", "rotor_inertia", "rotor_mass", "stiffness", "law")
    name: Name = field("Unique among the elastic joints; begins the names of its items")
    coordinate: CoordinateField = field(
        "Coordinate q of the joint, such as ``elbow.angle`` or ``slide.displacement``"
    )
    ratio: Number = field(
        "Gear ratio N: turns of the motor per turn of the joint, or radians per metre; negative "
        "if the motor turns the other way",
        unit=RATIO,
        nonzero=True,
    )
    rotor_inertia: Number = field(
        "Inertia J of the rotor about its axis, not times N^2", unit="kg m2", above=0
    )
    stiffness: OptionalNumber = field(
        "K of the gear on the side of the joint; None for `law`",
        unit=STIFFNESS,
        above=0,
        default=None,
    )
    damping: Number = field(
        "D of the gear on the side of the joint", unit=DAMPING, least=0, default=0.0, kw_only=True
    )
    law: GearLawField = field(
        "Torque over the wind-up, such as `HarmonicDrive`, instead of the stiffness",
        default=None,
        kw_only=True,
    )
    coupling: Choice = field(
        "Whether the rotor feels the rotation of its carrier",
        words=("exact", "reduced"),
        default="exact",
        kw_only=True,
    )
    rotor_mass: Number = field(
        "Mass of the rotor, at the joint; 0 if the mass of the carrier contains it",
        unit="kg",
        least=0,
        default=0.0,
        kw_only=True,
    )
    windup: Number = field("Wind-up theta - q at the start", unit=VALUE, default=0.0, kw_only=True)
    friction: Number = field(
        "Dry friction of the motor, at the rotor", unit="N m", least=0, default=0.0, kw_only=True
    )
    viscous: Number = field(
        "Viscous friction of the motor, at the rotor",
        unit="N m s/rad",
        least=0,
        default=0.0,
        kw_only=True,
    )
    brake: Flag = field("Whether a brake holds the rotor", default=False, kw_only=True)
    prefix: str = kept()
    motor: Angle = kept()
    gear: GearSpring = kept()
    rotor: RigidBody = kept()
    bearing: Revolute = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Build the items; report a missing stiffness, and coordinates of no single axis."""
        s = self.coordinate
        check_stiffness(problems, where, self)
        if not isinstance(s, Angle | Displacement):
            problems.add(where, f"{s.name} is a distance, must be an angle or a displacement")
        if problems.found:
            return
        axis = np.asarray(s.a.A)[:, s.column]
        carried = self.coupling == "exact"
        place = s.a if carried else ground.at(s.a.r, s.a.A)
        rotor = self._rotor("rotor", place, carried)
        bearing = Revolute(f"{self.name} motor", place, rotor["origin"], axis=axis)
        gear = GearSpring(
            *(f"{self.name} gear", s, bearing.angle, self.ratio, self.stiffness),
            damping=self.damping,
            law=self.law,
            windup=self.windup,
        )
        kept: dict[str, Any] = {
            "rotor": rotor,
            "bearing": bearing,
            "motor": bearing.angle,
            "gear": gear,
        }
        more = (*self._losses(bearing.angle), *self._brake(bearing.angle))
        mount = () if carried else self._mount()
        kept |= {"items": (rotor, bearing, gear, *more, *mount), "prefix": f"{self.name} "}
        for key, value in kept.items():
            object.__setattr__(self, key, value)

    def _rotor(self, what: str, place: Marker, turning: bool) -> Rotor:
        """Return a rotor at a marker, its z axis along the joint's, that moves with the marker."""
        s, J = self.coordinate, self.rotor_inertia
        axes = np.roll(s.a.A, 2 - s.column, axis=1)
        v, w = motion_of(place)
        if turning:
            w = w + self.ratio * rate_of(s) * axes[:, 2]
        return Rotor(
            f"{self.name} {what}",
            self.rotor_mass + TINY * mass_of(s),
            (TINY * J, TINY * J, J),
            position=place.r,
            orientation=axes,
            velocity=v,
            angular_velocity=w,
        )

    def _losses(self, motor: Angle) -> tuple[Spring, ...]:
        """Return the friction of the motor."""
        f = self.friction
        if f == 0.0 and self.viscous == 0.0:
            return ()
        speeds = SLOW[self.coordinate.unit] * magnitude(self.ratio), f * SOON / self.rotor_inertia
        slow = max(speeds, key=np.real)  # complex in a derivative
        table = Table((-slow, slow), (f, -f)) if f else None
        name = f"{self.name} losses"
        return (Spring(name, motor, damping=self.viscous, damper_table=table),)

    def _brake(self, motor: Angle) -> tuple[Drive, ...]:
        name = f"{self.name} brake"
        return (Drive(name, motor, Constant(motor.initial)),) if self.brake else ()

    def _mount(self) -> tuple[Any, ...]:
        """Return the rotor's own inertia on its carrier for the reduced coupling."""
        s = self.coordinate
        if isinstance(s.a.body, Ground):
            return ()
        mount = self._rotor("mount", s.a, False)
        return mount, Fixed(f"{self.name} seat", s.a, mount["origin"])

    @property
    def bodies(self) -> Mapping[str, RigidBody]:
        """Its bodies by name."""
        return {x.name: x for x in self.items if isinstance(x, RigidBody)}

    @property
    def joints(self) -> Mapping[str, Joint]:
        """Its joints by name."""
        return {x.name: x for x in self.items if isinstance(x, Joint)}


def mass_of(s: Coordinate) -> float:
    """Return the mass of the body of marker b, of that of a if b is the ground, kg."""
    body: Any = s.a.body if isinstance(s.b.body, Ground) else s.b.body
    mass: float = body.mass if isinstance(body, RigidBody) else body.reduced.invariants.mass
    return mass


def motion_of(marker: Marker) -> tuple[Array, Array]:
    """Return the initial velocity, m/s, and angular velocity, rad/s, of a marker (world)."""
    body: Any = marker.body
    if isinstance(body, Ground):
        return np.zeros(3), np.zeros(3)
    w = np.asarray(body.angular_velocity)
    return np.asarray(body.velocity) + np.cross(w, marker.r - body.position), w


def rate_of(s: Coordinate) -> Any:
    """Return the initial rate of an angle or a displacement by the motion of its bodies."""
    (va, wa), (vb, wb) = motion_of(s.a), motion_of(s.b)
    axis = s.a.A[:, s.column]
    return axis @ (wb - wa if isinstance(s, Angle) else vb - va - np.cross(wa, s.b.r - s.a.r))
