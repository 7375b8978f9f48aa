"""`jousto reduce` on matrix files: what it prints, and one sentence for each damaged file."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import CliRunner

from jousto.cli.group import app

FILES = Path(__file__).parent.parent / "parts" / "files"
PART = """type: matrices
K: brick.sti
node_sets: {right: [30, 60, 90, 120]}
reduce: {type: craig-bampton, interfaces: [LEFT, right], modes: 1}
"""


def folder(tmp_path: Path, text: str = PART) -> Path:
    for suffix in (".sti", ".mas", ".dof", ".inp"):
        shutil.copy(FILES / f"brick{suffix}", tmp_path)
    path = tmp_path / "brick.yaml"
    path.write_text(text)
    return path


def test_reduce_prints_and_keeps_the_part(tmp_path: Path) -> None:
    path = folder(tmp_path)
    done = CliRunner().invoke(app, ["reduce", str(path), "-o", str(tmp_path / "brick.h5")])
    assert done.exit_code == 0, done.output
    assert "78.5 kg" in done.output and "LEFT, right" in done.output
    assert (tmp_path / "brick.h5").is_file()


def cut(path: Path) -> None:
    text = path.read_text()
    path.write_text(text[: len(text) // 2])


DAMAGE: dict[str, tuple[Callable[[Path], object], str]] = {
    "missing": (lambda p: (p / "brick.sti").unlink(), "no such file"),
    "mass missing": (lambda p: (p / "brick.mas").unlink(), "no such file"),
    "cut": (lambda p: cut(p / "brick.mas"), "brick.mas: ends with"),
    "empty": (lambda p: (p / "brick.dof").write_text(""), "brick.dof: is empty"),
    "another kind": (
        lambda p: shutil.copy(p / "brick.inp", p / "brick.sti"),
        "brick.sti: line 1 is '*NODE,NSET=ALL', i j value is expected",
    ),
    "mesh of other nodes": (
        lambda p: (p / "brick.inp").write_text(
            (p / "brick.inp").read_text().replace("120,", "121,").replace(",120", ",121")
        ),
        "rows of node 120 without a position",
    ),
}


@pytest.mark.parametrize("name", DAMAGE)
def test_damaged_files_end_in_a_sentence(tmp_path: Path, name: str) -> None:
    path = folder(tmp_path, PART.replace("30, 60, 90, 120", "30, 60"))
    damage, sentence = DAMAGE[name]
    damage(tmp_path)
    done = CliRunner().invoke(app, ["reduce", str(path)])
    assert done.exit_code == 2
    text = " ".join(done.output.split())
    assert sentence in text and "Traceback" not in text
    assert text.count("brick.yaml:") == 1
