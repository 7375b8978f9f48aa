"""Tyres: closed form of the brush, published coefficients, tangents, energy, parked cars."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.mechanism import BrushTyre, MagicFormula, Tyre
from jousto.mechanism.forces.tyre import magic_curve
from jousto.model.native.native import displaced
from jousto.schema.read import parse_model

R, K, LOAD, G = 0.31, 2e5, 4000.0, 9.81
BRUSH = BrushTyre(0.9, load=LOAD, stiffness_x=90e3, stiffness_y=60e3, half_length=0.07)
MAGIC = MagicFormula()
pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


def wheel(v: Any, spin: float, *, load: float = LOAD, camber: float = 0.0) -> Any:
    """A wheel in motion that is pressed on the road by a load; camber: it leans to its left."""
    axle = np.array([0.0, np.cos(camber), -np.sin(camber)])
    height = R * np.cos(camber) - load / K
    body = jo.RigidBody(
        "wheel", 20.0, (0.6, 1.0, 0.6), position=(0, 0, height), velocity=v,
        angular_velocity=spin * axle,
    )  # fmt: skip
    return body, axle


def forces(law: Any, v: Any, spin: float, **more: Any) -> Any:
    """Force (3,) and moment about the centre of the wheel (3,) in steady slip."""
    body, axle = wheel(v, spin, **more)
    tyre = Tyre("tyre", jo.ground["origin"], body["origin"], R, law, K, axle=axle, sink=0.0)
    model = jo.compile(jo.Mechanism(body, tyre, jo.ForceSensor("f", tyre)))
    engine = jo.model.Engine(model)
    engine.start_states()
    engine.accelerations()
    return engine.sensors()[:6]


def brush(sx: float, sy: float, load: float) -> tuple[float, float, float]:
    """Pacejka 2012, equations 3.38 to 3.52, for slips in any direction, at a load."""
    share = load / LOAD
    cx, cy, a = 90e3 * share, 60e3 * share, 0.07 * np.sqrt(share)
    # bristles (cx, cy) / (2 a^2) s (a - x) against the parabola 3/4 mu load (a^2 - x^2) / a^3
    x = np.linspace(-a, a, 400001)
    pull = np.stack([cx * sx * (a - x), cy * sy * (a - x)]) / (2 * a * a)
    size, most = np.linalg.norm(pull, axis=0), 0.9 * 0.75 * load * (a * a - x * x) / a**3
    q = pull * np.minimum(1.0, most / np.maximum(size, 1e-300))
    return tuple(np.trapezoid(y, x) for y in (q[0], q[1], x * q[1]))


@pytest.mark.parametrize(
    ("sx", "sy"), [(0.01, 0), (-0.05, 0), (0, 0.03), (0, -0.15), (0.04, 0.06), (0.3, 0.2), (2, 0)]
)
@pytest.mark.parametrize("load", [LOAD, 2000.0])
def test_brush_is_the_integral_over_its_bristles(sx, sy, load):
    """Slip along and across, together, up to the sliding of the whole patch."""
    rolling = 20.0  # m/s
    v = (rolling - sx * rolling, -sy * rolling, 0.0)
    F = forces(BRUSH, v, rolling / R, load=load)
    x, y, moment = brush(sx, sy, load)
    scale = 0.9 * load
    assert F[2] == pytest.approx(load, rel=1e-12)
    np.testing.assert_allclose(F[:2], (x, y), atol=2e-6 * scale)
    lever = R - load / K
    assert F[5] == pytest.approx(moment, abs=2e-6 * scale * 0.07)
    assert F[3] == pytest.approx(lever * y, abs=2e-6 * scale)
    assert F[4] == pytest.approx(-R * x, abs=2e-6 * scale)


def test_brush_in_numbers():
    """Small slip: the stiffness, and a trail of a third of half the patch; sliding: mu load."""
    F = forces(BRUSH, (20.0, -20e-6, 0.0), 20.0 / R)
    assert F[1] == pytest.approx(60e3 * 1e-6, rel=1e-4)
    assert -F[5] / F[1] == pytest.approx(0.07 / 3, rel=1e-4)
    F = forces(BRUSH, (20.0, -20.0, 0.0), 20.0 / R)
    np.testing.assert_allclose(F[[1, 5]], (0.9 * LOAD, 0.0), atol=1e-9)


# largest forces of the source, N, fitted at each load by itself: SAE 870421, table of the car tyre
PEAKS = {2: (2193.0, 1936.0), 4: (4236.0, 3650.0), 6: (6090.0, 5237.0), 8: (7711.0, 6677.0)}


@pytest.mark.parametrize("load", PEAKS)
def test_magic_formula_has_the_published_peaks(load):
    """The polynomials in the load are within 1.5 % of the peaks D that the source lists."""
    slip = np.linspace(0, 40, 40001)
    for c, peak in zip((MAGIC.longitudinal, MAGIC.lateral), PEAKS[load], strict=True):
        assert magic_curve(c, load, slip).max() == pytest.approx(peak, rel=0.015)


@pytest.mark.parametrize("load", [2000.0, 4000.0, 7000.0])
def test_magic_formula_in_the_engine(load):
    """Pure slips against the formula as printed; loads in kN, slip in per cent and degrees."""
    V = 20.0
    for kappa in (-0.3, -0.02, 0.05):
        F = forces(MAGIC, (V, 0, 0), (1 + kappa) * V / R, load=load)
        assert F[0] == pytest.approx(magic_curve(MAGIC.longitudinal, load / 1e3, 100 * kappa))
        assert abs(F[1]) < 1e-9
    for degrees in (-12.0, 0.5, 4.0):
        F = forces(MAGIC, (V, -V * np.tan(np.radians(degrees)), 0), V / R, load=load)
        assert F[1] == pytest.approx(magic_curve(MAGIC.lateral, load / 1e3, degrees))
        assert F[5] == pytest.approx(magic_curve(MAGIC.aligning, load / 1e3, degrees), abs=1e-6)
        assert abs(F[0]) < 1e-9


def test_combined_slip_of_the_magic_formula_stays_in_its_ellipse():
    px, py = (
        magic_curve(c, 4.0, np.linspace(0, 30, 3001)).max()
        for c in (MAGIC.longitudinal, MAGIC.lateral)
    )
    for kappa in (-0.02, -0.1, 0.3):
        for slope in (-0.05, 0.1, 0.3):
            F = forces(MAGIC, (20, -20 * slope, 0), (1 + kappa) * 20 / R)
            assert (F[0] / px) ** 2 + (F[1] / py) ** 2 < 1 + 1e-9
            assert np.sign(F[0]) == np.sign(kappa) and np.sign(F[1]) == np.sign(slope)


def test_camber_pushes_to_the_side_to_which_the_wheel_leans():
    """a11 F of the source per degree, 59 N at 4 kN, and the shift a9 by 0.028 degrees."""
    lean = np.radians(2.0)
    F = forces(MAGIC, (20, 0, 0), 20 / R, camber=lean)
    c = MAGIC.lateral
    stiffness = c[3] * np.sin(c[4] * np.arctan(c[5] * 4)) * (1 - c[12] * 2)
    assert F[1] == pytest.approx(c[11] * 4 * 2 + stiffness * c[9] * 2, rel=2e-3)
    assert F[1] > 0  # to the left, the side of y


def guided(law: Any, *, relaxation: float, drift: float) -> Any:
    """A wheel that is carried along at 20 m/s, and across from 0.05 s on."""
    V, start = 20.0, 0.05
    height = R - LOAD / K
    slide = jo.RigidBody("slide", 1.0, (1, 1, 1), position=(0, 0, height), velocity=(V, 0, 0))
    fork = jo.RigidBody("fork", 1.0, (1, 1, 1), position=(0, 0, height), velocity=(V, 0, 0))
    body, axle = wheel((V, 0, 0), V / R)
    along = jo.Prismatic("along", jo.ground.at((0, 0, height)), slide["origin"], axis=(1, 0, 0))
    across = jo.Prismatic("across", slide["origin"], fork["origin"], axis=(0, 1, 0))
    spin = jo.Revolute("spin", fork["origin"], body["origin"], axis=axle)
    drives = (
        jo.Drive("d1", along.displacement, jo.Ramp(0, 1, before=0, after=V)),
        jo.Drive("d2", across.displacement, jo.Ramp(start, 1, before=0, after=drift * (1 - start))),
        jo.Drive("d3", spin.angle, jo.Ramp(0, 1, before=0, after=V / R)),
    )
    tyre = Tyre(
        *("tyre", jo.ground["origin"], body["origin"], R, law, K),
        axle=axle,
        sink=0.0,
        relaxation=relaxation,
    )
    sensor = jo.ForceSensor("f", tyre)
    return jo.compile(jo.Mechanism(slide, fork, body, along, across, spin, *drives, tyre, sensor))


@pytest.mark.parametrize("law", [BRUSH, MAGIC], ids=["brush", "magic"])
@pytest.mark.parametrize("solver", [jo.RK4(1e-4), jo.GeneralizedAlpha(2e-5)], ids=["RK4", "alpha"])
def test_slip_follows_with_the_relaxation_length(law, solver):
    """A small step of the slip angle: 1 - exp(-x / L) along the way x."""
    V, L, drift = 20.0, 0.25, -0.002
    run = jo.simulate(guided(law, relaxation=L, drift=drift), 0.15, solver=solver)
    after = run.time > 0.0502
    F = run["f"][after, 1]
    end = forces(law, (V, drift, 0), V / R)[1]
    wanted = end * (1 - np.exp(-V * (run.time[after] - 0.05) / L))
    np.testing.assert_allclose(F, wanted, atol=2e-3 * end)


@pytest.mark.parametrize("law", [BRUSH, MAGIC], ids=["brush", "magic"])
def test_tangent_is_the_derivative(law):
    """Newton's matrix against complex steps at constant deflections, in general motion."""
    rng = np.random.default_rng(4)
    for _ in range(12):
        body, axle = wheel((15.0, 1.0, -0.1), 45.0, camber=0.2)
        road = jo.RigidBody("road", 5.0, (1.0, 2.0, 2.5), velocity=(0.3, 0.2, 0.1))
        tyre = Tyre(
            *("tyre", road["origin"], body["origin"], R, law, K), axle=axle, damping=300.0,
            resistance=0.02,
        )  # fmt: skip
        engine = jo.model.Engine(jo.compile(jo.Mechanism(body, road, tyre)))
        engine.q[:] = displaced(engine.model, engine.q, 0.01 * rng.normal(size=12))
        engine.v[:] += rng.normal(size=12)
        engine.start_states()
        engine.states[:] += 0.005 * rng.normal(size=2)
        engine.accelerations()
        exact = engine.tangent()
        N = engine.newton_matrix(0.0, 1.0, 0.0)[:12, :12]
        assert np.abs(exact.D - N).max() <= 1e-11 * np.abs(exact.D).max()


