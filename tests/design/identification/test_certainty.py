"""Intervals hold the truth as often as they say; sentences of what is not seen."""

import numpy as np
import pytest
from scipy.signal import lfilter

import jousto as jo
from jousto.base.errors import Problems
from jousto.design.identification.certainty import certainty
from jousto.design.identification.unknowns import unknowns
from jousto.design.identification.unseen import find_unseen
from jousto.design.identification.whiteness import autocovariance, autoregression, whiteness

N, NOISES = 600, 400


def linear_case(seed, memory):
    """Return derivatives and residuals of a linear fit, and the errors of its two unknowns."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0.0, 30.0, N)
    J = np.column_stack([np.sin(t), np.exp(-t / 10.0)])
    noise = lfilter([np.sqrt(1 - memory**2)], [1.0, -memory], rng.normal(size=N + 200))[200:]
    error = np.linalg.solve(J.T @ J, J.T @ noise)
    return J, J @ error - noise, error


def held(memory):
    """Return how often intervals of 95 % hold the truth: with the memory, and without it."""
    sought = unknowns(Problems(), [jo.Parameter("a", 0.0), jo.Parameter("b", 0.0)])
    count = np.zeros((2, 2))
    one = np.ones(N)
    for seed in range(NOISES):
        J, r, error = linear_case(seed, memory)
        sure = certainty(J, np.zeros((0, 2)), r, one, [N], sought, np.zeros(2), [True])
        for k, C in enumerate((sure.covariance, sure.plain)):
            count[k] += np.abs(error) < 1.96 * np.sqrt(np.diag(C))
    return count / NOISES


def test_intervals_of_white_noise_hold_the_truth():
    # the deviation of a share of 400 is 1.1 %
    assert np.all(np.abs(held(0.0) - 0.95) < 0.03)


def test_intervals_of_noise_with_memory_hold_the_truth():
    """AR(1), 0.9: intervals that forget it hold the truth in 31 to 48 %."""
    remembering, forgetting = held(0.9)
    assert np.all((remembering > 0.90) & (remembering < 0.98))
    assert np.all(forgetting < 0.55)


def test_autoregression_of_known_coefficients():
    rng = np.random.default_rng(5)
    x = lfilter([0.5], [1.0, -1.2, 0.5], rng.normal(size=60_000))[1000:]
    a, variance = autoregression(x)
    assert a[:2] == pytest.approx([1.2, -0.5], abs=0.02)
    assert variance == pytest.approx(0.25, rel=0.02)
    # closed form of the variance of an AR(2) (Box and Jenkins)
    closed = 0.25 * (1 + 0.5) / ((1 - 0.5) * ((1 + 0.5) ** 2 - 1.2**2))
    found = autocovariance(np.array([1.2, -0.5]), 0.25, 50)
    assert found[0] == pytest.approx(closed, rel=1e-9)
    assert found[1] / found[0] == pytest.approx(1.2 / 1.5, rel=1e-9)


def test_white_residuals_have_no_memory():
    orders = [len(autoregression(np.random.default_rng(k).normal(size=500))[0]) for k in range(100)]
    assert np.mean(np.array(orders) == 0) > 0.9


def test_the_test_of_ljung_and_box_is_as_rare_as_it_says():
    rng = np.random.default_rng(2)
    p = [whiteness(r, r, np.ones(400), 0).p for r in rng.normal(size=(400, 400))]
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.03)
    smooth = np.sin(np.linspace(0, 20, 400))
    assert whiteness(smooth, smooth, np.ones(400), 0).p < 1e-12


def test_statistic_of_ljung_and_box_by_its_formula():
    r = np.random.default_rng(7).normal(size=50)
    rho = [np.sum(r[k:] * r[: 50 - k]) / np.sum(r * r) for k in range(1, 21)]
    Q = 50 * 52 * sum(x * x / (50 - k) for k, x in enumerate(rho, start=1))
    assert whiteness(r, r, np.ones(50), 0).Q == pytest.approx(Q, rel=1e-12)


def sentences(names, rows):
    """Return the sentences for values that depend on combinations, by their exponents."""
    units = {"k": "N/m", "m": "kg", "c": "N s/m", "a": "m", "b": "m"}
    values = {"a": 0.3, "b": -0.2}
    given = [jo.Parameter(n, values.get(n, 2.0 + 0.7 * i), unit=units[n[0]])
             for i, n in enumerate(names)]  # fmt: skip
    sought = unknowns(Problems(), given)
    u = np.array([own.u(own.start) for own in sought])
    weights = np.random.default_rng(0).normal(size=(30, len(rows)))
    sizes = np.array([own.size for own in sought])
    J = 1e4 * weights @ np.array([row(sought, u) for row in rows]) * sizes
    return [one.text for one in find_unseen(J, sought, u)[0]]


@pytest.mark.parametrize(
    ("names", "exponents", "sentence"),
    [
        (["k", "m"], [[1, -1]], "k and m may be multiplied by one number together: only k / m"),
        (["k", "m"], [[1, 1]], "k may grow as m shrinks: only k * m is seen"),
        (["k", "m"], [[1, 0]], "m has no influence"),
        (["k", "m", "c"], [[1, -1, 0], [0, -1, 1]], "k, m and c may be multiplied by one number"),
        (["k", "m"], [[1, -2]], "a number may multiply k by its power 2, m by its power 1"),
    ],
)
def test_products_of_powers_that_are_not_seen(names, exponents, sentence):
    rows = [lambda sought, u, e=e: np.array(e, dtype=float) for e in exponents]
    (found,) = sentences(names, rows)
    assert found.startswith(sentence)


def test_differences_that_are_not_seen():
    (found,) = sentences(["a", "b"], [lambda sought, u: np.array([1.0, -1.0])])
    assert found == "a and b may grow together: only a - b is seen"
