"""FORM: published numbers, ten limit states of other programs, sensitivities, failures."""

from __future__ import annotations

import pickle
import re
from pathlib import Path

import numpy as np
import pytest
import scipy.stats as stats

import jousto as jo
from design.limit_states import BETAS, CALLS, TEN, lognormal, normal, slopes

form, LimitState, Random = jo.design.form, jo.design.LimitState, jo.design.Random
METHODS = ("sqp", "hlrf")


@pytest.mark.parametrize("method", METHODS)
def test_cantilever_of_openturns(method):
    """OpenTURNS, ``python/test/t_FORM_std.expout``; the numbers are printed with six digits."""
    found = form(*TEN["cantilever"], method=method)
    assert found.beta == pytest.approx(1.009255, abs=1e-6)
    assert found.probability == pytest.approx(0.156426, abs=1e-6)
    # forward differences of 1e-5 deviations: some 1e-6 of the direction
    np.testing.assert_allclose(found.u, [-0.031035, 0.841942, 0.445404, -0.332238], atol=5e-6)
    np.testing.assert_allclose(found.x, [49.968965, 1.841942, 10.445404, 4.667762], atol=5e-6)


@pytest.mark.parametrize("method", METHODS)
def test_axially_loaded_bar(method):
    """The use case of OpenTURNS and Persalys; both programs agree to 1e-11 with Pystra."""
    found = form(*TEN["bar"], method=method)
    assert found.beta == pytest.approx(1.88104652, abs=2e-8)
    assert found.probability == pytest.approx(0.0299828, abs=5e-8)
    assert found.x["R"] == pytest.approx(254.6287, abs=5e-4)
    assert found.x["F"] == pytest.approx(79993.96, abs=0.2)


@pytest.mark.parametrize("name", TEN)
def test_ten_limit_states_of_openturns_and_pystra(name):
    found = form(*TEN[name])
    # the two programs differ from one another by up to 2e-7 of beta
    assert found.beta == pytest.approx(BETAS[name], rel=3e-7)
    assert found.calls <= min(CALLS[name])
    slow = form(*TEN[name], method="hlrf")
    assert slow.beta == pytest.approx(BETAS[name], rel=3e-7)


def test_the_page_has_the_calls():
    page = Path(__file__).parents[2] / "docs" / "benchmarks-design.md"
    rows = re.findall(
        r"^\| (.+?) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \| (\d+) \|$", page.read_text("utf-8"), re.M
    )
    told = {name: tuple(map(int, numbers)) for name, *numbers in rows}
    assert list(told) == list(TEN)
    for name, (n, calls, few, *others) in told.items():
        function, variables = TEN[name]
        assert (n, tuple(others)) == (len(variables), CALLS[name])
        # one step more or less may come of another processor's rounding
        assert abs(form(function, variables).calls - calls) <= n + 1
        exact = form(LimitState(function, gradient=slopes(function, variables)), variables)
        assert abs(exact.calls - few) <= 1
        assert exact.gradients <= exact.calls


@pytest.mark.parametrize("name", TEN)
def test_all_forms_of_a_limit_state_give_one_answer(name):
    """Differences of one point or of many at once, to one side or to both."""
    function, variables = TEN[name]
    one = form(function, variables)
    many = form(LimitState(function, vectorised=True), variables)
    assert many.calls == one.calls
    # the same numbers but for the order of operations of numpy on arrays
    np.testing.assert_allclose(many.u, one.u, atol=1e-7)
    both = form(LimitState(function, differences="central"), variables)
    assert both.beta == pytest.approx(one.beta, rel=1e-8)


def gradient(x):
    k = x["F"] * x["L"] ** 2 / (3.0 * x["E"] * x["I"])
    return {
        "E": k * x["L"] / x["E"],
        "F": -k * x["L"] / x["F"],
        "L": -3.0 * k,
        "I": k * x["L"] / x["I"],
    }


def test_a_given_gradient_saves_the_differences():
    function, variables = TEN["cantilever"]
    found = form(LimitState(function, gradient), variables)
    assert found.beta == pytest.approx(1.0092549405, abs=1e-9)  # OpenTURNS 1.27.post1
    assert found.calls == found.gradients == found.iterations + 1 < 8
    assert repr(found).endswith("6 calls and 6 gradients>")
    pair = form(LimitState(lambda x: (function(x), gradient(x)), gradient=True), variables)
    assert (pair.calls, pair.beta) == (found.calls, found.beta)
    array = form(
        LimitState(function, lambda x: [gradient(x)[name] for name in x.keys()]),
        variables,
    )
    assert array.beta == found.beta


def test_importance_and_sensitivities_of_normal_variables():
    """``beta = (m_R - m_S) / s``, ``s^2 = s_R^2 + s_S^2``."""
    found = form(lambda x: x["R"] - x["S"], [normal("R", 5, 3), normal("S", 0, 4)])
    assert found.beta == pytest.approx(1.0, abs=1e-9)
    assert dict(found.importance) == pytest.approx({"R": 0.36, "S": 0.64}, abs=1e-9)
    assert dict(found.by_mean) == pytest.approx({"R": 0.2, "S": -0.2}, abs=1e-9)
    assert dict(found.by_deviation) == pytest.approx({"R": -3 / 25, "S": -4 / 25}, abs=1e-9)


