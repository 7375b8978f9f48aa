"""A cylinder on a plane: it stands, tips over, lies and rolls as in closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Contact, Cylinder, HalfSpace, PowerLaw

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")
G, K = 9.81, 1e7
RADIUS, LENGTH = 0.05, 0.2


def cylinder(
    height: float, tilt: float, gravity: Any, mu: float = 0.5, turn: float = 0.0, **more: Any
) -> Any:
    """A solid cylinder of 1 kg, its axis turned by `tilt` from the vertical, deg."""
    a, b = np.radians([tilt, turn]) / 2
    across = 0.25 * RADIUS**2 + LENGTH**2 / 12
    q = (
        np.cos(a) * np.cos(b),
        -np.sin(a) * np.sin(b),
        np.sin(a) * np.cos(b),
        np.cos(a) * np.sin(b),
    )
    body = jo.RigidBody(
        "c", 1.0, (across, across, 0.5 * RADIUS**2), position=(0, 0, height), orientation=q, **more
    )
    contact = Contact(
        "touch",
        jo.ground["origin"],
        HalfSpace(),
        body["origin"],
        Cylinder(RADIUS, LENGTH),
        PowerLaw(K, 1.0, restitution=0.3),
        mu_kinetic=mu,
    )
    sensors = (
        jo.PositionSensor("x", body["origin"]),
        jo.VelocitySensor("v", body["origin"]),
        jo.AngularVelocitySensor("w", body["origin"]),
    )
    return jo.compile(jo.Mechanism(body, contact, jo.Gravity(gravity), *sensors))


def test_it_stands_on_four_points_and_lies_on_two():
    for tilt, height, points in ((0.0, 0.5 * LENGTH, 4), (90.0, RADIUS, 2)):
        sunk = G / (points * K)
        run = jo.simulate(cylinder(height, tilt, (0, 0, -G)), 0.5, solver=jo.ROS2(1e-3))
        assert run["x"][-1, 2] == pytest.approx(height - sunk, abs=1e-10)
        assert np.abs(run["w"][-1]).max() < 1e-9


@pytest.mark.parametrize("turn", [0.0, 37.0])
@pytest.mark.parametrize(("slope", "falls"), [(26.0, False), (27.1, True)])
def test_it_tips_over_at_the_angle_of_its_corner(slope, falls, turn):
    """atan(2 r / l) = 26.565 deg, on a slope in any direction of its rim."""
    a = np.radians(slope)
    model = cylinder(0.5 * LENGTH, 0.0, (G * np.sin(a), 0, -G * np.cos(a)), mu=1.0, turn=turn)
    run = jo.simulate(model, 0.3, solver=jo.ROS2(5e-4))
    assert (np.abs(run["w"][-1]).max() > 0.02) == falls


def test_force_is_continuous_as_it_begins_to_tip():
    """Sum and moment of the forces over the tilt, through the tilt at which the rim turns."""
    tilts = np.concatenate([[0.0], np.logspace(-10, -2, 400)])
    model, forces = cylinder(0.5 * LENGTH - 1e-4, 0.0, (0, 0, 0), mu=0.0), []
    engine = jo.model.Engine(model)
    for tilt in tilts:
        engine.q[3:7] = (np.cos(tilt / 2), 0, np.sin(tilt / 2), 0)
        engine.accelerations()
        forces.append(engine.a[:6].real.copy())
    jumps = np.abs(np.diff(forces, axis=0))
    change = np.diff(tilts)[:, None] * K * np.array([1, 1, 4 * RADIUS, 400, 4e2, 1])
    assert (jumps < 4 * change + 1e-6).all()


def test_it_rolls_lying_and_leaning():
    """Lying it rolls on without slip; leaning it falls down and rests."""
    rolling = cylinder(
        RADIUS - G / (2 * K),
        90.0,
        (0, 0, -G),
        velocity=(0, 1, 0),
        angular_velocity=(-1 / RADIUS, 0, 0),
    )
    run = jo.simulate(rolling, 1.0, solver=jo.ROS2(1e-3))
    assert run["v"][-1, 1] == pytest.approx(1.0, rel=1e-3)
    assert run["x"][-1, 1] == pytest.approx(1.0, rel=1e-3)
    assert abs(run["x"][-1, 0]) < 1e-6
    tilt = np.radians(20)
    height = 0.5 * LENGTH * np.cos(tilt) + RADIUS * np.sin(tilt)
    run = jo.simulate(cylinder(height, 20.0, (0, 0, -G)), 3.0, solver=jo.ROS2(5e-4))
    assert run["x"][-1, 2] == pytest.approx(0.5 * LENGTH, abs=1e-5)
    assert np.abs(run["w"][-1]).max() < 1e-6
