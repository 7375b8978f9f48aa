"""Spin-up of a flexible beam, see `spin_up`."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification import spin_up
from verification.spin_up import STRETCH, L, beam, links, seen, turn

FINE = jo.ROS2(step=2e-3)


def spun(pieces, modes, speed=spin_up.SPEED, **options):
    """Run and tip (nt, 2) along the root's axes."""
    model = jo.compile(beam(pieces, modes, speed=speed, **options))
    run = jo.simulate(model, 20.0, solver=FINE, output_step=0.02)
    return run, seen(run["tip"], turn(run.time, speed)[0])


@pytest.fixture(scope="module")
def one():
    return spun(1, 8)


@pytest.fixture(scope="module")
def four():
    return spun(4, 3)


def test_the_signal_is_the_published_turn():
    times = np.linspace(0.0, 20.0, 401)
    angle, rate, acceleration = turn(times)
    found = spin_up.signal()
    assert angle[-1] == pytest.approx(6 * 20 - 45)
    assert found.jumps == ()
    np.testing.assert_allclose(found(times), angle, atol=1e-12)
    np.testing.assert_allclose(found.rate(times), rate, atol=1e-12)
    np.testing.assert_allclose(found.acceleration(times), acceleration, atol=1e-12)


def test_in_the_end_the_beam_is_stretched_as_in_closed_form(four):
    run, u = four
    late = u[run.time > 17]
    assert abs(STRETCH - 5.14e-4) < 5e-7
    assert np.mean(late[:, 0]) == pytest.approx(STRETCH, rel=1e-3)
    assert np.ptp(late[:, 1]) < 0.008  # it still swings a little, as the reference does


def test_one_body_with_stiffening_bends_like_four(one, four):
    t = one[0].time
    stretch = STRETCH * (turn(t)[1] / spin_up.SPEED) ** 2  # one body has no mode for it
    bend = np.abs(one[1] - four[1] + np.outer(stretch, [1, 0])).max(axis=0)
    assert bend[0] < 1e-4
    assert bend[1] < 5e-4
    assert one[1][:, 1].min() < -0.57


@pytest.mark.slow
def test_jousto_bends_like_a_chain_of_rigid_links(one, four):
    t = one[0].time
    coarse, fine = (links(n, t) for n in (10, 20))
    exact = fine + (fine - coarse) / 3
    lowest = exact[:, 1].min()
    assert lowest == pytest.approx(-0.5738, abs=2e-4)
    assert t[np.argmin(exact[:, 1])] == pytest.approx(6.76, abs=0.05)
    for _, u in (one, four):
        assert u[:, 1].min() == pytest.approx(lowest, rel=1e-3)
        assert np.abs(u - exact)[t < 10].max() < 6e-4
        assert np.abs(u - exact).max() < 1.5e-3  # the links' swing lags after 10 s


def test_without_stiffening_it_bends_too_far_and_says_so(one):
    with pytest.warns(
        jo.JoustoWarning,
        match=r"body 'piece 1' spins with up to 6 rad/s, 2\d % of "
        r"its lowest natural frequency of 3\.\d+ Hz.*stiffening=True",
    ):
        _, u = spun(1, 8, stiffening=False)
    assert u[:, 1].min() < 1.15 * one[1][:, 1].min()


def test_at_twice_the_speed_it_diverges_without_and_not_with_stiffening():
    with (
        pytest.warns(jo.JoustoWarning, match="finally diverges"),
        pytest.warns(jo.JoustoWarning, match="bends by .* rad within itself"),
    ):
        _, wild = spun(1, 8, speed=12.0, stiffening=False)
    assert np.abs(wild).max() > 2 * L
    run, tame = spun(1, 8, speed=12.0)
    reference = links(8, run.time[:401], 12.0)
    assert tame[:, 1].min() == pytest.approx(reference[:, 1].min(), rel=0.05)
    assert np.ptp(tame[run.time > 17, 1]) < 0.02
