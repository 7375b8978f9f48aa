"""verify: sound machines agree, what was left out shows, what cannot be compared is said."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.natural.comparison import Compared
from jousto.natural.verify import verify
from natural.machines import SECTION, rod
from verification.iftomm import bricard

pytestmark = pytest.mark.filterwarnings(
    "ignore:.*has no joint to another", "ignore:.*regularised friction"
)
room = import_module("jousto.natural.verify")


def machine() -> jo.Mechanism:
    """Two bent bars that turn about skew axes; the elbow rubs."""
    upper = jo.FlexibleBody("upper", rod(), angular_velocity=(0, 0, 6.0))
    lower = jo.FlexibleBody(
        "lower", upper.reduced, position=(1, 0, 0), velocity=(0, 6.0, 0), angular_velocity=(0, 2, 6)
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], upper["start"], axis=(0, 0, 1))
    elbow = jo.Revolute("elbow", upper["end"], lower["start"], axis=(0, 1, 0))
    law = jo.mechanism.Regularised(velocity=0.1)
    rub = jo.Friction("rub", elbow, 0.1, radius=0.03, law=law)
    sensors = (
        jo.PositionSensor("tip", lower["end"]),
        jo.OrientationSensor("tip turned", lower["end"]),
        jo.StressSensor("stress", upper, "e2.a.top"),
    )
    push = jo.Force("push", lower["end"], (0, 0, 400.0))
    return jo.Mechanism(upper, lower, hinge, elbow, rub, push, *sensors, name="arm")


def found(mechanism: jo.Mechanism) -> jo.natural.Verification:
    """Verification over 20 ms, in which the bars bend by centimetres."""
    return verify(mechanism, 0.02, step=1e-3)


@cache
def sound() -> jo.natural.Verification:
    return found(machine())


def test_a_sound_machine_agrees() -> None:
    result = sound()
    assert result.agrees, result
    assert result.verdict.startswith("the formulations agree: ")
    assert result.instants == 21
    assert all(row.at_instants < 1e-7 for row in result.rows), result
    tip = next(row for row in result.rows if row.name == "tip")
    assert tip.order == pytest.approx(2.0, abs=0.3)


def test_implicit_methods_are_no_difference() -> None:
    """Their own accelerations miss the equations of motion by the error of a step."""
    result = verify(machine(), 0.02, step=1e-3, solver=jo.GeneralizedAlpha(1e-3))
    assert result.agrees, result
    assert max(row.at_instants for row in result.rows) < 1e-7


def test_an_invariant_left_out_on_purpose_shows_too() -> None:
    body = jo.FlexibleBody("bar", rod(), angular_velocity=(1, 5, 9), drop_invariants=("I9",))
    push = jo.Force("push", body["end"], (0, 300.0, 200.0))
    result = verify(jo.Mechanism(body, push), 0.02, step=1e-3)
    assert not result.agrees


@pytest.mark.filterwarnings("ignore:.*redundant")
def test_reactions_that_are_not_unique_are_not_compared() -> None:
    result = verify(bricard(), 0.02, step=2e-3)
    assert result.agrees, result
    shared = [row for row in result.rows if not row.unique]
    assert {row.name for row in shared} == {f"reaction of hinge {k}" for k in range(6)}
    assert "not unique" in str(result)


def test_sensors_of_the_engine_alone_are_named() -> None:
    body = jo.FlexibleBody("bar", rod(), angular_velocity=(0, 1, 2))
    stress = jo.StressSensor("stress", body, "e2.a.top")
    curve = jo.SN(S_D=50e6, N_D=2e6, k=5.0)
    damage = jo.mechanism.DamageSensor("damage", stress, curve, residue="half", factor=1.0)
    pin = jo.Spherical("pin", jo.ground["origin"], body["start"])
    result = verify(jo.Mechanism(body, pin, stress, damage), 0.002)
    assert result.left_out == ("damage",)
    assert result.agrees


def test_both_start_where_they_are_told() -> None:
    bar = jo.FlexibleBody("bar", rod())
    clamp = jo.Fixed("clamp", jo.ground["origin"], bar["start"])
    push = jo.Force("push", bar["end"], (0, 0, 40.0))
    mechanism = jo.Mechanism(bar, clamp, push, jo.StressSensor("stress", bar, "e2.a.top"))
    at_rest = verify(mechanism, 0.01, step=1e-3, begin=jo.equilibrium)
    assert at_rest.agrees, at_rest
    free = verify(mechanism, 0.01, step=1e-3)
    assert free.agrees, free
    # element 2 begins a quarter of a metre from the clamp: 40 N over 0.75 m; let go, 10 ms are not
    # long enough to bend it
    stress = [next(row for row in one.rows if row.name == "stress").size for one in (at_rest, free)]
    assert stress[0] == pytest.approx(40.0 * 0.75 * SECTION.height / 2 / SECTION.Iy, rel=1e-3)
    assert stress[1] < 0.1 * stress[0]
    with pytest.raises(jo.InputError, match="begin is 'rest', must be a function"):
        verify(mechanism, 0.01, begin="rest")  # type: ignore[arg-type]


def fast() -> jo.Mechanism:
    """A drive turns an eccentric wheel by six radians between two states; a gear turns another."""
    wheel = jo.RigidBody(
        "wheel", 1.0, (0.01, 0.01, 0.02), center=(0.05, 0, 0), angular_velocity=(0, 0, 300)
    )
    other = jo.RigidBody(
        "other", 1.0, (0.01, 0.01, 0.02), position=(0.5, 0, 0), angular_velocity=(0, 0, -210)
    )
    hinge = jo.Revolute("hinge", jo.ground["origin"], wheel["origin"], axis=(0, 0, 1))
    second = jo.Revolute("second", jo.ground.at((0.5, 0, 0)), other["origin"], axis=(0, 0, 1))
    gear = jo.Gear("gear", hinge.angle, second.angle, -0.7)
    drive = jo.Drive("drive", hinge.angle, jo.ConstantSpeed(300.0))
    turned = jo.CoordinateSensor("turned", second.angle)
    return jo.Mechanism(wheel, other, hinge, second, gear, drive, turned, name="fast")


def test_fast_machines_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    """Turns between two states count, and rounding of 4.5 kN is none of a torque that is zero."""
    # 20 states, all of them compared, are as far apart as 200 of a run that is ten times as long
    monkeypatch.setattr(room, "OUTPUTS", 20)
    monkeypatch.setattr(room, "EVERY", 1)
    result = verify(fast(), 0.4, step=2e-3)
    assert result.agrees, result
    assert result.instants == 21
    assert next(row for row in result.rows if row.name == "turned").size == pytest.approx(84.0)


def test_the_page_stands_for_itself(tmp_path: Path) -> None:
    text = jo.write(sound(), tmp_path / "arm.html").read_text(encoding="utf-8")
    assert sound().verdict.replace("'", "&#x27;") in text
    assert "<td>tip</td>" in text
    assert "http" not in text.replace("http-equiv", "")


def test_numbers_that_make_no_sense() -> None:
    with pytest.raises(jo.InputError) as error:
        verify(machine(), 0.0, step=-1.0)
    assert len(error.value.problems) == 2


@pytest.mark.filterwarnings("ignore:.*nothing will move")
def test_a_machine_that_does_not_move_is_said_not_to() -> None:
    body = jo.RigidBody("body", 1.0, (1, 1, 1))
    guide = jo.Prismatic("guide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    found = verify(jo.Mechanism(body, guide), 0.02, step=1e-3)
    assert "nothing moved in the run" in found.verdict
    pull = jo.Force("pull", body["origin"], (1, 0, 0))
    assert "nothing moved" not in verify(jo.Mechanism(body, guide, pull), 0.02, step=1e-3).verdict


def test_friction_of_reactions_that_are_not_unique_is_not_compared() -> None:
    """Two hinges on one axis hold five motions twice; friction in one follows its share of them."""
    body = jo.RigidBody("door", 1.0, (0.01, 0.02, 0.03), center=(0.1, -0.5, 0.2))
    low, high = (
        jo.Revolute(name, jo.ground.at((0, 0, z)), body.at((0, 0, z)), axis=(0, 0, 1))
        for name, z in (("low", 0), ("high", 1))
    )
    law = jo.mechanism.Regularised()
    rub = jo.Friction("rub", low, 0.3, radius=0.05, bearing_length=0.1, law=law)
    place = jo.PositionSensor("place", body["center"])
    weight = jo.Gravity((0, -9.81, 0))
    with pytest.warns(jo.JoustoWarning, match="not unique"):
        result = verify(jo.Mechanism(body, low, high, rub, place, weight), 0.02)
    assert result.shared == ("rub",)
    open_ended = {row.name for row in result.rows if not row.unique}
    assert {"force of rub", "reaction of low", "acceleration of door.center"} <= open_ended
    assert "place" not in open_ended
    assert "the friction 'rub' depends on reactions that are not unique" in result.verdict
    assert "DISAGREE" not in result.verdict


def rattling(stiffness: float) -> jo.natural.Verification:
    """A kilogram dropped onto a bushing, beside an event, which leaves two methods to judge."""
    body = jo.RigidBody("body", 1.0, (0.01, 0.01, 0.01), center=(0.05, 0.03, 0))
    stiff = (*(stiffness,) * 3, *(0.1 * stiffness,) * 3)
    bushing = jo.Bushing("bushing", jo.ground["origin"], body["origin"], stiffness=stiff)
    place = jo.PositionSensor("place", body["origin"])
    far = jo.mechanism.Event("far", place, 100.0, component=0, stop=True)
    return verify(jo.Mechanism(body, bushing, place, far, jo.Gravity((3, 0, -9.81))), 0.05)


def test_a_step_that_resolves_nothing_decides_nothing() -> None:
    """3e7 N/m under 1 kg vibrates 0.4 times in half a step, 1e3 N/m 2.5e-3 times."""
    result = rattling(3e7)
    assert result.undecided
    assert not result.agrees
    assert "nothing is decided" in result.verdict
    assert "'force of bushing'" in result.verdict
    assert rattling(1e3).agrees


def test_a_state_of_another_model_is_refused() -> None:
    """The model that is verified reads more, and counts more angles, than that of the mechanism."""
    body = jo.RigidBody("body", 1.0, (0.01, 0.02, 0.03), center=(0.1, -0.5, 0))
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    bare = jo.Mechanism(body, hinge, jo.Gravity((0, -9.81, 0)))
    spring = jo.Spring("spring", hinge.angle, stiffness=1.0)
    other = jo.simulate(jo.compile(jo.Mechanism(*bare.items, spring)), 0.01).state(0.0)
    with pytest.raises(jo.InputError, match="begin returned a state of another model; compute it"):
        verify(bare, 0.02, begin=lambda model: other)
    late = jo.simulate(jo.compile(bare), 0.01)
    with pytest.raises(jo.InputError, match=r"a state at 0\.01 s, must be at 0"):
        verify(bare, 0.02, begin=lambda model: late.state())


def stiff(step: float, *more: object) -> jo.natural.Verification:
    """A kilogram off the centre of a bushing, which vibrates with 3e3 rad/s and faster."""
    body = jo.RigidBody("body", 1.0, (0.01, 0.02, 0.03), center=(0.1, 0, 0))
    stiffness = (*(1e7,) * 3, *(1e4,) * 3)
    bushing = jo.Bushing("bushing", jo.ground["origin"], body["origin"], stiffness=stiffness)
    machine = jo.Mechanism(body, bushing, jo.Gravity((0, 0, -9.81)), *more)  # type: ignore[arg-type]
    return verify(machine, 0.2, step=step, solver=jo.RK4(step))


def test_an_engine_that_stops_decides_nothing() -> None:
    """RK4 is unstable beyond 2.8 / (3e3 rad/s), 0.9 ms."""
    result = stiff(4e-3)
    assert result.undecided
    assert not result.agrees
    assert not result.ended
    assert "nothing is decided: the engine with a step of 0.002 s stopped at" in result.verdict
    assert "are equal to" in result.verdict
    assert len([what for name, what in result.facts if name == "stopped"]) == 2


def test_a_step_with_which_the_engine_stops_leaves_the_half_of_it_to_compare() -> None:
    result = stiff(1e-3)
    assert result.agrees, result
    assert result.instants == 21
    assert "runs are not compared: the engine with a step of 0.001 s stopped" in result.verdict


def test_two_methods_of_which_one_stops_decide_nothing() -> None:
    far = jo.mechanism.Event("far", place := still(), 1e9, component=0, stop=True)
    result = stiff(4e-3, place, far)
    assert result.undecided
    assert not result.agrees
    assert "and nothing is decided: the engine with a step of 0.002 s stopped" in result.verdict


def still() -> jo.PositionSensor:
    return jo.PositionSensor("ground", jo.ground["origin"])


def test_a_moving_frame_that_stops_leaves_states_to_compare() -> None:
    """Two radians in a step are more than its iteration can follow."""
    body = jo.RigidBody("top", 1.0, (0.01, 0.02, 0.03), angular_velocity=(10, 2000, 20))
    result = verify(jo.Mechanism(body), 0.02, step=1e-3, solver=jo.RK4(1e-5))
    assert result.agrees, result
    assert "but runs are not compared: the moving frame did not converge" in result.verdict
    assert "nan" not in str(result)


def row(coarse: float, fine: float) -> Compared:
    return Compared("stress", 1.0, "Pa", np.nan, coarse, fine)


def test_a_difference_that_falls_is_none_only_where_it_is_small() -> None:
    """0.8 to 0.2 of the size is order 2, and says nothing of where both go."""
    assert row(4e-3, 1e-3).meets
    assert row(0.08, 0.02).meets
    assert row(0.8, 0.2).order == pytest.approx(2.0)
    assert not row(0.8, 0.2).meets
    assert not row(0.03, 0.02).meets


def test_two_methods_that_are_far_apart_do_not_agree() -> None:
    """Half a step of 0.1 s in a swing of 1 Hz: they come together, but not yet."""
    body = jo.RigidBody("body", 1.0, (0.01, 0.01, 0.01))
    pull = (*(39.5,) * 3, *(1.0,) * 3)
    spring = jo.Bushing("spring", jo.ground.at((0, 0, 0.25)), body["origin"], stiffness=pull)
    place = jo.PositionSensor("place", body["origin"])
    far = jo.mechanism.Event("far", place, 100.0, component=0, stop=True)
    machine = jo.Mechanism(body, spring, place, far)
    results = [verify(machine, 2.0, step=h, solver=jo.ROS2(h)) for h in (0.1, 2e-3)]
    apart = {row.name: row for row in results[0].ways[0].apart}
    assert apart["place"].order > 1.5
    assert apart["place"].fine > 0.05
    assert [result.agrees for result in results] == [False, True]


def test_the_page_shows_what_is_undecided(tmp_path: Path) -> None:
    text = jo.write(rattling(3e7), tmp_path / "rattling.html").read_text(encoding="utf-8")
    assert 'background:#A56A00">undecided</span>' in text
    assert ">disagree<" not in text


def test_an_engine_that_cannot_begin_ends_with_a_verdict() -> None:
    """Nothing is decided, and why, whether the forces or the start fail; not an error alone."""
    block = jo.RigidBody("block", 1.0, (0.1,) * 3)
    rail = jo.Prismatic("rail", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    broken = jo.UserForce("law", block["origin"], lambda t, x: [float("nan")] * 6)
    found = verify(jo.Mechanism(block, rail, broken), 0.1)
    assert (found.word, found.agrees) == ("undecided", False)
    assert "nothing is decided: the engine cannot begin: force 'law'" in found.verdict
    assert "nan at half" not in str(found)

    pushed = jo.Mechanism(block, rail, jo.Force("push", block["origin"], (1.0, 0, 0)))
    found = verify(pushed, 0.1, begin=jo.equilibrium)
    assert found.word == "undecided"
    assert "the engine cannot begin: no static equilibrium" in found.verdict


@pytest.mark.parametrize("start", ["declared", "initial"])
def test_elastic_joints_agree(start: str) -> None:
    """The rotor has almost no inertia across its axis; `Initial` takes the motor with it."""
    body = jo.RigidBody("link", 4.0, (0.01, 0.16, 0.16), center=(0.4, 0, 0))
    joint = jo.Revolute("joint", jo.ground["origin"], body["origin"], axis=(0, 0, 1))
    motor = jo.mechanism.ElasticJoint(
        *("joint", joint.angle, -50, 1e-4, 900.0), damping=1.0, windup=0.05
    )
    moved = () if start == "declared" else (jo.Initial(joint.angle, value=0.7, rate=3.0),)
    felt = jo.ForceSensor("felt", motor.gear)
    result = verify(
        jo.Mechanism(body, joint, motor, felt, jo.Gravity((0, -9.81, 0)), *moved), 0.02, step=1e-3
    )
    assert result.agrees, result
    assert "not compared" not in result.verdict
    assert next(row for row in result.rows if row.name == "felt").order == pytest.approx(2, abs=0.3)