def slope(law: Any, degrees: float, solver: Any, time: float, *, side: float = -0.3) -> Any:
    """A sledge of 1200 kg on three tyres that cannot turn, on a slope."""
    load = 1200 * G / 3
    car = jo.RigidBody("car", 1200.0, (300, 900, 1000), position=(0, 0, R - load / K))
    spots = ((1.2, 0.0), (-0.6, 0.7), (-0.6, -0.7))
    tyres = [
        Tyre(
            *(f"tyre{i}", jo.ground["origin"], car.at((*spot, 0)), R, law, K),
            damping=2e3,
            axle=(0, 1, 0),
        )
        for i, spot in enumerate(spots)
    ]
    a = np.radians(degrees)
    gravity = jo.Gravity((-G * np.sin(a), side, -G * np.cos(a)))
    p = jo.PositionSensor("p", car["origin"])
    v = jo.VelocitySensor("v", car["origin"])
    model = jo.compile(jo.Mechanism(car, *tyres, gravity, p, v))
    return jo.simulate(model, time, solver=solver, output_step=time / 200)


@pytest.mark.parametrize("law", [BRUSH, MAGIC], ids=["brush", "magic"])
@pytest.mark.parametrize(
    "solver", [jo.ROS2(5e-4), jo.GeneralizedAlpha(2e-3)], ids=["ROS2", "alpha"]
)
def test_a_parked_car_does_not_creep(law, solver):
    """On 15 degrees with the brakes on: it comes to rest and stays, to rounding."""
    run = slope(law, 15.0, solver, 30.0)
    rest = run["p"][run.time > 25.0]
    assert np.ptp(rest, axis=0).max() < 1e-11
    assert np.abs(run["v"][-1]).max() < 1e-12
    assert -0.03 < rest[-1, 0] < 0.0


