"""Wheelsets on two rails: hunting, Klingel's wavelength, flanges, statics, energy, both cores."""

from __future__ import annotations

import warnings
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

import jousto as jo
from jousto.mechanism import RailContact, RailContactSensor

R, S, G = 0.46, 0.75, 9.81  # m: radius, half the distance of the rails; m/s2
E, NU, HEAD = 210e9, 0.3, 0.3
pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")


MASS, I_X, I_Y, I_Z = 1500.0, 800.0, 120.0, 800.0  # kg, kg m2: axle and box together
BOX, I_BOX, BRAKE = 100.0, 20.0, 1e5
K_Y, K_YAW = SOFT = 2e5, 1e5  # N/m, N m: suspension


def wheelset(
    V: float, start: Any, *, cone: float, y: float = 0.0, springs: Any = SOFT,
    push: float = 0.0, core: str = "auto", **more: Any,
) -> tuple[Any, Any]:  # fmt: skip
    """A wheelset with its box between springs on a heavy car at the speed V; start: z, spin."""
    z, spin = start
    axle = jo.RigidBody(
        "axle", MASS - BOX, (I_X - I_BOX, I_Y, I_Z - I_BOX), position=(0, y, z),
        velocity=(V, 0, 0), angular_velocity=(0, spin, 0),
    )  # fmt: skip
    box = jo.RigidBody("box", BOX, (I_BOX,) * 3, position=(0, y, z), velocity=(V, 0, 0))
    car = jo.RigidBody("car", 1e7, (1e7,) * 3, position=(0, 0, z), velocity=(V, 0, 0))
    wheels = [
        RailContact(
            *(name, jo.ground.at((0, side * S, 0)), axle.at((0, side * S, 0)), R, -side * cone),
            axle=(0, 1, 0), **more,
        )
        for name, side in (("left", 1), ("right", -1))
    ]  # fmt: skip
    track = jo.Prismatic("track", jo.ground.at((0, 0, z)), car["origin"], axis=(1, 0, 0))
    bearing = jo.Revolute("bearing", box["origin"], axle["origin"], axis=(0, 1, 0))
    K = (0, springs[0], 0, 0, BRAKE, springs[1])
    held = jo.Bushing("springs", car["origin"], box["origin"], K)
    sensors = [RailContactSensor(f"{w.name} tread", w) for w in wheels]
    if wheels[0].play is not None:
        sensors += [RailContactSensor(f"{w.name} flange", w, "flange") for w in wheels]
    sensors += [
        jo.PositionSensor("place", axle["origin"]),
        jo.AccelerationSensor("a", axle["origin"]),
        jo.mechanism.AngularAccelerationSensor("alpha", axle["origin"]),
    ]
    loads = [jo.Gravity((0, 0, -G))]
    if push:
        loads.append(jo.Force("push", box["origin"], (0, push, 0)))
    items = (axle, box, car, *wheels, track, bearing, held, *sensors, *loads)
    return jo.compile(jo.Mechanism(*items), core=core), wheels


@lru_cache
def steady(V: float, cone: float, mu: float) -> tuple[float, float]:
    """Height and spin without vertical and angular acceleration."""

    def residual(x: Any) -> list[float]:
        model, _ = wheelset(V, x, cone=cone, mu=mu)
        engine = jo.model.Engine(model)
        engine.accelerations()
        at = {sensor.name: sensor.offset for sensor in model.sensors}
        y = engine.sensors()
        return [y[at["a"] + 2] / G, y[at["alpha"] + 1]]

    x = fsolve(residual, (R + 0.5 * cone**2 * HEAD - 2e-5, V / (R + cone**2 * HEAD)), xtol=1e-13)
    return float(x[0]), float(x[1])


