"""jousto fatigue on a run whose stress is known."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app

MODEL = """\
name: swing
parts:
  rod:
    type: beam
    length: 1 m
    section: {type: rectangle, width: 20 mm, height: 10 mm}
    material: S355
    elements: 2
    reduce: {type: craig-bampton, interfaces: [start], modes: 4}
bodies: [{name: arm, part: rod, damping: 0.5 %}]
joints: [{type: revolute, name: hinge, a: ground.origin, b: arm.start, axis: [0, 0, 1]}]
gravity: [0, -9.81, 0]
simulation: {t_end: 0.6 s, solver: {type: ROS2, step: 1 ms}, output_step: 2 ms}
fatigue:
  curves: {bar: {S_D: 2 MPa, N_D: 1e6, k: 5, T_S: 1.25}}
  checks:
    - {name: the bar, body: arm, sn: bar, residue: repeat, criterion: s11, required: 1 year}
"""


def invoke(*args: object):
    return CliRunner().invoke(app, [str(arg) for arg in args])


def jousto(*args: object) -> str:
    result = invoke(*args)
    assert result.exit_code == 0, result.output
    return result.stdout


def table(path):
    with path.open() as file:
        return list(csv.DictReader(file))


@pytest.fixture(scope="module")
def result(tmp_path_factory):
    folder = tmp_path_factory.mktemp("fatigue")
    path = folder / "swing.yaml"
    path.write_text(MODEL)
    jousto("run", path, "-q")
    return folder / "swing.h5"


def test_checks_of_the_model(result, tmp_path):
    out = jousto("fatigue", result, "--csv", tmp_path / "life.csv")
    assert out.startswith("the bar\n")
    assert "residue: repeat" in out and "required 3.156e+07 s (1 years)" in out
    rows = table(tmp_path / "life.csv")
    field = jo.stress_field(jo.load(result), "arm")
    curve = jo.SN(S_D=2e6, N_D=1e6, k=5)
    history = field.values("s11")
    for i, row in enumerate(rows):
        D = jo.fatigue.damage(jo.fatigue.rainflow(history[:, i], residue="repeat"), curve)
        assert float(row["damage"]) == pytest.approx(D, rel=1e-9, abs=1e-30)
        assert row["site"] == field.labels[i]


def test_curve_of_the_command_line(result, tmp_path):
    """Files for people, ParaView and spreadsheets, of a curve of the library."""
    files = [tmp_path / name for name in ("d.png", "d.vtu", "cycles.png", "cycles.csv")]
    out = jousto(
        "fatigue", result, "--sn", "fat71", "--residue", "half", "-o", files[0], "--vtu", files[1],
        "--cycles", files[2], "--criterion", "signed-principal",
    )  # fmt: skip
    jousto("fatigue", result, "--sn", "bar", "--residue", "half", "--cycles", files[3])
    assert "FAT 71 iiw" in out and "signed-principal" in out
    assert all(file.stat().st_size > 300 for file in files)
    import meshio

    mesh = meshio.read(files[1])
    assert {"damage", "log10 damage", "life (s)", "safety"} <= set(mesh.point_data)


def test_several_results_are_a_duty_cycle(result, tmp_path):
    duty = tmp_path / "duty.yaml"
    duty.write_text(
        f"transitions: separate\nevents:\n- {{result: '{result}', repeats: 10}}\n"
        f"- {{result: '{result}', repeats: 5, name: more}}\n"
    )
    options = ("--sn", "bar", "--residue", "repeat", "--csv", tmp_path / "a.csv")
    jousto("fatigue", "--duty", duty, *options)
    many = {r["site"]: float(r["damage"]) for r in table(tmp_path / "a.csv")}
    jousto("fatigue", result, *options)
    once = {r["site"]: float(r["damage"]) for r in table(tmp_path / "a.csv")}
    assert np.array(list(many.values())) == pytest.approx(15 * np.array(list(once.values())))
    jousto("fatigue", result, result, "--repeats", 10, "--repeats", 5, "--transitions", "separate",
           *options)  # fmt: skip
    again = {r["site"]: float(r["damage"]) for r in table(tmp_path / "a.csv")}
    assert again == many
    found = invoke("fatigue", result, "--duty", duty, *options)
    assert found.exit_code == 2
    assert (
        f"RESULT: cannot be combined with --duty: {duty.name} has results, repeats" in found.stderr
    )


def test_strict_ends_with_code_1(result):
    options = ("--sn", "bar", "--residue", "half", "--required", "1000 years")
    assert invoke("fatigue", result, *options).exit_code == 0
    found = invoke("fatigue", result, *options, "--strict")
    assert found.exit_code == 1
    assert "not enough: the least safety" in found.stderr


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--sn", "fat71"), "residue is missing: give the rule"),
        (("--sn", "fat7x", "--residue", "half"), "no S-N curve 'fat7x'; did you mean 'fat71'?"),
        (
            ("--sn", "bar", "--residue", "half", "--mean", "goodmann 5 MPa"),
            "did you mean 'goodman'",
        ),
        (("--sn", "bar", "--residue", "half", "--mean", "goodman"), "such as 'goodman 500 MPa'"),
        (("--sn", "bar", "--residue", "half", "--body", "amr"), "did you mean 'arm'?"),
        (("--body", "leg"), "has no fatigue: checks: of these bodies"),
        (("--sn", "bar", "--residue", "half", "--criterion", "von-mises"), "has no sign"),
        (("--sn", "bar", "--residue", "half", "--criterion", "normal:1,2"), "shape (2,)"),
    ],
)
def test_mistakes(result, options, sentence):
    found = invoke("fatigue", result, *options)
    assert found.exit_code == 2
    assert sentence in found.stderr


def test_several_results_need_transitions(result):
    found = invoke("fatigue", result, result, "--sn", "bar", "--residue", "half")
    assert found.exit_code == 2
    assert 'transitions is missing: give "separate"' in found.stderr
    assert invoke("fatigue").exit_code == 2
