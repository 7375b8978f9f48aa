"""Discs that roll, slip, leave a plane and land on it: closed forms, events, both cores, files."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.base.rotations import rotation_matrix
from jousto.mechanism import DiscOnPlane, Regularised, RollingDisc, StickSlip
from jousto.schema.read import parse_model
from model.test_newton import assert_exact

R, M, G = 0.1, 1.0, 9.81
pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


def disc(share: float = 0.5, **more: Any) -> jo.RigidBody:
    """A round body whose axle is y, with the inertia share M R^2 about it."""
    J = share * M * R * R
    more = {"position": (0, 0, R), **more}
    return jo.RigidBody("disc", M, (0.6 * J, J, 0.6 * J), **more)


def rolling(
    body: Any, mu: float = 0.2, *, law: Any = None, pull: Any = (0, 0, -G), **more: Any
) -> jo.Model:
    touch = DiscOnPlane("touch", jo.ground["origin"], body["origin"], R, axle=(0, 1, 0), **more)
    grip = jo.Friction("grip", touch, mu, law=law or StickSlip())
    sensors = (
        jo.PositionSensor("p", body["origin"]),
        jo.VelocitySensor("v", body["origin"]),
        jo.AngularVelocitySensor("w", body["origin"]),
        jo.ReactionSensor("N", touch),
    )
    return jo.compile(jo.Mechanism(body, touch, grip, *sensors, jo.Gravity(pull)))


SOLVERS = [
    jo.RK4(1e-3),
    jo.ROS2(1e-3),
    jo.GeneralizedAlpha(1e-3),
    jo.simulation.DormandPrince(tolerance=1e-9),
]


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
@pytest.mark.parametrize(
    ("share", "spin", "when", "speed"),
    [
        (0.5, 0.0, 0.5096839959, 2.0),
        (0.4, 0.0, 0.4368719965, 15 / 7),
        (0.4, -80.0, 1.601863987, -1 / 7),
    ],
    ids=["disc", "ball", "ball with spin back"],
)
def test_slip_ends_in_rolling(solver, share, spin, when, speed):
    """3 m/s, mu 0.2: v decreases by mu g, the spin grows, then both agree."""
    body = disc(share, velocity=(3, 0, 0), angular_velocity=(0, spin, 0))
    run = jo.simulate(rolling(body), 1.8, solver=solver, output_step=1e-3)
    (roll,) = [event for event in run.events if event.name == "grip"]
    assert roll.time == pytest.approx(when, abs=1e-8)
    assert run["v"][-1, 0] == pytest.approx(speed, abs=1e-8)
    assert run["w"][-1, 1] * R == pytest.approx(speed, abs=1e-8)
    if share == 0.4 and not spin:
        at = np.interp(when, run.time, run["p"][:, 0])
        assert at == pytest.approx(1.123385134, abs=2e-6)
    assert np.abs(run.energy.error).max() < 1e-6


@pytest.mark.parametrize("law", [StickSlip(), Regularised(1e-3)], ids=lambda law: law.tag)
def test_a_disc_on_a_slope_rolls_up_to_three_times_mu(law):
    """tan = 3 mu is the limit of a disc: a = 2/3 g sin, above it g (sin - mu cos)."""
    for degrees in (25.0, 40.0):
        a = np.radians(degrees)
        pull = (G * np.sin(a), 0, -G * np.cos(a))
        run = jo.simulate(rolling(disc(), pull=pull, law=law), 0.5, solver=jo.RK4(2e-4))
        rolls = np.tan(a) < 0.6
        rate = 2 / 3 * G * np.sin(a) if rolls else G * (np.sin(a) - 0.2 * np.cos(a))
        assert run["v"][-1, 0] == pytest.approx(0.5 * rate, rel=1e-6 if law.sticks else 2e-3)
        slip = run["v"][-1, 0] - run["w"][-1, 1] * R
        assert (abs(slip) < 2e-3) == rolls


def test_a_motor_spins_the_wheel_and_lets_it_roll_again():
    """Torque beyond mu N R (1 + 1/share) slips from its first instant; without it the slip ends."""
    body = disc()
    touch = DiscOnPlane("touch", jo.ground["origin"], body["origin"], R, axle=(0, 1, 0))
    grip = jo.Friction("grip", touch, 0.2, law=StickSlip())
    torque = jo.Torque(
        "torque", body["origin"], (0, 1.0, 0), signal=jo.Step(0.1, after=0, before=1)
    )
    v = jo.VelocitySensor("v", body["origin"])
    w = jo.AngularVelocitySensor("w", body["origin"])
    model = jo.compile(jo.Mechanism(body, touch, grip, torque, v, w, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.5, solver=jo.RK4(5e-4))
    names = [(event.name, event.change) for event in run.events]
    assert ("grip", "sticks") in names
    # mu g t forward; the spin grows by (1 - mu m g R) / J
    k = np.abs(run.time - 0.09).argmin()
    J = 0.5 * M * R * R
    assert run["v"][k, 0] == pytest.approx(0.2 * G * 0.09, rel=1e-6)
    assert run["w"][k, 1] == pytest.approx((1.0 - 0.2 * M * G * R) / J * 0.09, rel=1e-6)
    assert run["v"][-1, 0] == pytest.approx(run["w"][-1, 1] * R, abs=1e-9)


def test_a_thrown_disc_lands_slips_and_rolls():
    """From 0.3 m with restitution 0.5: parabolas, sliding between them, rolling in the end."""
    body = disc(position=(0, 0, R + 0.3), velocity=(2, 0, 0))
    run = jo.simulate(rolling(body, restitution=0.5), 3.0, solver=jo.RK4(1e-3))
    landings = [event.time for event in run.events if event.name == "touch"]
    first, e = np.sqrt(2 * 0.3 / G), 0.5
    assert landings[0] == pytest.approx(first, abs=1e-9)
    assert landings[1] == pytest.approx(first * (1 + 2 * e), abs=1e-9)
    assert landings[2] == pytest.approx(first * (1 + 2 * e + 2 * e * e), abs=1e-9)
    # friction has no impulse: the horizontal speed changes on the ground only
    assert run["v"][run.time < first * (1 + 2 * e), 0] == pytest.approx(2.0, abs=1e-12)
    # angular momentum about the contact: v = 2/3 of the first
    assert run["v"][-1, 0] == pytest.approx(2 * 2 / 3, abs=1e-9)
    assert run["w"][-1, 1] * R == pytest.approx(2 * 2 / 3, abs=1e-9)
    assert run["N"][-1, 0] == pytest.approx(M * G, abs=1e-9)
    assert np.abs(run.energy.error).max() < 1e-9


def test_a_rolling_disc_leaves_the_plane_and_comes_back():
    """A lift stronger than the weight for 0.2 s: flight, a landing, and it rolls on."""
    body = disc(velocity=(1, 0, 0), angular_velocity=(0, 1 / R, 0))
    touch = DiscOnPlane("touch", jo.ground["origin"], body["origin"], R, axle=(0, 1, 0))
    grip = jo.Friction("grip", touch, 0.3, law=StickSlip())
    pulse = jo.Table([0, 0.1, 0.1001, 0.3, 0.3001], [0, 0, 1, 1, 0])
    lift = jo.Force("lift", body["origin"], (0, 0, 1.5 * G), signal=pulse)
    sensors = (jo.PositionSensor("p", body["origin"]), jo.VelocitySensor("v", body["origin"]))
    model = jo.compile(jo.Mechanism(body, touch, grip, lift, *sensors, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 1.0, solver=jo.RK4(1e-3))
    changes = [event.change for event in run.events if event.name == "touch"]
    assert "opens" in changes and changes[-1] == "closes"
    top = run["p"][:, 2].max()
    assert top - R == pytest.approx(0.5 * 0.5 * G * 0.2**2 * 1.5, rel=2e-2)
    np.testing.assert_allclose(run["p"][-1], (1.0, 0, R), atol=1e-9)
    np.testing.assert_allclose(run["v"][:, 0], 1.0, atol=1e-9)


def test_while_it_rolls_it_is_the_rolling_disc():
    """A coin that leans and turns: the same motion as with the rows that never end."""
    found = []
    for kind in (RollingDisc, DiscOnPlane):
        axle = np.array([0, np.sin(np.radians(70.0)), np.cos(np.radians(70.0))])
        low = -R * (np.array([0, 0, 1.0]) - axle[2] * axle) / np.sin(np.radians(70.0))
        w = 15.0 * axle + np.array([0, 0, 0.5])
        J = M * R * R
        body = jo.RigidBody(
            *("coin", M, (J / 4, J / 2, J / 4)), position=(0, 0, -low[2]),
            velocity=-np.cross(w, low), angular_velocity=w,
        )  # fmt: skip
        touch: Any = kind("touch", jo.ground["origin"], body["origin"], R, axle=axle)
        more = () if kind is RollingDisc else (jo.Friction("g", touch, 0.8, law=StickSlip()),)
        p = jo.PositionSensor("p", body["origin"])
        model = jo.compile(jo.Mechanism(body, touch, *more, p, jo.Gravity((0, 0, -G))))
        # later it would slip
        found.append(jo.simulate(model, 0.3, solver=jo.RK4(5e-4))["p"])
    np.testing.assert_allclose(found[0], found[1], atol=1e-8)
    assert np.ptp(found[0], axis=0).max() > 0.2


@pytest.mark.parametrize("law", [StickSlip(), Regularised(1e-2)], ids=lambda law: law.tag)
def test_tangent_is_the_derivative(law):
    """Newton's matrix against complex steps while the disc leans, turns and slips."""
    rng = np.random.default_rng(8)
    body = disc(orientation=jo.Rotate((1, 0.2, 0), degrees=25.0))
    axle = np.array([0.1, np.cos(np.radians(20)), np.sin(np.radians(20))])
    touch = DiscOnPlane("touch", jo.ground["origin"], body["origin"], R, axle=axle)
    grip = jo.Friction("grip", touch, 0.2, 0.3, law=law, preload=2.0)
    model = jo.compile(jo.Mechanism(body, touch, grip, jo.Gravity((1, 2, -G))))
    engine = jo.model.Engine(model)
    engine.v[:] += rng.normal(size=6)
    engine.locked[0] = 1
    if law.sticks:
        n, k = axle / np.linalg.norm(axle), np.array([0, 0, 1.0])
        sine = np.linalg.norm(np.cross(k, n))
        A = rotation_matrix(engine.q[3:7])
        low = engine.v[:3] + np.cross(A @ engine.v[3:6], R * (n[2] * n - k) / sine)
        slip = np.array([low @ np.cross(n, k), low @ (n - n[2] * k)])
        engine.slip[0], engine.direction[:2] = 1, slip / np.linalg.norm(slip)
    engine.accelerations()
    assert_exact(engine)


