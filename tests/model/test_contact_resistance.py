"""Resistance to rolling and drilling of a contact: closed forms, rest, tangents, order, energy."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    Capsule,
    CollisionShape,
    Contact,
    Contacts,
    Cuboid,
    HalfSpace,
    PowerLaw,
    Regularised,
    Sphere,
    SpringDamper,
    Surface,
    SurfacePair,
)
from jousto.simulation import State

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
R = 0.1
CORES = ("joint", "maximal")


def ball(
    v: Any = (0, 0, 0), w: Any = (0, 0, 0), slope: float = 0.0, core: str = "auto", K: float = 1e9,
    law: Any = None, **more: Any,
) -> Any:  # fmt: skip
    """A ball of 1 kg on a plane, sunk in by its weight; x points down the slope."""
    law = law or PowerLaw(K)
    sunk = (G * np.cos(slope) / law.stiffness) ** (1 / getattr(law, "exponent", 1.0))
    body = jo.RigidBody(
        "ball", 1.0, (0.4 * R * R,) * 3, position=(0, 0, R - sunk), velocity=v, angular_velocity=w
    )
    contact = Contact(
        "c",
        jo.ground["origin"],
        HalfSpace(),
        body["origin"],
        Sphere(R),
        law,
        mu_kinetic=0.5,
        **more,
    )
    sensors = (
        jo.PositionSensor("x", body["origin"]),
        jo.VelocitySensor("v", body["origin"]),
        jo.AngularVelocitySensor("w", body["origin"]),
    )
    gravity = jo.Gravity((G * np.sin(slope), 0, -G * np.cos(slope)))
    return jo.compile(jo.Mechanism(body, contact, gravity, *sensors), core=core)


SOLVERS = [jo.RK4(1e-4), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)]


def name_of(solver: Any) -> str:
    return type(solver).__name__


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", SOLVERS, ids=name_of)
@pytest.mark.parametrize("heading", [0.0, 35.0])
def test_a_ball_rolls_out(solver, core, heading):
    """Of v = w R and the moment l N: it slows down by l g / (1.4 R), and stays where it stops.

    It springs back by less than the stretch of its bristle, d / (1.5 l) R = 0.23 mm.
    """
    c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
    model = ball((0.5 * c, 0.5 * s, 0), (-5 * s, 5 * c, 0), core=core, rolling=2e-3)
    run = jo.simulate(model, 6.0, solver=solver)
    slows, t, x = 2e-3 * G / (1.4 * R), run.time, run["x"][:, :2]
    rolls = (t > 0.1) & (t < 3.5)
    assert (run["v"][rolls, :2] @ (c, s)) == pytest.approx(0.5 - slows * t[rolls], abs=1e-5)
    assert 0 < 0.125 / slows - np.linalg.norm(x[-1]) < 2.3e-4
    assert abs(x[-1] @ (-s, c)) < 1e-9
    assert np.ptp(x[t > 5.0], axis=0).max() < 1e-12
    assert np.abs(run["v"][-1]).max() < 1e-12
    assert np.abs(run.energy.error).max() < 1e-6 * 0.175


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", SOLVERS, ids=name_of)
def test_a_spinning_ball_stops_in_time(solver, core):
    """Of the moment l N about the normal: after w0 I / (l N)."""
    model = ball(w=(0, 0, 20.0), core=core, drilling=5e-3)
    run = jo.simulate(model, 3.0, solver=solver)
    ends = 20 * 0.4 * R * R / (5e-3 * G)
    spin, t = run["w"][:, 2], run.time
    slows = t < ends - 1e-3
    assert spin[slows] == pytest.approx(20 * (1 - t[slows] / ends), abs=1e-10)
    assert np.abs(spin[t > ends + 0.1]).max() < 1e-6
    assert np.abs(run["x"][:, :2]).max() < 1e-12
    assert np.abs(run.energy.error).max() < 1e-6 * 0.8


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", SOLVERS[1:], ids=name_of)
@pytest.mark.parametrize(("share", "rolls"), [(0.97, False), (1.03, True)])
def test_a_ball_stays_on_a_slope(solver, core, share, rolls):
    """The weight acts R sin(a) beside the contact: it stays up to tan(a) = l / R, without creep."""
    slope = np.arctan(share * 2e-3 / R)
    run = jo.simulate(ball(slope=slope, core=core, rolling=2e-3), 20.0, solver=solver)
    x, v = run["x"][:, 0], run["v"][:, 0]
    if rolls:
        lever = R - 0.5 * (G / 1e9) ** (2 / 3)  # to the middle of the overlap
        faster = G * (np.sin(slope) - 2e-3 / lever * np.cos(slope)) / 1.4
        assert (v[-1] - v[-5001]) / 5.0 == pytest.approx(faster, rel=1e-4)
    else:
        assert np.ptp(x[run.time > 10.0]) < 1e-12


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("step", [1e-3, 1e-2, 1.0])
def test_a_step_has_the_resistance_in_its_matrix(core, step):
    """Ball twisted within its dent, far below the limit: linear, I w' = -l^2 (k t + c w)."""
    k, l, I = 1e6, 5e-3, 0.4 * R * R
    model = ball(w=(0, 0, 1e-9), core=core, law=SpringDamper(k), drilling=l)
    states = np.array(jo.model.Engine(model).states)
    states[2], states[6:9] = -1e6, 0.0
    start = State(model.q0, model.v0, np.zeros(model.nrow), states=states)
    run = jo.simulate(model, 8 * step, solver=jo.ROS2(step), state=start)
    rate = l * np.sqrt(k / I)
    A = np.array([[-2 * rate, -rate * rate], [1.0, 0.0]])
    g = 1 - 1 / np.sqrt(2)
    W = np.linalg.inv(np.eye(2) - g * step * A)
    y = np.array([1e-9, 0.0])
    for i in range(9):
        assert run["w"][i, 2] == pytest.approx(y[0], abs=1e-20, rel=1e-9)
        k1 = W @ A @ y
        y = y + step / 2 * (k1 + W @ (A @ (y + step * k1) - 2 * g * step * A @ k1))


