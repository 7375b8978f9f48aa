"""jousto advise MODEL: table, files, and wrong options, also in a process of its own."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest
from typer.testing import CliRunner

from jousto.cli.group import app

MODEL = """\
name: arm
parts:
  beam:
    type: beam
    length: 1 m
    section: {type: rectangle, width: 30 mm, height: 12 mm}
    elements: 3
    material: {E: 210 GPa, nu: 0.3, rho: 7850}
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 2}
bodies: [{name: arm, part: beam, damping: 2 %}]
joints: [{type: revolute, name: hinge, a: ground.origin, b: arm.start, axis: [0, 1, 0]}]
couplings:
  - type: drive
    name: drive
    coordinate: hinge.angle
    signal: {type: s-curve, times: [0, 400 ms], values: [0, 0.3]}
sensors: [{type: position, name: tip, marker: arm.end}]
simulation: {t_end: 0.5 s, output_step: 2.5 ms, solver: {type: ROS2, step: 0.5 ms}}
"""


@pytest.fixture
def model(tmp_path: Path) -> Path:
    path = tmp_path / "arm.yaml"
    path.write_text(MODEL)
    return path


def jousto(*args: object) -> tuple[int, str]:
    result = CliRunner().invoke(app, ["advise", *map(str, args)])
    return result.exit_code, result.output


def test_table_and_recommendation_in_a_process_of_its_own(model: Path) -> None:
    command = [sys.executable, "-m", "jousto", "advise", "arm.yaml", "-o", "a.csv"]
    done = subprocess.run(command, cwd=model.parent, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "leave 'arm' flexible: " in done.stdout
    assert "table in a.csv" in done.stdout
    with (model.parent / "a.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["change"] == "rigid"]
    assert {"tip.x", "tip.y", "tip.z"} < {row["reading"] for row in rows}
    assert all(row["steps"] == "1000.0" for row in rows)


def test_rigid_machine_alone_as_json(model: Path) -> None:
    target = model.parent / "a.json"
    code, out = jousto(model, "--from-rigid", "--limit", "50%", "--reading", "tip", "-o", target)
    assert code == 0, out
    table = json.loads(target.read_text())
    assert table["from rigid"] is True
    assert {row["reading"] for row in table["readings"]} == {"tip.x", "tip.y", "tip.z"}
    assert all(row["e_inf"] is None for row in table["readings"])
    assert "leave 'arm' rigid: no reading loses more than 50 % of its range" in out


def test_a_part_of_the_model_still_has_its_own_advice(model: Path) -> None:
    code, out = jousto(model, "beam", "--frequency-limit", "100")
    assert code == 0, out
    assert out.startswith("take CraigBampton(")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--body", "amr"], "no flexible body 'amr'; did you mean 'arm'?"),
        (["--reading", "tpi"], "no reading 'tpi'; did you mean 'tip'?"),
        (["--limit", "0"], "--limit: is 0 1, must be positive"),
        (["--limit", "x", "-o", "a.txt"], "--limit: expects a number, got 'x'"),
        (["-o", "a.txt"], "a.txt"),
        (["--slope", "3", "--frequency-limit", "9"], "cannot be combined with --frequency-limit"),
    ],
)
def test_wrong_options(model: Path, options: list[str], message: str) -> None:
    code, out = jousto(model, *options)
    assert code == 2
    assert message in out


def test_options_of_machines_need_a_machine(tmp_path: Path) -> None:
    part = tmp_path / "part.yaml"
    part.write_text("type: beam\nlength: 1 m\n")
    code, out = jousto(part, "--from-rigid")
    assert code == 2
    assert "--from-rigid: for the bodies of a machine, but part.yaml is a part" in out


def test_machine_without_elastic_data(tmp_path: Path) -> None:
    path = tmp_path / "rigid.yaml"
    path.write_text(
        "bodies: [{name: bar, mass: 1 kg, inertia: [1, 1, 1]}]\nsimulation: {t_end: 1 s}\n"
    )
    code, out = jousto(path)
    assert code == 2
    assert "its rigid bodies (bar) have no elastic data: neither stiffness nor modes" in out
