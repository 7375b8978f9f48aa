"""Sensors of loads: reactions of joints, couplings and drives, and force elements."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import Field, Reference, field
from jousto.mechanism.bodies.marker import Marker, OptionalMarker
from jousto.mechanism.forces.base import ForceElement
from jousto.mechanism.forces.friction import Friction
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.coupling import Coupler
from jousto.mechanism.sensors.base import Reading, Sensor
from jousto.mechanism.sensors.motion import frame_name

FORCE, MOMENT = ("Fx", "Fy", "Fz"), ("Mx", "My", "Mz")
SUM_FORCES, SUM_PAIR, SUM_PRESSURE, SUM_RAIL = 0.0, 1.0, 2.0, 3.0
"""What a sensor of contacts sums (``jo_contact_sum`` of the engine)."""
SUM_ROW = 6
"""Numbers of a sum in the engine (``JO_SUM_ROW``)."""


class Held(Reference["Joint | Coupler", "Joint | Coupler"]):
    """Field of a joint, coupling or drive; a model file contains its name."""

    section = ("joints", "couplings")
    word = "joint"
    noun = "Joint, Gear, Rack, Coupling or Drive"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the joint, coupling or drive, or report a value of another type."""
        if not isinstance(value, Joint | Coupler):
            problems.add(where, f"{self.name} is {value!r}, must be a joint, coupling or drive")
        return value


class Axes(Field["str | Marker", "str | Marker"]):
    """Field of axes: of the world, of a joint or of a marker."""

    form = "axes"
    noun = '"world", "joint" or Marker'

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the keyword or the marker, or report that the value is neither."""
        if not (isinstance(value, Marker) or value in ("world", "joint")):
            problems.add(where, f"{self.name} is {value!r}, must be 'world', 'joint' or a marker")
        return value


class ReactionSensor(Sensor, tag="reaction"):
    """Reaction of a joint, coupling or drive on the body of its marker b.

    The reaction of a joint is a force and a moment (6,) about the origin of marker b, even if b
    slides away from a; about a the moment is ``M + (r_b - r_a) x F``. The reaction of a coupling or
    drive is the force or torque along each of its coordinates, N or N m: the torque of a motor, or
    the two forces on a gear or rack. If constraints are redundant the reactions are not unique; the
    results contain a warning.
    """

    joint: Held = field("The measured joint, coupling or drive")
    resolved_in: Axes = field(
        "Axes of the components: of the world, of the joint on its side a (z is the axis), or of "
        "a marker; not for couplings and drives",
        default="world",
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report axes for a coupling or drive, whose reactions have none."""
        if isinstance(self.joint, Coupler) and self.resolved_in != "world":
            problems.add(
                where,
                f"the reaction of {self.joint.name!r} acts along its coordinates, leave "
                f"resolved_in out",
                "resolved_in",
                named=False,
            )

    @property
    def unit(self) -> str:
        """Units: one for all components, or one for each half of them."""
        if isinstance(self.joint, Joint):
            return "N, N m"
        return joined_units(self.joint.coordinates)

    @property
    def components(self) -> tuple[str, ...]:
        """Names of force and moment components, or of the coordinates of a coupling."""
        if isinstance(self.joint, Joint):
            return (*FORCE, *MOMENT)
        return joined_names(self.joint.coordinates)

    @property
    def axes(self) -> Marker | None:
        """Marker in whose axes the components are resolved; None for the world."""
        if isinstance(self.resolved_in, Marker):
            return self.resolved_in
        if self.resolved_in == "joint" and isinstance(self.joint, Joint):
            return self.joint.frames[0]
        return None

    @property
    def frame(self) -> str:
        """Name of the axes in which the components are resolved."""
        if isinstance(self.joint, Coupler):
            return "coordinate"
        return "joint" if self.resolved_in == "joint" else frame_name(self.axes)

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """Markers whose orientation matters, each with the name of the argument."""
        return () if self.axes is None else (("resolved_in", self.axes),)

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        kind = "reaction" if isinstance(self.joint, Joint) else "multiplier"
        return Reading(kind, self.joint, axes=self.axes)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        if isinstance(self.joint, Joint):
            b = self.joint.b
            return f"reaction of {self.joint.name} on {b.body.name}, moment about {b.label}"
        names = " and ".join(s.name for s in self.joint.coordinates)
        return f"reaction of {self.joint.name} along {names}"


