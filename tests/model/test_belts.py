"""Bollards, traction sheaves and belts: Euler-Eytelwein, sticking, creep, heat, bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import BeltDrive, BlockForce, Capstan, StateSensor, rate
from jousto.model.native.native import displaced
from jousto.schema.read import parse_model
from model.test_newton import assert_exact

G = 9.81
METHODS = (jo.RK4(2e-4), jo.ROS2(5e-4), jo.GeneralizedAlpha(5e-4), jo.simulation.DormandPrince())
NAMES = [type(solver).__name__ for solver in METHODS]
CORES = ["maximal", "joint"]


def mass(name: str, m: float, x: float, y: float) -> tuple[jo.RigidBody, jo.Prismatic]:
    """A mass that moves up and down."""
    body = jo.RigidBody(name, m, (0.1, 0.1, 0.1), position=(x, y, 0))
    guide = jo.Prismatic(f"{name}_rail", jo.ground.at((x, y, 0)), body["origin"], axis=(0, 1, 0))
    return body, guide


def hung(m: float, w: float, core: str = "auto", J: float = 0.0, **more: Any) -> jo.Model:
    """Masses m and w on a rope over a bollard, or over a sheave that turns with the inertia J."""
    R = 0.2
    left, right = mass("left", m, -R, -3), mass("right", w, R, -2)
    items: list[Any] = [*left, *right]
    drum, given = jo.ground["origin"], {"stiffness": 1e6, "damping": 2e3, "mu": 0.2, **more}
    if J:
        wheel = jo.RigidBody("wheel", 5.0, (J, J, J))
        axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"])
        items += [wheel, axle, jo.CoordinateSensor("turn", axle.angle)]
        drum, given["turn"] = wheel["origin"], axle.angle
    path = left[0]["origin"], drum, right[0]["origin"]
    rope = Capstan("rope", path, (0, -R, 0), **given)
    names = "tension", "tension_end", "stored", "heat", "slip"
    sensors = [StateSensor(name, rope[name]) for name in names]
    speed = jo.VelocitySensor("v", left[0]["origin"])
    gravity = jo.Gravity((0, -G, 0))
    return jo.compile(jo.Mechanism(*items, rope, *sensors, speed, gravity), core=core)


def book_closes(run: jo.Solution, rope_first: float, tolerance: float) -> None:
    """Assert that the work of the rope is what it stores and its heat, which only grows."""
    e = run.energy
    rope = run["stored"][:, 0] + run["heat"][:, 0]
    scale = np.ptp(e.kinetic)
    assert np.ptp(e.kinetic + e.potential + rope) < tolerance * scale
    assert np.diff(run["heat"][:, 0]).min() > -1e-9 * scale
    assert rope[0] == pytest.approx(rope_first)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", METHODS, ids=NAMES)
def test_a_rope_slips_over_a_bollard(core, solver):
    """``T_1 = T_2 exp(mu phi)`` and ``a = g (m - E w) / (m + E w)``."""
    m, w, E = 60.0, 20.0, np.exp(0.2 * np.pi)
    run = jo.simulate(hung(m, w, core), 1.0, solver=solver)
    late = run.time > 0.6
    a = G * (m - E * w) / (m + E * w)
    ratio = run["tension"][late, 0] / run["tension_end"][late, 0]
    np.testing.assert_allclose(ratio, E, rtol=1e-3)
    np.testing.assert_allclose(run["tension"][late, 0].mean(), m * (G - a), rtol=2e-3)
    v = np.interp([0.6, 1.0], run.time, run["v"][:, 1])
    assert v[1] - v[0] == pytest.approx(-0.4 * a, rel=5e-3)
    book_closes(run, 0.0, 2e-3)


def test_a_rope_sticks_without_creep():
    """Below ``exp(mu phi)`` both masses stay where the stretch lets them, for ever."""
    m, w = 60.0, 35.0
    run = jo.simulate(hung(m, w, damping=2e4), 20.0, solver=jo.ROS2(2e-3))
    last = run.time > 10.0
    assert np.ptp(run["slip"][last, 0]) == 0.0
    assert np.abs(run["v"][last, 1]).max() < 1e-9
    np.testing.assert_allclose(run["tension"][-1, 0], m * G, rtol=1e-6)
    np.testing.assert_allclose(run["tension_end"][-1, 0], w * G, rtol=1e-6)


@pytest.mark.parametrize("core", CORES)
def test_a_traction_sheave_has_two_tensions(core):
    """A sheave with inertia drives the rope by friction: ``a = g (m - w) / (m + w + J / R^2)``."""
    m, w, J, R = 30.0, 24.0, 0.4, 0.2
    run = jo.simulate(hung(m, w, core, J=J, damping=2e4, turns=1), 1.0, solver=jo.ROS2(5e-4))
    a = G * (m - w) / (m + w + J / R**2)
    late = run.time > 0.6
    np.testing.assert_allclose(run["tension"][late, 0].mean(), m * (G - a), rtol=1e-4)
    np.testing.assert_allclose(run["tension_end"][late, 0].mean(), w * (G + a), rtol=1e-4)
    v = np.interp([0.6, 1.0], run.time, run["v"][:, 1])
    assert v[1] - v[0] == pytest.approx(-0.4 * a, rel=2e-3)
    book_closes(run, 0.0, 1e-3)


def drive(torque: float, core: str = "auto", cross: int = 1, **more: Any) -> jo.Model:
    """A motor of a given torque, a belt, and a brake of 20 N m s / rad."""
    R, r, d = 0.1, 0.25, 1.0
    wheels = [
        jo.RigidBody(name, 3.0, (J, J, J), position=(x, 0, 0))
        for name, J, x in (("a", 0.01, 0.0), ("b", 0.02, d))
    ]
    turns = [
        jo.Revolute(f"turn_{w.name}", jo.ground.at(w["origin"].r), w["origin"]) for w in wheels
    ]
    a, b = (turn.angle for turn in turns)
    belt = BeltDrive(
        *("belt", wheels[0]["origin"], wheels[1]["origin"], R, cross * r, a, b),
        **({"stiffness": 2e4, "mu": 0.3, "preload": 400.0, "damping": 20.0} | more),
    )
    motor = jo.JointForce("motor", a, jo.SCurve((0.0, 0.1), (0.0, torque)))
    brake = BlockForce("brake", b, -20.0 * rate(b))
    names = "tension_ab", "tension_ba", "stored", "heat", "slip"
    sensors = [StateSensor(name, belt[name]) for name in names]
    speeds = [jo.RateSensor(f"w_{turn.name[-1]}", turn.angle) for turn in turns]
    items = *wheels, *turns, belt, motor, brake, *sensors, *speeds
    return jo.compile(jo.Mechanism(*items), core=core)


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("cross", [1, -1])
def test_a_belt_creeps(core, cross):
    """The driven rim is slower by ``(T_1 - T_2) / (EA (1 + T_1 / EA))``, without any slip."""
    torque, EA = 20.0, 2e4
    run = jo.simulate(drive(torque, core, cross), 2.0, solver=jo.ROS2(5e-4))
    tight, slack = run["tension_ba"][-1, 0], run["tension_ab"][-1, 0]
    assert tight - slack == pytest.approx(torque / 0.1, rel=1e-5)
    creep = 1.0 - cross * 0.25 * run["w_b"][-1, 0] / (0.1 * run["w_a"][-1, 0])
    assert creep == pytest.approx((tight - slack) / EA / (1.0 + tight / EA), rel=1e-4)
    assert run["w_b"][-1, 0] == pytest.approx(cross * 0.25 * torque / 0.1 / 20.0, rel=1e-5)
    assert np.ptp(run["slip"]) == 0.0
    # creep loses (T_1 - T_2) v creep
    v = 0.1 * run["w_a"][-1, 0]
    late = run.time > 1.8
    slope = np.polyfit(run.time[late], run["heat"][late, 0], 1)[0]
    assert slope == pytest.approx((tight - slack) * v * creep, rel=1e-3)


def test_axles_by_an_axis_are_those_of_the_markers():
    wheels = [jo.RigidBody(n, 1.0, (1, 1, 1), position=(x, 0, 0)) for n, x in (("a", 0), ("b", 2))]
    turns = [
        jo.Revolute(f"t{w.name}", jo.ground.at(w["origin"].r), w["origin"], axis=(0, 1, 0)).angle
        for w in wheels
    ]
    ends = [w["origin"] for w in wheels]
    given = {"stiffness": 1e4, "mu": 0.3, "preload": 1.0, "axis": (0, 1, 0)}
    belt = BeltDrive("belt", *ends, 0.1, 0.4, *turns, **given)
    phi = np.pi - 2 * np.arcsin(0.3 / 2.0)
    assert belt.largest_ratio == pytest.approx(np.exp(0.3 * phi), rel=1e-12)


def test_a_belt_slips():
    """Beyond ``T_1 / T_2 = exp(mu phi)`` the motor runs away and the driven pulley does not."""
    model = drive(60.0, mu=0.2)
    belt_phi = np.pi - 2 * np.arcsin(0.15 / 1.0)
    run = jo.simulate(model, 1.0, solver=jo.ROS2(2.5e-4))
    tight, slack = run["tension_ba"][-1, 0], run["tension_ab"][-1, 0]
    assert tight / slack == pytest.approx(np.exp(0.2 * belt_phi), rel=2e-2)
    assert 0.1 * run["w_a"][-1, 0] > 2.0 * 0.25 * run["w_b"][-1, 0]
    assert np.diff(run["heat"][:, 0]).min() > -1e-9


@pytest.mark.parametrize("make", [lambda: hung(60.0, 20.0), lambda: drive(30.0)])
def test_tangents(make):
    rng = np.random.default_rng(8)
    engine = jo.model.Engine(make())
    engine.q[:] = displaced(engine.model, engine.q, 1e-4 * rng.normal(size=engine.model.nv))
    engine.accelerations()
    assert_exact(engine, 1e-10)


FILE = """
bodies:
  - {name: load, mass: 60 kg, inertia: [1, 1, 1], position: [-0.2, -3, 0]}
  - {name: hand, mass: 20 kg, inertia: [1, 1, 1], position: [0.2, -2, 0]}
  - {name: driven, mass: 2 kg, inertia: [1, 1, 1], position: [5, 0, 0]}
  - {name: driving, mass: 2 kg, inertia: [1, 1, 1], position: [6, 0, 0]}
