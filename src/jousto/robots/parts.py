"""What a tree is made of: bodies, ties between them and relations, of a mechanism or a robot."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.mechanism.beams.pieces import BeamNode
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.coupling import Drive
from jousto.mechanism.joints.hinges import Cylindrical, Revolute, Screw, Universal
from jousto.mechanism.joints.points import Spherical
from jousto.mechanism.joints.slides import Fixed, Planar, Prismatic
from jousto.mechanism.mechanism import Mechanism
from jousto.robots.description import Frame, Robot, RobotJoint

E3 = np.eye(3)
X_UP = E3[:, [1, 2, 0]]  # its z axis is x
Y_UP = E3[:, [2, 0, 1]]
CROSS = E3[:, [1, 2, 0]]  # axes of b in the cross of a universal joint, both angles zero

Move = tuple[Array, str, Array]
"""Axes before, "turn" or "slide" along z or "ball", and axes after."""

MOVES: dict[type[Joint], tuple[Move, ...]] = {
    Fixed: (),
    Revolute: ((E3, "turn", E3),),
    Prismatic: ((E3, "slide", E3),),
    Cylindrical: ((E3, "slide", E3), (E3, "turn", E3)),
    Screw: ((E3, "slide", E3), (E3, "turn", E3)),
    Planar: ((X_UP, "slide", X_UP.T), (Y_UP, "slide", Y_UP.T), (E3, "turn", E3)),
    Universal: ((E3, "turn", CROSS), (E3, "turn", E3)),
    Spherical: ((E3, "ball", E3),),
}
OF_ROBOT: dict[str, type[Joint]] = {
    "revolute": Revolute,
    "prismatic": Prismatic,
    "planar": Planar,
    "ball": Spherical,
    "fixed": Fixed,
}


@dataclass(frozen=True, eq=False)
class Carried:
    """A body: its mass (kg), centre (m) and inertia about it (kg m2) in its frame, and its pose."""

    name: str
    mass: float
    center: Array
    inertia: Array
    pose: Frame


@dataclass(frozen=True, eq=False)
class Tie:
    """A joint between bodies a and b, numbers from 0 or -1 for the ground, and its frames there."""

    name: str
    moves: tuple[Move, ...]
    names: tuple[str, ...]
    a: int
    b: int
    frame_a: Frame
    frame_b: Frame
    initial: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class Relation:
    """A linear relation of scalar coordinates: ``sum factor s = offset``; the last name follows."""

    name: str
    names: tuple[str, ...]
    factors: tuple[float, ...]
    offset: float


@dataclass(frozen=True, eq=False)
class Parts:
    """What a tree is made of.

    Parameters
    ----------
    bodies : tuple of Carried
        In the order of the machine.
    joints : tuple of Tie
        In the order of the machine.
    relations : tuple of Relation
        Couplings.
    gravity : (3,) array
        m/s2.
    armature : dict of str to float
        Inertia of rotors by the names of coordinates.
    limits : dict of str to (float, float)
        By the names of coordinates.
    frames : dict of str to (int, Frame)
        Named frames: number of the body, -1 for the ground, and where on it.
    """

    bodies: tuple[Carried, ...]
    joints: tuple[Tie, ...]
    relations: tuple[Relation, ...] = ()
    gravity: Array = field(default_factory=lambda: np.zeros(3))
    armature: dict[str, float] = field(default_factory=dict)
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)
    frames: dict[str, tuple[int, Frame]] = field(default_factory=dict)


def of_mechanism(mechanism: Mechanism) -> Parts:
    """Return the parts of a mechanism.

    Raises
    ------
    InputError
        If a body is flexible, or a joint is of a kind that leaves no coordinates.
    """
    problems = Problems()
    numbers: dict[int, int] = {}
    bodies: list[Carried] = []
    for body in mechanism.bodies:
        if isinstance(body, FlexibleBody | BeamNode):
            what = "is flexible" if isinstance(body, FlexibleBody) else "belongs to a beam"
            problems.add(
                f"body {body.name!r}",
                f"{what}; a tree has rigid bodies alone, read_model(..., rigid=True) makes them so",
            )
            continue
        r, A, _ = mechanism.pose(body)
        numbers[id(body)] = len(bodies)
        bodies.append(Carried(body.name, float(body.mass), body.center, body.inertia, Frame(r, A)))
    joints, relations = [], []
    for joint in mechanism.joints:
        kind = next((kind for kind in MOVES if isinstance(joint, kind)), None)
        if kind is None:
            known = ", ".join(kind.__name__ for kind in MOVES)
            problems.add(
                f"joint {joint.name!r}",
                f"is a {type(joint).__name__}; joints of a tree are {known}",
            )
            continue
        ends = [numbers.get(id(marker.body), -1) for marker in (joint.a, joint.b)]
        a, b = (placed(marker) for marker in joint.frames)
        names = tuple(s.name for s in joint.coordinates)
        if kind is Spherical:
            names = (joint.name,)
        initial = tuple(s.initial for s in joint.coordinates)
        joints.append(Tie(joint.name, MOVES[kind], names, ends[0], ends[1], a, b, initial))
        if isinstance(joint, Screw):
            thread = joint.lines[-1]
            relations.append(
                relation(joint.name, thread.coordinates, thread.factors, thread.offset)
            )
    known_names = {name for joint in joints for name in joint.names}
    for coupling in mechanism.couplings:
        line = coupling.lines[0]
        if isinstance(coupling, Drive):
            continue
        found = relation(coupling.name, line.coordinates, line.factors, line.offset)
        for name in found.names:
            if name not in known_names:
                problems.add(
                    f"coupling {coupling.name!r}", f"{name} is no coordinate of a joint of the tree"
                )
        relations.append(found)
    problems.raise_if_any()
    frames: dict[str, tuple[int, Frame]] = {}
    for i, body in enumerate(x for x in mechanism.bodies if isinstance(x, RigidBody)):
        frames |= points_of(i, body)
    return Parts(tuple(bodies), tuple(joints), tuple(relations), mechanism.gravity, frames=frames)


def points_of(number: int, body: RigidBody) -> dict[str, tuple[int, Frame]]:
    """Return the named points of a body as frames."""
    named = {"origin": np.zeros(3), "center": body.center, **body.markers}
    found = {f"{body.name}.{name}": (number, Frame(r)) for name, r in named.items()}
    return {body.name: (number, Frame()), **found}


def relation(
    name: str, coordinates: Iterable[Coordinate], factors: Sequence[float], offset: float
) -> Relation:
    """Return a relation of coordinates; two coordinates of the same function are one."""
    return Relation(
        name, tuple(s.name for s in coordinates), tuple(map(float, factors)), float(offset)
    )


def placed(marker: Marker) -> Frame:
    """Return the frame of a marker in that of its body."""
    return Frame(np.asarray(marker.position_local), np.asarray(marker.axes))


def coordinate_names(joint: RobotJoint) -> tuple[str, ...]:
    """Return the names of a joint's coordinates, as the joints of a mechanism call them."""
    own = {
        "revolute": ("angle",),
        "prismatic": ("displacement",),
        "planar": ("x", "y", "angle"),
        "ball": ("",),
    }.get(joint.kind, ())
    return tuple(f"{joint.name}.{name}".removesuffix(".") for name in own)


