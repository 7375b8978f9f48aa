"""Stops at the limits of joints, and what their joints lose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.mechanism.forces.springs import Bushing, Spring
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.hinges import Revolute
from jousto.mechanism.joints.points import Spherical
from jousto.mechanism.joints.slides import Prismatic
from jousto.mechanism.signals.piecewise import Table
from jousto.robots.description import Robot, RobotJoint
from jousto.robots.tree import Tree

STOP_FREQUENCY = 50.0  # Hz, of what moves against a stop
YIELD = {"rad": 0.01, "m": 1e-3}  # under the largest effort of the joint
REACH = 10.0  # rad or m beyond a limit up to which a stop grows
DRY = {"rad": 0.01, "m": 1e-3}  # rad/s or m/s at which dry friction is full, or faster, so that
SOON = 2e-3  # it takes so many seconds to come to rest


def moving(tree: Tree) -> dict[str, float]:
    """Return what moves with each coordinate while the others are free, at the initial pose."""
    inverse = np.diag(np.linalg.pinv(tree.mass_matrix(tree.initial)))
    inertia = 1.0 / np.maximum(inverse, 1e-300)
    return dict(zip(tree.velocities, map(float, inertia), strict=True))


def limit_tables(
    robot: Robot, tree: Tree, stops: bool | float, inertias: Mapping[str, float]
) -> dict[str, Table]:
    """Return the force of the stops over the coordinate, by the names of coordinates.

    Raises
    ------
    InputError
        If the stiffness is not a positive number.
    """
    if stops is False:
        return {}
    problems = Problems()
    if stops is not True:
        problems.positive("mechanism", "stops", stops, "N/m or N m/rad")
        problems.raise_if_any()
    efforts = {joint.name: joint.effort for joint in robot.joints}
    tables = {}
    for i, name in enumerate(tree.velocities):
        ends = tree.lower[i], tree.upper[i]
        if not np.isfinite(ends).any():
            continue
        unit = "rad" if name.endswith(".angle") else "m"
        k = inertias[name] * (2.0 * np.pi * STOP_FREQUENCY) ** 2
        effort = efforts.get(name.rpartition(".")[0], np.inf)
        k = max(k, effort / YIELD[unit]) if np.isfinite(effort) else k
        tables[name] = stop_table(*ends, k if stops is True else float(stops))
    return tables


def stop_table(lower: float, upper: float, k: float) -> Table:
    """Return a force that is zero between the limits and grows by k outside."""
    points: list[tuple[float, float]] = []
    if np.isfinite(lower):
        points += [(lower - REACH, k * REACH), (lower, 0.0)]
    if np.isfinite(upper):
        points += [(upper, 0.0), (upper + REACH, -k * REACH)]
    points = [x for i, x in enumerate(points) if i == 0 or x[0] > points[i - 1][0]]
    s, force = zip(*points, strict=True)
    return Table(s, force)


def joint_forces(
    joint: RobotJoint,
    made: Joint | None,
    tables: Mapping[str, Table],
    inertias: Mapping[str, float] | None,
) -> list[Any]:
    """Return stop and, where inertias are given, spring, damping and dry friction of a joint."""
    if made is None:
        return []
    name = f"{joint.name} limits and losses"
    if isinstance(made, Spherical):
        if inertias is None or joint.damping == joint.stiffness == 0.0:
            return []
        turn = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0]
        K, D = np.multiply(joint.stiffness, turn), np.multiply(joint.damping, turn)
        return [Bushing(name, made.a, made.b, K, D)]
    if not isinstance(made, Revolute | Prismatic):
        return []
    s = made.coordinates[0]
    values: dict[str, Any] = {"table": tables.get(s.name)}
    if inertias is not None:
        values |= {"damping": joint.damping, "stiffness": joint.stiffness, "free": joint.rest}
        if joint.friction > 0.0:
            f = joint.friction
            slow = max(DRY[s.unit], f * SOON / inertias.get(s.name, np.inf))
            values["damper_table"] = Table((-slow, slow), (f, -f))
    active = any(value is not None and value != 0.0 for k, value in values.items() if k != "free")
    return [Spring(name, s, **values)] if active else []
