"""Points that slide along beams, and telescopes: closed forms, tangents, momentum, bad input."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import ForceStateSensor, Slider, nodes_along
from jousto.model.native.native import displaced
from jousto.schema.read import parse_model
from model.test_newton import assert_exact
from model.test_track_contact import EI, MU, SMALL, SPEED, G, L, exact, modal, sprung_mass

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
MIDDLE = "node11"


def moving_mass(modes: int, mass: float) -> tuple[float, float]:
    """Deflection of the middle when the mass is there, and the largest one, from the modes.

    The mass moves with w(v t, t), so that its acceleration is w_tt + 2 v w_xt + v^2 w_xx.
    """
    n = np.arange(1, modes + 1)
    w2, m, k = (n * np.pi / L) ** 4 * EI / MU, MU * L / 2, n * np.pi / L

    def rates(t: float, y: Any) -> Any:
        q, qd = y[:modes], y[modes:]
        shape, slope, bend = (
            np.sin(k * SPEED * t),
            k * np.cos(k * SPEED * t),
            -(k**2) * np.sin(k * SPEED * t),
        )
        free = G - 2 * SPEED * slope @ qd - SPEED**2 * bend @ q
        M = m * np.eye(modes) + mass * np.outer(shape, shape)
        return np.concatenate([qd, np.linalg.solve(M, mass * free * shape - m * w2 * q)])

    t = np.linspace(0, L / SPEED, 50001)
    run = solve_ivp(
        rates, (0, t[-1]), np.zeros(2 * modes), t_eval=t, rtol=1e-11, atol=1e-14, method="DOP853"
    )
    w = np.sin(n * np.pi / 2) @ run.y[:modes]
    return float(w[25000]), float(w.max())


def crossing(beam: Any, stiffness: float, damping: float, mass: float, **more: Any) -> jo.Model:
    """A mass that slides over a beam on a hinge and a roller, with its weight on it at first."""
    hinge = jo.Revolute("hinge", jo.ground["origin"], beam["start"], (0, 1, 0))
    roller = jo.PointOnPlane("roller", jo.ground.at((L, 0, 0)), beam["end"], (0, 0, 1))
    sunk = mass * G * SMALL / stiffness
    body = jo.RigidBody("mass", mass, (10, 10, 10), position=(0, 0, -sunk), velocity=(SPEED, 0, 0))
    way = jo.Planar("way", jo.ground["origin"], body["origin"], (0, 1, 0))
    track = nodes_along(beam, "start", "end")
    slide = Slider("slide", track, body["origin"], stiffness, damping, **more)
    weight = jo.Force("weight", body["origin"], (0, 0, -G * SMALL * mass))
    middle = jo.PositionSensor("middle", beam[MIDDLE])
    place = ForceStateSensor("place", slide, "way")
    return jo.compile(jo.Mechanism(beam, body, hinge, roller, way, slide, weight, middle, place))


def test_the_closed_form_has_the_published_numbers():
    """1000 kg at 20 m/s over 10 m of beam, 10 modes."""
    assert moving_mass(10, 1000.0) == pytest.approx((0.06625244938, 0.08770133588), rel=1e-8)


@pytest.mark.parametrize("solver", [jo.RK4(2e-4), jo.ROS2(2e-4), jo.GeneralizedAlpha(2e-4)])
def test_a_sprung_mass_slides_over_a_modal_beam(solver):
    model = crossing(modal(), 1e6, 1e4, 1000.0)
    run = jo.simulate(model, 0.25, solver=solver, output_step=0.025)
    wanted = sprung_mass(20, 1000.0, 1e6, 1e4)
    assert -run["middle"][-1, 2] / SMALL == pytest.approx(wanted, rel=1e-4)
    assert run["place"][-1, 0] == pytest.approx(5.0, rel=1e-5)


@pytest.mark.parametrize("make", [modal, exact])
def test_a_stiff_slider_is_the_moving_mass(make):
    """All modes: 0.06626054 m in the middle, and the largest value beyond it."""
    middle, most = moving_mass(24, 1000.0)
    model = crossing(make(), 1e9, 1e5, 1000.0)
    run = jo.simulate(model, 0.49, solver=jo.GeneralizedAlpha(1e-4))
    w = -run["middle"][:, 2] / SMALL
    assert np.interp(0.25, run.time, w) == pytest.approx(middle, rel=2e-4)
    assert w.max() == pytest.approx(most, rel=2e-3)


def test_friction_stops_it():
    """On a level rail ``v^2 / (2 (mu g + R / m))``, and a force along it is a drive."""
    m, mu, R, v = 5.0, 0.2, 3.0, 2.0
    body = jo.RigidBody("b", m, (1, 1, 1), position=(1, 0, -m * G / 1e7), velocity=(v, 0, 0))
    rail = jo.ground["origin"], jo.ground.at((10, 0, 0))
    slide = Slider("s", rail, body["origin"], 1e7, 1e3, mu=mu, resistance=R)
    held = jo.ConstantOrientation("held", jo.ground["origin"], body["origin"])
    p = jo.PositionSensor("p", body["origin"])
    model = jo.compile(jo.Mechanism(body, slide, held, p, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 2.0, solver=jo.GeneralizedAlpha(1e-3))
    assert run["p"][-1, 0] - 1 == pytest.approx(v**2 / 2 / (mu * G + R / m), rel=1e-3)
    lost = 0.5 * m * v**2
    assert run.energy.friction[-1] == pytest.approx(lost, rel=1e-3)


def test_a_drive_moves_it():
    """A trolley follows its reference with the error of its gains."""
    m, hold, brake = 50.0, 2e5, 6e3
    body = jo.RigidBody("b", m, (1, 1, 1), position=(1, 0, 0))
    rail = jo.ground["origin"], jo.ground.at((4, 0, 0)), jo.ground.at((10, 0, 0))
    to = jo.SCurve((0.0, 2.0), (1.0, 7.0))
    slide = Slider("s", rail, body["origin"], 1e7, 1e4, reference=to, hold=hold, brake=brake)
    held = jo.ConstantOrientation("held", jo.ground["origin"], body["origin"])
    way = ForceStateSensor("way", slide, "way")
    run = jo.simulate(jo.compile(jo.Mechanism(body, slide, held, way)), 3.0, solver=jo.RK4(2e-4))
    assert run["way"][-1, 0] == pytest.approx(7.0, abs=1e-6)
    assert np.abs(run["way"][:, 0] - to(run.time)).max() < 0.01


def machine(rng: Any, core: str = "auto") -> jo.Model:
    """Everything moves: a modal beam, a body on it aside of its axis, friction and a drive."""
    part = jo.Part.beam(4.0, jo.Rectangle(0.1, 0.06), 8, jo.Material(E=2e9, nu=0.3, rho=800.0))
    beam = jo.FlexibleBody(
        "beam", jo.reduce(part, jo.CraigBampton(interfaces=("start", "end"), modes=4)),
        velocity=rng.normal(size=3), angular_velocity=0.3 * rng.normal(size=3),
    )  # fmt: skip
    body = jo.RigidBody(
        "body", 3.0, (0.2, 0.3, 0.4), position=(1.7, 0.01, -0.02), velocity=rng.normal(size=3),
        angular_velocity=rng.normal(size=3), markers={"eye": (0.02, -0.01, 0.01)},
    )  # fmt: skip
    track = beam["start"], beam["end"]
    slide = Slider(
        "s", track, body["eye"], 3e4, 20.0, mu=0.2, resistance=1.0, slow=0.5, pull=2.0,
        reference=3.0, hold=40.0, brake=5.0, play=0.002,
    )  # fmt: skip
    return jo.compile(jo.Mechanism(beam, body, slide), core=core)


def test_tangents():
    rng = np.random.default_rng(3)
    for _ in range(3):
        engine = jo.model.Engine(machine(rng))
        engine.q[:] = displaced(engine.model, engine.q, 0.003 * rng.normal(size=engine.model.nv))
        engine.accelerations()
        assert_exact(engine, 1e-10)


def test_momentum_and_energy():
    model = machine(np.random.default_rng(5))
    run = jo.simulate(model, 0.3, solver=jo.RK4(1e-4))
    e = run.energy
    total = e.kinetic + e.strain + e.springs + e.dissipated + e.friction - e.work
    assert np.ptp(total) < 1e-6 * total[0]


# -- telescopes ---------------------------------------------------------------------------------


def stage(name: str, EI: float, at: float) -> jo.BeamBody:
    """A stage of 6 m along x from `at`, slender, in the plane of its bending."""
    height = 0.01
    material = jo.Material(E=EI / (height**3 / 12), nu=0.3, rho=1.0)
    points = [(at, 0, 0), (at + 6.0, 0, 0)]
    return jo.BeamBody(name, points, jo.Rectangle(1.0, height), material, elements=12, bending=True)


@pytest.mark.parametrize("play", [0.0, 1e-5])
def test_a_boom_of_two_stages(play):
    """6 + 6 m with 1.5 m of overlap, 5 kN at the tip: pads 20 and 15 kN, tip 0.10828125 m.

    The load is small, since the closed form is linear: what the pads give, and their play, tilts
    the inner stage.
    """
    load, k = 5e3 * SMALL, 1e7
    outer, inner = stage("outer", 2e7, 0.0), stage("inner", 8e6, 4.5)
    root = jo.Fixed("root", jo.ground["origin"], outer["start"])
    hold = jo.Rod("hold", outer["start"], inner["start"])
    mouth = Slider("mouth", nodes_along(inner, "start", "end"), outer["end"], k, play=play * SMALL)
    rear = Slider("rear", nodes_along(outer, "start", "end"), inner["start"], k, play=play * SMALL)
    weight = jo.Force("weight", inner["end"], (0, 0, -load))
    sensors = jo.PositionSensor("tip", inner["end"]), jo.ForceSensor("pad", mouth)
    plane = jo.PointOnPlane("plane", jo.ground["origin"], inner["end"], (0, 1, 0))
    model = jo.compile(jo.Mechanism(outer, inner, root, hold, mouth, rear, weight, plane, *sensors))
    state = jo.equilibrium(model)
    tip = (
        -np.asarray(jo.simulate(model, 1e-3, state=state, solver=jo.GeneralizedAlpha(1e-3))["tip"])[
            0, 2
        ]
        / SMALL
    )
    give = (20e3 / k + play, 15e3 / k + play)
    tilt = give[0] + (give[0] + give[1]) * 4.5 / 1.5
    assert tip - tilt == pytest.approx(0.10828125, rel=1e-4)


# -- declarations -------------------------------------------------------------------------------


def test_what_is_refused_and_why():
    body = jo.RigidBody("b", 1.0, (1, 1, 1), position=(1, 0, 0))
    rail = jo.ground["origin"], jo.ground.at((4, 0, 0))

    def refused(text: str, track: Any, b: Any, **more: Any) -> None:
        with pytest.raises(InputError, match=text):
            Slider("s", track, b, **({"stiffness": 1e6} | more))

    refused("track has 1 markers; give two or more", rail[:1], body["origin"])
    refused("is beyond the end of the track; move it", rail, body.at((4, 0, 0)))
    refused("is beyond the end of the track; move it", rail, body.at((-2, 0, 0)))
    refused("reference goes with hold or brake", rail, body["origin"], reference=1.0)
    refused("reference goes with hold or brake", rail, body["origin"], hold=1.0)
    refused("are both on", (body["origin"], rail[1]), body.at((1, 0, 0)))
    refused("stiffness is 0 N/m, must be positive", rail, body["origin"], stiffness=0.0)


FILE = """
bodies:
  - {name: trolley, mass: 50 kg, inertia: [1, 1, 1], position: [1, 0, 0]}
