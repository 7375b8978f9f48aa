"""RobotInMechanism: a robot as an assembly of a larger machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from typing import Any

from jousto.base.errors import InputError, Problem, Problems, UnknownNameError, suggest
from jousto.base.fields import AnyField, Field, Flag, Name, OptionalText, field, kept
from jousto.base.frozen_dict import Frozen
from jousto.base.numbers import Number, Vector, number
from jousto.base.rotations import rotation_matrix
from jousto.mechanism.assembly import Assembly
from jousto.mechanism.bodies.base import ZERO3, Orientation
from jousto.mechanism.bodies.body import Ground, RigidBody, ground
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.contacts.collision import Apart, CollisionShape
from jousto.robots.actuators import with_actuators
from jousto.robots.build import build_robot, by_joint, check_joints, contacts_of
from jousto.robots.contact_law import RobotContact
from jousto.robots.contacts import excluded_shapes
from jousto.robots.description import Frame, Robot
from jousto.robots.joint_limits import RESTITUTION
from jousto.robots.readers.files import read_robot
from jousto.robots.root_pose import Seat


class RobotField(Field["Robot | str | PathLike[str]", Robot]):
    """Field with a robot, or the path of its file."""

    form = "robot"
    noun = "Robot or path"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the robot; a path is read."""
        if isinstance(value, str | PathLike):
            try:
                return read_robot(str(value))
            except InputError as error:
                problems.found.extend(error.problems)
        elif not isinstance(value, Robot):
            problems.add(
                where, f"robot is {value!r}, must be a Robot or the path of its file", "robot"
            )
        return value


class BaseField(Field["Marker | RigidBody | Ground | None", "Marker"]):
    """Field with the base of a robot: a body, a marker, or None."""

    form = "base"
    noun = "RigidBody or Marker"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the marker; for a body, the marker at its origin."""
        if isinstance(value, RigidBody | Ground):
            return value["origin"]
        if not isinstance(value, Marker):
            problems.add(
                where,
                f"base is {value!r}, must be a rigid body, a marker or None for the ground",
                "base",
            )
        return value


class Prefix(OptionalText):
    """Field with a prefix of names, which may be empty, or None."""

    form = "prefix"


class Stops(AnyField):
    """Field with stops of joints: True, False, or their stiffness."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return True, False or the stiffness."""
        if type(value).__name__ in ("bool", "bool_"):
            return bool(value)
        wrong = Problems()
        x = number(wrong, where, self.name, value)
        if x is None or x <= 0.0:
            problems.add(
                where,
                f"{self.name} is {value!r}, must be True, False or a positive stiffness in N/m or "
                "N m/rad",
            )
            return None
        return float(x)


