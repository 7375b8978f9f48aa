"""Wheels on beams that bend: closed forms, tangents, momentum, bodies in a row, bad input."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import (
    Contact,
    HalfSpace,
    PowerLaw,
    Sphere,
    SpringDamper,
    TrackContact,
    nodes_along,
)
from jousto.model.native.native import displaced
from jousto.schema.read import parse_model

L, EI, MU, SPEED, G = 10.0, 4.2e6, 100.0, 20.0, 9.81
SMALL = 1e-3  # weight relative to that of the source: the closed form is linear, the track is not
MIDDLE = "node11"
HEIGHT = 0.01  # of the section, m: slender, without rotary inertia and shear
pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


def section() -> tuple[jo.Section, jo.Material]:
    """Section and material with the bending stiffness and mass of the source."""
    width = 1.0
    modulus = EI / (width * HEIGHT**3 / 12)
    return jo.Rectangle(width, HEIGHT), jo.Material(E=modulus, nu=0.3, rho=MU / (width * HEIGHT))


def modal(elements: int = 20, modes: int = 30) -> jo.FlexibleBody:
    profile, material = section()
    part = jo.Part.beam(L, profile, elements, material, theory=jo.parts.EulerBernoulli())
    reduced = jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=modes))
    return jo.FlexibleBody("beam", reduced.keep(reduced.in_plane("xz")))


def exact(elements: int = 20) -> jo.BeamBody:
    profile, material = section()
    return jo.BeamBody(
        "beam", [(0, 0, 0), (L, 0, 0)], profile, material, elements=elements, bending=True
    )


def crossing(beam: Any, law: Any, mass: float) -> jo.Model:
    """A mass that crosses a beam on a hinge and a roller, with its weight on the law at first."""
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], (0, 1, 0))
    roller = jo.PointOnPlane("roller", jo.ground.at((L, 0, 0)), beam["end"], (0, 0, 1))
    sunk = mass * G * SMALL / law.stiffness
    body = jo.RigidBody("mass", mass, (10, 10, 10), position=(0, 0, -sunk), velocity=(SPEED, 0, 0))
    way = jo.Planar("way", jo.ground["origin"], body["origin"], (0, 1, 0))
    touch = TrackContact("touch", nodes_along(beam, "start", "end"), body["origin"], law)
    weight = jo.Force("weight", body["origin"], (0, 0, -G * SMALL * mass))
    middle = jo.PositionSensor("middle", beam[MIDDLE])
    return jo.compile(jo.Mechanism(beam, body, hinge, roller, way, touch, weight, middle))


@cache
def sprung_mass(modes: int, mass: float, k: float, c: float) -> float:
    """Deflection of the middle when a sprung mass is there, from the modes of the beam."""
    n = np.arange(1, modes + 1)
    w2, m = (n * np.pi / L) ** 4 * EI / MU, MU * L / 2

    def rates(t: float, y: Any) -> Any:
        q, qd, z, zd = y[:modes], y[modes:-2], y[-2], y[-1]
        angle = n * np.pi * SPEED * t / L
        shape, slope = np.sin(angle), n * np.pi / L * np.cos(angle)
        F = k * (z - shape @ q) + c * (zd - shape @ qd - SPEED * slope @ q)
        return np.concatenate([qd, F * shape / m - w2 * q, [zd, G - F / mass]])

    start = np.zeros(2 * modes + 2)
    start[-2] = mass * G / k
    end = solve_ivp(rates, (0, 0.25), start, rtol=1e-10, atol=1e-13, method="DOP853").y[:, -1]
    return float(np.sin(n * np.pi / 2) @ end[:modes])


def deflection(model: jo.Model, solver: Any) -> float:
    """Deflection of the middle when the mass is there, times the share of its weight."""
    run = jo.simulate(model, 0.5 * L / SPEED, solver=solver, output_step=0.025)
    return float(-run["middle"][-1, 2] / SMALL)


def test_the_closed_form_has_the_published_number():
    assert sprung_mass(10, 1000.0, 1e6, 1e4) == pytest.approx(0.06214029020, abs=1e-10)


@pytest.mark.parametrize(
    "solver",
    [jo.RK4(2e-4), jo.ROS2(2e-4), jo.GeneralizedAlpha(2e-4)],
    ids=lambda s: type(s).__name__,
)
def test_a_sprung_mass_crosses_a_modal_beam(solver):
    """The shapes of the elements converge with the modes of the closed form."""
    model = crossing(modal(), SpringDamper(1e6, 1e4), 1000.0)
    wanted = sprung_mass(20, 1000.0, 1e6, 1e4)
    assert deflection(model, solver) == pytest.approx(wanted, rel=1e-4)


def test_a_sprung_mass_crosses_an_exact_beam():
    model = crossing(exact(), SpringDamper(1e6, 1e4), 1000.0)
    wanted = sprung_mass(20, 1000.0, 1e6, 1e4)
    assert deflection(model, jo.GeneralizedAlpha(2e-4)) == pytest.approx(wanted, rel=2e-5)


def test_a_stiff_contact_is_the_moving_mass():
    """A mass without gap: 10 modes have 0.06625244938 m, more than 10 have 0.06626054."""
    model = crossing(modal(), SpringDamper(3e8, 3e5), 1000.0)
    assert deflection(model, jo.GeneralizedAlpha(2e-4)) == pytest.approx(0.06626054, rel=3e-4)


@pytest.mark.parametrize("where", ["ground", "body"])
def test_on_a_rigid_track_it_is_a_contact_with_a_plane(where):
    """A ball is dropped with spin: bounces, slips and rolls as on a half-space."""
    law = PowerLaw(1e6, restitution=0.6)
    found = []
    for kind in ("track", "plane"):
        ball = jo.RigidBody.sphere(
            "ball", radius=0.05, mass=0.5, position=(0.3, 0, 0.1), velocity=(1.0, 0, 0),
            angular_velocity=(0, -30.0, 0),
        )  # fmt: skip
        floor: Any = jo.ground
        items: tuple[Any, ...] = ()
        if where == "body":
            floor = jo.RigidBody("floor", 1e9, (1e9,) * 3)  # the same steps
            items = (floor, jo.Fixed("held", jo.ground["origin"], floor["origin"]))
        touch: Any = Contact(
            *("c", floor["origin"], HalfSpace(), ball["origin"], Sphere(0.05), law), mu_kinetic=0.3
        )
        if kind == "track":
            # a circle of markers would do as well; a straight one is exact
            track = [floor.at((x, 0, 0)) for x in (-1.0, 0.4, 0.9, 4.0)]
            touch = TrackContact("c", track, ball["origin"], law, radius=0.05, mu_kinetic=0.3)
        p = jo.PositionSensor("p", ball["origin"])
        w = jo.AngularVelocitySensor("w", ball["origin"])
        model = jo.compile(jo.Mechanism(ball, *items, touch, p, w, jo.Gravity((0, 0, -G))))
        run = jo.simulate(model, 0.7, solver=jo.RK4(1e-3))
        found.append(np.hstack([run["p"], run["w"]]))
        assert np.abs(run.energy.error).max() < 1e-5
    np.testing.assert_allclose(found[0], found[1], atol=2e-6)


def floating(mu: float, w: float = 0.0) -> jo.Model:
    """A beam that floats and turns, a ball that slides or rolls on it."""
    beam = modal(6, 6)
    ball = jo.RigidBody(
        "ball", 3.0, (0.02, 0.03, 0.04), position=(6.1, 0.03, 0.19), velocity=(2, 0.3, -0.5),
        angular_velocity=(1.0, w, 0.5),
    )  # fmt: skip
    touch = TrackContact(
        *("touch", (beam["start"], beam["end"]), ball["origin"], SpringDamper(5e4, 200.0)),
        radius=0.2,
        mu_kinetic=mu,
    )
    return jo.compile(jo.Mechanism(beam, ball, touch))


@pytest.mark.parametrize("mu", [0.0, 0.4])
def test_tangent_is_the_derivative(mu):
    """Newton's matrix against complex steps: displaced beams in motion, a wheel off the middle."""
    rng = np.random.default_rng(3)
    found = 0
    for _ in range(20):
        engine = jo.model.Engine(floating(mu, 20.0))
        engine.q[:] = displaced(engine.model, engine.q, 0.02 * rng.normal(size=engine.model.nv))
        engine.v[:] += 0.3 * rng.normal(size=engine.model.nv)
        engine.start_states()
        phase = engine.states[0]
        if not phase or (mu and phase == 1):
            continue  # a bristle that sticks is moved by its states
        engine.accelerations()
        exact = engine.tangent()
        for M, weights in ((exact.K, (0.0, 0.0, 1.0)), (exact.D, (0.0, 1.0, 0.0))):
            N = engine.newton_matrix(*weights)[: len(M), : len(M)]
            assert np.abs(M - N).max() <= 1e-11 * np.abs(M).max()
        found += 1
    assert found > 5


