"""Wheels on rails with creep: geometry, forces, tangents, saturation, bad input, model files."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import RailContact, RailContactSensor
from jousto.model.native.native import displaced
from jousto.schema.read import parse_model

R, G = 0.46, 9.81  # m, m/s2
E, NU, HEAD = 210e9, 0.3, 0.3
pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


# -- one wheel in motion ------------------------------------------------------------------------

SHAPES: dict[str, dict[str, Any]] = {
    "cone": {"cone": 0.05},
    "cylinder": {"cone": 0.0},
    "convex": {"cone": -0.04, "tread": 0.8},
    "hollow": {"cone": 0.04, "tread": -0.5},
    "damped": {"cone": 0.05, "damping": 0.4},
}


def wheel(seed: int, across: float = 0.0, lift: float = 0.0) -> Any:
    """A wheel near the rail with a yaw, a tilt, and velocities of all kinds."""
    rng = np.random.default_rng(seed)
    turn = jo.Rotate(rng.normal(size=3) * (1, 0.1, 1), degrees=1.5)
    return jo.RigidBody(
        "wheel", 600.0, (40, 70, 40), position=(0.7, across, R + lift), orientation=turn,
        velocity=(15.0, 0.05 * rng.normal(), 0.02 * rng.normal()),
        angular_velocity=(0.02 * rng.normal(), 32.6, 0.3 * rng.normal()),
    )  # fmt: skip


def surface(contact: Any, y: Any) -> Any:
    """Radius of the tread at the distance y along the axle."""
    cone, tread = contact.cone, contact.tread
    if tread is None:
        return R + cone * y
    lean = np.hypot(1, cone)
    middle = np.array([0.0, R]) - tread * np.array([-cone, 1.0]) / lean
    return middle[1] + np.sign(tread) * np.sqrt(tread**2 - (y - middle[0]) ** 2)


def touching(contact: Any, body: Any) -> tuple[Any, Any, float]:
    """Nearest point of head and tread by search: point on the rail, normal down, depth."""
    n, r = np.array(body["origin"].A[:, 1]), np.array(body["origin"].r)
    one = np.cross(n, (0.0, 0.0, 1.0))
    one /= np.linalg.norm(one)
    other = np.cross(one, n)  # upwards

    def place(x: Any) -> Any:
        y, angle = 0.01 * x
        return r + y * n + surface(contact, y) * (np.sin(angle) * one - np.cos(angle) * other)

    def height(x: Any) -> float:
        """Distance of a point of the tread from the middle of the head."""
        return float(np.hypot(place(x)[1], place(x)[2] + HEAD))

    # the tread enters the head where this distance is least
    best = minimize(height, (0.0, 0.0), method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 0})
    at = place(best.x)
    out = np.array([0.0, at[1], at[2] + HEAD]) / best.fun
    return np.array([at[0], 0, -HEAD]) + HEAD * out, -out, HEAD - best.fun


def stated(contact: Any, body: Any, mu: float) -> Any:
    """Load, creep forces, moment and creepages as in the docstring, in NumPy."""
    at, down, depth = touching(contact, body)
    n, v, w = (np.array(x) for x in (body["origin"].A[:, 1], body.velocity, body.angular_velocity))
    arm = at - np.array(body["origin"].r)
    slide, across = v + np.cross(w, arm), np.cross((1, 0, 0), down)
    K = contact.tread_patch.scale.approach**-1.5
    elastic = K * depth**1.5
    N = elastic * (1 + contact.damping * (slide @ down))
    turning = np.cross((w @ n) * n, arm)
    speed = 0.5 * ((slide - turning)[0] - turning[0])  # mean of travel and circumference
    x, y, spin = slide[0] / speed, slide @ across / speed, -w @ down / speed
    C, shear = contact.tread_patch.coefficients, E / 2 / (1 + NU)
    one = contact.tread_patch.scale
    ab = one.a * one.b * elastic ** (2 / 3)
    F = -shear * ab * np.array([C.C11 * x, C.C22 * y + np.sqrt(ab) * C.C23 * spin])
    M = shear * ab * (np.sqrt(ab) * C.C23 * y - ab * C.C33 * spin)
    e = np.linalg.norm(F) / mu / N
    part = 1 - e / 3 + e * e / 27 if e < 3 else 1 / e
    return np.array([N, *(part * F), part * M, x, y, spin])


@pytest.mark.parametrize("shape", SHAPES)
def test_force_is_that_of_its_statement(shape):
    """Contact point by a search over tread and head; load, creepages, saturated forces."""
    more = SHAPES[shape]
    for seed in range(3):
        for mu in (0.3, 5.0):
            body = wheel(seed, lift=-8e-4)
            contact = RailContact(
                "c", jo.ground["origin"], body["origin"], R, mu=mu, axle=body["origin"].A[:, 1],
                **more,
            )  # fmt: skip
            sensor = RailContactSensor("s", contact)
            engine = jo.model.Engine(jo.compile(jo.Mechanism(body, contact, sensor)))
            engine.accelerations()
            found, want = engine.sensors()[:7], stated(contact, body, mu)
            assert want[0] > 1e3
            np.testing.assert_allclose(found[4:], want[4:], rtol=1e-4, atol=1e-7)
            np.testing.assert_allclose(found[:4], want[:4], rtol=2e-4, atol=1e-3)


def moving(seed: int, **more: Any) -> tuple[Any, Any]:
    """A wheel on a rail that moves, too: its engine and contact."""
    rng = np.random.default_rng(seed)
    body = wheel(seed, lift=-8e-4)
    sleeper = jo.RigidBody("sleeper", 100.0, (5, 6, 7), velocity=(0.3, 0.02, 0.01))
    contact = RailContact("c", sleeper["origin"], body["origin"], R, axle=(0, 1, 0), **more)
    names = ("tread", "flange")[: len(contact.patches)]
    sensors = [RailContactSensor(name, contact, name) for name in names]
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, sleeper, contact, *sensors)))
    engine.q[:] = displaced(engine.model, engine.q, 1e-4 * rng.normal(size=12))
    engine.v[:] += 0.03 * rng.normal(size=12)
    engine.accelerations()
    return engine, contact


@pytest.mark.parametrize("shape", [*SHAPES, "flange"])
def test_tangent_is_the_derivative(shape):
    """Newton's matrix against complex steps, on a rail that moves."""
    more = SHAPES.get(shape, {"cone": 0.05, "play": 1e-7})
    for seed in range(4):
        for mu in (0.05, 0.3, 50.0):
            engine, contact = moving(seed, mu=mu, **more)
            loads = engine.sensors()[::12]
            assert (loads[: len(contact.patches)] > 0).all()
            exact = engine.tangent()
            for weights, want in (((0.0, 1.0, 0.0), exact.D), ((0.0, 0.0, 1.0), exact.K)):
                found = engine.newton_matrix(*weights)[:12, :12]
                assert np.abs(found - want).max() < 1e-11 * np.abs(want).max()


