"""Steps of bounded work (``events="step"``): stick and slip change at the ends of steps.

Against closed forms (a block that stops on a slope, a belt), the pin pendulum located by SciPy
(`friction.py`), and conservation laws.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.simulation.solvers.base import prepared
from verification.friction import GRAVITY, Belt, PinPendulum
from verification.test_friction import block_on_a_belt, pendulum, swinging

STICKS = jo.mechanism.StickSlip()
METHODS = (jo.RK4, jo.ROS2, jo.GeneralizedAlpha)
CORES = ("joint", "maximal")
SLOPE, MU, SPEED = 0.3, 0.5, 2.0
PASSES = 2  # JO_END_PASSES

method = pytest.mark.parametrize("method", METHODS, ids=lambda one: one.__name__)
core = pytest.mark.parametrize("core", CORES)


def sliding(core: Any, *, kinetic: float = MU, static: float | None = None) -> jo.Model:
    """A block that slides down a slope from 2 m/s; x is along the slope."""
    block = jo.RigidBody("block", 2.0, (1, 1, 1), velocity=(SPEED, 0, 0))
    way = jo.Prismatic("way", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    return jo.compile(
        jo.Mechanism(
            *(block, way),
            jo.Friction("rub", way, kinetic, static, law=STICKS),
            jo.CoordinateSensor("x", way.displacement),
            jo.Gravity((GRAVITY * np.sin(SLOPE), 0, -GRAVITY * np.cos(SLOPE))),
        ),
        core=core,
    )


@core
@method
def test_a_block_on_a_slope_stops_where_the_closed_form_says(method: Any, core: str) -> None:
    """``v^2 / 2 g (mu cos a - sin a)``, to round-off: all forces are constant."""
    step = 0.013
    run = jo.simulate(sliding(core), 150 * step, solver=method(step, events="step"))
    distance = SPEED**2 / (2 * GRAVITY * (MU * np.cos(SLOPE) - np.sin(SLOPE)))
    assert run["x"].max() == pytest.approx(distance, rel=1e-10)
    (stop,) = run.events
    duration = 2 * distance / SPEED
    assert stop.change == "sticks"
    assert stop.time == pytest.approx(np.ceil(duration / step) * step, abs=1e-9)
    after = run["x"][run.time >= stop.time]
    assert np.ptp(after) == 0.0
    assert np.diff(run.energy.friction).min() >= 0.0
    lost = run.energy.friction[-1]
    assert lost == pytest.approx(MU * 2.0 * GRAVITY * np.cos(SLOPE) * distance, rel=1e-9)


@core
@method
def test_what_sticks_does_not_creep(method: Any, core: str) -> None:
    """For 1000 s, within 3 % of the static limit."""
    limit = float(np.tan(SLOPE))
    model = sliding(core, kinetic=1.02 * limit, static=1.03 * limit)
    run = jo.simulate(model, 1200.0, solver=method(0.02, events="step"), output_step=10.0)
    late = run["x"][run.time > 200.0]
    assert len(late) == 100
    assert np.ptp(late) == 0.0
    assert run.attributes["deferred"] == 0


@method
def test_the_belt_at_the_second_order_of_the_step(method: Any) -> None:
    """Stick and slip of a block on a belt: the error of ten periods."""
    belt, errors = Belt(), []
    period = belt.stick_time + belt.slip_time
    model = block_on_a_belt(STICKS)
    for step in (8e-3, 4e-3, 2e-3):
        run = jo.simulate(model, 8.8, solver=method(step, events="step"), output_step=0.008)
        located = jo.simulate(model, 8.8, solver=jo.RK4(1e-3), output_step=0.008)
        errors.append(np.abs(run["x"] - located["x"]).max())
        starts = np.array([one.time for one in run.events if one.change != "sticks"])
        assert np.abs(np.diff(starts).mean() - period) < 2 * step / len(starts)
        assert abs(run.energy.error[-1]) < 1e-3 * run.energy.friction[-1]
    assert errors[2] < 3e-5
    assert errors[0] / errors[2] > 10.0  # 16 at order 2


@method
def test_a_pin_that_turns_over_loses_no_speed(method: Any) -> None:
    """Every swing ends in a reversal without sticking; turning points located by SciPy."""
    exact = np.array(PinPendulum().turning_points(np.pi / 2, 3))
    errors = []
    for step in (8e-3, 2e-3):
        run = jo.simulate(pendulum(STICKS), 4.0, solver=method(step, events="step"))
        angle = run["angle"].ravel() + np.pi / 2
        turns = np.array([one.time for one in run.events])
        assert np.all((turns[:3] >= exact[:, 0] - 1e-4) & (turns[:3] <= exact[:, 0] + 1.01 * step))
        top = [np.abs(angle[np.abs(run.time - t) < 0.1]).max() for t in exact[:, 0]]
        errors.append(np.abs(np.array(top) - np.abs(exact[:, 1])).max())
    assert errors[1] < 5e-5
    assert errors[0] / errors[1] > 4.0  # at least the first order


@method
def test_flexible_bodies_lose_the_energy_of_the_located_run(method: Any) -> None:
    """Two beams in space, with a pin and a pole on which one slides and turns."""
    runs = [
        jo.simulate(swinging(STICKS), 0.4, solver=method(step, events=events), output_step=4e-4)
        for events, step in (("step", 2e-4), ("step", 5e-5), ("located", 5e-5))
    ]
    apart = [np.abs(run.q - runs[-1].q).max() for run in runs[:2]]
    assert apart[0] / apart[1] > 4.0
    assert np.diff(runs[0].energy.friction).min() >= 0.0
    assert runs[0].energy.friction[-1] == pytest.approx(runs[-1].energy.friction[-1], rel=1e-4)
    assert runs[1].energy.error[-1] == pytest.approx(runs[2].energy.error[-1], abs=1e-6)


def free_pair(core: str, joint: type[Any]) -> jo.Model:
    """Two free bodies with a rubbing joint between them, in space without gravity."""
    a = jo.RigidBody("a", 1.0, (0.1, 0.2, 0.3), velocity=(0.1, 0.2, 0.0))
    b = jo.RigidBody("b", 3.0, (0.2, 0.3, 0.1), position=(0.5, 0, 0), velocity=(0.9, 0.2, 0.0))
    rail = joint("rail", a.at((0.2, 0, 0)), b["origin"], axis=(1, 0, 0))
    pin = {"radius": 0.1} if joint is jo.Cylindrical else {}
    rub = jo.Friction("rub", rail, 0.3, preload=0.5, law=STICKS, **pin)
    return jo.compile(jo.Mechanism(a, b, rail, rub), core=core)


@core
@pytest.mark.parametrize("joint", [jo.Prismatic, jo.Cylindrical], ids=lambda one: one.__name__)
@method
def test_momentum_is_that_of_the_start(method: Any, joint: Any, core: str) -> None:
    """Of two free bodies, one of which stops on the other; their centre moves on evenly."""
    model = free_pair(core, joint)
    run = jo.simulate(model, 8.0, solver=method(0.05, events="step"))
    assert [one.change for one in run.events] == ["sticks"]
    centre = (run.q[:, 0:3] + 3.0 * run.q[:, 7:10]) / 4.0
    speed = np.array([0.7, 0.2, 0.0])
    even = centre[0] + speed * run.time[:, None]
    np.testing.assert_allclose(centre, even, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(run.v[-1, 0:3], speed, rtol=0.0, atol=1e-12)


def counted(model: jo.Model, solver: Any, steps: int) -> np.ndarray:
    """Evaluations of the accelerations in each step but the first."""
    engine = jo.model.Engine(model)
    native, rows = prepared(engine, solver, solver.step), np.zeros((1, engine.row_size))
    found = []
    for _ in range(steps):
        before = int(engine.counts.evaluations)
        status, _ = engine.run(native, 1, 10**9, rows)
        assert status == "ok"
        found.append(int(engine.counts.evaluations) - before)
    return np.array(found[1:])


def shaken(core: str) -> jo.Model:
    """A block on a floor, on a spring and under a harmonic load: it sticks and slips for ever."""
    block = jo.RigidBody("block", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    return jo.compile(
        jo.Mechanism(
            *(block, rail, jo.Gravity((0, 0, -GRAVITY))),
            jo.Spring("spring", rail.displacement, 100.0, free=0.0),
            jo.JointForce("shaker", rail.displacement, jo.Harmonic(amplitude=5.0, frequency=1.1)),
            jo.Friction("rub", rail, 0.2, 0.4, law=STICKS),
        ),
        core=core,
    )


@core
@pytest.mark.parametrize(("method", "usual"), [(jo.RK4, 4), (jo.ROS2, 3)])
def test_the_work_of_a_step_is_bounded(method: Any, usual: int, core: str) -> None:
    """Evaluations: two to stop, the passes, one to catch up; located, some steps need far more."""
    model = shaken(core)
    bounded = counted(model, method(2e-3, events="step"), 2000)
    assert np.median(bounded) == usual
    assert usual < bounded.max() <= usual + 3 + PASSES
    assert counted(model, method(2e-3), 2000).max() > 3 * bounded.max()


def test_thirty_hinges_that_release_one_another() -> None:
    """All at once, in two passes; what is left changes in the next step, and is counted."""
    items: list[Any] = [jo.Gravity((0, -GRAVITY, 0))]
    at = jo.ground["origin"]
    for i in range(30):
        place = {"position": (i, 0, 0), "markers": {"end": (1, 0, 0)}}
        body = jo.RigidBody(f"link {i}", 1.0, (0.1,) * 3, **place)
        hinge = jo.Revolute(f"hinge {i}", at, body["origin"], axis=(0, 0, 1))
        items += [body, hinge, jo.Friction(f"rub {i}", hinge, 0.1, radius=0.02, law=STICKS)]
        at = body["end"]
    model = jo.compile(jo.Mechanism(*items))
    solver = jo.RK4(1e-3, events="step")
    assert counted(model, solver, 300).max() <= 4 + 3 + PASSES
    with pytest.warns(jo.JoustoWarning, match="steps left a change of friction or an event to"):
        run = jo.simulate(model, 0.3, solver=solver)
    assert 0 < run.attributes["deferred"] < 30
    # of a hundred transitions in few steps: 1.4e-7 J of 0.07 J
    assert np.diff(run.energy.friction).min() > -1e-5 * run.energy.friction[-1]
    assert np.abs(run.energy.error).max() < 1e-3 * run.energy.friction[-1]
