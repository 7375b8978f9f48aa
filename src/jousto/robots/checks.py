"""Checks of robots: what cannot run is refused by name, what is odd is told, all at once."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from jousto.base.errors import Problem, Problems, suggest
from jousto.mechanism.bodies.inertia import check_inertia
from jousto.robots.description import Frame, Link, Robot, RobotJoint
from jousto.robots.markup import Reading

# a radius of gyration that is so many times the size of the robot has its mass in another unit
ODD_RADIUS = 20.0
HEAVY = 1e5  # kg
LONG = 1e3  # m


def robot(
    reading: Reading,
    name: str,
    links: Sequence[Link],
    joints: Sequence[RobotJoint],
    *,
    fixed_base: bool,
    merge: bool,
) -> Robot:
    """Return the robot of links and joints in any order.

    Raises
    ------
    InputError
        With everything that cannot run.
    """
    add = _Adder(reading)
    links, joints = renamed(add, links, joints)
    check_names(add, links, joints)
    root = check_tree(add, links, joints)
    check_joints(add, joints)
    if reading.problems or root is None:
        moving = {joint.child for joint in joints if joint.kind != "fixed"}
        for link in links:
            if link.name in moving:
                check_mass(add, link, held=False)
        reading.finish()
    assert root is not None
    ordered_links, ordered_joints = ordered(root, links, joints)
    made = Robot(name, ordered_links, ordered_joints, fixed_base, source=reading.path)
    check_masses(add, made)
    if not reading.problems:
        note_sizes(add, made)
    odd = reading.finish()
    made = replace(made, odd=odd)
    return merged(made) if merge else made


def renamed(
    add: _Adder, links: Sequence[Link], joints: Sequence[RobotJoint]
) -> tuple[list[Link], list[RobotJoint]]:
    """Return links and joints with names that bodies and joints of a mechanism may have."""

    def clean(name: str, forbidden: str) -> str:
        new = "".join("_" if x in forbidden else x for x in name).strip()
        return f"{new}_" if new == "ground" or new in (".", "..") else new

    things: list[Link | RobotJoint] = [*links, *joints]
    for thing in things:
        new = clean(thing.name, "./" if isinstance(thing, Link) else "/")
        if new != thing.name:
            add.note(thing, f"{thing.name!r} is called {new!r} here")
    new_links = [
        replace(
            link,
            name=clean(link.name, "./"),
            frames={
                f"{name}_" if name in ("origin", "center") else name: frame
                for name, frame in link.frames.items()
            },
        )
        for link in links
    ]
    new_joints = [
        replace(
            joint,
            name=clean(joint.name, "/"),
            parent=clean(joint.parent, "./"),
            child=clean(joint.child, "./"),
            mimic=joint.mimic and replace(joint.mimic, joint=clean(joint.mimic.joint, "/")),
        )
        for joint in joints
    ]
    return new_links, new_joints


class _Adder:
    """Adds problems under the place of a link or a joint."""

    def __init__(self, reading: Reading) -> None:
        self.reading = reading

    def __call__(self, thing: Link | RobotJoint | None, message: str) -> None:
        self.reading.problems.append(Problem(self.where(thing), message))

    def note(self, thing: Link | RobotJoint | None, message: str) -> None:
        """Note what is odd."""
        self.reading.odd.append(Problem(self.where(thing), message))

    def where(self, thing: Link | RobotJoint | None) -> str:
        """Return the place of a thing."""
        return self.reading.where(None) if thing is None else thing.where or thing.name


def check_names(add: _Adder, links: Sequence[Link], joints: Sequence[RobotJoint]) -> None:
    """Note names that are empty or used twice."""
    for word, things in (("link", links), ("joint", joints)):
        times = Counter(thing.name for thing in things)
        for thing in things:
            if not thing.name.strip():
                add(thing, f"the {word} has no name")
            elif times[thing.name] > 1:
                add(thing, f"{times[thing.name]} {word}s are called {thing.name!r}; rename them")
                times[thing.name] = 1


def check_tree(add: _Adder, links: Sequence[Link], joints: Sequence[RobotJoint]) -> str | None:
    """Return the name of the root, or note why the links are no tree."""
    known = {link.name: link for link in links}
    if not links:
        add(None, "has no links")
        return None
    parents: dict[str, RobotJoint] = {}
    for joint in joints:
        for end, name in (("parent", joint.parent), ("child", joint.child)):
            if name not in known:
                add(joint, f"{end}: no link {name!r}{suggest(name, known)}")
        if joint.parent == joint.child:
            add(joint, f"joins link {joint.child!r} with itself")
        elif joint.child in parents:
            other = parents[joint.child].name
            add(
                joint,
                f"link {joint.child!r} is the child of joint {other!r} already: a loop cannot be "
                "a tree; leave one of the joints out and close the loop in the mechanism",
            )
        else:
            parents[joint.child] = joint
    roots = [link for link in links if link.name not in parents]
    if not roots:
        add(None, "the joints go round in a circle: no link is without a parent")
        return None
    if len(roots) > 1:
        names = ", ".join(repr(link.name) for link in roots[:6])
        more = ", ..." if len(roots) > 6 else ""
        add(None, f"{len(roots)} links have no parent: {names}{more}; a robot has one root")
    if not add.reading.problems:
        reached = {link.name for link in ordered(roots[0].name, links, joints)[0]}
        lost = [link.name for link in links if link.name not in reached]
        if lost:
            names = ", ".join(repr(name) for name in lost[:6])
            add(None, f"the joints of {names} go round in a circle that hangs on nothing")
    return roots[0].name


def check_joints(add: _Adder, joints: Sequence[RobotJoint]) -> None:
    """Note axes without a direction, limits the wrong way round, and impossible mimics."""
    known = {joint.name: joint for joint in joints}
    for joint in joints:
        single = joint.kind in ("revolute", "prismatic")
        if (single or joint.kind == "planar") and not np.abs(joint.axis).max() > 1e-9:
            found = ", ".join(f"{x:g}" for x in joint.axis)
            add(joint, f"axis is ({found}), must have a direction")
        if single and joint.lower > joint.upper:
            add(joint, f"lower limit {joint.lower:g} lies above the upper one, {joint.upper:g}")
        for key in ("damping", "friction", "armature", "stiffness", "velocity", "effort"):
            if getattr(joint, key) < 0.0:
                add(joint, f"{key} is {getattr(joint, key):g}, must not be negative")
        check_mimic(add, joint, known)


def check_mimic(add: _Adder, joint: RobotJoint, known: dict[str, RobotJoint]) -> None:
    """Note a joint that follows one that is not there, has several coordinates, or itself."""
    if joint.mimic is None:
        return
    name = joint.mimic.joint
    if name not in known:
        add(joint, f"mimic: no joint {name!r}{suggest(name, known)}")
        return
    seen, at = [joint.name], name
    while at in known and at not in seen:
        seen.append(at)
        mimic = known[at].mimic
        at = "" if mimic is None else mimic.joint
    if at == joint.name:
        add(joint, f"mimic: {' follows '.join(repr(x) for x in (*seen, at))}, itself")
    for other in (joint, known[name]):
        if other.kind not in ("revolute", "prismatic"):
            add(joint, f"mimic: joint {other.name!r} is {other.kind}, has not one coordinate")


def ordered(
    root: str, links: Sequence[Link], joints: Sequence[RobotJoint]
) -> tuple[tuple[Link, ...], tuple[RobotJoint, ...]]:
    """Return links and joints, every one after what carries it; branches as the file has them."""
    known = {link.name: link for link in links}
    below: dict[str, list[RobotJoint]] = {}
    for joint in joints:
        below.setdefault(joint.parent, []).append(joint)
    found_links, found_joints = [known[root]], []
    waiting = list(reversed(below.get(root, [])))
    while waiting:
        joint = waiting.pop()
        found_joints.append(joint)
        found_links.append(known[joint.child])
        waiting += reversed(below.get(joint.child, []))
    return tuple(found_links), tuple(found_joints)


def check_masses(add: _Adder, made: Robot) -> None:
    """Note inertia that no body has, and links without mass that nothing holds."""
    carried = dict.fromkeys((link.name for link in made.links), 0.0)
    fixed_to = {joint.child: joint for joint in made.joints if joint.kind == "fixed"}
    held = {made.links[0].name} if made.fixed_base else set()
    for joint in made.joints:  # parents come first
        if joint.kind == "fixed" and joint.parent in held:
            held.add(joint.child)
    for link in made.links:
        check_mass(add, link, held=link.name in held)
        carried[link.name] = link.mass
    parents = {joint.child: joint for joint in made.joints}
    for link in reversed(made.links[1:]):
        carried[parents[link.name].parent] += carried[link.name]
    for link in made.links:
        carrier = parents.get(link.name)
        if link.name in held or link.name in fixed_to or carried[link.name] > 0.0:
            continue
        if carrier is None or carried[carrier.parent] > 0.0 or carrier.parent in held:
            what = f"moves with joint {carrier.name!r}" if carrier else "moves freely"
            add(
                link,
                f"{what}, but neither it nor what it carries has a mass; give it one, or make "
                "the joint fixed",
            )


def check_mass(add: _Adder, link: Link, *, held: bool) -> None:
    """Note why no body has the mass of a link; it is only odd where nothing moves it."""
    if link.mass < 0.0:
        add(link, f"mass is {link.mass:g} kg, must not be negative")
    elif link.mass == 0.0:
        if np.any(link.inertia != 0.0):
            add.note(link, "has inertia but no mass; it counts as a frame without either")
        return
    problems = Problems()
    check_inertia(problems, "", link.inertia)
    for problem in problems.found:
        (add.note if held else add)(link, problem.message)


def note_sizes(add: _Adder, made: Robot) -> None:
    """Note masses and lengths that were likely given in other units."""
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
    if size > LONG:
        add.note(None, f"the robot is {size:.3g} m long; were lengths given in mm?")


def extent(made: Robot) -> float:
    """Return the longest chain of distances between joints and centres of mass, m."""
    long = {made.links[0].name: 0.0}
    for joint in made.joints:
        long[joint.child] = long[joint.parent] + float(np.linalg.norm(joint.origin.r))
    return max(
        long[link.name] + (float(np.linalg.norm(link.center)) if link.mass else 0.0)
        for link in made.links
    )


def merged(made: Robot) -> Robot:
    """Return the robot with links on fixed joints merged into those that carry them."""
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
    return replace(made, links=tuple(links.values()), joints=tuple(joints))
