"""Contact of two shapes: closed forms and published numbers, tangents, energy, nothing missed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    Bore,
    Capsule,
    Contact,
    Cuboid,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Hertz,
    HollowSphere,
    Impact,
    PowerLaw,
    Sphere,
    SpringDamper,
    Torus,
)
from jousto.mechanism.contacts.laws import damping_of

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")

G = 9.81
PAIRS = [
    (HalfSpace(), Sphere(0.1)),
    (Sphere(0.2), Sphere(0.1)),
    (HollowSphere(0.5), Sphere(0.1)),
    (Capsule(0.1, 0.4), Sphere(0.1)),
    (Cuboid((0.3, 0.4, 0.5)), Sphere(0.1)),
    (Cylinder(0.2, 0.5), Sphere(0.1)),
    (Bore(0.3), Sphere(0.1)),
    (Torus(0.3, 0.1), Sphere(0.1)),
    (Ellipsoid((0.3, 0.5, 0.8)), Sphere(0.1)),
    (HalfSpace(), Torus(0.3, 0.1)),
    (HalfSpace(), Cuboid((0.3, 0.4, 0.5))),
    (HalfSpace(), Capsule(0.1, 0.4)),
    (HalfSpace(), Cylinder(0.2, 0.3)),
    (HalfSpace(), Ellipsoid((0.3, 0.5, 0.8))),
]


def named(pair: tuple[Any, Any]) -> str:
    return " ".join(type(one).__name__ for one in pair)


def ball(gap: float, speed: float = 0.0, mass: float = 1.0, r: float = 0.05, **more: Any) -> Any:
    inertia = (0.4 * mass * r * r,) * 3
    return jo.RigidBody(
        "ball", mass, inertia, position=(0, 0, r + gap), velocity=(0, 0, -speed), **more
    )


def drop(law: Any, gap: float, speed: float, mass: float, r: float, solver: Any, t: float) -> Any:
    body = ball(gap, speed, mass, r)
    contact = Contact("c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(r), law)
    sensors = (jo.VelocitySensor("v", body["origin"]), jo.PositionSensor("p", body["origin"]))
    return jo.simulate(jo.compile(jo.Mechanism(body, contact, *sensors)), t, solver=solver)


@pytest.mark.parametrize(
    ("e", "u"), [(0.3, 3.087081981), (0.5, 1.432750533), (0.8, 0.3731462034), (0.9, 0.1664819507)]
)
def test_damping_for_a_restitution(e, u):
    assert damping_of(e) == pytest.approx(u, rel=1e-9)


@pytest.mark.parametrize("e", [0.01, 0.1, 0.7, 0.999, 0.999999])
def test_damping_solves_its_equation(e):
    u = damping_of(e)
    if e > 0.05:  # below, 1 - e u is less than rounding
        assert u * (1 + e) == pytest.approx(np.log((1 + u) / (1 - e * u)), rel=1e-7)
    assert 0 < u < 1 / e * (1 + 1e-15)


# -- the normal force -----------------------------------------------------------------------------


def test_elastic_steel_ball_of_hertz():
    """Ball of 10 mm radius at 1 m/s: depth, force and duration in closed form."""
    steel = jo.Material(210e9, 0.3, 7850.0)
    r = 0.01
    m = 7850 * 4 / 3 * np.pi * r**3
    law = Hertz.between(steel, restitution=1.0)
    run = drop(law, 0.0, 1.0, m, r, jo.RK4(2e-8), 7.2e-5)
    depth = r - run["p"][:, 2]
    assert depth.max() == pytest.approx(2.348078729e-5, rel=1e-8)
    assert run["v"][-1, 2] == pytest.approx(1.0, rel=1e-10)
    end = run.time[np.argmax((depth < 0) & (run.time > 1e-5))]
    assert end == pytest.approx(6.911041853e-5, abs=2e-8)


@pytest.mark.parametrize("e", [0.1, 0.3, 0.5, 0.8, 0.95])
@pytest.mark.parametrize("n", [1.0, 1.5, 2.2])
def test_restitution_is_what_was_asked_for(e, n):
    """For other stiffness, exponent, mass and speed, with a step longer than the contact."""
    stiffness = {1.0: 3e5, 1.5: 1e8, 2.2: 1e11}[n]
    run = drop(PowerLaw(stiffness, n, restitution=e), 0.01, 2.0, 0.7, 0.05, jo.RK4(1e-3), 0.06)
    assert run["v"][-1, 2] / 2.0 == pytest.approx(e, rel=4e-5)


def test_depth_of_hunt_and_crossley():
    law = PowerLaw(1e8, restitution=0.5)
    run = drop(law, 0.0, 2.0, 1.0, 0.05, jo.RK4(1e-6), 2.1e-3)
    assert 0.05 - run["p"][:, 2].min() == pytest.approx(9.315715552e-4, rel=1e-6)
    assert run["v"][-1, 2] == pytest.approx(1.0, rel=1e-8)
    contact = 0.05 - run["p"][:, 2] > 0
    assert run.time[contact][-1] == pytest.approx(1.979364737e-3, abs=1e-6)


def test_impact_law_of_other_programs():
    """1 kg at 1 m/s with the usual numbers, 1e5 N/mm^2.2 and 10 N s/mm."""
    law = Impact(1e5 * 1000**2.2, 2.2, 1e4, 1e-4)
    run = drop(law, 0.0, 1.0, 1.0, 0.05, jo.RK4(2e-7), 1e-3)
    assert 0.05 - run["p"][:, 2].min() == pytest.approx(1.303182986e-4, rel=1e-6)
    assert run["v"][-1, 2] == pytest.approx(0.08739696763, rel=1e-5)


@pytest.mark.parametrize(
    ("z", "e"), [(0.05, 0.8587581018), (0.1, 0.7440793977), (0.5, 0.2984360592)]
)
def test_spring_and_damper(z, e):
    law = SpringDamper(1e6, 2 * z * np.sqrt(1e6 * 0.5))
    run = drop(law, 1e-3, 1.0, 0.5, 0.05, jo.RK4(1e-5), 0.02)
    assert run["v"][-1, 2] == pytest.approx(e, rel=1e-6)


def test_cradle_of_three_touching_balls():
    r, K = 0.02, 1e9
    balls = [
        jo.RigidBody(f"b{i}", 1.0, (1e-3,) * 3, position=(2 * r * i, 0, 0), velocity=(i == 0, 0, 0))
        for i in range(3)
    ]
    law = PowerLaw(K, restitution=1.0)
    touch = [
        Contact(f"c{i}", balls[i]["origin"], Sphere(r), balls[i + 1]["origin"], Sphere(r), law)
        for i in range(2)
    ]
    sensors = [jo.VelocitySensor(f"v{i}", balls[i]["origin"]) for i in range(3)]
    model = jo.compile(jo.Mechanism(*balls, *touch, *sensors))
    run = jo.simulate(model, 2e-3, solver=jo.simulation.DormandPrince(tolerance=1e-11))
    v = [run[f"v{i}"][-1, 0] for i in range(3)]
    assert v == pytest.approx([-0.07095235365, 0.07640303907, 0.9945493146], abs=1e-9)
    assert sum(v) == pytest.approx(1.0, abs=1e-14)


@pytest.mark.parametrize("pair", PAIRS, ids=named)
@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_tangent_is_the_derivative(pair, mu):
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
        law = PowerLaw(1e4, restitution=0.7)
        contact = Contact("c", a["origin"], pair[0], b["origin"], pair[1], law, mu_kinetic=mu)
        engine = jo.model.Engine(jo.compile(jo.Mechanism(a, b, contact)))
        phase = np.array(engine.states)[::6]
        if not phase.any() or (mu and (phase == 1).any()):
            continue  # a bristle that sticks is moved by its states
        engine.accelerations()
        exact = engine.tangent()
        for M, weights in ((exact.K, (0.0, 0.0, 1.0)), (exact.D, (0.0, 1.0, 0.0))):
            N = engine.newton_matrix(*weights)[: len(M), : len(M)]
            assert np.abs(M - N).max() <= 1e-12 * np.abs(M).max()
        found += 1
    assert found > 5


def ellipsoid_distance(x: Any, a: Any) -> tuple[float, Any]:
    """Signed distance and normal by bisection with long numbers."""
    x, a = np.abs(np.asarray(x, dtype=np.longdouble)), np.asarray(a, dtype=np.longdouble)
    low = (a * (x - a)).max()
    high = np.linalg.norm(a * x) + 1
    for _ in range(200):
        t = (low + high) / 2
        low, high = (t, high) if (((a * x) / (t + a * a)) ** 2).sum() > 1 else (low, t)
    g = x / (a * a + low)
    return float(low * np.linalg.norm(g)), np.asarray(g / np.linalg.norm(g), dtype=float)


@pytest.mark.parametrize("lengths", [(0.3, 0.5, 0.8), (0.8, 0.3, 0.3), (0.01, 1.0, 1.0), (1, 1, 1)])
def test_distance_from_an_ellipsoid(lengths):
    """Depth and normal of spheres anywhere, inside too, by the force of a linear law: 1e-14."""
    rng = np.random.default_rng(4)
    half = 0.5 * np.array(lengths)
    for _ in range(50):
        u = rng.normal(size=3)
        place = half * u / np.linalg.norm(u) * rng.uniform(0.6, 1.3)
        gap, normal = ellipsoid_distance(place, half)
        r = max(gap, 0.0) + 0.1
        body = jo.RigidBody("b", 1.0, (1, 1, 1), position=place)
        law = PowerLaw(1.0, 1.0, restitution=1.0)
        items = (jo.ground["origin"], Ellipsoid(lengths), body["origin"], Sphere(r))
        engine = jo.model.Engine(jo.compile(jo.Mechanism(body, Contact("c", *items, law))))
        force = np.array(engine.accelerations()[0])[:3]
        assert np.linalg.norm(force) == pytest.approx(r - gap, abs=1e-14)
        assert np.abs(force / (r - gap) - normal * np.sign(place)).max() < 1e-13


# -- friction -------------------------------------------------------------------------------------


def incline(
    angle: float, v: float, mu_s: float, mu_k: float, solver: Any, t: float, core: str = "auto",
    K: float = 1e7,
) -> Any:  # fmt: skip
    """A flat block of 1 kg on a ramp; x points up the ramp."""
    turn = np.radians(angle)
    sunk = G * np.cos(turn) / (4 * K)
    body = jo.RigidBody(
        "block", 1.0, (0.01, 0.012, 0.015), position=(0, 0, 0.05 - sunk), velocity=(v, 0, 0)
    )
    contact = Contact(
        "c", jo.ground["origin"], HalfSpace(), body["origin"], Cuboid((0.4, 0.4, 0.1)),
        PowerLaw(K, 1.0), mu_kinetic=mu_k, mu_static=mu_s,
    )  # fmt: skip
    gravity = jo.Gravity((-G * np.sin(turn), 0, -G * np.cos(turn)))
    x, speed = jo.PositionSensor("x", body["origin"]), jo.VelocitySensor("v", body["origin"])
    model = jo.compile(jo.Mechanism(body, contact, gravity, x, speed), core=core)
    return jo.simulate(model, t, solver=solver)


def test_block_on_a_ramp_stops_and_stays():
    """Up at 3 m/s on 15 degrees, mu 0.4 and 0.3: stops after 0.836 m, then it does not creep."""
    run = incline(15.0, 3.0, 0.4, 0.3, jo.RK4(5e-5), 1.0)
    assert run["x"][:, 0].max() == pytest.approx(0.8361616440, rel=1e-8)
    assert np.abs(run["v"][-1]).max() < 1e-12
    exchanged = 4.5
    assert np.abs(run.energy.error).max() < 1e-9 * exchanged


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_block_at_rest_does_not_creep(core):
    """1000 s on 15 degrees with steps of 10 ms: it does not move, to rounding."""
    run = incline(15.0, 0.0, 0.4, 0.4, jo.GeneralizedAlpha(1e-2), 1000.0, core)
    settled = run["x"][run.time > 1.0, 0]
    assert np.ptp(settled) < 1e-12
    assert abs(run["v"][-1, 0]) < 1e-12


@pytest.mark.parametrize("K", [1e7, 1e9, 1e11])
def test_block_slides_back_down_a_steeper_ramp(K):
    """25 degrees: it passes its start again after 1.3855 s, the sooner the softer the bristle."""
    run = incline(25.0, 3.0, 0.4, 0.3, jo.GeneralizedAlpha(2e-4), 1.5, K=K)
    x, t = run["x"][:, 0], run.time
    i = np.argmax((x < 0) & (t > 0.5))
    back = t[i - 1] + (t[i] - t[i - 1]) * x[i - 1] / (x[i - 1] - x[i])
    assert 0 < 1.385514397 - back < 2.0 / np.sqrt(K)


@pytest.mark.parametrize("heading", [0.0, 20.0, 45.0, 71.0])
def test_thrown_point_keeps_its_line(heading):
    """Friction is a circle: 2 m/s, mu 0.4 stop after v^2 / 2 mu g in every direction."""
    e = np.array([np.cos(np.radians(heading)), np.sin(np.radians(heading)), 0.0])
    K = 4e7
    body = jo.RigidBody("p", 1.0, (0.01,) * 3, position=(0, 0, -G / K), velocity=2 * e)
    law = PowerLaw(K, 1.0)
    contact = Contact(
        "c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.0), law, mu_kinetic=0.4
    )
    mechanism = jo.Mechanism(
        body, contact, jo.Gravity((0, 0, -G)), jo.PositionSensor("x", body["origin"])
    )
    run = jo.simulate(jo.compile(mechanism), 1.0, solver=jo.RK4(1e-4))
    x = run["x"][-1]
    assert abs(x[1] * e[0] - x[0] * e[1]) < 1e-12
    assert x @ e == pytest.approx(4 / (2 * 0.4 * G), rel=1e-5)


@pytest.mark.parametrize(
    ("share", "spin", "when", "speed"),
    [
        (0.5, 0.0, 0.5096839959, 2.0),
        (0.4, 0.0, 0.4368719965, 15 / 7),
        (0.4, -80.0, 1.601863987, -1 / 7),
    ],
    ids=["disc", "ball", "ball with spin back"],
)
def test_from_slip_to_rolling(share, spin, when, speed):
    """3 m/s, mu 0.2, inertia share m R^2: when it begins to roll, and how fast."""
    R, K = 0.1, 1e10
    sunk = (G / K) ** (1 / 1.5)
    body = jo.RigidBody(
        "b", 1.0, (share * R * R,) * 3, position=(0, 0, R - sunk), velocity=(3, 0, 0),
        angular_velocity=(0, spin, 0),
    )  # fmt: skip
    law = PowerLaw(K)
    contact = Contact(
        "c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(R), law, mu_kinetic=0.2
    )
    sensors = (
        jo.VelocitySensor("v", body["origin"]),
        jo.AngularVelocitySensor("w", body["origin"]),
        jo.mechanism.ForceStateSensor("phase", contact, "phase"),
    )
    model = jo.compile(jo.Mechanism(body, contact, jo.Gravity((0, 0, -G)), *sensors))
    run = jo.simulate(model, when + 0.1, solver=jo.GeneralizedAlpha(1e-4))
    rolls = run.time[np.argmax(run["phase"][:, 0] == 1)]
    assert rolls == pytest.approx(when, abs=2e-4)
    assert run["v"][-1, 0] == pytest.approx(speed, rel=1e-4)
    lever = R - 0.5 * sunk  # the common point lies in the middle of the overlap
    assert abs(run["v"][-1, 0] - lever * run["w"][-1, 1]) < 1e-12


# -- nothing missed -------------------------------------------------------------------------------


@pytest.mark.parametrize("step", [1e-3, 5e-3])
def test_shot_through_a_thin_plate(step):
    """100 m/s at a free plate of 2 mm: the whole flight through it is shorter than a step."""
    shot = jo.RigidBody("s", 0.01, (1e-7,) * 3, position=(-0.237, 0, 0), velocity=(100, 0, 0))
    plate = jo.RigidBody("p", 1.0, (0.1,) * 3)
    contact = Contact(
        "c", plate["origin"], Cuboid((2e-3, 1, 1)), shot["origin"], Sphere(5e-3),
        PowerLaw(1e9, restitution=0.6),
    )  # fmt: skip
    sensors = (jo.VelocitySensor("v", shot["origin"]), jo.VelocitySensor("V", plate["origin"]))
    touched = jo.mechanism.ForceStateSensor("since", contact, "since")
    model = jo.compile(jo.Mechanism(shot, plate, contact, touched, *sensors))
    run = jo.simulate(model, 0.01, solver=jo.RK4(step))
    assert run["since"][-1, 0] == pytest.approx(2.31e-3, rel=1e-9)
    assert run["v"][-1, 0] == pytest.approx(-58.4158415842, rel=1e-5)
    assert run["V"][-1, 0] == pytest.approx(1.58415841584, rel=1e-5)


@pytest.mark.parametrize("step", [1e-3, 5e-3, 1e-2])
def test_graze_of_an_edge(step):
    """A ball of 20 mm at 40 m/s, its centre 19.99 mm above an edge, and one 20.01 mm above."""
    for offset, touches in ((0.01999, True), (0.02001, False)):
        body = jo.RigidBody("s", 1.0, (1e-4,) * 3, position=(-0.5, 0, offset), velocity=(40, 0, 0))
        contact = Contact(
            "c", jo.ground.at((0.1, 0, -0.1)), Cuboid((0.2, 1, 0.2)), body["origin"], Sphere(0.02),
            PowerLaw(1e9, restitution=1.0),
        )  # fmt: skip
        sensors = [jo.mechanism.ForceStateSensor(k, contact, k) for k in ("approach", "since")]
        model = jo.compile(jo.Mechanism(body, contact, *sensors))
        run = jo.simulate(model, 0.03, solver=jo.RK4(step))
        assert (run["since"][-1, 0] > 0) == touches
        if touches:
            assert run["since"][-1, 0] == pytest.approx(0.01248419058825, rel=1e-12)
            assert run["approach"][-1, 0] == pytest.approx(1.264752940301, rel=1e-7)


def test_random_flights_miss_nothing():
    """Balls that fly past or into balls, with steps up to 1000 contact lengths."""
    rng = np.random.default_rng(2)
    r = 0.01
    for _ in range(40):
        speed, miss = rng.uniform(5, 80), rng.uniform(0, 2 * 2 * r)
        body = jo.RigidBody("s", 1.0, (1e-4,) * 3, position=(-1, miss, 0), velocity=(speed, 0, 0))
        contact = Contact(
            "c", jo.ground["origin"], Sphere(r), body["origin"], Sphere(r), PowerLaw(1e9)
        )
        since = jo.mechanism.ForceStateSensor("since", contact, "since")
        model = jo.compile(jo.Mechanism(body, contact, since))
        step = rng.uniform(1, 1000) * 2 * r / speed / 100
        run = jo.simulate(model, 2 / speed, solver=jo.RK4(step))
        assert (run["since"][-1, 0] > 0) == (miss < 2 * r), (speed, miss, step)


def test_closed_system_never_gains_energy():
    """Boxes of balls without gravity, any restitution, friction and method."""
    rng = np.random.default_rng(3)
    for solver in (jo.RK4(1e-3), jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)):
        balls = [
            jo.RigidBody(
                f"b{i}",
                1.0,
                (1e-3,) * 3,
                position=rng.uniform(-0.1, 0.1, 3) + (0.4 * i - 0.4, 0, 0),
                velocity=rng.normal(size=3),
                angular_velocity=rng.normal(size=3) * 5,
            )  # fmt: skip
            for i in range(3)
        ]
        law = PowerLaw(1e7, restitution=0.6)
        touch = [
            Contact(
                f"c{i}{k}", balls[i]["origin"], Sphere(0.1), balls[k]["origin"], Sphere(0.1), law,
                mu_kinetic=0.3,
            )  # fmt: skip
            for i in range(3) for k in range(i)
        ]  # fmt: skip
        box = [
            Contact(
                f"h{i}",
                jo.ground["origin"],
                HollowSphere(1.2),
                balls[i]["origin"],
                Sphere(0.1),
                law,
                mu_kinetic=0.3,
            )  # fmt: skip
            for i in range(3)
        ]
        run = jo.simulate(jo.compile(jo.Mechanism(*balls, *touch, *box)), 2.0, solver=solver)
        E = run.energy.kinetic + run.energy.springs
        assert E[-1] < 0.9 * E[0]
        assert np.abs(run.energy.error).max() < 0.02 * E[0]


# -- what is refused ------------------------------------------------------------------------------


def test_pairs_that_are_not_available():
    body = ball(0.1)
    with pytest.raises(jo.InputError, match="cylinder and bore cannot touch"):
        Contact(
            "c", jo.ground["origin"], Cylinder(0.1, 0.2), body["origin"], Bore(0.3), PowerLaw(1e7)
        )
    with pytest.raises(jo.InputError, match="both on 'ground'; take two bodies"):
        ground = jo.ground["origin"]
        Contact("c", ground, HalfSpace(), ground, Sphere(0.1), PowerLaw(1e7))
    with pytest.raises(jo.InputError, match="Hertz's law needs spheres"):
        Contact(
            "c", jo.ground["origin"], HalfSpace(), body["origin"], Cuboid((1, 1, 1)), Hertz(1e11)
        )
    with pytest.raises(jo.InputError, match="mu_static 0.1 is below mu_kinetic 0.3"):
        Contact(
            "c", jo.ground["origin"], HalfSpace(), body["origin"], Sphere(0.1), PowerLaw(1e7),
            mu_kinetic=0.3, mu_static=0.1,
        )  # fmt: skip


def test_shapes_in_either_order():
    """A sphere as the first shape: the same motion, and equal and opposite forces."""
    runs = []
    for swap in (False, True):
        body = ball(0.01, 1.0)
        pair = ((jo.ground["origin"], HalfSpace()), (body["origin"], Sphere(0.05)))
        (a, shape_a), (b, shape_b) = pair[::-1] if swap else pair
        contact = Contact("c", a, shape_a, b, shape_b, PowerLaw(1e7))
        model = jo.compile(jo.Mechanism(body, contact, jo.VelocitySensor("v", body["origin"])))
        runs.append(jo.simulate(model, 0.05, solver=jo.RK4(1e-3))["v"])
    assert np.array_equal(*runs)


@pytest.mark.filterwarnings("ignore:.*may jump over them")
def test_a_pulse_within_a_step_is_seen():
    """A force that moves a ball through a plate within a step and leaves it at rest.

    RK4 has the force at 0, h/2 and h: with 0, A and -4 A the velocity at the end is 0, but the
    ball has moved by h^2 A / (3 m), from one side of the plate to the other.
    """
    h = 1e-3
    A = 3 * 0.03 / h**2
    body = jo.RigidBody("b", 1.0, (1e-3,) * 3, position=(-0.02, 0, 0))
    contact = Contact(
        *("c", jo.ground["origin"], Cuboid((2e-3, 1, 1)), body["origin"], Sphere(0.005)),
        PowerLaw(1e9),
    )
    pulse = jo.Table([0, 0.5 * h, h, 1.001 * h, 1], [0, A, -4 * A, 0, 0])
    force = jo.Force("pulse", body["origin"], (1, 0, 0), signal=pulse)
    x = jo.PositionSensor("x", body["origin"])
    run = jo.simulate(jo.compile(jo.Mechanism(body, contact, force, x)), h, solver=jo.RK4(h))
    assert run["x"][-1, 0] < -0.005
    assert run.attributes["contacts"] == "missed: 0 (proven)"
    assert "0 after halving" not in run.attributes["contact steps"]


@pytest.mark.parametrize("count", [40, pytest.param(500, marks=pytest.mark.slow)])
def test_flights_of_steps_far_longer_than_a_touch(count):
    """Balls past or into balls, plates and boxes, steps of 1 to 1000 touches: none is missed."""
    rng = np.random.default_rng(11)
    r, law = 0.01, PowerLaw(1e9, restitution=0.9)
    for _ in range(count):
        speed, miss = rng.uniform(5, 80), rng.uniform(0, 4 * r)
        shape, half = [(Sphere(r), r), (Cuboid((2e-3, 2 * r, 1)), r)][int(rng.integers(2))]
        body = jo.RigidBody("s", 1.0, (1e-4,) * 3, position=(-1, miss, 0), velocity=(speed, 0, 0))
        contact = Contact("c", jo.ground["origin"], shape, body["origin"], Sphere(r), law)
        since = jo.mechanism.ForceStateSensor("since", contact, "since")
        model = jo.compile(jo.Mechanism(body, contact, since))
        touch = 2.94 * (1.25 / (1e9 * speed**0.5)) ** 0.4  # s, of 1 kg
        step = min(10 ** rng.uniform(0, 3) * touch, 1.9 / speed)
        solver = (jo.RK4, jo.ROS2, jo.GeneralizedAlpha)[int(rng.integers(3))](step)
        run = jo.simulate(model, 2 / speed, solver=solver)
        assert (run["since"][-1, 0] > 0) == (miss < half + r), (speed, miss, step)
        assert run.attributes["contacts"] == "missed: 0 (proven)"
