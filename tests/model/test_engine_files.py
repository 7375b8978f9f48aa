"""The files of the engine: who calls whom, how long a function is, where a kind of force is."""

from __future__ import annotations

import re
from collections import Counter
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

from jousto.model.native import declarations
from model.engine_fields import COMPILER, Access, accesses

ENGINE = Path(declarations.__file__).parents[4] / "engine"
pytestmark = pytest.mark.skipif(not ENGINE.exists(), reason="an installed package")

# functions and constants start at the left edge, and a function ends there unless it is one line
FUNCTION = re.compile(
    r"^(static (?:JO_INLINE )?)?[a-z][\w *]*?(\w+)\([^;{}]*\)\s*\{(?:[^\n]*\}$|.*?^\}$)",
    re.MULTILINE | re.DOTALL,
)
CONSTANT = re.compile(r"^const \w+ (\w+) =", re.MULTILINE)
PROTOTYPE = re.compile(r"^(?:extern [^;{}]*|[a-z][\w *]*\w\([^;{}]*\));", re.MULTILINE)
KIND = re.compile(r"^const jo_force_kind (\w+) =", re.MULTILINE)
RECURSIVE = ["jo_signal_at"]  # the operands of a signal are signals


def room_files() -> list[Path]:
    """The files of the engine itself: those of its rooms and those that all rooms share."""
    return sorted(
        path
        for path in (*ENGINE.glob("*.[ch]"), *ENGINE.glob("*/*.[ch]"))
        if path.parent.name not in ("export", "lanes", "test")
    )


def sources() -> dict[str, str]:
    """The text of each file, without comments, strings and prototypes."""
    texts = {}
    for path in room_files():
        text = re.sub(r"/\*.*?\*/", _blank, path.read_text("utf-8"), flags=re.DOTALL)
        texts[path.name] = re.sub(r'"(?:\\.|[^"\\\n])*"', '""', text)
    return texts


def _blank(comment: re.Match[str]) -> str:
    return "\n" * comment[0].count("\n")


def calls() -> dict[str, set[str]]:
    """Of each file those that define what it uses: functions, and rows of the table of forces."""
    texts = {name: PROTOTYPE.sub("", text) for name, text in sources().items()}
    defined = [(found, name) for name, text in texts.items() for found in _names(text)]
    twice = [name for name, count in Counter(found for found, _ in defined).items() if count > 1]
    assert not twice, f"defined in two files: {twice}"
    home = dict(defined)
    used = {name: set(re.findall(r"\w+", text)) for name, text in texts.items()}
    used["force_table.c"] |= {f"jo_force_{name}" for name in forces(texts)}  # the macro makes them
    return {name: {home[w] for w in words & home.keys()} - {name} for name, words in used.items()}


def forces(texts: dict[str, str]) -> list[str]:
    """The names of the rows of the table of forces."""
    rows = texts["jousto.h"].partition("#define JO_FORCES(ROW)")[2].partition("\n\n")[0]
    return re.findall(r"ROW\((\w+),", rows)


def _names(text: str) -> list[str]:
    return [m[2] for m in FUNCTION.finditer(text) if not m[1]] + CONSTANT.findall(text)


def functions() -> dict[tuple[str, str], str]:
    """Each function by its file and name."""
    return {(file, m[2]): m[0] for file, text in sources().items() for m in FUNCTION.finditer(text)}


def test_no_file_calls_one_that_calls_it():
    """Not through others either, so that any file can be read after those it uses.

    A step that ends at an event is repeated by jo_event_step (events.c), which calls jo_one_step
    (method_table.c); what calls jo_event_step is above both: run.c and step_control.c.
    """
    graph = calls()
    assert {"state.c", "events.c", "step_dormand_prince.c"} <= graph["step_control.c"]
    assert "force_along.c" in graph["force_table.c"]
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"a circle: {' <- '.join(error.args[1])}")


def test_no_two_files_have_one_name():
    """Exported programs have all files in one folder."""
    names = Counter(path.name for path in room_files())
    assert not [name for name, count in names.items() if count > 1]


def test_each_header_offers_what_the_files_of_its_room_define():
    """Section by section, in the order of the calls within the room."""
    texts, graph = sources(), calls()
    home = {path.name: path.parent.name for path in room_files()}
    for room in {path.parent for path in room_files()} - {ENGINE}:
        header = (room / f"{room.name}.h").read_text("utf-8")
        sections = re.split(r"^/\* (\w+\.c) \*/$", header, flags=re.MULTILINE)[1:]
        order = sections[::2]
        for file, section in zip(order, sections[1::2], strict=True):
            names = set(re.findall(r"\b(jo_\w+)\([^;{}]*\);", section))
            assert names
            assert home[file] == room.name and names <= set(_names(texts[file])), file
        for i, file in enumerate(order):
            assert not graph[file] & set(order[i + 1 :]), f"{file} calls what follows it"


def test_files_include_the_headers_of_the_rooms_that_they_call():
    home = {path.name: path.parent for path in room_files()}
    for file, called in calls().items():
        text = (home[file] / file).read_text("utf-8")
        rooms = {home[other].name for other in called if home[other] not in (home[file], ENGINE)}
        found = set(re.findall(r'#include "(\w+)/', text))
        assert not file.endswith(".c") or rooms <= found, f"{file} calls {rooms - found}"


@pytest.fixture(scope="module")
def fields(tmp_path_factory: pytest.TempPathFactory) -> set[Access]:
    if COMPILER is None:
        pytest.skip("no C compiler")
    return accesses(ENGINE, room_files(), tmp_path_factory.mktemp("empty"))


