"""What runs with a tree in joint coordinates: events, users' forces, meters, hands, gradients."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.model.native.ensemble import structure
from jousto.simulation.live.drag_spring import Grip, with_grip, with_hand
from jousto.simulation.live.machine import LiveMachine

CORES = ("joint", "maximal")


def swing(*more: Any, core: str = "auto", length: Any = 1.0) -> Any:
    """A double pendulum with a spring, and what is added to it."""
    upper, lower = arms(length)
    pivot, elbow = hinges(upper, lower, length)
    made = [item(pivot, elbow, upper, lower) for item in more]
    angle = jo.CoordinateSensor("angle", pivot.angle)
    tip = jo.PositionSensor("tip", lower.at((0.8, 0, 0)))
    hold = jo.Spring("hold", elbow.angle, stiffness=20.0, damping=0.5)
    items = (upper, lower, pivot, elbow, hold, angle, tip, jo.Gravity((0, -9.81, 0)), *made)
    return jo.Mechanism(*items, name="swing", core=core)


def arms(length: Any) -> tuple[jo.RigidBody, jo.RigidBody]:
    upper = jo.RigidBody("upper", 2.0, (0.02, 0.2, 0.2), center=(0.5, 0, 0))
    at = (length, 0, 0)
    return upper, jo.RigidBody("lower", 1.0, (0.01, 0.1, 0.1), center=(0.4, 0, 0), position=at)


def hinges(upper: Any, lower: Any, length: Any) -> tuple[jo.Revolute, jo.Revolute]:
    z = (0, 0, 1)
    pivot = jo.Revolute("pivot", jo.ground["origin"], upper["origin"], axis=z)
    return pivot, jo.Revolute("elbow", upper.at((length, 0, 0)), lower["origin"], axis=z)


def wind(_pivot: Any, _elbow: Any, _upper: Any, lower: Any) -> jo.UserForce:
    """A force of the user that depends on time, place and speed."""

    def function(t: float, x: Any) -> list[float]:
        return [3.0 * np.sin(5.0 * t) - 0.2 * x[12], 0.5 * x[0], 0.0, 0.0, 0.0, 0.0]

    return jo.UserForce("wind", lower.at((0.8, 0, 0)), function)


def apart(*more: Any, seen: Any, solver: Any = jo.RK4) -> list[float]:
    """How far the cores are apart with a step and with half of it."""
    models = [jo.compile(swing(*more), core=core) for core in CORES]
    assert [bool(model.links) for model in models] == [True, False]
    found = []
    for step in (8e-3, 4e-3):
        runs = [jo.simulate(m, 0.8, solver=solver(step=step), output_step=0.08) for m in models]
        found.append(float(np.abs(seen(runs[0]) - seen(runs[1])).max()))
    return found


# both are of the fourth order: what they are apart falls to a sixteenth, 11 of it asked for
@pytest.mark.parametrize("more", [(), (wind,)], ids=["without", "of the user"])
def test_forces_of_the_user_agree_by_the_order(more: tuple[Any, ...]) -> None:
    coarse, fine = apart(*more, seen=lambda run: run.q)
    assert coarse < 1e-4
    assert coarse > 11.0 * fine


def gate(pivot: Any, *_: Any) -> Any:
    return jo.mechanism.Event("gate", pivot.angle, -0.7, "falling")


def test_events_happen_at_the_same_time() -> None:
    """Found on the cubic between steps of 1 ms: both within 1e-7 s of the crossing."""
    runs = [
        jo.simulate(jo.compile(swing(gate), core=core), 0.8, solver=jo.RK4(step=1e-3))
        for core in CORES
    ]
    times = [[event.time for event in run.events] for run in runs]
    assert times[0]
    np.testing.assert_allclose(times[0], times[1], rtol=0, atol=1e-7)


def test_a_stop_ends_the_run_where_the_coordinate_is() -> None:
    def stop(pivot: Any, *_: Any) -> Any:
        return jo.mechanism.Event("stop", pivot.angle, -0.7, "falling", stop=True)

    run = jo.simulate(jo.compile(swing(stop), core="joint"), 0.8, solver=jo.RK4(step=1e-3))
    assert run.time[-1] < 0.8
    assert run["angle"][-1] == pytest.approx(-0.7, abs=1e-8)


def test_damage_is_counted_alike() -> None:
    """Turning points of an angle as 100 MPa a radian, to the error of RK4 at 1 ms, times k = 5."""
    curve = jo.SN(S_D=100e6, N_D=1e6, k=5)
    damage = []
    for core in CORES:
        mechanism = swing(core=core)
        angle = next(sensor for sensor in mechanism.sensors if sensor.name == "angle")
        life = jo.mechanism.DamageSensor("life", angle, curve, residue="half", factor=1e8)
        model = jo.compile(jo.Mechanism(*mechanism.items, life, core=core))
        assert bool(model.links) == (core == "joint")
        damage.append(jo.simulate(model, 4.0, solver=jo.RK4(step=1e-3))["life"][-1, 0])
    assert damage[1] > 0.0
    assert damage[0] == pytest.approx(damage[1], rel=1e-5)


def test_a_hand_keeps_the_tree_and_pulls_as_in_positions() -> None:
    model = jo.compile(swing(), core="joint")
    held = with_hand(model)
    assert held.links == model.links
    grip = Grip(1, (0.4, 0.0, 0.0), 50.0, 2.0)
    assert with_grip(held, grip).links == model.links
    ends = []
    for core in CORES:
        machine = LiveMachine(jo.compile(swing(), core=core), jo.RK4(1e-3))
        machine.step(50)
        machine.pull(1, np.array([0.4, 0.0, 0.0]), np.array([1.4, -0.1, 0.0]))
        machine.step(200)
        ends.append(machine.state().q)
    # the hand's stiffness is that of the mobility at its state, which differs by the method's error
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-6)


def test_a_state_of_the_other_core_starts_a_run(tmp_path: Path) -> None:
    joint, maximal = (jo.compile(swing(), core=core) for core in CORES)
    jo.simulate(maximal, 0.4, solver=jo.RK4(step=1e-3), path=tmp_path / "half.h5")
    kept = jo.load(tmp_path / "half.h5").state()
    assert kept.joint is None or not len(kept.joint)
    solver = jo.RK4(step=1e-3)
    rest = jo.simulate(joint, 0.8, solver=solver, state=kept)
    whole = jo.simulate(maximal, 0.8, solver=solver)
    # errors of RK4 at 1 ms in both
    np.testing.assert_allclose(rest.q[-1], whole.q[-1], rtol=0, atol=1e-8)
    begun = jo.simulate(joint, 0.4, solver=solver).state()
    back = jo.simulate(maximal, 0.8, solver=solver, state=begun)
    np.testing.assert_allclose(back.q[-1], whole.q[-1], rtol=0, atol=1e-8)


def test_machines_step_side_by_side_in_each_core_of_their_own() -> None:
    joint, maximal = (structure(jo.compile(swing(), core=core)) for core in CORES)
    assert joint and maximal and joint != maximal


@pytest.mark.parametrize("core", CORES)
def test_gradients_by_complex_steps_are_those_of_differences(core: str) -> None:
    length = jo.Parameter("length", 1.0, unit="m")

    def made(length: Any) -> Any:
        return swing(core=core, length=length)

    study = jo.study(made, length, ["min(tip.y)"], t_end=0.4, solver=jo.RK4(step=2e-3))
    found = jo.design.gradient(study, [1.0], check=False)
    assert found.how == (("complex step",),)
    h = 1e-5
    ends = [float(study([1.0 + s * h])[0]) for s in (1, -1)]
    # a central difference: h^2 of the third derivative, and round-off of 1e-16 over h
    assert found.jacobian[0, 0] == pytest.approx((ends[0] - ends[1]) / (2 * h), abs=1e-6)


@pytest.mark.chooses
def test_the_core_of_a_mechanism_is_that_of_its_models() -> None:
    assert jo.compile(swing(core="joint")).links
    assert jo.compile(swing()).links, "auto takes the tree"
    assert not jo.compile(swing(core="maximal")).links
    assert jo.compile(swing(core="maximal"), core="joint").links
    with pytest.raises(jo.InputError, match="core is 'fast', must be 'auto', 'joint' or 'maximal'"):
        swing(core="fast")
