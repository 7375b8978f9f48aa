"""DormandPrince: errors follow the tolerance, dense output, known jumps, stiffness, broken runs."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time as clock
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import scipy.special
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app
from jousto.simulation.state import State
from verification.mechanisms import chain, orders

G = 9.81


# -- motions with closed forms ------------------------------------------------------------------


def rigid_pendulum(angle=2.5):
    """A mass of 1 kg, 0.1 kg m2 on an arm of 1 m, released at rest at `angle` from hanging."""
    bob = jo.RigidBody(
        "bob",
        1.0,
        (0.1, 0.1, 0.1),
        center=(0.0, -1.0, 0.0),
        orientation=jo.Rotate((0, 0, 1), degrees=np.degrees(angle)),
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], bob["origin"], axis=(0, 0, 1))
    return jo.Mechanism(
        bob, hinge, jo.Gravity((0, -G, 0)), jo.CoordinateSensor("angle", hinge.angle)
    )


def pendulum_angle(t, start=2.5):
    """theta(t) = 2 asin(k sn(K - w t)), k = sin(start / 2) (Whittaker, Analytical Dynamics, 44)."""
    k = np.sin(0.5 * start)
    quarter = scipy.special.ellipk(k**2)
    sn = scipy.special.ellipj(quarter - np.sqrt(G / 1.1) * t, k**2)[0]
    return 2.0 * np.arcsin(k * sn)


def follow(model, t_end, tolerance, output=None, **options):
    solver = jo.simulation.DormandPrince(
        tolerance=tolerance, output=output or t_end / 50, **options
    )
    return jo.simulate(model, t_end, solver=solver)


@cache
def pendulum_model():
    return jo.compile(rigid_pendulum())


def pendulum_error(run):
    exact = pendulum_angle(run.time) - 2.5
    return float(np.abs(run["angle"][:, 0] - exact).max())


def test_the_error_of_a_pendulum_follows_the_tolerance():
    tolerances = np.array([1e-4, 1e-6, 1e-8, 1e-10])
    runs = [follow(pendulum_model(), 4.0, t) for t in tolerances]
    errors = np.array([pendulum_error(run) for run in runs])
    steps = np.array([run.work.steps[-1] for run in runs])
    # error per step: over some 50 steps the error is a few hundred tolerances at most
    assert (errors < 300 * tolerances).all(), errors
    # errors ~ steps^-5: two decades of tolerance are 10^(2/5) = 2.5 times the steps
    assert np.log(steps[-1] / steps[0]) / np.log(1e6) == pytest.approx(0.2, abs=0.03)
    # below 1e-6, where a swing takes more than some ten steps
    order = -np.polyfit(np.log(steps[1:]), np.log(errors[1:]), 1)[0]
    assert order == pytest.approx(5.0, abs=0.25)


def planet(eccentricity=0.6):
    """A ball under a force of 1/r^2 towards the origin, at the point nearest to it."""

    def attraction(t, x):
        return np.concatenate([-x[:3] / np.linalg.norm(x[:3]) ** 3, np.zeros(3)])

    ball = jo.RigidBody(
        "ball",
        1.0,
        (0.1, 0.1, 0.1),
        position=(1 - eccentricity, 0, 0),
        velocity=(0, np.sqrt((1 + eccentricity) / (1 - eccentricity)), 0),
    )
    pull = jo.UserForce("pull", ball["origin"], attraction)
    place = jo.PositionSensor("place", ball["origin"])
    return jo.Mechanism(ball, pull, jo.Gravity((0, 0, 0)), place)


def kepler(t, eccentricity=0.6):
    """Position after t, from Kepler's equation M = E - e sin E."""
    E = t.copy()
    for _ in range(50):
        E = E - (E - eccentricity * np.sin(E) - t) / (1 - eccentricity * np.cos(E))
    return np.stack(
        [np.cos(E) - eccentricity, np.sqrt(1 - eccentricity**2) * np.sin(E), 0 * E], axis=1
    )


@pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")
def test_steps_follow_the_speed_of_a_planet():
    model = jo.compile(planet())
    runs = [follow(model, 2 * np.pi, t, 2 * np.pi / 200) for t in (1e-6, 1e-9)]
    errors = [np.abs(run["place"] - kepler(run.time)).max() for run in runs]
    assert errors[0] < 3e-4
    assert errors[1] < 3e-7
    # slow far away: the angular momentum r^2 w is constant, and so are steps times w or so
    step = runs[1].work.step[1:]
    assert step[90:110].min() > 3 * step[:5].max()


@cache
def crank():
    """A crank of 0.2 m that turns as a quadratic of time, a rod of 0.7 m and a slider."""
    wheel = jo.RigidBody("crank", 1.0, (0.01,) * 3, markers={"pin": (0.2, 0, 0)})
    rod = jo.RigidBody(
        "rod",
        2.0,
        (0.1,) * 3,
        center=(0.35, 0, 0),
        position=(0.2, 0, 0),
        markers={"end": (0.7, 0, 0)},
    )
    slider = jo.RigidBody("slider", 3.0, (0.01,) * 3, position=(0.9, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))
    pin = jo.Spherical("pin", wheel["pin"], rod["origin"])
    wrist = jo.Universal("wrist", rod["end"], slider["origin"], axis_a=(0, 0, 1), axis_b=(0, 1, 0))
    guide = jo.Prismatic("guide", jo.ground.at((0.9, 0, 0)), slider["origin"], axis=(1, 0, 0))
    turn = jo.Drive("turn", hinge.angle, jo.SCurve((0.0, 0.3, 0.5, 1.0), (0.0, 4.0, 4.0, -3.0)))
    place = jo.PositionSensor("place", slider["origin"])
    angle = jo.CoordinateSensor("angle", hinge.angle)
    return jo.compile(
        jo.Mechanism(wheel, rod, slider, hinge, pin, wrist, guide, turn, place, angle)
    )


def test_a_driven_slider_crank_keeps_to_its_drive():
    run = follow(crank(), 1.0, 1e-7, 0.01)
    angle = jo.SCurve((0.0, 0.3, 0.5, 1.0), (0.0, 4.0, 4.0, -3.0))
    exact = np.array([angle(t) for t in run.time])
    np.testing.assert_allclose(run["angle"][:, 0], exact, rtol=0, atol=1e-11)
    x = 0.2 * np.cos(exact) + np.sqrt(0.7**2 - (0.2 * np.sin(exact)) ** 2)
    np.testing.assert_allclose(run["place"][:, 0], x, rtol=0, atol=1e-11)
    # interpolated states are projected like those at the ends of steps
    assert run.residuals.position.max() < 1e-12
    assert run.residuals.velocity.max() < 1e-10
    assert np.abs(run.energy.error).max() < 1e-5 * run.energy.kinetic.max()


# -- order --------------------------------------------------------------------------------------


def fixed(model, steps, t_end):
    """Steps of one length, without error control."""
    engine = jo.model.Engine(model)
    native = engine.native_solver("dopri", t_end / steps, True)
    rows = np.zeros((1, engine.row_size))
    assert engine.run(native, steps, steps, rows)[0] == "ok"
    return rows[0, 1 : 1 + model.nq]


def test_fixed_steps_converge_with_order_5():
    model = jo.compile(chain("revolute"))
    t = 0.05
    exact = fixed(model, 3200, t)
    errors = [float(np.abs(fixed(model, n, t) - exact).max()) for n in (100, 200, 400, 800)]
    assert orders(errors)[-1] == pytest.approx(5.0, abs=0.3)


def test_dense_output_is_of_order_4_within_a_step():
    # one step of h, rows at twentieths of it; the last of the rows is the step itself
    model = pendulum_model()
    errors, ends = [], []
    for h in (0.2, 0.1, 0.05):
        solver = jo.simulation.DormandPrince(tolerance=0.1, first_step=h, max_step=h, output=h / 20)
        run = jo.simulate(model, h, solver=solver)
        assert run.work.steps[-1] == 1
        gap = np.abs(run["angle"][:, 0] - (pendulum_angle(run.time) - 2.5))
        errors.append(float(gap[1:-1].max()))
        ends.append(float(gap[-1]))
    # of order 4: the error of one step is of order 5
    assert (orders(errors) > 4.6).all(), errors
    assert (orders(ends) > 5.5).all(), ends


# -- known jumps --------------------------------------------------------------------------------


