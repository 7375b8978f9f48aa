"""Solvers with ``events="step"``: what takes effect at the ends of steps, and what is refused."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from exported import CC, expected, rows_of
from jousto.export.project import write_program
from jousto.mechanism import HalfSpace, Sphere
from jousto.schema.read import parse_model
from jousto.simulation.results.diagnostics import Work

G = 9.81
STICKS = jo.mechanism.StickSlip()
EVERY = (jo.RK4, jo.ROS2, jo.GeneralizedAlpha, jo.simulation.Newmark, jo.simulation.SSPRK3)


def floor(*items: Any, mu: float = 0.2) -> jo.Model:
    """A block on a floor, on a spring and under a harmonic load: it sticks and slips."""
    block = jo.RigidBody("block", 1.0, (1, 1, 1))
    rail = jo.Prismatic("rail", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    return jo.compile(
        jo.Mechanism(
            *(block, rail, jo.Gravity((0, 0, -G)), *(item(block, rail) for item in items)),
            jo.Spring("spring", rail.displacement, 100.0, free=0.0),
            jo.JointForce("shaker", rail.displacement, jo.Harmonic(amplitude=5.0, frequency=1.1)),
            jo.Friction("rub", rail, mu, 2 * mu, law=STICKS),
            jo.CoordinateSensor("x", rail.displacement),
        )
    )


@pytest.mark.parametrize("method", EVERY, ids=lambda one: one.__name__)
def test_transitions_are_at_the_ends_of_steps(method: Any) -> None:
    step = 2e-3
    run = jo.simulate(floor(), 3.0, solver=method(step, events="step"))
    other = jo.simulate(floor(), 3.0, solver=method(step))
    times = np.array([one.time for one in run.events])
    assert len(times) == len(other.events) > 6
    np.testing.assert_allclose(times / step, np.round(times / step), rtol=0.0, atol=1e-6)
    located = np.array([one.time for one in other.events])
    assert (times - located > -1e-4).all() and (times - located < 1.1 * step).all()
    assert run.attributes["deferred"] == 0
    assert "deferred" not in other.attributes
    assert "events='step'" in run.attributes["solver"]
    assert isinstance(run.work, Work)


def test_an_event_takes_effect_at_the_end_of_its_step_and_a_chain_in_the_next_one() -> None:
    """Three events of one instant in a row: two in the two passes, the third one a step later."""

    def cart() -> jo.Model:
        body = jo.RigidBody("cart", 2.0, (1, 1, 1), velocity=(1.0, 0, 0))
        rail = jo.Prismatic("rail", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
        felt = jo.AccelerationSensor("felt", body["origin"])
        way = jo.mechanism.Event("way", rail.displacement, 0.1234, "rising")
        steps = [way]
        forces = []
        for i, limit in enumerate((1.0, 3.0)):
            forces.append(
                jo.JointForce(
                    f"f{i}", rail.displacement, jo.mechanism.Switched(steps[-1], 0.0, 4.0)
                )
            )
            steps.append(jo.mechanism.Event(f"e{i}", felt, limit, "rising", component="x"))
        return jo.compile(jo.Mechanism(body, rail, felt, *steps, *forces))

    run = jo.simulate(cart(), 0.2, solver=jo.RK4(0.01))
    assert [one.time for one in run.events] == pytest.approx([0.1234] * 3, abs=1e-9)
    with pytest.warns(
        jo.JoustoWarning, match="1 of 20 steps left a change of friction or an event"
    ):
        run = jo.simulate(cart(), 0.2, solver=jo.RK4(0.01, events="step"))
    assert [one.name for one in run.events] == ["way", "e0", "e1"]
    assert [one.time for one in run.events] == pytest.approx([0.13, 0.13, 0.14], abs=1e-12)
    assert run.attributes["deferred"] == 1


def test_an_event_that_stops_the_run_does_so_at_the_end_of_its_step() -> None:
    def stop(_: Any, rail: Any) -> Any:
        return jo.mechanism.Event("far", rail.displacement, 0.01, "rising", stop=True)

    run = jo.simulate(floor(stop, mu=0.01), 3.0, solver=jo.ROS2(2e-3, events="step"))
    assert run.attributes["ended"].startswith("stopped by event 'far'")
    assert run.time[-1] / 2e-3 == pytest.approx(round(run.time[-1] / 2e-3), abs=1e-6)
    assert run["x"][-2, 0] < 0.01 < run["x"][-1, 0]


def test_a_plastic_spring_yields_across_the_ends_of_steps() -> None:
    def spring(_: Any, rail: Any) -> Any:
        return jo.mechanism.PlasticSpring("bar", rail.displacement, 500.0, strength=2.0)

    ends = [
        jo.simulate(floor(spring, mu=0.02), 3.0, solver=solver)["x"].ravel()[-1]
        for solver in (jo.RK4(5e-4), jo.RK4(2e-3, events="step"), jo.RK4(5e-4, events="step"))
    ]
    assert abs(ends[2] - ends[0]) < 0.5 * abs(ends[1] - ends[0]) < 2e-4


def test_what_cannot_be_bounded_is_refused(tmp_path: Path) -> None:
    def touch(block: Any, _: Any) -> Any:
        law = jo.mechanism.PowerLaw(1e5, restitution=0.8)
        return jo.mechanism.Contact(
            "touch", jo.ground["origin"], HalfSpace(), block.at((0, 0, 1.0)), Sphere(0.1), law
        )

    model, solver = floor(touch), jo.ROS2(1e-3, events="step")
    wanted = "force 'touch': is a contact, which takes shorter steps"
    for call in (
        lambda: jo.simulate(model, 1.0, solver=solver),
        lambda: jo.simulation.Simulator(model, solver),
        lambda: write_program(model, tmp_path / "a.c", solver),
    ):
        with pytest.raises(jo.InputError, match=wanted):
            call()

    cart = jo.RigidBody("cart", 1.0, (1, 1, 1), velocity=(1.0, 0, 0))
    way = jo.Prismatic("way", jo.ground["origin"], cart["origin"], axis=(1, 0, 0))
    end = jo.mechanism.RigidStop("end", way.displacement, upper=0.5)
    with pytest.raises(jo.InputError, match="joint 'end': ends a step at each impact"):
        jo.simulate(jo.compile(jo.Mechanism(cart, way, end)), 1.0, solver=solver)
    with pytest.raises(jo.InputError, match="events"):
        jo.simulation.DormandPrince(events="step")
    with pytest.raises(jo.InputError, match="events is 'late', must be 'located' or 'step'"):
        jo.RK4(1e-3, events="late")


TEXT = """
name: m
bodies: [{name: a, mass: 1, inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: rail, a: ground.origin, b: a.origin, axis: [1, 0, 0]}]
simulation: {t_end: 1, solver: {type: %s, step: 1 ms, events: %s}}
"""


def test_a_model_file_says_it() -> None:
    found = parse_model(TEXT % ("GeneralizedAlpha", "step")).simulation
    assert found.solver == jo.GeneralizedAlpha(1e-3, events="step")
    with pytest.raises(jo.InputError, match="located"):
        parse_model(TEXT % ("RK4", "late"))
    with pytest.raises(jo.InputError, match="events"):
        parse_model(TEXT.replace("step: 1 ms", "tolerance: 1e-6") % ("DormandPrince", "step"))


def test_a_simulator_counts_what_it_defers() -> None:
    with jo.simulation.Simulator(floor(), jo.RK4(2e-3, events="step")) as sim:
        sim.step(1000)
        assert sim.deferred == 0
        assert len(sim.events) > 3
        assert (
            sim.read("x")[0]
            == jo.simulate(floor(), 2.0, solver=jo.RK4(2e-3, events="step"))["x"].ravel()[-1]
        )


@pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler")
def test_an_exported_program_computes_the_same(tmp_path: Path) -> None:
    model, solver = floor(), jo.ROS2(2e-3, events="step")
    found = rows_of(model, solver, tmp_path, "2.0", "100")
    run = jo.simulate(model, 2.0, solver=solver, output_step=0.02)
    rows = expected(model, run)
    np.testing.assert_allclose(found, rows, rtol=0.0, atol=1e-12)
