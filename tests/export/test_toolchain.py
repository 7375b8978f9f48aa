"""Binaries of C files: what is compiled anew, and what a compiler's failure says."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import jousto as jo
from exported import CC
from jousto.export import objects, toolchain
from jousto.export.toolchain import build, platforms

pytestmark = pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler")

SOURCES = {
    "main.c": '#include "value.h"\nint other(void);\nint main(void) { return VALUE + other(); }\n',
    "part/other.c": "int other(void) { return 10; }\n",
    "value.h": '#include "deep.h"\n#define VALUE (DEEP + 1)\n',
    "deep.h": "#define DEEP 1\n",
}


Made = Callable[..., tuple[int, set[str]]]


@pytest.fixture
def made(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Made:
    """Return a function that builds, runs, and tells the result and what was compiled."""
    lines: list[list[str]] = []
    run = toolchain.run

    def counted(line: Any, *more: Any) -> None:
        lines.append(list(line))
        run(line, *more)

    monkeypatch.setattr(toolchain, "run", counted)
    monkeypatch.setattr(toolchain, "OBJECTS", {})
    monkeypatch.setenv("JOUSTO_CACHE", str(tmp_path / "cache"))

    def make(sources: dict[str, str], *flags: str) -> tuple[int, set[str]]:
        lines.clear()
        build(sources, platforms(["here"])[0], tmp_path / "program", flags=flags)
        compiled = {line[line.index("-c") + 1] for line in lines if "-c" in line}
        return subprocess.run([tmp_path / "program"], check=False).returncode, compiled

    return make


def test_only_what_changed_is_compiled_anew(made: Made) -> None:
    assert made(SOURCES) == (12, {"main.c", "part/other.c"})
    assert made(SOURCES) == (12, set())
    assert made({**SOURCES, "deep.h": "#define DEEP 5\n"}) == (16, {"main.c"})
    assert made({**SOURCES, "part/other.c": "int other(void) { return 20; }\n"})[1] == {
        "part/other.c"
    }
    assert made(SOURCES) == (12, set())
    assert made(SOURCES, "-DDEEPER") == (12, {"main.c", "part/other.c"})


BOTH = {"main.c", "part/other.c"}


def another_process() -> None:
    """Forget what this process compiled, as a new one would not know it."""
    toolchain.OBJECTS.clear()
    objects.identity.cache_clear()


def test_another_process_finds_the_objects(made: Made, tmp_path: Path) -> None:
    assert made(SOURCES) == (12, BOTH)
    another_process()
    assert made(SOURCES) == (12, set())
    another_process()
    assert made(SOURCES, "-DDEEPER") == (12, BOTH)
    names = [path.name for path in objects.folder().iterdir()]
    assert objects.folder() == tmp_path / "cache" / "objects" and len(names) == 4
    assert all(objects.OBJECT.fullmatch(name) for name in names)


def test_another_version_of_the_compiler_compiles_anew(
    made: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert made(SOURCES)[1] == BOTH
    another_process()
    monkeypatch.setattr(objects, "identity", lambda command: "cc 99.0")
    assert made(SOURCES) == (12, BOTH)
    monkeypatch.setenv("CPATH", "/elsewhere")
    toolchain.OBJECTS.clear()
    assert made(SOURCES) == (12, BOTH)


@pytest.mark.parametrize("damage", ["cut", "changed", "emptied", "folder"])
def test_damaged_objects_are_made_anew(made: Made, damage: str) -> None:
    assert made(SOURCES)[1] == BOTH
    for path in list(objects.folder().iterdir()):
        content = path.read_bytes()
        if damage == "folder":
            path.unlink()
            path.mkdir()
        else:
            wrong = {"cut": content[:-9], "changed": content[:-1] + b"?", "emptied": b""}
            path.write_bytes(wrong[damage])
    toolchain.OBJECTS.clear()
    assert made(SOURCES) == (12, BOTH)
    toolchain.OBJECTS.clear()
    assert made(SOURCES)[1] == (BOTH if damage == "folder" else set())


def test_a_cache_that_cannot_be_written_is_done_without(made: Made, tmp_path: Path) -> None:
    (tmp_path / "cache").write_text("a file where the folder would be")
    assert made(SOURCES) == (12, BOTH)
    toolchain.OBJECTS.clear()
    assert made(SOURCES) == (12, BOTH)


def test_objects_used_longest_ago_make_room(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    assert made(SOURCES)[1] == BOTH
    kept = sorted(objects.folder().iterdir())
    for path in kept:
        os.utime(path, (1.0, 1.0))
    # one byte less than all four need: one of the old ones goes
    monkeypatch.setattr(objects, "LIMIT", 2 * sum(path.stat().st_size for path in kept) - 1)
    assert made(SOURCES, "-DDEEPER")[1] == BOTH
    left = set(objects.folder().iterdir())
    assert len(left) == 3 and len(left & set(kept)) == 1


def test_processes_that_build_at_once_get_whole_objects(tmp_path: Path) -> None:
    code = f"""
from pathlib import Path
import sys
from jousto.export.toolchain import build, platforms
build({SOURCES!r}, platforms(["here"])[0], Path(sys.argv[1]))
"""
    env = {**os.environ, "JOUSTO_CACHE": str(tmp_path / "cache")}
    lines = [[sys.executable, "-c", code, str(tmp_path / f"program{k}")] for k in range(3)]
    running = [subprocess.Popen(line, env=env) for line in lines]
    assert [process.wait(300) for process in running] == [0, 0, 0]
    for k in range(3):
        assert subprocess.run([tmp_path / f"program{k}"], check=False).returncode == 12
    assert len(list((tmp_path / "cache" / "objects").iterdir())) == 2


def test_a_compiler_that_fails_says_why(tmp_path: Path) -> None:
    wrong = {**SOURCES, "part/other.c": "int other(void) { return ten; }\n"}
    with pytest.raises(jo.InputError, match=r"failed for [\w-]+: (.|\n)*other\.c:1.*ten"):
        build(wrong, platforms(["here"])[0], tmp_path / "program")
    with pytest.raises(jo.InputError, match=r"failed for (.|\n)*other"):
        build(
            {"main.c": SOURCES["main.c"].replace("VALUE", "1")} | {"value.h": ""},
            platforms(["here"])[0],
            tmp_path / "program",
        )
    assert not (tmp_path / "program").exists()
