"""jousto path and buckle on a truss with a closed form."""

from __future__ import annotations

import re

import numpy as np
import pytest
from typer.testing import CliRunner

from jousto.cli.group import app

MODEL = """\
name: truss
bodies: [{name: apex, mass: 1 kg, inertia: [0.01, 0.01, 0.01], position: [0, 0.4, 0]}]
joints: [{type: prismatic, name: guide, a: ground.origin, b: apex.origin, axis: [0, 1, 0]}]
forces:
  - {type: spring, name: left, stiffness: 1000,
     coordinate: {type: distance, a: {body: ground, at: [-1, 0, 0]}, b: apex.origin}}
  - {type: spring, name: right, stiffness: 1000,
     coordinate: {type: distance, a: {body: ground, at: [1, 0, 0]}, b: apex.origin}}
  - {type: force, name: push, marker: apex.origin, vector: [0, -1, 0],
     signal: {type: input, name: load}}
sensors: [{type: position, name: apex, marker: apex.origin}]
"""
REST = np.hypot(1.0, 0.4)
TURN = np.sqrt(REST ** (2 / 3) - 1)
LIMIT = 2000 * (REST - np.hypot(1.0, TURN)) * TURN / np.hypot(1.0, TURN)


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "truss.yaml"
    path.write_text(MODEL)
    return path


def jousto(*args: object) -> tuple[int, str]:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    return result.exit_code, result.output


def test_a_path_names_its_limits_and_writes_table_and_picture(model, tmp_path):
    table, picture = tmp_path / "t.csv", tmp_path / "p.png"
    code, out = jousto("path", model, "--to", 50, "--arc", "--csv", table, "-o", picture)
    assert code == 0, out
    limits = [float(x) for x in re.findall(r"limit +load = (\S+),", out)]
    assert limits == pytest.approx([LIMIT, -LIMIT], rel=1e-5)
    assert table.read_text().startswith("load,")
    assert picture.exists()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--sensor", "apx.y", "-o", "a.png"), "no sensor 'apx'"),
        (("--sensor", "apex.7"), "has 3 values; say which"),
        (("-o", "a.txt"), "known: .png, .svg, .pdf, .jpg, .jpeg, .webp, .eps"),
        (("--csv", "a.txt"), "known: .csv"),
    ],
)
def test_a_path_is_not_followed_for_nothing(model, tmp_path, monkeypatch, options, told):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        "jousto.simulation.statics.load_path.load_path", lambda *_, **__: pytest.fail("it ran")
    )
    code, out = jousto("path", model, "--to", 5, *options)
    assert code == 2, out
    assert told in " ".join(out.split())


def test_load_steps_fail_at_the_limit_with_the_remedy(model):
    code, out = jousto("path", model, "--to", 50)
    assert code == 1
    assert "limit point is near" in out


def test_buckling_is_found_on_the_path(model):
    code, out = jousto("buckle", model, "--path", "-n", 1)
    assert code == 0, out
    (load,) = re.findall(r"load = (\S+) +limit", out)
    assert float(load) == pytest.approx(LIMIT, rel=1e-5)


def test_what_is_missing_is_said(model):
    code, out = jousto("path", model)
    assert code == 2
    assert "give --to VALUE" in out
    model.write_text(MODEL.replace("{type: input, name: load}", "{type: constant, value: 1}"))
    code, out = jousto("buckle", model)
    assert code == 2
    assert "name the load parameter with --input NAME; inputs: none" in out