joints:
  - {type: revolute, name: p, a: {body: ground, at: [5, 0, 0]}, b: driven.origin, axis: [0, 0, 1]}
  - {type: revolute, name: q, a: {body: ground, at: [6, 0, 0]}, b: driving.origin, axis: [0, 0, 1]}
gravity: [0, -9.81, 0]
forces:
  - {type: joint-force, name: motor, coordinate: p.angle, signal: 3 N m}
states:
  - type: capstan
    name: rope
    path: [load.origin, ground.origin, hand.origin]
    radii: [0 m, -200 mm, 0 m]
    stiffness: 1 MN
    mu: 0.2
  - type: belt-drive
    name: belt
    a: driven.origin
    b: driving.origin
    radius_a: 100 mm
    radius_b: -0.2 m
    turn_a: p.angle
    turn_b: q.angle
    stiffness: 20 kN
    mu: 0.3
    preload: 400 N
sensors:
  - {type: state, name: pull, of: rope.tension, unit: N}
  - {type: state, name: tight, of: belt.tension_ba, unit: N}
"""


def test_a_model_file_has_ropes_and_belts():
    run = jo.simulate(jo.compile(parse_model(FILE).mechanism), 0.05, solver=jo.RK4(2e-4))
    assert run["pull"].max() > 100.0
    assert np.ptp(run["tight"]) > 0.5


def test_what_is_refused_and_why():
    load = jo.RigidBody("load", 1.0, (1, 1, 1), position=(-0.2, -3, 0))
    wheel = jo.RigidBody("wheel", 1.0, (1, 1, 1))
    hinge = jo.Revolute("hinge", jo.ground["origin"], wheel["origin"])
    tilted = jo.Revolute("tilted", jo.ground["origin"], wheel["origin"], axis=(0, 1, 0))
    other = jo.Revolute("other", jo.ground.at((5, 0, 0)), load["origin"])
    rail = jo.Prismatic("rail", jo.ground["origin"], wheel["origin"])
    end = jo.ground.at((0.2, -2, 0))

    def refused(text: str, radii: Any = (0, -0.2, 0), path: Any = None, **more: Any) -> None:
        path = path or (load["origin"], wheel["origin"], end)
        with pytest.raises(InputError, match=text):
            Capstan("rope", path, radii, **({"stiffness": 1e6, "mu": 0.2} | more))

    refused("path has 2 markers; give three or more", path=(load["origin"], end))
    refused("has 2 radii for 3 markers", radii=(0, 0.2))
    refused("sheave is 2, must be a marker between the ends with a radius", sheave=2)
    refused("sheave is 1, must be a marker between the ends with a radius", radii=(0, 0, 0))
    refused("mu times the angle is .*must be at most 50: fix the rope to the sheave", turns=100)
    refused("turn is in m, must be the angle of a hinge", turn=rail.displacement)
    refused("turn does not turn wheel.origin; give the angle of its hinge", turn=other.angle)
    refused("turn turns about another axis than the axle", turn=tilted.angle)
    refused("mu is -0.1, must not be negative", mu=-0.1)

    def belt(text: str, a: Any, b: Any, *numbers: Any) -> None:
        with pytest.raises(InputError, match=text):
            BeltDrive("belt", a, b, *numbers, stiffness=1e4, mu=0.3, preload=1.0)

    ends = wheel["origin"], load["origin"]
    turns = hinge.angle, jo.Revolute("x", jo.ground.at(load["origin"].r), load["origin"]).angle
    belt("both pulleys are on 'wheel'", ends[0], wheel.at((1, 0, 0)), 0.1, 0.1, *turns)
    belt("inside one another or too near; move them apart", *ends, 4.0, -0.5, *turns)
    belt("turn_a turns about another axis", *ends, 0.1, 0.1, tilted.angle, turns[1])
    belt("turn_b does not turn load.origin", *ends, 0.1, 0.1, hinge.angle, hinge.angle)
    belt("radius_a is 0 m, must not be zero", *ends, 0.0, 0.1, *turns)
