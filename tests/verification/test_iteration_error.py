"""The end of Newton's iteration by the error of the step changes neither error nor energy.

Ratios are to runs that iterate to 1e-10; the references are a run of the exact tangent at a
thirty-second of the step.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import march
from verification.test_kept_factors import LOOPS, loop

pytestmark = pytest.mark.filterwarnings("ignore::jousto.JoustoWarning")

GALLERY = ("four_bar.yaml", "slider_crank.yaml", "robot.yaml", "robot_hose, bare", "squeezer")
HALVINGS = (1, 2, 4, 8)
VISIBLE = 0.02  # of the error of a run


def strip() -> jo.Mechanism:
    """A strip of plastic on a ball joint, level and at rest, under gravity out of its plane.

    Its start excites bending waves that the step does not resolve.
    """
    beam = jo.BeamBody(
        "strip",
        [[0, 0, 0], [1.0, 0, 0]],
        jo.Rectangle(0.01, 0.01),
        jo.Material(E=2e9, nu=0.3, rho=7850.0),
        elements=20,
        mass="lumped",
    )
    ball = jo.Spherical("ball", jo.ground["origin"], beam["start"])
    return jo.Mechanism(beam, ball, jo.Gravity((0.0, -8.5, -4.9)))


def motion(model: Any, duration: float, step: float, begin: Any, **options: Any) -> Any:
    """Positions and velocities (10, 2, n, 3) at ten instants, energy error in J, iterations."""
    steps = round(duration / 10 / step)
    solver = jo.GeneralizedAlpha(duration / 10 / steps, **options)
    start = {} if begin is None else {"state": begin(model)}
    run = jo.simulate(model, duration, solver=solver, output_step=duration / 10, **start)
    R = [run.q[1:, b.iq : b.iq + 3] for b in model.bodies]
    V = [run.v[1:, b.iv : b.iv + 3] for b in model.bodies]
    states = np.stack([np.stack(R, axis=1), np.stack(V, axis=1)], axis=1)
    return states, float(np.abs(run.energy.error).max()), float(run.work.iterations[-1])


@pytest.mark.parametrize("name", [*LOOPS, *GALLERY, "strip"])
def test_the_iteration_is_not_visible_at_any_step(name: str) -> None:
    if name == "strip":
        make, duration, step, begin = strip, 0.3, 1e-3, None
    else:
        make, duration, step, begin = loop(name)
    model = jo.compile(make(), core="maximal")
    tight = {"tolerance": 1e-12, "tangent": "exact"}
    exact = motion(model, duration, step / 32, begin, **tight)[0]
    for k in HALVINGS:
        errors, drifts, iterations = [], [], []
        for tolerance in ("auto", 1e-10):
            states, drift, count = motion(model, duration, step / k, begin, tolerance=tolerance)
            errors.append(np.abs(states - exact).max(axis=(0, 2, 3)))
            drifts.append(drift)
            iterations.append(count)
        np.testing.assert_allclose(errors[0], errors[1], rtol=VISIBLE, err_msg=f"step / {k}")
        assert drifts[0] <= (1.0 + VISIBLE) * drifts[1], (k, drifts)
        assert iterations[0] <= iterations[1], (k, iterations)


@pytest.mark.parametrize("name", ["four-bars", "spatial slider-crank", "strip"])
def test_the_iteration_is_shorter(name: str) -> None:
    make, duration, step, begin = (strip, 0.3, 1e-3, None) if name == "strip" else loop(name)
    model = jo.compile(make(), core="maximal")
    auto, tight = (
        motion(model, duration, step, begin, tolerance=tolerance)[2]
        for tolerance in ("auto", 1e-10)
    )
    assert auto < (0.9 if name == "strip" else 0.75) * tight


@pytest.mark.parametrize("solver", [jo.GeneralizedAlpha, jo.simulation.Newmark])
@pytest.mark.parametrize("projection", [True, False])
def test_closed_joints_and_rest_stay(solver: Any, projection: bool) -> None:
    """Joints are as closed as with a tight tolerance; a machine at rest needs an iteration."""
    model = jo.compile(LOOPS["four-bars"][0]())
    run = march(model, solver(step=2e-3, projection=projection), 1.0)
    assert run.residuals[:, 0].max() < 1e-11 * model.size
    body = jo.RigidBody("bar", 2.0, (0.1, 0.2, 0.2), center=(0, 0, -0.5))
    pin = jo.Revolute("pin", jo.ground["origin"], body["origin"], axis=(0, 1, 0))
    hangs = jo.compile(jo.Mechanism(body, pin, jo.Gravity((0, 0, -9.81))))
    rest = jo.simulate(hangs, 0.2, solver=solver(step=1e-3, projection=projection))
    assert rest.work.iterations[-1] <= 200 + 2
    assert np.abs(rest.q - rest.q[0]).max() < 1e-12


def test_a_new_step_begins_with_the_tolerance() -> None:
    """Estimate and prediction refer to one step: a last short step does not inherit them."""
    model = jo.compile(LOOPS["four-bars"][0]())
    ends = []
    for tolerance in ("auto", 1e-10):
        engine = jo.model.Engine(model)
        for step, steps, how in ((2e-3, 100, "auto"), (1e-5, 1, tolerance)):
            solver = jo.GeneralizedAlpha(step=step, tolerance=how)
            native = engine.native_solver(
                solver.method, solver.step, solver.projection, **solver.options
            )
            engine.run(native, steps, steps, np.zeros((2, engine.row_size)))
        ends.append((int(engine.counts.iterations), [*engine.q, *engine.v]))
    assert ends[0] == ends[1]
