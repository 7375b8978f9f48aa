"""What a reading loses: closed forms of sines, and the rainflow damage of a smaller stress."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from jousto.design import reading_loss
from jousto.design.flexibility.hot_spot_readings import SlopeRule, damage_ratio

T = np.linspace(0.0, 2.0, 4001)


def test_smaller_reading() -> None:
    y = 3.0 * np.sin(7.0 * T)
    loss = reading_loss(T, y, 0.92 * y)
    assert loss.difference == pytest.approx(0.08 * np.abs(y).max(), rel=1e-12)
    assert loss.error == pytest.approx(loss.difference / np.ptp(y), rel=1e-12)
    assert loss.peak == pytest.approx(-0.08, rel=1e-12)
    assert (loss.lag, loss.shifted, loss.absolute) == (0.0, loss.error, False)


def test_lag_alone_is_a_large_error_with_equal_peaks() -> None:
    # |sin(w (t - s)) - sin(w t)| is 2 sin(w s / 2) at most, the range 2
    w, late = 9.0, 0.013
    loss = reading_loss(T, np.sin(w * T), np.sin(w * (T - late)))
    assert loss.error == pytest.approx(np.sin(0.5 * w * late), rel=1e-4)
    assert loss.peak == pytest.approx(0.0, abs=1e-6)
    assert loss.lag == pytest.approx(late, abs=1e-4)
    assert loss.shifted < 1e-3 * loss.error
    early = reading_loss(T, np.sin(w * T), np.sin(w * (T + late)))
    assert early.lag == pytest.approx(-late, abs=1e-4)


def test_reading_without_range_is_absolute() -> None:
    y = np.full_like(T, 5.0)
    loss = reading_loss(T, y, y + 0.25, floor=1e-9)
    assert loss.absolute
    assert (loss.error, loss.difference, loss.range) == (0.25, 0.25, 0.0)
    assert loss.peak == pytest.approx(0.05)
    assert loss.share == pytest.approx(0.05)
    zero = reading_loss(T, 0.0 * T, 0.0 * T)
    assert (zero.error, zero.peak, zero.share) == (0.0, 0.0, 0.0)
    assert reading_loss(T, 0.0 * T, 0.0 * T + 1e-3).share == np.inf


def test_wrong_arrays() -> None:
    with pytest.raises(jo.InputError, match="full has shape"):
        reading_loss(T, T[:5], T)
    with pytest.raises(jo.InputError, match="ascending"):
        reading_loss(T[::-1], T, T)


def test_damage_of_a_smaller_stress() -> None:
    # Basquin: damage is in proportion to the amplitude to the power m
    y = 1e8 * np.sin(7.0 * T) * (1.0 + 0.3 * np.cos(3.0 * T))
    rule = SlopeRule(5.0)
    assert damage_ratio(rule(0.92 * y), rule(y)) == pytest.approx(0.92**5, rel=1e-9)
    assert 0.92**5 == pytest.approx(0.659, abs=5e-4)
    assert damage_ratio(0.0, 0.0) == 1.0
    assert damage_ratio(1.0, 0.0) == np.inf
