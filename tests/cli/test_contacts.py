"""jousto contacts: from touch to part, and at an instant."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

import jousto as jo
from cli.test_meshes import call

MODEL = """
name: bounce
bodies:
  - {name: ball, mass: 0.1 kg, inertia: [1e-4, 1e-4, 1e-4], position: [0, 0, 0.3]}
forces:
  - type: contact
    name: touch
    a: ground.origin
    shape_a: {type: half-space}
    b: ball.origin
    shape_b: {type: sphere, radius: 50 mm}
    law: {type: power-law, stiffness: 1e6, restitution: 0.5}
gravity: [0, 0, -9.81]
simulation: {t_end: 0.5 s, output_step: 1 ms, solver: {type: RK4, step: 1 ms}}
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("contacts") / "bounce.yaml"
    path.write_text(MODEL)
    code, text = call("run", path, "-o", path.with_suffix(".h5"), "-q")
    assert code == 0, text
    return path


def test_contacts_of_a_run(model: Path, tmp_path: Path) -> None:
    run = jo.load(model.with_suffix(".h5"))
    for source in (model.with_suffix(".h5"), model):
        code, text = call("contacts", source, "-o", tmp_path / "c.csv")
        assert code == 0, text
        line = next(x for x in text.splitlines() if x.strip().startswith("touch: ground - ball"))
        assert f"{run.contacts[0].touch:.6g}" in line
        with (tmp_path / "c.csv").open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        assert [float(row["impulse (N s)"]) for row in rows] == [x.impulse for x in run.contacts]


def test_contacts_of_an_instant(model: Path, tmp_path: Path) -> None:
    run = jo.load(model.with_suffix(".h5"))
    touch = run.contacts[0].touch
    inside = next(t for t in run.time if t > touch)
    code, text = call("contacts", run.path, "--at", f"{inside} s", "-o", tmp_path / "p.csv")
    assert code == 0, text
    assert "no friction" in text
    with (tmp_path / "p.csv").open(encoding="utf-8", newline="") as file:
        (row,) = csv.DictReader(file)
    assert float(row["gap (m)"]) < 0 < float(row["force (N)"])
    code, text = call("contacts", run.path, "--at", "0 s")
    assert code == 0 and "nothing touches" in text
    code, text = call("contacts", run.path, "--at", "0 s", "--near")
    assert code == 0 and "apart" in text


def test_wrong_options(model: Path, tmp_path: Path) -> None:
    code, text = call("contacts", model, "--near")
    assert code == 2 and "give --at TIME" in text
    code, text = call("contacts", model.with_suffix(".h5"), "--model", model)
    assert code == 2 and "needed with --at only" in text
    code, text = call("contacts", model, "--model", model)
    assert code == 2 and "leave --model out" in text
    code, text = call("contacts", model, "-o", tmp_path / "c.txt")
    assert code == 2 and "csv" in text
    code, text = call("contacts", model.with_suffix(".h5"), "--at", "0.12345 s")
    assert code == 2 and "no instant is stored" in text
