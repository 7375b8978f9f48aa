"""Sampling: exact probabilities inside of the intervals, rare events, failing points."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats as stats

import jousto as jo
from design.limit_states import TEN, normal

LimitState = jo.design.LimitState
monte_carlo, importance = jo.design.monte_carlo, jo.design.importance_sampling
subset = jo.design.subset_simulation
ONE = [normal("a", 0, 1)]
BAR = 0.0291487  # E[F_R(F / A)], as test_sorm.py integrates it


def plane(beta, n=1):
    """``P = Phi(-beta)`` in n variables."""
    made = [normal(f"x{i}", 0, 1) for i in range(n)]
    return LimitState(lambda x: beta - np.sum(x, axis=0) / np.sqrt(n), vectorised=True), made


def covered(results, exact):
    return sum(one.low <= exact <= one.high for one in results)


@pytest.mark.parametrize(
    ("method", "beta", "samples"),
    [(monte_carlo, 2.0, 4000), (importance, 3.0, 400), (subset, 3.0, 1000)],
)
def test_intervals_cover_the_exact_probability(method, beta, samples):
    state, variables = plane(beta, 3)
    results = [method(state, variables, samples=samples, seed=k) for k in range(40)]
    # 95 % of 40 are 38; fewer than 32 have a chance of 5e-4. Subset simulation takes its levels for
    # independent, which they are not quite
    assert covered(results, stats.norm.sf(beta)) >= (30 if method is subset else 32)
    assert np.mean([one.probability for one in results]) == pytest.approx(
        stats.norm.sf(beta), rel=4.0 * results[0].variation / np.sqrt(40)
    )


def test_the_bar():
    function, variables = TEN["bar"]
    state = LimitState(function, vectorised=True)
    for found in (
        monte_carlo(state, variables, seed=3),
        importance(function, variables, seed=3),
        subset(state, variables, seed=3),
    ):
        # four standard errors: once in 16000
        assert found.probability == pytest.approx(BAR, rel=4.0 * found.variation)
        assert found.low < found.probability < found.high
        assert found.beta == pytest.approx(-stats.norm.ppf(found.probability))


def test_rare_failures():
    state, variables = plane(6.0, 4)
    exact = stats.norm.sf(6.0)
    for found in (importance(state, variables), subset(state, variables)):
        assert found.probability == pytest.approx(exact, rel=4.0 * found.variation)
        assert found.calls < 20_000


def test_failures_in_two_places_are_found_without_a_design_point():
    state = LimitState(lambda x: 3.0 - np.abs(x["a"]), vectorised=True)
    found = subset(state, ONE, samples=4000)
    assert found.probability == pytest.approx(2.0 * stats.norm.sf(3.0), rel=4.0 * found.variation)


def test_failing_medians():
    state, variables = plane(-2.0)
    found = importance(state, variables, seed=1)
    assert found.probability == pytest.approx(stats.norm.cdf(2.0), rel=4.0 * found.variation)
    assert found.low < stats.norm.cdf(2.0) < found.high
    assert subset(state, variables).probability == pytest.approx(stats.norm.cdf(2.0), rel=0.02)


def test_nothing_that_fails_has_an_upper_bound():
    """``1 - 0.025^(1/n)``."""
    found = monte_carlo(plane(9.0)[0], ONE, samples=1000)
    assert (found.probability, found.low, found.failures) == (0.0, 0.0, 0)
    assert found.high == pytest.approx(1.0 - 0.025 ** (1 / 1000), rel=1e-9)
    assert found.variation == np.inf and found.beta == np.inf


def test_sampling_ends_at_a_variation():
    found = importance(*plane(3.0), samples=100_000, variation=0.05)
    assert found.variation <= 0.05 and found.samples < 3000
    few = monte_carlo(*plane(1.0), samples=10**6, variation=0.05)
    assert few.samples == 100_000


def test_the_same_seed_gives_the_same_points():
    for method in (monte_carlo, importance, subset):
        one, two, other = (method(*plane(2.0), seed=k, samples=500) for k in (1, 1, 2))
        assert one.probability == two.probability != other.probability


def test_a_result_of_form_is_enough():
    found = jo.design.form(*TEN["bar"])
    assert importance(found).probability == importance(*TEN["bar"]).probability
    assert monte_carlo(found, samples=200).samples == 200
    with pytest.raises(jo.InputError, match="leave variables out"):
        subset(found, TEN["bar"][1])


@pytest.mark.parametrize("vectorised", [True, False])
def test_points_without_a_value(vectorised):
    def g(x):
        # below -1 nothing can be computed; failure is above 1
        return np.where(x["a"] < -1.0, np.nan, 1.0 - x["a"])

    state = LimitState(g if vectorised else lambda x: float(g(x)), vectorised=vectorised)
    with pytest.raises(jo.design.LimitStateError, match="returned nan, at a = -"):
        monte_carlo(state, ONE, samples=1000)
    found = monte_carlo(state, ONE, samples=4000, failed="count")
    assert found.probability == pytest.approx(2.0 * stats.norm.sf(1.0), rel=0.1)
    assert 0 < found.broken < found.failures and "without a value" in repr(found)
    assert subset(state, ONE, failed="count", samples=2000).broken > 0


def test_the_error_of_the_tangent():
    concave = jo.design.form(*TEN["concave"])
    flat = jo.design.form(*plane(3.0))
    checked = jo.design.check_linearisation([concave, flat], samples=4000, seed=1)
    assert checked.significant == (True, False)
    # 7.1e-5 by FORM, 4.4e-5 by SORM
    assert checked.error[0] == pytest.approx(-0.12, abs=0.03)
    alone = jo.design.check_linearisation(flat, method="monte carlo", samples=20_000)
    assert alone.results[0].method == "monte carlo"
    assert repr(alone).startswith("<LinearisationCheck: beta of G 3 by FORM")
    with pytest.raises(jo.InputError, match="found is 3.0, must be "):
        jo.design.check_linearisation(3.0)
    with pytest.raises(jo.InputError, match="method is 'x'"):
        jo.design.check_linearisation(flat, method="x")


@pytest.mark.parametrize(
    ("method", "named", "said"),
    [
        (monte_carlo, {"samples": 0}, "samples is 0"),
        (monte_carlo, {"confidence": 1.0}, "confidence is 1, must be between 0 and 1"),
        (monte_carlo, {"failed": "skip"}, "failed is 'skip'"),
        (monte_carlo, {"seed": -1}, "seed is -1"),
        (monte_carlo, {"variation": 0.0}, "variation is 0"),
        (importance, {"variation": -1.0}, "variation is -1"),
        (subset, {"share": 0.9}, "share is 0.9"),
        (subset, {"samples": 10}, "too few for a share"),
        (subset, {"levels": 0}, "levels is 0"),
    ],
)
def test_wrong_arguments(method, named, said):
    with pytest.raises(jo.InputError, match=said):
        method(*plane(2.0), **named)


def test_subset_simulation_without_failures_says_so():
    state = LimitState(lambda x: 1.0 + np.exp(-x["a"]), vectorised=True)
    with pytest.raises(jo.design.DesignPointError, match="no failure after 4 levels"):
        subset(state, ONE, levels=4, samples=200)


@pytest.mark.parametrize(
    "limit",
    [
        lambda x: np.ceil(3.5 - x["a"]),
        lambda x: np.ceil(2 * (3.5 - x["a"])) / 2,
        lambda x: np.minimum(3.5 - x["a"], 2.0),
    ],
)
def test_subset_simulation_of_plateaus(limit):
    """Limit states with steps or a ceiling; P(a >= 3.5), within four standard errors of 30 runs."""
    one = [jo.design.Random("a", stats.norm(0.0, 1.0))]
    found = [
        jo.design.subset_simulation(
            jo.design.LimitState(limit, vectorised=True), one, samples=1000, seed=seed
        )
        for seed in range(30)
    ]
    p = np.array([run.probability for run in found])
    exact = stats.norm.sf(3.5)
    spread = max(float(np.std(p)), 0.3 * exact) / np.sqrt(len(p))
    assert float(np.mean(p)) == pytest.approx(exact, abs=4 * spread + 0.15 * exact)
