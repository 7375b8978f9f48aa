"""Exact beams that begin without stress, load or motion, where no force gives a scale."""

from __future__ import annotations

import numpy as np
import pytest

import jousto as jo
from verification.mechanisms import STEEL

pytestmark = pytest.mark.filterwarnings("ignore:.*has no joint to another body")

START = 0.05  # s, when something begins
TURNED = jo.Rotate((1.0, -2.0, 0.7), degrees=77.0)
METHODS = {
    "generalised alpha": jo.GeneralizedAlpha(step=1e-3),
    "exact tangent": jo.GeneralizedAlpha(step=1e-3, tangent="exact"),
    "index 3": jo.GeneralizedAlpha(step=1e-3, projection=False),
    "Newmark": jo.simulation.Newmark(step=1e-3),
}


def rod(orientation=None, **options):
    """A round bar of 1 m, which is not along an axis unless it is asked to be."""
    turn = TURNED if orientation is None else orientation
    return jo.BeamBody(
        "rod",
        [(0, 0, 0), (1.0, 0.2, 0)],
        jo.Circle(0.01),
        STEEL,
        elements=4,
        orientation=turn,
        **options,
    )


def clamped(body, load):
    """The bar with its start fixed and a load at its end, in its own frame."""
    fixed = jo.Fixed("wall", jo.ground["origin"], body["start"])
    tip = jo.PositionSensor("tip", body["end"], relative_to=body["start"])
    return (body, fixed, tip, load)


def stepped(body):
    """A follower force that steps in."""
    signal = jo.Step(START)
    load = jo.Force("push", body["end"], (0, 0, 5.0), follow=True, signal=signal)
    return clamped(body, load)


def by_input(body):
    """A force by an input that stays at 0."""
    load = jo.Force("push", body["end"], (0, 0, 5.0), signal=jo.Input("push"))
    return clamped(body, load)


def floating(body):
    """A force on a bar that nothing holds."""
    load = jo.Force("push", body["end"], (0, 0, 5.0), signal=jo.Step(START))
    return (body, load)


def turned_later(body):
    """A motor that starts later."""
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["start"], axis=(0.3, 0, 1))
    motion = jo.SCurve((0, START, 1.0), (0.0, 0.0, 1.0))
    return (body, hinge, jo.Drive("motor", hinge.angle, motion))


MACHINES = (stepped, by_input, floating, turned_later)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("machine", MACHINES)
def test_what_is_at_rest_stays_there_until_something_begins(machine, method):
    model = jo.compile(jo.Mechanism(*machine(rod())))
    run = jo.simulate(model, 0.1, solver=METHODS[method])
    before = run.time < START
    # rounding of positions, of a rod of 1 m
    assert np.abs(run.q[before] - run.q[0]).max() < 1e-13
    if machine is not by_input:
        assert np.abs(run.q[-1] - run.q[0]).max() > 1e-5


@pytest.mark.parametrize("machine", MACHINES)
def test_what_is_at_rest_is_in_equilibrium(machine):
    model = jo.compile(jo.Mechanism(*machine(rod())))
    state = jo.equilibrium(model)
    np.testing.assert_allclose(state.q, model.q0, rtol=0, atol=1e-13)


@pytest.mark.parametrize("method", METHODS)
def test_the_motion_does_not_depend_on_the_direction_of_the_bar(method):
    """Along an axis the strains at rest are 0 to the last digit, elsewhere they are rounded."""
    along_x = jo.Rotate((0, 0, 1), radians=-np.arctan(0.2))
    runs = [
        jo.simulate(jo.compile(jo.Mechanism(*stepped(rod(turn)))), 0.1, solver=METHODS[method])
        for turn in (along_x, TURNED)
    ]
    moved = [np.linalg.norm(run["tip"] - run["tip"][0], axis=1) for run in runs]
    assert moved[0].max() > 1e-3
    # 1e-10 is the tolerance of the iteration, relative to the accelerations of every step
    np.testing.assert_allclose(moved[1], moved[0], rtol=0, atol=1e-7 * moved[0].max())


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("step", [1e-6, 1e-4])
def test_rest_has_no_absolute_scale(size, step):
    """Lengths and times in the same ratio are the same motion."""
    points = size * np.array([(0, 0, 0), (0.3, 0.1, 0), (0.6, 0.15, 0.1), (1.0, 0.2, 0.25)])
    body = jo.BeamBody("rod", points, jo.Rectangle(0.02 * size, 0.05 * size), STEEL)
    fixed = jo.Fixed("wall", jo.ground["origin"], body["start"])
    load = jo.Force("push", body["end"], (0, 0, 1.0), signal=jo.Input("push"))
    model = jo.compile(jo.Mechanism(body, fixed, load))
    for solver in (jo.GeneralizedAlpha(size * step), jo.simulation.Newmark(size * step)):
        run = jo.simulate(model, 10 * size * step, solver=solver)
        # the first acceleration is rounded: a step of 1e5 / omega keeps 1e10 times 2e-16 of it
        assert np.abs(run.q[-1] - run.q[0]).max() < 1e-6 * size
