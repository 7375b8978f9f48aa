"""Several design points, and systems of limit states."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.integrate
import scipy.stats as stats

import jousto as jo
from design.limit_states import normal

LimitState = jo.design.LimitState
TWO = [normal("a", 0, 1), normal("b", 0, 1)]
ROOT = np.sqrt(2.0)


def branches(x):
    """Four branches, the classical series system (P. H. Waarts, TU Delft 2000) with k = 7."""
    a, b = x["a"], x["b"]
    bend = 3.0 + 0.1 * (a - b) ** 2
    sides = [bend - (a + b) / ROOT, bend + (a + b) / ROOT, a - b + 7 / ROOT, b - a + 7 / ROOT]
    return np.minimum.reduce([np.asarray(one) for one in sides])


def exact_of_branches():
    """Turned by 45 degrees: p = (a + b) / root, q = (a - b) / root."""

    def inside(q):
        return (2.0 * stats.norm.cdf(3.0 + 0.2 * q * q) - 1.0) * stats.norm.pdf(q)

    return 1.0 - scipy.integrate.quad(inside, -3.5, 3.5, epsabs=1e-14)[0]


def parabola(x):
    """Two points, of beta 2.906 and 3.094 (A. Der Kiureghian and T. Dakessian, 1998, example 1)."""
    return 5.0 - x["b"] - 0.5 * (x["a"] - 0.1) ** 2


def exact_of_parabola():
    def failed(a):
        return stats.norm.sf(5.0 - 0.5 * (a - 0.1) ** 2) * stats.norm.pdf(a)

    return scipy.integrate.quad(failed, -10, 10, epsabs=1e-14)[0]


ANGLES = np.array([0.0, 2.0, 4.0])  # rad, so that each tangent hides the others somewhere


def triangle(x):
    """Three planes around the origin; what is opposite of one leads to another."""
    sides = zip(ANGLES, (2.5, 2.6, 2.7), strict=True)
    return np.minimum.reduce([b - np.cos(t) * x["a"] - np.sin(t) * x["b"] for t, b in sides])


def exact_of_triangle():
    """The planes themselves; two of them at once fail beyond 4.6, with less than 3e-5."""
    return float(stats.norm.sf([2.5, 2.6, 2.7]).sum())


@pytest.mark.parametrize(
    ("function", "exact", "points"),
    [
        (parabola, exact_of_parabola(), 2),
        (lambda x: 3.0 - np.abs(x["a"]), 2.0 * stats.norm.sf(3.0), 2),
        (
            lambda x: np.minimum(3.0 - x["a"], 3.2 - x["b"]),
            1.0 - stats.norm.cdf(3.0) * stats.norm.cdf(3.2),
            2,
        ),
        (branches, exact_of_branches(), 4),
        (triangle, exact_of_triangle(), 3),
        (lambda x: 3.0 - x["a"], stats.norm.sf(3.0), 1),
    ],
)
def test_importance_sampling_sees_all_design_points(function, exact, points):
    state = LimitState(function, vectorised=True)
    found = jo.design.form(state, TWO, start={"a": 0.3, "b": 0.1})
    sampled = jo.design.importance_sampling(found, samples=20_000)
    assert len(sampled.points) == points
    # four standard errors: once in 16000
    assert sampled.probability == pytest.approx(exact, rel=4.0 * sampled.variation)
    assert sampled.variation < 0.02
    if points > 1:
        assert jo.design.check_linearisation(found).significant == (True,)
    one = jo.design.importance_sampling(found, samples=20_000, search=False)
    assert len(one.points) == 1 and (points != 2 or one.high < exact)


@pytest.mark.parametrize("n", [3, 4, 6])
def test_planes_in_any_direction_are_seen(n):
    """Series of planes near one another in distance, whose sum bounds the probability."""
    rng = np.random.default_rng(n)
    names = [normal(f"x{i}", 0, 1) for i in range(n)]
    for _ in range(5):
        normals = np.linalg.qr(rng.normal(size=(n, n)))[0][: min(n, 4)]
        betas = rng.uniform(2.5, 2.9, len(normals))

        def state(x, normals=normals, betas=betas):
            u = np.array([x[f"x{i}"] for i in range(n)])
            return (betas[:, None] - normals @ u.reshape(n, -1)).min(axis=0).reshape(u[0].shape)

        made = LimitState(state, vectorised=True)
        sampled = jo.design.importance_sampling(made, names, samples=20_000)
        # planes at right angles are independent
        exact = 1.0 - np.prod(stats.norm.cdf(betas))
        assert len(sampled.points) == len(normals)
        assert sampled.probability == pytest.approx(exact, rel=4.0 * sampled.variation)


def test_points_of_a_parabola_are_those_published():
    found = jo.design.form(LimitState(parabola, vectorised=True), TWO, start={"a": -1, "b": 0})
    sampled = jo.design.importance_sampling(found, samples=1000)
    # printed digits
    assert [one.beta for one in sampled.points] == pytest.approx([2.906, 3.094], abs=5e-4)


def test_a_limit_state_that_is_nearly_plane_needs_no_search():
    """Tangents at two starts and, at most, at each of two places across for each other variable."""

    def life(x):
        return 34.0 * (1.0 + 0.04 * x["a"]) ** 2.4 * np.exp(-0.3 * x["b"]) - 10.0 * np.exp(
            0.5 * x["c"]
        )

    three = [*TWO, normal("c", 0, 1)]
    found = jo.design.form(LimitState(life, vectorised=True), three)
    sampled = jo.design.importance_sampling(found, samples=100)
    assert len(sampled.points) == 1
    assert sampled.calls - found.calls - 100 <= 2 * (3 + 1) + 2 * 2 * (1 + 3 + 1)


def test_the_rare_side_may_be_the_safe_one():
    state = LimitState(lambda x: np.abs(x["a"]) - 3.0, vectorised=True)
    found = jo.design.form(state, TWO, start={"a": 0.3, "b": 0.1})
    sampled = jo.design.importance_sampling(found, samples=20_000)
    safe = 2.0 * stats.norm.sf(3.0)
    assert len(sampled.points) == 2
    assert 1.0 - sampled.probability == pytest.approx(safe, rel=0.06)


def planes(*betas):
    """Return independent planes, one for each variable."""
    made = [normal(f"x{i}", 0, 1) for i in range(len(betas))]
    states = [
        LimitState(lambda x, i=i, b=b: b - x[i], vectorised=True, name=f"g{i}")
        for i, b in enumerate(betas)
    ]
    return states, made


@pytest.mark.parametrize("kind", ["series", "parallel"])
def test_independent_planes(kind):
    betas = np.array([1.0, 1.5, 2.0])
    states, variables = planes(*betas)
    found = jo.design.system(states, variables, kind=kind)
    p = stats.norm.sf(betas)
    exact = 1.0 - np.prod(1.0 - p) if kind == "series" else np.prod(p)
    # quasi Monte Carlo of scipy in three dimensions
    assert found.probability == pytest.approx(exact, abs=1e-5)
    assert found.low <= exact <= found.high
    assert found.sampled.low < exact < found.sampled.high


def test_planes_of_equal_correlation():
    """``P = 1 - int Phi((beta + sqrt(r) t) / sqrt(1 - r))^n phi(t) dt``."""
    r, beta, n = 0.5, 2.5, 4
    made = [normal(f"x{i}", 0, 1) for i in range(n + 1)]
    states = [lambda x, i=i: beta - np.sqrt(r) * x[n] - np.sqrt(1.0 - r) * x[i] for i in range(n)]
    found = jo.design.system([LimitState(s, vectorised=True) for s in states], made)

    def inside(t):
        return stats.norm.cdf((beta - np.sqrt(r) * t) / np.sqrt(1.0 - r)) ** n * stats.norm.pdf(t)

    exact = 1.0 - scipy.integrate.quad(inside, -10, 10, epsabs=1e-13)[0]
    np.testing.assert_allclose(found.correlation[0, 1], r, atol=1e-6)
    assert found.low <= exact <= found.high < 1.3 * found.low
    assert found.probability == pytest.approx(exact, abs=1e-5)
    assert found.sampled.low < exact < found.sampled.high
    # beyond four tangents: the exact bounds of one event and of the sum hold, too
    p = stats.norm.sf(beta)
    assert p <= found.low and found.high <= n * p


@pytest.mark.parametrize("kind", ["series", "parallel"])
@pytest.mark.parametrize(("beta", "r"), [(4.0, 0.8), (5.5, 0.8), (5.5, 0.3)])
def test_errors_are_shares_of_a_rare_failure(beta, r, kind):
    """As above, or ``int Phi((sqrt(r) t - beta) / sqrt(1 - r))^n phi(t) dt`` in parallel."""
    n = 3
    made = [normal(f"x{i}", 0, 1) for i in range(n + 1)]
    states = [lambda x, i=i: beta - np.sqrt(r) * x[n] - np.sqrt(1.0 - r) * x[i] for i in range(n)]
    limits = [LimitState(s, vectorised=True) for s in states]
    found = jo.design.system(limits, made, kind=kind, samples=0)

    def failed(t):
        p = stats.norm.cdf((np.sqrt(r) * t - beta) / np.sqrt(1.0 - r))
        share = p**n if kind == "parallel" else p * (3.0 - 3.0 * p + p**2)  # 1 - (1 - p)^3
        return share * stats.norm.pdf(t)

    exact = scipy.integrate.quad(failed, -8, 12, epsabs=0, epsrel=1e-8, points=[beta])[0]
    # quasi Monte Carlo with a relative error of 1e-4 at 3.5 of its deviations
    assert found.probability == pytest.approx(exact, rel=5e-4)
    again = jo.design.system(limits, made, kind=kind, samples=0)
    assert again.probability == found.probability


def test_the_points_of_one_limit_state_are_in_series():
    state = LimitState(branches, vectorised=True)
    sampled = jo.design.importance_sampling(state, TWO)
    found = jo.design.system(sampled.points)
    assert "4 limit states in series" in repr(found)
    exact = exact_of_branches()
    assert found.sampled.low < exact < found.sampled.high
    # the bend of two branches is left out by their tangents
    assert found.high > exact


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"limits": []}, "must be two or more"),
        ({"kind": "both"}, "kind is 'both'"),
        ({"samples": -1}, "samples is -1"),
    ],
)
def test_what_is_no_system_is_refused(given, said):
    states, variables = planes(1.0, 2.0)
    with pytest.raises(jo.InputError, match=said):
        jo.design.system(**({"limits": states, "variables": variables} | given))
    other = jo.design.form(states[0], variables)
    alone = jo.design.form(lambda x: 2.0 - x["y"], [normal("y", 0, 1)])
    with pytest.raises(jo.InputError, match="has other random variables"):
        jo.design.system([other, alone])
