"""jousto friction: both runs of a model, or two results."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app

MODEL = """\
name: pendulum
parts:
  rod:
    type: beam
    length: 1 m
    section: {type: rectangle, width: 20 mm, height: 20 mm}
    elements: 2
    material: {E: 210 GPa, nu: 0.3, rho: 7850}
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 0}
bodies:
  - {name: arm, part: rod, damping: 0.02}
joints:
  - {type: revolute, name: pin, a: ground.origin, b: arm.start, axis: [0, 1, 0]}
frictions:
  - {name: rub, joint: pin, mu_kinetic: 0.3, radius: 50 mm, law: {type: stick-slip}}
gravity: [0, 0, -9.81]
sensors:
  - {type: force, name: torque, force: rub}
simulation: {t_end: 1.2 s, solver: {type: ROS2, step: 0.5 ms}, output_step: 2 ms}
"""


def jousto(*args: object, code: int = 0) -> str:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    assert result.exit_code == code, result.output
    return result.output


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "pendulum.yaml"
    path.write_text(MODEL)
    return path


def test_a_model_is_run_twice_and_compared(model, tmp_path):
    out = jousto("friction", model, "--csv", tmp_path / "f.csv", "-o", tmp_path / "f.png")
    assert "stress of arm due to friction" in out
    assert "transitions between stick and slip" in out
    assert "rub (pin)" in out
    rubbed, smooth = (
        jo.load(tmp_path / f"pendulum.{kind}.h5") for kind in ("friction", "frictionless")
    )
    assert rubbed.energy.friction[-1] > 0.1
    assert smooth.energy.friction[-1] == 0.0
    assert {event.joint for event in rubbed.events} == {"pin"}
    with open(tmp_path / "f.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    found = jo.recovery.friction_stress(rubbed, smooth, "arm")
    assert float(rows[1][4]) == pytest.approx(found.table(1)[0]["due"])
    # searched where no instant is stored: not known, instead of 0
    narrow = jo.recovery.friction_stress(rubbed, smooth, "arm", window=1e-8)
    between = [t for t in narrow.transitions if np.abs(rubbed.time - t.time).min() > 1e-6]
    assert between
    assert np.isnan([[t.jump, t.stress] for t in between]).all()
    assert "its stress is not known" in str(between[0])
    assert found.peaks(1)[0].jump > 0.0  # those of which nothing is known come last
    with Image.open(tmp_path / "f.png") as picture:
        assert len(picture.convert("RGB").getcolors(1 << 24)) > 20
    # the same of the results
    again = jousto(
        *("friction", rubbed.path, smooth.path, "--from", 0.2, "--to", 0.6, "--window", 0.05)
    )
    assert "from 0.2 to 0.6 s" in again


def test_mistakes(model, tmp_path):
    jousto("run", model, "-q")
    result = tmp_path / "pendulum.h5"
    assert "give that of the run without friction as well" in jousto("friction", result, code=2)
    assert "leave the second file out" in jousto("friction", model, result, code=2)
    out = jousto("friction", result, result, "--body", "am", code=2)
    assert "no flexible body 'am'; did you mean 'arm'?" in out
    # nothing is simulated before the bodies are known
    assert "no flexible body 'am'" in jousto("friction", model, "--body", "am", code=2)
    assert not list(tmp_path.glob("*friction*.h5"))
    model.write_text(MODEL.replace("frictions:", "events: []\n#").replace("  - {name: rub", "#"))
    text = "\n".join(line for line in model.read_text().splitlines() if "torque" not in line)
    model.write_text(text.replace("sensors:", ""))
    assert "has no friction to remove" in jousto("friction", model, code=2)
