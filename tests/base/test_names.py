"""Names from files: no paths, nothing that a terminal obeys."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest
from typer.testing import CliRunner

import jousto as jo
from cli.test_cli import MODEL
from jousto.cli.group import app
from jousto.cli.terminal import facts, say

ESCAPES = "\x1b[2J\x1b]0;title\x07\r\x9b1m\u202e"
WRONG = ["../../x", "..\\x", "a/b", "C:x", "..", "", " x", "x\x1b[2J", "a\nb"]


@pytest.mark.parametrize("name", WRONG)
@pytest.mark.parametrize("command", ["check", "run", "reduce", "advise"])
def test_names_of_parts_are_no_paths(command: str, name: str, tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    model = folder / "m.yaml"
    quoted = json.dumps(name)
    model.write_text(MODEL.replace("  rod:\n", f"  {quoted}:\n").replace("rod}", f"{quoted}}}"))
    result = CliRunner().invoke(app, [command, str(model)])
    assert result.exit_code == 2, result.output
    assert "name must not" in result.stderr or "is empty" in result.stderr
    assert "\x1b" not in result.output
    assert [p for p in tmp_path.rglob("*") if p.is_file()] == [model]


@pytest.mark.parametrize("name", WRONG[:-3])
def test_parts_of_python_have_such_names_too(name: str) -> None:
    steel = jo.Material(2.1e11, 0.3, 7850.0)
    with pytest.raises(jo.InputError, match="name must not"):
        jo.Part.beam(1.0, jo.Circle(0.02), 2, steel, name=name)


def test_a_reduced_part_of_a_file_names_no_other_folder(tmp_path: Path) -> None:
    steel = jo.Material(2.1e11, 0.3, 7850.0)
    part = jo.Part.beam(1.0, jo.Circle(0.02), 2, steel)
    reduced = jo.reduce(part, jo.CraigBampton(("start",), modes=2))
    folder = tmp_path / "a" / "b"
    folder.mkdir(parents=True)
    replace(reduced, name="../../x").save(folder / "part.h5")
    (folder / "m.yaml").write_text("parts: {p: {file: part.h5}}\n")
    CliRunner().invoke(app, ["reduce", str(folder / "m.yaml")])
    assert {p.parent for p in tmp_path.rglob("*") if p.is_file()} == {folder}


def test_terminals_are_not_told_what_to_do(capsys: pytest.CaptureFixture[str]) -> None:
    say(f"a{ESCAPES}b")
    say(f"a{ESCAPES}b", error=True, style="red")
    facts([(ESCAPES, ESCAPES)], ESCAPES)
    shown = capsys.readouterr()
    assert "a\\x1b[2J\\x1b]0;title\\x07\\r\\x9b1m\\u202eb\n" in shown.out
    assert not set(shown.out + shown.err) & set("\x1b\x07\r\x9b\u202e")


def test_names_of_files_and_sensors_are_spelled_out(tmp_path: Path) -> None:
    path = tmp_path / "bad\x1b[2J.yaml"
    path.write_text(MODEL.replace("name: middle", 'name: "mid\\e[2Jdle"'))
    result = CliRunner().invoke(app, ["check", str(path)])
    assert result.exit_code == 2
    assert "bad\\x1b[2J.yaml" in result.stderr and "\x1b" not in result.output
