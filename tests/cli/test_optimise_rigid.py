"""jousto optimise with a rigid machine outside, in a process of its own."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import jousto as jo
from jousto.base.errors import InputError
from jousto.schema.read import parse_model

MODEL = """\
parameters:
  height: {value: 27 mm, bounds: [10 mm, 60 mm]}
parts:
  rod:
    type: beam
    length: 1 m
    section: {type: rectangle, width: 20 mm, height: "${height}"}
    material: {E: 210 GPa, nu: 0.3, rho: 7850}
    elements: 2
    reduce: {type: craig-bampton, interfaces: [start, end], modes: 2}
bodies:
  - {name: carriage, mass: 4 kg, inertia: [0.1, 0.1, 0.1]}
  - {name: mast, part: rod, damping: 2 %}
joints:
  - {type: prismatic, name: rail, a: ground.origin, b: carriage.origin, axis: [0, 0, 1]}
  - {type: fixed, name: weld, a: carriage.origin, b: mast.start}
forces:
  - {type: force, name: push, marker: carriage.origin, vector: [0, 0, 300],
     signal: {type: step, time: 20 ms}}
simulation: {t_end: 0.15, solver: {type: ROS2, step: 0.5 ms}, output_step: 5 ms}
limits:
  - stress(mast) <= 60 MPa
optimisation: {machine: rigid, held: force}
"""


def test_an_unsafe_design_ends_with_code_1(tmp_path: Path) -> None:
    model, page = tmp_path / "mast.yaml", tmp_path / "page.html"
    model.write_text(MODEL)
    command = [sys.executable, "-m", "jousto", "optimise", str(model), "-o", str(page)]
    done = subprocess.run(
        [*command, "--tolerance", "1e-2"], capture_output=True, text=True, timeout=600, check=False
    )
    out = " ".join(done.stdout.split())
    assert done.returncode == 1, done.stdout + done.stderr
    # free of its carriage the mast bends less than it does on it
    assert "UNSAFE: the flexible machine exceeds a limit by" in out
    assert "von-mises of mast: limit 60000000 Pa part alone" in out
    assert "rigid outside" in out and "1 flexible run" in out
    text = page.read_text()
    assert "peaks of the flexible machine" in text and "UNSAFE" in text


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--machine", "ridgid"), "--machine: is 'ridgid'; did you mean 'rigid'?"),
        (("--machine", "flexible", "--beyond"), "--beyond: has no effect without --machine rigid"),
        (
            ("--machine", "flexible", "--held", "force", "--beyond"),
            "--held: has no effect without --machine rigid "
            "--beyond: has no effect without --machine rigid",
        ),
        (("--held", "both"), "--held: is 'both'"),
        (("--reliable", "--machine", "rigid"), "--machine: is for designs without scatter"),
    ],
)
def test_wrong_options_are_told(options: tuple[str, ...], message: str, tmp_path: Path) -> None:
    from typer.testing import CliRunner

    from jousto.cli.group import app

    model = tmp_path / "mast.yaml"
    model.write_text(MODEL)
    result = CliRunner().invoke(app, ["optimise", str(model), *options])
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())


def test_the_section_of_the_file() -> None:
    problem = jo.design.file_problem(parse_model(MODEL))
    assert problem.rigid == jo.design.RigidMachine(held="force")
    flexible = MODEL.replace("{machine: rigid, held: force}", "{machine: flexible}")
    assert jo.design.file_problem(parse_model(flexible)).rigid is None
    with pytest.raises(InputError, match="reliable design: runs the flexible machine only"):
        jo.design.file_rbdo(parse_model(MODEL))
    with pytest.raises(InputError, match="held has no effect without machine: rigid"):
        parse_model(MODEL.replace("machine: rigid", "machine: flexible"))
    with pytest.raises(InputError, match="machine"):
        parse_model(MODEL.replace("machine: rigid", "machine: ridgid"))
