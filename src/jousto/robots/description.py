"""Robot: links, joints, loops and actuators, as a file or table describes them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Array, skew
from jousto.base.errors import Problem
from jousto.base.object_repr import described
from jousto.base.rotations import turn_onto
from jousto.mechanism.contacts.shapes import Shape
from jousto.robots.softness import Softness

KINDS = ("revolute", "prismatic", "screw", "ball", "planar", "floating", "fixed")


@described
@dataclass(frozen=True, eq=False)
class Frame:
    """Pose of a frame in an outer frame.

    Parameters
    ----------
    r : (3,) array
        Origin in the outer frame, m.
    A : (3, 3) array
        Axes as columns, in the outer frame.
    """

    r: Array = field(default_factory=lambda: np.zeros(3))
    A: Array = field(default_factory=lambda: np.eye(3))

    def __matmul__(self, other: Frame) -> Frame:
        return Frame(self.r + self.A @ other.r, self.A @ other.A)

    def inverted(self) -> Frame:
        """Return the inverse: the pose of the outer frame in this one."""
        return Frame(-self.A.T @ self.r, self.A.T)


@dataclass(frozen=True)
class Resistance:
    """What resists a shape that touches, as in MJCF files.

    Parameters
    ----------
    drilling, rolling : float
        Lengths of the moments about the normal and across it, m.
    directions : int
        1 for no friction, 3 for friction, 4 with drilling, 6 with rolling: ``condim``.
    """

    drilling: float = 0.005
    rolling: float = 0.0001
    directions: int = 3

    def with_other(self, other: Resistance) -> Resistance:
        """Return that of a pair: the larger one of each number."""
        return Resistance(
            max(self.drilling, other.drilling),
            max(self.rolling, other.rolling),
            max(self.directions, other.directions),
        )

    def of(self, friction: float) -> dict[str, Any]:
        """Return the coefficient of friction and the lengths that act."""
        return {
            "mu_kinetic": friction if self.directions > 1 else 0.0,
            "rolling": self.rolling if self.directions > 4 else 0.0,
            "drilling": self.drilling if self.directions > 3 else 0.0,
        }


@dataclass(frozen=True, eq=False)
class Collision:
    """Shape of a link that touches others.

    Parameters
    ----------
    name : str
        Name of the shape, unique in the robot.
    shape : Shape
        Shape of `jousto.mechanism`.
    frame : Frame
        Pose of the shape, in the frame of the link.
    body : str
        Name of the body in the file, by which pairs are excluded.
    friction : float
        Coefficient of friction.
    resistance : Resistance
        Lengths of the resistance to drilling and rolling, and which of them act.
    type_bits, affinity : int
        Masks: two shapes touch if the type of one shares a bit with the affinity of the other.
    unread : tuple of str
        Words of the file on its contact that are not read.
    source : str
        What the shape was in the file, where it is not the same shape.
    added : float
        Share by which the hull of a mesh is larger than it, where the file does not ask for hulls.
    softness : Softness
        What the file contains on how it gives way where it touches.
    """

    name: str
    shape: Shape
    frame: Frame
    body: str = ""
    friction: float = 1.0
    resistance: Resistance = Resistance()
    type_bits: int = 1
    affinity: int = 1
    unread: tuple[str, ...] = ()
    source: str = ""
    added: float = 0.0
    softness: Softness = Softness()


@dataclass(frozen=True)
class ShapePair:
    """Pair of shapes that the file names: they touch whatever their masks and bodies are.

    Parameters
    ----------
    a, b : str
        Names of the shapes.
    friction : float or None
        Coefficient of friction; None: the larger one of both shapes.
    resistance : Resistance or None
        Its lengths; None: the larger ones of both shapes.
    unread : tuple of str
        Words of the file on the pair that are not read.
    soft : dict of str to value
        Fields of its softness that the file gives, in place of those of both shapes.
    """

    a: str
    b: str
    friction: float | None = None
    resistance: Resistance | None = None
    unread: tuple[str, ...] = ()
    soft: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Link:
    """Rigid link of a robot.

    Parameters
    ----------
    name : str
        Name of the link.
    mass : float
        Mass, kg; zero for a link that is only a frame.
    center : (3,) array
        Centre of mass in the frame of the link, m.
    inertia : (3, 3) array
        Inertia about the centre of mass, in the axes of the link, kg m2.
    shapes : tuple of (nt, 3, 3) arrays
        Triangles for pictures, in the frame of the link, m.
    frames : dict of str to Frame
        Named frames, in the frame of the link.
    where : str
        File and line of the link, for messages.
    lifts : tuple of (float, (3,) array)
        Masses with gravity compensation, kg, and their points, in the frame of the link, m.
    collisions : tuple of Collision
        Shapes that touch others.
    """

    name: str
    mass: float = 0.0
    center: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    shapes: tuple[Array, ...] = ()
    frames: Mapping[str, Frame] = field(default_factory=dict)
    where: str = ""
    lifts: tuple[tuple[float, Array], ...] = ()
    collisions: tuple[Collision, ...] = ()

    def __repr__(self) -> str:
        return f"<Link {self.name!r}: {self.mass:g} kg>"

    def with_link(self, other: Link, at: Frame, *, frame: bool = True) -> Link:
        """Return this link merged with another one at a frame, named after the other link."""
        mass = self.mass + other.mass
        c, d = self.center, at.r + at.A @ other.center
        # opposite masses have no centre of mass; negative masses are rejected later
        center = c if mass == 0.0 else (self.mass * c + other.mass * d) / mass
        inertia = self.inertia + at.A @ other.inertia @ at.A.T
        for m, x in ((self.mass, c - center), (other.mass, d - center)):
            inertia = inertia - m * skew(x) @ skew(x)
        frames = dict(self.frames)
        if frame:
            frames[other.name] = at
        frames.update((name, at @ inner) for name, inner in other.frames.items())
        shapes = (*self.shapes, *(at.r + shape @ at.A.T for shape in other.shapes))
        lifts = (*self.lifts, *((m, at.r + at.A @ r) for m, r in other.lifts))
        moved = (replace(one, frame=at @ one.frame) for one in other.collisions)
        return replace(
            self,
            mass=mass,
            center=center,
            inertia=inertia,
            shapes=shapes,
            frames=frames,
            lifts=lifts,
            collisions=(*self.collisions, *moved),
        )


@dataclass(frozen=True)
class Mimic:
    """Relation of a joint that follows another one: ``q = multiplier * q_other + offset``."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class RobotJoint:
    """Joint of a robot.

    Parameters
    ----------
    name : str
        Name of the joint.
    kind : {"revolute", "prismatic", "screw", "ball", "planar", "floating", "fixed"}
        Kind of motion. A continuous joint is a revolute one without limits; the coordinate of a
        screw is its angle.
    parent, child : str
        Names of the links.
    origin : Frame
        Pose of the child in the frame of the parent at coordinate zero.
    axis : (3,) array
        Axis, or normal of a planar joint, in the frame of the child.
    anchor : (3,) array
        Point of the joint in the frame of the child, m.
    lower, upper : float
        Limits of the coordinate, rad or m; infinite without limits.
    velocity, effort : float
        Limits of the rate (rad/s, m/s) and of the force (N m, N).
    damping, friction : float
        Viscous damping (N m s/rad, N s/m) and dry friction (N m, N).
    armature : float
        Rotor inertia reduced to the joint, kg m2 or kg.
    stiffness, rest : float
        Stiffness of a spring on the coordinate (N m/rad, N/m) and its unstressed coordinate.
    mimic : Mimic or None
        Relation to the joint that it follows.
    where : str
        File and line of the joint, for messages.
    initial : float
        Default initial coordinate, rad or m.
    pitch : float
        Displacement of a screw per revolution, m.
    """

    name: str
    kind: str
    parent: str
    child: str
    origin: Frame = field(default_factory=Frame)
    axis: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    anchor: Array = field(default_factory=lambda: np.zeros(3))
    lower: float = -math.inf
    upper: float = math.inf
    velocity: float = math.inf
    effort: float = math.inf
    damping: float = 0.0
    friction: float = 0.0
    armature: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    mimic: Mimic | None = None
    where: str = ""
    initial: float = 0.0
    pitch: float = 0.0

    def __repr__(self) -> str:
        return f"<RobotJoint {self.name!r}: {self.kind}, {self.parent} - {self.child}>"

    @property
    def frame(self) -> Frame:
        """Frame of the joint, with its z axis along the joint axis, in the frame of the child."""
        if self.kind in ("revolute", "prismatic", "screw", "planar"):
            return Frame(self.anchor, turn_onto(np.eye(3), self.axis))
        return Frame(self.anchor)

    @property
    def bounded(self) -> bool:
        """Whether the joint has a limit."""
        return math.isfinite(self.lower) or math.isfinite(self.upper)


