"""Numbers of a set of shapes for the engine: laws of pairs of surfaces, groups, excluded pairs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import gamma, hypot, pi, sqrt
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.mechanism.contacts.collision import Apart, CollisionShape
from jousto.mechanism.contacts.effective_mass import angular_mobility, mobility
from jousto.mechanism.contacts.ellipsoid import Ellipsoid
from jousto.mechanism.contacts.laws import NUMBERS, ContactLaw, Hertz, rest_damping
from jousto.mechanism.contacts.pairing import paired
from jousto.mechanism.contacts.shapes import (
    Capsule,
    ConvexHull,
    Cuboid,
    Cylinder,
    Shape,
    Torus,
    reach,
    touching,
)

SHAPE_ROW, TIP_ROW, LAW_ROW = 16, 10, 22
"""Numbers of a row of shapes, of tips and of laws (``contact_rows.h`` of the engine)."""
KINDS = 11
"""Number of types of shapes in ``jo_shape_type`` of the engine."""
HULL, SURFACE = 9, 10
"""Types of a shape that is only a polytope, and of one of triangles."""
NEITHER, SECOND, FIRST, CONVEX = 0, 1, 2, 3
"""Which shape of a pair has the tips that touch the other one; `CONVEX`: they are polytopes."""


def span(exponent: float) -> float:
    """Return c of the duration ``c (m / (K v^(n-1)))^(1/(n+1))`` of a touch without loss."""
    n = exponent
    c = sqrt(pi) * gamma(1.0 + 1.0 / (n + 1.0)) / gamma(0.5 + 1.0 / (n + 1.0))
    return float(2.0 * c * (0.5 * (n + 1.0)) ** (1.0 / (n + 1.0)))


def inner_radius(shape: ConvexHull) -> float:
    """Return the radius of the largest sphere about the mean of the vertices in a hull, m."""
    planes = shape.polytope.planes
    return float((planes[:, 3] - planes[:, :3] @ shape.polytope.vertices.mean(axis=0)).min())


def curvatures(shape: Shape) -> tuple[float, float]:
    """Return the mean curvatures of a shape that is touched, and of its tips, 1/m.

    Edges and corners, to which the law of Hertz gives no stiffness, have that of the largest
    sphere inside of the shape.
    """
    whole = shape.curvature
    if whole is not None:
        return whole, whole
    if isinstance(shape, Capsule):
        return 0.5 / shape.radius, 1.0 / shape.radius
    if isinstance(shape, Cuboid):
        return 0.0, 1.0 / min(shape.size)
    if isinstance(shape, Cylinder):
        return 0.5 / shape.radius, 1.0 / min(shape.size)
    if isinstance(shape, ConvexHull):
        return 0.0, 1.0 / inner_radius(shape)
    if isinstance(shape, Torus):
        mean = 0.5 / (shape.tube or shape.radius) + 0.5 / (shape.radius + shape.tube)
        return mean, mean
    if isinstance(shape, Ellipsoid):  # of the sphere of equal volume
        a, b, c = shape.size
        return (a * b * c) ** (-1.0 / 3.0), (a * b * c) ** (-1.0 / 3.0)
    (radius, *_) = shape.size or (0.0,)
    if not radius:
        return 0.0, 0.0
    return (-0.5 if shape.hollow else 0.5) / radius, 0.0


def type_of(shape: Shape) -> int:
    """Return the type of a shape in ``jo_shape_type`` of the engine."""
    if shape.mesh is not None:
        return SURFACE
    return shape.code if shape.code >= 0 else HULL


def tips_of_pair(first: Shape, second: Shape) -> int:
    """Return how two shapes touch: which one has the tips, as polytopes, or `NEITHER`."""
    if first.mesh is not None or second.mesh is not None:
        return CONVEX if paired(first, second) or paired(second, first) else NEITHER
    if touching(first, second) is not None:
        return SECOND
    if touching(second, first) is not None:
        return FIRST
    both = all(one.polytope is not None for one in (first, second))
    return CONVEX if both and not (first.hollow and second.hollow) else NEITHER


def touching_table(shapes: Iterable[Shape]) -> Array:
    """Return `tips_of_pair` (KINDS, KINDS) of the kinds of shapes that there are."""
    kinds = {type_of(shape): shape for shape in shapes}
    found = np.zeros((KINDS, KINDS))
    for i, first in kinds.items():
        for j, second in kinds.items():
            found[i, j] = tips_of_pair(first, second)
    return found


def shape_numbers(shape: Shape, hulls: bool) -> list[Array]:
    """Return the numbers of a polytope, or of a surface and, where needed, of its hull."""
    surface, polytope = shape.mesh, None
    if surface is None or hulls:
        polytope = shape.polytope
    return [one.numbers for one in (surface, polytope) if one is not None]


def polytope_numbers(shapes: Sequence[Shape], used: Sequence[bool]) -> tuple[Array, list[int]]:
    """Return the numbers of the polytopes for the engine, and the place of those of each shape.

    Equal shapes share their numbers; a shape that is not used has the place -1.
    """
    parts: list[Array] = []
    known: dict[tuple[Any, ...], int] = {}
    places, end = [], 0
    hulls = any(shape.hollow and shape.polytope is not None for shape in shapes)
    for shape, needed in zip(shapes, used, strict=True):
        if not needed:
            places.append(-1)
            continue
        points = shape.points.tobytes() if isinstance(shape, ConvexHull) else b""
        surface = id(shape) if shape.mesh is not None else 0
        key = type(shape), shape.size, points, surface
        if key not in known:
            known[key] = end
            numbers = shape_numbers(shape, hulls)
            parts += numbers
            end += sum(map(len, numbers))
        places.append(known[key])
    return np.concatenate([np.zeros(0), *parts]), places


@dataclass(frozen=True)
class PairLaw:
    """Law, friction and resistance between two surfaces.

    Parameters
    ----------
    law : ContactLaw
        Law of the normal force.
    friction : tuple of float
        Coefficients of friction while they slip, and up to which they stick.
    lengths : tuple of float
        Lengths of the resistance to rolling and drilling, m.
    """

    law: ContactLaw
    friction: tuple[float, float]
    lengths: tuple[float, float] = (0.0, 0.0)

    def __str__(self) -> str:
        kinetic, static = self.friction
        text = f"{self.law!r}, friction {kinetic:.4g} slips, {static:.4g} sticks"
        if not any(self.lengths):
            return text
        return f"{text}, rolling {self.lengths[0]:.4g} m, drilling {self.lengths[1]:.4g} m"


def law_row(pair: PairLaw, shear: float, velocity: float, *, strikes: bool) -> Array:
    """Return the numbers of a law (22,) as in ``jo_law_row`` of the engine.

    ``shear``: ratio of the stiffness of the bristle; ``velocity``: that of smooth friction, m/s, 0
    for a bristle; ``strikes``: whether touches are impulses.
    """
    law, (kinetic, static) = pair.law, pair.friction
    x = NUMBERS | law.numbers(1.0)
    if strikes:
        x["damping"] = rest_damping(law, x)
    hertz = float(isinstance(law, Hertz))
    names = ("stiffness", "exponent", "damping", "slowest", "viscous", "full")
    bristle = shear if static and not velocity else 0.0
    loss = getattr(law, "restitution", 0.0)
    usual = [hertz, *(x[key] for key in names), static, kinetic, bristle, span(x["exponent"]), loss]
    return np.array([*usual, velocity, x["curve"], x["extent"], *pair.lengths, *x["impedance"]])


def shape_rows(
    shapes: Sequence[CollisionShape],
    markers: Sequence[int],
    polytopes: Sequence[int],
    surfaces: Sequence[int],
    groups: Sequence[int],
) -> tuple[Array, Array]:
    """Return rows of the shapes (ns, 16) and of their tips (nt, 10) as in the engine."""
    rows = np.zeros((len(shapes), SHAPE_ROW))
    tips: list[tuple[float, ...]] = []
    for i, one in enumerate(shapes):
        shape = one.shape
        far = max((tip.reach for tip in shape.tips), default=0.0)
        size = (*shape.size, 0.0, 0.0, 0.0)[:3]
        rows[i] = (
            *(markers[i], type_of(shape), *size, reach(shape), len(tips), len(shape.tips)),
            *curvatures(shape),
            mobility(one.marker, hypot(*shape.size)),
            mobility(one.marker, far),
            angular_mobility(one.marker),
            *(polytopes[i], surfaces[i], groups[i]),
        )
        tips += [
            (i, *tip.centre, tip.radius, tip.ring, tip.place, *(tip.axes or (0.0, 0.0, 0.0)))
            for tip in shape.tips
        ]
    return rows, np.array(tips, dtype=float).reshape(-1, TIP_ROW)


def group_table(groups: Mapping[str, int], apart: Sequence[Apart]) -> Array:
    """Return whether the shapes of two groups touch (ng, ng)."""
    meets = np.ones((len(groups), len(groups)))
    for pair in apart:
        if pair.a in groups and pair.b in groups:
            i, j = groups[pair.a], groups[pair.b]
            meets[i, j] = meets[j, i] = 0.0
    return meets


def excluded_keys(
    shapes: Sequence[CollisionShape],
    groups: Mapping[str, int],
    apart: Sequence[Apart],
    bodies: Sequence[tuple[int, int]],
    body_of: Sequence[int],
) -> Array:
    """Return the pairs i < j of shapes that never touch, as ``i ns + j``, ascending.

    Parameters
    ----------
    shapes, groups, apart
        Shapes, numbers of their groups, and excluded pairs with the name of a shape.
    bodies : sequence of (int, int)
        Pairs of bodies that never touch.
    body_of : sequence of int
        Body of each shape.
    """
    n = len(shapes)
    named: dict[str, list[int]] = {}
    on: dict[int, list[int]] = {}
    for i, one in enumerate(shapes):
        named.setdefault(one.group, []).append(i)
        on.setdefault(body_of[i], []).append(i)
    named |= {one.name: [i] for i, one in enumerate(shapes) if one.name not in groups}
    pairs = [
        (named[pair.a], named[pair.b])
        for pair in apart
        if not (pair.a in groups and pair.b in groups)
    ]
    pairs += [(on.get(a, []), on.get(b, [])) for a, b in bodies]
    keys = {min(i, j) * n + max(i, j) for a, b in pairs for i in a for j in b if i != j}
    return np.array(sorted(keys), dtype=float)


def joined_bodies(joints: Iterable[tuple[int, int, bool]]) -> list[tuple[int, int]]:
    """Return the pairs of bodies that joints connect, welded bodies counting as one.

    The ground, and what is welded to it, is not connected with anything by a joint: an arm on the
    floor may touch the floor.

    Parameters
    ----------
    joints : iterable of (int, int, bool)
        Bodies of each joint, -1 for the ground, and whether it is rigid.
    """
    joints = list(joints)
    leader: dict[int, int] = {}

    def root(body: int) -> int:
        while leader.get(body, body) != body:
            body = leader[body]
        return body

    for a, b, rigid in joints:
        if rigid:
            low, high = sorted((root(a), root(b)))
            leader[high] = low  # the ground leads
    members: dict[int, list[int]] = {}
    for body in {body for a, b, _ in joints for body in (a, b)}:
        members.setdefault(root(body), []).append(body)
    pairs: set[tuple[int, int]] = set()
    for some in members.values():
        pairs |= {(a, b) for a in some for b in some if a < b}
    for a, b, _ in joints:
        if root(a) != root(b) and -1 not in (root(a), root(b)):
            pairs |= {(x, y) for x in members[root(a)] for y in members[root(b)]}
    return sorted(pairs)


def coupled_bodies(rows: Array, meets: Array, body_of: Sequence[int]) -> list[set[int]]:
    """Return sets of moving bodies any two of which may touch, by groups of shapes."""
    of_group: dict[int, set[int]] = {}
    for group, body in zip(rows[:, -1].astype(int).tolist(), body_of, strict=True):
        of_group.setdefault(group, set()).add(body)
    found = []
    for i, some in of_group.items():
        for j, others in of_group.items():
            if j < i or not meets[i, j] or some == {-1} or others == {-1}:
                continue
            found.append((some | others) - {-1})
    return found