joints:
  - {type: constant-orientation, name: held, a: ground.origin, b: trolley.origin}
gravity: [0, 0, -9.81]
forces:
  - type: slider
    name: runner
    track: [ground.origin, {body: ground, at: [10 m, 0, 0]}]
    b: trolley.origin
    stiffness: 10 MN/m
    damping: 10 kN s/m
    mu: 0.01
    reference: {type: s-curve, times: [0, 2], values: [1, 7]}
    hold: 200 kN/m
    brake: 6 kN s/m
sensors:
  - {type: position, name: p, marker: trolley.origin}
"""


def test_a_model_file_is_the_same_machine():
    body = jo.RigidBody("trolley", 50.0, (1, 1, 1), position=(1, 0, 0))
    slide = Slider(
        "runner", (jo.ground["origin"], jo.ground.at((10, 0, 0))), body["origin"], 1e7, 1e4,
        mu=0.01, reference=jo.SCurve((0, 2), (1, 7)), hold=2e5, brake=6e3,
    )  # fmt: skip
    held = jo.ConstantOrientation("held", jo.ground["origin"], body["origin"])
    p = jo.PositionSensor("p", body["origin"])
    items = body, slide, held, p, jo.Gravity((0, 0, -G))
    read = jo.compile(parse_model(FILE).mechanism)
    model = jo.compile(jo.Mechanism(*items))
    runs = [jo.simulate(one, 1.0, solver=jo.RK4(5e-4)) for one in (model, read)]
    np.testing.assert_array_equal(runs[0]["p"], runs[1]["p"])
