"""Equalities and actuators of MJCF files: mimic joints, loop joints, motors and servos."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problem
from jousto.robots.description import Actuator, Frame, Mimic, Robot, RobotJoint
from jousto.robots.kinematics.tree import Tree
from jousto.robots.readers.checks import joint_name, link_name
from jousto.robots.readers.mjcf_bodies import Bodies
from jousto.robots.readers.mjcf_collected import turned_back
from jousto.robots.readers.mjcf_settings import ACTUATORS, override
from jousto.robots.readers.mjcf_words import ALONE, LOPSIDED, NO_FORCE, NO_LIMIT, UNTIED
from jousto.robots.readers.xml import Element

SINGLE = ("revolute", "prismatic")
NAMES = ("body1", "body2", "site1", "site2", "joint", "jointinparent", "joint1", "joint2")
POLYNOMIAL = np.array([0.0, 1.0, 0.0, 0.0, 0.0])


@dataclass(frozen=True, eq=False)
class Tied:
    """Equality ``connect`` or ``weld`` of two bodies or sites: names, point or pose, line."""

    name: str
    kind: str
    one: str
    other: str
    sites: bool
    anchor: Array
    pose: Frame | None
    where: str


def each_copy(bodies: Bodies, element: Element) -> Iterator[Element]:
    """Yield an element, or one copy for each replica of the elements that it names."""
    given, copies = element.given, bodies.copies
    named = [key for key in NAMES if given.get(key) in copies]
    if not named:
        yield element
        return
    for i in range(min(len(copies[given[key]]) for key in named)):
        own = {key: copies[given[key]][i] for key in named}
        suffix = own[named[0]].removeprefix(given[named[0]])
        name = {"name": f"{given['name']}{suffix}"} if "name" in given else {}
        yield replace(element, given=given | own | name)


# -- equalities -----------------------------------------------------------------------------


def read_ties(bodies: Bodies) -> list[Tied]:
    """Set mimic relations of joints, and return the equalities ``connect`` and ``weld``."""
    if {"equality", "constraint"} & bodies.settings.off:
        return []
    found: list[Tied] = []
    for section in bodies.root.all("equality"):
        for one in section.children:
            for element in each_copy(bodies, one):
                base = bodies.places.given(element, "main", "equality")
                given = replace(element, given=override(base.given, element.given))
                if given.given.get("active", "true") == "false":
                    continue
                if given.tag == "joint":
                    _follow(bodies, given)
                elif given.tag in ("connect", "weld"):
                    found.append(_tied(bodies, given))
    return found


def _follow(bodies: Bodies, element: Element) -> None:
    """Set a joint to follow another joint, or add a warning if this is impossible.

    ``q1 - q1_0 = a0 + a1 (q2 - q2_0) + ...`` with the reference coordinates q_0.
    """
    joints = bodies.found.joints
    one, other = (element.given.get(key, "") for key in ("joint1", "joint2"))
    c = POLYNOMIAL.copy()
    if "polycoef" in element.given:  # missing coefficients have their default
        given = bodies.reading.list(element, "polycoef")
        if given is None or len(given) > 5:
            text = element.given["polycoef"][:60]
            bodies.reading.add(element, f"polycoef is {text!r}, must be up to 5 numbers")
        else:
            c[: len(given)] = given
    index = {joint.name: i for i, joint in enumerate(joints)}
    i, j = index.get(bodies.prefix + one), index.get(bodies.prefix + other)
    if i is None or (other and j is None):
        bodies.reading.effect(element, f"no joint {one if i is None else other!r}", UNTIED)
        return
    if np.any(c[2:] != 0.0) and j is not None:
        bodies.reading.effect(element, "a polynomial of higher order", UNTIED)
        return
    own = joints[i].initial + float(c[0])
    if j is None:
        joints[i] = held_at(joints[i], own)
        return
    offset = own - float(c[1]) * joints[j].initial
    joints[i] = replace(joints[i], mimic=Mimic(joints[j].name, float(c[1]), offset))


def held_at(joint: RobotJoint, value: float) -> RobotJoint:
    """Return a joint fixed at a value of its coordinate, rad or m."""
    if joint.kind not in SINGLE:
        return joint
    turn = turned_back(replace(joint, initial=-value))
    return replace(joint, kind="fixed", origin=joint.origin @ turn, initial=0.0)


def _tied(bodies: Bodies, element: Element) -> Tied:
    given, reading = element.given, bodies.reading
    sites = "site1" in given
    keys = ("site1", "site2") if sites else ("body1", "body2")
    one, other = (bodies.prefix + given[key] if key in given else "world" for key in keys)
    name = bodies.prefix + given.get("name", f"{element.tag} of {one} and {other}")
    anchor = np.zeros(3)
    if not sites and element.tag == "connect":
        anchor = reading.vector(element, "anchor", None)
    pose = Frame() if sites else None
    if element.tag == "weld" and "relpose" in given and not sites:
        x = reading.numbers(element, given["relpose"], "relpose", 7, np.zeros(7))
        if x[3:].any():
            quat = " ".join(map(repr, map(float, x[3:])))
            A = bodies.places.quaternion(replace(element, given={"relpose": quat}), "relpose")
            pose = Frame(x[:3], A)
    kind = "ball" if element.tag == "connect" else "fixed"
    return Tied(name, kind, one, other, sites, anchor, pose, reading.where(element))


def with_loop_joints(bodies: Bodies, robot: Robot, ties: list[Tied]) -> Robot:
    """Return a robot with the loop joints of ``connect`` and ``weld`` at its initial pose."""
    if not ties:
        return robot
    tree = Tree(robot)
    poses = tree.forward_kinematics(tree.initial)
    places = {name: (link.name, at) for link in robot.links for name, at in link.frames.items()}
    places |= {link.name: (link.name, Frame()) for link in robot.links}
    loops: list[RobotJoint] = []
    names = {joint.name for joint in robot.joints}
    for tie in ties:
        one, other = (x if tie.sites else link_name(x) for x in (tie.one, tie.other))
        lost = [name for name in (one, other) if name not in places]
        if lost:
            thing = "site" if tie.sites else "body"
            bodies.reading.problems.append(Problem(tie.where, f"no {thing} {lost[0]!r}"))
            continue
        (a, at_a), (b, at_b) = places[one], places[other]
        if a == b:
            continue
        between = poses[a].inverted() @ poses[b]  # pose of b in a
        point = at_a.r + at_a.A @ tie.anchor
        if tie.kind == "fixed" and tie.pose is not None:
            between = at_a @ tie.pose @ at_b.inverted()
        inner = at_b.r if tie.sites else between.A.T @ (point - between.r)
        if tie.kind == "ball":
            between = Frame(point - between.A @ inner, between.A)
        name = joint_name(tie.name)
        while name in names:
            name += "_"
        names.add(name)
        loops.append(RobotJoint(name, tie.kind, a, b, between, anchor=inner, where=tie.where))
    return replace(robot, loops=tuple(loops))


# -- actuators ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Motor:
    """Actuator, its damping ratio, and the limit of the force on its joint."""

    made: Actuator
    ratio: float
    most: float


def read_actuators(bodies: Bodies) -> list[Motor]:
    """Return the motors and servos on joints; add a warning for other actuators."""
    off = bodies.settings.off
    if "actuation" in off:
        return []
    found: list[Motor] = []
    for section in bodies.root.all("actuator"):
        for one in section.children:
            if one.tag not in ACTUATORS:
                continue  # already reported as a word
            for element in each_copy(bodies, one):
                motor = _motor(bodies, element)
                if motor is None:
                    continue
                if math.isfinite(motor.most) and motor.made.joint in {x.made.joint for x in found}:
                    bodies.reading.effect(element, "actuatorfrcrange", ALONE)
                found.append(motor)
    return found


def _motor(bodies: Bodies, element: Element) -> Motor | None:
    reading = bodies.reading
    shared = bodies.places.given(element, "main", "actuator")
    own = bodies.places.given(element, "main")
    given = override(shared.given, own.given)
    whole = replace(element, given=given)
    group = given.get("group", "0")
    if group.isdigit() and int(group) in bodies.settings.idle_groups:
        return None
    target = given.get("joint", given.get("jointinparent"))
    if target is None:
        ends = [key for key in ("tendon", "site", "cranksite", "body") if key in given]
        reading.effect(element, f"an actuator of a {ends[0] if ends else 'nothing'}", NO_FORCE)
        return None
    index = {joint.name: i for i, joint in enumerate(bodies.found.joints)}
    i = index.get(bodies.prefix + target)
    if i is None:
        if not bodies.prefix:  # a partly attached model may lack the joints of its motors
            reading.add(element, f"no joint {target!r}")
        return None
    joint = bodies.found.joints[i]
    if joint.kind not in SINGLE:
        reading.effect(element, f"an actuator of a {joint.kind} joint", NO_FORCE)
        return None
    gains = _gains(bodies, whole)
    if gains is None:
        return None
    gear = reading.list(whole, "gear")
    g = 1.0 if gear is None else float(gear[0])
    gain, bias, ratio = gains
    rotor, viscous = (reading.list(whole, key) for key in ("armature", "damping"))
    # rotor inertia of the actuator reduced to the joint, gear ratio g
    more = 0.0 if rotor is None else float(rotor[0]) * g * g
    loss = 0.0 if viscous is None else float(viscous[0]) * g * g
    bodies.found.joints[i] = replace(
        joint, armature=joint.armature + more, damping=joint.damping + loss
    )
    name = bodies.prefix + given["name"] if "name" in given else f"{joint.name} actuator"
    limit = _limit(bodies, whole, joint.effort / abs(g) if g else math.inf, servo=bias[1] < 0.0)
    made = Actuator(name, joint_name(joint.name), g, gain, bias, limit, reading.where(element))
    return Motor(made, ratio, joint.effort)


def _gains(
    bodies: Bodies, element: Element
) -> tuple[float, tuple[float, float, float], float] | None:
    """Return gain, bias and damping ratio of an actuator, or None with a warning."""
    reading, given = bodies.reading, element.given
    if element.tag == "motor":
        return 1.0, (0.0, 0.0, 0.0), 0.0
    if element.tag == "velocity":
        kv = reading.number(element, "kv", 1.0)
        return kv, (0.0, 0.0, -kv), 0.0
    if element.tag == "position" or "kp" in given:
        kp, kv = reading.number(element, "kp", 1.0), reading.number(element, "kv", 0.0)
        return kp, (0.0, -kp, -kv), reading.number(element, "dampratio", 0.0)
    kinds = [given.get(key, spare) for key, spare in _KINDS]
    if kinds[0] != "fixed" or kinds[1] not in ("none", "affine") or kinds[2] != "none":
        message = ", ".join(f"{key} {x}" for (key, _), x in zip(_KINDS, kinds, strict=True))
        reading.effect(element, f"a general actuator with {message}", NO_FORCE)
        return None
    gain, bias = (reading.list(element, key) for key in ("gainprm", "biasprm"))
    b = np.zeros(3)
    if bias is not None and kinds[1] == "affine":
        b[: min(3, len(bias))] = bias[:3]
    ratio = float(max(b[2], 0.0)) if b[1] < 0.0 else 0.0
    if ratio > 0.0:  # a positive value is a damping ratio instead of a bias
        b[2] = 0.0
    return 1.0 if gain is None else float(gain[0]), (float(b[0]), float(b[1]), float(b[2])), ratio


_KINDS = (("gaintype", "fixed"), ("biastype", "none"), ("dyntype", "none"))


def _limit(bodies: Bodies, element: Element, most: float, *, servo: bool) -> float:
    """Return the largest force of an actuator; infinite without a limit.

    Parameters
    ----------
    bodies, element
        Reader of the bodies, and the element of the actuator.
    most : float
        Limit of the force on its joint, reduced to the actuator.
    servo : bool
        Whether the actuator supports a limit; otherwise a limit is a warning.
    """
    limits = {"actuatorfrcrange": most}
    if bodies.limited(element, "forcelimited", "forcerange"):
        text = element.given.get("forcerange")
        span = bodies.reading.numbers(element, text, "forcerange", 2, np.zeros(2))
        if span[0] != -span[1]:
            bodies.reading.effect(element, "forcerange", LOPSIDED)
        limits["forcerange"] = float(np.abs(span).max()) or math.inf
    for word, limit in limits.items():
        if not servo and math.isfinite(limit):
            bodies.reading.effect(element, word, NO_LIMIT)
    return min(limits.values()) if servo else math.inf