def test_cores_and_bad_input():
    model = rolling(disc())
    assert not model.tree  # maximal coordinates
    with pytest.raises(InputError, match="limits no coordinate of a link"):
        jo.compile(jo.Mechanism(*_items(disc()), core="joint"))
    body = disc(position=(0, 0, 0.5 * R))
    with pytest.raises(InputError, match="below the plane"):
        DiscOnPlane("t", jo.ground["origin"], body["origin"], R, axle=(0, 1, 0))
    with pytest.raises(InputError, match="normal to the plane"):
        DiscOnPlane("t", jo.ground["origin"], disc()["origin"], R)
    touch = DiscOnPlane("t", jo.ground["origin"], disc()["origin"], R, axle=(0, 1, 0))
    with pytest.raises(InputError, match="radius is given"):
        jo.Friction("f", touch, 0.2, radius=0.1)


def _items(body: Any) -> tuple[Any, ...]:
    touch = DiscOnPlane("t", jo.ground["origin"], body["origin"], R, axle=(0, 1, 0))
    return (body, touch, jo.Friction("f", touch, 0.2))


def test_a_model_file_declares_it():
    model = parse_model(
        """
        bodies:
          - {type: rigid, name: disc, mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.1]}
        couplings:
          - {type: disc-on-plane, name: touch, a: ground.origin, b: disc.origin, radius: 100 mm,
             axle: [0, 1, 0], restitution: 0.3}
        frictions:
          - {name: grip, joint: touch, mu_kinetic: 0.2, law: {type: stick-slip}}
        """
    )
    (touch,), (grip,) = model.mechanism.couplings, model.mechanism.frictions
    assert isinstance(touch, DiscOnPlane) and grip.joint is touch
