"""A model file that starts at rest does so for everyone who runs its mechanism."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from jousto.simulation.live.machine import LiveMachine

# a mass of 2 kg on a spring of 500 N/m hangs 2 x 9.81 / 500 m below where the spring is free
FILE = """
gravity: [0, -9.81, 0]
bodies: [{type: rigid, name: weight, mass: 2, inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: guide, a: ground.origin, b: weight.origin, axis: [0, 1, 0]}]
forces: [{type: spring, name: hanger, coordinate: guide.displacement, stiffness: 500}]
sensors: [{type: coordinate, name: place, coordinate: guide.displacement}]
simulation: {t_end: 0.5, start: START}
"""
REST = -2.0 * 9.81 / 500.0


def mechanism(folder: Path, start: str) -> jo.Mechanism:
    path = folder / f"{start}.yaml"
    path.write_text(FILE.replace("START", start))
    found = jo.read_model(path).mechanism
    assert found is not None
    return found


def test_runs_of_the_mechanism_start_at_rest(tmp_path: Path) -> None:
    model = jo.compile(mechanism(tmp_path, "rest"))
    run = jo.simulate(model, 0.5)
    np.testing.assert_allclose(run["place"], REST, rtol=1e-9)
    sim = jo.simulation.Simulator(model)
    sim.step(100)
    np.testing.assert_allclose(sim.read("place"), REST, rtol=1e-9)
    live = LiveMachine(model)
    np.testing.assert_allclose(live.state().q[1], REST, rtol=1e-9)


def test_a_state_that_is_given_counts_more(tmp_path: Path) -> None:
    model = jo.compile(mechanism(tmp_path, "rest"))
    free = jo.compile(mechanism(tmp_path, "initial"))
    run = jo.simulate(model, 0.5, state=jo.simulate(free, 0.1).state(0.0))
    lowest = float(np.min(run["place"]))
    assert abs(lowest - 2.0 * REST) < 1e-3 * abs(REST)  # swings to twice the sag


def test_programs_start_there_too(tmp_path: Path) -> None:
    model = jo.compile(mechanism(tmp_path, "rest"))
    source = jo.write(model, tmp_path / "weight.c").read_text()
    numbers = np.array([float.fromhex(x) for x in re.findall(r"-0x1\.\w+p[-+]\d+", source)])
    assert np.abs(numbers / REST - 1.0).min() < 1e-9


def test_verify_starts_there(tmp_path: Path) -> None:
    found = jo.verify(mechanism(tmp_path, "rest"), 0.1)
    assert found.agrees and found.still


def test_words(tmp_path: Path) -> None:
    with pytest.raises(
        jo.InputError, match="start is 'up', must be 'initial', 'rest' or 'vibration-free'"
    ):
        jo.Mechanism(start="up")


def test_beside_a_unit_of_another_program_rest_is_not_known(tmp_path: Path) -> None:
    model = jo.compile(mechanism(tmp_path, "rest"))
    unit = jo.write(jo.compile(mechanism(tmp_path, "initial")), tmp_path / "unit.fmu")
    items = mechanism(tmp_path, "rest").items
    beside = jo.Mechanism(*items, jo.Fmu(unit, name="unit"), start="rest")
    with pytest.raises(jo.InputError, match="fmu 'unit' in that state are not known; take start"):
        jo.simulate(jo.compile(beside), 0.1)
    assert jo.simulate(jo.compile(beside), 0.1, state=jo.equilibrium(model)).complete