def linear(V: float, cone: float, wheel: Any, K_y: float, K_yaw: float) -> Any:
    """System matrix of (y, psi, y', psi'), both wheels on their rails, by Newton and Euler.

    The contacts are at b on both sides of the centre, on the radius r; the roll angle k y keeps
    them. The load moves from wheel to wheel by n, which the row of roll gives. Gyroscopic terms,
    the turned normal forces (gravitational stiffness), spin creepage -+g/r in the middle, its
    lateral forces F0 and their changes are there, terms of g^2 beside 1 are not. A. H. Wickens,
    Fundamentals of Rail Vehicle Dynamics, 2003, chapter 2, has the equations without F0.
    """
    g, C = cone, wheel.tread_patch.coefficients
    r, b, k = R + g * g * HEAD, S - HEAD * g, g / (S - g * (R + HEAD))
    weight, one = MASS * G, wheel.tread_patch.scale
    shear = E / 2 / (1 + NU)
    N = 0.5 * weight
    for _ in range(9):  # the lateral forces of spin carry a share of the weight
        ab = one.a * one.b * N ** (2 / 3)
        f11, f22 = shear * ab * C.C11, shear * ab * C.C22
        f23, f33 = shear * ab**1.5 * C.C23, shear * ab**2 * C.C33
        F0 = f23 * g / r
        N = 0.5 * weight - g * F0
    spin = V / r
    y, psi, v, turning, a = np.eye(5)  # coefficients of y, psi, y', psi' and y''
    # lateral creep forces without those of n, and all lateral forces
    creep = -2 * f22 * ((1 + r * k) * v / V - psi) - 2 * f23 * turning / V
    lateral, by_n = creep - 2 * (N + F0 * g) * k * y, -2 * g + 2 * F0 / N
    # roll: I_x k y'' - I_y W psi' = 2 b n - (Q k + 1) y W + ...
    roll = -(HEAD * k + 1) * weight * y + 2 * b * F0 * k * y + g * b * creep
    roll += 2 * HEAD * g * k * (F0 - N * g) * y + r * lateral - I_X * k * a + I_Y * spin * turning
    n = -roll / (2 * b + r * by_n + 2 * g * b * F0 / N)
    # m y'' = lateral forces;  I_z psi'' + I_y W k y' = yaw moments
    force = lateral + by_n * n - K_y * y
    y_row = force[:4] / (MASS - force[4])
    yaw = -2 * b * f11 * (k * S / r * y + b / V * turning) + 2 * (N * g - F0) * (b - r * g) * psi
    yaw += (
        2 * f23 * ((1 + r * k) * v / V - psi) - 2 * f33 * turning / V + 8 / 3 * f33 * g / r / N * n
    )
    yaw -= K_yaw * psi + I_Y * spin * k * v
    A = np.zeros((4, 4))
    A[0, 2] = A[1, 3] = 1.0
    A[2], A[3] = y_row, (yaw[:4] + yaw[4] * y_row) / I_Z
    return A


def slowest(A: Any) -> complex:
    """Eigenvalue of the hunting motion."""
    values = np.linalg.eigvals(A)
    return complex(max(values[values.imag > 0], key=lambda x: x.real))


