"""What is collected from an MJCF model and those that are attached to it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from jousto.base.rotations import exp_rotation
from jousto.robots.description import Actuator, Frame, Link, RobotJoint
from jousto.robots.readers.xml import Element


@dataclass
class Site:
    """A named frame: its link and where it is there."""

    link: str
    frame: Frame


@dataclass
class Collected:
    """What is found in a model and those that are attached to it.

    Attributes
    ----------
    links, joints, loops, actuators
        As of `Robot`.
    sites : dict of str to Site
        By their names.
    springs : dict of str to (float, float)
        ``springdamper`` of joints: time constant, s, and damping ratio.
    lifted : dict of str to float
        ``gravcomp`` of bodies.
    names : set of str
        Those that are taken.
    touching : list of (Element, str, int, int)
        Geoms that can touch, their bodies, ``contype`` and ``conaffinity``.
    """

    links: list[Link] = field(default_factory=list)
    joints: list[RobotJoint] = field(default_factory=list)
    loops: list[RobotJoint] = field(default_factory=list)
    actuators: list[Actuator] = field(default_factory=list)
    sites: dict[str, Site] = field(default_factory=dict)
    springs: dict[str, tuple[float, float]] = field(default_factory=dict)
    lifted: dict[str, float] = field(default_factory=dict)
    names: set[str] = field(default_factory=set)
    touching: list[tuple[Element, str, int, int]] = field(default_factory=list)
    count: dict[str, int] = field(default_factory=dict)


def turned_back(joint: RobotJoint) -> Frame:
    """Return the frame of a body where the coordinate of its joint is 0, in that of the file."""
    size = float(np.linalg.norm(joint.axis))
    if joint.initial == 0.0 or size == 0.0:
        return Frame()
    axis = joint.axis / size
    if joint.kind == "prismatic":
        return Frame(-joint.initial * axis)
    A = exp_rotation(-joint.initial * axis)
    return Frame(joint.anchor - A @ joint.anchor, A)
