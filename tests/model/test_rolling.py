"""Discs that roll, blades that glide: closed forms, both cores, order of the methods, bad input."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jousto as jo
from jousto.mechanism import Event, KnifeEdge, RollingDisc, RollingWheel
from jousto.schema.read import parse_model

G = 9.81
R, M = 0.1, 1.0
A, C = M * R * R / 4, M * R * R / 2  # kg m2, thin disc across and about its axle
UP = np.array([0.0, 0.0, 1.0])
CORES = ("maximal", "joint")
pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")


def pose(n: Any) -> Any:
    """Euler parameters of a disc with the axle n, and the vector e to its lowest point."""
    x = np.cross(UP, n) / np.linalg.norm(np.cross(UP, n))
    frame = np.stack([x, np.cross(n, x), n], axis=1)
    e = -(UP - (UP @ n) * n) / np.linalg.norm(np.cross(UP, n))
    return np.roll(Rotation.from_matrix(frame).as_quat(), 1), e


def coin(n: Any, w: Any, at: Any = (0.0, 0.0), **more: Any) -> Any:
    """A disc on the ground that rolls with the angular velocity w, rad/s."""
    n, w = np.asarray(n), np.asarray(w)
    orientation, e = pose(n)
    return jo.RigidBody(
        "coin",
        M,
        (A, A, C),
        position=(*at, -R * e[2]),
        orientation=orientation,
        velocity=-np.cross(w, R * e),
        angular_velocity=w,
        **more,
    )


def rolling(body: Any, core: str = "auto", *more: Any) -> Any:
    roll = RollingDisc("roll", jo.ground["origin"], body["origin"], R)
    return jo.compile(
        jo.Mechanism(
            *(body, roll, jo.Gravity((0, 0, -G)), jo.PositionSensor("p", body["origin"])),
            jo.ReactionSensor("f", roll, resolved_in="joint"),
            *(make(roll) for make in more),
        ),
        core=core,
    )


def leaning(core: str = "auto") -> tuple[Any, float]:
    """A coin in a circle of 0.5 m, leaning by 30 deg, and its angular velocity about it."""
    th, p = np.radians(60.0), 0.5
    W = np.sqrt(M * G * R * np.cos(th) / (np.sin(th) * ((C + M * R * R) * p / R + A * np.cos(th))))
    n = np.array([np.sin(th), 0.0, np.cos(th)])
    _, e = pose(n)
    v = np.cross(W * UP, (p, 0, 0))
    lever = np.cross(n, R * e)
    spin = -(np.cross(W * UP, R * e) + v) @ lever / (lever @ lever)
    return rolling(coin(n, W * UP + spin * n, (p, 0.0)), core), float(W)


@pytest.mark.parametrize("core", CORES)
def test_a_leaning_coin_runs_in_a_circle(core: str) -> None:
    model, W = leaning(core)
    assert pytest.approx(2.725425192, abs=1e-9) == W
    run = jo.simulate(model, 2.0, solver=jo.RK4(1e-3))
    p = run["p"]
    np.testing.assert_allclose(np.hypot(p[:, 0], p[:, 1]), 0.5, atol=1e-9)
    angle = np.unwrap(np.arctan2(p[:, 1], p[:, 0]))
    np.testing.assert_allclose(angle, W * run.time, atol=1e-8)
    np.testing.assert_allclose(run["f"][:, 2], M * G, rtol=1e-8)
    np.testing.assert_allclose(np.hypot(*run["f"][:, :2].T), M * W * W * 0.5, rtol=1e-8)
    assert np.abs(run.energy.error).max() < 1e-9


@pytest.mark.parametrize(("method", "order"), [(jo.RK4, 4), (jo.ROS2, 2), (jo.GeneralizedAlpha, 2)])
def test_the_methods_keep_their_order(method: Any, order: int) -> None:
    model, W = leaning()
    errors = []
    for h in (8e-3, 4e-3) if order == 4 else (2e-3, 1e-3):
        p = jo.simulate(model, 0.8, solver=method(h))["p"][-1]
        errors.append(np.hypot(p[0] - 0.5 * np.cos(0.8 * W), p[1] - 0.5 * np.sin(0.8 * W)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.35)


@pytest.mark.parametrize(
    "solver", [jo.RK4(5e-4), jo.simulation.DormandPrince(tolerance=1e-10)], ids=str
)
def test_a_thrown_coin_comes_to_the_place_of_two_other_integrations(solver: Any) -> None:
    # n = (cos 5 deg, 0, sin 5 deg), w = -10 n + 0.5 k; after 2 s
    n = np.array([np.cos(np.radians(5)), 0.0, np.sin(np.radians(5))])
    run = jo.simulate(rolling(coin(n, -10 * n + 0.5 * UP)), 2.0, solver=solver)
    np.testing.assert_allclose(run["p"][-1, :2], (-1.071843380, 1.532601423), atol=2e-8)
    assert np.abs(run.energy.error).max() < 1e-8


def test_an_upright_coin_wobbles_with_the_frequency_of_the_linear_theory() -> None:
    # sqrt(2) times the critical speed .5718391382 m/s: 8.858893836 rad/s
    w = np.sqrt(2.0) * 0.5718391382 / R
    tilt = 1e-5
    n = np.array([np.cos(tilt), 0.0, np.sin(tilt)])
    run = jo.simulate(rolling(coin(n, w * n)), 2.0, solver=jo.RK4(1e-3))
    fall = (R - run["p"][:, 2]) / (0.5 * R * tilt**2)  # tilt^2 / its first value
    # the tilt goes from 1 to -3 and back, since the coin turns meanwhile
    half = np.pi / 8.858893836
    found = [fall[np.abs(run.time - k * half).argmin()] for k in range(1, 5)]
    np.testing.assert_allclose(found, (9.0, 1.0, 9.0, 1.0), rtol=1e-3)


def test_a_wheel_rolls_down_a_slope_and_may_slide_across() -> None:
    # a = g sin(slope) / (1 + C / (m R^2)) along; across it slides freely
    slope = np.radians(10.0)
    disc = jo.RigidBody(
        "wheel", M, (A, A, C), position=(0, 0, R), orientation=pose(np.array([0.0, 1.0, 0.0]))[0]
    )
    wheel = RollingWheel("roll", jo.ground["origin"], disc["origin"], R, axle=(0, 1, 0))
    pull = (G * np.sin(slope), 0.3, -G * np.cos(slope))
    place = jo.PositionSensor("p", disc["origin"])
    # kept upright
    up = jo.mechanism.Perpendicular("up", jo.ground["origin"], disc["origin"], UP, (0, 1, 0))
    model = jo.compile(jo.Mechanism(disc, wheel, up, jo.Gravity(pull), place))
    run = jo.simulate(model, 1.0, solver=jo.RK4(1e-3))
    a = G * np.sin(slope) / (1 + C / (M * R * R))
    np.testing.assert_allclose(run["p"][-1], (0.5 * a, 0.15, R), atol=1e-9)


def gliding(*, center: Any = (0, 0, 0), gravity: Any = (0, 0, -G), **more: Any) -> Any:
    inertia = 0.1
    body = jo.RigidBody("sleigh", 2.0, (inertia,) * 3, center=center, **more)
    plane = jo.Planar("plane", jo.ground["origin"], body["origin"])
    blade = KnifeEdge("blade", jo.ground["origin"], body["origin"], (0, 1, 0))
    sensors = (
        jo.PositionSensor("p", body["origin"]),
        jo.VelocitySensor("v", body["origin"]),
        jo.CoordinateSensor("heading", plane.angle),
    )
    return jo.compile(jo.Mechanism(body, plane, blade, jo.Gravity(gravity), *sensors))


def test_a_sleigh_turns_into_its_glide() -> None:
    # Chaplygin's sleigh: v = V tanh(a V t / b^2), V = 1 m/s
    a, b = 0.2, np.sqrt((0.1 + 2 * 0.04) / 2)
    model = gliding(center=(a, 0, 0), angular_velocity=(0, 0, 1 / b))
    run = jo.simulate(model, 1.0, solver=jo.RK4(1e-3))
    speed = np.hypot(run["v"][:, 0], run["v"][:, 1])
    np.testing.assert_allclose(speed, np.tanh(a * run.time / b**2), atol=1e-9)
    assert speed[-1] == pytest.approx(0.9767853671, abs=1e-9)
    assert run["heading"][-1, 0] == pytest.approx(2.032354162, abs=1e-8)


def test_a_spinning_skate_on_a_slope_comes_back() -> None:
    # x = g sin(20 deg) / (2 w^2) sin^2(w t)
    slope, w = np.radians(20), 2.0
    pull = (G * np.sin(slope), 0, -G * np.cos(slope))
    run = jo.simulate(
        gliding(gravity=pull, angular_velocity=(0, 0, w)), np.pi / w, solver=jo.RK4(np.pi / 4000)
    )
    x = run["p"][:, 0]
    assert x.max() == pytest.approx(0.4194022008, abs=1e-9)
    np.testing.assert_allclose(x, x.max() * np.sin(w * run.time) ** 2, atol=1e-9)


def test_a_disc_that_is_lifted_leaves_the_plane_when_it_presses_no_more() -> None:
    n = np.array([0.0, 1.0, 0.0])
    body = coin(n, 3.0 * n)
    roll = RollingDisc("roll", jo.ground["origin"], body["origin"], R)
    press = jo.ReactionSensor("f", roll, resolved_in="joint")
    lift = Event("lift", press, 0.0, "falling", component="Fz", releases=roll)
    rope = jo.Force("rope", body["origin"], (0, 0, 2 * M * G), signal=jo.Ramp(0.0, 1.0))
    model = jo.compile(
        jo.Mechanism(
            *(body, roll, press, lift, rope, jo.Gravity((0, 0, -G))),
            jo.PositionSensor("p", body["origin"]),
        )
    )
    run = jo.simulate(model, 0.8, solver=jo.RK4(1e-3))
    assert run.events[0].time == pytest.approx(0.5, abs=1e-10)
    # from then on z'' = 2 g t - g
    assert run["p"][-1, 2] - R == pytest.approx(2 * G * 0.3**3 / 6, abs=1e-9)


@pytest.mark.parametrize("damped", [False, True])
def test_modes_of_a_wheel_on_a_spring_turn_it(damped: bool) -> None:
    # k = (m + C / R^2) w^2
    n = np.array([0.0, 1.0, 0.0])
    body = coin(n, 0 * n)
    ground = jo.ground["origin"]
    wheel = RollingWheel("roll", ground, body["origin"], R)
    plane = jo.Planar("plane", ground, body["origin"], n)
    spring = jo.Spring("spring", jo.Displacement(ground, body["origin"], axis="x"), 100.0)
    model = jo.compile(jo.Mechanism(body, wheel, plane, spring, jo.Gravity((0, 0, -G))))
    w = 2 * np.pi * np.array(jo.modes(model, damped=damped).frequencies)
    assert w[-1] == pytest.approx(np.sqrt(100.0 / (M + C / R**2)), rel=1e-9)
    np.testing.assert_allclose(w[:-1], 0.0, atol=1e-6)


def test_bad_discs_are_refused_with_a_remedy() -> None:
    n = np.array([0.0, 1.0, 0.0])
    body = coin(n, 0 * n)
    ground = jo.ground["origin"]
    with pytest.raises(jo.InputError, match="axle is normal to the plane"):
        RollingDisc("roll", ground, body["origin"], R, axle=(0, 0, 1))
    with pytest.raises(jo.InputError, match="radius"):
        RollingDisc("roll", ground, body["origin"], 0.0)
    with pytest.raises(jo.InputError, match="across the blade is normal"):
        KnifeEdge("blade", ground, body["origin"], UP)
    with pytest.raises(jo.InputError, match="initial gap of 20 mm"):
        jo.Mechanism(body, RollingDisc("roll", ground, body["origin"], 0.12))


def test_a_model_file_names_the_height_of_the_rim() -> None:
    found = parse_model(
        """
        bodies:
          - {type: rigid, name: disc, mass: 1, inertia: [1, 1, 1], position: [0, 0, 0.1]}
        joints:
          - {type: rolling-disc, name: roll, a: ground.origin, b: disc.origin, radius: 0.1,
             axle: [0, 1, 0]}
        sensors:
          - {type: coordinate, name: h, coordinate: roll.height}
        """
    )
    (sensor,) = found.mechanism.sensors
    assert sensor.coordinate is found.mechanism.joints[0].height


def test_blades_that_contradict_each_other_hold_a_sleigh_without_a_jolt() -> None:
    body = jo.RigidBody("sleigh", 2.0, (0.1,) * 3, velocity=(3.0, 1.0, 0))
    plane = jo.Planar("plane", jo.ground["origin"], body["origin"])
    blades = [
        KnifeEdge(name, jo.ground["origin"], body["origin"], across)
        for name, across in (("one", (0, 1, 0)), ("other", (1.0, 0.3, 0)))
    ]
    v = jo.VelocitySensor("v", body["origin"])
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        model = jo.compile(jo.Mechanism(body, plane, *blades, v))
        run = jo.simulate(model, 0.5)
    assert not [x for x in found if "jolt" in str(x.message)]
    assert np.abs(run["v"]).max() < 1e-12
