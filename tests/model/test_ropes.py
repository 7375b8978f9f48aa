"""Ropes over sheaves: lengths, closed forms, both cores, all methods, tangents, bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import Reeving, RopeSpan, StateSensor
from jousto.model.native.native import displaced
from jousto.schema.read import parse_model
from model.test_newton import assert_exact

G = 9.81
METHODS = (jo.RK4(2e-4), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3))


def down(*items: Any, core: str = "auto") -> jo.Model:
    """The machine of the items under gravity along -y."""
    return jo.compile(jo.Mechanism(*items, jo.Gravity((0, -G, 0))), core=core)


def mass(name: str, m: float, x: float, y: float, z: float = 0.0) -> jo.RigidBody:
    return jo.RigidBody(name, m, (0.1, 0.1, 0.1), position=(x, y, z))


# -- lengths ----------------------------------------------------------------------------------


def around(R: float, p: Any, q: Any, side: float) -> float:
    """Length from p around a disc at the origin to q: two tangents and the arc (plane geometry)."""
    (a, b), r = (np.hypot(*p), np.hypot(*q)), R
    turn = side * (np.arctan2(q[1], q[0]) - np.arctan2(p[1], p[0])) % (2 * np.pi)
    arc = turn - np.arccos(r / a) - np.arccos(r / b)
    return float(np.sqrt(a * a - r * r) + np.sqrt(b * b - r * r) + r * arc)


@pytest.mark.parametrize("side", [1, -1])
def test_length_around_a_disc(side):
    p, q = (-1.1, 0.6 * side), (0.8, 1.7 * side)
    R = 0.4
    path = [jo.ground.at((*p, 0)), mass("disc", 1.0, 0, 0)["origin"], jo.ground.at((*q, 0))]
    rope = Reeving("rope", path, (0, side * R, 0), stiffness=1.0)
    assert rope.initial_length == pytest.approx(around(R, p, q, side), rel=1e-13)


def test_an_open_and_a_crossed_belt():
    """L = 2 sqrt(d^2 - (R - r)^2) + pi (R + r) + 2 (R - r) asin((R - r) / d)."""
    R, r, d = 0.5, 0.3, 2.0
    for sign in (1, -1):
        wheels = [mass("a", 1.0, 0, 0), mass("b", 1.0, d, 0)]
        a, b = (wheel["origin"] for wheel in wheels)
        spans = RopeSpan(a, b, -R, -sign * r), RopeSpan(b, a, -sign * r, -R)
        straight = sum(span.initial for span in spans)
        assert straight == pytest.approx(2 * np.sqrt(d**2 - (R - sign * r) ** 2), rel=1e-14)
        top = jo.ground.at((-5.0, R, 0))
        path = (top, a, b, a, jo.ground.at((5.0, R, 0)))
        if sign > 0:  # once around both wheels
            rope = Reeving("rope", path, (0, -R, -r, -R, 0), stiffness=1.0)
            lean = np.arcsin((R - r) / d)
            belt = straight + np.pi * (R + r) + 2 * (R - r) * lean
            assert rope.initial_length == pytest.approx(10.0 + belt, rel=1e-13)


def stationary(span: RopeSpan) -> float:
    """Length by a search over the direction: s is stationary, no derivative used."""

    def s(z: Any) -> float:
        e = span.direction + z[0] * one + z[1] * other
        e = e / np.linalg.norm(e)
        made = e @ (span.b.r - span.a.r)
        for marker, radius in ((span.a, span.radius_a), (span.b, -span.radius_b)):
            made += radius * np.arctan2(e @ marker.A[:, 1], e @ marker.A[:, 0])
        return float(made)

    e = span.direction
    one = np.cross(e, (0.3, 0.5, 0.9))
    other = np.cross(e, one)
    h = 1e-4
    slopes = [(s((h, 0)) - s((-h, 0))) / 2 / h, (s((0, h)) - s((0, -h))) / 2 / h]
    assert np.abs(slopes).max() < 1e-7
    return s((0, 0))


def skew(rng: Any, core: str = "auto") -> jo.Model:
    """Two bodies whose sheaves are anyhow in space, a spring along the rope between them."""
    bodies = [
        jo.RigidBody(
            name, 2.0, (0.3, 0.4, 0.5), position=at,
            orientation=jo.Rotate(rng.normal(size=3), radians=0.3),
            velocity=(0.0 if name == "a" else 1.0) * rng.normal(size=3),
            angular_velocity=rng.normal(size=3),
            markers={"sheave": rng.normal(size=3) * 0.1},
        )
        for name, at in (("a", (0, 0, 0)), ("b", (2.0, 0.4, -0.3)))
    ]  # fmt: skip
    a, b = (body["sheave"] for body in bodies)
    span = RopeSpan(a, b, 0.35, -0.2)
    spring = jo.Spring("s", span, 300.0, 4.0, 0.8 * span.initial)
    joint = jo.Spherical("j", jo.ground["origin"], bodies[0]["origin"])
    value = jo.CoordinateSensor("s", span)
    rate = jo.RateSensor("v", span)
    second = jo.Spring.between("t", bodies[1]["origin"], jo.ground["origin"], 50.0)
    assert span.initial == pytest.approx(stationary(span), rel=1e-13)
    return jo.compile(jo.Mechanism(*bodies, joint, spring, second, value, rate), core=core)


def test_tangents_of_sheaves_anyhow_in_space():
    rng = np.random.default_rng(4)
    for _ in range(4):
        engine = jo.model.Engine(skew(rng))
        engine.q[:] = displaced(engine.model, engine.q, 0.05 * rng.normal(size=engine.model.nv))
        engine.accelerations()
        assert_exact(engine, 1e-11)


@pytest.mark.parametrize("core", ["maximal", "joint"])
def test_energy_is_kept_in_space(core):
    """The force is the gradient of the length: energy and momentum of a moving machine."""
    model = skew(np.random.default_rng(7), core)
    run = jo.simulate(model, 0.4, solver=jo.RK4(2e-4))
    e = run.energy
    total = e.kinetic + e.springs + e.dissipated
    assert np.ptp(total) < 1e-9 * total[0]
    # the rate is the derivative of the value
    v = np.gradient(run["s"][:, 0], run.time)
    np.testing.assert_allclose(run["v"][2:-2, 0], v[2:-2], rtol=0, atol=2e-5 * np.abs(v).max())


# -- machines with closed forms -----------------------------------------------------------------


def tackle(core: str = "auto", eta: float = 1.0, **more: Any) -> tuple[jo.Model, float]:
    """A load of 30 kg on a block with two parts of rope, 20 kg at the free end; the tension."""
    R, m, w, EA = 0.15, 30.0, 20.0, 2e6
    block, weight = mass("block", m, R, -5), mass("weight", w, 4 * R, -4)
    top = jo.ground.at((3 * R, 0, 0))
    T = 3 * m * w * G / (m + 4 * w)
    path = (jo.ground["origin"], block["origin"], top, weight["origin"])
    radii = (0, R, -R, 0)
    straight = 5 + 5 + 4 + np.pi * R * 2
    rope = Reeving(
        *("rope", path, radii), stiffness=EA, length=straight / (1 + T / EA),
        efficiencies=(1, eta, eta, 1), **more,
    )  # fmt: skip
    assert rope.initial_length == pytest.approx(straight, rel=1e-14)
    sensors = [StateSensor(name, rope[name]) for name in ("tension", "tension_end", "length")]
    p = jo.VelocitySensor("block", block["origin"]), jo.PositionSensor("end", weight["origin"])
    guide = jo.Prismatic("guide", jo.ground.at((R, -5, 0)), block["origin"], axis=(0, 1, 0))
    return down(block, weight, rope, guide, *sensors, *p, core=core), T


@pytest.mark.parametrize("core", ["maximal", "joint"])
@pytest.mark.parametrize("solver", METHODS)
def test_block_and_tackle(core, solver):
    """With the stretch of the tension at the start the motion is uniformly accelerated, exactly."""
    model, T = tackle(core)
    run = jo.simulate(model, 0.5, solver=solver)
    rise = 2 * T / 30.0 - G
    np.testing.assert_allclose(run["tension"][:, 0], T, rtol=1e-7)
    np.testing.assert_allclose(run["block"][-1], (0, rise * 0.5, 0), rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(run["end"][-1, 1], -4 - rise * 0.5**2, rtol=1e-7)
    e = run.energy
    balance = e.kinetic + e.potential - e.work
    assert np.ptp(balance) < 1e-6 * np.ptp(e.potential)


def test_sheaves_with_losses():
    """T1 + T2 = m (g + a), T3 = w (g - 2 a), each sheave T_after = T_before / eta."""
    m, w, eta = 30.0, 20.0, 0.95
    model, _ = tackle(eta=eta, damping=2e4)
    run = jo.simulate(model, 1.0, solver=jo.ROS2(5e-4))
    T, a = np.linalg.solve([[1 + 1 / eta, -m], [eta**-2, 2 * w]], [m * G, w * G])
    late = run.time > 0.5
    np.testing.assert_allclose(run["tension"][late, 0], T, rtol=1e-6)
    np.testing.assert_allclose(run["tension_end"][late, 0], T / eta**2, rtol=1e-6)
    speed = np.interp((0.5, 1.0), run.time, run["block"][:, 1])
    # the rope is longer by its stretch of 8e-5 on one side of a sheave than on the other
    assert speed[1] - speed[0] == pytest.approx(0.5 * a, rel=8e-5)


def test_a_drum_with_inertia():
    """y'' = -g m / (m + J / r^2), and the tension acts on the axle as on the load."""
    m, J, r, EA = 12.0, 0.3, 0.25, 1e6
    wheel = jo.RigidBody("wheel", 5.0, (J, J, J))
    axle = jo.Revolute("axle", jo.ground["origin"], wheel["origin"])
    load = mass("load", m, r, -3)
    share = m / (m + J / r**2)
    T = m * G * (1 - share)
    rope = Reeving(
        "rope", (jo.ground.at((r, 0, 0)), load["origin"]), (0, 0), stiffness=EA,
        length=3 / (1 + T / EA), drum=axle.angle, drum_radius=-r,
    )  # fmt: skip
    x = jo.CoordinateSensor("turn", axle.angle), jo.PositionSensor("p", load["origin"])
    run = jo.simulate(down(wheel, axle, load, rope, *x), 1.0, solver=jo.RK4(5e-4))
    assert run["p"][-1, 1] == pytest.approx(-3 - 0.5 * share * G, rel=1e-4)
    # the stretch is kept: the load moves as far as the rim of the drum pays out, times 1 + strain
    assert run["p"][-1, 1] + 3 == pytest.approx(r * run["turn"][-1, 0] * (1 + T / EA), rel=1e-4)


def test_a_winch_hoists():
    """The block of two parts rises with half the speed of the rope."""
    R = 0.2
    block = mass("block", 50.0, R, -6)
    rope = Reeving(
        "rope", (jo.ground["origin"], block["origin"], jo.ground.at((2 * R, 0, 0))), (0, R, 0),
        stiffness=5e6, damping=5e4, length=(12 + np.pi * R) / (1 + 25 * G / 5e6),
        winch=jo.SCurve((0.0, 0.5), (0.0, -0.8)),
    )  # fmt: skip
    sensors = StateSensor("paid", rope["paid_out"]), jo.VelocitySensor("v", block["origin"])
    run = jo.simulate(down(block, rope, *sensors), 2.0, solver=jo.ROS2(1e-3))
    assert run["v"][-1, 1] == pytest.approx(0.4 * (1 + 25 * G / 5e6), rel=1e-7)
    assert run["paid"][-1, 0] == pytest.approx(-0.8 * 1.75, rel=1e-6)


def test_slack_and_taut_again_are_events():
    """A mass on a rope is thrown upwards: ``sin(w t) = g / (w v)``, then free flight."""
    m, EA, l, v = 10.0, 2e5, 4.0, 1.0
    k = EA / l
    load = jo.RigidBody("load", m, (1, 1, 1), position=(0, -l - m * G / k, 0), velocity=(0, v, 0))
    rope = Reeving("r", (jo.ground["origin"], load["origin"]), (0, 0), stiffness=EA, length=l)
    strain, tension = StateSensor("strain", rope["strain"]), StateSensor("T", rope["tension"])
    events = [
        jo.mechanism.Event("slack", strain, threshold=0.0, direction="falling"),
        jo.mechanism.Event("taut", strain, threshold=0.0, direction="rising"),
    ]
    run = jo.simulate(down(load, rope, strain, tension, *events), 0.4, solver=jo.RK4(1e-3))
    w = np.sqrt(k / m)
    slack = np.arcsin(G / (w * v)) / w
    taut = slack + 2 * np.sqrt(v**2 - (G / w) ** 2) / G
    times = {name: [e.time for e in run.events if e.name == name] for name in ("slack", "taut")}
    assert times["slack"][0] == pytest.approx(slack, rel=1e-6)
    assert times["taut"][0] == pytest.approx(taut, rel=1e-6)
    assert run["T"].min() == 0.0


def ring(x0: float) -> jo.Model:
    """A ring on a rope of 10 m between two points 8 m apart, which does not stretch."""
    bead = mass("ring", 3.0, x0, -3 * np.sqrt(1 - x0**2 / 25))
    ends = jo.ground.at((-4, 0, 0)), jo.ground.at((4, 0, 0))
    spans = [RopeSpan(end, bead["origin"]) for end in ends]
    rope = jo.Coupling("rope", spans, (1.0, 1.0))
    plane = jo.PointOnPlane("plane", jo.ground["origin"], bead["origin"], normal=(0, 0, 1))
    return down(bead, rope, plane, jo.PositionSensor("p", bead["origin"]))


def test_a_ring_on_a_light_rope():
    """On the ellipse of 5 and 3 m: small motions 1.084988479 rad/s, from x = 3 m 5.570773755 s."""
    model = ring(0.0)
    omega = 2 * np.pi * np.asarray(jo.modes(model, jo.equilibrium(model)).frequencies)
    assert np.sort(omega[omega > 0.1])[0] == pytest.approx(1.084988479, rel=1e-9)
    run = jo.simulate(ring(3.0), 6.5, solver=jo.RK4(1e-3))
    x = run["p"][:, 0]
    i = int(np.argmax(x[run.time > 4.0])) + int(np.sum(run.time <= 4.0))
    a, b, _ = np.polyfit(run.time[i - 2 : i + 3] - run.time[i], x[i - 2 : i + 3], 2)
    assert run.time[i] - b / (2 * a) == pytest.approx(5.570773755, rel=1e-6)


# -- declarations -------------------------------------------------------------------------------


def test_what_is_refused_and_why():
    load, top = mass("load", 1.0, 0, -3), jo.ground["origin"]
    a, b = load["origin"], load.at((0.5, 0, 0))
    near = mass("near", 1.0, 0.1, 0)["origin"]

    def refused(text: str, path: Any, radii: Any, **more: Any) -> None:
        with pytest.raises(InputError, match=text):
            Reeving("rope", path, radii, **({"stiffness": 1e6} | more))

    refused("path has 1 markers; give two or more", (top,), (0,))
    refused("has 3 radii for 2 markers", (top, a), (0, 1, 0))
    refused("are inside one another or too near; move them apart", (top, near), (0.5, -0.5))
    refused("sheaves of radius 0.5 and 0.1 m are inside", (top, near), (0.5, 0.1))
    refused("at one place; move one", (top, jo.ground["origin"]), (0, 0))
    refused("along the axle of ground.origin, its z axis", (top, a), (0.2, 0), axis=(0, 1, 0))
    refused("nothing on its path can move", (a, b), (0, 0))
    refused(
        r"would wrap 3\d\d degrees around load.origin.*change the sign of radii\[1\]",
        (top, a, jo.ground.at((0.3, -6, 0))), (0, -0.01, 0),
    )  # fmt: skip
    refused(r"efficiencies\[1\] at load.origin is 1.2, must be above 0 and at most 1",
            (top, a, jo.ground.at((0.4, 0, 0))), (0, 0.2, 0), efficiencies=(1, 1.2, 1))  # fmt: skip
    refused("an end has no loss", (top, a), (0, 0), efficiencies=(0.9, 1))
    refused("drum and drum_radius go together", (top, a), (0, 0), drum_radius=0.2)
    refused("stiffness is 0 N, must be positive", (top, a), (0, 0), stiffness=0)
    with pytest.warns(jo.JoustoWarning, match="is 2 m long, its path 3 m: it starts stretched"):
        Reeving("rope", (top, a), (0, 0), stiffness=1e6, length=2.0)
    with pytest.raises(InputError, match="both markers are on 'load'"):
        RopeSpan(a, b, 0.1)


FILE = """
bodies:
  - {name: load, mass: 10 kg, inertia: [1, 1, 1], position: [0.2, -5, 0]}
