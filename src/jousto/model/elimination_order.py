"""Elimination order of the joints: symbolic block Cholesky of S = Cq M^-1 Cq^T."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from jousto.base.object_repr import described

MOST = 15_000_000
"""Largest number of block products in a factorisation; their list takes more than a gigabyte."""
LONG = 1000
"""Number of joints up to which chains are eliminated from both ends. In longer chains the last
pivot would vanish, since the stiffness of a fixed half decreases with the cube of its length."""


class TooDense(Exception):
    """Error raised if a Cholesky factor has too many products of blocks.

    Attributes
    ----------
    products : float
        Lower bound of the number of products.
    clique : tuple of int
        Joints that are all coupled with one another and are the cause; empty if loops are the
        cause.
    """

    def __init__(self, products: float, clique: Sequence[int] = ()) -> None:
        super().__init__(products)
        self.products = products
        self.clique = tuple(clique)


@described
@dataclass(frozen=True)
class Elimination:
    """Block pattern of the Cholesky factor, computed once per mechanism.

    Attributes
    ----------
    order : tuple of int
        Indices of joints in elimination order; diagonal block c belongs to joint ``order[c]``.
    below : tuple of tuple of (int, int)
        Blocks below the diagonal of every column: (block, joint).
    updates : tuple of tuple of (int, int, int, bool)
        Products of every column (target, left, right, rows of left, rows of right).
    blocks : dict of (int, int) to int
        Block of (joint of the row, joint of the column), the row eliminated later.
    fill : int
        Number of blocks of the factor that are zero in S.
    hubs : tuple of int
        Bodies whose velocities are also eliminated; in `order` their indices follow those of the
        joints.
    """

    order: tuple[int, ...]
    below: tuple[tuple[tuple[int, int], ...], ...]
    updates: tuple[tuple[tuple[int, int, int, int, int], ...], ...]
    blocks: dict[tuple[int, int], int]
    fill: int
    hubs: tuple[int, ...] = ()

    @property
    def count(self) -> int:
        """Number of blocks, diagonal ones included."""
        return len(self.order) + sum(len(column) for column in self.below)


def eliminate(
    rows: Sequence[int],
    cliques: Iterable[Sequence[int]],
    after: Mapping[int, Iterable[int]] | None = None,
    most: float = math.inf,
) -> Elimination:
    """Return an elimination order of the joints with little fill-in (none for chains and trees).

    Greedy minimum fill: a joint whose neighbours are all coupled with one another is always
    preferred, which eliminates any tree of bodies without fill (its joint graph is chordal). In
    large models with loops an upper bound of the fill is used (E. Rothberg and S. Eisenstat, SIAM
    J. Matrix Anal. Appl. 19 (1998) 682-695): exact counts take longer than the factorisation.

    Parameters
    ----------
    rows : sequence of int
        Constraint rows of every joint.
    cliques : iterable of sequence of int
        Joints on each moving body, which are coupled with one another.
    after : mapping of int to iterable of int, optional
        Joints that must be eliminated before a joint.
    most : float
        Largest allowed number of products of blocks.

    Raises
    ------
    TooDense
        If the factor would have more products than that, before they are listed.

    Examples
    --------
    >>> chain = eliminate([3, 3, 3, 3], [(0, 1), (1, 2), (2, 3)])
    >>> chain.count, chain.fill
    (7, 0)
    >>> ring = eliminate([3, 3, 3, 3], [(0, 1), (1, 2), (2, 3), (3, 0)])
    >>> ring.fill
    1
    """
    count = len(rows)
    near: list[set[int]] = [set() for _ in range(count)]
    shared, single = [0] * count, [0] * count  # cliques of several joints, and of one joint
    for clique in cliques:
        if (products := len(clique) ** 3 / 6) > most:
            raise TooDense(products, clique)
        for i in clique:
            near[i].update(clique)
            if len(clique) > 1:
                shared[i] += 1
            else:
                single[i] += 1
    for i in range(count):
        near[i].discard(i)
    entries = sum(len(n) for n in near) // 2

    def missing(i: int) -> int:
        """Return the number of uncoupled pairs of neighbours: the fill if i were eliminated now."""
        degree = len(near[i])
        return (degree * (degree - 1) - sum(len(near[i] & near[a]) for a in near[i])) // 2

    def at_most(i: int, clique: int) -> int:
        """Return an upper bound of `missing`, from the neighbours left by the last joint."""
        degree = len(near[i])
        return (degree * (degree - 1) - clique * (clique - 1)) // 2

    waits = {i: set(before) for i, before in (after or {}).items()}
    awaited: dict[int, list[int]] = {}
    for i, before in waits.items():
        for j in before:
            awaited.setdefault(j, []).append(i)
    # all joints of one clique are coupled
    known = [missing(i) if shared[i] > 1 else 0 for i in range(count)]
    # the joint unchanged for longest comes first: a chain is then eliminated from both ends in
    # turn, as two short sequences of dependent operations that the processor overlaps; a long chain
    # continues from the ground to its free end
    turn, step = 0, 1
    sides = [0] * count
    if count > LONG:
        step, sides = -1, [a + b for a, b in zip(shared, single, strict=True)]
    heap = [(known[i], len(near[i]), sides[i], i) for i in range(count) if not waits.get(i)]
    heapq.heapify(heap)
    order: list[int] = []
    later: list[list[int]] = []
    products = 0
    done = [False] * count
    while heap:
        fills, degree, _, i = heapq.heappop(heap)
        if done[i] or fills != known[i] or degree != len(near[i]):
            continue  # an outdated entry of the queue
        done[i] = True
        order.append(i)
        around = sorted(near[i])
        later.append(around)
        products += len(around) * (len(around) + 1) // 2
        if products > most:
            raise TooDense(products)
        beside, touched, degree = set(around), set(around), len(around)
        for a in around:
            near[a].discard(i)
            if fills:
                near[a].update(b for b in around if b != a)
                touched |= near[a] if count <= LONG else set()
        for a in awaited.get(i, ()):
            waits[a].discard(i)
            if not waits[a]:
                touched.add(a)
        for a in sorted(touched):
            if fills:
                known[a] = missing(a) if count <= LONG else at_most(a, degree - 1)
            elif known[a] and a in beside:  # its pairs with the eliminated joint were missing
                known[a] -= len(near[a]) + 1 - degree
            turn += step
            if not waits.get(a):
                heapq.heappush(heap, (known[a], len(near[a]), turn, a))
    place = {joint: c for c, joint in enumerate(order)}
    blocks = {(joint, joint): c for c, joint in enumerate(order)}
    below: list[tuple[tuple[int, int], ...]] = []
    for c, joint in enumerate(order):
        column = []
        for i in sorted(later[c], key=place.__getitem__):
            blocks[i, joint] = len(blocks)
            column.append((blocks[i, joint], i))
        below.append(tuple(column))
    updates = []
    for column_below in below:
        column_updates = []
        for k, (left, i) in enumerate(column_below):
            for right, j in column_below[: k + 1]:
                column_updates.append((blocks[i, j], left, right, rows[i], rows[j]))
        updates.append(tuple(column_updates))
    fill = len(blocks) - count - entries
    return Elimination(tuple(order), tuple(below), tuple(updates), blocks, fill)