class Pushing(Reference[ForceElement | Friction, ForceElement | Friction]):
    """Field of a force element; a model file contains its name."""

    section = ("forces", "frictions")
    word = "force"
    noun = "Force, Torque, Spring, Friction or any other force element"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the force element, or report a value of another type."""
        if not isinstance(value, ForceElement | Friction):
            problems.add(
                where, f"{self.name} is {value!r}, must be a force element such as a Spring"
            )
        elif isinstance(value, ForceElement) and value.unmeasured:
            problems.add(where, f"{value.name!r} {value.unmeasured}")
        return value


class ForceSensor(Sensor, tag="force"):
    """Force and moment of a force element on the body of its marker, or of marker b.

    The sensor measures of a `Spring`, `JointForce`, `Servo` or `Friction` the force or torque along
    its coordinates, positive if it increases the coordinate; of a `Force` or a `MovingLoad` the
    force (3,) N, of a `Torque` the moment (3,) N m; of a `Bushing` and a `UserForce` force and
    moment (6,) at the origin of b; of a `ModalLoad` the resultant force and moment (6,) about the
    origin of the body frame, for the undeformed body; of a `Contact` force and moment (6,), the sum
    over its tips, on the body of the tips at the origin of its marker, or on body b of two
    polytopes.
    """

    force: Pushing = field("The measured force element")
    resolved_in: OptionalMarker = field(
        "Axes of the components; None for the world frame", default=None, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report axes that are given for a force along coordinates, and friction by rows."""
        if getattr(self.force, "sticks", False):
            problems.add(
                where,
                f"the friction of {self.force.name!r} is StickSlip(), whose force is that of rows; "
                "read it from run.contacts.at(time), or leave out friction of the contact",
                "force",
            )
        if self.resolved_in is not None and along(self.force):
            problems.add(
                where,
                f"{self.force.name!r} acts along its coordinate, leave resolved_in out",
                "resolved_in",
                named=False,
            )

    @property
    def unit(self) -> str:
        """Units: one for all components, or one for each half of them."""
        if found := along(self.force):
            return joined_units(found)
        units = {"force": "N", "moment": "N m"}
        return ", ".join(units[half] for half in self._measured)

    @property
    def components(self) -> tuple[str, ...]:
        """Components of force and moment."""
        if found := along(self.force):
            return joined_names(found)
        halves = {"force": FORCE, "moment": MOMENT}
        return tuple(name for half in self._measured for name in halves[half])

    @property
    def _measured(self) -> tuple[str, ...]:
        return self.force.measured if isinstance(self.force, ForceElement) else ("force", "moment")

    @property
    def first(self) -> int:
        """Index of the first measured component in the list of force and moment components."""
        return 0 if "force" in self._measured else 3

    @property
    def axes(self) -> Marker | None:
        """Marker in whose axes the components are resolved; None for the world."""
        return self.resolved_in

    @property
    def frame(self) -> str:
        """Name of the axes in which the components are resolved."""
        return "coordinate" if along(self.force) else frame_name(self.resolved_in)

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """Markers whose orientation matters, each with the name of the argument."""
        return () if self.resolved_in is None else (("resolved_in", self.resolved_in),)

    @property
    def reading(self) -> Reading:
        """Input of the engine."""
        if isinstance(self.force, Friction):
            return Reading("friction", self.force)
        count = len(self.force.pushes) if self.force.summed else 1
        if count > 1:
            rows = np.zeros((1, SUM_ROW))
            rows[0, :2] = SUM_FORCES, count
            return Reading("contact", self.force, self.first, self.axes, rows)
        return Reading("element", self.force, self.first, self.axes)

    @property
    def description(self) -> str:
        """One line for results and plots."""
        force = self.force
        kind = getattr(force, "kind", type(force).__name__.lower())
        if found := along(force):
            return f"{kind} {force.name} along {' and '.join(s.name for s in found)}"
        body = getattr(force, "body", None)
        if body is None:
            return f"{kind} {force.name} on {pushed(force).body.name}"
        whole = "resultant of " if "moment" in self._measured else ""
        return f"{whole}{kind} {force.name} on {body.name}"


def along(force: Any) -> tuple[Coordinate, ...]:
    """Return the coordinates along which a force acts; none if it acts at a marker."""
    return force.coordinates if isinstance(force, ForceElement | Friction) else ()


def pushed(force: Any) -> Marker:
    """Return the marker on whose body a force acts."""
    marker: Marker = force.b if hasattr(force, "b") else force.marker
    return marker


def joined_units(coordinates: tuple[Coordinate, ...]) -> str:
    """Return the units of forces along coordinates: one for all, or one per coordinate."""
    units = [s.force_unit for s in coordinates]
    return ", ".join(units if len(set(units)) > 1 else units[:1])


def joined_names(coordinates: tuple[Coordinate, ...]) -> tuple[str, ...]:
    """Return the names of the forces along coordinates."""
    names = tuple(s.name for s in coordinates)
    return names if len(names) > 1 else ("f",)
