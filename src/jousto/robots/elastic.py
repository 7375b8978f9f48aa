"""Elastic joints of robots, and the motors, servos and drives that act behind their gears."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from jousto.base.errors import Problems
from jousto.mechanism.elastic_joint import ElasticJoint
from jousto.mechanism.forces.springs import JointForce, Servo, Spring
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.coupling import Drive
from jousto.mechanism.signals.base import Signal
from jousto.robots.actuators import scaled_signal
from jousto.robots.description import Robot


def check_elastic(problems: Problems, robot: Robot, given: Mapping[str, Any]) -> None:
    """Report elastic joints that are no mappings, and those that follow others."""
    joints = {joint.name: joint for joint in robot.joints}
    for name, options in given.items():
        where = f"elastic[{name!r}]"
        if not isinstance(options, Mapping):
            problems.add(where, f"is {options!r}, must be a mapping of arguments of ElasticJoint")
        for key in ("name", "coordinate"):
            if isinstance(options, Mapping) and key in options:
                problems.add(where, f"{key} is that of the joint; leave it out", key)
        if name in joints and joints[name].mimic is not None:
            problems.add(where, "follows another joint, which has the motor")


def with_ratios(robot: Robot, given: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the arguments of elastic joints with the ratios of the only actuators on them."""
    found: dict[str, dict[str, Any]] = {}
    for name, options in given.items():
        gears = [one.gear for one in robot.actuators if one.joint == name and one.gear]
        found[name] = ({"ratio": gears[0]} if len(gears) == 1 else {}) | dict(options)
    return found


def split_armature(robot: Robot, given: Mapping[str, Any]) -> tuple[Robot, dict[str, Any]]:
    """Return the robot without the rotors of elastic joints, and the arguments with these.

    The rotor inertia of a file is reduced to the joint: ``armature = ratio^2 rotor_inertia``.
    """
    inertias = {x.name: x.armature for x in robot.joints if x.armature > 0.0}
    joints = (replace(x, armature=0.0) if x.name in given else x for x in robot.joints)
    found: dict[str, Any] = {}
    for name, options in given.items():
        found[name] = dict(options)
        ratio = options.get("ratio")
        if name in inertias and isinstance(ratio, int | float) and ratio:
            found[name].setdefault("rotor_inertia", inertias[name] / ratio**2)
    return replace(robot, joints=tuple(joints)), found


def elastic_joints(
    coordinates: Mapping[str, Coordinate], given: Mapping[str, Any]
) -> dict[str, ElasticJoint]:
    """Return the elastic joints by the names of the joints."""
    return {name: ElasticJoint(name, coordinates[name], **given[name]) for name in given}


def on_motor(item: Any, elastic: Mapping[str, ElasticJoint]) -> Any:
    """Return a force or drive along a joint as the same one on the side of its motor.

    With the ratio N: forces ``f / N``, coordinates ``N (s - s(0) - windup)``, stiffness and damping
    ``/ N^2``. Items of other joints are returned as they are.
    """
    found = [x for x in elastic.values() if x.coordinate.same_as(item.coordinate)]
    if not found:
        return item
    (joint,) = found
    N, motor = joint.ratio, joint.motor
    start = -N * (joint.coordinate.initial + joint.windup)
    if isinstance(item, Drive):
        return Drive(item.name, motor, scaled_signal(item.signal, N, start))
    if isinstance(item, JointForce):
        return JointForce(item.name, motor, scaled_signal(item.signal, 1.0 / N, 0.0))
    if isinstance(item, Servo):
        limit = None if item.limit is None else item.limit / abs(N)
        wanted: Signal = scaled_signal(item.reference, N, start)
        return Servo(item.name, motor, wanted, item.kp / N**2, item.kd / N**2, limit)
    assert isinstance(item, Spring)  # damping of a motor
    return Spring(item.name, motor, 0.0, item.damping / N**2, 0.0)
