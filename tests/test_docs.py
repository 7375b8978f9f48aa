"""The code in the documentation runs and prints what is printed there.

Blocks are executed page by page in their order, in an empty folder:

* ``python``: warnings of jousto and the error that ends a block are part of its output; a ``text``
  block that follows at once is that output.
* ``yaml`` with a first line ``# NAME.yaml``: written to that file and checked by ``jousto check``;
  ``# NAME.yml`` is a part alone, which ``jousto reduce`` must accept.
* ``console``: lines after ``$ jousto ...`` are its output, ``$ echo $?`` asks for its exit code.
  Each command runs in a process of its own, as a user starts it.

In outputs ``...`` stands for anything. The page `OWN` adds a force to the engine: it runs in a
copy of the sources, see test_own_element.py.
"""

from __future__ import annotations

import atexit
import contextlib
import doctest
import importlib.util
import io
import json
import re
import shlex
import subprocess
import sys
import tempfile
import traceback
import warnings
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import ModuleType

import pytest
from typer.testing import CliRunner

import jousto as jo
from jousto.base.declare import SECTIONS, kinds
from jousto.base.lazy_exports import public_names
from jousto.cli.group import app

ROOT = Path(__file__).parent.parent
PAGES = ["README.md", *(f"docs/{path.name}" for path in sorted((ROOT / "docs").glob("*.md")))]
OWN = "docs/own-element.md"
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.M | re.S)
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def blocks(page: str) -> Iterator[tuple[str, str, int, bool]]:
    """Yield language, text, line and whether the block follows the one before at once."""
    text = (ROOT / page).read_text(encoding="utf-8")
    end = 0
    for match in BLOCK.finditer(text):
        line = text.count("\n", 0, match.start()) + 1
        yield match[1], match[2], line, end > 0 and not text[end : match.start()].strip()
        end = match.end()


def same(expected: str, found: str, where: str) -> None:
    checker = doctest.OutputChecker()
    if not checker.check_output(expected.rstrip() + "\n", found.rstrip() + "\n", FLAGS):
        pytest.fail(f"{where} prints\n{found}\nbut the page says\n{expected}")


def run_python(code: str, where: str, names: dict[str, object]) -> tuple[str, bool]:
    """Return what a block prints, and whether that includes a warning or an error."""
    out, noted = io.StringIO(), False
    with warnings.catch_warnings(record=True) as caught, contextlib.redirect_stdout(out):
        warnings.simplefilter("always")
        try:
            exec(compile(code, where, "exec"), names)
        except jo.JoustoError as error:
            # first the warnings, then what ended the block
            ended = f"{type(error).__name__}: {error}\n"
        except Exception:
            pytest.fail(f"{where}\n{traceback.format_exc()}")
        else:
            ended = ""
        for item in caught:
            assert issubclass(item.category, jo.JoustoWarning), f"{where}: {item.message}"
            out.write(f"JoustoWarning: {item.message}\n")
            noted = True
        out.write(ended)
    return out.getvalue(), noted or bool(ended)


def commands(page: str) -> Iterator[str]:
    """Yield the name of each command that a page runs."""
    for language, text, *_ in blocks(page):
        if language == "console":
            for line in re.findall(r"^\$ jousto (.*)$", text, re.M):
                words = shlex.split(line)
                yield words[2 if words[0] == "--with" else 0]


