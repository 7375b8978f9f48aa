"""Contacts in the matrix of ROS2, in both cores: exact steps, order, rest in any step."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import Contact, Cuboid, HalfSpace, PowerLaw, Sphere, SpringDamper
from jousto.simulation import State

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
CORES = ("joint", "maximal")


def point(law: Any, core: str, mu: float = 50.0, arm: Any = (0, 0, 0), inertia: Any = 1e12) -> Any:
    """A point of a body of 1 kg that rests on the floor and is pulled sideways by 1 m/s2."""
    sunk = (G / law.stiffness) ** (1 / getattr(law, "exponent", 1.0))
    at = -np.array(arm) - (0, 0, sunk)
    body = jo.RigidBody("p", 1.0, np.broadcast_to(inertia, 3), position=at)
    place = body.at(arm)
    contact = Contact("c", jo.ground["origin"], HalfSpace(), place, Sphere(0.0), law, mu_kinetic=mu)
    sensors = (
        jo.PositionSensor("x", place),
        jo.VelocitySensor("v", place),
        jo.mechanism.ForceStateSensor("phase", contact, "phase"),
        jo.mechanism.ForceStateSensor("s", contact, "stretch x"),
    )
    gravity = jo.Gravity((1.0, 0.5, -G))
    return jo.compile(jo.Mechanism(body, contact, gravity, *sensors), core=core)


def long_closed(model: Any) -> State:
    """The initial state with contacts that have lasted long, so that nothing shortens a step."""
    states = np.array(jo.model.Engine(model).states)
    states[2::6] = -1e6
    return State(model.q0, model.v0, np.zeros(model.nrow), states=states)


def ros2(A: Any, y: Any, h: float, b: Any) -> Any:
    """ROS2 of ``y' = A y + b`` (Hairer, Wanner, Solving ODEs II, IV.7)."""
    g = 1 - 1 / np.sqrt(2)
    W = np.linalg.inv(np.eye(len(y)) - g * h * A)
    k1 = W @ (A @ y + b)
    k2 = W @ (A @ (y + h * k1) + b - 2 * g * h * A @ k1)
    return y + h / 2 * (k1 + k2)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("step", [1e-3, 1e-2, 1.0])
def test_a_step_is_that_of_the_method_with_the_exact_matrix(core, step):
    """Spring and damper along z, across a bristle with its own state: linear, to h w = 1000."""
    k, c = 1e6, 50.0
    model = point(SpringDamper(k, c), core)
    run = jo.simulate(model, 8 * step, solver=jo.ROS2(step), state=long_closed(model))
    A = np.zeros((8, 8))  # x, v, s
    A[0:3, 3:6], A[6:8, 3:5] = np.eye(3), np.eye(2)
    A[3, 6] = A[4, 7] = -2 * 0.7 / 1.7 * k
    A[5, 2], A[5, 5] = -k, -c
    b = np.zeros(8)
    b[3:6] = 1.0, 0.5, -G
    y = np.zeros(8)
    y[2] = -G / k
    for i in range(9):
        assert np.abs(run["v"][i] - y[3:6]).max() < 1e-13
        assert np.abs(run["x"][i] - y[:3]).max() < 1e-16
        assert abs(run["s"][i, 0] - y[6]) < 1e-16
        y = ros2(A, y, step, b)