@pytest.mark.parametrize(
    "pair",
    [(HalfSpace(), Sphere(0.1)), (Cuboid((0.3, 0.4, 0.5)), Sphere(0.1))],
    ids=["floor", "box"],
)
@pytest.mark.parametrize("lengths", [(2.0, 3.0), (1e-3, 2e-3)], ids=["within", "at the limit"])
def test_tangent_is_the_derivative(pair, lengths):
    """Newton's matrix against complex steps, for overlapping bodies in general motion."""
    rng = np.random.default_rng(5)
    found = 0
    for _ in range(60):
        turn = rng.normal(size=(2, 4))
        turn /= np.linalg.norm(turn, axis=1)[:, None]
        v, w = rng.normal(size=(2, 2, 3))
        a = jo.RigidBody("a", 2.0, (0.1, 0.2, 0.25), orientation=turn[0], velocity=v[0])
        apart = rng.normal(size=3)
        apart *= rng.uniform(0.05, 0.45) / np.linalg.norm(apart)
        b = jo.RigidBody(
            "b", 1.0, (0.05, 0.06, 0.07), position=apart, orientation=turn[1],
            velocity=v[1], angular_velocity=w[1],
        )  # fmt: skip
        contact = Contact(
            "c", a["origin"], pair[0], b["origin"], pair[1], PowerLaw(1e4, restitution=0.7),
            rolling=lengths[0], drilling=lengths[1],
        )  # fmt: skip
        engine = jo.model.Engine(jo.compile(jo.Mechanism(a, b, contact)))
        if not engine.states[0]:
            continue
        engine.accelerations()
        exact = engine.tangent()
        N = engine.newton_matrix(0.0, 1.0, 0.0)[: len(exact.D), : len(exact.D)]
        assert np.abs(exact.D - N).max() <= 1e-12 * np.abs(exact.D).max()
        found += 1
    assert found > 5


@pytest.mark.parametrize(
    ("solver", "error"), [(jo.RK4(1e-3), 1e-4), (jo.ROS2(1e-3), 3e-3)], ids=["RK4", "ROS2"]
)
def test_energy_never_grows(solver, error):
    """Spheres and capsules with any spin thrown at a floor: the energy falls at every step."""
    rng = np.random.default_rng(3)
    for _ in range(4):
        shape: Any = Sphere(0.1) if rng.uniform() < 0.5 else Capsule(0.05, 0.2)
        body = jo.RigidBody(
            "b", 1.0, (0.004, 0.005, 0.006), position=(0, 0, 0.3), velocity=rng.normal(size=3),
            angular_velocity=10 * rng.normal(size=3),
        )  # fmt: skip
        contact = Contact(
            "c", jo.ground["origin"], HalfSpace(), body["origin"], shape,
            PowerLaw(1e6, restitution=rng.uniform(0.3, 1.0)), mu_kinetic=0.3,
            rolling=5e-3, drilling=1e-2,
        )  # fmt: skip
        model = jo.compile(jo.Mechanism(body, contact, jo.Gravity((0, 0, -G))))
        run = jo.simulate(model, 2.0, solver=solver)
        energy = run.energy.kinetic + run.energy.potential
        assert np.diff(run.energy.dissipated).min() > -1e-9 * np.ptp(energy)
        assert np.abs(run.energy.error).max() < error * np.ptp(energy)


