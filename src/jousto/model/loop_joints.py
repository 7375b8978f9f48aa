"""Loops: joints outside the spanning tree in the engine's order; their rows close loops."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from jousto.model.model import LinkModel, Model

MOVING = {"hinge", "slide", "ball", "free"}
MEETINGS = 8
"""Largest mean number of pairs of loops per body for which "auto" selects a tree with loops.

Measured: 1 pair per body (four-bar linkages), 2.5 to 5 times faster than the positions of the
bodies; 6 pairs (Stewart platform), 1.6 to 2.2 times (benchmarks/loops.py). Chains with a rod from
each body to the ground, with the cheapest rows: 5 to 15 pairs equally fast, 22 pairs 25 % slower.
"""


class Loops(NamedTuple):
    """Lists jo_loop, jo_reach and jo_meet of jousto.h."""

    loops: list[tuple[int, int, int, int, int]]
    reaches: list[tuple[int, int]]
    meets: list[tuple[int, int]]


def spanning(edges: Sequence[tuple[int, int, int]]) -> list[int]:
    """Return the joints of a spanning tree; joints with many rows are kept in it.

    Parameters
    ----------
    edges : sequence of (int, int, int)
        Bodies of both sides, from 0, -1 for the ground, and number of rows of each joint. Of joints
        with the same number of rows the later ones are cut.

    Returns
    -------
    list of int
        Indices in `edges`, ascending.

    Examples
    --------
    A triangle on the ground whose last side is a ball:

    >>> spanning([(-1, 0, 5), (0, 1, 3), (1, -1, 5)])
    [0, 2]
    """
    roots = {body: body for a, b, _ in edges for body in (a, b)}

    def root(body: int) -> int:
        while roots[body] != body:
            body = roots[body]
        return body

    found = []
    for k in sorted(range(len(edges)), key=lambda k: -edges[k][2]):
        a, b = (root(body) for body in edges[k][:2])
        if a != b:
            roots[max(a, b)] = min(a, b)
            found.append(k)
    return sorted(found)


def cut_joints(model: Model, links: Iterable[LinkModel]) -> list[int]:
    """Return the joints, couplings and drives that are not links of the tree."""
    taken = {place for link in links for place in (link.joint, link.drive)}
    return [k for k, joint in enumerate(model.joints) if k not in taken and joint.lock < 0]


def loops_of(model: Model) -> Loops:
    """Return the loops of the tree; loops that share moving links form one group."""
    links = () if model.mixed else model.links
    cut = cut_joints(model, links) if links else []
    of_body = {link.body: i for i, link in enumerate(links) if link.body >= 0}
    paths = {k: _path(model, links, of_body, k) for k in cut}
    found = Loops([], [], [])
    for number, group in enumerate(_groups(links, paths)):
        row, seen = 0, list[tuple[int, int]]()
        for k in group:
            first, path = len(found.reaches), paths[k]
            at = {link: first + i for i, link in enumerate(path)}
            found.reaches.extend((link, at.get(links[link].parent, -1)) for link in path)
            found.loops.append((k, number, row, first, len(path)))
            row += model.joints[k].rows
            seen += [(link, place) for link, place in at.items() if is_moving(links[link])]
        found.meets.extend(_meets(seen))
    return found


def drawback(model: Model) -> str:
    """Return why a tree is not faster than coordinates of all bodies; empty if it is faster.

    Loops with many common links form a dense matrix, and each row depends on all links of its loop;
    then the sparse rows of all joints need fewer operations.
    """
    if all(link.kind == "free" for link in model.links):
        return "no joint connects a body"
    if _meet_often(model):
        return "its loops have many common bodies"
    return ""


def _meet_often(model: Model) -> bool:
    """Return whether there are too many pairs of loops, without listing them."""
    links, most = model.links, MEETINGS * len(model.bodies)
    of_body = {link.body: i for i, link in enumerate(links) if link.body >= 0}
    passed, meetings = [0] * len(links), 0
    for k in cut_joints(model, links):
        for link in _path(model, links, of_body, k):
            if not is_moving(links[link]):
                continue
            passed[link] += 1
            # pairs with all loops through the link, and of the loop with itself
            meetings += passed[link]
            if meetings >= most:
                return True
    return False


def _meets(seen: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Return the pairs of reaches on one link, each reach with itself included."""
    of_link: dict[int, list[int]] = {}
    for link, place in seen:
        of_link.setdefault(link, []).append(place)
    return sorted((a, b) for places in of_link.values() for a in places for b in places if a <= b)


def is_moving(link: LinkModel) -> bool:
    """Return whether a link can move freely, and not only by a drive."""
    return link.kind in MOVING and link.driven < 0


def _path(
    model: Model, links: tuple[LinkModel, ...], of_body: dict[int, int], joint: int
) -> list[int]:
    """Return the links between the sides of a joint and the ground, children first."""
    path = set[int]()
    for side in model.joints[joint].sides:
        body = model.markers[side].body
        link = of_body[body] if body >= 0 else -1
        while link >= 0 and link not in path:
            path.add(link)
            link = links[link].parent
    return sorted(path, reverse=True)


def _groups(links: tuple[LinkModel, ...], paths: dict[int, list[int]]) -> list[list[int]]:
    """Return groups of the joints that share moving links."""
    roots = {k: k for k in paths}

    def root(k: int) -> int:
        while roots[k] != k:
            roots[k] = k = roots[roots[k]]
        return k

    first: dict[int, int] = {}
    for k, path in paths.items():
        for link in path:
            if is_moving(links[link]):
                one, other = sorted((root(first.setdefault(link, k)), root(k)))
                roots[other] = one
    groups: dict[int, list[int]] = {}
    for k in paths:
        groups.setdefault(root(k), []).append(k)
    return list(groups.values())