def test_momentum_is_kept():
    """Of a floating beam and a ball that rolls on it, in all directions and about the origin."""
    model = floating(0.4)
    engine = jo.model.Engine(model)

    def momentum() -> Any:
        # of the beam: [V, w] times its mass matrix, in its frame; of the ball alike
        total = np.zeros(6)
        for body in range(2):
            b = model.bodies[body]
            M = engine.mass_matrix(body)
            v = engine.v[b.iv : b.iv + 6 + b.n]
            A = jo.base.rotations.rotation_matrix(engine.q[b.iq + 3 : b.iq + 7])
            local = np.concatenate([A.T @ v[:3], v[3:]])
            p, h = (M @ local)[:3], (M @ local)[3:6]
            total[:3] += A @ p
            total[3:] += A @ h + np.cross(engine.q[b.iq : b.iq + 3], A @ p)
        return total

    before = momentum()
    run = jo.simulate(model, 0.1, solver=jo.RK4(5e-5))
    engine.q[:], engine.v[:] = run.q[-1], run.v[-1]
    np.testing.assert_allclose(momentum(), before, atol=2e-9 * np.abs(before).max())


def test_two_wheels_run_from_rail_to_beam_to_rail():
    """The bridge carries their weight; rails before and after it are on the ground."""
    beam = modal(8, 10)
    before, after = jo.ground.at((-3, 0, 0)), jo.ground.at((L + 6, 0, 0))
    track = (
        before,
        jo.ground["origin"],
        beam["start"],
        beam["end"],
        jo.ground.at((L, 0, 0)),
        after,
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], (0, 1, 0))
    roller = jo.PointOnPlane("roller", jo.ground.at((L, 0, 0)), beam["end"], (0, 0, 1))
    items: list[Any] = [beam, hinge, roller]
    K = 2e6
    for i, x in enumerate((-0.5, -2.5)):
        wheel = jo.RigidBody(
            f"wheel{i}", 200.0, (4, 4, 4), position=(x, 0, 0.4 - 200 * G / K), velocity=(5, 0, 0)
        )
        touch = TrackContact(
            f"touch{i}", track, wheel["origin"], PowerLaw(K, 1.0, restitution=0.2), radius=0.4
        )
        weight = jo.Force(f"weight{i}", wheel["origin"], (0, 0, -200 * G))
        sensors = (jo.PositionSensor(f"p{i}", wheel["origin"]), jo.ForceSensor(f"N{i}", touch))
        piece = jo.mechanism.ForceStateSensor(f"piece{i}", touch, "piece")
        items += [wheel, touch, weight, *sensors, piece]
    model = jo.compile(jo.Mechanism(*items))
    run = jo.simulate(model, 2.9, solver=jo.GeneralizedAlpha(1e-3), output_step=0.01)
    for i in range(2):
        assert run[f"p{i}"][-1, 0] > L  # beyond the beam
        np.testing.assert_allclose(run[f"p{i}"][-1, 2], 0.4 - 200 * G / K, atol=2e-4)
        assert run[f"N{i}"][:, 2].min() > 0.5 * 200 * G  # it never leaves the track
        x = run[f"p{i}"][:, 0]
        pieces = run[f"piece{i}"].ravel()
        assert pieces[x < -0.1].max() == 0 and pieces[x > L + 0.1].min() == 9
        assert np.all(np.diff(pieces) >= 0)


