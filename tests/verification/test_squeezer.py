"""Andrews' squeezer against the published solution at 0.03 s, see `squeezer`."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification import squeezer
from verification.mechanisms import march, orders


@pytest.fixture(scope="module")
def reference():
    """Angles and rates at 0.03 s by NumPy and SciPy alone, from the published data."""
    times = np.array([0.0, squeezer.T_END])
    q, v = squeezer.REFERENCE.run(squeezer.START, np.zeros(7), times, tolerance=1e-12)
    return q[-1], v[-1]


def test_the_published_start_closes_the_loops_and_accelerates_as_printed():
    assert np.abs(squeezer.close(squeezer.START)).max() < 1e-17
    a = squeezer.REFERENCE.accelerations(squeezer.START, np.zeros(7))
    np.testing.assert_allclose(a[:2], squeezer.START_ACCELERATION, rtol=1e-13)
    np.testing.assert_allclose(a[2:], 0.0, atol=1e-8)


@pytest.mark.slow
def test_the_data_give_the_published_solution(reference):
    q, v = reference
    # the published state is that of an index-3 solver: its bars part with 1e-9 m/s where they
    # meet, and its energy misses 2e-10 J of 0.5 J; that is what its last digits are worth
    np.testing.assert_allclose(q, squeezer.ANGLES, rtol=5e-10)
    np.testing.assert_allclose(v, squeezer.RATES, rtol=1e-7, atol=0)
    a = squeezer.REFERENCE.accelerations(q, v)
    np.testing.assert_allclose(a, squeezer.ACCELERATIONS, rtol=2e-6)


def power_balance(q, v):
    """Energy gained less the work of the motor, J."""
    length = squeezer.spring(q) - squeezer.FREE, squeezer.spring(squeezer.START) - squeezer.FREE
    stored = 0.5 * squeezer.STIFFNESS * (length[0] ** 2 - length[1] ** 2)
    return squeezer.REFERENCE.energy(q, v) + stored - squeezer.TORQUE * (q[0] - squeezer.START[0])


@pytest.mark.slow
def test_energy_says_which_of_the_two_is_closer(reference):
    assert abs(power_balance(*reference)) < 1e-11
    assert abs(power_balance(squeezer.ANGLES, squeezer.RATES)) > 1e-10


# nine rows are repeated where all ten joints are revolute
@pytest.fixture(scope="module", params=[False, True], ids=["41 rows", "50 rows"])
def model(request):
    if not request.param:
        return jo.compile(squeezer.mechanism(repeated=False))
    with pytest.warns(jo.JoustoWarning, match="9 of the constraint rows"):
        return jo.compile(squeezer.mechanism(repeated=True))


def relative(run):
    """Angles and rates as in the published coordinates."""
    turns = np.concatenate([run.sensors[f"{bar} pivot angle"][-1] for bar in squeezer.BARS])
    # K2 turns against K1, K4 against K5, K6 against K7, the others against the ground
    angles = squeezer.START + turns
    w = np.array([run.sensors[f"{bar} rate"][-1, 2] for bar in squeezer.BARS])
    for k, base in ((1, 0), (3, 4), (5, 6)):
        w[k] -= w[base]
    return angles, w


def test_jousto_ends_in_the_published_state(model):
    run = march(model, jo.RK4(step=2e-6), squeezer.T_END)
    angles, rates = relative(run)
    # what the last published digits are worth: see the reference above
    np.testing.assert_allclose(angles, squeezer.ANGLES, rtol=5e-10)
    np.testing.assert_allclose(rates, squeezer.RATES, rtol=1e-7)
    reactions = np.array([run.sensors[f"K2-{k}"][-1, :2] for k in squeezer.LOOPS])
    np.testing.assert_allclose(reactions, squeezer.REACTIONS, rtol=2e-6)
    assert np.abs(run.balance).max() < 1e-12  # J, of 0.5 J
    # trees leave gaps below 1e-14 of the size, rates below 1e-14 of the speed on an arm as long
    fastest = model.size * np.abs(rates).max()
    assert np.all(run.residuals < (1e-14, 1e-14 * fastest))


def test_jousto_finds_its_own_steps_to_the_published_angles(model):
    run = jo.simulate(
        model, squeezer.T_END, solver=jo.simulation.DormandPrince(tolerance=1e-10, output=1e-3)
    )
    turns = np.array([run[f"{bar} pivot angle"][-1, 0] for bar in squeezer.BARS])
    # 1.4e-9 rad is the error of the published crank angle
    np.testing.assert_allclose(squeezer.START + turns, squeezer.ANGLES, rtol=0, atol=3e-9)


@pytest.mark.slow
def test_jousto_agrees_with_the_reference_beyond_the_published_digits(model, reference):
    run = march(model, jo.RK4(step=5e-7), squeezer.T_END)
    angles, rates = relative(run)
    np.testing.assert_allclose(angles, reference[0], rtol=5e-11)
    np.testing.assert_allclose(rates, reference[1], rtol=5e-10)


@pytest.mark.parametrize(
    ("method", "steps"),
    [(jo.RK4, (300, 600)), (jo.ROS2, (3000, 6000)), (jo.GeneralizedAlpha, (1500, 3000))],
    ids=["RK4", "ROS2", "GeneralizedAlpha"],
)
def test_jousto_converges_to_the_published_angles(model, method, steps):
    errors = []
    for n in steps:
        angles, _ = relative(march(model, method(step=squeezer.T_END / n), squeezer.T_END))
        errors.append(float(np.abs(angles - squeezer.ANGLES).max()))
    # RK4 falls with the fifth order until it meets the last published digits
    assert orders(errors)[-1] > method.order - 0.2, (errors, orders(errors))
