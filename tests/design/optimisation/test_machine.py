"""Equivalent static loads of machines against closed forms of bending."""

import numpy as np
import pytest

import jousto as jo
from jousto.design import (
    DisplacementLimit,
    FrequencyLimit,
    LifeLimit,
    MachineProblem,
    StressLimit,
    optimise,
)
from jousto.design.optimisation import loads as esl

STEEL = jo.Material(210e9, 0.3, 7850.0)
LENGTH, WIDTH, FORCE = 1.0, 0.02, 100.0  # m, m, N
SLOW = jo.SCurve((0.0, 2.0), (0.0, 1.0))  # a hundred periods of the bar


def parts(values, width=WIDTH):
    section = jo.Rectangle(width, values["height"])
    return {"bar": jo.Part.beam(LENGTH, section, 4, STEEL, theory=jo.parts.EulerBernoulli())}


def clamped(values, parts):
    reduced = jo.reduce(parts["bar"], jo.CraigBampton(["start", "end"], modes=2))
    bar = jo.FlexibleBody("bar", reduced, damping=0.02)
    return jo.Mechanism(
        bar,
        jo.Fixed("wall", jo.ground["origin"], bar["start"]),
        jo.Force("pull", bar["end"], (0, 0, -FORCE), signal=SLOW),
    )


def problem(limits, build=clamped, parts=parts):
    return MachineProblem(
        [jo.Parameter("height", 0.03, bounds=(0.005, 0.1), unit="m")],
        parts,
        build,
        limits,
        2.5,
        solver=jo.ROS2(step=1e-3),
        output_step=0.05,
    )


def spinning(values, parts):
    """Thrown about a hinge: inertia loads as large as any."""
    reduced = jo.reduce(parts["bar"], jo.CraigBampton(["start", "end"], modes=4))
    bar = jo.FlexibleBody("bar", reduced)
    hinge = jo.Revolute("hinge", jo.ground["origin"], bar["start"], axis=(0, 1, 0))
    return jo.Mechanism(
        bar, hinge, jo.Drive("turn", hinge.angle, jo.SCurve((0.0, 0.5), (0.0, 2.0)))
    )


def test_statics_under_equivalent_loads_are_the_motion():
    one = problem([StressLimit("bar", 1e8)], build=spinning)
    x = one.start
    loads = esl.classical(x, one.bodies(x), one.motions(x))
    (body,) = one.bodies(x)
    # a free body: the loads balance, and six supports carry nothing
    assert body.unbalance(loads[0].columns) < 1e-9
    z = body.solve(loads[0].columns)
    reaction = body.K @ z - loads[0].columns
    assert np.abs(reaction).max() < 1e-8 * np.abs(loads[0].columns).max()
    ((_, _, moving),) = esl.table_of(one, x)
    ((_, _, still),) = esl.table_of(one, x, loads)
    assert still == pytest.approx(moving, abs=1e-9 * moving.max())
    assert moving.max() > 0.01


@pytest.mark.parametrize("order", [0, 1])
def test_the_stress_limit_of_a_bent_bar(order):
    stress = 80e6
    found = optimise(problem([StressLimit("bar", stress, criterion="s11")]), order=order)
    height = np.sqrt(6 * FORCE * LENGTH / (WIDTH * stress))
    assert found.converged
    assert found.values["height"] == pytest.approx(height, rel=2e-3)  # it still rings a little
    assert found.cost == pytest.approx(7850 * LENGTH * WIDTH * found.values["height"], rel=1e-12)
    assert found.ratio == pytest.approx(1.0, abs=1e-4)


def test_the_displacement_limit_of_a_bent_bar():
    limit = DisplacementLimit("bar", 0.01, "end", direction=(0, 0, 1), relative_to="start")
    found = optimise(problem([limit]))
    height = (4 * FORCE * LENGTH**3 / (210e9 * WIDTH * 0.01)) ** (1 / 3)
    assert found.values["height"] == pytest.approx(height, rel=2e-3)


