"""Estimates from a rigid run, against closed forms and the modes of a cantilever."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import brentq

import jousto as jo
from design.flexibility.flexible_machines import (
    EI,
    LENGTH,
    LINE_MASS,
    TIME,
    TIP_MASS,
    hub_acceleration,
    slewing_boom,
)
from jousto.design.flexibility.body_advice import BodyAdvice
from jousto.design.flexibility.expected import Expected, expected_readings, jump
from jousto.design.flexibility.impacts import has_impact
from jousto.design.flexibility.quasi_static import HeldBodies
from jousto.design.flexibility.swinging import period_change
from jousto.design.flexibility.variant_runs import Settings, run_variant
from jousto.design.flexibility.vibration import free_oscillation, highest_frequency, vibration
from jousto.mechanism.body_variants import with_rigid_bodies

Array = NDArray[np.float64]


def first_wave_number() -> float:
    """Return beta L of a cantilever with a mass at its tip, from its frequency equation."""
    ratio = TIP_MASS / (LINE_MASS * LENGTH)

    def equation(x: float) -> float:
        c, s, ch, sh = np.cos(x), np.sin(x), np.cosh(x), np.sinh(x)
        return float(1.0 + c * ch + ratio * x * (c * sh - s * ch))

    return float(brentq(equation, 0.5, 1.8, xtol=1e-14))


@pytest.fixture(scope="module")
def boom() -> Expected:
    machine = slewing_boom()
    settings = Settings(TIME, {"output_step": TIME / 400}, None)
    simple = run_variant(with_rigid_bodies(machine, ["boom"]).mechanism, settings)
    return expected_readings(jo.compile(machine), None, simple, 0)


def test_first_frequency_as_the_joints_hold_it(boom: Expected) -> None:
    w = first_wave_number() ** 2 * np.sqrt(EI / LINE_MASS) / LENGTH**2
    assert w == pytest.approx(13.29424477, rel=1e-9)
    # at the first instant nothing turns: later the spin changes the frequency
    assert boom.held.omega[0].min() == pytest.approx(w, rel=1e-7)
    assert boom.highest == pytest.approx(2.0 * np.pi / TIME, rel=1e-9)
    assert boom.ratio == pytest.approx(boom.highest / boom.first)


def test_static_deflection_under_the_loads_of_the_run(boom: Expected) -> None:
    # q = rho alpha x along the boom, m alpha L at its tip
    k = int(np.argmin(np.abs(boom.held.time - 0.25 * TIME)))
    assert boom.held.time[k] == pytest.approx(0.25 * TIME, abs=1e-12)
    alpha = np.pi**2 / TIME**2
    exact = alpha * (11.0 * LINE_MASS * LENGTH**5 / 120.0 + TIP_MASS * LENGTH**4 / 3.0) / EI
    assert exact == pytest.approx(0.03932050393, rel=1e-9)
    angle = 0.5 * np.pi * (0.25 - 1.0 / (2.0 * np.pi))
    across = np.array([-np.sin(angle), np.cos(angle), 0.0])
    moved = boom.held.increments(k, boom.held.static[k])[boom.full.bodies[1].iv :][:3]
    assert -moved @ across == pytest.approx(exact, rel=1e-8)
    # the sensor moves on a circle about the hub: a difference of second order in d / L
    rigid = LENGTH * np.array([np.cos(angle), np.sin(angle), 0.0])
    reading = -(boom.static[k, :3] - rigid) @ across
    assert reading == pytest.approx(exact, rel=0.5 * (exact / LENGTH) ** 2)
    assert exact * boom.bound == pytest.approx(0.0467, abs=1e-4)


def test_bound_covers_the_largest_deflection(boom: Expected) -> None:
    largest = 0.0462267008
    assert 0.03932050393 < largest < 0.03932050393 * boom.bound
    base = boom.held.time
    across = max(
        float(np.linalg.norm(one[:, :3] - boom.static[:, :3], axis=1).max())
        for one in boom.readings
    )
    assert base[0] == 0.0
    assert 0.0 < across < 0.2 * largest


def cantilever_modes(held: HeldBodies, time: Array, count: int) -> HeldBodies:
    """Return the boom in a linear stroke: constant modes, static deformation times alpha."""
    alpha = hub_acceleration(time)
    k = int(np.argmin(np.abs(held.time - 0.25 * TIME)))
    # transverse part alone: the deformation at zero speed of the hub is that of alpha
    unit = held.static[k] / hub_acceleration(held.time[k : k + 1])[0]
    rows = np.zeros(count, dtype=int)
    return replace(
        held,
        time=time,
        states=(held.states[0],) * count,
        static=alpha[:, None] * unit,
        shapes=(held.shapes[0],) * count,
        inverses=(held.inverses[0],) * count,
        motions=(held.motions[0],) * count,
        omega=held.omega[rows],
        damping=0.0 * held.damping[rows],
        bodies=held.bodies[rows],
    )


def test_largest_tip_deflection_of_the_linear_boom(boom: Expected) -> None:
    time = np.linspace(0.0, TIME, 6001)
    linear = cantilever_modes(boom.held, time, len(time))
    still = np.zeros(linear.static.shape[1])
    p, _ = vibration(linear, still, still)
    # displacement of the tip across the boom that the hub holds, per unit p
    tip = linear.motions[0][7 + linear.static.shape[1]] @ linear.inverses[0]
    assert np.abs(linear.static @ tip).max() == pytest.approx(0.03932050393, rel=1e-7)
    assert np.abs(p @ tip).max() == pytest.approx(0.0462267008, rel=2e-6)


@pytest.mark.parametrize("damping", [0.0, 3.0, 20.0, 60.0])
def test_free_oscillation_of_any_damping(damping: float) -> None:
    # against the exponential of the matrix of the system
    from scipy.linalg import expm

    w, t = 10.0, 0.37
    exact = expm(np.array([[0.0, 1.0], [-(w**2), -damping]]) * t) @ [0.2, -1.5]
    ones = np.ones(1)
    c, dc = free_oscillation(0.2 * ones, -1.5 * ones, w * ones, damping * ones, t)
    assert [c[0], dc[0]] == pytest.approx(exact, rel=1e-10, abs=1e-12)


def test_spring_in_series_with_a_part() -> None:
    # V / T = k_s / k_p; the period of the rigid machine is shorter by 1 - 1 / sqrt(1 + k_s / k_p)
    longer = period_change(0.25, 1.0)
    assert 1.0 - 1.0 / (1.0 + longer) == pytest.approx(0.1055728090, abs=1e-10)
    assert period_change(1.0, 0.0) == 0.0


def test_highest_frequency_of_loads() -> None:
    t = np.linspace(0.0, 4.0, 801)
    loads = np.stack([np.sin(2.0 * np.pi * 0.5 * t), 0.1 * np.sin(2.0 * np.pi * 5.0 * t)], axis=1)
    # the second one has 1 % of the energy, then 6 %
    assert highest_frequency(t, loads) == pytest.approx(2.0 * np.pi * 0.5)
    assert highest_frequency(t, loads * [1.0, 2.6]) == pytest.approx(2.0 * np.pi * 5.0)
    assert highest_frequency(t, 0.0 * loads + 3.0) == 0.0


@pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")
@pytest.mark.parametrize(
    ("signal", "jumps"),
    [(jo.Ramp(0.0, 0.313, 0.0, 0.4), True), (jo.SCurve((0.0, 0.313), (0.0, 0.4)), False)],
)
def test_drive_whose_velocity_jumps_is_an_impact(signal: object, jumps: bool) -> None:
    bar = jo.RigidBody("bar", 1.0, (0.1, 0.1, 0.1))
    hinge = jo.Revolute("hinge", jo.ground["origin"], bar["origin"])
    model = jo.compile(jo.Mechanism(bar, hinge, jo.Drive("drive", hinge.angle, signal)))
    assert has_impact(model, jo.simulate(model, 0.5, output_step=0.01)) is jumps


@pytest.mark.parametrize(("wall", "hit"), [(-0.5, True), (-3.0, False)])
def test_stop_that_is_hit_is_an_impact(wall: float, hit: bool) -> None:
    ball = jo.RigidBody("ball", 1.0, (0.1, 0.1, 0.1))
    rail = jo.Prismatic("rail", jo.ground["origin"], ball["origin"], axis=(0, 0, 1))
    stop = jo.mechanism.Stop("stop", rail.displacement, lower=wall, stiffness=1e5)
    machine = jo.Mechanism(ball, rail, stop, jo.Gravity((0, 0, -9.81)))
    model = jo.compile(machine)
    assert has_impact(model, jo.simulate(model, 0.4)) is hit


def test_jump_of_a_reading_between_instants() -> None:
    t = np.linspace(0.0, 1.0, 401)
    smooth = np.sin(2.0 * np.pi * 3.0 * t)
    assert jump(smooth, "N") < 1e-3
    assert jump(smooth + 5.0 * (t > 0.4), "N") == pytest.approx(5.0, abs=0.02)
    # of a load that is there from the second instant on
    assert jump(np.where(t > 0.0, -40.0, 0.0), "N") == pytest.approx(40.0)
    assert np.isnan(jump(smooth, "m"))


def test_resonance_has_no_estimate(boom: Expected) -> None:
    base = boom.static[:, 0]
    assert np.isfinite(boom.upper(base, base, [base], 0.0))
    resonant = replace(boom, amplification=3.0)
    assert resonant.upper(base, base, [base], 0.0) == np.inf
    # a stroke of r = 0.16 deflects by at most 1 / (1 - r)
    assert 1.0 < boom.amplification < 1.0 / (1.0 - boom.ratio / 0.85)  # 0.85: softest of SCATTER
    advice = BodyAdvice("boom", (), 0.02, 0.1, ratio=1.5, amplification=4.0)
    assert advice.verdict == "flexible"
    reason = "not estimable: dynamic, r = 1.5, its vibration grows to 4 times the static"
    assert next(advice.reasons()).startswith(reason)
    free = BodyAdvice("boom", (), 0.02, 0.1, ratio=0.5, amplification=1.0, slower=0.07)
    assert "free motions are slower by 7 %; run it flexible" in next(free.reasons())