def test_a_car_slides_down_a_slope_that_is_too_steep():
    """mu = 0.9 is 42 degrees: on 50 degrees g (sin - mu cos), from the start of sliding on."""
    run = slope(BRUSH, 50.0, jo.RK4(2e-4), 4.0, side=0.0)
    a = np.radians(50.0)
    late = run.time > 3.0  # when it has ceased to pitch
    fall = np.polyfit(run.time[late], run["v"][late, 0], 1)[0]
    size = G * np.sin(a) - 0.9 * G * np.cos(a)
    assert -fall == pytest.approx(size, rel=2e-5)


@pytest.mark.parametrize("law", [BRUSH, MAGIC], ids=["brush", "magic"])
def test_energy_of_a_braked_wheel(law):
    """What the slip dissipates is what the wheel loses; the balance closes."""
    body, axle = wheel((12.0, 0.5, 0.0), 5.0, load=20 * G)
    tyre = Tyre(*("tyre", jo.ground["origin"], body["origin"], R, law, K), axle=axle, damping=300.0)
    model = jo.compile(jo.Mechanism(body, tyre, jo.Gravity((0, 0, -G))))
    run = jo.simulate(model, 1.0, solver=jo.RK4(1e-4), output_step=0.01)
    assert np.abs(run.energy.error).max() < 1e-6 * run.energy.kinetic[0]
    assert run.energy.friction[-1] > 0.01 * run.energy.kinetic[0]


