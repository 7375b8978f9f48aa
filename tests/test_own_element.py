"""The page on own elements: its diff applies to these sources, which are compiled and run it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import test_docs

ROOT = Path(__file__).parent.parent
pytestmark = pytest.mark.skipif(not shutil.which("cmake"), reason="needs CMake")


def apply(diff: str, root: Path) -> None:
    """Apply a diff of new files and of lines between others, as git shows it."""
    head, *pieces = diff.splitlines()
    target = root / head.removeprefix("+++ b/")
    assert head.startswith("+++ b/") and pieces[0].startswith("@@")
    old = "".join(f"{line[1:]}\n" for line in pieces[1:] if line[:1] != "+")
    new = "".join(f"{line[1:]}\n" for line in pieces[1:] if line[:1] != "-")
    text = target.read_text(encoding="utf-8") if target.exists() else ""
    assert text.count(old) == 1 if old else not text, f"{target.name} is not as the page shows it"
    target.write_text(text.replace(old, new) if old else new, encoding="utf-8")


def built(diffs: list[str], root: Path) -> None:
    """Copy the sources, apply diffs and build the engine in place, the portable and complex one."""
    # with the bytecode, which fits files of the same times
    ignored = shutil.ignore_patterns("lib", "*.html")
    shutil.copytree(ROOT / "src", root / "src", ignore=ignored)
    shutil.copytree(ROOT / "engine", root / "engine")
    shutil.copy(ROOT / "CMakeLists.txt", root)
    for diff in diffs:
        apply(diff, root)
    # compiled without optimisation, which takes a few seconds
    options = ["-DJOUSTO_INPLACE=ON", "-DCMAKE_BUILD_TYPE=None"]
    options.append(f"-DPython_EXECUTABLE={sys.executable}")
    cmake = ["cmake", "-S", str(root), "-B", str(root / "build"), *options]
    subprocess.run(cmake, check=True, capture_output=True)
    targets = ["jousto_engine", "jousto_engine_complex", "jousto_declared"]
    cmake = ["cmake", "--build", str(root / "build"), "-j2", "--target", *targets]
    subprocess.run(cmake, check=True, capture_output=True)


def test_the_page_adds_a_force_to_the_engine(tmp_path: Path) -> None:
    found = list(test_docs.blocks(test_docs.OWN))
    diffs = [text for language, text, *_ in found if language == "diff"]
    built(diffs, tmp_path)
    # only the copy: an editable install would serve the sources beside this file
    paths = [str(tmp_path / "src"), str(ROOT / "tests"), *sys.path]
    settings = {**os.environ, "PYTHONPATH": os.pathsep.join(paths), "JOUSTO_CPU": "baseline"}
    code = (
        f"import test_docs, jousto; test_docs.run_page({test_docs.OWN!r}); print(jousto.__file__)"
    )
    python = [sys.executable, "-S", "-c", code]
    run = subprocess.run(python, cwd=tmp_path, env=settings, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    assert Path(run.stdout.splitlines()[-1]).is_relative_to(tmp_path)
    # one file of Python, one of C and one row
    assert [diff.splitlines()[0] for diff in diffs] == [
        "+++ b/engine/jousto.h",
        "+++ b/engine/force/force_cubic.c",
        "+++ b/src/jousto/mechanism/forces/cubic.py",
    ]
    added = [line for line in diffs[0].splitlines()[1:] if line.startswith("+")]
    assert len(added) == 1 and "ROW(cubic" in added[0]
