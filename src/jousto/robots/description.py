"""Robots: links and the joints between them, as a file describes them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from jousto.base.arrays import Array, skew
from jousto.base.errors import Problem
from jousto.base.object_repr import described
from jousto.base.rotations import turn_onto

KINDS = ("revolute", "prismatic", "screw", "ball", "planar", "floating", "fixed")


@described
@dataclass(frozen=True, eq=False)
class Frame:
    """Where a frame is in another.

    Parameters
    ----------
    r : (3,) array
        Its origin, m.
    A : (3, 3) array
        Its axes in columns.
    """

    r: Array = field(default_factory=lambda: np.zeros(3))
    A: Array = field(default_factory=lambda: np.eye(3))

    def __matmul__(self, other: Frame) -> Frame:
        return Frame(self.r + self.A @ other.r, self.A @ other.A)

    def inverted(self) -> Frame:
        """Return the outer frame in this one."""
        return Frame(-self.A.T @ self.r, self.A.T)


@dataclass(frozen=True, eq=False)
class Link:
    """A rigid link of a robot.

    Parameters
    ----------
    name : str
        Its name.
    mass : float
        kg; zero for a frame that only carries others.
    center : (3,) array
        Centre of mass in the frame of the link, m.
    inertia : (3, 3) array
        About the centre, in the axes of the link, kg m2.
    shapes : tuple of (nt, 3, 3) arrays
        Triangles to draw it with, in its frame, m.
    frames : dict of str to Frame
        Named frames in that of the link.
    where : str
        Where the file describes it.
    lifts : tuple of (float, (3,) array)
        Masses whose weight is compensated, kg, and where, in the frame of the link, m.
    """

    name: str
    mass: float = 0.0
    center: Array = field(default_factory=lambda: np.zeros(3))
    inertia: Array = field(default_factory=lambda: np.zeros((3, 3)))
    shapes: tuple[Array, ...] = ()
    frames: Mapping[str, Frame] = field(default_factory=dict)
    where: str = ""
    lifts: tuple[tuple[float, Array], ...] = ()

    def __repr__(self) -> str:
        return f"<Link {self.name!r}: {self.mass:g} kg>"

    def with_link(self, other: Link, at: Frame, *, frame: bool = True) -> Link:
        """Return this link with another one fixed to it at a frame, which keeps its name."""
        mass = self.mass + other.mass
        c, d = self.center, at.r + at.A @ other.center
        # equal and opposite masses have no centre; negative ones are refused
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
        return replace(
            self,
            mass=mass,
            center=center,
            inertia=inertia,
            shapes=shapes,
            frames=frames,
            lifts=lifts,
        )


@dataclass(frozen=True)
class Mimic:
    """A joint that follows another one: ``q = multiplier * q_other + offset``."""

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0


@dataclass(frozen=True, eq=False)
class RobotJoint:
    """A joint of a robot.

    Parameters
    ----------
    name : str
        Its name.
    kind : {"revolute", "prismatic", "screw", "ball", "planar", "floating", "fixed"}
        How the child moves. A continuous joint is a revolute one without limits; the coordinate
        of a screw is its angle.
    parent, child : str
        Names of the links.
    origin : Frame
        Frame of the child in that of the parent where the coordinate is zero.
    axis : (3,) array
        Axis, or normal of a planar joint, in the frame of the child.
    anchor : (3,) array
        Where the joint is, in the frame of the child, m.
    lower, upper : float
        Limits, rad or m; infinite where there are none.
    velocity, effort : float
        Largest rate (rad/s, m/s) and force (N m, N) that the file allows.
    damping, friction : float
        Viscous (N m s/rad, N s/m) and dry (N m, N).
    armature : float
        Inertia of the rotor as the joint sees it, kg m2 or kg.
    stiffness, rest : float
        Spring on the coordinate (N m/rad, N/m) and where it is relaxed.
    mimic : Mimic or None
        What it follows.
    where : str
        Where the file describes it.
    initial : float
        Where it starts unless told otherwise, rad or m.
    pitch : float
        Displacement of a screw in one turn, m.
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
        """Frame of the joint in that of the child, whose z axis is the joint's."""
        if self.kind in ("revolute", "prismatic", "screw", "planar"):
            return Frame(self.anchor, turn_onto(np.eye(3), self.axis))
        return Frame(self.anchor)

    @property
    def bounded(self) -> bool:
        """Whether it has a limit."""
        return math.isfinite(self.lower) or math.isfinite(self.upper)


@dataclass(frozen=True)
class Actuator:
    """A motor or servo of a robot with a control signal u.

    The force on the joint is ``g (gain u + b0 + b1 g q + b2 g q')``, g being the gear, rad or m of
    the actuator for one of the joint.

    Parameters
    ----------
    name : str
        Its name, that of its input.
    joint : str
        The joint it acts on.
    gear, gain : float
        Transmission ratio g, and force for one unit of the signal.
    bias : (float, float, float)
        b0 (N or N m), b1 and b2 (of its own length and rate).
    limit : float
        Largest force of the actuator, N or N m, before the gear.
    where : str
        Where the file describes it.
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
    """A robot as a file or a table describes it: a tree of links, and what closes loops.

    Parameters
    ----------
    name : str
        Its name.
    links : tuple of Link
        The root first, then every link after the one that carries it.
    joints : tuple of RobotJoint
        In the order of the links that they carry, without the root.
    fixed_base : bool
        Whether the root is fixed to the ground; else it moves freely.
    odd : tuple of Problem
        What is odd in the file but can be run; it was warned of.
    source : Path or None
        The file.
    gravity : (3,) array
        Acceleration of free fall, m/s2.
    loops : tuple of RobotJoint
        Joints that close loops between links of the tree, without coordinates of their own.
    actuators : tuple of Actuator
        Motors and servos.
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

    def __repr__(self) -> str:
        moving = sum(joint.kind != "fixed" for joint in self.joints)
        return f"<Robot {self.name!r}: {len(self.links)} links, {moving} moving joints>"

    @property
    def mass(self) -> float:
        """Mass of all links, kg."""
        return sum(link.mass for link in self.links)
