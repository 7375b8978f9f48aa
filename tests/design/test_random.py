"""Random variables, their correlation and their transformations."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.stats as stats
from scipy.special import betainc

import jousto as jo
from jousto.design.reliability.inputs.correlation import normal_correlation
from jousto.design.reliability.inputs.transform import transformation
from jousto.design.studies.parameters.distributions import KINDS

Random, distribution_from_moments, Nataf = (
    jo.design.Random,
    jo.design.distribution_from_moments,
    jo.design.Nataf,
)
LAWS = [distribution_from_moments(kind, 10.0, 2.5) for kind in KINDS] + [
    stats.expon(1.0, 2.0),
    stats.t(5, 1.0, 2.0),
    stats.truncnorm(-2, 3, 5.0, 1.0),
    stats.lognorm(0.4, loc=2.0, scale=3.0),
]


@pytest.mark.parametrize("kind", KINDS)
def test_moments_are_those_asked_for(kind):
    law = distribution_from_moments(kind, 10.0, 2.5)
    # 1e-9: moments of scipy of closed forms, the Weibull exponent to 1e-14
    assert (law.mean(), law.std()) == pytest.approx((10.0, 2.5), rel=1e-9)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.dist.name)
def test_values_of_normal_variables_and_back(law):
    one = Random("x", law)
    y = np.array([-6.0, -2.0, -0.1, 0.0, 0.5, 3.0, 6.0])
    x = one.law.value(y)
    # quantiles of scipy are good to some 1e-12, near the end of a bounded law y loses 4 digits
    np.testing.assert_allclose(one.law.normal(x), y, atol=1e-7)
    np.testing.assert_allclose(stats.norm.cdf(y[1:5]), law.cdf(x[1:5]), rtol=1e-9)
    h = 1e-4
    slope = (one.law.value(y[1:6] + h) - one.law.value(y[1:6] - h)) / (2 * h)
    # central differences: h^2 / 6 of a third derivative of order ten
    np.testing.assert_allclose(one.law.slope(y, x)[1:6], slope, rtol=1e-6)


@pytest.mark.parametrize("law", LAWS, ids=lambda law: law.dist.name)
def test_moved_variables_have_the_moments(law):
    one = Random("x", law).moved(12.0, 3.0)
    assert (one.mean, one.deviation) == pytest.approx((12.0, 3.0), rel=1e-9)
    assert one.kind == law.dist.name
    grown = Random("x", law, keep="cov").moved(2.0 * Random("x", law).mean)
    assert grown.deviation == pytest.approx(2.0 * law.std(), rel=1e-9)


def test_distortion_has_its_closed_forms():
    """P.-L. Liu and A. Der Kiureghian, *Probab. Eng. Mech.* 1 (1986) 105-112."""
    uniform, normal = Random("u", stats.uniform(0, 1)), Random("n", stats.norm(3, 2))
    exponential = Random("e", stats.expon())
    wide, narrow = (
        Random(n, distribution_from_moments("lognormal", 1.0, s))
        for n, s in (("w", 0.5), ("s", 0.2))
    )
    # rho = (6 / pi) asin(rho_0 / 2); 1e-12: the sums of the series
    assert normal_correlation(uniform, uniform, 0.5)[0] == pytest.approx(
        2.0 * math.sin(math.pi / 12.0), abs=1e-12
    )
    s = math.sqrt(math.log1p(0.25))
    assert normal_correlation(normal, wide, 0.5)[0] == pytest.approx(0.5 * 0.5 / s, abs=1e-12)
    z = math.sqrt(math.log1p(0.04))
    expected = math.log1p(0.3 * 0.5 * 0.2) / (s * z)
    assert normal_correlation(wide, narrow, 0.3)[0] == pytest.approx(expected, abs=1e-12)
    # their table 4: F = 1.001 - 0.007 d + 0.118 d^2 of a gamma variable with the ratio d
    general = Random("g", distribution_from_moments("gamma", 1.0, 0.5))
    assert normal_correlation(general, normal, 0.2)[0] == pytest.approx(0.2 * 1.027, rel=2e-3)
    # the least correlation of exponential variables is 1 - pi^2 / 6
    found, low, high = normal_correlation(exponential, exponential, -0.6)
    assert (low, high) == pytest.approx((1.0 - math.pi**2 / 6.0, 1.0), abs=1e-9)
    # Liu and Der Kiureghian, table 5: F = 1.229 - 0.367 rho + 0.153 rho^2, good to 1.5 %
    assert found == pytest.approx(-0.6 * (1.229 + 0.367 * 0.6 + 0.153 * 0.36), rel=0.015)


def test_samples_have_the_correlation(rng):
    variables = [
        Random("g", distribution_from_moments("gumbel", 10.0, 3.0)),
        Random("w", distribution_from_moments("weibull", 10.0, 3.0)),
        Random("l", distribution_from_moments("lognormal", 5.0, 2.0)),
    ]
    joint = Nataf(variables, {("g", "w"): -0.5, ("g", "l"): 0.4})
    x = joint.to_x(rng.standard_normal((3, 200_000)))
    wanted = np.array([[1, -0.5, 0.4], [-0.5, 1, 0], [0.4, 0, 1]])
    # 1 / sqrt(200000) = 0.0022 of an estimate
    np.testing.assert_allclose(np.corrcoef(x), wanted, atol=0.012)
    u = np.array([0.3, -1.2, 2.0])
    np.testing.assert_allclose(joint.to_u(joint.to_x(u)), u, atol=1e-9)
    # fourth order differences with steps of 1e-3: 1e-12 of a fifth derivative, and rounding
    differences = super(Nataf, joint).jacobian(u)
    np.testing.assert_allclose(joint.jacobian(u), differences, rtol=1e-7, atol=1e-9)


def test_ranks_and_normal_correlations():
    a, b = Random("a", stats.expon()), Random("b", stats.uniform(0, 1))
    by_rank = Nataf([a, b], {("a", "b"): 0.5}, "spearman").normal[0, 1]
    assert by_rank == pytest.approx(2.0 * math.sin(math.pi / 12.0), abs=1e-15)
    assert Nataf([a, b], [[1, 0.5], [0.5, 1]], "normal").normal[0, 1] == 0.5


def test_conditional_normal_variables_are_correlated_ones():
    """``x2 | x1 ~ N(rho x1, 1 - rho^2)`` is the bivariate normal distribution with rho."""
    rho = 0.6
    a, b = Random("a", stats.norm(0, 1)), Random("b", stats.norm(0, 1))
    given = jo.design.Conditional("b", lambda x: stats.norm(rho * x["a"], math.sqrt(1 - rho**2)))
    chain, joint = jo.design.Rosenblatt([a, given]), Nataf([a, b], {("a", "b"): rho})
    u = np.array([[0.3, -2.0, 1.0], [1.2, 0.1, -1.0]])
    np.testing.assert_allclose(chain.to_x(u), joint.to_x(u), atol=1e-13)
    np.testing.assert_allclose(chain.to_u(chain.to_x(u)), u, atol=1e-13)
    np.testing.assert_allclose(chain.jacobian(u[:, 0]), joint.jacobian(u[:, 0]), atol=1e-11)
    assert isinstance(transformation([a, given]), jo.design.Rosenblatt)


def test_conditional_variables_that_take_one_point_at_a_time():
    def scaled(x):
        if float(x["a"]) > 0.0:  # of an array this is an error
            return stats.norm(1.0, 2.0)
        return stats.norm(0.0, 1.0)

    chain = jo.design.Rosenblatt(
        [Random("a", stats.norm(0, 1)), jo.design.Conditional("b", scaled)]
    )
    np.testing.assert_array_equal(chain.to_x(np.array([[1.0, -1.0], [1.0, 1.0]]))[1], [3.0, 1.0])


def test_openturns_distributions_and_copulas(openturns):
    ot = openturns
    ours = Random("R", distribution_from_moments("lognormal", 300.0, 30.0))
    theirs = Random("R", ot.LogNormalMuSigma(300.0, 30.0, 0.0).getDistribution())
    assert (theirs.mean, theirs.deviation) == pytest.approx((300.0, 30.0))
    y = np.array([-5.0, 0.0, 5.0])
    np.testing.assert_allclose(theirs.law.value(y), ours.law.value(y), rtol=1e-9)
    np.testing.assert_allclose(theirs.moved(310.0).law.value(y), ours.moved(310.0).law.value(y))
    assert Random("n", ot.Normal(1.0, 2.0)).moved(4.0, 1.0).mean == pytest.approx(4.0)
    copula = ot.ClaytonCopula(2.0)
    pair = [Random("a", stats.norm(0, 1)), Random("b", stats.expon())]
    one = jo.design.Rosenblatt(pair, copula)
    law = ot.JointDistribution([ot.Normal(), ot.Exponential()], copula)
    other = jo.design.JointDistribution(("a", "b"), law)
    u = np.array([[0.3, -2.0], [1.2, 0.1]])
    np.testing.assert_allclose(one.to_x(u), other.to_x(u), rtol=1e-9)
    np.testing.assert_allclose(one.to_u(one.to_x(u)), u, atol=1e-8)
    np.testing.assert_allclose(other.to_u(other.to_x(u)), u, atol=1e-8)
    with pytest.raises(jo.InputError, match="finite"):
        Random("c", ot.Student(1.5))
    with pytest.raises(jo.InputError, match="continuous"):
        Random("c", ot.Poisson(3.0))
    with pytest.raises(jo.InputError, match="1 names for a distribution of 2"):
        jo.design.JointDistribution(("a",), law)


# -- wrong input -----------------------------------------------------------------------------------

A, B, C = (Random(name, stats.norm(0, 1)) for name in "abc")
E = Random("e", stats.expon())


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Random("x", stats.cauchy()), "must be finite .* truncate"),
        (lambda: Random("x", stats.t(2)), "deviation inf, both must be finite"),
        (lambda: Random("x", stats.norm), "with its parameters"),
        (lambda: Random("x", stats.poisson(3)), "continuous"),
        (lambda: Random("x", 3.0), "must be a frozen distribution"),
        (lambda: Random("", stats.norm()), "name must not be empty"),
        (lambda: Random("x", stats.norm([1, 2])), "arrays as parameters"),
        (lambda: Random("x", stats.norm(), "mean"), "keep is 'mean'"),
        (lambda: distribution_from_moments("log-normal", 1, 1), "did you mean 'lognormal'"),
        (lambda: distribution_from_moments("lognormal", -1, 1), "must be beyond 0"),
        (lambda: distribution_from_moments("normal", 1, -1), "deviation is -1"),
        (lambda: Nataf([A, A]), "'a' occurs twice"),
        (lambda: Nataf([]), "there are none"),
        (lambda: Nataf([A, B], {("a", "d"): 0.5}), "no random variable 'd'"),
        (lambda: Nataf([A, B], {("a", "b"): 1.2}), "a and b is 1.2, must be between"),
        (lambda: Nataf([A, B], [[1, 0.2], [0.3, 1]]), "symmetric"),
        (lambda: Nataf([A, B], {("a", "b"): 0.2}, "kendall"), "measure is 'kendall'"),
        (
            lambda: Nataf([E, Random("f", stats.expon())], {("e", "f"): -0.8}),
            "e and f is -0.8: variables with these distributions have correlations from -0.6449 to",
        ),
        (
            lambda: Nataf([A, B, C], {("a", "b"): 0.9, ("b", "c"): 0.9, ("a", "c"): -0.9}),
            "not possible already as it is given, its least eigenvalue .* contradict one another",
        ),
        (lambda: jo.design.Rosenblatt(3.0), "must be a sequence of Random"),
        (lambda: jo.design.Rosenblatt([A, "b"]), r"variables\[1\] is 'b'"),
        (lambda: jo.design.Rosenblatt([A, B], copula=3.0), "must be a copula of OpenTURNS"),
        (lambda: jo.design.JointDistribution(("a",), 3.0), "must be one of OpenTURNS"),
        (lambda: jo.design.Conditional("b", 3.0), "must be a function"),
    ],
)
def test_what_cannot_be_is_refused_by_a_sentence(make, said):
    with pytest.raises(jo.InputError, match=said):
        make()


@pytest.mark.parametrize(("a", "b"), [(0.2, 2.0), (2.0, 0.2), (0.2, 0.5), (2.0, 3.0)])
def test_a_beta_distribution_of_openturns_has_its_quantiles(a, b):
    """Root finding of OpenTURNS gives up on some shapes with a bare RuntimeError."""
    ot = pytest.importorskip("openturns")
    law = Random("x", ot.Beta(a, b, 0.0, 1.0)).law
    y = np.linspace(-6.0, 2.0, 17)
    # the incomplete beta function of scipy
    np.testing.assert_allclose(betainc(a, b, law.value(y)), stats.norm.cdf(y), rtol=1e-9)


def test_form_with_a_beta_distribution_of_openturns():
    ot = pytest.importorskip("openturns")
    found = jo.design.form(
        lambda x: 0.9 - x["x"], [Random("x", ot.Beta(0.2, 2.0, 0.0, 1.0))], start={"x": 0.8}
    )
    assert found.probability == pytest.approx(betainc(2.0, 0.2, 0.1), rel=1e-6)


def test_what_openturns_cannot_do_is_a_sentence():
    ot = pytest.importorskip("openturns")
    joint = jo.design.JointDistribution(["a"], ot.JointDistribution([ot.Beta(2.0, 2.0, 0.0, 1.0)]))

    def fails(given):
        raise RuntimeError("Root finding evaluation exceeded 200 iterations, giving up now.")

    object.__setattr__(joint, "_maps", (fails, fails))
    with pytest.raises(jo.InputError, match="a transformation of OpenTURNS failed: Root .*Rosenb"):
        joint.to_x(np.zeros(1))
