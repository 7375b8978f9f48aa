"""Robots where model files stand."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app
from jousto.scene.make import make_scene
from jousto.schema.summary import given
from jousto.viewer.viewable import read
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


ARM = """<mujoco><worldbody><body name="arm">
  <joint name="pivot" type="hinge" axis="0 1 0" frictionloss="0.5"/>
  <geom type="capsule" fromto="0 0 0 1 0 0" size="0.02" density="1000"/>
</body></worldbody></mujoco>"""


def test_dry_friction_of_a_joint_is_listed_and_its_loss_counted(tmp_path: Path) -> None:
    model = tmp_path / "arm.xml"
    model.write_text(ARM)
    found = runner.invoke(app, ["check", str(model)])
    assert found.exit_code == 0, found.output
    assert "dry friction 0.5 N m, full from 0.01 rad/s" in found.output
    run = jo.simulate(jo.compile(jo.robots.mechanism(jo.robots.read_robot(model))), 1.0)
    path = np.abs(np.diff(run["pivot"][:, 0])).sum()
    assert path > 1.0
    # less than 0.5 N m only below 0.01 rad/s, which is less than 0.01 rad of the path
    assert 0.5 * (path - 0.01) <= run.energy.dissipated[-1] <= 0.5 * path * (1.0 + 1e-6)


def test_tables_of_springs_are_listed() -> None:
    body = jo.RigidBody("b", mass=1.0, inertia=(1, 1, 1))
    slide = jo.Prismatic("slide", jo.ground["origin"], body["origin"], axis=(1, 0, 0))
    table = jo.Table((-0.1, 0.0, 0.2), (-5.0, 0.0, 40.0))
    bump = jo.Spring("bump", slide.coordinates[0], table=table)
    assert "of 3 points, -5 to 40 N at -0.1 to 0.2 m" in given(bump)