def test_what_is_refused():
    body = jo.RigidBody("b", 1.0, (0.1,) * 3, position=(0, 0, 1))
    at = (jo.ground["origin"], Cuboid((1, 1, 1)), body["origin"], Cuboid((1, 1, 1)))
    with pytest.raises(jo.InputError, match="touch at corners.*leave out rolling"):
        Contact("c", *at, PowerLaw(1e6, 1.0), rolling=0.01)
    at = (jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.1))
    with pytest.raises(jo.InputError, match="an impulse has no moment that resists drilling"):
        Contact("c", *at, PowerLaw(1e6, 1.0), drilling=0.01, resolve="impulse")
    with pytest.raises(jo.InputError, match="rolling.*-1"):
        Contact("c", *at, PowerLaw(1e6, 1.0), rolling=-1.0)


# -- in sets --------------------------------------------------------------------------------------


@pytest.mark.parametrize("core", CORES)
@pytest.mark.parametrize("solver", SOLVERS, ids=name_of)
@pytest.mark.parametrize("smooth", [False, True], ids=["bristle", "smooth"])
def test_a_set_moves_as_one_contact_a_pair(solver, core, smooth):
    """Two balls with lengths of their surfaces, and a box beside them, on one floor."""
    lengths = ((2e-3, 4e-3), (0.0, 1e-3))
    friction = Regularised(0.05) if smooth else None
    balls = [
        jo.RigidBody(
            f"b{i}",
            1.0,
            (0.004,) * 3,
            position=(0.5 * i, 0, R - 1e-5),
            velocity=(0.5, 0, 0),
            angular_velocity=(0, 5, 10.0),
        )  # fmt: skip
        for i in range(2)
    ]
    box = jo.RigidBody("box", 1.0, (0.01,) * 3, position=(0, 1, 0.05))
    law, ends = PowerLaw(1e8), []
    floor = CollisionShape("floor", jo.ground["origin"], HalfSpace(), surface=Surface("floor"))
    shapes = [
        floor,
        CollisionShape("box", box["origin"], Cuboid((0.1, 0.1, 0.1)), surface=Surface("box")),
    ]
    shapes += [
        CollisionShape(
            one.name,
            one["origin"],
            Sphere(R),
            surface=Surface(one.name, mu_kinetic=0.4, rolling=l[0]),
        )
        for one, l in zip(balls, lengths, strict=True)
    ]
    pairs = [
        SurfacePair("floor", one.name, mu_kinetic=0.4, drilling=l[1])
        for one, l in zip(balls, lengths, strict=True)
    ]
    single: list[Any] = [
        Contact(
            one.name,
            jo.ground["origin"],
            HalfSpace(),
            one["origin"],
            Sphere(R),
            law,
            mu_kinetic=0.4,
            rolling=l[0],
            drilling=l[1],
            friction=friction,
        )  # fmt: skip
        for one, l in zip(balls, lengths, strict=True)
    ]
    single.append(
        Contact(
            "box", jo.ground["origin"], HalfSpace(), box["origin"], Cuboid((0.1, 0.1, 0.1)), law
        )
    )
    whole = Contacts("c", shapes, law=law, pairs=pairs, friction=friction, overlap="start")
    assert "rolling 0.002 m, drilling 0.004 m" in str(whole.laws["floor", "b0"])
    sensors = [jo.AngularVelocitySensor(f"w{i}", one["origin"]) for i, one in enumerate(balls)]
    for touch in (single, [whole]):
        gravity = jo.Gravity((0, 0, -G))
        model = jo.compile(jo.Mechanism(*balls, box, *touch, gravity, *sensors), core=core)
        run = jo.simulate(model, 0.3, solver=solver)
        ends.append(np.concatenate([run[f"w{i}"][-1] for i in range(2)]))
        assert abs(run.energy.error).max() < 1e-3
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)
    assert 0 < ends[0][5] - ends[0][2]  # the second one spins on
