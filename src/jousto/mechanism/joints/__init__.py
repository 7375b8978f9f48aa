"""Joints connect marker a to marker b; each declares its constraint rows as data."""

from jousto.mechanism.joints.base import AxisJoint, Joint, aligned
from jousto.mechanism.joints.hinges import Cylindrical, Revolute, Screw, Universal
from jousto.mechanism.joints.points import PointOnLine, PointOnPlane, Rod, Spherical
from jousto.mechanism.joints.slides import ConstantOrientation, Fixed, Planar, Prismatic

JOINTS: tuple[type[Joint], ...] = (
    Spherical,
    Revolute,
    Fixed,
    Prismatic,
    Cylindrical,
    Universal,
    Planar,
    PointOnLine,
    PointOnPlane,
    ConstantOrientation,
    Rod,
    Screw,
)

__all__ = [
    "JOINTS",
    "AxisJoint",
    "ConstantOrientation",
    "Cylindrical",
    "Fixed",
    "Joint",
    "Planar",
    "PointOnLine",
    "PointOnPlane",
    "Prismatic",
    "Revolute",
    "Rod",
    "Screw",
    "Spherical",
    "Universal",
    "aligned",
]
