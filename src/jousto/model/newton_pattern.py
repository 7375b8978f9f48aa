"""Newton's matrix of the implicit methods: its nodes, their order, fill and memory."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from jousto.model.elimination_order import eliminate
from jousto.model.model import JointModel, Model

PAD = 4  # rows of a block are padded to a multiple of this number
CARRIED = 6  # largest number of constraint rows assigned to a body
STRUCTURE = ("bodies", "joints", "forces", "beams", "markers", "coordinates")


@dataclass(frozen=True)
class NewtonPattern:
    """Block pattern of ``[M^ Cq^T; Cq 0]`` and of its LU factors, computed once per mechanism.

    A node is a body and its joint towards the ground, so that its pivot block is regular, or the
    joints that close a loop, after the bodies of the loop.

    Attributes
    ----------
    nodes : tuple of (int, int, int, int, int, int, int)
        In elimination order: body (-1: joints only), number of unknowns, number of those of the
        body, first unknown, offset of the diagonal block, first branch, number of branches.
    branches : tuple of (int, int, int, int)
        Blocks of a node with later nodes: later node, number of its leading unknowns used, offsets
        of the blocks below the diagonal (width x size) and right of it (size x width).
    fills : tuple of (int, int, int, int)
        Products of every node: offset and stride of the target, branches left and right.
    first : tuple of int
        Range of fills of every node (nodes + 1).
    places : tuple of (int, int)
        Node and first unknown in it of every body, then of every joint.
    reals : int
        Size of the matrix in memory, count of numbers.
    """

    nodes: tuple[tuple[int, int, int, int, int, int, int], ...]
    branches: tuple[tuple[int, int, int, int], ...]
    fills: tuple[tuple[int, int, int, int], ...]
    first: tuple[int, ...]
    places: tuple[tuple[int, int], ...]
    reals: int


_KNOWN: WeakKeyDictionary[Model, NewtonPattern] = WeakKeyDictionary()


def padded(count: int) -> int:
    """Return a count rounded up to a multiple of the padding."""
    return -(-count // PAD) * PAD


def newton_pattern(model: Model) -> NewtonPattern:
    """Return the pattern of Newton's matrix of a model, cached for models of equal structure."""
    if model not in _KNOWN:
        alike = (other for other in _KNOWN if _same_structure(model, other))
        same = next(alike, None)
        _KNOWN[model] = _pattern(model) if same is None else _KNOWN[same]
    return _KNOWN[model]


def _same_structure(model: Model, other: Model) -> bool:
    """Return whether two models have equal lists of everything that determines the pattern."""
    return all(getattr(model, name) is getattr(other, name) for name in STRUCTURE)


def newton_entries(model: Model) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.intp]]:
    """Return memory index, row and column of every entry, rows and columns as in [v, lam]."""
    pattern = newton_pattern(model)
    unknown: list[list[int]] = [[0] * node[1] for node in pattern.nodes]
    items = [(b.iv, 6 + b.n) for b in model.bodies]
    items += [(model.nv + joint.row, joint.rows) for joint in model.joints]
    for (place, local), (first, count) in zip(pattern.places, items, strict=True):
        unknown[place][local : local + count] = range(first, first + count)
    own = [np.array(x, dtype=np.intp) for x in unknown]
    blocks = []  # start, stride, rows, columns
    for mine, node in zip(own, pattern.nodes, strict=True):
        stride = padded(node[1])
        blocks.append((node[4], stride, mine, mine))
        for later, width, lower, upper in pattern.branches[node[5] : node[5] + node[6]]:
            other = own[later][:width]
            blocks.append((lower, stride, other, mine))
            blocks.append((upper, padded(width), mine, other))
    at, rows, columns = [], [], []
    for start, stride, r, c in blocks:
        at.append((start + stride * np.arange(len(r))[:, None] + np.arange(len(c))).ravel())
        rows.append(np.repeat(r, len(c)))
        columns.append(np.tile(c, len(r)))
    none = np.zeros(0, dtype=np.intp)
    return (
        np.concatenate([none, *at]),
        np.concatenate([none, *rows]),
        np.concatenate([none, *columns]),
    )


def _pattern(model: Model) -> NewtonPattern:
    moving = [_moving(model, joint.sides) for joint in model.joints]
    parent, carried, loops = _tree(model, moving)
    sizes = [6 + body.n for body in model.bodies]
    nb = len(sizes)
    members = [[b, *(nb + j for j in carried[b])] for b in range(nb)]
    members += [[nb + j] for j in loops]
    size_of = [*sizes, *(joint.rows for joint in model.joints)]
    home: dict[int, tuple[int, int]] = {}
    total = []
    for index, items in enumerate(members):
        at = 0
        for item in items:
            home[item] = (index, at)
            at += size_of[item]
        total.append(at)
    cliques = [[*bodies, nb + j] for j, bodies in enumerate(moving)]
    for force in model.forces:
        sides = [force.a, force.b]
        for place in force.coordinates:
            sides += [model.coordinates[place].a, model.coordinates[place].b]
        cliques.append(_moving(model, [s for s in sides if s >= 0]))
        cliques += [list(bodies) for bodies in force.coupled]
    cliques += [[beam.a, beam.b] for beam in model.beams]
    width: dict[
        tuple[int, int], int
    ] = {}  # number of leading unknowns of the second node coupled with the first
    for clique in cliques:
        for x in clique:
            for y in clique:
                i, (j, at) = home[x][0], home[y]
                if i != j:
                    width[i, j] = max(width.get((i, j), 0), at + size_of[y])
    after = {nb + k: _path(parent, moving[j]) for k, j in enumerate(loops)}
    touching = [sorted({home[x][0] for x in clique}) for clique in cliques]
    found = eliminate([1] * len(members), touching, after)
    return _storage(members, nb, sizes, total, home, width, found.order, found.below)


