"""Contacts of a robot: the shapes of its links with the filters of its file."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, combinations_with_replacement
from math import inf
from typing import Any

import numpy as np

from jousto.base.arrays import skew
from jousto.base.errors import warn
from jousto.mechanism.bodies.marker import Marker
from jousto.mechanism.contacts.collision import Apart, CollisionShape, Surface, SurfacePair
from jousto.mechanism.contacts.laws import ContactLaw, PowerLaw
from jousto.mechanism.contacts.pair_tables import CONVEX, NEITHER, tips_of_pair
from jousto.mechanism.forces.contact import Contact
from jousto.mechanism.forces.contact_set import Contacts
from jousto.robots.contact_law import FILE, MATERIAL
from jousto.robots.description import Collision, Resistance, Robot, ShapePair
from jousto.robots.kinematics.tree import Tree
from jousto.robots.margins import grown
from jousto.robots.softness import (
    OWN_WORDS,
    RESTITUTION,
    SLOWEST,
    SoftConstraint,
    Softness,
    Touch,
)

DEPTH = 1e-4
"""Depth under the weight of the robot over the size of its smallest shape."""
NAMED = 3
"""Largest number of bodies in the name of a surface."""


@dataclass(frozen=True)
class Skin:
    """What shapes with one surface have in common.

    Parameters
    ----------
    friction, resistance, softness
        As of `Collision`.
    mobility : float
        Inverse of the mass in play of the body, 1/kg; 0: unknown, or the world.
    """

    friction: float
    resistance: Resistance
    softness: Softness
    mobility: float = 0.0

    def touch(self, other: Skin, usual: PowerLaw, pair: ShapePair | None = None) -> Touch:
        """Return the data of the law of a pair; `pair`: with its own friction."""
        friction, resistance = self.friction_with(other)
        if pair is not None and pair.friction is not None:
            friction = pair.friction
        if pair is not None and pair.resistance is not None:
            resistance = pair.resistance
        whole = self.mobility + other.mobility
        mass = 1.0 / whole if whole > 0.0 else inf
        return Touch(mass, friction, resistance.directions, usual)

    def friction_with(self, other: Skin) -> tuple[float, Resistance]:
        """Return friction and resistance of a pair."""
        first, second = self.softness, other.softness
        both = self.resistance.with_other(other.resistance)
        resistance = first.first(second, self.resistance, other.resistance, both)
        return first.friction(second, self.friction, other.friction), resistance

    def pair(self, a: Surface, b: Surface, other: Skin, law: PowerLaw, own: bool) -> SurfacePair:
        """Return the pair of this surface a with that of another skin, b; own: a law of its own."""
        friction, resistance = self.friction_with(other)
        made: Any = self.softness.law(other.softness, self.touch(other, law)) if own else None
        return SurfacePair(a.name, b.name, made, **resistance.of(friction))


def robot_contacts(
    robot: Robot,
    marker_of: Callable[[str, Collision], Marker],
    weight: float,
    name: str = "contacts",
    law: str = MATERIAL,
) -> list[Contacts | Contact]:
    """Return the contacts of a robot with itself and the world; none without two that may touch.

    The stiffness is that of a depth under the weight of `DEPTH` of the smallest shape, or that of
    the file, see `jousto.robots.softness`. Friction and the lengths of the resistance to rolling
    and drilling are the larger ones of both shapes of an MJCF file and the smaller ones of others,
    and ``condim`` says which of them act. Pairs of kinds that cannot touch are excluded, with a
    warning. A pair that the file names is a `Contact` of its own.

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
    law : {"material", "file"}
        Law of the normal force: one for all shapes, or by the words of the file.
    """
    own = law == FILE
    found = [(link.name, one) for link in robot.links for one in link.collisions]
    sizes = [one.shape.size_about for _, one in found if np.isfinite(one.shape.size_about)]
    if len(found) < 2 or not sizes:
        return []
    warn_of_shapes(robot, [one for _, one in found], own)
    usual = PowerLaw(
        max(weight, 1e-3) / (DEPTH * min(sizes)), 1.0, restitution=RESTITUTION, slowest=SLOWEST
    )
    if own:
        found = [(link, with_margin(one)) for link, one in found]
    mobile = mobilities(robot) if own else {}
    skins = {one.name: skin_of(one, mobile.get(link, 0.0), own) for link, one in found}
    surfaces = surfaces_of(skins, {one.name: link for link, one in found}, own)
    shapes = [
        CollisionShape(
            *(one.name, marker_of(link, one), one.shape),
            surface=surfaces[skins[one.name]],
            group=group_of(one),
        )
        for link, one in found
    ]
    couples = combinations_with_replacement if own else combinations
    pairs = [a.pair(surfaces[a], surfaces[b], b, usual, own) for a, b in couples(surfaces, 2)]
    single = paired(robot, {one.name: one for one in shapes}, skins, usual, own)
    between_groups = excluded_groups([one for _, one in found])
    groups = len({one.group for one in shapes})
    if len(between_groups) == groups * (groups + 1) // 2:
        return [*single]
    apart = [*between_groups, *excluded_links(robot, found)]
    apart += [Apart(pair.a, pair.b) for pair in robot.pairs if {pair.a, pair.b} <= known(found)]
    whole = Contacts(name, shapes, law=usual, pairs=pairs, apart=apart, overlap="start")
    return [whole, *single]


def warn_of_shapes(robot: Robot, found: Sequence[Collision], own: bool) -> None:
    """Warn of shapes that touch nothing or as their hulls, and of words that are not read."""
    if robot.untouching:
        warn("contacts", f"these shapes of the file touch nothing: {'; '.join(robot.untouching)}")
    if wide := sorted({one.source for one in found if one.added}):
        warn("contacts", f"meshes that are not convex touch as their hulls: {'; '.join(wide)}")
    words = {word for one in found for word in one.unread}
    words |= {word for pair in robot.pairs for word in pair.unread}
    if unread := sorted(words - (OWN_WORDS if own else set())):
        more = "" if own or not words & OWN_WORDS else "; contact='file' takes those of the file"
        warn("contacts", f"{', '.join(unread)} of the file are not read: one law for all{more}")


def with_margin(one: Collision) -> Collision:
    """Return a shape that is larger by its margin."""
    shape, frame = grown(one.shape, one.frame, one.softness.margin)
    text = one.source or str(one.shape).strip("<>")
    source = f"{text}, larger by {one.softness.margin:g} m" if one.softness.margin else one.source
    return replace(one, shape=shape, frame=frame, source=source)


def mobilities(robot: Robot) -> dict[str, float]:
    """Return the inverse of the mass in play of each link, 1/kg.

    A third of the trace of ``J M^-1 J^T`` of its centre of mass at the initial coordinates: what
    MuJoCo takes for the mass of a contact (body_invweight0).
    """
    tree = Tree(replace(robot, loops=()))
    q = tree.initial
    inverse = np.linalg.pinv(tree.mass_matrix(q), hermitian=True) if tree.nv else np.zeros((0, 0))
    found = {}
    for link in robot.links:
        if not link.collisions:
            continue
        J = tree.jacobian(link.name, q)
        Jc = J[:3] - skew(tree.pose(link.name, q).A @ link.center) @ J[3:]
        found[link.name] = float(np.einsum("ij,jk,ik->", Jc, inverse, Jc)) / 3.0
    return found


def skin_of(one: Collision, mobility: float, own: bool) -> Skin:
    """Return what a shape has in common with others of the same surface."""
    if not own:
        return Skin(one.friction, one.resistance, one.softness.material)
    return Skin(one.friction, one.resistance, replace(one.softness, margin=0.0), mobility)


def surfaces_of(
    skins: Mapping[str, Skin], links: Mapping[str, str], own: bool
) -> dict[Skin, Surface]:
    """Return the surface of each skin, named by its friction or, with laws of its own, by links."""
    on: dict[Skin, dict[str, None]] = {}
    for name, skin in skins.items():
        on.setdefault(skin, {})[links[name]] = None
    found: dict[Skin, Surface] = {}
    taken: Counter[str] = Counter()
    for skin, some in on.items():
        names = list(some)
        text = ", ".join(names[:NAMED]) + (", ..." if len(names) > NAMED else "")
        name = text if own else friction_name(skin)
        taken[name] += 1
        if taken[name] > 1:
            name += f" ({taken[name]})"
        found[skin] = Surface(name, **skin.resistance.of(skin.friction))
    return found


def friction_name(skin: Skin) -> str:
    """Return the name of the surface of shapes with a coefficient of friction and a resistance."""
    name, acts = f"friction {skin.friction:g}", skin.resistance
    if acts != Resistance():
        name += f" {acts.drilling:g} {acts.rolling:g}, condim {acts.directions}"
    return name


def known(found: Sequence[tuple[str, Collision]]) -> set[str]:
    """Return the names of shapes."""
    return {one.name for _, one in found}


def paired(
    robot: Robot,
    shapes: Mapping[str, CollisionShape],
    skins: Mapping[str, Skin],
    usual: PowerLaw,
    own: bool,
) -> list[Contact]:
    """Return a contact for each pair that the file names; warn of those that cannot touch."""
    made, left_out = [], []
    for pair in robot.pairs:
        a, b = shapes.get(pair.a), shapes.get(pair.b)
        if a is None or b is None or tips_of_pair(a.shape, b.shape) == NEITHER:
            left_out.append(f"{pair.a} - {pair.b}")
            continue
        one, other = skins[pair.a], skins[pair.b]
        touch = one.touch(other, usual, pair)
        acts = (pair.resistance or one.friction_with(other)[1]).of(touch.friction)
        if tips_of_pair(a.shape, b.shape) == CONVEX:  # faces resist by the forces at their corners
            acts = {"mu_kinetic": acts["mu_kinetic"]}
        law = paired_law(one, other, pair, touch) if own else usual
        label = f"{pair.a} {pair.b}"
        made.append(Contact(label, a.marker, a.shape, b.marker, b.shape, law, **acts))
    if left_out:
        warn("contacts", f"these pairs of the file pass through each other: {', '.join(left_out)}")
    return made


def paired_law(one: Skin, other: Skin, pair: ShapePair, touch: Touch) -> ContactLaw:
    """Return the law of a pair that the file names, with its own softness where it gives one."""
    first, second = one.softness, other.softness
    if not (isinstance(first, SoftConstraint) and isinstance(second, SoftConstraint)):
        return first.law(second, touch)
    if touch.mass == inf:
        return touch.usual
    return replace(first.with_other(second), **pair.soft).of(touch)


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