def measured(V: float, cone: float, time: float, **more: Any) -> complex:
    """Growth rate and frequency of a small lateral motion, from the second half of a run."""
    start = steady(V, cone, 1e3)
    model, _ = wheelset(V, start, cone=cone, y=1e-6, mu=1e3, **more)
    run = jo.simulate(model, time, solver=jo.RK4(2.5e-4), output_step=2e-2)
    y = run["place"][len(run.time) // 4 :, 1]
    # y_(i+2) = p y_(i+1) + q y_i: two roots exp(lambda dt)
    p, q = np.linalg.lstsq(np.stack([y[1:-1], y[:-2]], axis=1), y[2:], rcond=None)[0]
    return complex(np.log(np.roots([1, -p, -q])[0] + 0j)) / 2e-2


@pytest.mark.parametrize(("V", "cone"), [(30.0, 0.025), (45.0, 0.05), (60.0, 0.05), (45.0, 0.1)])
def test_hunting_grows_as_in_the_linear_theory(V, cone):
    """Eigenvalue within 0.4 %: the roll mode, 200 rad/s, and g^2 are not in the closed form."""
    found = measured(V, cone, 1.2)
    _, wheels = wheelset(V, steady(V, cone, 1e3), cone=cone)
    want = slowest(linear(V, cone, wheels[0], K_Y, K_YAW))
    found = complex(found.real, abs(found.imag))
    assert abs(found - want) < 4e-3 * abs(want)


def test_critical_speed():
    """Speed at which hunting begins: 1 % of the root of the linear theory."""
    cone = 0.05
    _, wheels = wheelset(30.0, (R, 60.0), cone=cone)
    want = brentq(lambda V: slowest(linear(V, cone, wheels[0], K_Y, K_YAW)).real, 20.0, 50.0)
    pair = [want * 0.95, want * 1.05]
    rates = [measured(V, cone, 2.4).real for V in pair]
    assert rates[0] < 0 < rates[1]
    found = np.interp(0.0, rates, pair)
    assert found == pytest.approx(want, rel=0.01)


def test_a_slow_wheelset_sways_with_the_wavelength_of_klingel():
    """2 pi sqrt(r b / cone) within 1 %, b half the distance of the contacts; with b / s exactly."""
    V, cone = 4.0, 0.05
    found = measured(V, cone, 4.0, springs=(0, 0))
    wave = 2 * np.pi * V / abs(found.imag)
    b, r = S - HEAD * cone, R + HEAD * cone**2
    assert wave == pytest.approx(2 * np.pi * np.sqrt(r * b / cone), rel=0.01)
    # the head turns the contact inwards: r b (1 + r k) / (k s), k the roll over the displacement
    assert wave == pytest.approx(2 * np.pi * np.sqrt(r * b / cone * b / S), rel=1e-3)


# -- flange -------------------------------------------------------------------------------------

PLAY, PUSH, CONE = 7e-3, 30e3, 0.05


@lru_cache
def pushed(push: float) -> Any:
    """A loaded wheelset that a lateral force pushes against its left flange, when it is steady."""
    V = 10.0
    start = steady(V, CONE, 1e3)
    model, wheels = wheelset(
        V, start, cone=CONE, springs=(0, 1e8), push=push, mu=0.3, play=PLAY, damping=2.0
    )
    run = jo.simulate(model, 2.0, solver=jo.RK4(2e-4), output_step=0.01)
    return run, wheels


def test_flange_stops_at_the_play():
    """A steady push holds it there, but for the depth of the contact; no load before."""
    run, wheels = pushed(6e3)
    y, load = run["place"][:, 1], run["left flange"][:, 0]
    late = run.time > 1.0
    depth = load[late].mean() ** (2 / 3) * wheels[0].flange_patch.scale.approach
    # the angle of the flange lifts the depth of the tread, too, and the axle rolls
    np.testing.assert_allclose(y[late], PLAY, atol=3 * depth)
    assert 5 * depth < 0.05 * PLAY and (load[late] > 5e3).all()
    assert (load[y < 0.9 * PLAY] == 0).all() and (y < 0.9 * PLAY).sum() > 10


def test_load_moves_to_the_wheel_on_the_side_of_the_force():
    """The contacts carry weight, push and their moment: statics with the angles of the planes."""
    run, wheels = pushed(6e3)
    late = run.time > 1.5
    place, total, roll = run["place"][late, 1].mean(), np.zeros(3), 0.0
    lean = place * CONE / (S - CONE * (R + HEAD))
    up = {}
    for wheel, side in zip(wheels, (1, -1), strict=True):
        for name, patch in zip(("tread", "flange"), wheel.patches, strict=True):
            row = run[f"{wheel.name} {name}"][late].mean(axis=0)
            slope = lean - np.arctan(patch.slope)
            force = row[0] * np.array([0, -np.sin(slope), np.cos(slope)])
            force += row[2] * np.array([0, np.cos(slope), np.sin(slope)])
            total += force
            roll += (side * S + row[11] - place) * force[2] + row[10] * force[1]
            up[wheel.name] = up.get(wheel.name, 0.0) + force[2]
    assert total[2] == pytest.approx(MASS * G, rel=2e-3)
    assert total[1] == pytest.approx(-6e3, rel=5e-3)
    assert abs(roll) < 0.01 * 6e3 * R
    # push at the height R, weight beside the middle, over half the distance of the treads; the
    # flange is somewhat further inside
    want = (6e3 * R + MASS * G * place) / (S - CONE * HEAD)
    assert up["left"] - up["right"] == pytest.approx(want, rel=0.05)


# -- energy, cores ------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", [jo.RK4(2e-4), jo.GeneralizedAlpha(2e-4)], ids=["RK4", "alpha"])
def test_energy_of_a_hunting_wheelset(solver):
    """Between its flanges: the balance closes, creep never gives energy."""
    V, cone = 40.0, 0.1
    model, _ = wheelset(V, steady(V, cone, 1e3), cone=cone, y=5e-4, mu=0.3, play=5e-3, damping=1.0)
    run = jo.simulate(model, 1.2, solver=solver, output_step=5e-3)
    lost = run.energy.friction
    assert np.diff(lost).min() >= 0 and lost[-1] > 100.0
    error = 1e-4 if isinstance(solver, jo.RK4) else 1e-3
    assert np.abs(run.energy.error).max() < error * lost[-1]
    assert run["left flange"][:, 0].max() > 1e3 and run["right flange"][:, 0].max() > 1e3
    assert np.abs(run["place"][:, 1]).max() < 5.8e-3  # the flange rises on the corner


@pytest.mark.parametrize("core", ["joint", "maximal"])
def test_both_cores_agree(core):
    """A wheelset in its box, in joint coordinates and in maximal ones."""
    model, _ = wheelset(20.0, steady(20.0, 0.05, 1e3), cone=0.05, y=2e-3, mu=0.3, core=core)
    run = jo.simulate(model, 0.4, solver=jo.RK4(2e-4), output_step=0.02)
    other = CORES.setdefault("first", run["place"])
    np.testing.assert_allclose(run["place"], other, atol=1e-9)
    assert np.ptp(run["place"][:, 1]) > 5e-4


CORES: dict[str, Any] = {}


@pytest.mark.filterwarnings("default")
def test_linear_motions_of_a_wheel_that_rolls_are_warned_of():
    """Their axes turn with the wheel; at rest there is nothing to warn of."""
    model, _ = wheelset(40.0, (R + 2e-4, 80.0), cone=0.1)
    with pytest.warns(jo.JoustoWarning, match="wheel 'axle' rolls at 80 rad/s"):
        jo.simulation.linearise(model)
    with pytest.warns(jo.JoustoWarning, match="simulate a small motion"):
        jo.modes(model, damped=True)
    still, _ = wheelset(0.0, (R + 2e-4, 0.0), cone=0.1)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        jo.simulation.linearise(still)