def _storage(
    members: Sequence[Sequence[int]],
    nb: int,
    sizes: Sequence[int],
    total: Sequence[int],
    home: dict[int, tuple[int, int]],
    width: dict[tuple[int, int], int],
    order: Sequence[int],
    below: Sequence[Sequence[tuple[int, int]]],
) -> NewtonPattern:
    """Assign memory to the blocks, in elimination order."""
    place = {node: c for c, node in enumerate(order)}
    for column, node in zip(below, order, strict=True):  # fill-in
        touched = [i for _, i in column]
        for i in touched:
            for j in touched:
                if i != j:
                    width[i, j] = max(width.get((i, j), 0), width[node, j])
    nodes: list[tuple[int, int, int, int, int, int, int]] = []
    branches: list[tuple[int, int, int, int]] = []
    reals = at = 0
    where: dict[tuple[int, int], int] = {}
    for column, node in zip(below, order, strict=True):
        body = members[node][0] if members[node][0] < nb else -1
        size, stride = total[node], padded(total[node])
        nodes.append(
            (body, size, sizes[body] if body >= 0 else 0, at, reals, len(branches), len(column))
        )
        at += size
        reals += size * stride
        for _, later in column:
            w = width[node, later]
            where[node, later] = len(branches)
            branches.append((place[later], w, reals, reals + w * stride))
            reals += w * stride + size * padded(w)
    fills, first = [], [0]
    for column, node in zip(below, order, strict=True):
        for _, i in column:
            for _, j in column:
                left, right = where[node, i], where[node, j]
                if i == j:
                    fills.append((nodes[place[i]][4], padded(total[i]), left, right))
                elif place[i] < place[j]:
                    branch = branches[where[i, j]]
                    fills.append((branch[3], padded(branch[1]), left, right))
                else:
                    fills.append((branches[where[j, i]][2], padded(total[j]), left, right))
        first.append(len(fills))
    places = tuple((place[home[item][0]], home[item][1]) for item in range(len(home)))
    return NewtonPattern(tuple(nodes), tuple(branches), tuple(fills), tuple(first), places, reals)


def _moving(model: Model, markers: Sequence[int]) -> list[int]:
    """Return the bodies of markers without duplicates and without the ground."""
    return list(dict.fromkeys(b for b in (model.markers[k].body for k in markers) if b >= 0))


def _tree(
    model: Model, moving: Sequence[list[int]]
) -> tuple[list[int], list[list[int]], list[int]]:
    """Return the parent of every body (-1: ground or none), its joints, and the loops."""
    count = len(model.bodies)
    on_body: list[list[int]] = [[] for _ in range(count + 1)]  # the last entry is the ground
    for j, joint in enumerate(model.joints):
        ground = any(model.markers[side].body < 0 for side in joint.sides)
        for b in [*moving[j], *([count] if ground else [])]:
            on_body[b].append(j)
    parent = [-1] * count
    carried: list[list[int]] = [[] for _ in range(count)]
    known, used = [False] * count, [False] * len(model.joints)
    for root in (count, *range(count)):
        if root < count:
            if known[root]:
                continue
            known[root] = True
        queue = deque([root])
        while queue:
            at = queue.popleft()
            for j in on_body[at]:
                if used[j] or not _carries(model.joints[j]):
                    continue
                new = [b for b in moving[j] if not known[b]]
                others = [b for b in moving[j] if known[b] and b != at]
                if len(new) != 1 or others:
                    continue
                parent[new[0]] = at if at < count else -1
                carried[new[0]].append(j)
                known[new[0]] = used[j] = True
                queue.append(new[0])
    for j, joint in enumerate(model.joints):  # drives and locks of the joint assigned to a body
        for b in moving[j] if not used[j] else ():
            first = moving[carried[b][0]] if carried[b] else None
            rows = joint.rows + sum(model.joints[k].rows for k in carried[b])
            if first is not None and set(first) == set(moving[j]) and rows <= CARRIED:
                carried[b].append(j)
                used[j] = True
                break
    return parent, carried, [j for j in range(len(model.joints)) if not used[j]]


def _carries(joint: JointModel) -> bool:
    return len(joint.sides) == 2


def _path(parent: Sequence[int], bodies: Sequence[int]) -> set[int]:
    """Return the bodies of the loop that a joint between `bodies` closes."""
    lines = []
    for b in bodies:
        line = [b]
        while parent[line[-1]] >= 0:
            line.append(parent[line[-1]])
        lines.append(line)
    shared = set(lines[0]).intersection(*lines[1:]) if lines else set()
    if len(lines) < 2:
        return set(lines[0]) if lines else set()
    top = next((b for b in lines[0] if b in shared), None)
    return {b for line in lines for b in line if b not in shared} | (
        {top} if top is not None else set()
    )
