"""The friction references give the numbers that friction laws are to meet, see `friction`."""

from __future__ import annotations

import numpy as np
import pytest

from verification.friction import GRAVITY, Belt, PinPendulum


def test_belt():
    # closed form for m = 1 kg, k = 100 N/m, mu_s = 0.4, mu_k = 0.2, 0.1 m/s, printed to 8 digits
    belt = Belt()
    assert abs(belt.stick_time - 0.39240000) < 5e-9
    assert abs(belt.slip_time - 0.40843222) < 5e-9
    assert abs(belt.stick_time + belt.slip_time - 0.80083222) < 5e-9
    np.testing.assert_allclose(belt.extremes, (-0.002401, 0.041641), atol=5e-7)


def test_pin_pendulum_turns_as_printed_and_stops():
    turns = PinPendulum().turning_points(np.pi / 2, 100)
    t, angle = turns[0]
    assert abs(t - 1.172721) < 5e-7
    assert abs(np.degrees(angle) + 85.069927) < 5e-7
    # it loses height at every swing and ends inside the cone of friction
    heights = np.cos([angle for _, angle in turns])
    assert np.all(np.diff(heights) > 0)
    assert len(turns) < 100
    assert abs(np.sin(turns[-1][1])) <= 0.3 * 0.05


@pytest.mark.parametrize("w", [0.0, 1.0, -3.0])
def test_pin_pendulum_meets_its_own_equation(w):
    # m l^2 w' = -m g l sin th - mu r N sgn(w), with N from w and w'
    pin = PinPendulum(mass=1.3, length=0.8, radius=0.06, friction=0.35)
    th, way = 0.7, -1.0
    a = pin.acceleration(th, w, way)
    along = pin.mass * (pin.length * w**2 + GRAVITY * np.cos(th))
    across = pin.mass * (pin.length * a + GRAVITY * np.sin(th))
    moment = -pin.mass * GRAVITY * pin.length * np.sin(th)
    moment -= way * pin.friction * pin.radius * np.hypot(along, across)
    np.testing.assert_allclose(pin.mass * pin.length**2 * a, moment, rtol=1e-14)
