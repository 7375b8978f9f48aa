"""Contents of an MJCF model and its attached models, collected during reading."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from jousto.base.rotations import exp_rotation
from jousto.robots.description import Actuator, Collision, Frame, Link, RobotJoint
from jousto.robots.readers.xml import Element


@dataclass
class Site:
    """Named frame with its link and its pose in the link."""

    link: str
    frame: Frame


@dataclass
class Collected:
    """Contents of a model and of the models attached to it.

    Attributes
    ----------
    links, joints, loops, actuators
        As for `Robot`.
    sites : dict of str to Site
        Sites by name.
    springs : dict of str to (float, float)
        ``springdamper`` of joints: time constant, s, and damping ratio.
    lifted : dict of str to float
        ``gravcomp`` of bodies.
    names : set of str
        Used names.
    touching : list of (Element, str, int, int)
        Geoms that can touch, with body, ``contype`` and ``conaffinity``.
    collisions : dict of str to list of Collision
        Shapes that can touch, by link.
    paired : set of str
        Names of geoms in ``<pair>`` elements, which touch without masks.
    untouching : list of str
        Geoms that would touch, but cannot, with the reason.
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
    collisions: dict[str, list[Collision]] = field(default_factory=dict)
    paired: set[str] = field(default_factory=set)
    untouching: list[str] = field(default_factory=list)
    count: dict[str, int] = field(default_factory=dict)


def turned_back(joint: RobotJoint) -> Frame:
    """Return the pose of a body at coordinate 0 of its joint, relative to that in the file."""
    size = float(np.linalg.norm(joint.axis))
    if joint.initial == 0.0 or size == 0.0:
        return Frame()
    axis = joint.axis / size
    if joint.kind == "prismatic":
        return Frame(-joint.initial * axis)
    A = exp_rotation(-joint.initial * axis)
    return Frame(joint.anchor - A @ joint.anchor, A)
