"""advise_flexibility: verdicts, errors, and machines at the edge."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from design.flexibility.flexible_machines import arm, driven_arm
from jousto.design import advise_flexibility
from jousto.design.flexibility.flexibility_advice import FlexibilityAdvice
from jousto.mechanism.body_variants import with_modes, with_rigid_bodies


@pytest.fixture(scope="module")
def soft() -> FlexibilityAdvice:
    return advise_flexibility(driven_arm(thick=0.012), 1.0, slope=5.0, output_step=2.5e-3)


def test_soft_arm_must_be_flexible(soft: FlexibilityAdvice) -> None:
    body = soft["arm"]
    assert soft.flexible == ("arm",)
    names = {one.reading: one for one in body.readings}
    assert set(names) == {"tip.x", "tip.y", "tip.z", next(n for n in names if "stress" in n)}
    # sag of a cantilever under its weight, rho A g L^4 / 8 E I
    h = 0.012
    sag = 7850 * h**2 * 9.81 / (8 * 2.1e11 * h**4 / 12)
    z = names["tip.z"]
    assert z.measured is not None
    assert z.measured.difference == pytest.approx(sag, rel=0.5)
    for one in body.readings:
        assert one.within_estimate()
    text = str(soft)
    assert "leave 'arm' flexible: " in text
    assert "first frequency" in text


def test_stress_of_a_rigid_body_is_that_of_statics(soft: FlexibilityAdvice) -> None:
    stress = next(one for one in soft["arm"].readings if one.reading.startswith("stress arm"))
    assert stress.recovered
    assert stress.measured is not None
    # not lost: only its vibration is
    assert -0.5 < stress.measured.peak < 0.1
    assert 0.0 < stress.life < 1.2


def test_stiff_arm_can_be_rigid() -> None:
    advice = advise_flexibility(driven_arm(thick=0.12), 1.0, limit=0.1, output_step=2.5e-3)
    assert advice.flexible == ()
    assert "make 'arm' rigid: no reading loses more than 10 % of its range" in str(advice)
    assert advise_flexibility(
        driven_arm(thick=0.12), 1.0, limit=1e-6, modes=False, output_step=5e-3
    ).flexible == ("arm",)


def test_from_the_rigid_machine_alone(soft: FlexibilityAdvice) -> None:
    advice = advise_flexibility(driven_arm(thick=0.012), 1.0, from_rigid=True, output_step=2.5e-3)
    body = advice["arm"]
    assert all(one.measured is None for one in body.readings)
    assert "make 'arm' flexible: " in str(advice)
    assert "mm elsewhere" in str(advice)
    measured = {one.reading: one for one in soft["arm"].readings}
    for one in body.readings:
        if one.reading.startswith("tip"):
            full = measured[one.reading].measured
            assert full is not None
            assert one.estimate >= 0.8 * full.difference - 1e-12
            assert one.estimate <= 3.0 * full.difference + 1e-9


def test_chosen_readings() -> None:
    advice = advise_flexibility(driven_arm(), 0.2, readings="tip.z", modes=False, output_step=5e-3)
    assert [one.reading for one in advice["arm"].readings] == ["tip.z"]


def test_energy_of_modes_and_run_without_the_smallest() -> None:
    advice = advise_flexibility(driven_arm(), 0.3, output_step=5e-3)
    modes = advice["arm"].modes
    assert modes is not None
    assert modes.energy.sum() == pytest.approx(1.0)
    # the machine moves in a plane: modes across it, of torsion and of length carry nothing
    assert modes.left_out >= 3
    assert modes.readings
    assert max(one.worst for one in modes.readings) < 0.02
    assert np.sort(modes.energy)[: modes.left_out].sum() < 0.02**2


def test_table_of_a_file(soft: FlexibilityAdvice, tmp_path: Path) -> None:
    with soft.to_csv(tmp_path / "a.csv").open() as file:
        rows = list(csv.DictReader(file))
    first = [row for row in rows if row["change"] == "rigid"]
    assert [row["reading"] for row in first] == [one.reading for one in soft["arm"].readings]
    table = json.loads(soft.to_json(tmp_path / "a.json").read_text())
    assert table["machine"] == "arm"
    assert table["readings"][0]["difference"] == float(first[0]["difference"])


def test_machine_whose_readings_have_no_range() -> None:
    # a hanging arm at rest: nothing moves, nothing is lost
    body = arm()
    hinge = jo.Fixed("hold", jo.ground["origin"], body["start"])
    machine = jo.Mechanism(
        body, hinge, jo.Gravity((-9.81, 0, 0)), jo.PositionSensor("tip", body["end"]), start="rest"
    )
    advice = advise_flexibility(machine, 0.1, output_step=5e-3)
    tips = [one for one in advice["arm"].readings if one.reading.startswith("tip")]
    assert all(one.measured is not None and one.measured.absolute for one in tips)
    # elongation under its weight, rho g L^2 / 2 E; judged by the peak, 1 m
    x = next(one for one in tips if one.reading == "tip.x")
    assert x.measured is not None
    assert x.measured.difference == pytest.approx(7850 * 9.81 / (2 * 2.1e11), rel=1e-3)
    assert advice["arm"].verdict == "rigid"


def test_rigid_run_that_fails_is_a_result() -> None:
    # a strip clamped at both ends, one of which is pushed across: rigid, it cannot follow
    body = arm()
    end = jo.RigidBody("end", 1.0, (0.1, 0.1, 0.1), position=(1, 0, 0))
    slide = jo.Prismatic("slide", jo.ground.at((1, 0, 0)), end["origin"], axis=(0, 1, 0))
    machine = jo.Mechanism(
        *(body, end, slide),
        jo.Fixed("left", jo.ground["origin"], body["start"]),
        jo.Spherical("right", body["end"], end["origin"]),
        jo.Drive("push", slide.displacement, jo.SCurve((0.0, 1.0), (0.0, 0.01))),
        jo.PositionSensor("tip", body["end"]),
    )
    advice = advise_flexibility(machine, 1.0, modes=False, output_step=0.01)
    assert advice["arm"].verdict == "flexible"
    assert "the run with the rigid body fails: " in advice["arm"].failed
    assert "leave 'arm' flexible: the run with the rigid body fails" in str(advice)
    assert advice.to_csv


@pytest.mark.filterwarnings("ignore::jousto.base.errors.JoustoWarning")
def test_impact_loses_everything() -> None:
    body = arm()
    hinge = jo.Revolute("hinge", jo.ground["origin"], body["start"], axis=(0, 1, 0))
    stop = jo.mechanism.Stop("stop", hinge.angle, upper=0.2, stiffness=1e4)
    machine = jo.Mechanism(
        *(body, hinge, stop, jo.Gravity((0, 0, -9.81))), jo.PositionSensor("tip", body["end"])
    )
    advice = advise_flexibility(machine, 0.4, modes=False, output_step=2e-3, limit=0.99)
    assert advice["arm"].impact
    assert advice["arm"].verdict == "flexible"
    assert "an impact excites all frequencies" in str(advice)


def test_wrong_arguments_all_at_once() -> None:
    with pytest.raises(jo.InputError) as caught:
        advise_flexibility(
            *(driven_arm(), -1.0), bodies="amr", readings=["tpi"], limit=0.0, sloper=3
        )
    text = str(caught.value)
    for part in ("'amr'; did you mean 'arm'", "'tpi'; did you mean 'tip'", "limit", "t_end"):
        assert part in text
    assert "'sloper'" in text
    with pytest.raises(jo.InputError, match="no end time"):
        advise_flexibility(driven_arm())
    with pytest.raises(jo.InputError, match="must be a Mechanism"):
        advise_flexibility(3, 1.0)


def test_machine_without_elastic_data() -> None:
    bar = jo.RigidBody("bar", 1.0, (0.1, 0.1, 0.1))
    hinge = jo.Revolute("hinge", jo.ground["origin"], bar["origin"])
    with pytest.raises(jo.InputError, match=r"\(bar\) have no elastic data: neither stiffness"):
        advise_flexibility(jo.Mechanism(bar, hinge), 1.0)
    machine = driven_arm()
    weld = jo.Fixed("weld", machine.bodies[0]["end"], bar.at((1, 0, 0)))
    other = jo.Mechanism(*machine.items, bar, weld)
    with pytest.raises(jo.InputError, match="body 'bar': is rigid and has no elastic data"):
        advise_flexibility(other, 1.0, bodies=["bar"])


def test_variant_keeps_the_rest_of_the_machine() -> None:
    machine = driven_arm()
    sensor = jo.StressSensor("root", machine.bodies[0])
    ends = jo.mechanism.Event("high", sensor, 1e9, component=0, stop=True)
    full = jo.Mechanism(*machine.items, sensor, name="m")
    variant = with_rigid_bodies(full, ["arm"])
    assert variant.dropped == ("root",)
    assert [one.name for one in variant.mechanism.sensors] == ["tip"]
    assert variant.mechanism.bodies[0].mass == pytest.approx(
        machine.bodies[0].reduced.invariants.mass
    )
    assert full.bodies[0] is machine.bodies[0]
    few = with_modes(full, {"arm": [0, 2]}).mechanism
    assert few.bodies[0].n == 2
    assert few.sensors[1].body is few.bodies[0]
    with pytest.raises(jo.InputError, match="needs sensor 'root'"):
        with_rigid_bodies(jo.Mechanism(*machine.items, sensor, ends, name="m"), ["arm"])
    with pytest.raises(jo.InputError, match="no body 'amr'"):
        with_rigid_bodies(full, ["amr"])


def test_gauges_have_the_modes_that_remain() -> None:
    machine = driven_arm()
    gauge = jo.gauges.Gauge("top", machine.bodies[0], "e1.a.top")
    few = with_modes(jo.Mechanism(*machine.items, gauge, name="m"), {"arm": [0, 2]}).mechanism
    copied = next(one for one in few.sensors if one.name == "top")
    assert copied.rows.shape == (1, 2)
    np.testing.assert_array_equal(copied.rows, gauge.rows[:, [0, 2]])
    jo.compile(few)


def test_limits_are_shares_and_percent_is_proposed() -> None:
    with pytest.raises(
        jo.InputError, match=r"limit is 5, 500 %; give a share such as 0.05 or '5 %'"
    ):
        jo.design.advise_flexibility(idle_machine(), 0.1, limit=5)


def test_nothing_is_rigid_where_nothing_happens() -> None:
    """Without loads all readings are equal, and say nothing."""
    advice = jo.design.advise_flexibility(idle_machine(), 0.05, output_step=0.01)
    assert advice.bodies[0].verdict == "flexible"
    assert "no load deforms it in this run, so that nothing was compared" in str(advice)


def idle_machine() -> jo.Mechanism:
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850)
    part = jo.Part.beam(1.0, jo.Rectangle(0.03, 0.012), 3, steel)
    arm = jo.FlexibleBody("arm", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=2)))
    hinge = jo.Fixed("hinge", jo.ground["origin"], arm["start"])
    push = jo.Force("push", arm["end"], (0, 0, 100.0), signal=jo.Constant(0.0))
    return jo.Mechanism(arm, hinge, push, jo.PositionSensor("tip", arm["end"]))
