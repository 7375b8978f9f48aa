"""Mechanisms of robots: bodies, joints, losses, stops at the limits, rotors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest, warn
from jousto.mechanism.bodies.body import RigidBody, ground
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.loads import Gravity
from jousto.mechanism.forces.springs import Bushing, JointForce, Spring
from jousto.mechanism.initial import Initial
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.coupling import Coupling, Drive
from jousto.mechanism.joints.hinges import Revolute
from jousto.mechanism.joints.points import Spherical
from jousto.mechanism.joints.slides import Fixed, Prismatic
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.readings import CoordinateSensor
from jousto.mechanism.signals.piecewise import Table
from jousto.robots.description import Frame, Link, Robot, RobotJoint
from jousto.robots.parts import OF_ROBOT, zero_poses
from jousto.robots.tree import Tree

SHARE = 1e-6  # of what it carries, for a link without mass
STOP_FREQUENCY = 50.0  # Hz, of what moves against a stop
YIELD = {"rad": 0.01, "m": 1e-3}  # under the largest effort of the joint
REACH = 10.0  # rad or m beyond a limit up to which a stop grows
DRY = {"rad": 0.01, "m": 1e-3}  # rad/s or m/s at which dry friction is full, or faster, so that
SOON = 2e-3  # it takes so many seconds to come to rest


@explained
def mechanism(
    robot: Robot,
    *,
    gravity: ArrayLike | None = None,
    at: Mapping[str, float] | None = None,
    stops: bool | float = True,
    losses: bool = True,
    drives: Mapping[str, Any] | None = None,
    efforts: Mapping[str, Any] | None = None,
) -> Mechanism:
    """Return the mechanism of a robot, its coordinates counted as in the file.

    A joint of the robot is a joint of the same name, a link a body; a link without mass that
    carries others gets a millionth of their mass and inertia. A joint that follows another one
    is held by a `Coupling`. A rotor (armature) is a wheel on the ground that turns, or a mass
    that slides, with its joint; its weight does not count. Each joint with one coordinate has a
    `CoordinateSensor` of its name.

    A limit is a stop: a spring without slack, ``k = max(M (2 pi 50 Hz)^2, effort / 0.01 rad)``
    (1 mm for slides), M being the inertia that moves with the joint at its zero while the others
    are free. It gives back what it takes.

    Parameters
    ----------
    robot : Robot
        What `read_urdf` or another reader returns.
    gravity : (3,) array_like, optional
        Acceleration of free fall, m/s2; None for that of the robot, (0, 0, -9.81) in most files.
    at : dict of str to float, optional
        Where joints start, rad or m; elsewhere at zero, or at the limit that is nearest to it.
    stops : bool or float
        Whether limits are stops; a number is their stiffness, N m/rad or N/m.
    losses : bool
        Whether damping, dry friction and springs of the joints count. Dry friction is full from
        0.01 rad/s or 1 mm/s on, later where it would stop the joint in less than 2 ms.
    drives : dict of str to Signal, optional
        Joints that follow a signal, rad or m.
    efforts : dict of str to Signal or float, optional
        Forces of motors, N m or N, such as ``jo.Input("u")``.

    Raises
    ------
    InputError
        If a joint is not there, or has not one coordinate.
    """
    bodies = make_bodies(robot)
    joints = make_joints(robot, bodies)
    coordinates = {
        joint.name: made.coordinates[0]
        for joint in robot.joints
        if (made := joints.get(joint.name)) is not None and len(made.coordinates) == 1
    }
    asked = {"at": at, "drives": drives, "efforts": efforts}
    given = {key: dict(value or {}) for key, value in asked.items()}
    check_joints(robot, coordinates, given)
    items: list[Any] = [*bodies.values(), *joints.values()]
    items += couplings(robot, coordinates)
    items += (Drive(f"{name} drive", coordinates[name], x) for name, x in given["drives"].items())
    items += (
        JointForce(f"{name} motor", coordinates[name], x) for name, x in given["efforts"].items()
    )
    tree = Tree(robot)
    begun = starts(robot, tree, given["at"], set(given["drives"]))
    items += (Initial(coordinates[name], value=x) for name, x in begun.items())
    inertias = moving(tree)
    tables = limit_tables(robot, tree, stops, inertias)
    weight = Gravity(robot.gravity if gravity is None else gravity)
    for joint in robot.joints:
        items += joint_forces(joint, joints.get(joint.name), tables, inertias if losses else None)
        items += rotor(joint, coordinates, weight.acceleration)
    items += (CoordinateSensor(name, s) for name, s in coordinates.items())
    return Mechanism(
        *items, Gravity(robot.gravity if gravity is None else gravity), name=robot.name
    )


def check_joints(
    robot: Robot, coordinates: Mapping[str, Coordinate], given: Mapping[str, Mapping[str, Any]]
) -> None:
    """Raise InputError for joints that are not there or have not one coordinate."""
    problems = Problems()
    kinds = {joint.name: joint.kind for joint in robot.joints}
    for key, named in given.items():
        for name in named:
            if name not in kinds:
                problems.add(f"{key}[{name!r}]", f"no such joint{suggest(name, coordinates)}")
            elif name not in coordinates:
                problems.add(f"{key}[{name!r}]", f"a {kinds[name]} joint has not one coordinate")
    problems.raise_if_any()


def make_bodies(robot: Robot) -> dict[str, RigidBody]:
    """Return the bodies by the names of their links; a base that only stands there is left out."""
    poses = zero_poses(robot)
    carried = carrying(robot)
    bodies = {}
    for i, link in enumerate(robot.links):
        mass, inertia, center = link.mass, link.inertia, link.center
        if mass == 0.0 and i == 0 and robot.fixed_base:
            if not link.shapes:
                continue
            mass, inertia = 1.0, np.eye(3)  # held by the ground
        elif mass == 0.0:
            whole = carried[link.name]
            if whole.mass == 0.0:
                message = "neither it nor what it carries has a mass, which a mechanism needs"
                raise InputError(Problem(f"link {link.name!r}", message))
            mass = SHARE * whole.mass
            moment = float(np.linalg.eigvalsh(whole.inertia)[-1])
            inertia, center = SHARE * moment * np.eye(3), np.zeros(3)
            warn(
                f"link {link.name!r}",
                f"has no mass; as a body it gets {mass:.3g} kg, a millionth of what it carries",
            )
        outline = np.concatenate(link.shapes) if link.shapes else None
        bodies[link.name] = RigidBody(
            link.name,
            mass,
            inertia,
            center=center,
            position=poses[link.name].r,
            orientation=poses[link.name].A,
            markers={name: frame.r for name, frame in link.frames.items()},
            outline=outline,
        )
    return bodies


def carrying(robot: Robot) -> dict[str, Link]:
    """Return each link with all that it carries at zero as one body."""
    whole = {link.name: link for link in robot.links}
    for joint in reversed(robot.joints):
        parent = whole[joint.parent]
        whole[joint.parent] = parent.with_link(whole[joint.child], joint.origin, frame=False)
    return whole


def make_joints(robot: Robot, bodies: Mapping[str, RigidBody]) -> dict[str, Joint]:
    """Return the joints by name, and that of the base to the ground."""
    joints: dict[str, Joint] = {}
    root = robot.links[0]
    if robot.fixed_base and root.name in bodies:
        base = free_name("base", {joint.name for joint in robot.joints})
        joints[base] = Fixed(base, ground["origin"], bodies[root.name]["origin"])
    for joint in robot.joints:
        if joint.kind == "floating":
            continue
        a = marker(bodies.get(joint.parent), joint.origin @ joint.frame)
        b = marker(bodies[joint.child], joint.frame)
        kind: Any = OF_ROBOT[joint.kind]
        joints[joint.name] = kind(joint.name, a, b)
    return joints


def marker(body: RigidBody | None, frame: Frame) -> Marker:
    """Return a marker on a body, or on the ground where the base is not a body."""
    return (ground if body is None else body).at(frame.r, frame.A)


def free_name(name: str, taken: set[str]) -> str:
    """Return a name that is not taken."""
    while name in taken:
        name += "_"
    return name


def couplings(robot: Robot, coordinates: Mapping[str, Coordinate]) -> list[Coupling]:
    """Return what holds the joints that follow others."""
    found = []
    for joint in robot.joints:
        if joint.mimic is None:
            continue
        own, k = coordinates[joint.name], joint.mimic.multiplier
        terms: tuple[Any, Any] = ([own], [1.0])
        if k != 0.0:
            terms = ([coordinates[joint.mimic.joint], own], [-k, 1.0])
        found.append(Coupling(f"{joint.name} follows", *terms, joint.mimic.offset))
    return found


def starts(robot: Robot, tree: Tree, at: Mapping[str, float], driven: set[str]) -> dict[str, float]:
    """Return where joints start: where they shall, and else within their limits."""
    found = dict(at)
    kinds = {joint.name: joint.kind for joint in robot.joints}
    for name, low, high in zip(tree.velocities, tree.lower, tree.upper, strict=True):
        joint = name.rpartition(".")[0]
        value = at.get(joint, 0.0)
        if joint in driven or low <= value <= high:
            continue
        if joint in at:
            warn(
                f"at[{joint!r}]",
                f"{value:g} lies outside the limits {low:g} and {high:g}: the stop pushes it back",
            )
        elif kinds.get(joint) == "prismatic" or abs(np.clip(0.0, low, high)) < np.pi:
            found[joint] = float(np.clip(0.0, low, high))
    return found


def moving(tree: Tree) -> dict[str, float]:
    """Return what moves with each coordinate while the others are free, at the initial pose."""
    inverse = np.diag(np.linalg.pinv(tree.mass_matrix(tree.initial)))
    inertia = 1.0 / np.maximum(inverse, 1e-300)
    return dict(zip(tree.velocities, map(float, inertia), strict=True))


def limit_tables(
    robot: Robot, tree: Tree, stops: bool | float, inertias: Mapping[str, float]
) -> dict[str, Table]:
    """Return the force of the stops over the coordinate, by the names of coordinates.

    Raises
    ------
    InputError
        If the stiffness is not a positive number.
    """
    if stops is False:
        return {}
    problems = Problems()
    if stops is not True:
        problems.positive("mechanism", "stops", stops, "N/m or N m/rad")
        problems.raise_if_any()
    efforts = {joint.name: joint.effort for joint in robot.joints}
    tables = {}
    for i, name in enumerate(tree.velocities):
        ends = tree.lower[i], tree.upper[i]
        if not np.isfinite(ends).any():
            continue
        unit = "rad" if name.endswith(".angle") else "m"
        k = inertias[name] * (2.0 * np.pi * STOP_FREQUENCY) ** 2
        effort = efforts.get(name.rpartition(".")[0], np.inf)
        k = max(k, effort / YIELD[unit]) if np.isfinite(effort) else k
        tables[name] = stop_table(*ends, k if stops is True else float(stops))
    return tables


def stop_table(lower: float, upper: float, k: float) -> Table:
    """Return a force that is zero between the limits and grows by k outside."""
    points: list[tuple[float, float]] = []
    if np.isfinite(lower):
        points += [(lower - REACH, k * REACH), (lower, 0.0)]
    if np.isfinite(upper):
        points += [(upper, 0.0), (upper + REACH, -k * REACH)]
    points = [x for i, x in enumerate(points) if i == 0 or x[0] > points[i - 1][0]]
    s, force = zip(*points, strict=True)
    return Table(s, force)


def joint_forces(
    joint: RobotJoint,
    made: Joint | None,
    tables: Mapping[str, Table],
    inertias: Mapping[str, float] | None,
) -> list[Any]:
    """Return stop and, where inertias are given, spring, damping and dry friction of a joint."""
    if made is None:
        return []
    name = f"{joint.name} limits and losses"
    if isinstance(made, Spherical):
        if inertias is None or joint.damping == joint.stiffness == 0.0:
            return []
        turn = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
        K, D = np.multiply(joint.stiffness, turn), np.multiply(joint.damping, turn)
        return [Bushing(name, made.a, made.b, K, D)]
    if not isinstance(made, Revolute | Prismatic):
        return []
    s = made.coordinates[0]
    values: dict[str, Any] = {"table": tables.get(s.name)}
    if inertias is not None:
        values |= {"damping": joint.damping, "stiffness": joint.stiffness, "free": joint.rest}
        if joint.friction > 0.0:
            f = joint.friction
            slow = max(DRY[s.unit], f * SOON / inertias.get(s.name, np.inf))
            values["damper_table"] = Table((-slow, slow), (f, -f))
    active = any(value is not None and value != 0.0 for k, value in values.items() if k != "free")
    return [Spring(name, s, **values)] if active else []


def rotor(joint: RobotJoint, coordinates: Mapping[str, Coordinate], g: Array) -> list[Any]:
    """Return a wheel or a mass on the ground that moves with a joint as its rotor.

    A mass slides across the direction of gravity g, so that its weight does no work.
    """
    if joint.armature == 0.0:
        return []
    if joint.name not in coordinates:
        warn(f"joint {joint.name!r}", f"the armature of a {joint.kind} joint is left out")
        return []
    s, J = coordinates[joint.name], joint.armature
    body = RigidBody(f"{joint.name} rotor".replace(".", "_"), J, (J, J, J))
    kind = Revolute if joint.kind == "revolute" else Prismatic
    across = np.cross(g, np.eye(3)[np.argmin(np.abs(g))])
    axis = across if across.any() else None
    made = kind(f"{joint.name} bearing", ground["origin"], body["origin"], axis=axis)
    own = made.coordinates[0]
    return [body, made, Coupling(f"{joint.name} gearing", [s, own], [-1.0, 1.0], 0.0)]
