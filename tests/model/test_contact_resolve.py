"""Touches by impulses: closed forms, joints, closed contacts, friction, bounded work, reports."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    CollisionShape,
    Contact,
    Contacts,
    Cuboid,
    ForceStateSensor,
    HalfSpace,
    PowerLaw,
    Sphere,
    SpringDamper,
)

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely", "ignore:.*energy balance")
G = 9.81
CORES = ("maximal", "joint")
ORIGIN = jo.ground["origin"]


def methods(step: float) -> list[Any]:
    adaptive = jo.simulation.DormandPrince(tolerance=1e-10)
    return [jo.RK4(step), jo.ROS2(step), jo.GeneralizedAlpha(step), adaptive]


def named(solver: Any) -> str:
    return type(solver).__name__


def balance(run: Any) -> Any:
    """Energy that is there, less what came in, J."""
    energy = run.energy
    return energy.total + energy.dissipated + energy.friction - energy.work


@pytest.mark.parametrize("solver", methods(1e-3), ids=named)
@pytest.mark.parametrize("core", CORES)
def test_a_shot_at_a_free_plate(solver, core):
    """v1 = (m1 - e m2) v / (m1 + m2), and the plate moves on; the step is 20 flights through it."""
    shot = jo.RigidBody("s", 0.01, (1e-7,) * 3, position=(-0.237, 0, 0), velocity=(100, 0, 0))
    plate = jo.RigidBody("p", 1.0, (0.1,) * 3)
    contact = Contact(
        "c",
        plate["origin"],
        Cuboid((2e-3, 1, 1)),
        shot["origin"],
        Sphere(5e-3),
        PowerLaw(1e9, restitution=0.6),
        resolve="impulse",
    )
    sensors = [
        *(jo.VelocitySensor(f"v{b.name}", b["origin"]) for b in (shot, plate)),
        *(jo.PositionSensor(f"x{b.name}", b["origin"]) for b in (shot, plate)),
        ForceStateSensor("since", contact, "since"),
    ]
    model = jo.compile(jo.Mechanism(shot, plate, contact, *sensors), core=core)
    run = jo.simulate(model, 0.01, solver=solver)
    assert run["since"][-1, 0] == pytest.approx(2.31e-3, rel=1e-9)
    assert run["vs"][-1, 0] == pytest.approx(-59 / 1.01, rel=1e-12)
    assert run["vp"][-1, 0] == pytest.approx(1.6 / 1.01, rel=1e-12)
    assert run["xp"][-1, 0] - run["xs"][-1, 0] == pytest.approx(0.4674, rel=1e-8)
    (event,) = run.events
    assert (event.name, event.change) == ("c", "closes")
    assert event.impulse == pytest.approx(1.58415841584, rel=1e-11)
    assert np.ptp(balance(run)) < 1e-12 * 50
    assert run.attributes["contacts"] == "missed: 0 (proven)"


@pytest.mark.parametrize("solver", methods(5e-3), ids=named)
@pytest.mark.parametrize("core", CORES)
def test_a_rod_on_a_hinge_strikes_a_pin(solver, core):
    """The hinge takes part of the impulse: the rate jumps to -e of it, L = (1 + e) J w / arm."""
    inertia = 2.0 * 0.4**2 / 12
    rod = jo.RigidBody(
        "rod", 2.0, (1e-3, inertia, inertia), angular_velocity=(0, 0, 300), center=(0.2, 0, 0)
    )
    hinge = jo.Revolute("h", ORIGIN, rod["origin"], axis=(0, 0, 1))
    contact = Contact(
        "c",
        rod.at((0.2, 0, 0)),
        Cuboid((0.4, 0.01, 0.1)),
        jo.ground.at((0.21, 0.15, 0)),
        Sphere(0.002),
        PowerLaw(1e9, restitution=0.5),
        resolve="impulse",
    )
    sensors = (
        ForceStateSensor("since", contact, "since"),
        jo.CoordinateSensor("q", hinge.angle),
        jo.RateSensor("w", hinge.angle),
    )
    model = jo.compile(jo.Mechanism(rod, hinge, contact, *sensors), core=core)
    run = jo.simulate(model, 5e-3, solver=solver)
    # the face of the rod reaches the pin at asin(.007 / |pin|) below the angle of its centre
    touch, arm = 1.977072365899e-3, 0.2579748049713
    assert run["since"][-1, 0] == pytest.approx(touch, abs=2e-12)
    assert run["q"][-1, 0] == pytest.approx(0.1396825646548, abs=1e-9)
    assert run["w"][-1, 0] == pytest.approx(-150.0, rel=1e-12)
    total = inertia + 2.0 * 0.2**2
    assert run.events[0].impulse == pytest.approx(1.5 * total * 300 / arm, rel=1e-11)


def bouncing(solver: Any, slowest: float = 1e-3) -> Any:
    ball = jo.RigidBody.sphere("ball", radius=0.05, mass=0.1, position=(0, 0, 0.55))
    law = PowerLaw(1e9, restitution=0.7, slowest=slowest)
    contact = Contact(
        "c", ORIGIN, HalfSpace(), ball["origin"], Sphere(0.05), law, resolve="impulse"
    )
    sensors = (
        ForceStateSensor("phase", contact, "phase"),
        ForceStateSensor("since", contact, "since"),
        jo.VelocitySensor("v", ball["origin"]),
        jo.PositionSensor("x", ball["origin"]),
    )
    model = jo.compile(jo.Mechanism(ball, contact, jo.Gravity((0, 0, -G)), *sensors))
    return jo.simulate(model, 2.5, solver=solver)


@pytest.mark.parametrize("solver", methods(2e-3)[:3], ids=named)
def test_bounces_end_at_rest(solver):
    """Touches form a geometric series that ends at sqrt(2 h / g) (1 + e) / (1 - e)."""
    run = bouncing(solver)
    assert len(run.events) == 23  # above 1 mm/s
    speeds = np.sqrt(2 * G * 0.5) * 0.7 ** np.arange(23)
    assert [e.impulse for e in run.events] == pytest.approx(0.17 * speeds, rel=1e-6)
    assert run["phase"][-1, 0] == 1
    assert abs(run["v"][-1, 2]) < 1e-9
    static = (0.1 * G / 1e9) ** (2 / 3)
    assert run["x"][-1, 2] - 0.05 == pytest.approx(-static, rel=1e-6)
    slower = bouncing(solver, 1e-4)
    assert slower["since"][-1, 0] == pytest.approx(1.80922742764, abs=1e-4)


@pytest.mark.parametrize("step", [1e-3, 2e-4])
def test_bounces_in_steps_of_bounded_work(step):
    """No step is shortened or repeated: impulses to 1e-6 of the series, then rest at once."""
    run = bouncing(jo.ROS2(step, events="step"))
    count = int(np.log(2.5 * step * G / np.sqrt(2 * G * 0.5)) / np.log(0.7))
    speeds = np.sqrt(2 * G * 0.5) * 0.7 ** np.arange(count)
    assert [e.impulse for e in run.events[:count]] == pytest.approx(0.17 * speeds, rel=1e-6)
    assert run["phase"][-1, 0] == 1
    assert abs(run["v"][-1, 2]) < 1e-12
    assert run["x"][-1, 2] - 0.05 == pytest.approx(-((0.1 * G / 1e9) ** (2 / 3)), rel=1e-6)
    assert np.diff(run.energy.total).max() < 1e-9 * 0.5
    assert run.attributes["deferred"] == 0


def block(contact_of: Any, mu: float, speed: Any, solver: Any, core: str, n: int = 1) -> Any:
    blocks = [
        jo.RigidBody(f"b{i}", 1.0, (0.01, 0.012, 0.015), position=(0, 0, 0.06 + 0.1 * i))
        for i in range(n)
    ]
    blocks[-1] = jo.RigidBody(
        f"b{n - 1}",
        1.0,
        (0.01, 0.012, 0.015),
        position=(0, 0, 0.06 + 0.1 * (n - 1)),
        velocity=speed,
    )
    sensors = [jo.VelocitySensor(f"v{i}", b["origin"]) for i, b in enumerate(blocks)]
    turns = jo.AngularVelocitySensor("w", blocks[-1]["origin"])
    contact = contact_of(blocks[-1], mu)
    model = jo.compile(jo.Mechanism(*blocks, contact, *sensors, turns), core=core)
    return jo.simulate(model, 0.05, solver=solver)


def tips(body: Any, mu: float) -> Any:
    return Contact(
        "c",
        ORIGIN,
        HalfSpace(),
        body["origin"],
        Cuboid((0.4, 0.4, 0.1)),
        PowerLaw(1e8, 1.0, restitution=0.5),
        mu_kinetic=mu,
        resolve="impulse",
    )


def faces(body: Any, mu: float) -> Any:
    return Contact(
        "c",
        jo.ground.at((0, 0, -0.05)),
        Cuboid((1, 1, 0.1)),
        body["origin"],
        Cuboid((0.4, 0.4, 0.1)),
        PowerLaw(1e8, 1.0, restitution=0.5),
        mu_kinetic=mu,
        resolve="impulse",
    )


def found(body: Any, mu: float) -> Any:
    shapes = [
        CollisionShape("floor", ORIGIN, HalfSpace()),
        CollisionShape("block", body["origin"], Cuboid((0.4, 0.4, 0.1))),
    ]
    law = PowerLaw(1e8, 1.0, restitution=0.5)
    return Contacts("c", shapes, law=law, mu_kinetic=mu, resolve="impulse")


@pytest.mark.parametrize("contact", [tips, faces, found])
@pytest.mark.parametrize("core", CORES)
def test_a_block_lands_on_four_corners_at_once(contact, core):
    """Redundant rows: the velocity after it is unique, and the block does not turn."""
    run = block(contact, 0.0, (0, 0, -2), jo.RK4(1e-3), core)
    assert run["v0"][-1] == pytest.approx([0, 0, 1.0], abs=1e-12)
    assert np.abs(run["w"]).max() < 1e-11
    assert sum(e.impulse for e in run.events) == pytest.approx(3.0, rel=1e-9)


@pytest.mark.parametrize("heading", [0.0, 20.0, 45.0])
def test_friction_in_an_impact_is_a_circle(heading):
    """A ball that slips through the impact loses mu (1 + e) v along its line, else it rolls."""
    c, s = np.cos(np.radians(heading)), np.sin(np.radians(heading))
    for speed, mu in ((3.0, 0.1), (0.5, 0.4)):
        inertia = 0.4 * 0.1**2
        ball = jo.RigidBody(
            "b", 1.0, (inertia,) * 3, position=(0, 0, 0.11), velocity=(speed * c, speed * s, -1)
        )
        contact = Contact(
            "c",
            ORIGIN,
            HalfSpace(),
            ball["origin"],
            Sphere(0.1),
            PowerLaw(1e9, restitution=0.8),
            mu_kinetic=mu,
            resolve="impulse",
        )
        sensors = [
            jo.VelocitySensor("v", ball["origin"]),
            jo.AngularVelocitySensor("w", ball["origin"]),
        ]
        run = jo.simulate(
            jo.compile(jo.Mechanism(ball, contact, *sensors)), 0.02, solver=jo.RK4(1e-3)
        )
        v = run["v"][-1]
        along = c * v[0] + s * v[1]
        lost = min(mu * 1.8, 2 / 7 * speed)  # until it rolls: 2/7 of the speed for a solid ball
        assert along == pytest.approx(speed - lost, rel=1e-9)
        assert abs(s * v[0] - c * v[1]) < 1e-12
        assert v[2] == pytest.approx(0.8, rel=1e-12)
        assert np.ptp(balance(run)) < 1e-12


def test_a_closed_contact_takes_part():
    """A ball rests on the floor; another one that strikes it bounces as from the floor."""
    balls = [
        jo.RigidBody.sphere(f"b{i}", radius=0.05, mass=1.0, position=(0, 0, z), velocity=(0, 0, v))
        for i, (z, v) in enumerate(((0.05 - (G / 1e8), 0.0), (0.16, -2.0)))
    ]
    law = PowerLaw(1e8, 1.0, restitution=0.5)
    contacts = [
        Contact(
            "floor", ORIGIN, HalfSpace(), balls[0]["origin"], Sphere(0.05), law, resolve="impulse"
        ),
        Contact(
            "c",
            balls[0]["origin"],
            Sphere(0.05),
            balls[1]["origin"],
            Sphere(0.05),
            law,
            resolve="impulse",
        ),
    ]
    sensors = [jo.VelocitySensor(f"v{i}", b["origin"]) for i, b in enumerate(balls)]
    pull = jo.Force("pull", balls[0]["origin"], (0, 0, -G))
    model = jo.compile(jo.Mechanism(*balls, *contacts, pull, *sensors))
    run = jo.simulate(model, 0.02, solver=jo.RK4(1e-3))
    assert run["v1"][-1, 2] == pytest.approx(1.0, rel=1e-9)
    assert abs(run["v0"][-1, 2]) < 1e-9


def test_energy_never_grows_in_random_collisions():
    """Boxes that fall on edges and corners with friction and any restitution."""
    rng = np.random.default_rng(7)
    for _ in range(12):
        turn = rng.normal(size=4)
        box = jo.RigidBody(
            "b",
            1.0,
            (0.01, 0.012, 0.015),
            position=(0, 0, 0.4),
            orientation=turn / np.linalg.norm(turn),
            velocity=rng.normal(size=3) * 2,
            angular_velocity=rng.normal(size=3) * 5,
        )
        contact = Contact(
            "c",
            ORIGIN,
            HalfSpace(),
            box["origin"],
            Cuboid((0.4, 0.3, 0.2)),
            PowerLaw(1e7, restitution=rng.uniform(0.1, 1.0)),
            mu_kinetic=rng.uniform(0, 1.5),
            resolve="impulse",
        )
        model = jo.compile(jo.Mechanism(box, contact, jo.Gravity((0, 0, -G))))
        run = jo.simulate(model, 0.8, solver=jo.RK4(1e-3))
        assert len(run.events) > 0
        # slow touches have the law, whose bristle stores energy when its slip turns
        assert np.diff(run.energy.total).max() < 1e-4 * run.energy.total[0]
        assert np.ptp(balance(run)) < 1e-4 * run.energy.total[0]


def test_what_is_refused():
    body = jo.RigidBody.sphere("ball", radius=0.1, mass=1.0, position=(0, 0, 0.2))
    at = (ORIGIN, HalfSpace(), body["origin"], Sphere(0.1))
    with pytest.raises(jo.InputError, match="needs a law with a restitution, not SpringDamper"):
        Contact("c", *at, SpringDamper(1e6), resolve="impulse")
    with pytest.raises(jo.InputError, match="resolve"):
        Contact("c", *at, PowerLaw(1e6), resolve="bounce")
    for how, solver in (
        ("cut", jo.ROS2(1e-3, events="step")),
        ("impulse", jo.RK4(1e-3, events="step")),
    ):
        model = jo.compile(jo.Mechanism(body, Contact("c", *at, PowerLaw(1e6), resolve=how)))
        with pytest.raises(jo.InputError, match='take resolve="impulse" of the contact and ROS2'):
            jo.simulate(model, 0.1, solver=solver)


def test_a_flight_through_a_plate_in_bounded_work_is_reported():
    shot = jo.RigidBody("s", 0.01, (1e-7,) * 3, position=(-0.237, 0, 0), velocity=(100, 0, 0))
    contact = Contact(
        "plate",
        ORIGIN,
        Cuboid((2e-3, 1, 1)),
        shot["origin"],
        Sphere(5e-3),
        PowerLaw(1e9),
        resolve="impulse",
    )
    model = jo.compile(jo.Mechanism(shot, contact))
    run = jo.simulate(model, 0.01, solver=jo.ROS2(1e-3, events="step"))
    assert run.attributes["contacts"].startswith("unproven: 1, 'plate' at 0.003 s")


def test_report_lists_the_touches_that_are_too_short():
    """Of pi sqrt(m / K), m: least mass of a ball that a force can meet, 1 / (1 + 5/2) kg."""
    counts = {}
    for step in (1e-3, 5e-6):
        ball = jo.RigidBody.sphere(
            "ball", radius=0.1, mass=1.0, position=(0, 0, 0.2), velocity=(0, 0, -5)
        )
        law = PowerLaw(1e9, 1.0, restitution=0.8)
        contact = Contact(
            "hit", ORIGIN, HalfSpace(), ball["origin"], Sphere(0.1), law, resolve="report"
        )
        model = jo.compile(jo.Mechanism(ball, contact))
        run = jo.simulate(model, 0.03, solver=jo.GeneralizedAlpha(step))
        counts[step] = run.attributes["short touches"]
    assert counts[1e-3] == (
        "1: 'hit' at 0.02 s lasts 0.0531 ms; take a smaller step, or resolve='cut'"
    )
    assert counts[5e-6] == "none"