def test_beyond_the_end_a_wheel_falls():
    wheel = jo.RigidBody("w", 1.0, (1, 1, 1), position=(0.5, 0, 0.1), velocity=(2.0, 0, 0))
    track = (jo.ground["origin"], jo.ground.at((1, 0, 0)))
    touch = TrackContact("t", track, wheel["origin"], PowerLaw(1e6, 1.0), radius=0.1)
    p = jo.PositionSensor("p", wheel["origin"])
    model = jo.compile(jo.Mechanism(wheel, touch, p, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 0.5, solver=jo.RK4(1e-3))
    assert run["p"][run.time < 0.249, 2].min() > 0.0999
    assert run["p"][-1, 2] == pytest.approx(0.1 - 0.5 * G * 0.25**2, abs=1e-4)


def test_bad_input_is_refused():
    wheel = jo.RigidBody("w", 1.0, (1, 1, 1))
    law = PowerLaw(1e6, 1.0)
    beam = exact(4)
    for track, message in (
        ((jo.ground["origin"],), "two or more"),
        ((beam["start"], beam["end"]), "name every node"),
        ((wheel.at((0, 0, 1)), jo.ground["origin"]), "both on"),
        ((jo.ground["origin"], jo.ground.at((0, 0, 1))), "along the direction of its top"),
        ((jo.ground["origin"], jo.ground.at((0, 0, 0))), "at one place"),
    ):
        with pytest.raises(InputError, match=message):
            TrackContact("t", track, wheel["origin"], law)
    with pytest.raises(InputError, match="marker"):
        TrackContact("t", (jo.ground["origin"], 3), wheel["origin"], law)  # type: ignore[arg-type]


def test_a_model_file_declares_it():
    model = parse_model(
        """
        bodies:
          - {type: rigid, name: wheel, mass: 1, inertia: [1, 1, 1], position: [0.5, 0, 0.1]}
        forces:
          - type: track-contact
            name: touch
            track: [ground.origin, {body: ground, at: [1, 0, 0]}]
            b: wheel.origin
            radius: 0.1
            law: {type: power-law, stiffness: 1e6, exponent: 1}
        """
    )
    (touch,) = model.mechanism.forces
    assert isinstance(touch, TrackContact) and len(touch.pieces) == 1
