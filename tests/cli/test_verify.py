"""jousto verify: the verdict, the exit code, a missing end."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from jousto.cli.group import app
from jousto.model.packing import builder

MODEL = """
bodies:
  - {name: ball, mass: 2, inertia: [1, 1, 1], position: [1, 0, 0], markers: {foot: [-1, 0, 0]}}
joints: [{type: revolute, name: hinge, a: ground.origin, b: ball.foot}]
forces: [{type: spring, name: coil, coordinate: hinge.angle, stiffness: 3 N m/rad, free: 0.5 rad}]
sensors: [{type: position, name: place, marker: ball.origin}]
"""


def run(*words: object) -> tuple[int, str]:
    found = CliRunner().invoke(app, [str(word) for word in words])
    return found.exit_code, found.output


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "swing.yaml"
    path.write_text(MODEL, encoding="utf-8")
    return path


def test_the_verdict_and_the_exit_code(model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    code, out = run("verify", model, "--t-end", "40 ms", "--step", "4 ms")
    assert code == 0, out
    assert "the formulations agree: " in out.splitlines()[-1]
    made = builder.packed

    def stiffer(struct: str, *rest: object, **data: float) -> object:
        if struct == "jo_along_data":
            data["stiffness"] *= 1.001
        return made(struct, *rest, **data)

    monkeypatch.setattr(builder, "packed", stiffer)
    code, out = run("verify", model, "--t-end", "40 ms", "--step", "4 ms")
    assert code == 1
    assert "DISAGREE: 'force of coil' differs by 0.001 of its size" in out.splitlines()[-1]


def test_a_model_without_an_end_asks_for_it(model: Path) -> None:
    code, out = run("verify", model)
    assert code == 2
    assert "give --t-end" in out


def test_other_models_are_compared_by_their_sensors(model: Path, tmp_path: Path) -> None:
    other = tmp_path / "heavy.yaml"
    other.write_text(MODEL.replace("mass: 2", "mass: 3"), encoding="utf-8")
    line = ["verify", model, "--t-end", "40 ms", "--step", "4 ms", "--beside"]
    code, out = run(*line, model, "--beside", other)
    assert code == 0, out
    # the model itself does not differ; with another mass on the same spring the place does
    same, heavy = re.findall(r"\.yaml +differs by (\S+) of the size", out)
    assert float(same) < 1e-12 < 1e-5 < float(heavy)
    code, out = run(*line, tmp_path / "none.yaml")
    assert code == 2
    assert "none.yaml" in out
