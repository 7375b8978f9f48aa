"""Friction of pins of any radius: the scale of the slip belongs to the joint."""

from __future__ import annotations

from typing import Any

import pytest

import jousto as jo
from jousto.mechanism import Regularised, StickSlip

I, T, RATE, MU = 0.02, 0.1, 5.0, 0.2  # kg m2, N m, rad/s


def wheel(radius: float, law: Any = None, push: float = 0.0) -> jo.Mechanism:
    """A wheel that turns against a friction torque T by a preload of its axle."""
    body = jo.RigidBody(
        "wheel", 3.0, (0.01, 0.01, I), angular_velocity=(0, 0, 0.0 if push else RATE)
    )
    axle = jo.Revolute("axle", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    preload = T / (MU * radius)
    rubs = jo.Friction("rubs", axle, MU, radius=radius, preload=preload, law=law or StickSlip())
    angle, rate = jo.CoordinateSensor("q", axle.angle), jo.RateSensor("w", axle.angle)
    torque = [jo.JointForce("push", axle.angle, jo.Constant(push))] if push else []
    return jo.Mechanism(body, axle, rubs, angle, rate, *torque)


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("radius", [1e-1, 1e-5, 1e-9, 1e-13])
def test_a_torque_stops_a_wheel_whatever_the_radius(radius, core):
    """It stops after I w^2 / 2 T, and stays."""
    model = jo.compile(wheel(radius), core=core)
    run = jo.simulate(model, 1.5, solver=jo.RK4(1e-3))
    assert run["q"][-1, 0] == pytest.approx(I * RATE**2 / (2 * T), rel=1e-9)
    assert abs(run["w"][-1, 0]) < 1e-15


@pytest.mark.parametrize("radius", [1e-2, 1e-9])
def test_it_sticks_up_to_its_torque(radius):
    for share, moves in ((0.999, False), (1.5, True)):
        run = jo.simulate(jo.compile(wheel(radius, push=share * T)), 0.5, solver=jo.ROS2(1e-3))
        angle = 0.5 * (share - 1) * T / I * 0.5**2 if moves else 0.0
        assert run["q"][-1, 0] == pytest.approx(angle, rel=1e-6, abs=1e-14)


def test_smooth_friction_of_a_thin_pin_is_warned_of():
    with pytest.warns(jo.JoustoWarning, match="full friction above 1e\\+06 rad/s at a pin radius"):
        wheel(1e-9, Regularised())
    wheel(1e-9, Regularised(1e-12))