class RobotInMechanism(Assembly, section="robots"):
    """Robot on the ground or on a body of a larger machine.

    It is an argument of `Mechanism` like a body; the names of its bodies, joints and forces have
    its prefix: ``arm_elbow``. Joint coordinates are those of its file. Gravity is that of the
    machine; gravity compensation is for the gravity of the file. Stops, losses, rotors and
    actuators are those of `mechanism`. With ``contact`` its links touch one another and the planes
    of its file; for contact with the rest of the machine pass `shapes` and `apart` to one
    `Contacts`. ``robot["tool"]`` is the marker of a link or a named frame,
    by its name in the file, with the axes of the file.

    Attributes
    ----------
    bodies, joints : dict
        Bodies and joints by their names in the file.
    items : tuple
        Bodies, joints, forces and sensors.

    Examples
    --------
    An arm on a cart::

        arm = jo.robots.RobotInMechanism("arm", "arm.urdf", cart["top"], at={"elbow": 0.5})
        motor = jo.JointForce("motor", arm.joints["elbow"].angle, jo.Input("u"))
        machine = jo.Mechanism(cart, slide, arm, motor, jo.Gravity((0, 0, -9.81)))
    """

    kind = "robot"
    together = ("robot",)
    name: Name = field("Unique among the robots")
    robot: RobotField = field("A Robot, or its URDF, MJCF or SDF file", key="file")
    base: BaseField = field(
        "Body, frame or marker to which the robot is fixed; if not given it is on the ground, "
        "fixed or free as in its file",
        default=None,
    )
    position: Vector = field(
        "Position of the robot's root in the frame of the base",
        unit="m",
        default=ZERO3,
        kw_only=True,
    )
    orientation: Orientation = field(
        "Orientation of the root in the frame of the base", default=None, kw_only=True
    )
    prefix: Prefix = field(
        "Prefix of the names of its bodies and joints; its name and _ if not given",
        default=None,
        kw_only=True,
    )
    stops: Stops = field(
        "Whether the limits of the joints are stops; in Python also their stiffness, N m/rad or "
        "N/m",
        form="flag",
        noun="bool or float",
        default=True,
        kw_only=True,
    )
    restitution: Number = field(
        "Coefficient of restitution of stops: speed after an impact over speed before it",
        unit="1",
        least=0,
        most=1,
        default=RESTITUTION,
        kw_only=True,
    )
    losses: Flag = field(
        "Whether to include damping, dry friction and springs of the file",
        default=True,
        kw_only=True,
    )
    actuators: Flag = field(
        "Whether to include motors and servos of the file, each with an input of its name",
        default=True,
        kw_only=True,
    )
    contact: RobotContact = field(
        "Whether its links touch one another and the planes of its file: no, by the law of the "
        "material, or by the words of the file",
        default=False,
        kw_only=True,
    )
    at: AnyField = field(
        "Initial coordinates of joints by their names in the file, rad or m; by default zero, or "
        "the limit nearest to it",
        form="robot starts",
        noun="dict of str to float",
        default=None,
        kw_only=True,
    )
    bodies: Mapping[str, RigidBody] = kept()
    joints: Mapping[str, Any] = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Build bodies and joints; add problems for unknown joints and invalid initial values."""
        robot: Robot = self.robot
        given: Any = {} if self.at is None else self.at
        own: Any = self.prefix
        prefix: str = f"{self.name}_" if own is None else own
        if any(c in str(prefix) for c in "./"):
            problems.add(where, f"prefix is {prefix!r}, must contain no '.' and no '/'", "prefix")
        if not isinstance(given, Mapping):
            problems.add(
                where, f"at is {given!r}, must be a mapping of names of joints to numbers", "at"
            )
        else:
            wrong = Problems()
            given = by_joint(given)
            check_joints(wrong, robot, {"at": given}, self.stops)
            for one in wrong.found:
                problems.add(where, str(one))
        if problems.found:
            return
        base: Any = self.base
        if base is not None:
            robot = replace(robot, fixed_base=True)
        robot = with_actuators(robot, self.actuators, ())
        marker = ground["origin"] if base is None else base
        seat = Seat(marker, Frame(self.position, rotation_matrix(self.orientation)))
        try:
            made = build_robot(
                with_prefix(robot, prefix),
                seat,
                at={f"{prefix}{name}": x for name, x in given.items()},
                stops=(self.stops, self.restitution),
                losses=self.losses,
                prefix=prefix,
            )
        except InputError as error:
            problems.found.extend(error.problems)
            return
        bodies = {name.removeprefix(prefix): body for name, body in made.bodies.items()}
        joints = {name.removeprefix(prefix): joint for name, joint in made.joints.items()}
        kept = {"prefix": prefix, "bodies": bodies, "joints": joints, "at": dict(given)}
        for key, value in kept.items():
            frozen = Frozen(value) if isinstance(value, dict) else value
            object.__setattr__(self, key, frozen)
        object.__setattr__(self, "_seat", seat)
        named = with_prefix(robot, prefix)
        touch = (
            contacts_of(
                *(named, made.bodies, seat, robot.gravity, f"{prefix}contacts"),
                law=str(self.contact),
            )
            if self.contact
            else []
        )
        object.__setattr__(self, "items", (*made.items, *touch))

    @property
    def shapes(self) -> tuple[CollisionShape, ...]:
        """Shapes of its links, of the group of its name, for `Contacts` of the machine."""
        seat: Seat = vars(self)["_seat"]
        found = []
        for link in self.robot.links:
            body = self.bodies.get(link.name)
            for one in link.collisions:
                at = one.frame
                marker = seat.at(at) if body is None else body.at(at.r, at.A)
                name = f"{self.prefix}{one.name}"
                found.append(CollisionShape(name, marker, one.shape, group=self.name))
        return tuple(found)

    @property
    def apart(self) -> tuple[Apart, ...]:
        """Pairs of its shapes that never touch, by the masks and excluded pairs of its file."""
        return tuple(
            Apart(f"{self.prefix}{a}", f"{self.prefix}{b}") for a, b in excluded_shapes(self.robot)
        )

    @property
    def frames(self) -> tuple[str, ...]:
        """Names of its links and of the frames on them."""
        named = [name for link in self.robot.links for name in (link.name, *link.frames)]
        return tuple(dict.fromkeys(named))

    @property
    def named(self) -> dict[str, Marker]:
        """Markers of links and named frames, with the axes of the file, by prefixed names."""
        return {f"{self.prefix}{name}": self[name] for name in self.frames}

    def __getitem__(self, name: str) -> Marker:
        """Return the marker of a link or a named frame, with the axes of the file.

        Raises
        ------
        UnknownNameError
            If there is no such frame; the message contains the nearest name.
        """
        for link in self.robot.links:
            if name == link.name or name in link.frames:
                frame = Frame() if name == link.name else link.frames[name]
                body = self.bodies.get(link.name)
                if body is not None:
                    return body.at(frame.r, frame.A, name)
                seat: Seat = vars(self)["_seat"]
                return seat.at(frame)
        raise UnknownNameError(
            Problem(f"robot {self.name!r}", f"no frame {name!r}{suggest(name, self.frames)}")
        )

    def __repr__(self) -> str:
        moving = sum(bool(joint.coordinates) for joint in self.joints.values())
        base: Any = self.base
        label = "the ground" if base is None else base.label
        what = f"{len(self.bodies)} bodies, {moving} joints, on {label}"
        return f"<RobotInMechanism {self.name!r}: {what}>"


def with_prefix(robot: Robot, prefix: str) -> Robot:
    """Return a robot with a prefix on the names of links and joints, but not of frames."""
    links = tuple(replace(link, name=f"{prefix}{link.name}") for link in robot.links)
    joints = tuple(
        replace(
            joint,
            name=f"{prefix}{joint.name}",
            parent=f"{prefix}{joint.parent}",
            child=f"{prefix}{joint.child}",
            mimic=joint.mimic and replace(joint.mimic, joint=f"{prefix}{joint.mimic.joint}"),
        )
        for joint in robot.joints
    )
    loops = tuple(
        replace(
            joint,
            name=f"{prefix}{joint.name}",
            parent=f"{prefix}{joint.parent}",
            child=f"{prefix}{joint.child}",
        )
        for joint in robot.loops
    )
    actuators = tuple(
        replace(one, name=f"{prefix}{one.name}", joint=f"{prefix}{one.joint}")
        for one in robot.actuators
    )
    return replace(robot, links=links, joints=joints, loops=loops, actuators=actuators)
