"""Probabilities by samples: Monte Carlo and importance sampling at the design point."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
import scipy.stats
from scipy.special import logsumexp, ndtr, ndtri

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.frozen_dict import Frozen
from jousto.base.object_repr import described
from jousto.design.reliability.form import FormResult, form_result
from jousto.design.reliability.inputs.space import Space
from jousto.design.reliability.limit import LimitState
from jousto.design.reliability.points import further_points

Failed = Literal["raise", "count"]
MOST = 1e10  # largest number of samples


@described
@dataclass(frozen=True, eq=False)
class SamplingResult:
    """Probability of failure from samples, with its confidence interval.

    Attributes
    ----------
    name : str
        Name of the limit state.
    method : str
        "monte carlo", "importance sampling" or "subset simulation".
    probability : float
        Estimate.
    low, high : float
        Ends of the confidence interval.
    confidence : float
        Confidence level of the interval.
    variation : float
        Coefficient of variation of the estimate; infinite if nothing failed.
    samples, failures : int
        Number of points, and of those that failed.
    broken : int
        Points at which the limit state gave no number, counted as failures.
    calls : int
        Calls of the limit state, including those for a design point.
    reasons : dict of int
        Number of points without a number, by reason.
    history : (k, 3) array
        Samples, probability and variation after each batch; for subset simulation samples,
        threshold and conditional probability of each level.
    points : tuple of FormResult
        Design points around which importance sampling drew.
    """

    name: str
    method: str
    probability: float
    low: float
    high: float
    confidence: float
    variation: float
    samples: int
    failures: int
    broken: int
    calls: int
    history: Array
    reasons: Mapping[str, int] = field(default_factory=dict)
    points: tuple[FormResult, ...] = ()

    @property
    def beta(self) -> float:
        """Reliability index ``-Phi^-1(P)`` of the probability."""
        return float(-ndtri(self.probability))

    def _facts(self) -> str:
        band = f"{self.confidence:.0%} in {self.low:.4g} to {self.high:.4g}"
        broken = f", {self.broken} without a value" if self.broken else ""
        work = f"{self.failures} of {self.samples} failed{broken}"
        if len(self.points) > 1:
            work += f"; {len(self.points)} design points"
        return f"{self.method}, Pf {self.probability:.4g}, {band}; {work}"


@explained
def monte_carlo(
    limit: LimitState | Callable[..., Any] | FormResult,
    variables: Any = None,
    *,
    samples: int = 100_000,
    seed: int | None = 0,
    confidence: float = 0.95,
    variation: float | None = None,
    failed: Failed = "raise",
) -> SamplingResult:
    """Return the probability of failure by Monte Carlo simulation, with its interval.

    The interval is that of Clopper and Pearson (*Biometrika* 26 (1934) 404-413): conservative, and
    valid with few failures or none.

    Parameters
    ----------
    limit : LimitState, callable or FormResult
        ``G(x) <= 0`` is failure; a result of `form` needs no further arguments. A vectorised
        function saves time.
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables.
    samples : int
        Largest number of samples.
    seed : int, optional
        Seed of the random numbers; equal seeds give equal points, None different points each time.
    confidence : float
        Confidence level of the interval.
    variation : float, optional
        Coefficient of variation at which the simulation stops early.
    failed : {"raise", "count"}
        Treatment of points without a finite value: raise, or count them as failures.

    Returns
    -------
    SamplingResult

    Raises
    ------
    LimitStateError
        If the limit state fails or is not a number, unless ``failed="count"``.
    InputError
        For wrong arguments.

    Examples
    --------
    >>> from scipy.stats import norm
    >>> from jousto.design import LimitState, Random
    >>> plane = LimitState(lambda x: 2.0 - x["a"], vectorised=True)
    >>> found = monte_carlo(plane, [Random("a", norm(0, 1))], seed=1)
    >>> bool(found.low < norm.sf(2.0) < found.high)
    True
    """
    check_sampling("monte carlo", samples, confidence, failed, seed, variation)
    space = space_of("monte carlo", limit, variables)
    rng = np.random.default_rng(seed)
    rows: list[tuple[float, float, float]] = []
    done = failures = broken = 0
    while done < samples:
        size = min(space.limit.batch, samples - done)
        g = space.g_columns(rng.standard_normal((space.n, size)), lenient=failed == "count")
        broken += int(np.isnan(g).sum())
        failures += int(np.sum(~(g > 0.0)))
        done += size
        p = failures / done
        spread = math.sqrt((1.0 - p) / (p * done)) if failures else math.inf
        rows.append((done, p, spread))
        if variation is not None and spread <= variation:
            break
    low, high = clopper_pearson(failures, done, confidence)
    return SamplingResult(
        name=space.limit.name,
        method="monte carlo",
        probability=failures / done,
        low=low,
        high=high,
        confidence=confidence,
        variation=rows[-1][2],
        samples=done,
        failures=failures,
        broken=broken,
        calls=space.calls,
        history=np.array(rows),
        reasons=Frozen(space.counted.reasons),
    )


def check_sampling(
    where: str, samples: Any, confidence: Any, failed: Any, seed: Any, variation: Any = None
) -> None:
    """Check the settings of a sampling.

    Raises
    ------
    InputError
        With all settings out of their ranges.
    """
    problems = Problems()
    whole = f"a whole number from 1 to {MOST:g}"
    problems.number(where, "samples", samples, "", whole, lambda x: 1 <= x <= MOST and x == int(x))
    inside = "between 0 and 1"
    problems.number(where, "confidence", confidence, "", inside, lambda x: 0.0 < x < 1.0)
    if failed not in ("raise", "count"):
        problems.add(where, f"failed is {failed!r}, must be 'raise' or 'count'")
    if seed is not None:
        known = "a whole number that is not negative, or None"
        problems.number(where, "seed", seed, "", known, lambda x: x >= 0 and x == int(x))
    if variation is not None:
        problems.positive(where, "variation", variation, "")
    problems.raise_if_any()


def clopper_pearson(failures: int, samples: int, confidence: float) -> tuple[float, float]:
    """Return the exact confidence interval of a proportion (Clopper and Pearson).

    Examples
    --------
    >>> low, high = clopper_pearson(0, 300, 0.95)
    >>> print(f"{low:.3f} {high:.4f}")  # 1 - 0.025^(1/300)
    0.000 0.0122
    """
    tail = 0.5 * (1.0 - confidence)
    beta: Any = scipy.stats.beta
    low = beta.ppf(tail, failures, samples - failures + 1) if failures else 0.0
    high = beta.isf(tail, failures + 1, samples - failures) if failures < samples else 1.0
    return float(low), float(high)


@explained
def importance_sampling(
    limit: LimitState | Callable[..., Any] | FormResult,
    variables: Any = None,
    *,
    samples: int = 1000,
    seed: int | None = 0,
    confidence: float = 0.95,
    variation: float | None = None,
    failed: Failed = "raise",
    search: bool = True,
) -> SamplingResult:
    """Return the probability of failure by samples around the design points.

    Points are normal around u* with weights ``phi(u) / phi(u - u*)``. About half of them fail,
    however rare failure is. First, further design points are searched with bulges around the known
    ones; points are then drawn around each in proportion to its ``Phi(-beta)``, with weights
    ``phi(u) / sum w_k phi(u - u_k)``.

    Parameters
    ----------
    limit : LimitState, callable or FormResult
        ``G(x) <= 0`` is failure; a result of `form` needs no further arguments.
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables.
    samples : int
        Largest number of samples.
    seed : int, optional
        Seed of the random numbers; equal seeds give equal points.
    confidence : float
        Confidence level of the interval.
    variation : float, optional
        Coefficient of variation at which the simulation stops early, checked every 100 points.
    failed : {"raise", "count"}
        Treatment of points without a finite value: raise, or count them as failures.
    search : bool
        Whether to search for further design points, which costs two gradients and two values per
        variable for a nearly plane limit state, else some 30 calls per variable. Without the
        search, design points far from the first one are missed.

    Returns
    -------
    SamplingResult
        Result with the design points.

    Raises
    ------
    DesignPointError
        If there is no design point.
    LimitStateError
        If the limit state fails or is not a number, unless ``failed="count"``.
    InputError
        For wrong arguments.
    """
    where = "importance sampling"
    check_sampling(where, samples, confidence, failed, seed, variation)
    found = form_result(where, limit, variables)
    space = Space(found.limit, found.variables, dict(found.fixed))
    points = [found, *(further_points(space, found) if search else ())]
    centres = np.stack([one.u for one in points])
    shares = ndtr(-np.abs([one.beta for one in points]))
    shares = shares / shares.sum()
    rng = np.random.default_rng(seed)
    # negative index: failure is the likely side, so count the safe points
    side = 1.0 if found.beta >= 0.0 else -1.0
    weights: list[Array] = []
    rows: list[tuple[float, float, float]] = []
    broken = done = 0
    while done < samples:
        size = min(100 if variation is not None else space.limit.batch, samples - done)
        u = rng.standard_normal((space.n, size))
        u += centres[rng.choice(len(points), size, p=shares) if len(points) > 1 else [0] * size].T
        g = space.g_columns(u, lenient=failed == "count")
        broken += int(np.isnan(g).sum())
        bad = ~(g > 0.0) if side > 0.0 else g > 0.0
        # log of phi(u - u_k) / phi(u), a row for each centre
        ratio = centres @ u - 0.5 * np.sum(centres**2, axis=1)[:, None]
        weights.append(np.where(bad, np.exp(-logsumexp(ratio, axis=0, b=shares[:, None])), 0.0))
        done += size
        w = np.concatenate(weights)
        p = float(w.mean())
        spread = float(w.std(ddof=1)) / math.sqrt(done) / p if p > 0.0 and done > 1 else math.inf
        rows.append((done, p, spread))
        if variation is not None and spread <= variation:
            break
    low, high = lognormal_interval(p, spread, confidence)
    failures = int(np.count_nonzero(w)) if side > 0.0 else int(np.sum(w == 0.0))
    if side < 0.0:
        p, low, high = 1.0 - p, 1.0 - high, 1.0 - low
    return SamplingResult(
        name=space.limit.name,
        method=where,
        probability=p,
        low=low,
        high=high,
        confidence=confidence,
        variation=spread if side > 0.0 else spread * (1.0 - p) / p,
        samples=done,
        failures=failures,
        broken=broken,
        calls=space.calls + found.calls,
        history=np.array(rows),
        reasons=Frozen(space.counted.reasons),
        points=tuple(points),
    )


def space_of(where: str, limit: Any, variables: Any) -> Space:
    """Return the Space of a limit state and its variables, or of a FORM result."""
    if isinstance(limit, FormResult):
        found = form_result(where, limit, variables)
        return Space(found.limit, found.variables, dict(found.fixed))
    return Space(limit, variables)


def lognormal_interval(p: float, variation: float, confidence: float) -> tuple[float, float]:
    """Return the lognormal confidence interval of an estimate from its coefficient of variation."""
    if not math.isfinite(variation):
        return 0.0, 1.0
    spread = math.sqrt(math.log1p(variation**2))
    z = float(-ndtri(0.5 * (1.0 - confidence)))
    return p * math.exp(-z * spread), min(1.0, p * math.exp(z * spread))


@described
@dataclass(frozen=True, eq=False)
class LinearisationCheck:
    """Comparison of FORM indices with sampled ones: the error of the tangent planes.

    Attributes
    ----------
    names : tuple of str
        Names of the limit states.
    form : (n,) array
        Indices by FORM.
    sampled : (n,) array
        Indices of the sampled probabilities.
    low, high : (n,) arrays
        Ends of their confidence intervals.
    results : tuple of SamplingResult
        The samplings.
    """

    names: tuple[str, ...]
    form: Array
    sampled: Array
    low: Array
    high: Array
    results: tuple[SamplingResult, ...]

    @property
    def error(self) -> Array:
        """FORM index minus sampled index (n,)."""
        return np.asarray(self.form - self.sampled)

    @property
    def significant(self) -> tuple[bool, ...]:
        """Whether the FORM index lies outside the confidence interval."""
        inside = (self.low <= self.form) & (self.form <= self.high)
        return tuple(bool(out) for out in ~inside)

    def _facts(self) -> str:
        each = [
            f"{name} {a:.4g} by FORM, {b:.4g} sampled"
            for name, a, b in zip(self.names, self.form, self.sampled, strict=True)
        ]
        return "beta of " + ", ".join(each[:3]) + (", ..." if len(each) > 3 else "")


@explained
def check_linearisation(
    found: Any,
    *,
    method: Literal["importance", "monte carlo"] = "importance",
    samples: int = 2000,
    seed: int | None = 0,
    confidence: float = 0.95,
) -> LinearisationCheck:
    """Compare FORM indices with sampled ones: the error of the tangent planes.

    Parameters
    ----------
    found : FormResult, RbdoResult or sequence of FormResult
        Results to check.
    method : {"importance", "monte carlo"}
        Sampling method.
    samples : int
        Samples for each limit state.
    seed : int, optional
        Seed of the random numbers; equal seeds give equal points.
    confidence : float
        Confidence level of the intervals.

    Returns
    -------
    LinearisationCheck

    Raises
    ------
    InputError
        If `found` contains no results of FORM.
    """
    forms = getattr(found, "forms", found)
    forms = (forms,) if isinstance(forms, FormResult) else tuple(forms)
    if not forms or not all(isinstance(one, FormResult) for one in forms):
        message = f"found is {found!r:.80}, must be results of form or of rbdo"
        raise InputError(Problem("check_linearisation", message))
    if method not in ("importance", "monte carlo"):
        message = f"method is {method!r}, must be 'importance' or 'monte carlo'"
        raise InputError(Problem("check_linearisation", message))
    results = []
    for one in forms:
        options: dict[str, Any] = {"samples": samples, "seed": seed, "confidence": confidence}
        if method == "importance":
            results.append(importance_sampling(one, **options))
        else:
            results.append(monte_carlo(one, **options))
    return LinearisationCheck(
        names=tuple(one.name for one in forms),
        form=np.array([one.beta for one in forms]),
        sampled=np.array([one.beta for one in results]),
        low=-ndtri(np.array([one.high for one in results])),
        high=-ndtri(np.array([one.low for one in results])),
        results=tuple(results),
    )
