"""jousto export --twin: the twin of a model file's block monitor."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"


def export(*words: str) -> int:
    from jousto.cli.group import app

    with pytest.raises(SystemExit) as end:
        app(["export", *words])
    return int(end.value.code or 0)


def test_the_twin_of_a_model_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copy(EXAMPLES / "monitor.yaml", tmp_path)
    path = tmp_path / "monitor.yaml"
    assert export(str(path), "--twin", "-o", str(tmp_path / "boom.c")) == 0
    text = (tmp_path / "boom.h").read_text()
    assert "extern const jo_plan boom_plan;" in text and ".damage (1): sum of Miner" in text
    assert export(str(path), "--twin", "-o", str(tmp_path / "boom.fmu")) == 2
    assert "--twin: converts a model file to .c or .zip" in capsys.readouterr().err


def test_a_model_without_a_monitor(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = EXAMPLES / "slider_crank.yaml"
    assert export(str(path), "--twin", "-o", str(tmp_path / "a.c")) == 2
    assert "has no block monitor" in capsys.readouterr().err
