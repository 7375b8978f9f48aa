"""jousto run and info tell which events happened and which one stopped the run."""

from __future__ import annotations

from typer.testing import CliRunner

from jousto.cli.group import app
from schema.test_events import TEXT


def jousto(*args: object) -> str:
    result = CliRunner().invoke(app, [str(arg) for arg in args])
    assert result.exit_code == 0, result.output
    return result.stdout


def test_run_prints_the_events_and_the_end(tmp_path):
    model = tmp_path / "crane.yaml"
    model.write_text(TEXT, encoding="utf-8")
    printed = jousto("run", model)
    assert "event end: " not in printed
    assert "stopped by event 'end' at " in printed
    assert "1.02332671 s" in printed  # root of pi / 3
    assert "limit switch rising" in printed
    told = jousto("info", tmp_path / "crane.h5")
    assert "limit switch rising" in told
    checked = jousto("check", model)
    assert "event end" in checked
    assert "slewing.angle passes 6.28319, stops the run" in checked


def test_many_events_are_counted(tmp_path):
    model = tmp_path / "wave.yaml"
    text = TEXT.replace("watch: tip, component: y, threshold: 5 m/s", "watch: wave")
    wave = "  - {name: wave, type: signal, signal: {type: harmonic, frequency: 5}}\n"
    model.write_text(text.replace("events:\n", wave + "events:\n"), encoding="utf-8")
    printed = jousto("run", model)
    assert "fast falling" in printed
    assert "more in the results" in printed
