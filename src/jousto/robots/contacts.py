"""Contacts of a robot: the shapes of its links with the filters of its file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import combinations, combinations_with_replacement

import numpy as np

from jousto.base.errors import warn
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.contacts.collision import Apart, CollisionShape, Surface, SurfacePair
from jousto.mechanism.contacts.laws import PowerLaw
from jousto.mechanism.contacts.pair_tables import CONVEX, NEITHER, tips_of_pair
from jousto.mechanism.forces.contact import Contact
from jousto.mechanism.forces.contact_set import Contacts
from jousto.robots.description import Collision, Resistance, Robot

DEPTH = 1e-4
"""Depth under the weight of the robot over the size of its smallest shape."""
RESTITUTION = 0.2
"""Coefficient of restitution of the links of robots."""

SLOWEST = 0.1
"""Speed of approach below which a touch loses as much as at it, m/s: feet come to rest at once."""


def robot_contacts(
    robot: Robot,
    marker_of: Callable[[str, Collision], Marker],
    weight: float,
    name: str = "contacts",
) -> list[Contacts | Contact]:
    """Return the contacts of a robot with itself and the world; none without two that may touch.

    The stiffness is that of a depth under the weight of `DEPTH` of the smallest shape. Friction and
    the lengths of the resistance to rolling and drilling are the larger ones of both shapes, and
    ``condim`` says which of them act, as in MuJoCo. Pairs of kinds that cannot touch are excluded,
    with a warning. A pair that the file names is a `Contact` of its own.

    Parameters
    ----------
    robot : Robot
        Robot with the collision shapes of its links.
    marker_of : callable
        Function that returns the marker of a shape on a link.
    weight : float
        Weight of the robot, N.
    name : str
        Name of the set, and prefix of the names of pairs.
    """
    found = [(link.name, one) for link in robot.links for one in link.collisions]
    sizes = [one.shape.size_about for _, one in found if np.isfinite(one.shape.size_about)]
    if len(found) < 2 or not sizes:
        return []
    if robot.untouching:
        warn("contacts", f"these shapes of the file touch nothing: {'; '.join(robot.untouching)}")
    if wide := sorted({one.source for _, one in found if one.added}):
        warn("contacts", f"meshes that are not convex touch as their hulls: {'; '.join(wide)}")
    words = {word for _, one in found for word in one.unread}
    if unread := sorted(words | {word for pair in robot.pairs for word in pair.unread}):
        warn("contacts", f"{', '.join(unread)} of the file are not read: one law for all shapes")
    law = PowerLaw(
        max(weight, 1e-3) / (DEPTH * min(sizes)), 1.0, restitution=RESTITUTION, slowest=SLOWEST
    )
    kinds = dict.fromkeys((one.friction, one.resistance) for _, one in found)
    surfaces = {kind: surface_of(*kind) for kind in kinds}
    shapes = [
        CollisionShape(
            one.name,
            marker_of(link, one),
            one.shape,
            surface=surfaces[one.friction, one.resistance],
            group=group_of(one),
        )
        for link, one in found
    ]
    pairs = [
        SurfacePair(surfaces[a].name, surfaces[b].name, **a[1].with_other(b[1]).of(max(a[0], b[0])))
        for a, b in combinations(surfaces, 2)
    ]
    single = paired(robot, {one.name: one for one in shapes}, law)
    between_groups = excluded_groups([one for _, one in found])
    groups = len({one.group for one in shapes})
    if len(between_groups) == groups * (groups + 1) // 2:
        return [*single]
    apart = [*between_groups, *excluded_links(robot, found)]
    apart += [Apart(pair.a, pair.b) for pair in robot.pairs if {pair.a, pair.b} <= known(found)]
    whole = Contacts(name, shapes, law=law, pairs=pairs, apart=apart, overlap="start")
    return [whole, *single]


def surface_of(friction: float, resistance: Resistance) -> Surface:
    """Return the surface of shapes with a coefficient of friction and a resistance."""
    name = f"friction {friction:g}"
    if resistance != Resistance():
        name += f" {resistance.drilling:g} {resistance.rolling:g}, condim {resistance.directions}"
    return Surface(name, **resistance.of(friction))


def known(found: Sequence[tuple[str, Collision]]) -> set[str]:
    """Return the names of shapes."""
    return {one.name for _, one in found}


def paired(
    robot: Robot, shapes: Mapping[str, CollisionShape], law: PowerLaw, prefix: str = ""
) -> list[Contact]:
    """Return a contact for each pair that the file names; warn of those that cannot touch."""
    known = {one.name: one for link in robot.links for one in link.collisions}
    made, left_out = [], []
    for pair in robot.pairs:
        a, b = shapes.get(pair.a), shapes.get(pair.b)
        if a is None or b is None or tips_of_pair(a.shape, b.shape) == NEITHER:
            left_out.append(f"{pair.a} - {pair.b}")
            continue
        one, other = known[pair.a], known[pair.b]
        mu = max(one.friction, other.friction) if pair.friction is None else pair.friction
        acts = (pair.resistance or one.resistance.with_other(other.resistance)).of(mu)
        if tips_of_pair(a.shape, b.shape) == CONVEX:  # faces resist by the forces at their corners
            acts = {"mu_kinetic": acts["mu_kinetic"]}
        label = f"{prefix}{pair.a} {pair.b}"
        made.append(Contact(label, a.marker, a.shape, b.marker, b.shape, law, **acts))
    if left_out:
        warn("contacts", f"these pairs of the file pass through each other: {', '.join(left_out)}")
    return made


def group_of(one: Collision) -> str:
    """Return the group of a shape: its kind and its masks."""
    return f"{one.shape.tag} {one.type_bits} {one.affinity}"


def excluded_groups(shapes: Sequence[Collision]) -> list[Apart]:
    """Return the groups that do not touch: by their masks, or because their kinds cannot.

    ``contype`` of one must share a bit with ``conaffinity`` of the other.
    """
    groups = {group_of(one): one for one in shapes}
    apart, left_out = [], set()
    for (a, one), (b, other) in combinations_with_replacement(groups.items(), 2):
        masked = not (one.type_bits & other.affinity or other.type_bits & one.affinity)
        neither = tips_of_pair(one.shape, other.shape) == NEITHER
        if masked or neither:
            apart.append(Apart(a, b))
        if neither and not masked:
            left_out.add(" - ".join(sorted((one.shape.tag, other.shape.tag))))
    planes = "half-space - half-space"
    if found := sorted(left_out - {planes}):
        warn("contacts", f"these kinds of shapes pass through each other: {', '.join(found)}")
    return apart


def excluded_shapes(robot: Robot) -> list[tuple[str, str]]:
    """Return the pairs of shapes that never touch: by masks, kinds, or excluded bodies."""
    found = [one for link in robot.links for one in link.collisions]
    bodies = {frozenset(pair) for pair in (*robot.apart, *neighbours(robot))}
    pairs = []
    for one, other in combinations(found, 2):
        masked = not (one.type_bits & other.affinity or other.type_bits & one.affinity)
        neither = tips_of_pair(one.shape, other.shape) == NEITHER
        if masked or neither or frozenset((one.body, other.body)) in bodies:
            pairs.append((one.name, other.name))
    return pairs


def excluded_links(robot: Robot, found: Sequence[tuple[str, Collision]]) -> list[Apart]:
    """Return the pairs of shapes of bodies that the file excludes, and of neighbours."""
    on: dict[str, list[str]] = {}
    for _, one in found:
        on.setdefault(one.body, []).append(one.name)
    bodies = [*robot.apart, *neighbours(robot)]
    return [Apart(a, b) for x, y in bodies for a in on.get(x, ()) for b in on.get(y, ()) if a != b]


def neighbours(robot: Robot) -> list[tuple[str, str]]:
    """Return the bodies with only links without mass and shapes between them.

    A body with several joints has such links. Their joints do not connect the two bodies.
    """
    above = {joint.child: joint.parent for joint in robot.joints}
    links = {link.name: link for link in robot.links}
    found = []
    for link in robot.links:
        name = above.get(link.name)
        while name is not None and not (links[name].mass or links[name].collisions):
            name = above.get(name)
        if name is None or name == above[link.name]:
            continue
        upper, lower = ({one.body for one in x.collisions} for x in (links[name], link))
        found += [(a, b) for a in upper for b in lower]
    return found