# -- saturation ---------------------------------------------------------------------------------


def forces(creep: Any, mu: float = 0.3) -> Any:
    """N, Fx, Fy, M of a cylinder on its rail with creepages along, across, and spin, 1/m."""
    V, x, y, spin = 20.0, *creep
    lever = R - 5e-5
    turn = V * (1 - 0.5 * x) / (1 + 0.5 * x) / lever  # (travel - circumference) / their mean is x
    mean = 0.5 * (V + turn * lever)
    body = jo.RigidBody(
        "wheel", 600.0, (40, 70, 40), position=(0, 0, lever), velocity=(V, mean * y, 0),
        angular_velocity=(0, turn, mean * spin),
    )  # fmt: skip
    contact = RailContact("c", jo.ground["origin"], body["origin"], R, mu=mu, axle=(0, 1, 0))
    sensor = RailContactSensor("s", contact)
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, contact, sensor)))
    engine.accelerations()
    return engine.sensors(), contact


def fastsim(contact: Any, load: float, creep: Any, mu: float, rows: int = 60) -> Any:
    """Fx, Fy of Kalker's simplified theory (Vehicle System Dynamics 11, 1982), an independent law.

    Strips along the rolling direction, from the leading edge: the traction of a bristle grows with
    the creepage over its flexibility until it reaches mu times a parabolic pressure.
    """
    one, C = contact.tread_patch.scale, contact.tread_patch.coefficients
    a, b = one.a * load ** (1 / 3), one.b * load ** (1 / 3)
    shear = E / 2 / (1 + NU)
    flex = 8 * a / (3 * shear * C.C11), 8 * a / (3 * shear * C.C22)
    turns = np.pi * a * np.sqrt(a / b) / (4 * shear * C.C23)
    total = np.zeros(2)
    for y in b * ((np.arange(rows) + 0.5) / rows * 2 - 1):
        edge = a * np.sqrt(1 - (y / b) ** 2)
        h = 2 * edge / rows
        p = np.zeros(2)
        for x in edge - h * (np.arange(rows) + 0.5):
            p = p - h * np.array(
                [
                    creep[0] / flex[0] - creep[2] * y / turns,
                    creep[1] / flex[1] + creep[2] * x / turns,
                ]
            )
            most = mu * 2 * load / np.pi / a / b * max(0.0, 1 - (x / a) ** 2 - (y / b) ** 2)
            size = np.linalg.norm(p)
            if size > most:
                p = p * most / size
            total += p * h * 2 * b / rows
    return total


