"""The method of a run that names none."""

from __future__ import annotations

import logging

import numpy as np
import pytest

import jousto as jo
from jousto.simulation.running.simulate import describe
from jousto.simulation.solvers.default_solver import choose, fast
from jousto.simulation.solvers.explicit_growth import excess
from jousto.simulation.solvers.impact_time import shortest_blow

STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
G = (0, -9.81, 0)


def pendulum():
    rod = jo.RigidBody("rod", 1.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0))
    pivot = jo.Revolute("pivot", jo.ground["origin"], rod["origin"], axis=(0, 0, 1))
    return jo.Mechanism(rod, pivot, jo.Gravity(G), jo.PositionSensor("c", rod["center"]))


def strip():
    body = jo.BeamBody("strip", [[0, 0, 0], [1, 0, 0]], jo.Rectangle(0.01, 0.01), STEEL, elements=3)
    pivot = jo.Revolute("pivot", jo.ground["origin"], body["start"], axis=(0, 0, 1))
    return jo.Mechanism(body, pivot, jo.Gravity(G), jo.PositionSensor("c", body["end"]))


def rubbing(slip: float):
    block = jo.RigidBody("block", 1.0, (0.01, 0.01, 0.01), velocity=(1, 0, 0))
    rail = jo.Prismatic("rail", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    friction = jo.Friction("rub", rail, 0.3, law=jo.mechanism.Regularised(slip))
    return jo.Mechanism(
        block, rail, friction, jo.Gravity(G), jo.PositionSensor("c", block["center"])
    )


def hung(stiffness: float):
    bar = jo.RigidBody("bar", 2.0, (0.01, 0.01, 0.01))
    rubber = jo.Bushing(
        "rubber", jo.ground["origin"], bar["origin"], [stiffness] * 3 + [1e-3 * stiffness] * 3
    )
    return jo.Mechanism(bar, rubber, jo.Gravity(G), jo.PositionSensor("c", bar["center"]))


@pytest.mark.parametrize(
    ("values", "words"),
    [({"damping": 3e4}, "dampers"), ({"stiffness": 2e7}, "springs"),
     ({"stiffness": 2e7, "damping": 1.0}, "springs or dampers")],
)  # fmt: skip
def test_the_reason_names_what_is_there(values: dict[str, float], words: str) -> None:
    block = jo.RigidBody("block", 2.0, (0.01, 0.01, 0.01))
    slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    push = jo.Spring("push", slide.coordinates[0], **values)
    assert fast(jo.compile(jo.Mechanism(block, slide, push))) == words


@pytest.mark.filterwarnings("ignore:.*the error of the energy balance")
@pytest.mark.parametrize("stiffness", [1e4, 2e7, 1e9])
def test_springs_count_in_the_choice(stiffness: float):
    """x = -m g / c (1 - cos w t), whose mean is the static displacement."""
    run = jo.simulate(jo.compile(hung(stiffness)), 1.0)
    y, static = run["c"][:, 1], -2.0 * 9.81 / stiffness
    assert np.mean(y) == pytest.approx(static, rel=0.05)
    assert np.abs(y).max() < 2.1 * abs(static)


@pytest.mark.filterwarnings("ignore:.*the error of the energy balance")
@pytest.mark.parametrize("stiffness", [2e7, 1e9])
def test_a_force_in_python_hides_no_bushing(stiffness: float):
    """Half of the weight is pushed up: the bar hangs half as deep, and does not fly away."""
    bare = hung(stiffness)
    lift = jo.UserForce("lift", bare.bodies[0]["origin"], lambda t, x: [0, 9.81, 0, 0, 0, 0])
    model = jo.compile(jo.Mechanism(*bare.items, lift))
    assert choose(model, 1.0, None) == choose(jo.compile(bare), 1.0, None)
    y = jo.simulate(model, 0.2)["c"][:, 1]
    assert np.mean(y) == pytest.approx(-9.81 / stiffness, rel=0.05)


def test_a_machine_that_falls_over_needs_no_other_method():
    """An upright pendulum on a weak spring leaves its place at its own rate."""
    mass = jo.RigidBody("mass", 1.0, (0.01, 0.01, 0.01), center=(0, 0.1, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], mass["origin"], axis=(0, 0, 1))
    weak = jo.Servo("weak", hinge.angle, 0.0, kp=0.1)
    model = jo.compile(jo.Mechanism(mass, hinge, weak, jo.Gravity(G)))
    assert excess(model, jo.ROS2(), 1e-3) < 1e-3


@pytest.mark.filterwarnings("ignore:.*the error of the energy balance")
@pytest.mark.parametrize(
    "make,method,why",
    [
        (pendulum, jo.ROS2, "the default"),
        (strip, jo.GeneralizedAlpha, "exact beams"),
        (lambda: rubbing(0.5), jo.ROS2, "the default"),
        (lambda: hung(2e7), jo.ROS2, "fast for a step"),
        (lambda: hung(1e9), jo.GeneralizedAlpha, "too fast for ROS2"),
        (lambda: rubbing(1e-3), jo.ROS2, "friction or dampers are steep"),
    ],
)
def test_the_model_decides(make, method, why, caplog):
    model = jo.compile(make())
    with caplog.at_level(logging.INFO, "jousto"):
        run = jo.simulate(model, 0.01)
    assert run.attributes["solver"].startswith(method.__name__)
    assert why in run.attributes["chosen"]
    assert any(why in record.message for record in caplog.records)
    # the same as if it had been named
    other = jo.simulate(model, 0.01, solver=eval(run.attributes["solver"], vars(jo)))
    np.testing.assert_array_equal(run["c"], other["c"])
    assert other.attributes["chosen"] == ""


def test_the_choice_stands_in_the_file(tmp_path):
    jo.simulate(jo.compile(strip()), 0.01, path=tmp_path / "r.h5")
    found = jo.load(tmp_path / "r.h5")
    assert "exact beams" in found.attributes["chosen"]
    assert "GeneralizedAlpha" in describe(found)["solver"]
    assert "exact beams" in describe(found)["solver"]


def test_steep_friction_comes_to_rest_where_it_must():
    """A block of 1 m/s slows down at mu g and stops after v^2 / (2 mu g)."""
    run = jo.simulate(jo.compile(rubbing(1e-3)), 0.5, output_step=0.01)
    a = 0.3 * 9.81
    # the law is linear below its slip of 1e-3 m/s, where it takes longer to stop
    assert run["c"][-1, 0] == pytest.approx(1.0 / (2.0 * a), rel=2e-2)


def test_print_says_which_method_and_why(tmp_path):
    model = jo.compile(strip())
    run = jo.simulate(model, 0.002)
    for found in (run, jo.load(run.save(tmp_path / "run.h5"))):
        assert "3 instants" in repr(found) and "GeneralizedAlpha(step=0.001, ...)" in repr(found)
        text = str(found)
        assert text.startswith(repr(found))
        assert f"solver {run.attributes['solver']}, {run.attributes['chosen']}" in text
        assert run.energy.verdict in text
    own = str(jo.simulate(model, 0.002, solver=jo.GeneralizedAlpha(1e-3)))
    assert "solver GeneralizedAlpha(step=0.001" in own and "since" not in own


@pytest.mark.parametrize("core", ["joint", "maximal"])
@pytest.mark.parametrize(("frequency", "step"), [(10.0, 1e-3), (50.0, 5e-4), (300.0, 1e-4)])
def test_a_blow_on_a_stop_gets_twenty_steps(frequency: float, step: float, core: str):
    """It lasts half a period of the mass on the stop's spring, here 50, 10 and 1.7 ms."""
    door = jo.RigidBody("door", 2.0, (0.5, 0.5, 0.5))
    hinge = jo.Revolute("hinge", jo.ground["origin"], door["origin"], axis=(0, 0, 1))
    k = 0.5 * (2.0 * np.pi * frequency) ** 2
    stop = jo.mechanism.Stop("stop", hinge.angle, upper=1.0, stiffness=k)
    model = jo.compile(jo.Mechanism(door, hinge, stop), core=core)
    # derivatives by complex numbers are exact to round-off
    assert shortest_blow(model) == pytest.approx(0.5 / frequency, rel=1e-9)
    solver, reason = choose(model, 1.0, None)
    assert isinstance(solver, jo.ROS2)
    assert solver.step == step
    assert ("blows on its stops" in reason) == (step < 1e-3)


def test_a_stop_takes_no_more_than_there_is():
    """A rod falls from the horizontal onto a stop; with 1 ms the balance misses 4 %."""
    rod = jo.RigidBody("rod", 2.0, (0.01, 0.1, 0.1), center=(0.5, 0, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], rod["origin"], axis=(0, 0, 1))
    k = 0.6 * (2.0 * np.pi * 50.0) ** 2
    stop = jo.mechanism.Stop("stop", hinge.angle, lower=-1.0, stiffness=k)
    run = jo.simulate(jo.compile(jo.Mechanism(rod, hinge, stop, jo.Gravity(G))), 1.5)
    there = 2.0 * 9.81 * 0.5 * np.sin(1.0)
    assert 0.7 * there < run.energy.dissipated[-1] < 1.02 * there
    assert np.abs(run.energy.error).max() < 0.02 * there
