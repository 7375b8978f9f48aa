"""SORM: paraboloids, exact probabilities, curvatures of OpenTURNS, and where formulas end."""

from __future__ import annotations

import math

import numpy as np
import pytest
import scipy.integrate
import scipy.stats as stats

import jousto as jo
from design.limit_states import TEN, normal
from jousto.design.reliability.sorm import probabilities

form, sorm, LimitState = jo.design.form, jo.design.sorm, jo.design.LimitState
STANDARD = [normal(name, 0, 1) for name in ("a", "b", "c")]

# OpenTURNS 1.27.post1, SORM at the design point: Breitung, Hohenbichler-Rackwitz, Tvedt. Its
# differences have absolute steps, which are wrong for the bar and the roof in SI units.
HARD = ("Hohenbichler-Rackwitz", "Tvedt")
OPENTURNS = {
    "cantilever": (0.14895531, 0.14579899, 0.14510390),
    "cubic": (0.00444413, 0.00416520, 0.00394032),
    "skew cubic": (0.00432124, 0.00407461, 0.00388644),
    "exponential": (3.6158629e-4, 3.5879671e-4, 3.5833419e-4),
    "oscillator": (0.02900232, 0.02865666, 0.02857710),
    "frame": (0.01200669, 0.01263992, 0.01233383),
    "convex": (0.00221017, 0.00223546, 0.00223102),
    "concave": (4.4936663e-5, 4.4126951e-5, 4.3727459e-5),
}


@pytest.mark.parametrize("name", OPENTURNS)
def test_probabilities_of_openturns(name):
    found = sorm(*TEN[name])
    three = (found.breitung, found.hohenbichler, found.tvedt)
    # second differences of both programs: third derivatives times steps of 0.01
    assert three == pytest.approx(OPENTURNS[name], rel=2e-4)
    n = len(TEN[name][1])
    assert found.calls == found.form.calls + (n - 1) * (n + 6) // 2 + 1


def test_the_bar_beside_its_exact_probability():
    """``P = E[F_R(F / A)]``, an integral over the normal force."""
    function, (strength, force) = TEN["bar"]
    law = strength.distribution

    def inside(y):
        return law.cdf((75e3 + 5e3 * y) / (100.0 * math.pi)) * stats.norm.pdf(y)

    exact = scipy.integrate.quad(inside, -10.0, 10.0, epsabs=1e-12)[0]
    found = sorm(function, [strength, force])
    # what the second order leaves of the error of the first, 2.7 %
    assert found.form.probability / exact == pytest.approx(1.027, abs=1e-3)
    assert found.probability == pytest.approx(exact, rel=2e-3)


@pytest.mark.parametrize("kappa", [(0.3, 0.1), (-0.15, 0.2), (1.0, 2.0)])
def test_paraboloids(kappa):
    """``u_3 = beta + sum kappa_i v_i^2 / 2``; exact by a double integral."""

    def g(x):
        return 2.5 + 0.5 * (kappa[0] * x["a"] ** 2 + kappa[1] * x["b"] ** 2) - x["c"]

    def dg(x):
        return {"a": kappa[0] * x["a"], "b": kappa[1] * x["b"], "c": -1.0}

    def inside(a, b):
        both = 0.5 * (kappa[0] * a * a + kappa[1] * b * b)
        return stats.norm.sf(2.5 + both) * stats.norm.pdf(a) * stats.norm.pdf(b)

    y = np.linspace(-8.0, 8.0, 161)  # sums of equal steps converge exponentially
    exact = inside(y[:, None], y[None, :]).sum() * (y[1] - y[0]) ** 2
    for found in (sorm(g, STANDARD), sorm(LimitState(g, dg), STANDARD)):
        # second differences are exact here, but for rounding: 1e-16 / 0.01^2
        np.testing.assert_allclose(found.curvatures, sorted(kappa), atol=1e-6)
        assert found.tvedt == pytest.approx(exact, rel=0.06)
        error = [abs(p / exact - 1) for p in (found.form.probability, found.breitung, found.tvedt)]
        assert max(error[1:]) < error[0]


def test_planes_and_single_variables_have_no_curvature():
    for variables in (STANDARD, STANDARD[:1]):
        found = sorm(lambda x: 2.0 - np.sum(x) / math.sqrt(len(x)), variables)
        assert found.probability == pytest.approx(stats.norm.sf(2.0), rel=1e-6)
        assert found.beta == pytest.approx(2.0, rel=1e-6)


def test_failing_medians_have_the_complement():
    function, variables = TEN["convex"]
    safe = sorm(function, variables)
    other = sorm(lambda x: -function(x), variables)
    assert other.probability == pytest.approx(1.0 - safe.probability, rel=1e-6)
    assert other.form.beta == pytest.approx(-safe.form.beta, rel=1e-9)


def test_a_result_of_form_is_enough():
    found = form(*TEN["convex"])
    assert sorm(found).tvedt == sorm(*TEN["convex"]).tvedt
    assert "Breitung 0.00221" in repr(sorm(found))
    with pytest.raises(jo.InputError, match="leave variables out"):
        sorm(found, TEN["convex"][1])
    with pytest.raises(jo.InputError, match="step is -1"):
        sorm(found, step=-1.0)


def test_a_surface_that_bends_more_than_a_sphere_is_refused():
    """The farthest point of an ellipse within reach is stationary, too."""

    def g(x):
        return 1.0 - (x["a"] / 2.0) ** 2 - (x["b"] / 3.0) ** 2

    def dg(x):
        return [-x["a"] / 2.0, -2.0 * x["b"] / 9.0]

    found = form(LimitState(g, dg), STANDARD[:2], start={"a": 0.0, "b": 2.0})
    assert found.beta == pytest.approx(3.0, rel=1e-6)
    with pytest.raises(jo.design.DesignPointError, match="not the nearest one"):
        sorm(found)


def test_a_formula_that_does_not_hold_is_told():
    assert np.isnan(probabilities(2.0, np.array([-0.45]))[1])
    with pytest.warns(jo.JoustoWarning) as told:
        found = sorm(lambda x: 2.0 - 0.225 * x["b"] ** 2 - x["a"], STANDARD[:2])
    said = [str(one.message) for one in told]
    assert said == [f"limit state 'G': the formula of {name} does not hold here" for name in HARD]
    assert np.isfinite(found.breitung)


def test_a_noisy_limit_state_is_told():
    x = [normal("a", 0, 1), normal("b", 0, 1)]

    def noisy(x):
        return 3.0 - x["a"] + 0.1 * x["b"] ** 2 + 1e-5 * np.sin(1e7 * x["b"] + 3e6 * x["a"])

    state = jo.design.LimitState(noisy, step=1e-2)
    # noise of 1e-5 by the square of a step of 0.01 is 0.1, the half of the curvature
    with pytest.warns(jo.JoustoWarning, match="its curvatures change with the step"):
        jo.design.sorm(state, x, step=1e-2)
    found = jo.design.sorm(state, x, step=0.3)
    # with 0.3 it is 1e-4
    assert found.curvatures[0] == pytest.approx(0.2, abs=1e-3)