@pytest.mark.parametrize(
    ("creep", "near"),
    [
        ((1e-3, 0, 0), 0.01),
        ((4e-3, 0, 0), 0.01),
        ((0, 2e-3, 0), 0.01),
        ((2e-3, -2e-3, 0), 0.01),
        ((1e-3, 1e-3, 0.2), 0.06),
        ((0, 0, 1.0), 0.1),
    ],
)
def test_saturation_against_fastsim(creep, near):
    """Two approximations of one theory: 1 % of mu N apart, with much spin up to 10 %."""
    found, contact = forces(creep)
    want = fastsim(contact, found[0], creep, 0.3)
    np.testing.assert_allclose(found[4:7], creep, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found[1:3], want, atol=near * 0.3 * found[0])


def test_saturation_follows_vermeulen_and_johnson():
    """(1 - (1 - e/3)^3) mu N up to e = 3 (Journal of Applied Mechanics 31, 1964), then mu N."""
    for x in (1e-4, 1e-3, 3e-3, 6e-3, 0.1):
        found, contact = forces((x, 0, 0))
        one, C = contact.tread_patch.scale, contact.tread_patch.coefficients
        N = found[0]
        e = E / 2 / (1 + NU) * one.a * one.b * N ** (2 / 3) * C.C11 * x / 0.3 / N
        want = 0.3 * N * (1 - max(0.0, 1 - e / 3) ** 3)
        assert -found[1] == pytest.approx(want, rel=1e-7)
        assert abs(found[2]) < 1e-9 * N
    for y in (-0.2, 0.3):  # a wheel that is dragged aside
        found, _ = forces((0.1, y, 0))
        assert np.hypot(*found[1:3]) == pytest.approx(0.3 * found[0], rel=1e-12)


def test_creep_never_gives_power():
    """Any creepages: the forces and the moment on the wheel take power."""
    rng = np.random.default_rng(6)
    for _ in range(40):
        creep = rng.normal(size=3) * (3e-3, 3e-3, 1.0)
        found, _ = forces(creep, mu=rng.choice([0.1, 0.4, 5.0]))
        assert found[1:4] @ found[4:7] < 0


def test_pressure_of_a_round_contact():
    """Equal radii: p0 = (6 N E*^2 / (pi^3 R^2))^(1/3), a^3 = 3 N R / (4 E*) (Johnson 1985, 4.2)."""
    body = jo.RigidBody("w", 600.0, (40, 70, 40), position=(0, 0, R - 5e-5))
    contact = RailContact("c", jo.ground["origin"], body["origin"], R, head=R, axle=(0, 1, 0))
    sensor = RailContactSensor("s", contact)
    engine = jo.model.Engine(jo.compile(jo.Mechanism(body, contact, sensor)))
    engine.accelerations()
    found = engine.sensors()
    N, half = found[0], E / 2 / (1 - NU**2)
    assert N == pytest.approx(4 / 3 * half * np.sqrt(R) * 5e-5**1.5, rel=1e-6)
    assert found[7] == pytest.approx((6 * N * half**2 / np.pi**3 / R**2) ** (1 / 3), rel=1e-6)
    np.testing.assert_allclose(found[8:10], (3 * N * R / 4 / half) ** (1 / 3), rtol=1e-6)
    np.testing.assert_allclose(found[10:], (R - 5e-5, 0.0), atol=1e-12)


# -- rest, input, files --------------------------------------------------------------------------


