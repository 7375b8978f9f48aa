"""Hot spots of beams: all values are computed, since a site depends on only six resultants."""

from __future__ import annotations

import numpy as np

from jousto.base import ranking
from jousto.base.arrays import Array
from jousto.recovery.fields.criteria import Criterion
from jousto.recovery.fields.field import StressField
from jousto.recovery.hotspots.measures import Measure
from jousto.recovery.hotspots.search import Places, Proof
from jousto.recovery.hotspots.windows import SAFETY, UNIT


def search_all(
    field: StressField,
    criterion: Criterion,
    measure: Measure,
    *,
    count: int = 10,
    separation: float = 0.0,
) -> Places:
    """Return the sites of a beam with the largest values of a criterion; see `search`.

    Parameters
    ----------
    field : StressField
        Field of a beam.
    criterion, measure
        The criterion and its ranking.
    count : int
        Number of hot spots.
    separation : float
        Smallest distance of two hot spots, m.
    """
    found = field.envelope(criterion)
    ends = np.stack([found.min, found.max])
    ranked = measure.rank(ends)
    which = ranked.argmax(axis=0)
    column = np.arange(field.ns)
    values = ranked[which, column]
    times = np.stack([found.min_time, found.max_time])[which, column]
    instants = np.searchsorted(field.time, times)
    margin = rounding(field)
    alive = np.ones(field.ns, dtype=bool)
    spots: list[int] = []
    while len(spots) < count and alive.any():
        top = ranking.largest(np.where(alive, values, -np.inf), field.labels)
        spots.append(top)
        if separation > 0.0:
            away = np.linalg.norm(field.positions - field.positions[top], axis=1)
            alive &= away > separation
        alive[top] = False
    chosen = np.array(spots, dtype=np.intp)
    proof = Proof(
        places=field.ns,
        instants=field.nt,
        pruned=0,
        visited=field.ns,
        complete=field.ns,
        neighbours=int(field.ns - alive.sum() - len(spots)),
        bound=float((values + margin)[alive].max(initial=-np.inf)),
        best_pruned=-np.inf,
        knots=0,
        full=field.ns * field.nt,
        margin=float(margin.max(initial=0.0)),
        separation=float(separation),
    )
    return Places(chosen, instants[chosen].astype(np.intp), values[chosen], proof)


def rounding(field: StressField) -> Array:
    """Return the rounding error (ns,) of a criterion at each site, for any order of summation."""
    n = field.S.shape[2]
    parts = np.einsum("scj,sj->sc", np.abs(field.S), _sizes(field))
    return np.asarray(SAFETY * UNIT * (n + SAFETY) * np.sqrt((parts**2).sum(axis=1)))


def upper_bound(field: StressField, measure: Measure) -> float:
    """Return an upper bound for all sites and instants of a body, ``sum_j |G S_j| max |p_j|``."""
    length = np.sqrt(((measure.rows @ field.S) ** 2).sum(axis=1))
    bound = (length * _sizes(field)).sum(axis=1) + rounding(field)
    return float(bound.max(initial=-np.inf))


def _sizes(field: StressField) -> Array:
    """Return the largest magnitudes (ns, n) of the coordinates that each site depends on."""
    size = np.abs(field.p).max(axis=0)
    n = field.S.shape[2]
    if field.columns is None:
        return np.broadcast_to(size[:n], (field.ns, n))
    return np.asarray(size[field.columns[:, None] + np.arange(n)])


def largest(field: StressField, criterion: Criterion) -> Array:
    """Return the largest magnitude (ns,) of a criterion at each site, with its rounding error."""
    found = field.envelope(criterion)
    return np.asarray(np.maximum(np.abs(found.min), np.abs(found.max)) + rounding(field))
