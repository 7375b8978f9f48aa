"""What has no answer: limits without gradient, out of reach or never safe, laws without moments."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats as stats

import jousto as jo

D = jo.design
PAIR = [D.Random(name, stats.norm(0.0, 1.0)) for name in "ab"]
BOX = {"a": (-2.0, 2.0)}


def redesign(method):
    def run(limit, variables):
        limit = limit.function if isinstance(limit, D.LimitState) else limit
        return D.rbdo(lambda d: (d["a"] - 0.3) ** 2, [limit], variables, BOX, 3.0, method=method)

    return run


BY_GRADIENT = {
    "form": D.form,
    "hlrf": lambda g, v: D.form(g, v, method="hlrf"),
    "sorm": D.sorm,
    "ria": D.ria,
    "importance sampling": D.importance_sampling,
}
ON_SPHERE = {
    name: (lambda g, v, name=name: D.pma(g, v, 3.0, method=name))
    for name in ("sqp", "hmv", "amv", "cmv")
}
REDESIGN = {name: redesign(name) for name in ("sora", "pma", "ria")}


def vectorised(g):
    return D.LimitState(g, vectorised=True, name="G")


def constant(x):
    return 1.0 + 0.0 * x["a"]


def stepped(x):
    return np.where(x["a"] < 3.0, 1.0, -1.0) * 1.0


# -- a limit state without gradient ----------------------------------------------------------------


@pytest.mark.parametrize("limit", [constant, stepped])
@pytest.mark.parametrize("method", [*BY_GRADIENT, *ON_SPHERE])
def test_methods_of_gradients_say_that_there_is_none(method, limit):
    analyse = (BY_GRADIENT | ON_SPHERE)[method]
    with pytest.raises(
        D.DesignPointError, match="gradient is zero at a = 0, b = 0, so there is no search"
    ):
        analyse(limit, PAIR)


@pytest.mark.parametrize("limit", [constant, stepped])
@pytest.mark.parametrize("method", REDESIGN)
def test_a_design_is_not_called_safe_where_nothing_is_known(method, limit):
    with pytest.raises(D.DesignPointError, match="its gradient is zero at a = 0.3, b = 0"):
        REDESIGN[method](limit, PAIR)


def test_samples_need_no_gradient():
    found = D.monte_carlo(vectorised(stepped), PAIR, samples=100_000)
    assert found.low < stats.norm.sf(3.0) < found.high
    assert D.monte_carlo(vectorised(constant), PAIR, samples=100).probability == 0.0
    with pytest.raises(D.DesignPointError, match="is 1 at all 500 points of level 1; nothing"):
        D.subset_simulation(vectorised(constant), PAIR, samples=500)


# -- failure out of reach, or everywhere -----------------------------------------------------------


@pytest.mark.parametrize("method", BY_GRADIENT)
@pytest.mark.parametrize(
    ("limit", "said"),
    [
        (lambda x: 9.0 - x["a"], "design point is at beta = 9, beyond 8"),
        (lambda x: 30.0 - x["a"], "no failure found; G is still 14 .* none within beta = 8"),
        (lambda x: np.exp(-x["a"]), "no failure found"),
        (lambda x: -1.0 - x["a"] ** 2, "nothing safe found; G is still -1 .* be nothing within"),
        (lambda x: 1e300 * (3.0 - x["a"]), r"returned 3e\+300, no double has its square: scale"),
    ],
)
def test_no_probability_beyond_reach(method, limit, said):
    with pytest.raises((D.DesignPointError, D.LimitStateError), match=said):
        BY_GRADIENT[method](limit, PAIR)


@pytest.mark.parametrize("method", ON_SPHERE)
def test_the_sphere_of_a_target_is_always_in_reach(method):
    assert ON_SPHERE[method](lambda x: 30.0 - x["a"], PAIR).value == pytest.approx(27.0)
    assert ON_SPHERE[method](lambda x: -1.0 - x["a"] ** 2, PAIR).value == pytest.approx(-10.0)


def test_samples_out_of_reach():
    with pytest.raises(D.DesignPointError, match="no failure after 20 levels"):
        D.subset_simulation(vectorised(lambda x: 30.0 - x["a"]), PAIR, samples=200)
    found = D.monte_carlo(vectorised(lambda x: 30.0 - x["a"]), PAIR, samples=300)
    assert found.probability == 0.0 and found.high == pytest.approx(0.0122, abs=1e-4)
    assert D.subset_simulation(vectorised(lambda x: -1.0 + 0.0 * x["a"]), PAIR).probability == 1.0
    with pytest.raises(jo.InputError, match="samples is 1e.30, must be a whole number from 1 to"):
        D.monte_carlo(vectorised(constant), PAIR, samples=10**30)


HEAVY = [stats.t(2.1), stats.pareto(2.1), stats.expon(0.0, 1.0)]


@pytest.mark.parametrize("law", HEAVY, ids=lambda law: law.dist.name)
@pytest.mark.parametrize("method", REDESIGN)
def test_a_design_that_cannot_fail_has_no_index(method, law):
    """Far out quantiles end where probabilities do; none is infinite."""
    found = REDESIGN[method](lambda x: 1e6 - x["a"], [D.Random("a", law)])
    assert found.betas["G1"] == np.inf and not found.forms
    assert found.design["a"] == pytest.approx(0.3, abs=1e-4)


@pytest.mark.parametrize(
    "law", [*HEAVY, stats.gamma(2.0), stats.uniform(0.0, 1.0), stats.beta(2.0, 3.0)]
)
def test_quantiles_are_finite_and_ascend(law):
    x = D.Nataf([D.Random("a", law)]).to_x(np.linspace(-80.0, 80.0, 401)[None])[0]
    assert np.all(np.isfinite(x)) and np.all(np.diff(x) >= 0.0)
    # within reach they are those of the law
    np.testing.assert_allclose(x[180:201], law.ppf(stats.norm.cdf(np.linspace(-8, 0, 21))))


@pytest.mark.parametrize("method", REDESIGN)
@pytest.mark.parametrize(
    ("limit", "said"),
    [
        (lambda x: -1.0 + 0.0 * x["a"], "G1 fails at a = 0, and no design variable changes that"),
        (lambda x: -20.0 - x["a"], "no design reaches the targets; missed at a = -2: G1"),
    ],
)
def test_designs_that_always_fail(method, limit, said):
    with pytest.raises(D.DesignPointError, match=said):
        REDESIGN[method](limit, PAIR)


def test_what_fails_everywhere_but_at_the_means_is_not_safe():
    """The search for what is safe does not find the jump."""

    def jump(x):
        return 1.0 + 0.1 * x["t"] if x["a"] > 0.9 else -1.0 - 0.01 * x["a"]

    a = D.Random("a", stats.expon(0.0, 1.0))  # mean 1, median 0.69
    with pytest.raises(D.DesignPointError, match="G1 fails at t = 0.5, and no design variable"):
        D.rbdo(
            lambda d: (d["t"] - 0.5) ** 2,
            {"G1": jump},
            [a],
            {"t": (0.0, 1.0)},
            method="ria",
            start={"t": 0.5},
        )


@pytest.mark.parametrize("method", REDESIGN)
def test_a_cost_without_end(method):
    with pytest.raises(D.DesignPointError, match="the cost falls without end, .* finite bounds"):
        D.rbdo(
            lambda d: -d["a"],
            [lambda x: x["a"] - x["b"]],
            PAIR,
            {"a": (0.0, np.inf)},
            method=method,
        )
    with pytest.raises(jo.InputError, match="bounds of 'a' are nan to 1, they are no numbers"):
        D.rbdo(lambda d: d["a"], [constant], PAIR, {"a": (np.nan, 1.0)}, method=method)


# -- distributions and correlations ----------------------------------------------------------------

ENDLESS = [stats.cauchy(), stats.t(2), stats.pareto(2), stats.pareto(1), stats.levy()]


@pytest.mark.parametrize("law", ENDLESS, ids=lambda law: law.dist.name)
def test_infinite_moments_are_refused(law):
    for make in (D.Random, lambda name, law: jo.Parameter(name, 1.0, distribution=law)):
        with pytest.raises(jo.InputError, match="both must be finite .* truncate a distribution"):
            make("x", law)
    low, high = law.ppf([0.01, 0.99])
    cut = stats.uniform(low, high - low)  # what the sentence asks for
    assert jo.Parameter("x", 1.0, distribution=cut).distribution is cut


def test_impossible_parameters_are_told_from_heavy_tails():
    for law in (stats.norm(0.0, -1.0), stats.norm(np.nan, 1.0), stats.gamma(-1.0)):
        for make in (D.Random, lambda name, law: jo.Parameter(name, 1.0, distribution=law)):
            with pytest.raises(jo.InputError, match="no median: its parameters are impossible"):
                make("x", law)


@pytest.mark.parametrize(
    ("law", "said"),
    [
        (lambda x: stats.norm(x["a"], -1.0), "of its distribution are impossible.* at a = "),
        (lambda x: 1 / 0, "'b': its distribution failed: ZeroDivisionError"),
        (lambda x: stats.norm(x["c"], 1.0), "no value 'c'; known: a"),
        (lambda x: stats.poisson(3.0), "must be one of scipy or OpenTURNS"),
    ],
)
def test_conditional_laws_that_are_none(law, said):
    chain = D.Rosenblatt([PAIR[0], D.Conditional("b", law)])
    for analyse in (D.form, D.monte_carlo, lambda g, v: D.pma(g, v, 3.0)):
        with pytest.raises(jo.InputError, match=said):
            analyse(lambda x: 3.0 - x["b"], chain)


def test_a_pair_given_twice():
    with pytest.raises(jo.InputError, match="b and a is given twice"):
        D.Nataf(PAIR, {("a", "b"): 0.5, ("b", "a"): 0.2})
    assert D.Nataf(PAIR, {("a", "b"): 0.5, ("b", "a"): 0.5}).normal[0, 1] == pytest.approx(0.5)


def test_a_start_out_of_this_world():
    for analyse in (D.form, lambda g, v, start: D.pma(g, v, 3.0, start=start)):
        with pytest.raises(jo.InputError, match=r"a is 1e\+300, 1e\+300 standard deviations"):
            analyse(lambda x: 3.0 - x["a"], PAIR, start={"a": 1e300, "b": 0.0})
