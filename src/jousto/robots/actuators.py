"""Motors and servos of robots as forces with inputs."""

from __future__ import annotations

import math
from collections.abc import Container
from dataclasses import replace
from typing import Any

from jousto.base.errors import warn
from jousto.mechanism.forces.springs import JointForce, Servo, Spring
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.signals.base import Input, Signal
from jousto.robots.description import Actuator, Robot


def with_actuators(robot: Robot, whether: bool, moved: Container[str]) -> Robot:
    """Return a robot without the actuators on driven joints, or without any actuators."""
    kept = (actuator for actuator in robot.actuators if actuator.joint not in moved)
    return replace(robot, actuators=tuple(kept) if whether else ())


def actuator_forces(actuator: Actuator, s: Coordinate | None) -> list[Any]:
    """Return the forces of an actuator on the coordinate of its joint.

    ``f = g (gain u + b0 + b1 g s + b2 g s')``. For b1 < 0 it is a `Servo` with the reference
    ``(gain u + b0) / (-b1 g)``, otherwise a `JointForce`, with a damper if b2 < 0.
    """
    g, gain, (b0, b1, b2) = actuator.gear, actuator.gain, actuator.bias
    if s is None or g == 0.0:
        return []
    name = actuator.name
    if b1 > 0.0 or b2 > 0.0:
        warn(actuator.where or name, "has an unstable bias (b1 or b2 above 0) and exerts no force")
        return []
    u = Input(name)
    if b1 < 0.0:
        wanted = scaled_signal(u, gain / (-b1 * g), b0 / (-b1 * g))
        limit = g * actuator.limit
        return [
            Servo(
                name,
                s,
                wanted,
                -b1 * g * g,
                -b2 * g * g,
                abs(limit) if math.isfinite(limit) else None,
            )
        ]
    found: list[Any] = [JointForce(name, s, scaled_signal(u, g * gain, g * b0))]
    if b2 < 0.0:
        found.append(Spring(f"{name} damping", s, 0.0, -b2 * g * g, 0.0))
    return found


def scaled_signal(u: Signal, factor: float, offset: float) -> Signal:
    """Return the signal ``factor u + offset``, simplified if the factor is 1 or the offset 0."""
    made = u if factor == 1.0 else factor * u
    return made if offset == 0.0 else made + offset
