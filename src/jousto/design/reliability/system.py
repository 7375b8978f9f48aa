"""Systems of limit states: series (any of them fails) or parallel (all of them fail)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from scipy.special import ndtr, ndtri
from scipy.stats import multivariate_normal

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, count
from jousto.base.object_repr import described
from jousto.design.reliability.form import FormResult, form
from jousto.design.reliability.limit import LimitState
from jousto.design.reliability.sampling import SamplingResult, monte_carlo

WHERE = "system"
EXACT, MOST = 1e-4, 200_000
"""Relative error of the multivariate normal distribution, and its maximum number of points."""


@described
@dataclass(frozen=True, eq=False)
class SystemResult:
    """Probability of failure of a system of limit states, with its bounds.

    Attributes
    ----------
    kind : str
        "series" or "parallel".
    forms : tuple of FormResult
        FORM results of the limit states.
    correlation : (n, n) array
        ``alpha_i . alpha_j`` of the tangents.
    low, high : float
        Ditlevsen's bounds of the probability by the tangents.
    probability : float
        Probability by the tangents, from the multivariate normal distribution. Its relative error
        is 1e-4 for up to about ten limit states in series, and some per cent for very rare failures
        in parallel.
    sampled : SamplingResult or None
        Monte Carlo simulation with the limit states themselves.
    """

    kind: str
    forms: tuple[FormResult, ...]
    correlation: Array
    low: float
    high: float
    probability: float
    sampled: SamplingResult | None

    @property
    def beta(self) -> float:
        """Reliability index ``-Phi^-1(P)`` of the probability."""
        return float(-ndtri(self.probability))

    def _facts(self) -> str:
        text = (
            f"{count(len(self.forms), 'limit state')} in {self.kind}, Pf {self.probability:.4g} by "
            f"tangents, bounds {self.low:.4g} to {self.high:.4g}"
        )
        if self.sampled is None:
            return text
        s = self.sampled
        band = f"{s.confidence:.0%} in {s.low:.4g} to {s.high:.4g}"
        return f"{text}; sampled {s.probability:.4g}, {band}"


@explained
def system(
    limits: Sequence[FormResult | LimitState | Callable[..., Any]],
    variables: Any = None,
    *,
    kind: Literal["series", "parallel"] = "series",
    samples: int = 100_000,
    seed: int | None = 0,
) -> SystemResult:
    """Return the probability that a series or parallel system of limit states fails.

    The tangents of FORM are a system of planes, whose probability is that of a multivariate normal
    distribution with the correlation ``alpha_i . alpha_j``. The bounds need only pairs (O.
    Ditlevsen, *J. Struct. Mech.* 7 (1979) 453-472): in series, in falling order of P_i, ``P_1 + sum
    max(0, P_i - sum_j P_ij) <= P <= P_1 + sum (P_i - max_j P_ij)``, j < i; in parallel they follow
    from the bounds of the safe events. The design points of one limit state, ``points`` of
    `importance_sampling`, form a series system.

    Parameters
    ----------
    limits : sequence of FormResult, LimitState or callable
        Two or more limit states of the same random variables.
    variables : sequence of Random, Nataf, Rosenblatt or JointDistribution, optional
        The random variables, for limit states that are not results of `form`.
    kind : {"series", "parallel"}
        Kind of system, see above.
    samples : int
        Samples of a Monte Carlo check; 0: no check.
    seed : int, optional
        Seed of the random numbers; equal seeds give equal points.

    Returns
    -------
    SystemResult

    Raises
    ------
    InputError
        For fewer than two limit states, different variables, or an unknown kind.
    DesignPointError, LimitStateError
        As for `form` and `monte_carlo`.

    Examples
    --------
    Two independent planes at beta = 2:

    >>> from scipy.stats import norm
    >>> from jousto.design import Random
    >>> x = [Random("a", norm(0, 1)), Random("b", norm(0, 1))]
    >>> found = system([lambda x: 2 - x["a"], lambda x: 2 - x["b"]], x, samples=0)
    >>> p = norm.sf(2)
    >>> print(f"{found.probability:.5f} {2 * p - p**2:.5f}")
    0.04498 0.04498
    """
    problems = Problems()
    if kind not in ("series", "parallel"):
        problems.add(WHERE, f"kind is {kind!r}, must be 'series' or 'parallel'")
    given = list(limits) if isinstance(limits, list | tuple) else []
    if len(given) < 2:
        problems.add(WHERE, "limits must be two or more limit states or results of form")
    problems.whole(WHERE, "samples", samples, 0, "0 for none")
    problems.raise_if_any()
    forms = tuple(one if isinstance(one, FormResult) else form(one, variables) for one in given)
    first = forms[0]
    for one in forms[1:]:
        if one.variables.names != first.variables.names or dict(one.fixed) != dict(first.fixed):
            message = f"'{one.name}' has other random variables or fixed values than '{first.name}'"
            raise InputError(Problem(WHERE, message))
    alpha = np.stack([one.alpha for one in forms])
    beta = np.array([one.beta for one in forms])
    R = alpha @ alpha.T
    np.fill_diagonal(R, 1.0)
    low, high = ditlevsen_bounds(beta, R, kind)
    p = planes_probability(beta, R, kind)
    sampled = None
    if samples:
        sampled = monte_carlo(
            system_limit_state(forms, kind), first.variables, samples=samples, seed=seed
        )
    return SystemResult(kind, forms, R, low, high, min(max(p, low), high), sampled)


def system_limit_state(forms: Sequence[FormResult], kind: str) -> LimitState:
    """Return the limit state of a system: minimum (series) or maximum (parallel) of the members."""
    each = list({id(one.limit): one.limit for one in forms}.values())
    fixed = dict(forms[0].fixed)
    least: Any = np.minimum if kind == "series" else np.maximum

    def worst(x: Any) -> Any:
        found = [one.function(x) for one in each]
        pure = [g[0] if one.gradient is True else g for one, g in zip(each, found, strict=True)]
        return least.reduce([np.asarray(g) for g in pure])

    if fixed:
        message = "results with fixed values, such as those of rbdo, need samples=0"
        raise InputError(Problem(WHERE, message))
    many = all(one.vectorised for one in each)
    return LimitState(worst, vectorised=many, name="system")


def ditlevsen_bounds(beta: Array, R: Array, kind: str) -> tuple[float, float]:
    """Return Ditlevsen's bounds of the probability for planes at beta with correlation R.

    Examples
    --------
    >>> low, _ = ditlevsen_bounds(np.array([2.0, 2.0]), np.ones((2, 2)), "parallel")
    >>> bool(low <= float(ndtr(-2.0)) * (1 + 1e-9))
    True
    """
    # complement: a parallel system fails where the series system of the safe sides does not
    if kind == "parallel":
        low, high = ditlevsen_bounds(-beta, R, "series")
        pairs = [
            _bivariate_cdf(-beta[i], -beta[j], R[i, j]) for i in range(len(beta)) for j in range(i)
        ]
        return max(0.0, 1.0 - high), min(1.0 - low, *pairs)
    order = np.argsort(beta)
    beta, R = beta[order], R[np.ix_(order, order)]
    low = high = 0.0
    for i, p in enumerate(ndtr(-beta)):
        both = [_bivariate_cdf(-beta[i], -beta[j], R[i, j]) for j in range(i)]
        low += max(0.0, p - sum(both))
        high += p - max(both, default=0.0)
    return float(low), float(min(high, 1.0))


def planes_probability(beta: Array, R: Array, kind: str) -> float:
    """Return the failure probability of a system of planes at beta with correlation R.

    In series ``P = sum_i P(i fails, none before it does)``: each term is a box probability of the
    multivariate normal distribution, so that errors are relative to P, however rare failure is.
    """
    if kind == "parallel":
        return _normal_cdf(-beta, R)
    order = np.argsort(beta)
    beta, R = beta[order], R[np.ix_(order, order)]
    total = 0.0
    for i in range(len(beta)):
        side = np.append(-np.ones(i), 1.0)  # planes 0 .. i - 1 safe, plane i failed
        total += _normal_cdf(-side * beta[: i + 1], side[:, None] * R[: i + 1, : i + 1] * side)
    return total


def _normal_cdf(upper: Array, R: Array) -> float:
    """Return ``P(y <= upper)`` of normal variables with correlation R (fixed random seed)."""
    how: dict[str, Any] = {"abseps": 0.0, "releps": EXACT, "maxpts": MOST}
    rng = np.random.default_rng(0)
    return float(multivariate_normal.cdf(upper, cov=R, allow_singular=True, rng=rng, **how))


def _bivariate_cdf(a: float, b: float, r: float) -> float:
    """Return ``P(y_1 <= a and y_2 <= b)`` of two normal variables with correlation r."""
    return _normal_cdf(np.array([a, b]), np.array([[1.0, r], [r, 1.0]]))