def test_sensitivities_are_those_of_an_analysis_repeated():
    """With correlated lognormal and Gumbel variables, the distortion moving along."""

    def variables(**moved):
        moments = {"R": (300.0, 30.0), "F": (75e3, 5e3), "A": (314.0, 10.0)} | moved
        kinds = {"R": "lognormal", "F": "gumbel", "A": "weibull"}
        made = [
            Random(n, jo.design.distribution_from_moments(kinds[n], *m)) for n, m in moments.items()
        ]
        return jo.design.Nataf(made, {("R", "A"): 0.4, ("R", "F"): -0.2})

    def g(x):
        return x["R"] - x["F"] / x["A"]

    state = LimitState(g, lambda x: [1.0, -1.0 / x["A"], x["F"] / x["A"] ** 2])
    found = form(state, variables(), tolerance=1e-9)
    for name, mean, deviation in (("R", 300, 30), ("F", 75e3, 5e3), ("A", 314, 10)):
        for which, known in ((0, found.by_mean), (1, found.by_deviation)):
            h = 1e-3 * deviation
            up, down = (
                [mean + h * (which == 0) * s, deviation + h * (which == 1) * s] for s in (1, -1)
            )
            ends = [form(state, variables(**{name: tuple(m)}), tolerance=1e-9) for m in (up, down)]
            # central differences of steps of 1e-3 deviations
            expected = (ends[0].beta - ends[1].beta) / (2 * h)
            assert known[name] == pytest.approx(expected, rel=1e-4, abs=1e-9 / deviation)
    assert sum(found.importance.values()) == pytest.approx(1.0)


def test_correlated_normal_variables():
    """``beta = m / sqrt(a^T C a)`` of a linear limit state."""
    pair = jo.design.Nataf([normal("R", 5, 3), normal("S", 0, 4)], {("R", "S"): 0.5})
    found = form(lambda x: x["R"] - x["S"], pair)
    assert found.beta == pytest.approx(5.0 / np.sqrt(9 + 16 - 12), rel=1e-9)


class Given(stats.rv_continuous):
    """``F(x2 | x1) = 1 - (1 + x2) exp(-x2 - x1 x2)``."""

    def _cdf(self, x, given):
        return 1.0 - self._sf(x, given)

    def _sf(self, x, given):
        return (1.0 + x) * np.exp(-x * (1.0 + given))

    def _pdf(self, x, given):
        return ((1.0 + given) * (1.0 + x) - 1.0) * np.exp(-x * (1.0 + given))


@pytest.mark.parametrize(
    ("order", "beta", "other"), [(("x1", "x2"), 2.784, 3.501), (("x2", "x1"), 2.649, 3.633)]
)
def test_dependent_exponential_variables(order, beta, other):
    """M. Hohenbichler and R. Rackwitz, *J. Eng. Mech. Div.* 107 (1981) 1227-1238.

    ``F = 1 - exp(-x1) - exp(-x2) + exp(-x1 - x2 - x1 x2)``, G = 18 - 3 x1 - 2 x2. The index depends
    on the order of the transformation: 2.78 and 2.65, with a second design point farther away
    (H. O. Madsen, S. Krenk and N. C. Lind, *Methods of structural safety*, 1986, have 2.784).
    """
    first, second = order
    law = Given(a=0.0, name="given")
    chain = jo.design.Rosenblatt(
        [
            Random(first, stats.expon()),
            jo.design.Conditional(second, lambda x: law(x[first])),
        ]
    )

    def g(x):
        return 18.0 - 3.0 * x["x1"] - 2.0 * x["x2"]

    # the last printed digit
    assert form(g, chain).beta == pytest.approx(beta, abs=6e-4)
    far = form(g, chain, start={"x1": 0.5, "x2": 8.0})
    assert far.beta == pytest.approx(other, abs=6e-4)


def test_medians_that_fail_have_a_negative_index():
    found = form(lambda x: -1.0 - x["a"], [normal("a", 0, 0.5)])
    assert found.beta == pytest.approx(-2.0, abs=1e-9)
    assert found.probability == pytest.approx(stats.norm.cdf(2.0), rel=1e-9)


def test_values_have_names_and_places():
    seen = []

    def g(x):
        seen.append(x)
        R, S = x
        assert x["R"] == R == x[0]
        assert dict(**x) == {"R": R, "S": S}
        with pytest.raises(jo.InputError, match="no value 'T'; known: R, S"):
            x["T"]
        return R - S

    form(g, [normal("R", 5, 3), normal("S", 0, 4)])
    assert repr(seen[0]) == "<Values: R = 5, S = 0>"
    copy = pickle.loads(pickle.dumps(seen[0]))
    assert copy.names == ("R", "S")
    assert (2.0 * seen[0]).names == ()


