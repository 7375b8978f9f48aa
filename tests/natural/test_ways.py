"""verify by other ways: another method, frame, basis or mechanism, each with a planted fault."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

import jousto as jo
from jousto.base.rotations import rotation_matrix
from jousto.natural import engine_variants
from jousto.natural.comparison import Way
from jousto.natural.rebuilt_mechanism import with_constant_inputs, with_parts
from jousto.natural.verification import Verification
from jousto.natural.verify import verify
from jousto.reduction import NodeFrame, in_frame

Patch = pytest.MonkeyPatch
STEEL = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
pytestmark = pytest.mark.filterwarnings(
    "ignore:.*the energy balance misses", "ignore:.*has no joint to another"
)


@cache
def bar() -> jo.ReducedPart:
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.02), 8, STEEL, name="bar")
    return jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2))


def pushed(reduced: jo.ReducedPart | None = None, **more: Any) -> jo.Mechanism:
    """A clamped bar that a growing force bends by a hundredth of its length, without a jolt."""
    body = jo.FlexibleBody("bar", reduced or bar(), **more)
    clamp = jo.Fixed("clamp", jo.ground["origin"], body["start"])
    push = jo.Force("push", body["end"], (0, 0, 100.0), signal=jo.SCurve((0, 0.1), (0, 1)))
    sensors = (
        jo.PositionSensor("tip", body["end"]),
        jo.ReactionSensor("at the clamp", clamp),
        jo.StressSensor("stress", body, "e2.a.top"),
    )
    return jo.Mechanism(body, clamp, push, *sensors, name="bar")


def ways_of(found: Verification) -> dict[str, Way]:
    return {way.name: way for way in found.ways}


def compare(mechanism: jo.Mechanism, **more: Any) -> Verification:
    return verify(mechanism, 0.1, step=1e-3, **more)


@pytest.fixture(scope="module")
def sound() -> Verification:
    """Made before any test plants its fault, in whichever order tests run."""
    return compare(pushed())


def test_all_ways_are_gone(sound: Verification) -> None:
    found = ways_of(sound)
    assert list(found) == ["GeneralizedAlpha", "another frame", "finer basis"]
    for way in found.values():
        assert way.worst is not None, way.said
        assert way.worst.fine < 5e-3, way.said
    assert found["GeneralizedAlpha"].worst.order == pytest.approx(2.0, abs=0.3)  # type: ignore[union-attr]
    for name, way in found.items():
        assert f"{name}" in str(sound)
        assert way.said in str(sound)


def off(found: Verification, way: str, reading: str) -> float:
    return next(row.fine for row in ways_of(found)[way].rows if row.name == reading)


def test_a_method_with_a_fault_shows(monkeypatch: Patch) -> None:
    """A Newmark method with too much weight on the new velocity is of order 1."""
    bad = jo.simulation.Newmark(beta=0.6, gamma=1.0)
    monkeypatch.setattr(engine_variants, "contrasting_method", lambda solver, model: bad)
    way = ways_of(compare(pushed()))["Newmark"]
    assert way.apart
    assert way.worst is not None
    assert way.worst.order < 1.4


def test_a_frame_with_a_fault_shows(monkeypatch: Patch, sound: Verification) -> None:
    """Frequencies that are 2 % too high: 4 % more stiffness."""

    def wrong(reduced: jo.ReducedPart, frame: Any) -> jo.ReducedPart:
        part = in_frame(reduced, frame)
        return replace(part, frequencies=1.02 * part.frequencies)

    monkeypatch.setattr(engine_variants, "in_frame", wrong)
    broken = compare(pushed())
    assert off(broken, "another frame", "stress") > 10 * off(sound, "another frame", "stress")


def test_a_basis_that_is_too_poor_shows(sound: Verification) -> None:
    """Without its slow modes the bar does not bend, and has no stress."""
    poor = bar().keep(range(4, bar().n))
    stiff = compare(pushed(poor))
    assert off(stiff, "finer basis", "stress") > 0.3 > 10 * off(sound, "finer basis", "stress")


def test_a_given_mechanism_is_compared() -> None:
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.02), 16, STEEL, name="bar")
    mesh = pushed(jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)))
    light = jo.Part.beam(
        1.0, jo.Rectangle(0.02, 0.02), 8, replace(STEEL, rho=0.5 * STEEL.rho), name="bar"
    )
    wrong = pushed(jo.reduce(light, jo.CraigBampton(("start", "end"), modes=2)))
    found = compare(pushed(), beside={"16 elements": mesh, "half the mass": wrong})
    assert off(found, "16 elements", "tip") < 1e-4
    assert off(found, "half the mass", "stress") > 1e-2
    with pytest.raises(jo.InputError, match="beside must be mechanisms by names"):
        compare(pushed(), beside={"fine": 3})


def test_a_body_with_damping_is_compared_without_it(sound: Verification) -> None:
    """A damping ratio is that of the free body: of the modes of another frame it is another."""
    found = compare(pushed(damping=0.05))
    assert off(found, "another frame", "tip") == pytest.approx(
        off(sound, "another frame", "tip"), rel=0.5
    )


def test_exchanged_mechanisms_move_alike() -> None:
    machine = pushed()
    body = machine.bodies[0]
    assert isinstance(body, jo.FlexibleBody)
    other = with_parts(machine, {body: in_frame(bar(), NodeFrame("start"))})
    assert other.bodies[0] is not body
    assert other.joints[0].b.body is other.bodies[0]
    assert other.sensors[1].reading.of is other.joints[0]
    assert with_parts(machine, {}) is machine
    assert with_constant_inputs(machine) is machine


def stop() -> jo.Mechanism:
    machine = pushed()
    tip = machine.sensors[0]
    end = jo.mechanism.Event("low", tip, -10.0, component="z", stop=True)
    return jo.Mechanism(*machine.items, end, name="bar")


def test_two_methods_judge_what_the_moving_frame_does_not_know(monkeypatch: Patch) -> None:
    found = compare(stop())
    assert found.agrees, found
    assert found.unknown == ("event 'low': the moving frame does not stop at events; remove it",)
    assert "does not know 1 thing of the machine; two methods of the engine agree" in found.verdict
    assert "not known" in str(found)
    monkeypatch.setattr(
        engine_variants,
        "contrasting_method",
        lambda solver, model: jo.simulation.Newmark(beta=0.6, gamma=1.0),
    )
    broken = compare(stop())
    assert not broken.agrees
    assert "DISAGREE with a step of 0.0005 s in" in broken.verdict


def test_inputs_are_held() -> None:
    """A push of 3 N at the centre of 2 kg, the initial value of an input."""
    ball = jo.RigidBody("ball", 2.0, (1, 1, 1))
    push = jo.Force("push", ball["center"], (1, 0, 0), signal=jo.Input("load", 3.0))
    machine = jo.Mechanism(ball, push, jo.AccelerationSensor("a", ball["center"]))
    found = verify(machine, 0.01)
    assert found.agrees, found
    assert not found.unknown
    (row,) = (row for row in found.rows if row.name == "a")
    np.testing.assert_allclose(row.size, 1.5, rtol=1e-9)


def swing(*, stiffening: bool) -> jo.Mechanism:
    """A bar with a load at its end falls from a slope: it rings across under tension."""
    part = jo.Part.beam(2.0, jo.Rectangle(0.02, 0.04), 8, STEEL, name="bar")
    method = jo.CraigBampton(("start", "end"), modes=4)
    slope = rotation_matrix((np.cos(np.pi / 12), 0, 0, -np.sin(np.pi / 12)))
    reduced = jo.reduce(part, method, stiffening=stiffening)
    body = jo.FlexibleBody("bar", reduced, orientation=slope)
    load = jo.RigidBody("load", 25.0, (0.1,) * 3, position=slope @ (2.0, 0, 0))
    hinge = jo.Revolute("pivot", jo.ground["origin"], body["start"], axis=(0, 0, 1))
    damper = jo.Spring("damper", hinge.angle, damping=20.0)
    root = jo.StressSensor("root", body, "e1.a.left")
    tied = jo.Revolute("pin", body["end"], load["origin"], axis=(0, 0, 1))
    gravity = jo.Gravity((0, -9.81, 0))
    return jo.Mechanism(body, load, hinge, tied, damper, root, gravity, name="swing")


def test_a_verdict_names_what_another_frame_shows() -> None:
    """Tension stiffens the bar, which linear modes leave out: each frame sees it otherwise."""
    linear, exact = (verify(swing(stiffening=on), 0.5) for on in (False, True))
    assert linear.agrees
    assert off(linear, "another frame", "root") > 0.05 > 4 * off(exact, "another frame", "root")
    said = "; another frame differs by"
    assert said in linear.verdict
    assert "stiffening=True" in linear.verdict
    assert said not in exact.verdict


def test_a_finer_basis_too_fast_for_the_method_runs_by_another() -> None:
    """With twice the modes ROS2 stops at once: the engine takes what it would choose for them."""
    found = verify(swing(stiffening=False), 0.05)
    way = ways_of(found)["finer basis"]
    assert not way.failed
    assert way.worst is not None


def test_a_verdict_names_a_way_that_does_not_come_to_its_end(sound: Verification) -> None:
    stopped = Way("finer basis", (), "the run stopped at 0.01 s")
    found = replace(sound, ways=(*sound.ways[:2], stopped))
    assert found.verdict.endswith("; finer basis not compared: the run stopped at 0.01 s")
    assert "not compared" not in sound.verdict