def of_robot(robot: Robot, gravity: Array) -> Parts:
    """Return the parts of a robot, its coordinates zero."""
    poses = zero_poses(robot)
    numbers = {link.name: i for i, link in enumerate(robot.links)}
    bodies = tuple(
        Carried(link.name, link.mass, link.center, link.inertia, poses[link.name])
        for link in robot.links
    )
    joints, relations = [], []
    armature: dict[str, float] = {}
    limits: dict[str, tuple[float, float]] = {}
    if robot.fixed_base:
        root = Tie("", (), (), -1, 0, Frame(), Frame(), ())
        joints.append(root)
    for joint in robot.joints:
        if joint.kind == "floating":
            continue
        names = coordinate_names(joint)
        a, b = numbers[joint.parent], numbers[joint.child]
        frame = joint.frame
        moves = MOVES[OF_ROBOT[joint.kind]]
        zero = (0.0,) * len(names)
        joints.append(Tie(joint.name, moves, names, a, b, joint.origin @ frame, frame, zero))
        if joint.mimic is not None:
            relations.append(mimic_relation(robot, joint))
        if joint.armature > 0.0:
            armature |= dict.fromkeys(names, joint.armature)
        if joint.bounded and len(names) == 1 and joint.kind != "ball":
            limits[names[0]] = (joint.lower, joint.upper)
    frames = {}
    for i, link in enumerate(robot.links):
        frames[link.name] = (i, Frame())
        frames[f"{link.name}.origin"] = (i, Frame())
        frames[f"{link.name}.center"] = (i, Frame(link.center))
        for name, at in link.frames.items():
            frames.setdefault(name, (i, at))
            frames[f"{link.name}.{name}"] = (i, at)
    return Parts(bodies, tuple(joints), tuple(relations), gravity, armature, limits, frames)


def mimic_relation(robot: Robot, joint: RobotJoint) -> Relation:
    """Return ``q - multiplier q_other = offset``."""
    mimic = joint.mimic
    assert mimic is not None
    other = next(x for x in robot.joints if x.name == mimic.joint)
    names = (*coordinate_names(other), *coordinate_names(joint))
    return Relation(joint.name, names, (-mimic.multiplier, 1.0), mimic.offset)


def zero_poses(robot: Robot) -> dict[str, Frame]:
    """Return the frame of each link in the world where all coordinates are zero."""
    poses = {robot.links[0].name: Frame()}
    for joint in robot.joints:
        poses[joint.child] = poses[joint.parent] @ joint.origin
    return poses