def test_a_start_and_a_limit_state_that_cannot_be_computed_everywhere():
    """Beyond x = 6 the root has no value; steps that go there are shortened."""

    def g(x):
        if x["a"] > 6.0:
            raise ArithmeticError("no equilibrium")
        return np.sqrt(6.0 - x["a"]) - 1.0

    found = form(g, [normal("a", 1, 1)], start={"a": -20.0})
    assert found.beta == pytest.approx(4.0, abs=1e-6)


# -- what goes wrong -------------------------------------------------------------------------------

ONE = [normal("a", 0, 1)]


def test_a_failing_limit_state_says_where():
    with pytest.raises(jo.design.LimitStateError) as error:
        form(lambda x: 1 / 0, ONE)
    assert (
        str(error.value) == "limit state 'G': failed: ZeroDivisionError: division by zero, at a = 0"
    )
    assert error.value.x == {"a": 0.0}


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda x: float("nan"), "limit state 'G': returned nan, at a = 0"),
        (lambda x: None, "returned None, must be one number"),
        (lambda x: [1.0, 2.0], "must be one number"),
        (lambda x: 1j, "must be one number"),
        (LimitState(lambda x: x * np.nan, vectorised=True), "returned nan"),
        (LimitState(lambda x: 1.0, gradient=lambda x: [np.nan]), r"its gradient is \[nan\]"),
        (LimitState(lambda x: 1.0, gradient=True), "must return its value and its gradient"),
    ],
)
def test_limit_states_that_give_no_number(function, said):
    with pytest.raises(jo.design.LimitStateError, match=said):
        form(function, ONE)


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda x: 1.0, "its gradient is zero at a = 0"),
        (lambda x: 9.0 - x["a"], "design point is at beta = 9, beyond 8"),
        (lambda x: 2.0 + np.tanh(x["a"]), "no failure found; G is still 1"),
        (lambda x: 1.0 + x["a"] ** 2 + 0.1 * x["a"], "no failure found"),
    ],
)
def test_limit_states_without_a_design_point(function, said):
    with pytest.raises(jo.design.DesignPointError, match=said) as error:
        form(function, ONE)
    assert np.all(np.isfinite(error.value.u))


def test_an_iteration_that_does_not_end_says_how_far_it_came():
    with pytest.raises(jo.design.DesignPointError, match="no design point after 6 steps") as error:
        form(*TEN["cubic"], iterations=6)
    assert len(error.value.history) == 7


def test_a_far_design_point_is_found_if_asked_for():
    assert form(lambda x: 9.0 - x["a"], ONE, far=10.0).beta == pytest.approx(9.0, abs=1e-9)


@pytest.mark.parametrize(
    ("named", "said"),
    [
        ({"method": "newton"}, "method is 'newton'"),
        ({"tolerance": -1.0}, "tolerance is -1"),
        ({"iterations": 0}, "iterations is 0"),
        ({"far": 0.0}, "far is 0"),
        ({"start": {"b": 1.0}}, "needs a value for each of a; wrong: a, b"),
        ({"start": [1.0, 2.0]}, "must be 1 numbers"),
        ({"variables": 3.0}, "variables is 3.0"),
        ({"limit": 3.0}, "function is 3.0"),
        ({"limit": LimitState(lambda x: x[0], lambda x: {"b": 1.0})}, "its gradient has 'b'"),
        ({"limit": LimitState(lambda x: x[0], lambda x: [1.0, 2.0])}, "2 numbers, must have 1"),
    ],
)
def test_wrong_arguments(named, said):
    given = {"limit": lambda x: 3.0 - x["a"], "variables": ONE} | named
    with pytest.raises(jo.InputError, match=said):
        form(given.pop("limit"), given.pop("variables"), **given)


def test_a_start_outside_of_a_distribution():
    with pytest.raises(jo.InputError, match="R is -1, outside of its distribution"):
        form(lambda x: x["R"], [lognormal("R", 1, 1)], start={"R": -1.0})
    with pytest.raises(jo.InputError, match="step is 0"):
        LimitState(lambda x: x, step=0.0)


def test_openturns_joint_distributions_find_the_point_of_openturns(openturns):
    ot = openturns
    law = ot.JointDistribution([ot.Normal(5.0, 1.0), ot.Gumbel(0.5, 1.0)], ot.ClaytonCopula(2.0))
    found = form(
        lambda x: x["R"] - x["S"], jo.design.JointDistribution(("R", "S"), law), tolerance=1e-8
    )
    state = ot.SymbolicFunction(["R", "S"], ["R - S"])
    vector = ot.CompositeRandomVector(state, ot.RandomVector(law))
    solver = ot.AbdoRackwitz()
    solver.setStartingPoint([5.0, 1.0])
    for name in ("AbsoluteError", "RelativeError", "ResidualError", "ConstraintError"):
        getattr(solver, f"setMaximum{name}")(1e-8)
    theirs = ot.FORM(solver, ot.ThresholdEvent(vector, ot.LessOrEqual(), 0.0))
    theirs.run()
    known = theirs.getResult()
    assert found.beta == pytest.approx(known.getHasoferReliabilityIndex(), rel=1e-6)
    np.testing.assert_allclose(found.u, known.getStandardSpaceDesignPoint(), atol=1e-4)
    assert not found.by_mean
