"""Binaries of C files: what is compiled anew, and what a compiler's failure says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import jousto as jo
from exported import CC
from jousto.export import toolchain
from jousto.export.toolchain import build, platforms

pytestmark = pytest.mark.skipif(CC is None or sys.platform == "win32", reason="no C compiler")

SOURCES = {
    "main.c": '#include "value.h"\nint other(void);\nint main(void) { return VALUE + other(); }\n',
    "part/other.c": "int other(void) { return 10; }\n",
    "value.h": '#include "deep.h"\n#define VALUE (DEEP + 1)\n',
    "deep.h": "#define DEEP 1\n",
}


def test_only_what_changed_is_compiled_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lines: list[list[str]] = []
    run = toolchain.run

    def counted(line: Any, *more: Any) -> None:
        lines.append(list(line))
        run(line, *more)

    monkeypatch.setattr(toolchain, "run", counted)
    monkeypatch.setattr(toolchain, "OBJECTS", {})

    def made(sources: dict[str, str], *flags: str) -> tuple[int, set[str]]:
        lines.clear()
        build(sources, platforms(["here"])[0], tmp_path / "program", flags=flags)
        compiled = {line[line.index("-c") + 1] for line in lines if "-c" in line}
        return subprocess.run([tmp_path / "program"], check=False).returncode, compiled

    assert made(SOURCES) == (12, {"main.c", "part/other.c"})
    assert made(SOURCES) == (12, set())
    assert made({**SOURCES, "deep.h": "#define DEEP 5\n"}) == (16, {"main.c"})
    assert made({**SOURCES, "part/other.c": "int other(void) { return 20; }\n"})[1] == {
        "part/other.c"
    }
    assert made(SOURCES) == (12, set())
    assert made(SOURCES, "-DDEEPER") == (12, {"main.c", "part/other.c"})


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
