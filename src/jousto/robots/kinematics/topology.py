"""Topology of a tree: bodies, joints, loop joints and relations of a mechanism or a robot."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.mechanism.beams.discretisation import BeamNode
from jousto.mechanism.bodies.body import FlexibleBody, RigidBody
from jousto.mechanism.bodies.inertia import rigid_inertia
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate, Line
from jousto.mechanism.joints.coupling import Drive
from jousto.mechanism.joints.hinges import Cylindrical, Revolute, Screw, Universal
from jousto.mechanism.joints.points import Spherical
from jousto.mechanism.joints.slides import Fixed, Planar, Prismatic
from jousto.mechanism.mechanism import Mechanism
from jousto.model.loop_joints import spanning
from jousto.robots.description import Frame, Robot, RobotJoint
from jousto.robots.kinematics.loop_joints import Closure, Measured, Place, Sum

E3 = np.eye(3)
X_UP = E3[:, [1, 2, 0]]  # axes with z along x
Y_UP = E3[:, [2, 0, 1]]
CROSS = E3[:, [1, 2, 0]]  # axes of b in the cross of a universal joint, both angles zero

Move = tuple[Array, str, Array]
"""Axes before the motion, its kind ("turn" or "slide" along z, or "ball"), and axes after it."""

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
    "screw": Screw,
    "planar": Planar,
    "ball": Spherical,
    "fixed": Fixed,
}


@dataclass(frozen=True, eq=False)
class Carried:
    """Body of a tree: mass, centre of mass, inertia about it, in its frame, and its pose; SI."""

    name: str
    mass: float
    center: Array
    inertia: Array
    pose: Frame


@dataclass(frozen=True, eq=False)
class Tie:
    """Joint between bodies a and b (index, -1 for the ground), with its frames on them."""

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
    """Relation of scalar coordinates ``sum factor s = offset``, which eliminates the last one."""

    name: str
    names: tuple[str, ...]
    factors: tuple[float, ...]
    offset: float


@dataclass(frozen=True, eq=False)
class Parts:
    """Bodies, joints, couplings and limits of a tree.

    Parameters
    ----------
    bodies : tuple of Carried
        Bodies in the order of the machine.
    joints : tuple of Tie
        Joints in the order of the machine.
    relations : tuple of Relation
        Couplings.
    gravity : (3,) array
        Gravitational acceleration, m/s2.
    armature : dict of str to float
        Rotor inertia by name of the coordinate.
    limits : dict of str to (float, float)
        Limits by name of the coordinate.
    frames : dict of str to (int, Frame)
        Named frames: index of the body, -1 for the ground, and pose on it.
    closures : tuple of Closure
        Joints and couplings outside the tree.
    measured : dict of str to Measured
        Coordinates of these joints.
    size : float
        Size of the machine including its distance from the origin, m.
    """

    bodies: tuple[Carried, ...]
    joints: tuple[Tie, ...]
    relations: tuple[Relation, ...] = ()
    gravity: Array = field(default_factory=lambda: np.zeros(3))
    armature: dict[str, float] = field(default_factory=dict)
    limits: dict[str, tuple[float, float]] = field(default_factory=dict)
    frames: dict[str, tuple[int, Frame]] = field(default_factory=dict)
    closures: tuple[Closure, ...] = ()
    measured: dict[str, Measured] = field(default_factory=dict)
    size: float = 1.0


def of_mechanism(mechanism: Mechanism) -> Parts:
    """Return the parts of a mechanism; in each loop the joint with the fewest rows is cut.

    Raises
    ------
    InputError
        If a body is a beam.
    """
    problems = Problems()
    numbers: dict[int, int] = {}
    bodies: list[Carried] = []
    frames: dict[str, tuple[int, Frame]] = {}
    for body in mechanism.bodies:
        if isinstance(body, BeamNode):
            message = "belongs to a beam; a tree has no exact beams, remove it"
            problems.add(f"body {body.name!r}", message)
            continue
        r, A, _ = mechanism.pose(body)
        numbers[id(body)] = len(bodies)
        if isinstance(body, FlexibleBody):
            mass = float(body.reduced.invariants.mass)
            center, inertia = rigid_inertia(body.reduced.invariants)
        else:
            mass, center, inertia = float(body.mass), body.center, body.inertia
        frames |= points_of(len(bodies), body, center)
        bodies.append(Carried(body.name, mass, center, inertia, Frame(r, A)))
    problems.raise_if_any()
    look = _Look(numbers)
    for one in mechanism.assemblies:
        frames = {name: look.place(marker) for name, marker in one.named.items()} | frames
    kinds = [next((kind for kind in MOVES if isinstance(j, kind)), None) for j in mechanism.joints]
    known = [k for k, kind in enumerate(kinds) if kind is not None]
    edges = [(*look.ends(mechanism.joints[k]), mechanism.joints[k].rows) for k in known]
    kept = {known[i] for i in spanning(edges)}
    joints, relations, closures = [], [], []
    for k, (joint, kind) in enumerate(zip(mechanism.joints, kinds, strict=True)):
        if kind is None or k not in kept:
            closures.append(look.closure(joint))
            continue
        joints.append(look.tie(joint, kind))
        if isinstance(joint, Screw):
            relations.append(relation(joint.name, joint.lines[-1]))
    look.own = {name for joint in joints for name in joint.names}
    for coupling in mechanism.couplings:
        if isinstance(coupling, Drive):
            continue
        line = coupling.lines[0]
        if all(s.name in look.own for s in line.coordinates):
            relations.append(relation(coupling.name, line))
        else:
            closures.append(Closure(coupling.name, lines=(look.line(line),)))
    measured = {
        s.name: look.measured(s)
        for k, joint in enumerate(mechanism.joints)
        if k not in kept
        for s in joint.coordinates
    }
    return Parts(
        tuple(bodies),
        tuple(joints),
        tuple(relations),
        mechanism.gravity,
        frames=frames,
        closures=tuple(closures),
        measured=measured,
        size=max(mechanism.size, *(float(np.linalg.norm(body.pose.r)) for body in bodies), 0.0),
    )


class _Look:
    """Converter of joints and coordinates of a mechanism, with indices of its bodies."""

    def __init__(self, numbers: dict[int, int]) -> None:
        self.numbers = numbers
        self.own: set[str] = set()  # names of the coordinates of the tree

    def place(self, marker: Marker) -> Place:
        """Return body index (-1 for the ground) and frame of a marker."""
        return self.numbers.get(id(marker.body), -1), marker_frame(marker)

    def ends(self, joint: Joint) -> tuple[int, int]:
        """Return the indices of the bodies of a joint."""
        a, b = (self.place(marker)[0] for marker in (joint.a, joint.b))
        return a, b

    def tie(self, joint: Joint, kind: type[Joint]) -> Tie:
        """Return a joint as a joint of the tree."""
        (a, frame_a), (b, frame_b) = (self.place(marker) for marker in joint.frames)
        names = tuple(s.name for s in joint.coordinates)
        if kind is Spherical:
            names = (joint.name,)
        initial = tuple(s.initial for s in joint.coordinates)
        return Tie(joint.name, MOVES[kind], names, a, b, frame_a, frame_b, initial)

    def closure(self, joint: Joint) -> Closure:
        """Return a joint as a closure outside the tree."""
        a, b = (self.place(marker) for marker in joint.frames)
        lines = tuple(self.line(line) for line in joint.lines)
        return Closure(joint.name, a, b, joint.coincident, joint.perpendicular, lines)

    def line(self, line: Line) -> Sum:
        """Return a linear relation of coordinates as a constraint row."""
        terms = tuple(self.measured(s) for s in line.coordinates)
        return Sum(terms, tuple(map(float, line.factors)), float(line.offset))

    def measured(self, s: Coordinate) -> Measured:
        """Return a coordinate of the mechanism as one of the tree or between frames."""
        if s.name in self.own:
            return Measured(s.name, s.engine)
        return Measured(s.name, s.engine, s.column, self.place(s.a), self.place(s.b))


def points_of(
    number: int, body: RigidBody | FlexibleBody, center: Array
) -> dict[str, tuple[int, Frame]]:
    """Return the named points of a rigid body, or named nodes of a flexible one, as frames."""
    own = body.markers if isinstance(body, RigidBody) else body.reduced.named_nodes
    named = {"origin": np.zeros(3), "center": center, **own}
    found = {f"{body.name}.{name}": (number, Frame(r)) for name, r in named.items()}
    return {body.name: (number, Frame()), **found}


def relation(name: str, line: Line) -> Relation:
    """Return a relation of coordinates, with equal coordinates combined."""
    factors = tuple(map(float, line.factors))
    return Relation(name, tuple(s.name for s in line.coordinates), factors, float(line.offset))


def marker_frame(marker: Marker) -> Frame:
    """Return the pose of a marker in its body."""
    return Frame(np.asarray(marker.position_local), np.asarray(marker.axes))


def coordinate_names(joint: RobotJoint) -> tuple[str, ...]:
    """Return the names of the coordinates of a joint, equal to those of a mechanism's joint."""
    own = {
        "revolute": ("angle",),
        "prismatic": ("displacement",),
        "screw": ("displacement", "angle"),
        "planar": ("x", "y", "angle"),
        "ball": ("",),
    }.get(joint.kind, ())
    return tuple(f"{joint.name}.{name}".removesuffix(".") for name in own)