def test_the_life_limit_of_a_bent_bar():
    curve = jo.SN(S_D=50e6, N_D=2e6, k=5, rule="elementary")
    repeats = 1e5
    found = optimise(problem([LifeLimit("bar", repeats, curve, criterion="s11")]))
    # one cycle a run from 0 to the stress and back: the amplitude is half of it
    stress = 2 * 50e6 * (2e6 / repeats) ** (1 / 5)
    height = np.sqrt(6 * FORCE * LENGTH / (WIDTH * stress))
    assert found.values["height"] == pytest.approx(height, rel=5e-3)


def test_the_frequency_limit_of_a_bar():
    def flat(values):
        return parts(values, width=0.12)  # it bends more easily than sideways

    found = optimise(problem([StressLimit("bar", 1e9), FrequencyLimit(30.0)], parts=flat))
    height = 30.0 * 2 * np.pi / 1.875104069**2 * np.sqrt(12 * 7850 / 210e9) * LENGTH**2
    assert found.values["height"] == pytest.approx(height, rel=2e-3)
    assert str(found.active[0][0]) == "frequency 1"


def test_two_load_cases_bound_together():
    def both(values, parts):
        return {"down": clamped(values, parts), "thrown": spinning(values, parts)}

    one = problem([StressLimit("bar", 80e6, criterion="s11")], build=both)
    found = optimise(one)
    runs = one.solutions(found.values)
    largest = [jo.stress_field(run, "bar").values("s11").max() for run in runs.values()]
    assert tuple(runs) == ("down", "thrown")
    assert max(largest) == pytest.approx(80e6 * found.ratio, rel=1e-9)
    with pytest.raises(jo.InputError, match="no value of height"):
        one.solutions({})
    assert found.ratio == pytest.approx(1.0, abs=1e-4)
    assert {place.case for place, _ in found.active} == {"down"}


def test_runs_start_where_a_function_of_the_model_says():
    speed = 20.0

    def turning(values, parts):
        reduced = jo.reduce(parts["bar"], jo.CraigBampton(["start", "end"], modes=12))
        bar = jo.FlexibleBody("bar", reduced)
        hinge = jo.Revolute("hinge", jo.ground["origin"], bar["start"], axis=(0, 1, 0))
        return jo.Mechanism(bar, hinge, jo.Drive("turn", hinge.angle, jo.ConstantSpeed(speed)))

    longer = DisplacementLimit("bar", 1e-4, "end", direction=(1, 0, 0), relative_to="start")
    problem = MachineProblem(
        [jo.Parameter("height", 0.03, bounds=(0.005, 0.1), unit="m")],
        parts,
        turning,
        [longer],
        0.01,
        solver=jo.ROS2(step=1e-4),
        output_step=1e-3,
        state=jo.simulation.vibration_free_state,
    )
    ((_, _, ratio),) = esl.table_of(problem, problem.start)
    # a bar that turns is longer by rho w^2 L^3 / (3 E), and does not ring about that
    closed = 7850 * speed**2 * LENGTH**3 / (3 * 210e9)
    assert 1e-4 * ratio[0] == pytest.approx(closed, rel=2e-3)


def test_functions_that_return_something_else():
    with pytest.raises(jo.InputError, match="parts returns 3"):
        optimise(
            MachineProblem(
                [jo.Parameter("h", 1.0, bounds=(0.5, 2.0))],
                lambda v: 3,
                clamped,
                [StressLimit("bar", 1e8)],
                1.0,
            )
        )
    with pytest.raises(jo.InputError, match="build returns None"):
        optimise(problem([StressLimit("bar", 1e8)], build=lambda values, parts: None))
    one = problem([StressLimit("bar", 1e8)])
    with pytest.raises(jo.InputError, match="state is 'rest', must be a State or a function"):
        MachineProblem(one.parameters, parts, clamped, one.limits, 1.0, state="rest")


def test_a_history_as_a_table(tmp_path):
    found = optimise(problem([StressLimit("bar", 80e6)]), order=0)
    lines = found.to_csv(tmp_path / "history.csv").read_text().splitlines()
    assert lines[0].split(",")[:3] == ["cycle", "height", "cost"]
    assert len(lines) == len(found.history) + 1
    assert len(repr(found)) < 300
    assert "KKT residual" in str(found)
