"""Named constants of a model file as parameters of exported programs."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

import jousto as jo
from exported import CC, PLAIN, compiled
from jousto.export import tunable_constants
from jousto.export.program import program
from jousto.export.project import flat_files
from jousto.export.tunable_constants import named_constants

FILE = """
name: cart
parameters:
  k: {value: 800 N/m, bounds: [100 N/m, 2000 N/m]}
  g: 9.81 m/s2
  share: 0.25
  load: 2 kg
  squared: 3.0
  length: 0.2 m
bodies: [{name: cart, mass: "${load}", inertia: [1, 1, 1]}]
joints: [{type: prismatic, name: rail, a: ground.origin, b: cart.origin, axis: [0, 0, 1]}]
forces:
  - {type: spring, name: one, coordinate: rail.displacement, stiffness: "${k}", damping: 3}
  - {type: spring, name: two, coordinate: rail.displacement, stiffness: "${k * 0.5 + 10 N/m}"}
  - {type: spring, name: three, coordinate: rail.displacement, stiffness: "${share * 100 N/m}",
     free: "${length}"}
  - {type: spring, name: four, coordinate: rail.displacement,
     stiffness: "${squared * squared * 1 N/m}"}
gravity: [0, 0, "${-1 * g}"]
sensors: [{type: coordinate, name: place, coordinate: rail.displacement}]
simulation: {t_end: 1 s, solver: {type: RK4, step: 1 ms}}
"""

MAIN = """
#include "plant.h"
#include <stdio.h>
static union { double number; char bytes[PLANT_BYTES]; } memory;
int main(void)
{
    jo_machine *k = jo_machine_place(&PLANT, memory.bytes, (long long)sizeof memory.bytes);
    double x, state[400];
    if (jo_machine_state_size(k) > 400) return 2;
    for (int round = 0; round < 3; round++) {
        if (round == 1) {
            jo_machine_set_parameter(k, cart_model_parameter_k, 500.0);
            jo_machine_set_parameter(k, cart_model_parameter_g, 5.0);
            jo_machine_set_parameter(k, cart_model_parameter_share, 0.75);
            jo_machine_save(k, state);
        }
        if (round == 2) {
            jo_machine_reset(k);
            jo_machine_load(k, state);
        }
        jo_machine_step(k, 300);
        jo_machine_get_output(k, 0, &x);
        printf("%.17g %.17g\\n", jo_machine_get_parameter(k, cart_model_parameter_k), x);
        if (round == 0) jo_machine_reset(k);
    }
    return 0;
}
"""


@pytest.fixture
def cart(tmp_path: Path) -> Path:
    path = tmp_path / "cart.yaml"
    path.write_text(FILE)
    return path


def test_constants_that_move_forces_alone_are_found(cart: Path) -> None:
    file = jo.read_model(cart)
    model = jo.compile(file.mechanism)
    found = {x.name: x for x in named_constants(file, model)}
    # of the others one is a mass and one stands squared
    assert list(found) == ["k", "g", "share", "length"]
    assert found["k"].bounds == (100.0, 2000.0) and found["k"].unit == "N/m"
    assert sorted(factor for _, factor, _ in found["k"].links) == pytest.approx([0.5, 1.0])
    assert [factor for _, factor, _ in found["g"].links] == pytest.approx([-1.0])
    assert max(factor for _, factor, _ in found["share"].links) == pytest.approx(100.0)


def test_what_is_no_model_file_is_refused(cart: Path) -> None:
    with pytest.raises(jo.InputError) as found:
        named_constants(str(cart), jo.read_model(cart).mechanism)  # type: ignore[arg-type]
    assert "must come from read_model" in str(found.value)
    assert "must come from compile" in str(found.value)


def test_what_parts_are_made_of_is_not_tried(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A mesh may take minutes to reduce; a name of the crane's file that no part has is tried."""
    text = (Path(__file__).parents[2] / "examples" / "crane_live.yaml").read_text()
    path = tmp_path / "crane.yaml"
    path.write_text(
        text.replace("parameters:", "parameters:\n  l: 4 m\n  k: 140 kN m/rad", 1)
        .replace("length: 4 m", 'length: "${l}"', 1)
        .replace("kp: 140 kN m/rad", 'kp: "${k}"', 1)
    )
    file = jo.read_model(path)
    model = jo.compile(file.mechanism)
    tried: list[str] = []
    variant = tunable_constants._variant

    def seen(file: object, values: dict[str, float], *rest: object) -> object:
        tried.extend(values)
        return variant(file, values, *rest)

    monkeypatch.setattr(tunable_constants, "_variant", seen)
    assert [x.name for x in named_constants(file, model)] == ["k"]
    assert set(tried) == {"load", "k"}


@pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler")
def test_a_program_with_other_values_is_that_of_the_other_file(cart: Path, tmp_path: Path) -> None:
    """Set in the running program, or written into the file and simulated: the same to round-off."""
    file = jo.read_model(cart)
    model = jo.compile(file.mechanism)
    solver = jo.RK4(step=1e-3)
    made = program(model, solver, name="cart_model", named=named_constants(file, model))
    for name, text in (flat_files(made) | {"use.c": MAIN}).items():
        (tmp_path / name).write_text(text)
    sources = [path.name for path in tmp_path.glob("*.c")]
    run = compiled(tmp_path, *sources, flags=("-DJO_NO_ALLOCATION", *PLAIN))
    import subprocess

    done = subprocess.run([run], capture_output=True, text=True, check=True).stdout
    rows = [[float(x) for x in row.split()] for row in done.splitlines()]

    def place(text: str) -> float:
        cart.write_text(text)
        other = jo.compile(jo.read_model(cart).mechanism)
        return float(jo.simulate(other, 0.3, solver=solver)["place"][-1, 0])

    changed = (
        FILE.replace("value: 800 N/m", "value: 500 N/m")
        .replace("g: 9.81", "g: 5.0")
        .replace("share: 0.25", "share: 0.75")
    )
    wanted = [place(FILE), place(changed)]
    assert rows[0] == pytest.approx([800.0, wanted[0]], rel=1e-11)
    assert rows[1] == pytest.approx([500.0, wanted[1]], rel=1e-11)
    assert rows[2] == rows[1], "a kept state remembers them"
    assert abs(wanted[0] - wanted[1]) > 1e-2 * np.abs(wanted).max()