def of_robot(robot: Robot, gravity: Array) -> Parts:
    """Return the parts of a robot at zero coordinates."""
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
        zero = (joint.initial,) * len(names)
        joints.append(Tie(joint.name, moves, names, a, b, joint.origin @ frame, frame, zero))
        if joint.mimic is not None:
            relations.append(mimic_relation(robot, joint))
        if joint.kind == "screw":
            slide, turn = names
            lead = joint.pitch / (2.0 * np.pi)
            relations.append(Relation(joint.name, (turn, slide), (-lead, 1.0), 0.0))
        if joint.armature > 0.0:
            armature |= dict.fromkeys(names, joint.armature)
        if joint.bounded and len(names) == 1 and joint.kind != "ball":
            limits[names[0]] = (joint.lower, joint.upper)
    frames: dict[str, tuple[int, Frame]] = {}
    for i, link in enumerate(robot.links):
        frames[link.name] = (i, Frame())
        frames[f"{link.name}.origin"] = (i, Frame())
        frames[f"{link.name}.center"] = (i, Frame(link.center))
        for name, at in link.frames.items():
            frames.setdefault(name, (i, at))
            frames[f"{link.name}.{name}"] = (i, at)
    closures = tuple(closure_of(joint, numbers) for joint in robot.loops)
    return Parts(
        bodies, tuple(joints), tuple(relations), gravity, armature, limits, frames, closures
    )


