"""Stops: the restitution of single blows against quadrature, energy, exact slopes, all builds."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import jousto as jo
from jousto.model.model import ForceModel
from jousto.model.native import ensemble
from model import test_ensemble, test_forces

pytestmark = pytest.mark.filterwarnings("ignore:.*moves freely")

M = 2.0  # kg, of what strikes
K = M * (2 * np.pi * 50.0) ** 2
SPEED = 0.02  # m/s
ENDS = ((-1.0, "lower"), (1.0, "upper"))


def after(e: float, x: float) -> float:
    """Return the speed after a blow with speed x, both by that of the stop.

    From ``int_0^x v / phi(v) dv = int_0^y v / phi(-v) dv``, ``phi(v) = 1 + h s(v)``.
    """
    h = (1 - e * e) / (1 + e * e)

    def reached(y: float, sign: float) -> float:
        slow = min(y, 1.0)
        area = quad(
            lambda v: v / (1 + sign * h * 0.5 * v * (3 - v * v)),
            *(0, slow),
            epsabs=1e-13,
            epsrel=1e-13,
        )[0]
        return area + (y * y - 1) / 2 / (1 + sign * h) * (y > 1)

    return float(brentq(lambda y: reached(y, -1.0) - reached(x, 1.0), 1e-12, x, xtol=1e-14))


def struck(
    e: float,
    v: float,
    end: tuple[float, str] = ENDS[1],
    core: str = "joint",
    solver: Any = None,
) -> jo.Solution:
    """Run a mass that starts at a stop 10 um before it, until it has left."""
    side, word = end
    mass = jo.RigidBody("mass", M, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], mass["origin"], axis=(1, 0, 0))
    s = slide.displacement
    stop = jo.mechanism.Stop(
        "stop", s, **{word: side * 1e-5}, stiffness=K, restitution=e, speed=SPEED
    )
    sensors = jo.RateSensor("rate", s), jo.ForceSensor("force", stop), jo.CoordinateSensor("s", s)
    items = (mass, slide, stop, jo.Initial(s, rate=side * v), *sensors)
    model = jo.compile(jo.Mechanism(*items), core=core)
    # a blow takes a quarter of 20 ms in and more out; without restitution it creeps out
    solver = solver or jo.simulation.DormandPrince(tolerance=1e-9, output=1e-4)
    return jo.simulate(model, 1e-5 / v + (0.06 if e else 1.0), solver=solver)


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize("e", [0.1, 0.5, 0.9, 1.0])
@pytest.mark.parametrize("v", [0.004, 0.02, 0.1, 2.0])
def test_blows_come_back_as_quadrature_says(e: float, v: float, core: str) -> None:
    run = struck(e, v, core=core)
    back = -run["rate"][-1, 0] / v
    wanted = after(e, v / SPEED) / (v / SPEED) if e < 1 else 1.0
    # 1e-9 of a step, some 200 steps, and half of it where two speeds of 1e-3 are compared
    assert back == pytest.approx(wanted, abs=2e-6)
    if v >= 5 * SPEED and e >= 0.5:
        assert back == pytest.approx(e, abs=0.01)


@pytest.mark.parametrize("end", ENDS, ids=[x[1] for x in ENDS])
@pytest.mark.parametrize("e", [0.0, 0.3, 0.8])
def test_energy_closes_and_nothing_is_pulled(e: float, end: tuple[float, str]) -> None:
    run = struck(e, 1.0, end, solver=jo.RK4(2e-5))
    push = -end[0] * run["force"][:, 0]
    assert (push >= 0.0).all()
    assert push.max() > 0.5 * np.sqrt(K * M)
    lost = run.energy.dissipated
    kinetic = run.energy.kinetic
    assert (np.diff(lost) >= 0.0).all()
    # a step over a kink of the loss misses some (w h)^2, 4e-5, of it, and all others 1e-9
    assert lost[-1] == pytest.approx(kinetic[0] - kinetic[-1], rel=4e-5)
    assert lost[-1] == pytest.approx((1 - e * e) * kinetic[0], abs=2e-3)
    total = run.energy.kinetic + run.energy.springs + run.energy.dissipated
    assert np.ptp(total) < 4e-5 * kinetic[0]


def test_what_lies_on_a_stop_comes_to_rest_as_on_a_damper() -> None:
    """At rest ``d0 = M g / k`` and the damper is ``3 h M g / (2 speed)``: the envelope falls so."""
    g, e = 9.81, 0.5
    h = 0.75 / 1.25
    mass = jo.RigidBody("mass", M, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], mass["origin"], axis=(0, 0, 1))
    s, k = slide.displacement, 100 * K
    stop = jo.mechanism.Stop("stop", s, 0.0, stiffness=k, restitution=e, speed=1.0)
    begin = jo.Initial(s, value=-1.01 * M * g / k)
    items = (mass, slide, stop, begin, jo.CoordinateSensor("s", s), jo.Gravity((0, 0, -g)))
    run = jo.simulate(jo.compile(jo.Mechanism(*items)), 0.2, solver=jo.RK4(2e-5))
    x = (run["s"][:, 0] + M * g / k) / (0.01 * M * g / k)
    c = 1.5 * h * M * g / 1.0
    rate = c / (2 * M)
    w = np.sqrt(k / M - rate**2)
    exact = -np.exp(-rate * run.time) * (np.cos(w * run.time) + rate / w * np.sin(w * run.time))
    # the damper follows the load, which differs by 1 % of it
    assert np.abs(x - exact).max() < 0.02
    assert abs(x[-1]) < 0.5


@pytest.mark.parametrize("rate", [0.0, 0.3, -0.3, 2.0, -2.0], ids=str)
@pytest.mark.parametrize("upper", [True, False])
@pytest.mark.parametrize("kind", [0, 1, 2], ids=["distance", "along", "angle"])
def test_slopes_are_those_of_complex_steps(kind: int, upper: bool, rate: float) -> None:
    low, high = (-1e300, 0.01) if upper else (9.0, 1e300)
    data = np.array([300.0, low, high, 0.6, 1.0])
    force = ForceModel("stop", "stop", data, coordinate=kind)
    model = test_forces.two_bodies(force)
    engine = jo.model.Engine(model)
    rng = np.random.default_rng(kind)
    engine.v[:] = rate * rng.normal(size=model.nv)
    engine.accelerations()
    exact = engine.tangent()
    n = len(exact.K)
    for found, wanted in (
        (engine.newton_matrix(0.0, 0.0, 1.0)[:n, :n], exact.K),
        (engine.newton_matrix(0.0, 1.0, 0.0)[:n, :n], exact.D),
    ):
        scale = max(np.abs(wanted).max(), 1.0)
        assert np.abs(found - wanted).max() < 1e-12 * scale
    bare = jo.model.Engine(test_forces.two_bodies())
    bare.v[:] = engine.v
    bare.accelerations()
    assert np.abs(exact.K - bare.tangent().K).max() > 1.0  # the stop is touched


@pytest.mark.skipif(ensemble.machines() == 1, reason="no build of lanes for this processor")
@pytest.mark.parametrize("high", [0.3, 0.8])
def test_machines_side_by_side(high: float) -> None:
    data = np.array([500.0, -1e300, high, 0.6, 0.5])
    force = ForceModel("stop", "stop", data, coordinate=0)
    model = test_forces.two_bodies(force)
    test_ensemble.assert_lanes(model, test_ensemble.SOLVERS["rk4"])


def test_a_servo_pushes_a_tree_to_its_stop_in_both_cores() -> None:
    """Two links with weight against stops of two angles: the same motion from both cores."""
    a = jo.RigidBody("a", 2.0, (0.1, 0.1, 0.1), center=(0.3, 0, 0))
    b = jo.RigidBody("b", 1.0, (0.05, 0.05, 0.05), center=(0.2, 0, 0), position=(0.6, 0, 0))
    one = jo.Revolute("one", jo.ground["origin"], a["origin"], axis=(0, 1, 0))
    two = jo.Revolute("two", a.at((0.6, 0, 0)), b["origin"], axis=(0, 1, 0))
    stops = (
        jo.mechanism.Stop("s1", one.angle, -0.4, 0.5, stiffness=2e4, restitution=0.3),
        jo.mechanism.Stop("s2", two.angle, -0.2, stiffness=5e3),
        jo.mechanism.Stop("s3", two.angle, upper=0.6, stiffness=5e3, restitution=0.8),
    )
    sensors = jo.CoordinateSensor("one", one.angle), jo.CoordinateSensor("two", two.angle)
    mechanism = jo.Mechanism(a, b, one, two, *stops, *sensors, jo.Gravity((0, 0, -9.81)))
    runs = [
        jo.simulate(jo.compile(mechanism, core=core), 0.6, solver=jo.RK4(2e-5), output_step=1e-3)
        for core in ("joint", "maximal")
    ]
    assert runs[0]["one"].max() > 0.5
    assert runs[0]["two"].min() < -0.2 or runs[0]["two"].max() > 0.6
    for name in ("one", "two"):
        # kinks within steps: k (w h)^2 / M of 1e-3 of the rates, after some blows
        assert np.abs(runs[0][name] - runs[1][name]).max() < 1e-6
    for run in runs:
        assert run.energy.relative_error < 1e-3


def test_limits_are_checked() -> None:
    mass = jo.RigidBody("mass", M, (1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], mass["origin"])
    s = slide.displacement
    with pytest.raises(jo.InputError, match="stop 'x': has no limit; give lower, upper or both"):
        jo.mechanism.Stop("x", s, stiffness=1.0)
    with pytest.raises(jo.InputError) as error:
        jo.mechanism.Stop("x", s, 0.2, 0.1, stiffness=-1.0, restitution=1.5, speed=0.0)
    assert [problem.message.split(",")[0] for problem in error.value.problems] == [
        "stiffness is -1",
        "restitution is 1.5",
        "speed is 0",
        "lower limit 0.2 lies above the upper one",
    ]
