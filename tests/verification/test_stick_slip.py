"""Stick and slip located in time: the belt and the pin to the printed digits, at full order."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.friction import Belt, PinPendulum
from verification.test_friction import block_on_a_belt, pendulum, swinging

RK4, ROS2 = "rk4", "ros2"
STICKS = 0


def transitions(model, t_end, method, step):
    """Return time and new slip (k, 2) of all transitions."""
    engine = jo.model.Engine(model)
    steps = round(t_end / step)
    rows = np.zeros((steps, engine.row_size))
    status, _ = engine.run(engine.native_solver(method, step, True), steps, 1, rows)
    assert status == "ok"
    return engine.happenings()[:, [0, 2]], rows


@pytest.mark.parametrize(("method", "step"), [(RK4, 2e-3), (ROS2, 1e-4)])
def test_the_belt_slips_and_sticks_when_the_closed_form_says(method, step):
    found, _ = transitions(block_on_a_belt(jo.mechanism.StickSlip()), 1.7, method, step)
    belt = Belt()
    np.testing.assert_array_equal(found[:, 1], [-1, STICKS, -1, STICKS])
    lengths = np.diff(found[:, 0], prepend=0.0)
    np.testing.assert_allclose(lengths, [belt.stick_time, belt.slip_time] * 2, rtol=0, atol=1e-8)
    np.testing.assert_allclose(lengths[:2], [0.39240000, 0.40843222], rtol=0, atol=1.4e-8)


def test_the_pin_turns_when_the_reference_says():
    found, _ = transitions(pendulum(jo.mechanism.StickSlip()), 5.0, RK4, 5e-3)
    exact = np.array(PinPendulum().turning_points(np.pi / 2, 4))
    np.testing.assert_allclose(found[:, 0], exact[:, 0], rtol=0.0, atol=3e-8)
    assert found[0, 0] == pytest.approx(1.172721, abs=5e-7)
    np.testing.assert_array_equal(found[:, 1], [1, -1, 1, -1])  # it turns, it does not stick


def test_the_angle_of_the_first_turn_is_that_of_the_reference():
    run = jo.simulate(pendulum(jo.mechanism.StickSlip()), 1.172721, solver=jo.RK4(1e-3))
    angle = np.degrees(run["angle"].ravel()[-1]) + 90.0  # 0 where it hangs
    assert angle == pytest.approx(-85.069927, abs=5e-7)


@pytest.mark.parametrize(("method", "order"), [(RK4, 4), (ROS2, 2)])
def test_transitions_keep_the_order_of_the_method(method, order):
    belt = Belt()
    errors = []
    for step in (0.02, 0.005):
        found, _ = transitions(block_on_a_belt(jo.mechanism.StickSlip()), 0.9, method, step)
        errors.append(abs(found[1, 0] - belt.stick_time - belt.slip_time))
    assert np.log(errors[0] / errors[1]) / np.log(4.0) > order - 0.5


def test_energy_closes_over_many_transitions_in_space():
    run = jo.simulate(swinging(jo.mechanism.StickSlip()), 0.4, solver=jo.RK4(1e-4))
    assert np.abs(run.energy.error).max() < 1e-5 * run.energy.friction[-1]
