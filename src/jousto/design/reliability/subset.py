"""Subset simulation: a small probability as a product of conditional ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array, Ints
from jousto.base.errors import Problems
from jousto.base.frozen_dict import Frozen
from jousto.design.reliability.errors import DesignPointError
from jousto.design.reliability.form import FormResult
from jousto.design.reliability.inputs.space import Space
from jousto.design.reliability.limit import LimitState, format_values
from jousto.design.reliability.sampling import (
    Failed,
    SamplingResult,
    check_sampling,
    lognormal_interval,
    space_of,
)

WHERE = "subset simulation"
ACCEPTED = 0.44  # acceptance rate of the moves at which Markov chains mix fastest
WIDEST, FIRST = 1.0, 0.6  # standard deviations of a move: upper limit, initial value


@explained
def subset_simulation(
    limit: LimitState | Callable[..., Any] | FormResult,
    variables: Any = None,
    *,
    samples: int = 2000,
    share: float = 0.1,
    levels: int = 20,
    seed: int | None = 0,
    confidence: float = 0.95,
    failed: Failed = "raise",
) -> SamplingResult:
    """Return the probability of failure by subset simulation, without a design point.

    ``P = P(g <= b_1) P(g <= b_2 | g <= b_1) ...`` with thresholds that a `share` of the points
    passes (S.-K. Au and J. L. Beck, *Probab. Eng. Mech.* 16 (2001) 263-277). Points of a level are
    Markov chains from those of the level before, with moves ``rho u + sqrt(1 - rho^2) xi`` whose
    width is adapted (I. Papaioannou et al., *Probab. Eng. Mech.* 41 (2015) 89-103). It finds
    failures in several places and needs no gradient.

    Parameters
    ----------
    limit : LimitState, callable or FormResult
        ``G(x) <= 0`` is failure.
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables.
    samples : int
        Number of samples in each level.
    share : float
        Share of points that pass a level, between 0 and 0.5.
    levels : int
        Largest number of levels.
    seed : int, optional
        Seed of the random numbers; equal seeds give equal points.
    confidence : float
        Confidence level of the interval, under the assumption of independent levels.
    failed : {"raise", "count"}
        Treatment of points without a finite value: raise, or count them as failures.

    Returns
    -------
    SamplingResult

    Raises
    ------
    DesignPointError
        If there is no failure after the last level.
    LimitStateError
        If the limit state fails or is not a number, unless ``failed="count"``.
    InputError
        For wrong arguments.
    """
    check_sampling(WHERE, samples, confidence, failed, seed)
    problems = Problems()
    inside = "between 0 and 0.5"
    if problems.number(WHERE, "share", share, "", inside, lambda x: 0.0 < x <= 0.5):
        chains = round(share * samples)
        if chains < 2:
            problems.add(WHERE, f"{samples} samples are too few for a share of {share:g}")
    problems.whole(WHERE, "levels", levels)
    problems.raise_if_any()
    space = space_of(WHERE, limit, variables)
    lenient = failed == "count"
    rng = np.random.default_rng(seed)
    u = rng.standard_normal((space.n, samples))
    g, broken = _values(space, u, lenient)
    rows: list[tuple[float, float, float]] = []
    square, p, width = 0.0, 1.0, FIRST
    # index of the chain of each point; one group at the first level
    link = np.zeros((samples, 1), dtype=np.int64)
    for _ in range(levels):
        if np.min(g) == np.max(g) > 0.0:
            message = (
                f"{space.counted.where}: is {g[0]:.4g} at all {samples} points of level "
                f"{len(rows) + 1}; nothing there is nearer to failure"
            )
            raise DesignPointError(message, u[:, 0], rows)
        order = np.argsort(g, kind="stable")
        threshold = max(0.5 * float(g[order[chains - 1]] + g[order[chains]]), 0.0)
        tie = float(g[order[chains]])
        if threshold > 0.0 and g[order[chains - 1]] == tie and np.any(g < tie):
            # plateau of equal values: take only the points below it as the next level
            threshold = max(float(np.max(g[g < tie])), 0.0)
        passed = g <= threshold
        q = float(np.mean(passed))
        square += _variance(passed, link, q)
        p *= q
        rows.append((samples * (len(rows) + 1), threshold, q))
        if threshold == 0.0:
            break
        seeds = rng.permutation(np.flatnonzero(passed))[:chains]
        u, g, link, width, lost = _chains(
            space, rng, (u[:, seeds], g[seeds]), (samples, threshold, width), lenient
        )
        broken += lost
    else:
        best = int(np.argmin(g))
        message = (
            f"{space.counted.where}: no failure after {levels} levels (Pf < {p:.1g}); the least is "
            f"{g[best]:.4g} at {format_values(space.values(u[:, best]))}"
        )
        raise DesignPointError(message, u[:, best], rows)
    variation = math.sqrt(square)
    low, high = lognormal_interval(p, variation, confidence)
    return SamplingResult(
        name=space.limit.name,
        method=WHERE,
        probability=p,
        low=low,
        high=high,
        confidence=confidence,
        variation=variation,
        samples=samples * len(rows),
        failures=int(np.sum(g <= 0.0)),
        broken=broken,
        calls=space.calls,
        history=np.array(rows),
        reasons=Frozen(space.counted.reasons),
    )


def _values(space: Space, u: Array, lenient: bool) -> tuple[Array, int]:
    """Return the limit state, -inf in place of NaN, and the number of NaN."""
    g = space.g_columns(u, lenient=lenient)
    lost = int(np.isnan(g).sum())
    return np.where(np.isnan(g), -np.inf, g), lost


def _chains(
    space: Space,
    rng: np.random.Generator,
    start: tuple[Array, Array],
    settings: tuple[int, float, float],
    lenient: bool,
) -> tuple[Array, Array, Ints, float, int]:
    """Return points below a threshold by parallel Markov chains, with the chain of each point."""
    (u, g), (samples, threshold, width) = start, settings
    chains = u.shape[1]
    points, values, lost = [u], [g], 0
    steps = -(-samples // chains)
    for k in range(1, steps):
        rho = math.sqrt(1.0 - width**2)
        new = rho * u + width * rng.standard_normal(u.shape)
        g_new, more = _values(space, new, lenient)
        lost += more
        taken = g_new <= threshold
        u, g = np.where(taken, new, u), np.where(taken, g_new, g)
        points.append(u)
        values.append(g)
        rate = float(np.mean(taken)) - ACCEPTED
        width = min(WIDEST - 1e-6, width * math.exp(rate / math.sqrt(k)))
    link = np.tile(np.arange(chains, dtype=np.int64), steps)[:samples, None]
    all_u, all_g = np.concatenate(points, axis=1), np.concatenate(values)
    return all_u[:, :samples], all_g[:samples], link, width, lost


def _variance(passed: NDArray[np.bool_], link: Ints, q: float) -> float:
    """Return the squared coefficient of variation of a level (Au and Beck, eq. 28)."""
    n = len(passed)
    chains = len(np.unique(link))
    base = (1.0 - q) / (q * n)
    if len(link) < 2 or not link.any() or q >= 1.0:
        return base
    steps = n // chains
    table = passed[: steps * chains].reshape(steps, chains).astype(np.float64)
    gamma = 0.0
    for k in range(1, steps):
        together = float(np.mean(table[:-k] * table[k:])) - q * q
        gamma += 2.0 * (1.0 - k / steps) * together / (q * (1.0 - q))
    return base * (1.0 + max(gamma, 0.0))
