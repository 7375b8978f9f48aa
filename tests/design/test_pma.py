"""PMA: the school of Youn and Choi with its iteration counts, brute force, hand over."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.stats as stats

import jousto as jo
from design.limit_states import TEN, concave, convex, normal
from jousto.design.reliability.pma import METHODS

pma, ria, LimitState = jo.design.pma, jo.design.ria, jo.design.LimitState
A = [normal("a", 6, 0.8), normal("b", 6, 0.8)]
B = [normal("a", 4, 0.8), normal("b", 5, 0.8)]


def concave_gradient(x):
    return [0.08 * np.exp(0.8 * x["a"] - 1.2), 0.07 * np.exp(0.7 * x["b"] - 0.6)]


EXACT = {
    "A": (LimitState(convex, lambda x: [-np.exp(x["a"] - 7.0), -1.0]), A),
    "B": (LimitState(concave, concave_gradient), B),
}


def on_the_circle(function, variables, beta, points=400_001):
    """Return the least value on the circle, by trying: good to (2 pi beta / points)^2."""
    t = np.linspace(0.0, 2.0 * np.pi, points)
    u = beta * np.stack([np.cos(t), np.sin(t)])
    x = jo.design.Nataf(variables).to_x(u)
    g = function({"a": x[0], "b": x[1]})
    return float(g.min()), x[:, g.argmin()]


@pytest.mark.parametrize(
    ("case", "method", "steps"),
    [
        ("A", "amv", 13),
        ("A", "cmv", 27),
        ("A", "hmv", 13),
        ("B", "cmv", 51),
        ("B", "hmv", 45),
    ],
)
def test_iterations_of_mean_value_methods(case, method, steps):
    """Steps until ``|u / beta - n(u)| <= 1e-8``; the functions of Youn, Choi and Park (2003)."""
    found = pma(*EXACT[case], 3.0, method=method, tolerance=1e-8)
    assert (found.iterations, found.method, found.handed_over) == (steps, method, "")
    assert found.calls == found.gradients == steps + 1


@pytest.mark.parametrize("method", METHODS)
def test_least_values_are_those_of_brute_force(method):
    """Values and points by trying 2e6 points of the circle, printed with six digits."""
    a, b = (pma(*EXACT[case], 3.0, method=method) for case in "AB")
    assert a.value == pytest.approx(-0.357938, abs=1e-6)
    assert b.value == pytest.approx(0.203816, abs=1e-6)
    # the residual of 1e-6 leaves some 1e-6 of the radius, 2.4
    np.testing.assert_allclose(a.x, [8.318454, 6.620299], atol=2e-5)
    np.testing.assert_allclose(b.x, [2.680716, 2.995133], atol=2e-5)
    assert not a.reliable and b.reliable


def test_amv_goes_to_and_fro_on_the_concave_function():
    found = pma(*EXACT["B"], 3.0, method="amv")
    assert found.method == "sqp" and found.handed_over.startswith("amv: cycles between")
    assert "(a = 1.98085, b = 3.70268) and (a = 3.46408, b = 2.6606)" in found.handed_over
    assert found.residual <= 1e-6
    # residuals before the hand over stay where they are
    assert found.history[10:30, 2].min() > 0.5


def wells(x):
    """Concave to the origin, as a region between two walls that steepen."""
    return np.cosh(0.6 * (x["a"] + 4.0)) + np.cosh(0.5 * (x["b"] + 5.0)) - 2.5


def test_a_concave_function_of_our_own():
    variables = [normal("a", 0, 1), normal("b", 0, 1)]
    value, x = on_the_circle(wells, variables, 3.0)
    amv, hmv = (pma(wells, variables, 3.0, method=m) for m in ("amv", "hmv"))
    assert "cycles between" in amv.handed_over and not hmv.handed_over
    for found in (amv, hmv, pma(wells, variables, 3.0)):
        # the circle of 4e5 points is good to 1e-9, forward differences to 1e-5 of a direction
        assert found.value == pytest.approx(value, abs=1e-8)
        np.testing.assert_allclose(found.x, x, atol=1e-4)


def quartic(x):
    """The third function of B. D. Youn, K. K. Choi and L. Du, *AIAA J.* 43 (2005) 874-884."""
    y = 0.9063 * x["a"] + 0.4226 * x["b"] - 6.0
    return -1.0 + y**2 + y**3 - 0.6 * y**4 + 0.4226 * x["a"] - 0.9063 * x["b"]


def cubic(x):
    return 0.3 * x["a"] ** 2 * x["b"] - x["b"] + 0.8 * x["a"] + 1.0


@pytest.mark.parametrize(
    ("function", "variables", "beta"),
    [
        (quartic, [normal("a", 4.5, 0.3), normal("b", 2.0, 0.3)], 2.0),
        (cubic, [normal("a", 1.3, 0.55), normal("b", 1.0, 0.55)], 2.0),
        (TEN["exponential"][0], TEN["exponential"][1], 3.0),
        (TEN["skew cubic"][0], TEN["skew cubic"][1], 2.0),
    ],
)
@pytest.mark.parametrize("method", METHODS)
def test_further_functions(function, variables, beta, method):
    found = pma(function, variables, beta, method=method)
    value, _ = on_the_circle(function, variables, beta)
    assert found.value == pytest.approx(value, abs=1e-7 * max(1.0, abs(value)))


@pytest.mark.parametrize("name", TEN)
def test_the_value_at_the_index_of_form_is_zero(name):
    """PMA is the inverse of FORM, where the nearest point is the only one."""
    function, variables = TEN[name]
    found = jo.design.form(function, variables)
    back = pma(function, variables, found.beta)
    size = np.linalg.norm(found.gradient)
    assert back.value == pytest.approx(0.0, abs=1e-7 * size * max(1.0, found.beta))
    assert ria(function, variables, 2.0).value == pytest.approx(found.beta - 2.0, abs=1e-9)


def test_sensitivities_are_those_of_an_analysis_repeated():
    def at(mean, deviation):
        return pma(EXACT["B"][0], [normal("a", mean, deviation), B[1]], 3.0, tolerance=1e-10)

    found = at(4.0, 0.8)
    h = 1e-3
    by_mean = (at(4.0 + h, 0.8).value - at(4.0 - h, 0.8).value) / (2 * h)
    by_deviation = (at(4.0, 0.8 + h).value - at(4.0, 0.8 - h).value) / (2 * h)
    # central differences: h^2
    assert found.by_mean["a"] == pytest.approx(by_mean, rel=1e-5)
    assert found.by_deviation["a"] == pytest.approx(by_deviation, rel=1e-5)


@pytest.mark.parametrize("step", [1e-3, 1e-2])
def test_wide_differences_end_where_they_blur(step):
    """Forward differences err in direction by half a step times the curvature, squared in value."""
    function, variables = TEN["concave"]
    wide = LimitState(function, step=step)
    found, exact = (pma(g, B, 3.0) for g in (wide, EXACT["B"][0]))
    assert found.value == pytest.approx(exact.value, abs=10.0 * step**2)
    beta = jo.design.form(wide, variables).beta
    assert beta == pytest.approx(jo.design.form(function, variables).beta, abs=10.0 * step**2)


def test_ria_says_whether_the_target_is_reached():
    found = ria(lambda x: 3.0 - x["a"], [normal("a", 0, 1)], 3.5)
    assert found.value == pytest.approx(-0.5, abs=1e-9) and not found.reliable
    assert "target 3.5 missed" in repr(found)


@pytest.mark.parametrize(
    ("named", "said"),
    [
        ({"beta": -1.0}, "beta is -1"),
        ({"beta": 50.0}, "at most 38"),
        ({"method": "newton"}, "method is 'newton', must be one of sqp, hmv"),
        ({"tolerance": 0.0}, "tolerance is 0"),
    ],
)
def test_wrong_arguments(named, said):
    given = {"beta": 3.0} | named
    with pytest.raises(jo.InputError, match=said):
        pma(convex, A, **given)


def test_what_cannot_be_found_is_told():
    with pytest.raises(jo.design.DesignPointError, match="its gradient is zero"):
        pma(lambda x: 1.0, A, 3.0)
    with pytest.raises(jo.design.DesignPointError, match="no least value on the sphere"):
        pma(concave, B, 3.0, iterations=1)
    with pytest.raises(jo.design.LimitStateError, match="returned nan"):
        pma(lambda x: np.nan, A, 3.0)
    assert stats.norm.cdf(-3.0) < 0.0014  # what a target of 3 is