def test_a_wheel_at_rest_creeps_slowly():
    """A locked wheel under a pull: creepage v / (slow / 2), force G a b C11 per creepage."""
    pull, slow = 100.0, 0.1
    body = jo.RigidBody("wheel", 600.0, (40, 70, 40), position=(0, 0, R - 2e-5))
    slide = jo.RigidBody("slide", 1.0, (1, 1, 1), position=(0, 0, R))
    along = jo.Prismatic("along", jo.ground.at((0, 0, R)), slide["origin"], axis=(1, 0, 0))
    down = jo.Prismatic("down", slide["origin"], body["origin"], axis=(0, 0, 1))
    contact = RailContact(
        "c", jo.ground["origin"], body["origin"], R, damping=10.0, slow=slow, axle=(0, 1, 0)
    )
    load = jo.Force("pull", body["origin"], (pull, 0, 0))
    speed, state = jo.VelocitySensor("v", body["origin"]), RailContactSensor("s", contact)
    items = (body, slide, along, down, contact, load, speed, state, jo.Gravity((0, 0, -G)))
    run = jo.simulate(jo.compile(jo.Mechanism(*items)), 0.5, solver=jo.GeneralizedAlpha(1e-3))
    a, b = run["s"][-1, 8:10]
    stiffness = E / 2 / (1 + NU) * a * b * contact.tread_patch.coefficients.C11
    e = pull / (0.3 * 600 * G)  # saturation takes e / 3 and more of the creepage
    linear = 3 * (1 - (1 - e) ** (1 / 3)) / e
    assert run["v"][-1, 0] == pytest.approx(linear * pull / stiffness * slow / 2, rel=1e-3)


def test_a_flange_across_the_rail_has_no_contact():
    """Turned by more than 20 degrees its cone has no place that is nearest: values stay finite."""
    for degrees in (15.0, 25.0, 60.0):
        turn = jo.Rotate((0, 0, 1), degrees=degrees)
        body = jo.RigidBody("w", 600.0, (40, 70, 40), position=(0, 0, R - 1e-4), orientation=turn)
        axle = body["origin"].A[:, 1]
        contact = RailContact(
            "c", jo.ground["origin"], body["origin"], R, 0.05, play=7e-3, axle=axle
        )
        sensors = [RailContactSensor(name, contact, name) for name in ("tread", "flange")]
        engine = jo.model.Engine(jo.compile(jo.Mechanism(body, contact, *sensors)))
        engine.accelerations()
        assert np.isfinite(engine.sensors()).all()
        assert np.isfinite(engine.newton_matrix(1.0, 1.0, 1.0)).all()
        assert engine.sensors()[0] > 0


def test_bad_input_is_refused():
    body = jo.RigidBody("w", 1.0, (1, 1, 1), position=(0, 0, R))
    rail, hub = jo.ground["origin"], body["origin"]

    def refused(text: str, **more: Any) -> None:
        with pytest.raises(InputError, match=text):
            RailContact("c", rail, hub, R, **({"axle": (0, 1, 0)} | more))

    refused("axle does not lie across the rail", axle=None)
    refused("along the z axis of marker a", rail=(0, 0, 1))
    refused("side of the flange of a cylinder is not known", play=7e-3)
    refused("30 to 85", play=7e-3, flange_angle=0.2)
    refused("opposite signs", play=7e-3, cone=0.05, flange_angle=-1.2)
    refused("a flange has a play", flange_angle=1.2)
    refused("hollow by a radius", tread=-0.3)
    refused("must be below gauge_face", play=7e-3, cone=0.05, corner=0.05)
    refused("half axes of its contact are as", head=1e-4)
    refused("mu", mu=0.0)
    with pytest.raises(InputError, match="take two bodies"):
        RailContact("c", hub, hub, R, axle=(0, 1, 0))
    plain = RailContact("c", rail, hub, R, axle=(0, 1, 0))
    with pytest.raises(InputError, match="has no flange"):
        RailContactSensor("s", plain, "flange")
    with pytest.raises(InputError, match="must be a RailContact"):
        RailContactSensor("s", hub)  # type: ignore[arg-type]


def test_a_model_file_declares_it():
    model = parse_model(
        """
        bodies:
          - {type: rigid, name: axle, mass: 1200, inertia: [700, 100, 700],
             position: [0, 0, 0.46]}
        forces:
          - type: rail-contact
            name: left
            a: ground.origin
            b: axle.origin
            radius: 460 mm
            cone: -0.05
            play: 7 mm
            flange_angle: -70 deg
            axle: [0, 1, 0]
        sensors:
          - {type: rail-contact, name: s, contact: left, patch: flange}
        """
    )
    (left,) = model.mechanism.forces
    assert isinstance(left, RailContact) and left.play == pytest.approx(7e-3)
    assert left.flange_angle == pytest.approx(-np.radians(70))
    (sensor,) = model.mechanism.sensors
    assert sensor.contact is left and sensor.patch == "flange"
