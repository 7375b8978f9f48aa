"""The core that runs a machine, from model files and from the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.cli.group import app
from jousto.schema.read import parse_model

MODEL = """
bodies: [{name: rod, type: rigid, mass: 1 kg, inertia: [0.1, 0.1, 0.1], center: [0.5, 0, 0]}]
joints: [{type: revolute, name: pivot, a: ground.origin, b: rod.origin}]
simulation: {t_end: 10 ms, solver: {type: RK4, step: 1 ms}, core: CORE}
"""


@pytest.mark.parametrize(("core", "joint"), [("joint", True), ("maximal", False), ("auto", True)])
def test_a_model_file_says_what_runs_it(core: str, joint: bool) -> None:
    mechanism = parse_model(MODEL.replace("CORE", core)).mechanism
    assert mechanism.core == core
    assert bool(jo.compile(mechanism, core=None if core != "auto" else "joint").links) == joint


def test_a_core_that_there_is_not_is_told_with_all_there_are() -> None:
    with pytest.raises(jo.InputError, match="no core 'fast'; known: auto, joint, maximal"):
        parse_model(MODEL.replace("CORE", "fast"))


def test_the_command_line_decides_over_the_file(tmp_path: Path) -> None:
    model = tmp_path / "rod.yaml"
    model.write_text(MODEL.replace("CORE", "maximal"))

    def called(*args: str) -> str:
        result = CliRunner().invoke(app, [args[0], str(model), *args[1:]])
        assert result.exit_code == 0, result.output
        return result.output

    assert "joint coordinates (1 of a tree)" not in called("check")
    assert "joint coordinates (1 of a tree)" in called("check", "--core", "joint")
    for core, kept in (("joint", True), ("maximal", False)):
        called("run", "--core", core, "-q")
        state = jo.load(tmp_path / "rod.h5").state()
        assert bool(state.joint is not None and len(state.joint)) == kept
    result = CliRunner().invoke(app, ["check", str(model), "--core", "fast"])
    assert result.exit_code == 2
