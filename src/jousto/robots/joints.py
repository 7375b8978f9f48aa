"""Joints, loop joints, couplings, rotors and gravity compensation of the mechanism of a robot."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.errors import warn
from jousto.mechanism.bodies.body import RigidBody, ground
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.forces.loads import Force
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.coupling import Coupling
from jousto.mechanism.joints.hinges import Revolute
from jousto.robots.description import Robot, RobotJoint
from jousto.robots.kinematics.topology import OF_ROBOT
from jousto.robots.root_pose import Seat


def make_joint(joint: RobotJoint, a: Marker, b: Marker) -> Joint:
    """Return the mechanism's joint between two frames for a joint of a robot."""
    kind: Any = OF_ROBOT[joint.kind]
    own = {"pitch": joint.pitch} if joint.kind == "screw" else {}
    # as_placed=False: the coordinate is zero where the frames coincide, not at the initial pose
    made: Joint = kind(joint.name, a, b, as_placed=False, **own)
    return made


def make_loops(robot: Robot, bodies: Mapping[str, RigidBody], seat: Seat) -> dict[str, Joint]:
    """Return the mechanism's joints that close loops, by name."""
    made = {}
    for joint in robot.loops:
        ends = []
        for name, frame in (
            (joint.parent, joint.origin @ joint.frame),
            (joint.child, joint.frame),
        ):
            body = bodies.get(name)
            ends.append(seat.at(frame) if body is None else body.at(frame.r, frame.A))
        made[joint.name] = make_joint(joint, *ends)
    return made


def gravity_compensation(robot: Robot, bodies: Mapping[str, RigidBody]) -> list[Force]:
    """Return the forces of gravity compensation."""
    found = []
    for link in robot.links:
        for i, (mass, r) in enumerate(link.lifts):
            if link.name in bodies and np.any(robot.gravity != 0.0):
                name = f"{link.name} compensation {i + 1}" if i else f"{link.name} compensation"
                found.append(Force(name, bodies[link.name].at(r), -mass * robot.gravity))
    return found


def couplings(robot: Robot, coordinates: Mapping[str, Coordinate]) -> list[Coupling]:
    """Return the couplings of the joints that follow others (mimic)."""
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


def rotor(joint: RobotJoint, coordinates: Mapping[str, Coordinate]) -> list[Any]:
    """Return a wheel on the ground coupled to a joint as its rotor, 1 rad per m of slide."""
    if joint.armature == 0.0:
        return []
    if joint.name not in coordinates:
        warn(f"joint {joint.name!r}", f"the armature of a {joint.kind} joint is ignored")
        return []
    s, J = coordinates[joint.name], joint.armature
    body = RigidBody(f"{joint.name} rotor".replace(".", "_"), J, (J, J, J))
    made = Revolute(f"{joint.name} bearing", ground["origin"], body["origin"])
    own = made.coordinates[0]
    return [body, made, Coupling(f"{joint.name} gearing", [s, own], [-1.0, 1.0], -s.initial)]