def test_what_is_valid_is_asked_and_changed_by_functions(fields: set[Access]):
    """Bits of validity, and which solver carries what, are fields of valid.h and split.c alone."""
    own = {access for access in fields if access.owner == "valid_data.h"}
    assert len({access.field for access in own}) > 15
    assert not {access for access in own if access.file not in ("valid.h", "split.c")}


def test_what_a_room_keeps_is_used_in_this_room_alone(fields: set[Access]):
    """Other rooms use the functions and structs of its header, and what the shared headers declare.

    Nor does another room reach a member of a shared struct whose own fields a room keeps, such as
    `d->newton` or `body->maximal`.
    """

    def keeper(file: str) -> str:
        """The room that keeps what a file declares; "" for headers that others may use."""
        room, _, name = file.rpartition("/")
        return "" if name == f"{room}.h" else room

    kept = [(room, a) for a in fields for room in {keeper(a.owner), keeper(a.content)} - {""}]
    assert {room for room, _ in kept} == {path.parent.name for path in room_files()} - {ENGINE.name}
    found = [a for room, a in kept if a.file.rpartition("/")[0] != room]
    assert not sorted(found)


def test_results_of_an_evaluation_serve_several_rooms(fields: set[Access]):
    """Of evaluation.h: what one room alone uses belongs into a header of this room."""
    rooms: dict[tuple[str, str], set[str]] = {}
    for a in fields:
        if a.owner == "evaluation.h" and a.field != "maximal":
            rooms.setdefault((a.struct, a.field), set()).add(a.file.rpartition("/")[0])
    assert len(rooms) > 30
    alone = {field for (_, field), used in rooms.items() if len(used) < 2}
    assert alone == {"bias", "stored"}  # parts of an acceleration and of a force that others read


def test_files_include_headers_of_other_rooms_that_have_the_name_of_the_room():
    found = {}
    for path in room_files():
        room = path.parent.name if path.parent != ENGINE else ""
        headers = re.findall(r'#include "(\w+)/(\w+)\.h"', path.read_text("utf-8"))
        found[path.name] = [name for other, name in headers if name != other != room]
    shared = {
        name: found.pop(name) for name in ("data.h", "evaluation.h")
    }  # members of the structs
    assert all(name.endswith("_data") for names in shared.values() for name in names)
    assert not {name: names for name, names in found.items() if names}


# in headers: functions, macros, enumerators and types
NAME = re.compile(
    r"\b(jo_\w+)\([^;{}]*\)\s*\{|#define (\w+)|\b(JO_\w+) ="
    r"|\}\s*(jo_\w+);|typedef struct \w+ (jo_\w+);"
)


def test_names_of_other_headers_are_used_in_their_room_alone():
    """data.h and evaluation.h name the types of their members."""
    text_of = sources()
    texts = {path: text_of[path.name] for path in room_files()}
    found, count = set(), 0
    for header, text in texts.items():
        if header.suffix != ".h" or header.parent == ENGINE or header.stem == header.parent.name:
            continue
        names = {word for match in NAME.findall(text) for word in match if word}
        names -= {f"JO_{header.stem.upper()}_H"}
        count += len(names)
        for path, other in texts.items():
            if path.parent != header.parent and path.name not in ("data.h", "evaluation.h"):
                found |= {(path.name, word) for word in names & set(re.findall(r"\w+", other))}
    assert count > 50
    assert not found


def test_only_what_is_recursive_calls_itself():
    texts = functions()
    home = {name: file for file, name in texts}
    graph = {}
    for (file, name), text in texts.items():
        called = set(re.findall(r"(\w+)\(", text.partition("{")[2]))
        here = {(file, other) for other in called if (file, other) in texts}
        graph[file, name] = here | {(home[w], w) for w in called & home.keys() if w[:3] == "jo_"}
    assert [key[1] for key, called in graph.items() if key in called] == RECURSIVE
    TopologicalSorter({key: called - {key} for key, called in graph.items()}).prepare()


def test_functions_are_below_60_lines():
    long = {key: text.count("\n") + 1 for key, text in functions().items()}
    assert len(long) > 500
    assert not {key: lines for key, lines in long.items() if lines >= 60}


def test_each_kind_of_force_has_a_file_and_a_row():
    texts = sources()
    files = {name: found for name, text in texts.items() if (found := KIND.findall(text))}
    assert sorted(files) == sorted(f"force_{name}.c" for name in forces(texts))
    assert all(found == [f"jo_{name[:-2]}"] for name, found in files.items())
    assert "table[] = {JO_FORCES(" in texts["force_table.c"]


# keywords of C++ that are names in C; bool is a type of the interface of FMI 3.0
CPP = (
    "class delete explicit export friend mutable namespace new operator private protected public "
    "template this throw try typename using virtual"
)


def test_no_name_is_a_keyword_of_cpp():
    """The benchmarks compile the engine as C++, with a scalar that counts operations."""
    words = re.compile(rf"\b({'|'.join(CPP.split())})\b")
    apart = re.compile(r'/\*.*?\*/|//[^\n]*|"(?:\\.|[^"\\])*"|^\s*#[^\n]*', re.S | re.M)
    found = {
        path.name: sorted(set(words.findall(apart.sub(" ", path.read_text()))))
        for path in ENGINE.rglob("*.[ch]")
    }
    assert not {name: names for name, names in found.items() if names}
