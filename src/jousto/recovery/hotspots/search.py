"""The places where a criterion is largest, with proof: branch and bound, best first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array, Index
from jousto.base.errors import JoustoError
from jousto.base.ranking import TIE, first
from jousto.recovery.hotspots.bounds import prepare
from jousto.recovery.hotspots.measures import Measure

FIRST, MOST = 32, 2048  # places refined at once


@dataclass(frozen=True)
class Proof:
    """What a search looked at, and what bounds the rest.

    Attributes
    ----------
    places, instants : int
        What was searched.
    pruned : int
        Places that the bound over the whole run left out.
    visited : int
        Places that were looked at window by window; all others are `pruned`.
    complete : int
        Places of those whose largest value is known exactly.
    neighbours : int
        Places nearer to a hot spot than the separation, which cannot be one.
    bound : float
        No place that is neither a hot spot nor a neighbour of one exceeds this, in whatever order
        its sums are taken; -inf if there is none.
    best_pruned : float
        The largest bound of those that were pruned, -inf if none was.
    knots, full : int
        How often the criterion was worked out at knots of windows and in full.
    margin : float
        Largest allowance for rounding in a bound.
    separation : float
        No two hot spots are nearer, m.
    """

    places: int
    instants: int
    pruned: int
    visited: int
    complete: int
    neighbours: int
    bound: float
    best_pruned: float
    knots: int
    full: int
    margin: float
    separation: float


@dataclass(frozen=True, eq=False)
class Found:
    """Hot spots: places, their instants and ranked values, the largest first."""

    places: Index
    instants: Index
    ranked: Array
    certificate: Proof


def search(
    modes: Array,
    p: Array,
    positions: Array,
    measure: Measure,
    *,
    count: int = 10,
    separation: float = 0.0,
    labels: Sequence[str] | None = None,
) -> Found:
    """Return the places where a criterion is largest over a run, each apart from those before.

    The largest of all first; then the largest of those further away from it than `separation`,
    and so on. Places wait in a queue ordered by an upper bound. The first of the queue is either
    known exactly, then nothing else can exceed it and it is a hot spot, or it is looked at more
    closely. So what was never looked at is proved to be smaller.

    Parameters
    ----------
    modes : (ns, 6, n) array
        Stress of the modes at the places.
    p : (nt, n) array
        Modal coordinates.
    positions : (ns, 3) array
        Of the places, m.
    measure : Measure
        The criterion.
    count : int
        How many.
    separation : float
        Straight distance, m.
    labels : sequence of str, optional
        Of the places: which comes first of those that are equal but for round-off (`ranking`);
        their order if None.

    Raises
    ------
    JoustoError
        If a place does not become known exactly, since values and bounds of the criterion disagree.
    """
    work = prepare(modes, p, measure)
    ns = len(modes)
    upper = work.whole()
    whole = upper.copy()
    lower = np.full(ns, -np.inf)
    when = np.zeros(ns, dtype=np.intp)
    seen, exact, alive = (np.zeros(ns, dtype=bool) for _ in range(3))
    alive[:] = True
    spots: list[int] = []
    batch = FIRST
    while len(spots) < count and alive.any():
        top = int(np.argmax(np.where(alive, upper, -np.inf)))
        equal = np.flatnonzero(alive & (upper >= upper[top] - TIE * abs(upper[top])))
        open_ = equal[~exact[equal]]
        if not len(open_):
            top = first(equal, labels)
            spots.append(top)
            near = np.linalg.norm(positions - positions[top], axis=1) <= separation
            alive &= ~near if separation > 0.0 else True
            alive[top] = False
            continue
        # what may be as large as a place known exactly must be known, too
        top = int(open_[np.argmax(upper[open_])])
        # a value that the last hot spot will probably have; only the effort depends on it
        hope = _hope(lower, alive, positions, count - len(spots), separation)
        waiting = np.flatnonzero(alive & ~exact & (upper > min(hope, upper[top])))
        if len(waiting) > batch:
            waiting = waiting[np.argpartition(upper[waiting], -batch)[-batch:]]
        if top not in waiting:
            waiting = np.append(waiting, top)
        # those that failed with the hope before must be known exactly now
        below = np.where(seen[waiting], lower[waiting], np.maximum(lower[waiting], hope))
        best, instant, bound = work.refine(waiting, below)
        better = best > lower[waiting]
        lower[waiting] = np.where(better, best, lower[waiting])
        when[waiting] = np.where(better, instant, when[waiting])
        upper[waiting] = np.minimum(upper[waiting], np.maximum(bound, lower[waiting]))
        exact[waiting] = upper[waiting] <= lower[waiting]
        _refuse_standstill(waiting[seen[waiting] & ~exact[waiting]], lower, upper)
        seen[waiting] = True
        batch = min(2 * batch, MOST)
    chosen = np.array(spots, dtype=np.intp)
    unseen = alive & ~seen
    # values known exactly are sums in one order; the margin is for all others
    left = np.maximum(upper, lower + work.margin)[alive]
    certificate = Proof(
        places=ns,
        instants=len(p),
        pruned=int((~seen).sum()),
        visited=int(seen.sum()),
        complete=int(exact.sum()),
        neighbours=int(ns - alive.sum() - len(spots)),
        bound=float(left.max(initial=-np.inf)),
        best_pruned=float(whole[unseen].max(initial=-np.inf)),
        knots=work.effort.knots,
        full=work.effort.full,
        margin=float(work.margin.max(initial=0.0)),
        separation=float(separation),
    )
    return Found(chosen, when[chosen], lower[chosen], certificate)


def _refuse_standstill(places: Index, lower: Array, upper: Array) -> None:
    """Refuse places that were looked at twice and are not known exactly: the next pass is alike."""
    if len(places):
        k = int(places[0])
        raise JoustoError(
            f"hot_spots: place {k} of the field has a bound of {upper[k]:.9g} and a value of "
            f"{lower[k]:.9g} after its last pass, which must agree; values and bounds of this "
            "criterion contradict each other: search with another criterion and report this one"
        )


def _hope(
    lower: Array, alive: NDArray[np.bool_], positions: Array, count: int, apart: float
) -> float:
    """Return the value that the last of the next hot spots has at least, going by what is known."""
    known = np.where(alive, lower, -np.inf)
    if apart <= 0.0:
        if count > len(known):
            return -np.inf
        return float(np.partition(known, -count)[-count])
    value = -np.inf
    for _ in range(count):
        top = int(np.argmax(known))
        value = float(known[top])
        if value == -np.inf:
            return value
        known[np.linalg.norm(positions - positions[top], axis=1) <= apart] = -np.inf
    return value