def test_newton_converges_with_the_response_of_the_slip():
    """The tangent contains the response of the deflections: two or three iterations a step."""
    run = slope(BRUSH, 15.0, jo.GeneralizedAlpha(2e-3, tangent="exact"), 1.0)
    assert run.work.iterations[-1] / run.work.steps[-1] < 3.5


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_both_cores_agree(core):
    """A pendulum that carries a wheel, in joint coordinates and in maximal ones."""
    arm = jo.RigidBody("arm", 5.0, (0.5, 0.5, 0.5), position=(0, 1.5, R), center=(0, -0.5, 0))
    body, axle = wheel((0, 0, 0), -20.0)
    hinge = jo.Universal("hinge", jo.ground.at((0, 1.5, R)), arm["origin"], (1, 0, 0), (0, 0, 1))
    spin = jo.Revolute("spin", arm.at((0, -1.5, -LOAD / K)), body["origin"], axis=axle)
    tyre = Tyre("tyre", jo.ground["origin"], body["origin"], R, BRUSH, K, axle=axle, damping=100.0)
    p = jo.PositionSensor("p", body["origin"])
    model = jo.compile(
        jo.Mechanism(arm, body, hinge, spin, tyre, jo.Gravity((0, 0, -G)), p), core=core
    )
    run = jo.simulate(model, 0.5, solver=jo.RK4(1e-4), output_step=0.01)
    other = CORES.setdefault("first", run["p"])
    np.testing.assert_allclose(run["p"], other, atol=1e-9)
    assert np.abs(run["p"][-1, 0]) > 0.01


CORES: dict[str, Any] = {}


def test_bad_input_is_refused():
    body = jo.RigidBody("w", 1.0, (1, 1, 1), position=(0, 0, R))
    road = jo.ground["origin"]
    with pytest.raises(InputError, match="axle is normal to the road"):
        Tyre("t", road, body["origin"], R, BRUSH, K)
    with pytest.raises(InputError, match="take two bodies"):
        Tyre("t", body["origin"], body["origin"], R, BRUSH, K, axle=(0, 1, 0))
    with pytest.raises(InputError, match="BrushTyre or MagicFormula"):
        Tyre("t", road, body["origin"], R, 3.0, K, axle=(0, 1, 0))  # type: ignore[arg-type]
    with pytest.raises(InputError, match="mu"):
        BrushTyre(0.0, load=1.0, stiffness_x=1.0, stiffness_y=1.0, half_length=1.0)
    with pytest.raises(InputError, match="lateral"):
        MagicFormula(lateral=(1.0, 2.0))


def test_a_model_file_declares_it():
    model = parse_model(
        """
        bodies:
          - {type: rigid, name: wheel, mass: 20, inertia: [0.6, 1, 0.6], position: [0, 0, 0.3]}
        forces:
          - type: tyre
            name: front
            a: ground.origin
            b: wheel.origin
            radius: 310 mm
            stiffness: 200 N/mm
            axle: [0, 1, 0]
            law: {type: magic-formula, nominal: 5 kN}
          - type: tyre
            name: other
            a: ground.origin
            b: wheel.origin
            radius: 0.31
            stiffness: 2e5
            axle: [0, 1, 0]
            law:
              {type: brush, mu: 0.9, load: 4e3, stiffness_x: 9e4, stiffness_y: 6e4,
               half_length: 0.07}
        """
    )
    front, other = model.mechanism.forces
    assert isinstance(front, Tyre) and front.law.nominal == 5000.0
    assert front.stiffness == 2e5
    assert other.law.mu == 0.9
