"""An arm of three rigid links on a boom: what is carried, what says why not, and what uses it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.model.native.native import Engine
from jousto.model.tree import core_of
from jousto.simulation.live.drag_spring import with_hand
from jousto.simulation.live.machine import LiveMachine
from model.test_tree_ports import Z, kinds
from verification.mechanisms import rod


def arm(*more: Any, core: str = "joint") -> Any:
    """A boom on a hinge with three hinged links, the first of which stays by its rows."""
    boom = jo.FlexibleBody("boom", rod(), damping=0.02)
    links = [
        jo.RigidBody(f"link{k}", 0.7, (0.02, 0.05, 0.06), center=(0.2, 0, 0), position=(x, 0, 0))
        for k, x in enumerate((1.0, 1.4, 1.8))
    ]
    ends = [boom["end"], *(link.at((0.4, 0, 0)) for link in links)]
    axes = (Z, (0, 1, 0), Z)
    hinges = [
        jo.Revolute(f"hinge{k}", a, link.at((0, 0, 0)), axis=axis)
        for k, (a, link, axis) in enumerate(zip(ends, links, axes, strict=False))
    ]
    foot = jo.Revolute("foot", jo.ground["origin"], boom["start"], axis=Z)
    made = [item(hinges, links, boom) for item in more]
    tip = jo.PositionSensor("tip", links[2].at((0.4, 0, 0)))
    items = (boom, *links, foot, *hinges, tip, jo.Gravity((0, -9.81, 0)), *made)
    return jo.Mechanism(*items, name="arm", core=core)


@pytest.mark.chooses
def test_the_first_rigid_body_stays_and_the_core_says_so() -> None:
    model = jo.compile(arm())
    assert kinds(model) == ["body", "body", "hinge", "hinge"]
    assert core_of(model) == "positions of 2 bodies, joint coordinates for 2 more on 'link0'"
    assert core_of(model) in str(jo.doctor(model))
    few = core_of(jo.compile(arm(core="auto")))
    assert few == "positions of the bodies: joint coordinates for 2 of them save little"


@pytest.mark.chooses
def test_auto_keeps_the_positions_of_the_bodies() -> None:
    assert not jo.compile(arm(core="auto")).links


def test_what_cannot_be_carried_says_why() -> None:
    boom = jo.FlexibleBody("boom", rod())
    alone = jo.Mechanism(boom, jo.Revolute("foot", jo.ground["origin"], boom["start"], axis=Z))
    with pytest.raises(jo.InputError, match="'boom' is flexible, and no rigid body is connected"):
        jo.compile(alone, core="joint")
    rub = arm(lambda hinges, *_: jo.Friction("rub", hinges[2], mu_kinetic=0.1, radius=0.02))
    with pytest.raises(jo.InputError, match="'boom' is flexible, and 'rub' is friction"):
        jo.compile(rub)


def held(_hinges: Any, links: Any, boom: Any) -> Any:
    return jo.Spherical("rope", boom["start"], links[2].at((-1.8, 0, 0)))


def coupled(hinges: Any, *_: Any) -> Any:
    return jo.Coupling("gear", (hinges[0].angle, hinges[1].angle), (1.0, -2.0))


def loose(hinges: Any, *_: Any) -> Any:
    return jo.mechanism.Event("low", hinges[2].angle, -3.0, releases=hinges[2])


def jerked(hinges: Any, *_: Any) -> Any:
    return jo.Drive("motor", hinges[2].angle, jo.Ramp(0.0, 1.0, 0.0, 2.0))


def smooth(hinges: Any, *_: Any) -> Any:
    return jo.Drive("motor", hinges[2].angle, jo.SCurve((0.0, 1.0), (0.0, 2.0)))


@pytest.mark.parametrize(
    ("item", "carried"), [(coupled, 1), (smooth, 2)], ids=["coupled", "smooth drive"]
)
def test_what_rows_act_on_stays(item: Any, carried: int) -> None:
    model = jo.compile(arm(item))
    assert len(model.links) - kinds(model).count("body") == carried


@pytest.mark.parametrize("item", [held, loose, jerked], ids=["loop", "release", "kinked drive"])
def test_a_last_body_that_rows_act_on_keeps_all(item: Any) -> None:
    mechanism = arm(item)
    with pytest.raises(jo.InputError, match="no rigid body is"):
        jo.compile(mechanism)
    assert not jo.compile(mechanism, core="maximal").links


def test_ros2_takes_springs_of_carried_joints_in_its_matrix() -> None:
    """Hinge springs of 1e5 rad/s at a step of 1 ms: the links stay where they are held."""

    def hold(k: int) -> Any:
        return lambda hinges, *_: jo.Spring(f"hold{k}", hinges[k].angle, stiffness=1e9)

    model = jo.compile(arm(hold(1), hold(2)))
    engine = Engine(model)
    solver = engine.native_solver("ros2", 1e-3, True)
    for _ in range(100):
        engine.step(solver)
    angles = engine.joint[[link.x for link in model.links if link.kind == "hinge"]]
    assert np.abs(angles).max() < 1e-7  # moments of some 10 N m over the stiffness
    assert abs(engine.q[1]) < 0.2


def wind(_hinges: Any, links: Any, _boom: Any) -> Any:
    """A force of the user that depends on time, place and speed."""

    def function(t: float, x: Any) -> list[float]:
        return [3.0 * np.sin(5.0 * t) - 0.2 * x[12], 0.5 * x[0], 0.0, 0.0, 0.0, 0.0]

    return jo.UserForce("wind", links[2].at((0.4, 0, 0)), function)


def gate(hinges: Any, *_: Any) -> Any:
    return jo.mechanism.Event("gate", hinges[2].angle, 0.2)


def runs(*more: Any, end: float = 0.4, step: float = 5e-4) -> list[Any]:
    return [
        jo.simulate(jo.compile(arm(*more, core=core)), end, solver=jo.RK4(step=step))
        for core in ("joint", "maximal")
    ]


def test_forces_of_the_user_and_events_act_alike() -> None:
    one, other = runs(wind, gate)
    np.testing.assert_allclose(one.q, other.q, rtol=0, atol=1e-8)
    times = [[event.time for event in run.events] for run in (one, other)]
    assert times[0]
    np.testing.assert_allclose(times[0], times[1], rtol=0, atol=1e-7)


def test_angles_of_carried_and_other_joints_are_counted_on() -> None:
    """Driven by moments through more than half a turn, where an angle alone would jump."""

    def push(k: int) -> Any:
        return lambda hinges, *_: jo.JointForce(f"push{k}", hinges[k].angle, jo.Constant(5.0))

    def angle(k: int) -> Any:
        return lambda hinges, *_: jo.CoordinateSensor(f"angle{k}", hinges[k].angle)

    one, other = runs(push(0), push(2), angle(0), angle(2), end=1.2)
    for name in ("angle0", "angle2"):
        assert np.abs(one[name]).max() > 3.5
        np.testing.assert_allclose(one[name], other[name], rtol=0, atol=1e-6)


def test_a_hand_pulls_a_carried_body_as_in_positions() -> None:
    ends = []
    for core in ("joint", "maximal"):
        model = jo.compile(arm(core=core))
        assert bool(with_hand(model).links) == (core == "joint")
        machine = LiveMachine(model, jo.RK4(5e-4))
        machine.step(20)
        machine.pull(3, np.array([0.4, 0.0, 0.0]), np.array([2.2, -0.1, 0.1]))
        machine.step(100)
        ends.append(machine.state().q)
    # the hand's stiffness is that of the mobility at its state, which differs by the method's error
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-6)
