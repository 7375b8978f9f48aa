"""Every kind of force is declared whole: its law, units, picture and second formulation."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import jousto as jo
from jousto.base.declare import kinds
from jousto.mechanism.forces.law import LAWS, law_of
from jousto.mechanism.joints.coordinate import Along
from jousto.model.force_numbers import law_in, struct_of
from jousto.model.native import header
from jousto.natural.equations import force_laws
from scene.machines import everything

ROOT = Path(__file__).parents[2]
ROWS = header.kinds("jo_force_type")
CLASSES = {
    word: cls
    for word, cls in kinds("forces", "jousto.mechanism.forces").items()
    if cls.__module__.startswith("jousto.")
}

DOTS = {"contacts", "modal-load", "user-force"}
"""Forces that pictures show as dots: one is among many bodies, one acts on a whole body, one as its
user wants."""


def test_every_law_of_the_engine_is_declared():
    assert set(LAWS) == set(ROWS)


@pytest.mark.parametrize("name", LAWS)
def test_every_number_has_a_unit_or_stays(name):
    law, places = LAWS[name], header.places(struct_of(name))
    assert set(law.units) | set(law.constants) == set(places)
    assert not set(law.units) & set(law.constants)
    assert set(law.notes) <= set(law.units)
    for key, unit in law.units.items():
        size = places[key].stop - places[key].start
        if isinstance(unit, tuple):
            assert len(unit) ** 2 == size
        else:
            assert size == 1 or (size == 3 and isinstance(unit, str))


@pytest.mark.parametrize("name", LAWS)
def test_the_second_formulation_has_every_law_or_says_why_not(name):
    assert (name in force_laws.LAWS) != bool(force_laws.REFUSED.get(name))


def test_the_second_formulation_has_no_law_of_its_own():
    assert set(force_laws.LAWS) | set(force_laws.REFUSED) == set(LAWS)


def test_laws_are_side_by_side_whose_files_are_compiled_for_vectors():
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    left_out = {name.replace("_", " ") for name in re.findall(r"\bforce_(\w+)\|", text)}
    assert {name for name, law in LAWS.items() if law.side_by_side} == set(LAWS) - left_out
    assert left_out < set(LAWS)


@pytest.mark.parametrize("name", LAWS)
def test_laws_that_store_energy_act_between_bodies(name):
    file = ROOT / "engine" / "force" / f"force_{name.replace(' ', '_')}.c"
    (row,) = re.findall(r"^const jo_force_kind \w+ = \{(.*)\};", file.read_text(), re.M)
    apply, stored, tangent, *_ = row.split(", ")
    assert (apply, tangent) == ("apply", "tangent")
    assert stored == "0" or LAWS[name].between
    assert bool(LAWS[name].fast) == LAWS[name].between
    assert row.endswith("&yielding") == LAWS[name].yields


def test_states_and_units_are_those_of_a_model():
    model = jo.compile(everything())
    for force in model.forces:
        law = law_in(force)
        names = list(law.states)
        if law.name.startswith("contact"):  # fewer points, or without resistance to turning
            names = names[: len(force.state_names)]
        assert names == list(force.state_names)
        along = [unit for unit in law.units.values() if isinstance(unit, Along)]
        assert not along or force.coordinate >= 0


@pytest.mark.parametrize("word", CLASSES)
def test_every_force_can_be_seen_measured_or_says_why_not(word):
    page = (ROOT / "frontend/src/render/symbols/kinds.ts").read_text(encoding="utf-8")
    (*_, force) = [x for x in everything().forces if x.tag == word]
    assert (f'"{force.symbol}"' in page) != (word in DOTS)
    assert force.drawn_at or force.coordinates or force.pushes[0].body is not None
    assert set(force.measured) <= {"force", "moment"} and force.measured
    if force.unmeasured:
        with pytest.raises(jo.InputError, match=force.unmeasured):
            jo.ForceSensor("s", force)
    else:
        sensor = jo.ForceSensor("s", force)
        assert sensor.components and sensor.unit and force.name in sensor.description


def test_a_law_that_is_not_declared_has_nothing_of_all_this():
    law = law_of("cubic")
    assert not (law.units or law.states or law.between or law.fast or law.side_by_side)
