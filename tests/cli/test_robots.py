"""Robots where model files stand."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from jousto.cli.group import app
from jousto.scene.make import make_scene
from jousto.viewer.things import read
from robots.machines import SCARA, SCARA_SDF

runner = CliRunner()


@pytest.mark.parametrize(("name", "text"), [("a.urdf", SCARA), ("a.sdf", SCARA_SDF)])
def test_a_robot_is_checked_and_runs(
    name: str, text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).write_text(text, encoding="utf-8")
    found = runner.invoke(app, ["check", name])
    assert found.exit_code == 0, found.output
    assert "leave 4 free motions" in found.output and f"{name}: ok" in found.output
    assert re.search(
        r"stop \w+ stop +\w+\.\w+, lower -[\d.]+ rad, upper [\d.]+ rad, ", found.output
    )
    found = runner.invoke(app, ["run", name, "--t-end", "0.01", "-q"])
    assert found.exit_code == 0 and Path("a.h5").is_file(), found.output
    found = runner.invoke(app, ["export", name, "-o", "a.c"])
    assert found.exit_code == 0 and Path("a.h").is_file(), found.output
    scene = make_scene(read(Path(name)).mechanism)
    assert len(scene.bodies) > 3


def test_all_that_is_wrong_is_said_at_once(tmp_path: Path) -> None:
    path = tmp_path / "bad.urdf"
    path.write_text(
        SCARA.replace('mass value="6"', 'mass value="-6"').replace("fore", "for", 1),
        encoding="utf-8",
    )
    found = runner.invoke(app, ["check", str(path)])
    assert found.exit_code == 2
    assert "mass is -6 kg, must not be negative" in found.output
    assert found.output.count("no link 'fore'; did you mean 'for'?") == 2
