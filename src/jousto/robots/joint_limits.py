"""Stops at the limits of joints, and springs, damping and friction of joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.numbers import number
from jousto.mechanism.forces.springs import Bushing, Spring
from jousto.mechanism.forces.stop import SLOW, Stop
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.hinges import Revolute
from jousto.mechanism.joints.points import Spherical
from jousto.mechanism.joints.slides import Prismatic
from jousto.mechanism.signals.piecewise import Table
from jousto.robots.description import Robot, RobotJoint
from jousto.robots.kinematics.tree import Tree

STOP_FREQUENCY = 50.0  # natural frequency of the effective inertia of a joint on its stop, Hz
RESTITUTION = 0.5  # default coefficient of restitution of stops
YIELD = {"rad": 0.01, "m": 1e-3}  # deflection of a stop under the largest effort of the joint
# ratio of the largest speed of the joint and the speed above which restitution applies in full
QUICK = 20.0
DRY = {"rad": 0.01, "m": 1e-3}  # smallest speed of full dry friction, rad/s or m/s
SOON = 2e-3  # shortest time in which full dry friction stops a joint, s


def effective_inertias(tree: Tree) -> dict[str, float]:
    """Return the effective inertia of each coordinate at the initial pose, kg m2 or kg."""
    inverse = np.diag(np.linalg.pinv(tree.mass_matrix(tree.initial)))
    inertia = 1.0 / np.maximum(inverse, 1e-300)
    return dict(zip(tree.velocities, map(float, inertia), strict=True))


@dataclass(frozen=True)
class Limits:
    """Parameters of the stop at the limits of a joint.

    Parameters
    ----------
    lower, upper : float
        Limits, rad or m; infinite without limits.
    stiffness : float
        Stiffness, N m/rad or N/m.
    restitution : float
        Coefficient of restitution.
    speed : float
        Impact speed from which the restitution applies, rad/s or m/s.
    """

    lower: float
    upper: float
    stiffness: float
    restitution: float
    speed: float

    def stop(self, name: str, s: Coordinate) -> Stop:
        """Return the stop on a coordinate."""
        low, high = (x if np.isfinite(x) else None for x in (self.lower, self.upper))
        rest = {"restitution": self.restitution, "speed": self.speed}
        return Stop(name, s, low, high, stiffness=self.stiffness, **rest)


def limits_of(
    robot: Robot,
    tree: Tree,
    stops: bool | float,
    restitution: float,
    inertias: Mapping[str, float],
) -> dict[str, Limits]:
    """Return the parameters of the stops by name of the coordinate.

    Raises
    ------
    InputError
        If the stiffness is not a positive number, or the restitution not between 0 and 1.
    """
    if isinstance(stops, bool | np.bool_) and not stops:
        return {}
    problems = Problems()
    whether = isinstance(stops, bool | np.bool_)
    if not whether:
        problems.positive("mechanism", "stops", stops, "N/m or N m/rad")
    e = number(problems, "mechanism", "restitution", restitution)
    if e is not None and not 0.0 <= e <= 1.0:
        problems.add("mechanism", f"restitution is {e:g}, must be between 0 and 1", "restitution")
    problems.raise_if_any()
    joints = {joint.name: joint for joint in robot.joints}
    found = {}
    for i, name in enumerate(tree.velocities):
        ends = float(tree.lower[i]), float(tree.upper[i])
        if not np.isfinite(ends).any():
            continue
        unit = "rad" if name.endswith(".angle") else "m"
        k = inertias[name] * (2.0 * np.pi * STOP_FREQUENCY) ** 2
        joint = joints[name.rpartition(".")[0]]
        k = max(k, joint.effort / YIELD[unit]) if np.isfinite(joint.effort) else k
        fast = joint.velocity if np.isfinite(joint.velocity) else 0.0
        speed = max(SLOW[unit], fast / QUICK)
        found[name] = Limits(*ends, k if whether else float(stops), float(restitution), speed)
    return found


def joint_forces(
    joint: RobotJoint,
    made: Joint | None,
    limits: Mapping[str, Limits],
    inertias: Mapping[str, float] | None,
) -> list[Any]:
    """Return the stop of a joint and, if inertias are given, its spring, damper and friction."""
    if made is None:
        return []
    if isinstance(made, Spherical):
        if inertias is None or joint.damping == joint.stiffness == 0.0:
            return []
        turn = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
        K, D = np.multiply(joint.stiffness, turn), np.multiply(joint.damping, turn)
        return [Bushing(f"{joint.name} losses", made.a, made.b, K, D)]
    if not isinstance(made, Revolute | Prismatic):
        return []
    s = made.coordinates[0]
    found: list[Any] = []
    if s.name in limits:
        found.append(limits[s.name].stop(f"{joint.name} stop", s))
    if inertias is None or joint.damping == joint.stiffness == joint.friction == 0.0:
        return found
    values: dict[str, Any] = {}
    if joint.friction > 0.0:
        f = joint.friction
        slow = max(DRY[s.unit], f * SOON / inertias.get(s.name, np.inf))
        values["damper_table"] = Table((-slow, slow), (f, -f))
    k, c = joint.stiffness, joint.damping
    return [*found, Spring(f"{joint.name} losses", s, k, c, joint.rest, **values)]