@dataclass(frozen=True)
class Actuator:
    """Motor or servo of a robot with a control signal u.

    The force on the joint is ``g (gain u + b0 + b1 g q + b2 g q')`` with the gear ratio g, motion
    of the actuator over motion of the joint.

    Parameters
    ----------
    name : str
        Name of the actuator and of its input.
    joint : str
        Name of the joint on which it acts.
    gear, gain : float
        Gear ratio g, and force per unit of the signal.
    bias : (float, float, float)
        b0 (N or N m), b1 (per coordinate) and b2 (per rate) of the actuator.
    limit : float
        Largest force of the actuator before the gear, N or N m.
    where : str
        File and line of the actuator, for messages.
    """

    name: str
    joint: str
    gear: float = 1.0
    gain: float = 1.0
    bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    limit: float = math.inf
    where: str = ""


@dataclass(frozen=True, eq=False)
class Robot:
    """Robot as a file or a table describes it: a tree of links, and joints that close loops.

    Parameters
    ----------
    name : str
        Name of the robot.
    links : tuple of Link
        Links: the root first, then every link after its parent.
    joints : tuple of RobotJoint
        Joints in the order of their child links.
    fixed_base : bool
        Whether the root is fixed to the ground; otherwise it moves freely.
    odd : tuple of Problem
        Warnings of the reader.
    source : Path or None
        Path of the file.
    gravity : (3,) array
        Gravitational acceleration, m/s2.
    loops : tuple of RobotJoint
        Joints that close loops of the tree; they have no coordinates of their own.
    actuators : tuple of Actuator
        Motors and servos.
    apart : tuple of (str, str)
        Bodies of the file that do not touch each other.
    pairs : tuple of ShapePair
        Pairs of shapes that touch in any case.
    untouching : tuple of str
        Shapes of the file that would touch, but cannot, with the reason.
    """

    name: str
    links: tuple[Link, ...]
    joints: tuple[RobotJoint, ...]
    fixed_base: bool = True
    odd: tuple[Problem, ...] = ()
    source: Path | None = None
    gravity: Array = field(default_factory=lambda: np.array([0.0, 0.0, -9.81]))
    loops: tuple[RobotJoint, ...] = ()
    actuators: tuple[Actuator, ...] = ()
    apart: tuple[tuple[str, str], ...] = ()
    pairs: tuple[ShapePair, ...] = ()
    untouching: tuple[str, ...] = ()

    def __repr__(self) -> str:
        moving = sum(joint.kind != "fixed" for joint in self.joints)
        return f"<Robot {self.name!r}: {len(self.links)} links, {moving} moving joints>"

    @property
    def mass(self) -> float:
        """Mass of all links, kg."""
        return sum(link.mass for link in self.links)

    @property
    def shape_facts(self) -> list[tuple[str, str]]:
        """Lines on each shape that touches others, and on those of the file that cannot."""
        rows = []
        for link in self.links:
            for one in link.collisions:
                text = one.source or str(one.shape).strip("<>")
                rows.append((f"shape {one.name}", f"{text}, on {link.name}"))
        return [*rows, *(("touches nothing", text) for text in self.untouching)]
