"""Search for the sites with the largest value of a criterion, by branch and bound."""

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

FIRST, MOST = 32, 2048  # number of sites refined at once: at first, and maximum


@dataclass(frozen=True)
class Proof:
    """Certificate of a search: numbers of sites and evaluations, and the proved bound.

    Attributes
    ----------
    places, instants : int
        Number of sites and instants of the search.
    pruned : int
        Number of sites excluded by their bound over the whole run.
    visited : int
        Number of sites evaluated window by window; all others are `pruned`.
    complete : int
        Number of visited sites whose largest value is known exactly.
    neighbours : int
        Number of sites nearer to a hot spot than the separation, which are excluded.
    bound : float
        Upper bound of the ranked value of all sites besides hot spots and neighbours, valid for
        any order of summation; -inf if there are no other sites.
    best_pruned : float
        Largest bound of the pruned sites; -inf if there are none.
    knots, full : int
        Number of evaluations of the criterion at knots of windows, and at all instants of windows.
    margin : float
        Largest allowance for rounding errors in a bound.
    separation : float
        Smallest distance of two hot spots, m.
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
class Places:
    """Hot spots: sites, their instants and ranked values, in descending order."""

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
) -> Places:
    """Return the sites with the largest values of a criterion over a run, at a given separation.

    The first hot spot is the largest value of all; the next one is the largest of the sites further
    away from it than `separation`, and so on. Sites are in a queue ordered by an upper bound. If
    the value of the first site of the queue is known exactly, no other site can exceed it, and it
    is a hot spot; otherwise its bound is refined. So all sites that were not evaluated are proved
    to be smaller.

    Parameters
    ----------
    modes : (ns, 6, n) array
        Stress of the modes at the sites.
    p : (nt, n) array
        Modal coordinates.
    positions : (ns, 3) array
        Positions of the sites, m.
    measure : Measure
        The criterion.
    count : int
        Number of hot spots.
    separation : float
        Smallest distance of two hot spots, m.
    labels : sequence of str, optional
        Labels of the sites, which order those of equal values up to round-off (`ranking`); None
        orders them by index.

    Raises
    ------
    JoustoError
        If the refinement of a site does not end, since values and bounds of the criterion disagree.
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
        # refine all sites whose value may be as large as that of the site known exactly
        top = int(open_[np.argmax(upper[open_])])
        # estimate of the value of the last hot spot, which affects only the effort
        hope = _hope(lower, alive, positions, count - len(spots), separation)
        waiting = np.flatnonzero(alive & ~exact & (upper > min(hope, upper[top])))
        if len(waiting) > batch:
            waiting = waiting[np.argpartition(upper[waiting], -batch)[-batch:]]
        if top not in waiting:
            waiting = np.append(waiting, top)
        # sites that were only refined up to the estimate are now refined to their exact value
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
    # the margin covers sums in another order than those of the exact values
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
    return Places(chosen, when[chosen], lower[chosen], certificate)


def _refuse_standstill(places: Index, lower: Array, upper: Array) -> None:
    """Raise an error if sites have no exact value after two passes: the search would not end."""
    if len(places):
        k = int(places[0])
        raise JoustoError(
            f"hot_spots: site {k} of the field has a bound of {upper[k]:.9g} and a value of "
            f"{lower[k]:.9g} after its last pass, which must agree; values and bounds of this "
            "criterion contradict each other; search with another criterion and report this one"
        )


def _hope(
    lower: Array, alive: NDArray[np.bool_], positions: Array, count: int, apart: float
) -> float:
    """Return a lower bound for the value of the last hot spot, from the known lower bounds."""
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