joints:
  - {type: prismatic, name: slide, a: {body: ground, at: [0.2, -5, 0]},
     b: load.origin, axis: [0, 1, 0]}
gravity: [0, -9.81, 0]
states:
  - type: reeving
    name: rope
    path: [ground.origin, load.origin, {body: ground, at: [400 mm, 0, 0]}]
    radii: [0 m, 200 mm, 0 m]
    stiffness: 1 MN
    damping: 5 kN s/m
    efficiencies: [1, 0.97, 1]
    winch: {type: s-curve, times: [0, 1], values: [0, -0.3]}
forces:
  - {type: spring, name: side, stiffness: 10 N/m, free: 2 m,
     coordinate: {type: rope-span, a: ground.origin, b: load.origin, radius_b: 0.2 m}}
sensors:
  - {type: state, name: pull, of: rope.tension, unit: N}
  - {type: position, name: p, marker: load.origin}
"""


def test_a_model_file_is_the_same_machine():
    load = jo.RigidBody("load", 10.0, (1, 1, 1), position=(0.2, -5, 0))
    rope = Reeving(
        "rope", (jo.ground["origin"], load["origin"], jo.ground.at((0.4, 0, 0))), (0, 0.2, 0),
        stiffness=1e6, damping=5e3, efficiencies=(1, 0.97, 1), winch=jo.SCurve((0, 1), (0, -0.3)),
    )  # fmt: skip
    slide = jo.Prismatic("slide", jo.ground.at((0.2, -5, 0)), load["origin"], axis=(0, 1, 0))
    span = RopeSpan(jo.ground["origin"], load["origin"], 0.0, 0.2)
    side = jo.Spring("side", span, 10.0, free=2.0)
    pull = StateSensor("pull", rope["tension"], unit="N")
    model = down(load, slide, rope, side, pull, jo.PositionSensor("p", load["origin"]))
    read = jo.compile(parse_model(FILE).mechanism)
    runs = [jo.simulate(one, 1.0, solver=jo.ROS2(1e-3)) for one in (model, read)]
    for name in ("pull", "p"):
        np.testing.assert_array_equal(runs[0][name], runs[1][name])


def test_a_rope_is_drawn_around_its_sheaves():
    load = mass("load", 1.0, 0.2, -5)
    top = jo.ground["origin"]
    rope = Reeving(
        "r", (top, load["origin"], jo.ground.at((0.4, 0, 0))), (0, 0.2, 0), stiffness=1.0
    )
    symbol = next(one for one in down(load, rope).symbols if one.name == "r")
    assert symbol.kind == "cable"
    rim = [p.u0 for p in symbol.points if p.body >= 0]
    assert len(rim) > 5
    np.testing.assert_allclose(np.linalg.norm(rim, axis=1), 0.2, rtol=1e-12)
    np.testing.assert_allclose((rim[0], rim[-1]), ((-0.2, 0, 0), (0.2, 0, 0)), atol=1e-12)
