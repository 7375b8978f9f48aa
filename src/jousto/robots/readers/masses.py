"""Masses of robots: moving links without mass, impossible inertia, merging of fixed links."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.mechanism.bodies.inertia import check_inertia
from jousto.robots.description import Frame, Link, Robot
from jousto.robots.readers.xml import Adder

# radius of gyration over the size of the robot, above which mass or inertia has a wrong unit
ODD_RADIUS = 20.0
HEAVY = 1e5  # mass of a link above which a warning follows, kg
LONG = 1e3  # size of a robot above which a warning follows, m
TURNS, DEGREES = 8.0 * math.pi, 720.0  # range of limits, rad, that are probably in degrees
THIN = 1e-3  # smallest radius of gyration of a repaired inertia over the size of the robot


def merge_and_check(add: Adder, made: Robot, *, merge: bool, repair: bool) -> Robot:
    """Return the robot with fixed links merged; add problems for impossible mass and inertia.

    A link on a fixed joint may have any inertia if the merged link has a possible one.
    """
    made = fix_massless_joints(add, made)
    wrong = {link.name: message for link in made.links if (message := wrong_mass(link))}
    whole, homes = merge_links(made)
    if not merge:
        whole, homes = made, {link.name: link.name for link in made.links}
    # links fixed to a link with mass add their inertia, whether or not they have mass themselves
    whole = replace(whole, links=without_idle_inertia(add, made, whole, homes))
    held = held_links(whole)
    links, size = [], extent(made)
    for link in whole.links:
        message = wrong_mass(link)
        if message and repair and link.mass > 0.0 and link.name not in held:
            add.note(link, f"{message}; repaired")
            link = replace(link, inertia=nearest_inertia(link, size))
        elif message and link.name not in held:
            names = [name for name in wrong if homes[name] == link.name] or [link.name]
            known = {one.name: one for one in made.links}
            for name in names:
                add(known[name], wrong.get(name, message))
        links.append(link)
    bad = {link.name for link in whole.links if wrong_mass(link) and link.name not in held}
    for link in made.links:
        if link.mass < 0.0 and homes[link.name] not in bad:
            add(link, wrong[link.name])
        elif link.name in wrong and homes[link.name] not in bad:
            add.note(link, f"{wrong[link.name]}; without effect, since it is fixed to other links")
    return replace(whole, links=tuple(links))


def held_links(made: Robot) -> set[str]:
    """Return the names of links that are fixed to the ground."""
    held = {made.links[0].name} if made.fixed_base else set()
    for joint in made.joints:  # parents precede children
        if joint.kind == "fixed" and joint.parent in held:
            held.add(joint.child)
    return held


def without_idle_inertia(
    add: Adder, made: Robot, whole: Robot, homes: dict[str, str]
) -> tuple[Link, ...]:
    """Return merged links, without inertia for links of zero mass, with a warning for these."""
    empty = {link.name for link in whole.links if link.mass == 0.0}
    for link in made.links:
        if link.mass == 0.0 and homes[link.name] in empty and np.any(link.inertia != 0.0):
            add.note(link, "has inertia but no mass; its inertia is ignored")
    return tuple(
        replace(link, inertia=np.zeros((3, 3))) if link.name in empty else link
        for link in whole.links
    )


def fix_massless_joints(add: Adder, made: Robot) -> Robot:
    """Return the robot with joints of massless links fixed; add problems for massless moving links.

    A problem is a moving link without mass whose joint cannot be fixed.
    """
    mass = {link.name: link.mass for link in made.links}
    drawn = {link.name: bool(link.shapes) for link in made.links}
    for joint in reversed(made.joints):
        mass[joint.parent] += mass[joint.child]
        drawn[joint.parent] |= drawn[joint.child]
    links = {link.name: link for link in made.links}
    root = made.links[0]
    if not made.fixed_base and mass[root.name] == 0.0:
        add(root, "moves freely, but neither it nor its children have a mass; give it one")
        return made
    leads = {joint.mimic.joint for joint in made.joints if joint.mimic is not None}
    joints = []
    for joint in made.joints:
        if joint.kind == "fixed" or mass[joint.child] > 0.0:
            joints.append(joint)
        elif drawn[joint.child] or joint.name in leads:
            add(
                links[joint.child],
                f"moves with joint {joint.name!r}, but neither it nor its children have a mass; "
                "give it one, or make the joint fixed",
            )
            return replace(made, joints=made.joints)
        else:
            add.note(joint, "moves no link with a mass or a shape; it is fixed at zero")
            joints.append(replace(joint, kind="fixed", mimic=None))
    return replace(made, joints=tuple(joints))


def wrong_mass(link: Link) -> str:
    """Return why mass and inertia of a link are impossible; empty if they are possible."""
    if link.mass < 0.0:
        return f"mass is {link.mass:g} kg, must not be negative"
    if link.mass == 0.0:
        return ""
    problems = Problems()
    check_inertia(problems, "", link.inertia)
    return "; ".join(problem.message for problem in problems.found)


def check_mass(add: Adder, link: Link) -> None:
    """Add a problem if mass and inertia of a link are impossible."""
    message = wrong_mass(link)
    if message:
        add(link, message)


def nearest_inertia(link: Link, size: float) -> Array:
    """Return the nearest possible inertia of a link: second moments of mass become positive.

    The second moments of a body are ``S = int x x^T dm = tr(J) / 2 - J``.
    """
    J = 0.5 * (link.inertia + link.inertia.T)
    least = link.mass * (THIN * max(size, THIN)) ** 2
    values, vectors = np.linalg.eigh(0.5 * np.trace(J) * np.eye(3) - J)
    values = np.maximum(values, max(least, 1e-6 * float(np.abs(values).max())))
    S = (vectors * values) @ vectors.T
    return np.asarray(np.trace(S) * np.eye(3) - S)


def note_sizes(add: Adder, made: Robot) -> None:
    """Add warnings for masses, lengths and angles that are probably in other units."""
    size = extent(made)
    for link in made.links:
        if link.mass > HEAVY:
            add.note(link, f"mass is {link.mass:g} kg; was it given in g?")
        if link.mass > 0.0:
            radius = math.sqrt(max(0.0, float(np.trace(link.inertia))) / (2.0 * link.mass))
            if size > 0.0 and radius > ODD_RADIUS * size:
                add.note(
                    link,
                    f"its radius of gyration is {radius:.3g} m, the robot itself {size:.3g} m "
                    "long; are mass and inertia in kg and kg m2?",
                )
    for joint in made.joints:
        wide = max(abs(joint.lower), abs(joint.upper)) if joint.kind == "revolute" else 0.0
        if TURNS < wide <= DEGREES:
            both = f"limits are {joint.lower:g} and {joint.upper:g} rad"
            add.note(joint, f"{both}, {wide / math.tau:.0f} turns; were they given in degrees?")
    if size > LONG:
        add.note(None, f"the robot is {size:.3g} m long; were lengths given in mm?")


def extent(made: Robot) -> float:
    """Return the size of a robot, m: the longest chain of joints and centres of mass."""
    long = {made.links[0].name: 0.0}
    for joint in made.joints:
        long[joint.child] = long[joint.parent] + float(np.linalg.norm(joint.origin.r))
    return max(
        long[link.name] + (float(np.linalg.norm(link.center)) if link.mass else 0.0)
        for link in made.links
    )


def merge_links(made: Robot) -> tuple[Robot, dict[str, str]]:
    """Return the robot with links on fixed joints merged, and the merged link of each link."""
    place = {made.links[0].name: (made.links[0].name, Frame())}
    links = {made.links[0].name: made.links[0]}
    known = {link.name: link for link in made.links}
    joints = []
    for joint in made.joints:
        home, at = place[joint.parent]
        at = at @ joint.origin
        if joint.kind == "fixed":
            place[joint.child] = (home, at)
            links[home] = links[home].with_link(known[joint.child], at)
        else:
            place[joint.child] = (joint.child, Frame())
            links[joint.child] = known[joint.child]
            joints.append(replace(joint, parent=home, origin=at))
    homes = {name: home for name, (home, _) in place.items()}
    return replace(made, links=tuple(links.values()), joints=tuple(joints)), homes