@pytest.mark.parametrize("core", CORES)
def test_order_is_two(core):
    """A body that sways and bounces a little on a point that sticks: closed all the time."""
    law = PowerLaw(1e7, 1.5, restitution=0.9)
    model = point(law, core, arm=(0.1, 0.05, -0.2), inertia=(0.3, 0.4, 0.5))

    def end(solver: Any) -> Any:
        run = jo.simulate(model, 0.01, solver=solver, state=long_closed(model))
        assert (run["phase"] == 1).all()
        return run["x"][-1]

    exact = end(jo.RK4(2e-6))
    errors = [np.abs(end(jo.ROS2(h)) - exact).max() for h in (4e-5, 2e-5, 1e-5)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(2.0, abs=0.1)


def ramp(angle: float, speed: float, solver: Any, t: float, core: str, blocks: int = 1) -> Any:
    """Blocks of 1 kg on a ramp with mu 0.4 and 0.3, x up the ramp."""
    turn, K, items = np.radians(angle), 1e7, []
    sunk = G * np.cos(turn) / (4 * K)
    for i in range(blocks):
        body = jo.RigidBody(
            f"b{i}", 1.0, (0.01, 0.012, 0.015), position=(0, i, 0.05 - sunk), velocity=(speed, 0, 0)
        )
        contact = Contact(
            f"c{i}", jo.ground["origin"], HalfSpace(), body["origin"], Cuboid((0.4, 0.4, 0.1)),
            PowerLaw(K, 1.0), mu_kinetic=0.3, mu_static=0.4,
        )  # fmt: skip
        items += [body, contact, jo.PositionSensor(f"x{i}", body["origin"])]
        items += [jo.VelocitySensor(f"v{i}", body["origin"])]
    gravity = jo.Gravity((-G * np.sin(turn), 0, -G * np.cos(turn)))
    model = jo.compile(jo.Mechanism(*items, gravity), core=core)
    return jo.simulate(model, t, solver=solver)


@pytest.mark.parametrize("core", CORES)
def test_rest_takes_one_step_and_does_not_creep(core):
    """On 15 degrees with steps of 10 ms: 100 s in as many steps, and not a micrometre."""
    run = ramp(15.0, 0.0, jo.ROS2(1e-2), 100.0, core)
    late = run.time > 1.0
    assert np.ptp(run["x0"][late, 0]) < 1e-12
    assert np.abs(run["v0"][-1]).max() < 1e-12
    assert run.work.steps[-1] - run.work.steps[np.argmax(late)] == late.sum() - 1


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("step", [1e-2, 1e-3])
def test_block_is_thrown_up_a_ramp(core, step):
    """It stops after 0.836 m in closed form and stays; energy is kept."""
    run = ramp(15.0, 3.0, jo.ROS2(step), 1.0, core)
    assert run["x0"][:, 0].max() == pytest.approx(0.8361616440, abs=2e-6)
    assert np.abs(run["v0"][-1]).max() < 1e-12
    assert np.abs(run.energy.error).max() < 2e-5 * 4.5


def test_many_contacts_run_in_the_positions_of_the_bodies():
    """More contacts than joint coordinates take: each of the blocks moves as if it were alone."""
    one = ramp(15.0, 3.0, jo.ROS2(5e-3), 0.5, "joint")
    many = ramp(15.0, 3.0, jo.ROS2(5e-3), 0.5, "joint", blocks=4)
    for i in range(4):
        assert many[f"x{i}"][-1, 0] == pytest.approx(one["x0"][-1, 0], abs=1e-6)


def test_shot_through_a_thin_plate():
    """100 m/s at a free plate of 2 mm with steps of 1 ms: in them nothing is missed."""
    shot = jo.RigidBody("s", 0.01, (1e-7,) * 3, position=(-0.237, 0, 0), velocity=(100, 0, 0))
    plate = jo.RigidBody("p", 1.0, (0.1,) * 3)
    contact = Contact(
        "c", plate["origin"], Cuboid((2e-3, 1, 1)), shot["origin"], Sphere(5e-3),
        PowerLaw(1e9, restitution=0.6),
    )  # fmt: skip
    sensors = (jo.VelocitySensor("v", shot["origin"]), jo.VelocitySensor("V", plate["origin"]))
    touched = jo.mechanism.ForceStateSensor("since", contact, "since")
    model = jo.compile(jo.Mechanism(shot, plate, contact, touched, *sensors))
    run = jo.simulate(model, 0.01, solver=jo.ROS2(1e-3))
    assert run["since"][-1, 0] == pytest.approx(2.31e-3, rel=1e-9)
    assert run["v"][-1, 0] == pytest.approx(-58.4158415842, rel=1e-3)
    assert 0.01 * run["v"][-1, 0] + run["V"][-1, 0] == pytest.approx(1.0, rel=1e-13)
