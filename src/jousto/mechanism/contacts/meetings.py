"""Which kinds of shapes of a set touch one another, and how."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from jousto.base.errors import Problems
from jousto.mechanism.contacts.collision import Apart, CollisionShape
from jousto.mechanism.contacts.pair_tables import CONVEX, FIRST, NEITHER, SECOND, tips_of_pair
from jousto.mechanism.contacts.pairing import check_pair, most_points, paired
from jousto.mechanism.contacts.shapes import Shape

PAIRS_EACH = 3
"""Slots for pairs of polytopes for each of these."""
SURFACES_EACH = 2
"""Slots for each shape that is a polytope for surfaces of triangles only."""


@dataclass(frozen=True)
class Meetings:
    """How the shapes of a set touch one another.

    Attributes
    ----------
    tips : int
        Number of spheres, corners and ends that touch another shape.
    convex : tuple of bool
        Whether each shape touches another one as a polytope.
    points : int
        Largest number of points of two polytopes.
    near : int
        Number of pairs of polytopes, or of one and a surface of triangles, that are near at a time
        in usual machines.
    """

    tips: int
    convex: tuple[bool, ...]
    points: int
    near: int


def meetings(shapes: Sequence[Shape]) -> Meetings:
    """Return how the shapes of a set touch one another, from one shape of each kind."""
    count = Counter(type(shape) for shape in shapes)
    kinds = {type(shape): shape for shape in shapes}
    ways = {
        (a, b): tips_of_pair(x, y)
        for a, x in kinds.items()
        for b, y in kinds.items()
        if a is not b or count[a] > 1
    }
    convex = {kind for pair, how in ways.items() if how == CONVEX for kind in pair}
    tipped = {kind for pair, how in ways.items() if how in (FIRST, SECOND) for kind in pair}
    pairs = [
        (kinds[a], kinds[b])
        for (a, b), how in ways.items()
        if how == CONVEX and is_touched(kinds[a], kinds[b])
    ]
    solid = {kind for pair in pairs if not any(x.mesh for x in pair) for kind in map(type, pair)}
    each = {kind: PAIRS_EACH if kind in solid else SURFACES_EACH for kind in convex}
    return Meetings(
        sum(n * len(kinds[kind].tips) for kind, n in count.items() if kind in tipped),
        tuple(type(shape) in convex for shape in shapes),
        max((most_points(a, b) for a, b in pairs), default=0),
        sum(each[kind] * n for kind, n in count.items() if kind in convex),
    )


def is_touched(on: Shape, of: Shape) -> bool:
    """Return whether the first of two polytopes may be the one that is touched.

    A half-space is, and a surface of triangles unless it touches a half-space.
    """
    return paired(on, of) and (of.mesh is None or on.hollow)


def check_kinds(
    problems: Problems,
    where: str,
    shapes: Sequence[CollisionShape],
    apart: Sequence[Apart],
) -> None:
    """Report pairs of kinds of shapes that are not available, once for each pair of kinds."""
    named = {name for pair in apart for name in (pair.a, pair.b)}
    kinds: dict[Any, tuple[CollisionShape, set[int]]] = {}
    for one in shapes:
        own = one.name if one.name in named or one.shape.mesh is not None else ""
        key = one.group, type(one.shape), own
        kinds.setdefault(key, (one, set()))[1].add(id(one.marker.body))
    excluded = {frozenset((pair.a, pair.b)) for pair in apart}
    reported: set[frozenset[str]] = set()
    for first, some in kinds.values():
        for second, others in kinds.values():
            tags = frozenset((first.shape.tag, second.shape.tag))
            if tags in reported or len(some | others) < 2:
                continue
            labels = ((a, b) for a in labels_of(first) for b in labels_of(second))
            if any(frozenset(pair) in excluded for pair in labels):
                continue
            how = tips_of_pair(first.shape, second.shape)
            if how == CONVEX and is_touched(first.shape, second.shape):
                check_pair(problems, where, first.shape, second.shape)
            if how == NEITHER:
                reported.add(tags)
                problems.add(
                    where,
                    f"{first.shape.tag} and {second.shape.tag} cannot touch in this version "
                    f"({first.name!r} and {second.name!r}); exclude them with Apart, or take "
                    "spheres or a hull at the places that touch",
                    "shapes",
                )


def labels_of(one: CollisionShape) -> tuple[str, str]:
    """Return the names by which `Apart` refers to a shape."""
    return one.name, one.group
