"""Mechanisms of robots: bodies, joints, rotors, and initial coordinates of joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.base.numbers import number
from jousto.mechanism.bodies.body import RigidBody, ground
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.elastic_joint import ElasticJoint
from jousto.mechanism.forces.contact import Contact
from jousto.mechanism.forces.contact_set import Contacts
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.forces.springs import JointForce
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.coupling import Drive
from jousto.mechanism.joints.slides import Fixed
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.scalar import CoordinateSensor
from jousto.mechanism.signals.base import check_signal
from jousto.robots.actuators import actuator_forces, with_actuators
from jousto.robots.contact_law import MATERIAL, RobotContact
from jousto.robots.contacts import robot_contacts
from jousto.robots.description import Collision, Frame, Link, Robot
from jousto.robots.elastic import (
    check_elastic,
    elastic_joints,
    on_motor,
    split_armature,
    with_ratios,
)
from jousto.robots.joint_limits import RESTITUTION, effective_inertias, joint_forces, limits_of
from jousto.robots.joints import couplings, gravity_compensation, make_joint, make_loops, rotor
from jousto.robots.kinematics.tree import Tree
from jousto.robots.root_pose import Seat

SINGLE = ("revolute", "prismatic", "screw")
SHARE = 1e-6  # mass given to a link without mass, relative to the mass of its children


@dataclass(frozen=True, eq=False)
class RobotItems:
    """Bodies, joints and coordinates of the mechanism of a robot.

    Parameters
    ----------
    bodies, joints : dict
        Bodies and joints by the names of links and joints.
    coordinates : dict
        Coordinates of joints with one coordinate, by name.
    items : tuple
        All items of the mechanism.
    elastic : dict
        Elastic joints by the names of the joints.
    """

    bodies: Mapping[str, RigidBody]
    joints: Mapping[str, Any]
    coordinates: Mapping[str, Coordinate]
    items: tuple[Any, ...]
    elastic: Mapping[str, ElasticJoint]


@explained
def mechanism(
    robot: Robot,
    *,
    gravity: ArrayLike | None = None,
    at: Mapping[str, float] | None = None,
    stops: bool | float = True,
    restitution: float = RESTITUTION,
    losses: bool = True,
    drives: Mapping[str, Any] | None = None,
    efforts: Mapping[str, Any] | None = None,
    actuators: bool = True,
    elastic: Mapping[str, Mapping[str, Any]] | None = None,
    contact: bool | str = False,
) -> Mechanism:
    """Return the mechanism of a robot, with the joint coordinates of the file.

    A joint of the robot becomes a joint of the same name, a link becomes a body; a link without
    mass gets a millionth of the mass and inertia of its children. A mimic joint has a `Coupling`. A
    rotor (armature) becomes a wheel on the ground coupled to its joint. Each joint with one
    coordinate has a `CoordinateSensor` of its name.

    A limit becomes a `Stop`, ``k = max(M (2 pi 50 Hz)^2, effort / 0.01 rad)`` (1 mm for slides),
    with the effective inertia M of the joint at coordinate zero. Its restitution applies to impacts
    above 0.1 rad/s or 20 mm/s, or above a twentieth of the largest rate of the joint.

    Parameters
    ----------
    robot : Robot
        Robot from `read_urdf` or another reader.
    gravity : (3,) array_like, optional
        Gravitational acceleration, m/s2; None: gravity of the robot, (0, 0, -9.81) in most files.
    at : dict of str to float, optional
        Initial coordinates, rad or m, by names of joints or of coordinates (``elbow.angle``). The
        default is the initial value of a drive, or zero, or the limit nearest to zero.
    stops : bool or float
        Whether limits are stops; a number is their stiffness, N m/rad or N/m.
    restitution : float
        Coefficient of restitution of stops: speed after an impact over speed before it.
    losses : bool
        Whether to include damping, dry friction and springs of the joints. Dry friction has its
        full value above 0.01 rad/s or 1 mm/s, or above the speed that it stops in 2 ms.
    drives : dict of str to Signal, optional
        Prescribed coordinates of joints by name, rad or m.
    efforts : dict of str to Signal or float, optional
        Forces on joints by name, N m or N, such as ``jo.Input("u")``.
    actuators : bool
        Whether to include motors and servos of the file, each with an `Input` of the same name with
        the initial value 0, as in MuJoCo; never those on a joint in `drives` or `efforts`.
    elastic : dict of str to dict, optional
        Motors behind elastic gears by joint: the arguments of `jo.mechanism.ElasticJoint` except
        name and coordinate. Drives, efforts and actuators of the joint, in units of the joint, then
        act on its motor. The default of ``ratio`` is that of the only actuator of the joint in the
        file, and that of ``rotor_inertia`` is ``armature / ratio^2`` of the file.
    contact : bool or {"material", "file"}
        Whether links touch one another and the world, by the shapes, masks, excluded pairs and
        friction of the file, see `jousto.robots.contacts.robot_contacts`; without it they pass
        through each other. True or "material": with one stiffness for all; "file": with that of
        the words of the file (``solref``, ``solimp``, ``margin``; ``kp``, ``kd``, ``bounce``).

    Raises
    ------
    InputError
        If a joint does not exist, does not have exactly one coordinate, or starts outside its
        limits.

    See Also
    --------
    RobotInMechanism : A robot as an assembly of a larger machine.
    """
    touching = contact_word(contact)
    asked = {"at": at, "drives": drives, "efforts": efforts, "elastic": elastic}
    given = {key: dict(value or {}) for key, value in asked.items()}
    given["at"] = by_joint(given["at"])
    problems = Problems()
    check_joints(problems, robot, given, stops)
    check_elastic(problems, robot, given["elastic"])
    drives_of = {x: check_signal(problems, "drives", x, y) for x, y in given["drives"].items()}
    problems.raise_if_any()
    seat = Seat(ground["origin"])
    begins = {x: float(signal(0.0)) for x, signal in drives_of.items() if signal is not None}
    start = given["at"] | begins
    weight = robot.gravity if gravity is None else np.asarray(gravity, dtype=np.float64)
    elastic = with_ratios(robot, given["elastic"])
    robot = with_actuators(robot, actuators, {**given["drives"], **given["efforts"]})
    robot, gears = split_armature(replace(robot, gravity=weight), elastic)
    made = build_robot(
        robot, seat, at=start, stops=(stops, restitution), losses=losses, elastic=gears
    )
    s = made.coordinates
    moved: list[Any] = [Drive(f"{name} drive", s[name], x) for name, x in given["drives"].items()]
    moved += [JointForce(f"{name} motor", s[name], x) for name, x in given["efforts"].items()]
    items = [*made.items, *(on_motor(item, made.elastic) for item in moved)]
    if touching:
        items += contacts_of(robot, made.bodies, seat, weight, law=touching)
    return Mechanism(*items, Gravity(weight), name=robot.name)


def contact_word(contact: bool | str) -> str:
    """Return the law of contact that is asked for; empty for none.

    Raises
    ------
    InputError
        For another value.
    """
    problems = Problems()
    found = RobotContact().check(problems, "", contact)
    problems.raise_if_any()
    return str(found or "")


def contacts_of(
    robot: Robot,
    bodies: Mapping[str, RigidBody],
    seat: Seat,
    gravity: Any,
    name: str = "contacts",
    law: str = MATERIAL,
) -> list[Contacts | Contact]:
    """Return the contacts of a robot; warn if it has no shapes that touch."""

    def marker_of(link: str, one: Collision) -> Marker:
        body = bodies.get(link)
        at = one.frame
        return seat.at(at) if body is None else body.at(at.r, at.A)

    weight = robot.mass * float(np.linalg.norm(gravity))
    found = robot_contacts(robot, marker_of, weight, name, law)
    if not found:
        warn(f"robot {robot.name!r}", "has no two shapes that touch, so that contact has no effect")
    return found


def build_robot(
    robot: Robot,
    seat: Seat,
    *,
    at: Mapping[str, float],
    stops: tuple[bool | float, float],
    losses: bool,
    prefix: str = "",
    elastic: Mapping[str, Any] = MappingProxyType({}),
) -> RobotItems:
    """Return the bodies, joints, forces and sensors of a robot on its base.

    Raises
    ------
    InputError
        If a joint starts outside its limits, or a moving body has no mass.
    """
    tree = Tree(replace(robot, loops=()))
    begun = initial_coordinates(tree, at, {x.name: x.kind for x in robot.joints})
    poses = initial_poses(robot, tree, begun, seat)
    bodies = make_bodies(robot, poses, seat)
    joints = make_joints(robot, bodies, seat, prefix)
    coordinates = {
        joint.name: made.coordinates[-1]  # the last coordinate, which for a screw is the angle
        for joint in robot.joints
        if joint.kind in SINGLE and (made := joints.get(joint.name)) is not None
    }
    items: list[Any] = [*bodies.values(), *joints.values(), *couplings(robot, coordinates)]
    gears = elastic_joints(coordinates, elastic)
    items += gears.values()
    inertias = effective_inertias(tree)
    limits = limits_of(robot, tree, *stops, inertias)
    for joint in robot.joints:
        items += joint_forces(joint, joints.get(joint.name), limits, inertias if losses else None)
        items += rotor(joint, coordinates)
    items += make_loops(robot, bodies, seat).values()
    items += gravity_compensation(robot, bodies)
    for actuator in robot.actuators:
        forces = actuator_forces(actuator, coordinates.get(actuator.joint))
        items += (on_motor(force, gears) for force in forces)
    items += (CoordinateSensor(name, s) for name, s in coordinates.items())
    return RobotItems(bodies, joints, coordinates, tuple(items), gears)


def check_joints(
    problems: Problems, robot: Robot, given: Mapping[str, Mapping[str, Any]], stops: bool | float
) -> None:
    """Add problems for joints that do not exist or lack a single coordinate, and invalid starts."""
    ends = ends_of(robot, stops) if given.get("at") else {}
    for key, named in given.items():
        for name, value in named.items():
            message = wrong_joint(robot, name)
            if not message and key == "at":
                message = wrong_start(robot, name, value, ends)
            if message:
                problems.add(f"{key}[{name!r}]", message)


def wrong_joint(robot: Robot, name: str) -> str:
    """Return why a joint does not have one coordinate; empty if it has one."""
    known = {joint.name: joint for joint in robot.joints}
    if name not in known:
        single = [x.name for x in robot.joints if x.kind in SINGLE]
        return f"no such joint{suggest(name, single)}"
    kind = known[name].kind
    return "" if kind in SINGLE else f"a {kind} joint has not one coordinate"


def by_joint(given: Mapping[Any, Any]) -> dict[Any, Any]:
    """Return values by joint, from names of joints or of coordinates such as ``elbow.angle``."""
    ends = (".angle", ".displacement")
    return {
        next((x[: -len(end)] for end in ends if isinstance(x, str) and x.endswith(end)), x): value
        for x, value in given.items()
    }


def ends_of(robot: Robot, stops: bool | float) -> dict[str, tuple[float, float]]:
    """Return the limits of joints, rad or m; limits of mimic joints limit the joint they follow.

    Without stops the result is empty, since joints may then start anywhere.
    """
    if stops is False:
        return {}
    tree = Tree(replace(robot, loops=()))
    limits = zip(tree.velocities, tree.lower, tree.upper, strict=True)
    return {name.rpartition(".")[0]: (float(low), float(high)) for name, low, high in limits}


def wrong_start(
    robot: Robot, name: str, value: Any, ends: Mapping[str, tuple[float, float]]
) -> str:
    """Return why a joint cannot start at a value; empty if it can; `ends` are the limits."""
    joint = next(x for x in robot.joints if x.name == name)
    problems = Problems()
    x = number(problems, "", "", value)
    if x is None:
        return problems.found[0].message.lstrip()
    turns = joint.kind == "revolute"
    unit = "rad" if turns else "m"
    if joint.mimic is not None:
        return f"the joint follows {joint.mimic.joint!r}; give the start of that joint"
    if turns and abs(x) > np.pi:
        return f"is {x:g} rad, must be within half a turn"
    lower, upper = ends.get(name, (-np.inf, np.inf))
    if not lower <= x <= upper:
        return (
            f"{x:g} {unit} is outside the limits {lower:g} and {upper:g}; start between them, or "
            "give stops=False"
        )
    return ""


def make_bodies(robot: Robot, poses: Mapping[str, Frame], seat: Seat) -> dict[str, RigidBody]:
    """Return the bodies by the names of their links, except a fixed base that is not drawn.

    A base without mass gets a millionth of the mass of its children, which has no noticeable
    effect, so that it can be drawn.
    """
    carried = carrying(robot)
    bodies = {}
    for i, link in enumerate(robot.links):
        mass, inertia, center = link.mass, link.inertia, link.center
        stands = i == 0 and robot.fixed_base
        if mass == 0.0 and stands and not link.shapes and seat.rigid:
            continue
        if mass == 0.0:
            whole = carried[link.name]
            if whole.mass == 0.0 and not stands:
                message = "neither it nor its children have a mass, which a mechanism needs"
                raise InputError(Problem(f"link {link.name!r}", message))
            mass = SHARE * (whole.mass or 1.0)
            moment = float(np.linalg.eigvalsh(whole.inertia)[-1]) or 1.0
            inertia, center = SHARE * moment * np.eye(3), np.zeros(3)
            if not stands:
                warn(
                    f"link {link.name!r}",
                    f"has no mass; as a body it gets {mass:.3g} kg, a millionth of its children",
                )
        v, w = seat.motion(poses[link.name].r)
        outline = np.concatenate(link.shapes) if link.shapes else None
        bodies[link.name] = RigidBody(
            link.name,
            mass,
            inertia,
            center=center,
            position=poses[link.name].r,
            orientation=poses[link.name].A,
            velocity=v,
            angular_velocity=w,
            markers={name: frame.r for name, frame in link.frames.items()},
            outline=outline,
        )
    return bodies


def carrying(robot: Robot) -> dict[str, Link]:
    """Return each link merged with all its descendants at zero coordinates."""
    whole = {link.name: link for link in robot.links}
    for joint in reversed(robot.joints):
        parent = whole[joint.parent]
        whole[joint.parent] = parent.with_link(whole[joint.child], joint.origin, frame=False)
    return whole


def make_joints(
    robot: Robot, bodies: Mapping[str, RigidBody], seat: Seat, prefix: str
) -> dict[str, Joint]:
    """Return the joints by name, including the one between base and carrier."""
    joints: dict[str, Joint] = {}
    root = robot.links[0]
    if robot.fixed_base and root.name in bodies:
        base = free_name(f"{prefix}base", {joint.name for joint in robot.joints})
        foot = seat.frame.inverted()
        joints[base] = Fixed(base, seat.marker, bodies[root.name].at(foot.r, foot.A))
    for joint in robot.joints:
        if joint.kind == "floating":
            continue
        above, frame = bodies.get(joint.parent), joint.origin @ joint.frame
        a = seat.at(frame) if above is None else above.at(frame.r, frame.A)
        b = bodies[joint.child].at(joint.frame.r, joint.frame.A)
        joints[joint.name] = make_joint(joint, a, b)
    return joints


def free_name(name: str, taken: set[str]) -> str:
    """Return a name that is not taken."""
    while name in taken:
        name += "_"
    return name


def initial_coordinates(
    tree: Tree, at: Mapping[str, float], kinds: Mapping[str, str]
) -> dict[str, float]:
    """Return the initial coordinates of joints: given ones, or zero moved to the nearest limit."""
    found = {name: float(x) for name, x in at.items()}
    usual = dict(zip(tree.positions, map(float, tree.initial), strict=True))
    for name, low, high in zip(tree.velocities, tree.lower, tree.upper, strict=True):
        joint = name.rpartition(".")[0]
        near = float(np.clip(usual.get(name, 0.0), low, high))
        if joint in found or near == usual.get(name, 0.0):
            continue
        if kinds.get(joint) == "prismatic" or abs(near) < np.pi:
            found[joint] = near
    return found


def initial_poses(
    robot: Robot, tree: Tree, begun: Mapping[str, float], seat: Seat
) -> dict[str, Frame]:
    """Return the poses of the links in the world at the initial coordinates."""
    q = np.array(tree.initial)
    for i, name in enumerate(tree.positions):
        q[i] = begun.get(name.rpartition(".")[0], q[i])
    places = tree.forward_kinematics(q)
    return {link.name: seat.world @ places[link.name] for link in robot.links}