def block(signal, mass=2.0):
    """A mass on a slide, pushed by 1 N times the signal."""
    body = jo.RigidBody("block", mass, (1.0,) * 3)
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    push = jo.Force("push", body["origin"], (1.0, 0, 0), signal=signal)
    return jo.compile(
        jo.Mechanism(
            body,
            slide,
            push,
            jo.PositionSensor("x", body["origin"]),
            jo.VelocitySensor("v", body["origin"]),
        )
    )


def test_a_short_pulse_is_never_missed():
    # 5 ms of 100 N in 10 s of rest: 0.5 N s
    pulse = jo.Step(7.123, 0.0, 100.0) - jo.Step(7.128, 0.0, 100.0)
    run = follow(block(pulse), 10.0, 1e-6, 0.5)
    assert run["v"][-1, 0] == pytest.approx(0.25, rel=1e-12)
    late = run.time > 7.2
    np.testing.assert_allclose(run["x"][late, 0], 0.25 * (run.time[late] - 7.1255), rtol=1e-11)
    assert np.abs(run.energy.error).max() < 1e-13
    assert run.work.steps[-1] < 40


def test_kinks_of_tables_are_ends_of_steps():
    # a hat of 10 ms between long zeros: the speed is its area over the mass
    hat = jo.Table((0.0, 3.0, 3.005, 3.01, 10.0), (0.0, 0.0, 40.0, 0.0, 0.0))
    run = follow(block(hat), 10.0, 1e-6, 1.0)
    assert run["v"][-1, 0] == pytest.approx(0.5 * 0.01 * 40.0 / 2.0, rel=1e-12)
    ramp = jo.Ramp(1.0, 1.5, 0.0, 8.0)
    run = follow(block(ramp), 3.0, 1e-6, 1.0)
    assert run["v"][-1, 0] == pytest.approx((2.0 + 12.0) / 2.0, rel=1e-12)


def test_a_table_of_a_spring_has_no_times():
    body = jo.RigidBody("block", 1.0, (1.0,) * 3, velocity=(1, 0, 0))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    table = jo.Table((-1.0, 0.1, 0.2, 1.0), (30.0, -3.0, -6.0, -30.0))
    spring = jo.Spring("spring", slide.displacement, table=table)
    model = jo.compile(jo.Mechanism(body, slide, spring))
    assert model.breaks.tolist() == []
    both = jo.Force("push", body["origin"], (1.0, 0, 0), signal=table)
    model = jo.compile(jo.Mechanism(body, slide, spring, both))
    assert model.breaks.tolist() == [-1.0, 0.1, 0.2, 1.0]


def test_max_step_catches_a_pulse_of_a_function():
    def pulse(t, x):
        return np.array([100.0 if 7.0 < t < 7.2 else 0.0, 0, 0, 0, 0, 0])

    body = jo.RigidBody("block", 2.0, (1.0,) * 3)
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    push = jo.UserForce("push", body["origin"], pulse)
    model = jo.compile(jo.Mechanism(body, slide, push, jo.VelocitySensor("v", body["origin"])))
    run = follow(model, 10.0, 1e-7, 0.5, max_step=0.1)
    assert run.work.step.max() <= 0.1
    assert run["v"][-1, 0] == pytest.approx(10.0, rel=1e-5)


# -- events and friction ------------------------------------------------------------------------


def watched(stop):
    """2 kg pushed by 5 N until 0.3 m, then pulled by 1 N."""
    body = jo.RigidBody("block", 2.0, (1.0,) * 3)
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    place = jo.PositionSensor("x", body["origin"])
    there = jo.mechanism.Event("there", place, 0.3, "rising", stop, component="x")
    push = jo.Force(
        "push", body["origin"], (1.0, 0, 0), signal=jo.mechanism.Switched(there, 5.0, -1.0)
    )
    faster = jo.AccelerationSensor("a", body["origin"])
    return jo.compile(jo.Mechanism(body, slide, push, place, faster, there))


