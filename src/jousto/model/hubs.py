"""Hubs: rigid bodies with many joints, and the elimination order of joints and hubs.

The joints of one body are all coupled, so that they form a dense block of ``S = Cq M^-1 Cq^T``.
Instead the velocities of a hub are unknowns of the factorisation: ``[D V; V^T -1]`` with ``S = D +
V V^T``, where D contains the coupling through the other bodies.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from jousto.model.elimination_order import Elimination, eliminate
from jousto.model.model import BodyModel, JointModel, MarkerModel

MANY = 24
"""Number of joints above which a body is a hub; for fewer the dense block is equally fast."""
GROUND = -1


def joints_on(joints: Sequence[JointModel], markers: Sequence[MarkerModel]) -> dict[int, list[int]]:
    """Return the joints on each moving body that has joints, in their order."""
    found: dict[int, list[int]] = {}
    for k, joint in enumerate(joints):
        for side in joint.sides:
            body = markers[side].body
            if body != GROUND:
                some = found.setdefault(body, [])
                if not some or some[-1] != k:  # two sides may be on one body
                    some.append(k)
    return found


def order_joints(
    joints: Sequence[JointModel],
    markers: Sequence[MarkerModel],
    bodies: Sequence[BodyModel],
    most: float = math.inf,
) -> Elimination:
    """Return the elimination order of joints and hubs.

    Raises
    ------
    TooDense
        See `eliminate`.
    """
    on_body, rows = joints_on(joints, markers), [joint.rows for joint in joints]
    hubs = [body for body, some in on_body.items() if len(some) > MANY and not bodies[body].n]
    if not hubs:
        return eliminate(rows, on_body.values(), most=most)
    place = {body: len(joints) + i for i, body in enumerate(hubs)}
    cliques: list[Sequence[int]] = [some for body, some in on_body.items() if body not in place]
    cliques += [(k, place[body]) for body in hubs for k in on_body[body]]
    ends = [{markers[side].body for side in joint.sides} for joint in joints]
    after = {k: place.values() for k in closing(ends, {GROUND, *hubs})}
    made = eliminate([*rows, *(6 for _ in hubs)], cliques, after, most)
    return replace(made, hubs=tuple(hubs))


def closing(ends: Sequence[set[int]], held: set[int]) -> set[int]:
    """Return the joints whose rows may be redundant while some bodies are fixed.

    A group of bodies connected to a single fixed body has independent rows. In a group connected to
    several fixed bodies, the joints to all but one fixed body are eliminated later, as are joints
    between fixed bodies.

    Parameters
    ----------
    ends : sequence of set of int
        Bodies of each joint.
    held : set of int
        Hubs and ground.

    Examples
    --------
    Two bodies between ground and hub 9, and one that is connected to the hub only:

    >>> sorted(closing([{-1, 0}, {0, 1}, {1, 9}, {9, 2}, {9, -1}], {-1, 9}))
    [2, 4]
    """
    root = _pieces([some - held for some in ends])
    joined: dict[int, Counter[int]] = {}  # number of joints of each group to each fixed body
    for some in ends:
        for body in some - held:
            joined.setdefault(root[body], Counter()).update(sorted(some & held))
            break
    found = set()
    for k, some in enumerate(ends):
        free = some - held
        if not free:
            found.add(k)
            continue
        counts = joined[root[min(free)]]
        if some & held and some & held != {counts.most_common(1)[0][0]}:
            found.add(k)
    return found


def _pieces(groups: Iterable[set[int]]) -> Mapping[int, int]:
    """Return the representative of the connected group of each body."""
    roots: dict[int, int] = {}

    def root(body: int) -> int:
        while roots.setdefault(body, body) != body:
            roots[body] = body = roots[roots[body]]
        return body

    for group in groups:
        first, *others = sorted(group) or (None,)
        if first is None:
            continue
        root(first)
        for body in others:
            one, other = sorted((root(first), root(body)))
            roots[other] = one
    return {body: root(body) for body in list(roots)}