@cache
def starter() -> subprocess.Popen[str]:
    """Start the process that starts commands."""
    line = [sys.executable, str(ROOT / "tests/starter.py")]
    started = subprocess.Popen(line, text=True, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
    atexit.register(started.communicate)
    return started


def run_command(words: list[str], folder: Path | None = None, **settings: str) -> tuple[int, str]:
    """Return exit code and output of a command in a process of its own, with more variables."""
    with tempfile.TemporaryDirectory(prefix="jousto-command-") as place:
        asked = json.dumps([str(folder or Path.cwd()), f"{place}/out", words, settings])
        print(asked, file=starter().stdin, flush=True)
        code = int(starter().stdout.readline())
        return code, Path(place, "out").read_text(encoding="utf-8")


def run_console(text: str, where: str) -> None:
    """Run the commands of a console block and compare their output."""
    code, prompt = 0, re.compile(r"^\$ (.*)\n((?:(?!\$ ).*\n)*)", re.M)
    asked = True
    for command, expected in prompt.findall(text):
        words = shlex.split(command)
        if words == ["echo", "$?"]:
            asked = True
            assert str(code) == expected.strip(), f"{where}: exit code {code}"
        elif words[0] == "jousto":
            assert asked or code == 0, f"{where}: exit code {code}, not shown"
            code, output = run_command(words[1:])
            asked = False
            if expected.strip():
                same(expected, output, f"{where}: {command}")
            else:
                assert code == 0, f"{where}: {command}\n{output}"
    assert asked or code == 0, f"{where}: exit code {code}, not shown"


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("page", [page for page in PAGES if page != OWN])
def test_code_of_the_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    before = {name: set(section) for name, section in SECTIONS.items()}
    try:
        run_page(page)
    finally:  # what the page declares goes with it
        for name, section in SECTIONS.items():
            for word in set(section) - before.get(name, set()):
                if not section[word].__module__.startswith("jousto."):
                    del section[word]


def run_page(page: str) -> None:
    """Run all blocks of a page in this folder."""
    names: dict[str, object] = {"__name__": "page"}
    printed, noted, where = None, False, page
    for language, text, line, follows in blocks(page):
        if noted and not (language == "text" and follows):
            pytest.fail(f"{where}: not shown on the page:\n{printed}")
        if language == "text" and follows and printed is not None:
            same(text, printed, where)
        printed, noted, where = None, False, f"{page}:{line}"
        if language == "python":
            printed, noted = run_python(text, where, names)
        elif language == "yaml" and (name := re.match(r"# (\S+\.ya?ml)\n", text)):
            Path(name[1]).write_text(text, encoding="utf-8")
            command = "check" if name[1].endswith(".yaml") else "reduce"
            result = CliRunner().invoke(app, [command, name[1]], prog_name="jousto")
            # a file with errors is followed by the console block that shows them
            right = 2 if name[1].startswith("bad") else 0
            assert result.exit_code == right, f"{where}: {result.output}"
        elif language == "console":
            run_console(text, where)
    assert not noted, f"{where}: not shown on the page:\n{printed}"


@pytest.mark.parametrize("page", PAGES)
def test_links_and_pictures_of_the_page_exist(page: str) -> None:
    folder = (ROOT / page).parent
    assert [target for target in targets(page) if not folder.joinpath(target).exists()] == []


def targets(page: str) -> list[str]:
    """Files that a page links to or shows."""
    text = (ROOT / page).read_text(encoding="utf-8")
    found = re.findall(r"\]\(([^)#\s]+)(?:#[^)]*)?\)", text)
    return [target for target in found if not re.match(r"[a-z]+:", target)]


def test_links_and_commands_are_seen() -> None:
    assert sum(len(targets(page)) for page in PAGES) > len(PAGES)
    kinds = {language for page in PAGES for language, *_ in blocks(page)}
    assert {"python", "console", "yaml", "text"} <= kinds
    with pytest.raises(AssertionError, match="here: jousto info missing.h5"):
        run_console("$ jousto info missing.h5\n\n", "here")
    with pytest.raises(AssertionError, match="exit code 2, not shown"):
        run_console("$ jousto info missing.h5\n...\n$ jousto --help\n...\n", "here")
    with pytest.raises(AssertionError, match="exit code 0"):
        run_console("$ jousto --help\n...\n$ echo $?\n1\n", "here")


def test_these_tests_see_a_wrong_output() -> None:
    with pytest.raises(pytest.fail.Exception, match="but the page says"):
        same("1.0\n", "2.0\n", "here")
    same("a ... c\n", "a b c\n", "here")
    assert run_python("print(1)", "here", {}) == ("1\n", False)
    assert run_python("import jousto as jo; jo.Material(1e5, 0.3, 7850)", "here", {})[1]


@pytest.fixture(scope="module")
def tables() -> ModuleType:
    spec = importlib.util.spec_from_file_location("tables", ROOT / "tools/tables.py")
    tool = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(tool)
    return tool


def test_pages_contain_the_tables_that_the_declarations_give(tables: ModuleType) -> None:
    pages = {path: path.read_text(encoding="utf-8") for path in (ROOT / "docs").rglob("*.md")}
    wrong = [
        str(path.relative_to(ROOT)) for path, text in pages.items() if tables.filled(text) != text
    ]
    assert not wrong, "run make tables"
    # what Sphinx alone would fill in is a bare word to who reads the page as it lies in the folder
    assert not [
        path for path, text in pages.items() if re.search("^(KINDS|KEYS|PUBLIC) ", text, re.M)
    ]


def test_a_table_that_is_not_what_the_declarations_give_is_seen(tables: ModuleType) -> None:
    page = (ROOT / "docs/model-joints.md").read_text(encoding="utf-8")
    assert "| `pitch` |" not in (spoilt := re.sub(r"^\| `pitch` \|.*\n", "", page, flags=re.M))
    assert tables.filled(spoilt) == page
    assert tables.filled(page.replace("| `screw` |", "| `thread` |")) == page


def test_tables_of_pages_have_every_declared_kind(tables: ModuleType) -> None:
    pages = sorted((ROOT / "docs").glob("model-*.md"))
    page = "".join(path.read_text(encoding="utf-8") for path in pages)
    asked = re.findall(r"^<!-- tools/tables.py kinds (\S+) (\S+) -->$", page, re.M)
    assert len(asked) == 10
    for section, room in asked:
        rows = list(tables.table(section, room))
        for word, cls in kinds(section, room).items():
            if not f"{cls.__module__}.".startswith(f"{room}."):
                continue  # of another room, which has its page, or of another test
            (row,) = [row for row in rows[: rows.index("")] if row.startswith(f"| `{word}` |")]
            assert row in page
            shown = [key for key, field in cls.fields.items() if field.file and f"`{key}`" in row]
            assert {*shown} | {"name", "a", "b", "as_placed"} >= {
                key for key, field in cls.fields.items() if field.file
            }
    assert (
        "| `gear` | Gear pair with a constant ratio of two angles: `b - b0 = ratio (a - a0)`."
        in page
    )
    assert "| `cylindrical` | " in page and "| *`axis`* | `angle`, `displacement` |" in page
    assert (
        "| `pitch` | `screw` | Displacement in one turn; negative for a left-hand thread, m |"
        in page
    )


def test_every_public_name_has_its_help_on_one_page() -> None:
    pages = [path.read_text(encoding="utf-8") for path in (ROOT / "docs/api").glob("*.md")]
    counts = {name: sum(f"``{name}``\n" in page for page in pages) for name in public_names()}
    assert not {name: count for name, count in counts.items() if count != 1}
