"""Robots from Denavit-Hartenberg tables."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.errors import Problems
from jousto.base.object_repr import described
from jousto.base.rotations import exp_rotation
from jousto.mechanism.bodies.inertia import check_inertia
from jousto.robots.description import Frame, Link, Robot, RobotJoint

CONVENTIONS = ("standard", "modified")
X, Z = np.eye(3)[0], np.eye(3)[2]


@described
@dataclass(frozen=True, eq=False)
class DHRow:
    """Row of a Denavit-Hartenberg table: a joint and its child link.

    Parameters
    ----------
    a, alpha : float
        Length (m) and twist (rad) of the link.
    d, theta : float
        Offset (m) along and angle (rad) about the joint axis; the coordinate is added to theta, or
        to d of a prismatic joint.
    kind : {"revolute", "prismatic"}
        Kind of the joint.
    lower, upper : float
        Limits of the joint, rad or m.
    mass : float
        Mass of the link, kg; zero for kinematics alone.
    center : (3,) array_like
        Centre of mass in the frame of the link, m.
    inertia : (3,) or (3, 3) array_like
        Inertia about the centre of mass in the axes of the link, kg m2.
    name : str
        Name of the joint; None for ``joint1``, ``joint2`` ...
    """

    a: float
    alpha: float
    d: float = 0.0
    theta: float = 0.0
    kind: str = "revolute"
    lower: float = -math.inf
    upper: float = math.inf
    mass: float = 0.0
    center: ArrayLike = (0.0, 0.0, 0.0)
    inertia: ArrayLike = (0.0, 0.0, 0.0)
    name: str | None = None


@explained
def from_dh(rows: Sequence[Any], *, convention: str, name: str = "robot") -> Robot:
    """Return the robot of a Denavit-Hartenberg table.

    The transformation from frame i - 1 to frame i in the standard convention is
    ``Rot_z(theta_i) Trans_z(d_i) Trans_x(a_i) Rot_x(alpha_i)``: the joint axis is z of frame i - 1,
    and the frame of a link is at its distal end (Spong, Hutchinson and Vidyasagar, Robot Modeling
    and Control, 2006, eq. 3.10). In the modified convention it is ``Rot_x(alpha_i) Trans_x(a_i)
    Rot_z(theta_i) Trans_z(d_i)``, where row i has the a and alpha of index i - 1 in the book: the
    frame of a link is at its joint (Craig, Introduction to Robotics, 3rd ed., eq. 3.6).

    Parameters
    ----------
    rows : sequence of DHRow or of (a, alpha, d, theta)
        Rows from the base outward; m and rad. Links are named ``link1``, ``link2`` ...
    convention : {"standard", "modified"}
        Convention of the table; mandatory.
    name : str
        Name of the robot.

    Returns
    -------
    Robot
        Robot. Rows without mass suffice for kinematics; a mechanism needs masses.

    Raises
    ------
    InputError
        With all errors of the table.

    Examples
    --------
    An arm of two rods of 1 m in the plane, stretched along y:

    >>> import jousto as jo
    >>> robot = jo.robots.from_dh([(1, 0, 0, 0), (1, 0, 0, 0)], convention="standard")
    >>> jo.robots.Tree(robot).pose("link2", [np.pi / 2, 0]).r.round(12) + 0.0
    array([0., 2., 0.])
    """
    problems = Problems()
    if convention not in CONVENTIONS:
        problems.add("from_dh", f"convention is {convention!r}, must be 'standard' or 'modified'")
    if len(rows) == 0:
        problems.add("from_dh", "the table has no rows")
    made = [_row(problems, i, row) for i, row in enumerate(rows)]
    names = [row.name or f"joint{i + 1}" for i, row in enumerate(made)]
    for i, one in enumerate(names):
        if one in names[:i]:
            problems.add(f"rows[{i}]", f"name is {one!r}, which another row has too; rename it")
    links = [Link("base", where="base")]
    joints = []
    for i, (row, joint) in enumerate(zip(made, names, strict=True)):
        where = f"rows[{i}]"
        link = _link(problems, where, f"link{i + 1}", row)
        joints.append(_joint(problems, where, joint, links[-1].name, link.name, row, convention))
        links.append(link)
    problems.raise_if_any()
    return Robot(name, tuple(links), tuple(joints))


def _row(problems: Problems, i: int, row: Any) -> DHRow:
    """Return a row as a DHRow; add a problem if it is not valid."""
    if isinstance(row, DHRow):
        return row
    values = problems.array(f"rows[{i}]", "(a, alpha, d, theta)", row, (4,))
    if values is None:
        return DHRow(0.0, 0.0)
    a, alpha, d, theta = (float(x) for x in values)
    return DHRow(a, alpha, d, theta)


def _link(problems: Problems, where: str, name: str, row: DHRow) -> Link:
    """Return the link of a row."""
    center = problems.array(where, "center", row.center, (3,))
    inertia: Any = np.zeros((3, 3))
    good = problems.number(
        where, "mass", row.mass, "kg", "a number not below zero", lambda x: x >= 0.0
    )
    if good and row.mass > 0.0:
        inertia = check_inertia(problems, where, row.inertia)
    if center is None or inertia is None:
        return Link(name, where=where)
    return Link(name, float(row.mass) if good else 0.0, center, inertia, where=where)


def _joint(
    problems: Problems, where: str, name: str, parent: str, child: str, row: DHRow, convention: str
) -> RobotJoint:
    """Return the joint of a row."""
    for key in ("a", "d"):
        problems.number(where, key, getattr(row, key), "m")
    for key in ("alpha", "theta"):
        problems.number(where, key, getattr(row, key), "rad")
    if row.kind not in ("revolute", "prismatic"):
        problems.add(where, f"kind is {row.kind!r}, must be 'revolute' or 'prismatic'")
    for key in ("lower", "upper"):
        if np.isnan(getattr(row, key)):
            problems.add(where, f"{key} is nan, must be a number")
    if row.lower > row.upper:
        problems.add(where, f"lower limit {row.lower:g} is above the upper limit {row.upper:g}")
    if problems.found:
        return RobotJoint(name, "fixed", parent, child)
    along_x = Frame(row.a * X, exp_rotation(row.alpha * X))
    along_z = Frame(row.d * Z, exp_rotation(row.theta * Z))
    common: Any = {"lower": float(row.lower), "upper": float(row.upper), "where": where}
    if convention == "modified":
        return RobotJoint(name, row.kind, parent, child, along_x @ along_z, Z, **common)
    # joint axis z of the previous frame, in the frame of the link
    origin = along_z @ along_x
    back = origin.inverted()
    return RobotJoint(name, row.kind, parent, child, origin, back.A @ Z, back.r, **common)