def test_signals_switch_at_events_within_steps():
    run = follow(watched(False), 5.0, 1e-6, 0.05)
    t = run.time
    t1 = np.sqrt(2 * 0.3 * 2.0 / 5.0)
    v1 = 2.5 * t1
    x = np.where(t < t1, 1.25 * t**2, 0.3 + v1 * (t - t1) - 0.25 * (t - t1) ** 2)
    np.testing.assert_allclose(run["x"][:, 0], x, rtol=0, atol=1e-10)
    # rows before the event, in the same step, know the force of before
    np.testing.assert_allclose(run["a"][:, 0], np.where(t < t1, 2.5, -0.5), rtol=0, atol=1e-12)
    assert run.work.steps[-1] < 25
    assert np.abs(run.energy.error).max() < 1e-12


def test_an_event_stops_a_run():
    run = follow(watched(True), 5.0, 1e-6, 0.05)
    assert run.complete
    assert run.nt == 11  # at 0 to 0.45 s and at the event
    assert run.time[-1] == pytest.approx(np.sqrt(0.24), abs=1e-11)
    np.testing.assert_allclose(run.time[:-1], 0.05 * np.arange(run.nt - 1), atol=1e-15)


def test_sticking_and_slipping_block():
    # pulled by 3 N/s, on a spring: it slips when the pull passes what friction and spring hold
    body = jo.RigidBody("block", 1.0, (0.1,) * 3)
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    model = jo.compile(
        jo.Mechanism(
            body,
            slide,
            jo.Spring("spring", slide.displacement, stiffness=100.0, free=0.0),
            jo.JointForce("pull", slide.displacement, jo.Ramp(0.0, 10.0, 0.0, 30.0)),
            jo.Friction("rub", slide, mu_kinetic=0.3, mu_static=0.5, law=jo.mechanism.StickSlip()),
            jo.Gravity((0, 0, -G)),
            jo.CoordinateSensor("x", slide.displacement),
        )
    )
    run = follow(model, 3.0, 1e-8, 0.01)
    start = 0.5 * G / 3.0  # s
    rest = run.time < start
    assert np.abs(run["x"][rest]).max() == 0.0
    # then 0.2 G and a rising force against a spring, until it rests again:
    # x = (0.2 G (1 - cos w t) + 3 (t - sin(w t) / w)) / k
    t = run.time[~rest] - start
    moves = t < 0.25
    x = (0.2 * G * (1 - np.cos(10 * t)) + 3.0 * (t - np.sin(10 * t) / 10)) / 100.0
    np.testing.assert_allclose(run["x"][~rest][moves, 0], x[moves], rtol=0, atol=1e-9)
    assert run.energy.friction[-1] > 0.1
    assert np.abs(run.energy.error).max() < 1e-7


# -- what cannot be done ------------------------------------------------------------------------


def stiff(stiffness):
    body = jo.RigidBody("needle", 1e-3, (1e-6,) * 3, velocity=(0.1, 0, 0))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    spring = jo.Spring("spring", slide.displacement, stiffness=stiffness)
    return jo.compile(jo.Mechanism(body, slide, spring))


def test_a_stiff_spring_ends_with_a_sentence():
    with pytest.raises(jo.simulation.RunFailed) as error:
        follow(stiff(1e13), 10.0, 1e-6, 0.1)
    sentence = str(error.value)
    assert "body 'needle'" in sentence
    assert "100000 between two outputs" in sentence
    assert "take ROS2 or GeneralizedAlpha" in sentence
    assert error.value.body == "needle"
    assert error.value.solution.nt >= 1


def test_a_function_that_jumps_for_ever_ends_with_a_sentence():
    # dry friction as a sign: at rest it changes within any step
    def sign(t, x):
        return np.array([-np.sign(x[12]) * 1e3, 0, 0, 0, 0, 0])

    body = jo.RigidBody("block", 1.0, (1.0,) * 3, velocity=(1, 0, 0))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    model = jo.compile(jo.Mechanism(body, slide, jo.UserForce("dry", body["origin"], sign)))
    solver = jo.simulation.DormandPrince(tolerance=1e-10, output=1.0)
    object.__setattr__(solver, "most", 2000)  # soon
    with pytest.raises(jo.simulation.RunFailed, match="body 'block'"):
        jo.simulate(model, 1.0, solver=solver)


