"""Loop: the joints of a tree that no link is, whose rows close loops, in the engine's order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from jousto.model.model import LinkModel, Model

MOVING = {"hinge", "slide", "ball", "free"}
MEETINGS = 8
"""Most meetings of loops in a link, a body, up to which a tree with loops is taken by itself.

Measured: 1 meeting a body, four-bars, 2.5 to 5 times faster than the positions of the bodies; 6,
the Stewart platform, 1.6 to 2.2 times (benchmarks/loops.py). Chains with a rod from each body to
the ground, whose rows are the cheapest there: 5 to 15 meetings as fast, 22 slower by a quarter.
"""


class Loops(NamedTuple):
    """The lists of jousto.h: jo_loop, jo_reach and jo_meet."""

    loops: list[tuple[int, int, int, int, int]]
    reaches: list[tuple[int, int]]
    meets: list[tuple[int, int]]


def spanning(edges: Sequence[tuple[int, int, int]]) -> list[int]:
    """Return which joints span a tree: of those that close a loop those with most rows.

    Parameters
    ----------
    edges : sequence of (int, int, int)
        Bodies of both sides, from 0, -1 for the ground, and rows of each joint. Of joints with
        the same number of rows the later ones are cut.

    Returns
    -------
    list of int
        Places in `edges`, ascending.

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
    """Return the joints, couplings and drives that no link is."""
    taken = {place for link in links for place in (link.joint, link.drive)}
    return [k for k, joint in enumerate(model.joints) if k not in taken and joint.lock < 0]


def loops_of(model: Model) -> Loops:
    """Return the loops of the tree that runs, those that move one another side by side."""
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
    """Return why a tree is not faster than the positions of the bodies; empty where it is.

    Loops that have many links in common fill a dense matrix, and each of their rows runs along all
    of the links: then sparse rows of all joints are less work.
    """
    if all(link.kind == "free" for link in model.links):
        return "no joint leads to a body"
    if _meet_often(model):
        return "its loops have many bodies in common"
    return ""


def _meet_often(model: Model) -> bool:
    """Return whether there are too many meetings, without listing them: they may be very many."""
    links, most = model.links, MEETINGS * len(model.bodies)
    of_body = {link.body: i for i, link in enumerate(links) if link.body >= 0}
    passed, meetings = [0] * len(links), 0
    for k in cut_joints(model, links):
        for link in _path(model, links, of_body, k):
            if not is_moving(links[link]):
                continue
            passed[link] += 1
            meetings += passed[link]  # with all that pass it, and with itself
            if meetings >= most:
                return True
    return False


def _meets(seen: list[tuple[int, int]]) -> list[tuple[int, int]]:
    """Pairs of reaches of one link, each with itself too."""
    of_link: dict[int, list[int]] = {}
    for link, place in seen:
        of_link.setdefault(link, []).append(place)
    return sorted((a, b) for places in of_link.values() for a in places for b in places if a <= b)


def is_moving(link: LinkModel) -> bool:
    """Return whether a link moves other than a drive tells it."""
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
    """Return the joints by groups that share no moving link."""
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
