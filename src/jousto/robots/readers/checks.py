"""Checks of robots: names, tree, joints, mimics and masses, with all errors together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from jousto.base.errors import suggest
from jousto.robots.description import Frame, Link, Robot, RobotJoint
from jousto.robots.readers.masses import check_mass, merge_and_check, note_sizes
from jousto.robots.readers.xml import Adder, Reading


def robot(
    reading: Reading,
    name: str,
    links: Sequence[Link],
    joints: Sequence[RobotJoint],
    *,
    fixed_base: bool,
    merge: bool,
    repair: bool = False,
    complete: Callable[[Robot], Robot] = lambda made: made,
) -> Robot:
    """Return the checked robot of links and joints in any order, after the call of `complete`.

    Raises
    ------
    InputError
        With all errors.
    """
    add = Adder(reading)
    links, joints = with_valid_names(add, links, joints)
    joints = [without_mimic(add, joint) for joint in joints]
    check_names(add, links, joints)
    root = check_tree(add, links, joints)
    check_joints(add, joints)
    if reading.problems or root is None:
        moving = {joint.child for joint in joints if joint.kind != "fixed"}
        for link in links:
            if link.name in moving:
                check_mass(add, link)
        reading.finish()
    assert root is not None
    ordered_links, ordered_joints = tree_order(root, links, joints)
    made = Robot(name, ordered_links, ordered_joints, fixed_base, source=reading.path)
    made = merge_and_check(add, made, merge=merge, repair=repair)
    if not reading.problems:
        note_sizes(add, made)
        made = complete(made)
    return replace(made, odd=reading.finish())


def split_loops(
    joints: Sequence[RobotJoint], kinds: Sequence[str]
) -> tuple[list[RobotJoint], list[RobotJoint]]:
    """Return the joints of a spanning tree, and the joints of given kinds that close loops."""
    root: dict[str, str] = {}

    def end(name: str) -> str:
        while name in root:
            root[name] = root.get(root[name], root[name])
            name = root[name]
        return name

    tree, loops = [], []
    for joint in joints:
        a, b = end(joint.parent), end(joint.child)
        if a == b and joint.kind in kinds and joint.parent != joint.child:
            loops.append(joint)
            continue
        if a != b:
            root[b] = a
        tree.append(joint)
    return tree, loops


def with_loops(made: Robot, loops: Sequence[RobotJoint]) -> Robot:
    """Return a robot with loop joints between its links; merged links become frames."""
    places = {name: (link.name, at) for link in made.links for name, at in link.frames.items()}
    places |= {link.name: (link.name, Frame()) for link in made.links}
    found = []
    for joint in loops:
        (a, at_a), (b, at_b) = (places[link_name(name)] for name in (joint.parent, joint.child))
        if a == b:
            continue
        found.append(
            replace(
                joint,
                name=joint_name(joint.name),
                parent=a,
                child=b,
                origin=at_a @ joint.origin @ at_b.inverted(),
                axis=at_b.A @ joint.axis,
                anchor=at_b.r + at_b.A @ joint.anchor,
            )
        )
    return replace(made, loops=(*made.loops, *found))


def without_mimic(add: Adder, joint: RobotJoint) -> RobotJoint:
    """Return a joint, without its mimic relation if the joint is fixed."""
    if joint.kind != "fixed" or joint.mimic is None:
        return joint
    add.note(joint, f"is fixed, so that it does not follow joint {joint.mimic.joint!r}")
    return replace(joint, mimic=None)


def clean_name(name: str, forbidden: str) -> str:
    """Return a name with forbidden characters replaced."""
    new = "".join("_" if x in forbidden else x for x in name).strip()
    return f"{new}_" if new == "ground" or new in (".", "..") else new


def link_name(name: str) -> str:
    """Return the name of a link without the characters forbidden for bodies of a mechanism."""
    return clean_name(name, "./")


def joint_name(name: str) -> str:
    """Return the name of a joint without the characters forbidden for joints of a mechanism."""
    return clean_name(name, "/")


def with_valid_names(
    add: Adder, links: Sequence[Link], joints: Sequence[RobotJoint]
) -> tuple[list[Link], list[RobotJoint]]:
    """Return links and joints with names that are valid in a mechanism."""
    things: list[Link | RobotJoint] = [*links, *joints]
    for thing in things:
        new = link_name(thing.name) if isinstance(thing, Link) else joint_name(thing.name)
        if new != thing.name:
            add.note(thing, f"{thing.name!r} is renamed to {new!r}")
    new_links = [
        replace(
            link,
            name=link_name(link.name),
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
            name=joint_name(joint.name),
            parent=link_name(joint.parent),
            child=link_name(joint.child),
            mimic=joint.mimic and replace(joint.mimic, joint=joint_name(joint.mimic.joint)),
        )
        for joint in joints
    ]
    return new_links, new_joints


def check_names(add: Adder, links: Sequence[Link], joints: Sequence[RobotJoint]) -> None:
    """Add errors for names that are empty or used twice."""
    for word, things in (("link", links), ("joint", joints)):
        times = Counter(thing.name for thing in things)
        for thing in things:
            if not thing.name.strip():
                add(thing, f"the {word} has no name")
            elif times[thing.name] > 1:
                add(thing, f"{times[thing.name]} {word}s have the name {thing.name!r}; rename them")
                times[thing.name] = 1


def check_tree(add: Adder, links: Sequence[Link], joints: Sequence[RobotJoint]) -> str | None:
    """Return the name of the root; add errors if the links do not form a tree."""
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
                f"link {joint.child!r} is also the child of joint {other!r}, which closes a loop; "
                "remove one of the joints and close the loop in the mechanism",
            )
        else:
            parents[joint.child] = joint
    roots = [link for link in links if link.name not in parents]
    if not roots:
        add(None, "all links have a parent: the joints form a circle; a robot needs one root")
        return None
    # a child with a wrong name leaves a link without a parent, which is reported already
    astray = len({joint.name for joint in joints if joint.child not in known})
    if len(roots) > 1 + astray:
        names = ", ".join(repr(link.name) for link in roots[:6])
        more = ", ..." if len(roots) > 6 else ""
        add(None, f"{len(roots)} links have no parent: {names}{more}; a robot has one root")
    if not add.reading.problems:
        reached = {link.name for link in tree_order(roots[0].name, links, joints)[0]}
        lost = [link.name for link in links if link.name not in reached]
        if lost:
            names = ", ".join(repr(name) for name in lost[:6])
            add(None, f"the joints of {names} form a circle without a link to the root")
    return roots[0].name


def check_joints(add: Adder, joints: Sequence[RobotJoint]) -> None:
    """Add errors for axes without a direction, reversed limits and invalid mimics."""
    known = {joint.name: joint for joint in joints}
    for joint in joints:
        single = joint.kind in ("revolute", "prismatic", "screw")
        if (single or joint.kind == "planar") and not np.abs(joint.axis).max() > 1e-9:
            found = ", ".join(f"{x:g}" for x in joint.axis)
            add(joint, f"axis is ({found}), must have a direction")
        if single and joint.lower > joint.upper:
            add(joint, f"lower limit {joint.lower:g} is above the upper limit {joint.upper:g}")
        for key in ("damping", "friction", "armature", "stiffness", "velocity", "effort"):
            if getattr(joint, key) < 0.0:
                add(joint, f"{key} is {getattr(joint, key):g}, must not be negative")
        check_mimic(add, joint, known)


def check_mimic(add: Adder, joint: RobotJoint, known: dict[str, RobotJoint]) -> None:
    """Add an error for a mimic of a missing joint, of several coordinates or of itself."""
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
            add(joint, f"mimic: joint {other.name!r} is {other.kind}, must have one coordinate")


def tree_order(
    root: str, links: Sequence[Link], joints: Sequence[RobotJoint]
) -> tuple[tuple[Link, ...], tuple[RobotJoint, ...]]:
    """Return links and joints, each after its parent; branches in the order of the file."""
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