def test_a_force_that_is_nan_beyond_a_point_is_not_stepped_over():
    def wall(t, x):
        return np.array([0.0 if x[0] < 1.0 else np.nan, 0, 0, 0, 0, 0])

    body = jo.RigidBody("block", 1.0, (2.0 / 3.0,) * 3, velocity=(1, 0, 0))  # 1 m wide
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    model = jo.compile(jo.Mechanism(body, slide, jo.UserForce("wall", body["origin"], wall)))
    with pytest.raises(jo.simulation.RunFailed, match="force 'wall'") as error:
        follow(model, 2.0, 1e-6, 0.1)
    assert 0.0 < error.value.time <= 1.0


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"tolerance": 0.0}, "tolerance is 0.0, must be between 1e-13 and 0.1"),
        ({"tolerance": "1e-6"}, "tolerance is '1e-6'"),
        ({"absolute": -1.0}, "absolute is -1.0, must be None or positive, m"),
        ({"first_step": float("nan")}, "first_step is nan"),
        ({"max_step": 0}, "max_step is 0, must be None or positive, s"),
        ({"output": True}, "output is True, must be a positive number of seconds"),
    ],
)
def test_impossible_settings(arguments, sentence):
    with pytest.raises(jo.InputError) as error:
        jo.simulation.DormandPrince(**arguments)
    assert sentence in str(error.value)


def test_all_wrong_settings_are_named_at_once():
    with pytest.raises(jo.InputError) as error:
        jo.simulation.DormandPrince(tolerance=1.0, output=0.0)
    assert "tolerance is 1.0" in str(error.value)
    assert "output is 0.0" in str(error.value)


def test_many_steps_are_foretold():
    part = jo.Part.beam(0.1, jo.Rectangle(0.01, 0.01), 8, jo.Material(2.1e11, 0.3, 7850.0))
    rod = jo.reduce(part, jo.CraigBampton(interfaces=("start",), modes=21))
    arm = jo.FlexibleBody("arm", rod)
    model = jo.compile(
        jo.Mechanism(
            arm, jo.Spherical("pivot", jo.ground["origin"], arm["start"]), jo.Gravity((0, -G, 0))
        )
    )
    from jousto.simulation.solvers.schedule import cautions, schedule

    solver = jo.simulation.DormandPrince()
    (sentence,) = cautions(model, solver, schedule(model, 100.0, solver))
    assert "modes of body 'arm'" in sentence
    assert "ROS2 does not mind them" in sentence
    assert cautions(model, solver, schedule(model, 1e-3, solver)) == []


# -- runs ---------------------------------------------------------------------------------------


def test_rows_are_at_equal_times_whatever_the_steps():
    model = pendulum_model()
    run = jo.simulate(
        model, 1.0, solver=jo.simulation.DormandPrince(tolerance=1e-5), output_step=0.001
    )
    np.testing.assert_array_equal(run.time, np.arange(1001) * 0.001)
    assert run.work.steps[-1] < 100
    assert pendulum_error(run) < 1e-3
    # between outputs far apart it takes as many steps as it needs, the same ones
    far = jo.simulate(model, 1.0, solver=jo.simulation.DormandPrince(tolerance=1e-5, output=0.25))
    np.testing.assert_array_equal(far.time, np.arange(5) * 0.25)
    assert far.work.steps[-1] == run.work.steps[-1]
    # rows are projected from nearby states: the same to the accuracy of the projection
    np.testing.assert_allclose(far.q, run.q[::250], rtol=0, atol=1e-11)


def test_slow_progress_does_not_change_a_run():
    model = jo.compile(chain("fixed", loads=True, damping=0.01))
    plain = follow(model, 0.05, 1e-5, 0.001)
    slow = jo.simulate(
        model,
        0.05,
        solver=jo.simulation.DormandPrince(tolerance=1e-5, output=0.001),
        progress=lambda t, w: clock.sleep(0.002),
    )
    for name in ("q", "v", "multipliers"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(slow, name))
    np.testing.assert_array_equal(plain.work.evaluations, slow.work.evaluations)
    np.testing.assert_array_equal(plain.energy.work, slow.energy.work)


def test_work_and_losses_close_the_balance():
    run = follow(jo.compile(chain("fixed", loads=True, damping=0.02)), 0.1, 1e-8, 0.001)
    assert run.energy.dissipated[-1] > 0.01
    assert np.abs(run.energy.work).max() > 0.01
    assert np.abs(run.energy.error).max() < 1e-7