def closure_of(joint: RobotJoint, numbers: dict[str, int]) -> Closure:
    """Return a loop joint of a robot as a closure."""
    frame, kind = joint.frame, OF_ROBOT[joint.kind]
    a = (numbers[joint.parent], joint.origin @ frame)
    b = (numbers[joint.child], frame)
    across = {Prismatic: (0, 1), Planar: (2,)}.get(kind, ())
    lines = tuple(
        Sum((Measured(f"{joint.name} {i}", "along", i, a, b),), (1.0,), 0.0) for i in across
    )
    return Closure(joint.name, a, b, kind.coincident, kind.perpendicular, lines)


def mimic_relation(robot: Robot, joint: RobotJoint) -> Relation:
    """Return the relation ``q - multiplier q_other = offset`` of a mimic joint."""
    mimic = joint.mimic
    assert mimic is not None
    other = next(x for x in robot.joints if x.name == mimic.joint)
    names = (*coordinate_names(other), *coordinate_names(joint))
    return Relation(joint.name, names, (-mimic.multiplier, 1.0), mimic.offset)


def zero_poses(robot: Robot) -> dict[str, Frame]:
    """Return the pose of each link in the world at zero coordinates."""
    poses = {robot.links[0].name: Frame()}
    for joint in robot.joints:
        poses[joint.child] = poses[joint.parent] @ joint.origin
    return poses
