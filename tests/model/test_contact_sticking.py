"""Friction of contacts by rows (StickSlip): no creep, closed forms, limits, refusals, files."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.mechanism import (
    Contact,
    Cuboid,
    Cylinder,
    HalfSpace,
    PowerLaw,
    Regularised,
    Sphere,
    StickSlip,
)
from jousto.schema.read import parse_model

G, MU = 9.81, 0.4
GROUND = jo.ground["origin"]
pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
SOLVERS = [
    jo.RK4(1e-3),
    jo.ROS2(1e-3),
    jo.GeneralizedAlpha(1e-3),
    jo.simulation.DormandPrince(tolerance=1e-9),
]
IMPLICIT = [jo.ROS2(1e-3), jo.GeneralizedAlpha(1e-3)]
every_solver = pytest.mark.parametrize("solver", SOLVERS, ids=lambda s: type(s).__name__)
implicit = pytest.mark.parametrize("solver", IMPLICIT, ids=lambda s: type(s).__name__)


def direction(degrees: float) -> Any:
    return np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])


def touch(body: Any, shape: Any, K: float, n: float = 1.0, **more: Any) -> Contact:
    more = {"mu_kinetic": MU, "friction": StickSlip(), **more}
    return Contact("c", GROUND, HalfSpace(), body["origin"], shape, PowerLaw(K, n), **more)


def block(slope: float, speed: float, K: float = 1e7, low: float = 0.0, **more: Any) -> jo.Model:
    """A box on four corners on a slope, its centre of mass `low` below the middle."""
    turn = np.radians(slope)
    body = jo.RigidBody(
        "block", 1.0, (0.01, 0.012, 0.015), velocity=(speed, 0, 0), center=(0, 0, -low),
        position=(0, 0, 0.05 - G * np.cos(turn) / (4 * K)),
    )  # fmt: skip
    pull = jo.Gravity((-G * np.sin(turn), 0, -G * np.cos(turn)))
    sensors = jo.PositionSensor("x", body["origin"]), jo.VelocitySensor("v", body["origin"])
    contact = touch(body, Cuboid((0.4, 0.4, 0.1)), K, **more)
    return jo.compile(jo.Mechanism(body, contact, pull, *sensors))


def transitions(run: Any) -> list[tuple[str, str]]:
    return [(event.name, event.change) for event in run.events]


@pytest.mark.parametrize(
    ("solver", "t"),
    [
        *((solver, 20.0) for solver in (jo.ROS2(1e-2), jo.GeneralizedAlpha(1e-2))),
        pytest.param(jo.ROS2(1e-2), 1000.0, marks=pytest.mark.slow),
        pytest.param(jo.GeneralizedAlpha(1e-2), 1000.0, marks=pytest.mark.slow),
    ],
    ids=["ROS2", "alpha", "ROS2 1000 s", "alpha 1000 s"],
)
def test_a_block_does_not_creep(solver, t):
    """15 degrees, mu 0.4: it stays where it settled, to rounding; a bristle creeps by 1e-12 m."""
    run = jo.simulate(block(15.0, 0.0), t, solver=solver)
    assert np.ptp(run["x"][run.time > 1.0, 0]) < 1e-15
    assert abs(run["v"][-1, 0]) < 1e-15


@implicit
def test_a_block_goes_up_a_slope_and_stays(solver):
    """3 m/s up 15 degrees, mu 0.4 / 0.3: 0.557441096 s, 0.8361616440 m, all corners at once."""
    model = block(15.0, 3.0, mu_static=MU, mu_kinetic=0.3)
    run = jo.simulate(model, 0.7, solver=solver)
    assert {change for _, change in transitions(run)} == {"sticks"}
    assert run.events[0].time == pytest.approx(0.5574410960, abs=1e-9)
    assert run["x"][:, 0].max() == pytest.approx(0.8361616440, abs=2e-8)
    assert np.abs(run["v"][-1]).max() < 1e-12
    assert np.abs(run.energy.error).max() < 1e-6


@every_solver
@pytest.mark.parametrize("heading", [0.0, 20.0, 45.0])
def test_a_thrown_point_keeps_its_line(solver, heading):
    """Friction is a circle: 2 m/s, mu 0.4 stop after v^2 / 2 mu g in every direction."""
    e, K = direction(heading), 1e5
    body = jo.RigidBody("p", 1.0, (0.01,) * 3, position=(0, 0, -G / K), velocity=2 * e)
    x = jo.PositionSensor("x", body["origin"])
    model = jo.compile(jo.Mechanism(body, touch(body, Sphere(0.0), K), x, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.6, solver=solver)
    x = run["x"][-1]
    assert abs(x[1] * e[0] - x[0] * e[1]) < 1e-12
    assert x @ e == pytest.approx(4 / (2 * MU * G), abs=1e-11)
    assert run.events[0].time == pytest.approx(2 / (MU * G), abs=1e-10)
    assert np.abs(run.energy.error).max() < 1e-11


@every_solver
def test_a_block_breaks_away_at_mu_static(solver):
    """A force through the centre rises by 10 N/s: all corners slip at mu_s m g, to 1e-9."""
    K = 1e5
    body = jo.RigidBody(
        "block", 1.0, (0.01, 0.012, 0.015), position=(0, 0, 0.05 - G / (4 * K)),
        center=(0, 0, -0.05),
    )  # fmt: skip
    ramp = jo.Table([0, 1], [0, 1])
    push = jo.Force("f", body.at((0, 0, -0.05)), 10 * direction(17.0), signal=ramp)
    contact = touch(body, Cuboid((0.4, 0.4, 0.1)), K, mu_static=MU, mu_kinetic=0.3)
    x, v = jo.PositionSensor("x", body["origin"]), jo.VelocitySensor("v", body["origin"])
    model = jo.compile(jo.Mechanism(body, contact, push, x, v, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.5, solver=solver)
    assert [change for _, change in transitions(run)] == ["slips forward"] * 4
    for event in run.events:
        assert event.time == pytest.approx(MU * G / 10, rel=2e-9)
    assert np.ptp(run["x"][run.time < 0.39], axis=0).max() < 1e-11
    # from then on 10 t - mu_k m g
    t, start = 0.5, MU * G / 10
    speed = 5 * (t * t - start * start) - 0.3 * G * (t - start)
    np.testing.assert_allclose(run["v"][-1], speed * direction(17.0), atol=2e-7)


@pytest.mark.parametrize("turn", [0.0, 30.0])
def test_a_block_turned_by_a_couple_slips_at_its_limit(turn):
    """Four equal corners at a distance r hold the couple mu_s m g r, however the box is turned."""
    K, r = 1e5, 0.2 * np.sqrt(2)
    half = np.radians(turn) / 2
    body = jo.RigidBody(
        "block", 1.0, (0.01, 0.012, 0.015), position=(0, 0, 0.05 - G / (4 * K)),
        orientation=(np.cos(half), 0, 0, np.sin(half)),
    )  # fmt: skip
    couple = jo.Torque("m", body["origin"], (0, 0, 2.0), signal=jo.Table([0, 1], [0, 1]))
    contact = touch(body, Cuboid((0.4, 0.4, 0.1)), K)
    model = jo.compile(jo.Mechanism(body, contact, couple, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.6, solver=jo.ROS2(1e-3))
    assert [change for _, change in transitions(run)] == ["slips forward"] * 4
    assert run.events[0].time == pytest.approx(MU * G * r / 2.0, rel=2e-9)


@implicit
@pytest.mark.parametrize(
    ("share", "spin", "when", "speed"),
    [
        (0.5, 0.0, 0.5096839959, 2.0),
        (0.4, 0.0, 0.4368719965, 15 / 7),
        (0.4, -80.0, 1.601863987, -1 / 7),
    ],
    ids=["disc", "ball", "ball with spin back"],
)
def test_from_slip_to_rolling(solver, share, spin, when, speed):
    """3 m/s, mu 0.2, inertia share m R^2: when it begins to roll, and how fast."""
    R, K = 0.1, 1e10
    body = jo.RigidBody(
        "b", 1.0, (share * R * R,) * 3, position=(0, 0, R - (G / K) ** (1 / 1.5)),
        velocity=(3, 0, 0), angular_velocity=(0, spin, 0),
    )  # fmt: skip
    v = jo.VelocitySensor("v", body["origin"])
    contact = touch(body, Sphere(R), K, 1.5, mu_kinetic=0.2)
    model = jo.compile(jo.Mechanism(body, contact, v, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 1.8, solver=solver)
    assert [event.time for event in run.events] == pytest.approx([when], abs=1e-9)
    assert run["v"][-1, 0] == pytest.approx(speed, abs=1e-12)
    assert np.abs(run.energy.error).max() < 1e-9


def wedge(half: float) -> jo.Model:
    """A wedge between two walls, pressed in by 50 um at each; half an angle in degrees."""
    c, s = np.cos(np.radians(half)), np.sin(np.radians(half))
    body = jo.RigidBody("w", 1.0, (0.01,) * 3)
    guide = jo.Prismatic("guide", GROUND, body["origin"], axis=(0, 0, 1))
    contacts = []
    for side in (1, -1):
        normal, place = np.array([side * c, 0, s]), np.array([-side * 0.1, 0, 0])
        axes = np.column_stack([np.cross((0, 1, 0), normal), (0, 1, 0), normal])
        contacts.append(
            Contact(
                f"c{side}", jo.ground.at(place + 5e-5 * normal, axes=axes), HalfSpace(),
                body.at(place), Sphere(0.0), PowerLaw(1e6, 1.0), mu_kinetic=0.2,
                friction=StickSlip(),
            )
        )  # fmt: skip
    z = jo.PositionSensor("z", body["origin"])
    return jo.compile(jo.Mechanism(body, guide, *contacts, z))


@pytest.mark.parametrize("solver", [jo.RK4(1e-4), *IMPLICIT], ids=lambda s: type(s).__name__)
def test_a_wedge_sticks_up_to_the_angle_of_friction(solver):
    """Mu 0.2: it stays below 11.30993247402 degrees of half angle and is pushed out above."""
    holds = jo.simulate(wedge(11.30993147402), 0.1, solver=solver)
    assert not holds.events and np.abs(holds["z"]).max() < 1e-15
    slips = jo.simulate(wedge(11.30993347402), 0.1, solver=solver)
    assert slips["z"][-1, 2] > 1e-9


def test_a_ball_that_bounces_with_spin_never_gains_energy():
    """Flight, touches, slip and rolling: the energy falls, and the balance closes."""
    R = 0.1
    body = jo.RigidBody.sphere(
        "b", radius=R, mass=1.0, position=(0, 0, R + 0.02), velocity=(1, 0.5, 0),
        angular_velocity=(3, -30, 5),
    )  # fmt: skip
    contact = Contact(
        "c", GROUND, HalfSpace(), body["origin"], Sphere(R), PowerLaw(1e5, restitution=0.6),
        mu_kinetic=0.2, mu_static=0.3, friction=StickSlip(),
    )  # fmt: skip
    v, w = jo.VelocitySensor("v", body["origin"]), jo.AngularVelocitySensor("w", body["origin"])
    model = jo.compile(jo.Mechanism(body, contact, v, w, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 1.5, solver=jo.RK4(1e-3))
    energy = run.energy
    assert np.abs(energy.error).max() < 1e-4 * energy.kinetic[0]
    assert np.diff(energy.kinetic + energy.potential + energy.springs).max() < 1e-9
    # angular momentum about the ground: rolls with (5 v + 2 R w) / 7
    assert transitions(run)[-1] == ("c.slip", "sticks")
    assert run["v"][-1, :2] == pytest.approx(((5 - 60 * R) / 7, (2.5 - 6 * R) / 7), abs=1e-3)


def test_points_report_their_state_and_friction():
    """At rest on a slope the corners share m g sin a in proportion to their normal forces."""
    model = block(15.0, 0.0, low=0.05)
    run = jo.simulate(model, 0.02, solver=jo.ROS2(1e-3))
    points = run.contacts.at(0.02)
    assert [one.phase for one in points] == ["sticks"] * 4
    friction = sum(one.friction for one in points)
    np.testing.assert_allclose(friction, (G * np.sin(np.radians(15.0)), 0, 0), atol=1e-9)
    ratios = [np.linalg.norm(one.friction) / one.force for one in points]
    assert ratios == pytest.approx([np.tan(np.radians(15.0))] * 4, rel=1e-6)


def test_a_model_file_has_it():
    text = """
    name: floor
    gravity: [0, 0, -9.81]
    bodies:
      - {type: rigid, name: ball, mass: 1 kg, inertia: [0.004, 0.004, 0.004],
         position: [0, 0, 0.1], velocity: [1, 0, 0]}
    forces:
      - type: contact
        name: c
        a: ground.origin
        shape_a: {type: half-space}
        b: ball.origin
        shape_b: {type: sphere, radius: 100 mm}
        law: {type: power-law, stiffness: 1e8}
        mu_kinetic: 0.3
        friction: {type: stick-slip}
    """
    mechanism = parse_model(text).mechanism
    assert mechanism.forces[-1].friction == StickSlip()


def test_what_is_refused():
    body = jo.RigidBody("b", 1.0, (1,) * 3, position=(0, 0, 1))
    law, here = PowerLaw(1e6), body["origin"]
    rub: dict[str, Any] = {"mu_kinetic": MU, "friction": StickSlip()}
    floor = (GROUND, HalfSpace())
    with pytest.raises(jo.InputError, match="of a sphere on a cuboid; leave out friction"):
        Contact("c", GROUND, Cuboid((1, 1, 1)), here, Sphere(0.1), law, **rub)
    with pytest.raises(jo.InputError, match="of a cylinder on a half-space"):
        Contact("c", *floor, here, Cylinder(0.1, 0.2), law, **rub)
    with pytest.raises(jo.InputError, match="mu_kinetic is 0; give mu_kinetic"):
        Contact("c", *floor, here, Sphere(0.1), law, friction=StickSlip())
    with pytest.raises(jo.InputError, match="give resolve='cut'"):
        Contact("c", *floor, here, Sphere(0.1), law, **rub, resolve="impulse")
    with pytest.raises(jo.InputError, match=r"must be Regularised\(velocity\), StickSlip\(\)"):
        Contact("c", *floor, here, Sphere(0.1), law, mu_kinetic=MU, friction="none")  # type: ignore[arg-type]
    contact = Contact("c", *floor, here, Sphere(0.1), law, **rub)
    with pytest.raises(jo.InputError, match="whose force is that of rows"):
        jo.ForceSensor("f", contact)
    model = jo.compile(jo.Mechanism(body, contact, jo.Gravity((0, 0, -G))))
    for call in (jo.modes, jo.simulation.linearise, jo.equilibrium):
        with pytest.raises(jo.InputError, match=r"StickSlip\(\), whose rows .* leave out friction"):
            call(model)
    with pytest.raises(jo.InputError, match="hold points that touch"):
        jo.compile(jo.Mechanism(body, contact), core="joint")
    many = [Contact(f"c{i}", *floor, here, Cuboid((1, 1, 1)), law, **rub) for i in range(5)]
    with pytest.raises(jo.InputError, match="more than 32 points of 'b'"):
        jo.compile(jo.Mechanism(body, *many))
    smooth = Contact("c", *floor, here, Sphere(0.1), law, mu_kinetic=MU, friction=Regularised())
    assert not smooth.sticks and not smooth.slips