def test_a_coarse_tolerance_costs_fewer_evaluations():
    model = pendulum_model()
    cheap, dear = (follow(model, 2.0, t) for t in (1e-3, 1e-9))
    assert cheap.work.evaluations[-1] < 0.3 * dear.work.evaluations[-1]
    # six a step, one a row and one at the start: FSAL holds in spite of the projection
    for run in (cheap, dear):
        tries = run.work.steps[-1] + run.work.rejected[-1]
        assert run.work.evaluations[-1] <= 6 * tries + run.nt + 1


def test_absolute_errors_that_do_not_matter_save_steps():
    model = pendulum_model()
    fine = follow(model, 1.0, 1e-9)
    coarse = follow(model, 1.0, 1e-9, absolute=1e-4)
    assert coarse.work.steps[-1] < 0.3 * fine.work.steps[-1]


FILE = """
name: swing
bodies:
  - {name: ball, mass: 2 kg, inertia: [0.01, 0.01, 0.01], center: [0, -1, 0]}
joints: [{type: spherical, name: pivot, a: ground.origin, b: ball.origin}]
gravity: [0, -9.81, 0]
simulation:
  t_end: 0.5 s
  solver:
    {type: DormandPrince, tolerance: 1e-4, absolute: 1 um, first_step: 1 ms, max_step: 20 ms,
     output: 50 ms}
"""


def test_a_model_file_and_the_command_line_know_it(tmp_path):
    path = tmp_path / "swing.yaml"
    path.write_text(FILE)
    solver = jo.read_model(path).simulation.solver
    assert solver == jo.simulation.DormandPrince(1e-4, 1e-6, 1e-3, 0.02, 0.05)
    for options, tolerance in ((), 1e-4), (("--tolerance", "1e-9"), 1e-9):
        words = ["run", str(path), "-o", str(tmp_path / "swing.h5"), "-q", *options]
        assert CliRunner().invoke(app, words, prog_name="jousto").exit_code == 0
        run = jo.load(tmp_path / "swing.h5")
        assert run.attributes["solver"] == repr(replace(solver, tolerance=tolerance))
        assert run.nt == 11


KILLED = """
import os, signal
import jousto as jo
from simulation.test_adaptive import pendulum_model
def kill(t, wall):
    if t > 12.0:
        os.kill(os.getpid(), signal.SIGKILL)
jo.simulate(pendulum_model(), 1e6, solver=jo.simulation.DormandPrince(tolerance=1e-9, output=0.05),
            path="killed.h5", progress=kill)
"""


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="no SIGKILL")
def test_a_killed_run_goes_on_from_its_last_row(tmp_path):
    folders = [str(Path(jo.__file__).parents[1]), str(Path(__file__).parents[1])]
    code = f"import sys; sys.path[:0] = {json.dumps(folders)}\n{KILLED}"
    ended = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=dict(os.environ))
    assert ended.returncode == -signal.SIGKILL
    rest = jo.load(tmp_path / "killed.h5")
    assert not rest.complete
    assert rest.time[-1] > 10.0
    assert pendulum_error(rest) < 1e-4
    # the motion has no clock: from the last row on it is the same motion
    state = State(rest.q[-1], rest.v[-1], rest.multipliers[-1])
    solver = jo.simulation.DormandPrince(tolerance=1e-9, output=0.05)
    again = jo.simulate(pendulum_model(), 1.0, solver=solver, state=state)
    exact = pendulum_angle(rest.time[-1] + again.time) - 2.5
    turns = again["angle"][:, 0] - exact
    assert np.abs(turns - turns[0]).max() < 1e-4


def test_turns_are_counted_over_long_steps():
    # nothing but rotation: steps are bounded by the turn of a body
    body = jo.RigidBody("rotor", 1.0, (1.0,) * 3, angular_velocity=(0, 0, 40.0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    model = jo.compile(jo.Mechanism(body, hinge, jo.CoordinateSensor("angle", hinge.angle)))
    run = follow(model, 10.0, 1e-3, 0.5)
    np.testing.assert_allclose(run["angle"][:, 0], 40.0 * run.time, rtol=1e-10, atol=1e-10)
    assert run.work.step.max() <= 1.0 / 40.0 + 1e-12
