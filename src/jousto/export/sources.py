"""Sources of the engine, for programs that run without Python."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from jousto.base.errors import InputError, Problem
from jousto.model.native import library

# files for results and for waiting, which no step calls
LEFT_OUT = (
    *("body_loads.c", "channel_health.c", "real_time_pace.c"),
    *("critical_planes.c", "stress_recovery.c"),
)
HOST = "export"  # folder of the files that surround an exported machine
NO_ROOMS = (HOST, "lanes", "test")  # folders that are not part of the engine itself


@cache
def folder() -> Path:
    """Return the folder of the engine's sources.

    Raises
    ------
    InputError
        If the installation does not contain the sources.
    """
    here = Path(library.__file__).parent
    for place in (here.parents[3] / "engine", here / "engine"):
        if (place / "jousto.h").exists():
            return place
    raise InputError(
        Problem("sources of the engine", "are missing in the installation; install jousto again")
    )


def headers() -> dict[str, str]:
    """Return the headers of the engine by name, for one folder."""
    rooms = [path for path in folder().glob("*/*.h") if path.parent.name not in (HOST, "test")]
    return {path.name: without_folders(path) for path in (*folder().glob("*.h"), *rooms)}


def engine() -> dict[str, str]:
    """Return the engine files of a step by name, for one folder, in order."""
    rooms = [path for path in folder().glob("*/*.c") if path.parent.name not in NO_ROOMS]
    files = sorted((*folder().glob("*.c"), *rooms), key=lambda path: path.name)
    return {path.name: without_folders(path) for path in files if path.name not in LEFT_OUT}


def find(name: str) -> str:
    """Return the text of an engine file by name, from any of its folders."""
    (path,) = (path for path in folder().rglob(name) if path.parent.name not in NO_ROOMS)
    return without_folders(path)


def without_folders(path: Path) -> str:
    """Return the text of an engine file with the folders in its includes removed."""
    return FOLDER.sub('#include "', path.read_text(encoding="utf-8"))


def host(name: str) -> str:
    """Return the text of a file of engine/export, which surrounds a machine."""
    return (folder() / HOST / name).read_text(encoding="utf-8")


def hosted() -> set[str]:
    """Return the names of the files of engine/export, without suffix."""
    return {path.stem for path in (folder() / HOST).iterdir()} | {"plant"}


OUTSIDE = re.compile(
    r"^(?!static|typedef|return|else|#)[A-Za-z_][\w *]*?\b(jo_\w+)(?:\(| ?\[|;| =)",
    flags=re.MULTILINE,
)


def complex_build(files: dict[str, str], plant: str) -> dict[str, str]:
    """Return C files that compile given files a second time, with complex numbers and new names.

    Parameters
    ----------
    files : dict
        Sources and headers by name, in one folder.
    plant : str
        Name of the constants.

    Returns
    -------
    dict
        ``twice.h``, which renames the external names, and for each source a file that includes
        ``twice.h`` and the source.
    """
    names = {name for text in files.values() for name in OUTSIDE.findall(text)}
    lines = [f"#define {name} z_{name}" for name in sorted({*names, plant})]
    head = (
        "/* twice.h - names of the build with complex numbers, beside that with real ones. */\n"
        "#ifndef JO_TWICE_H\n#define JO_TWICE_H\n#define JO_COMPLEX\n"
    )
    made = {"twice.h": head + "\n".join(lines) + "\n#endif\n"}
    made |= {
        f"complex_{name}": f'#include "twice.h"\n#include "{name}"\n'
        for name in files
        if name.endswith(".c")
    }
    return made


FOLDER = re.compile(r'^#include "\w+/', flags=re.MULTILINE)
INCLUDE = re.compile(r'^#include "([^"]+)".*$', flags=re.MULTILINE)
STATIC = re.compile(r"^static [\w *]*?\b(\w+)(?:\(|\[| =)", flags=re.MULTILINE)
TYPE = re.compile(
    r"^(?:\} (\w+);|typedef struct \{[^{}]*\} (\w+);|typedef \w+ (\w+);)", flags=re.MULTILINE
)
ENUM = re.compile(r"^enum \{ ([^}]*) \};", flags=re.MULTILINE)
DEFINE = re.compile(r"^#define (\w+)", flags=re.MULTILINE)


def join_files(files: dict[str, str], known: dict[str, str]) -> str:
    """Return C files joined into one, with each header once and conflicting static names renamed.

    Parameters
    ----------
    files : dict
        Texts by name, in order.
    known : dict
        Headers that the files may include, by name.
    """
    done: set[str] = set()

    def included(text: str) -> str:
        def one(match: re.Match[str]) -> str:
            name = match.group(1)
            if name in done or name not in known:
                return "" if name in done else match.group(0)
            done.add(name)
            return included(known[name])

        return INCLUDE.sub(one, text)

    pieces = []
    own = {name: _own(text) for name, text in files.items()}
    count: dict[str, int] = {}
    for names in own.values():
        for name in names:
            count[name] = count.get(name, 0) + 1
    for name, text in files.items():
        stem = re.sub(r"\W", "_", Path(name).stem)
        heads = "".join(included(m.group(0)) + "\n" for m in INCLUDE.finditer(text))
        body = INCLUDE.sub("", text)
        for twice in sorted(x for x in own[name] if count[x] > 1):
            # rename, except fields of structs of the same name
            body = re.sub(rf"(?<![\w.])(?<!->){twice}\b", f"{twice}_of_{stem}", body)
        ended = "".join(f"#undef {x}\n" for x in sorted(set(DEFINE.findall(body))))
        pieces.append(f"{heads}\n/* ---- {name} ---- */\n{body}\n{ended}")
    return "\n".join(pieces)


def _own(text: str) -> set[str]:
    """Return the internal names of a file: static functions and data, types, enums, macros."""
    found = set(STATIC.findall(text))
    found |= {a or b or c for a, b, c in TYPE.findall(text)}
    for names in ENUM.findall(text):
        names = re.sub(r"/\*.*?\*/|=[^,]*", "", names)  # without comments and values
        found |= set(re.findall(r"\b([A-Za-z_]\w*)", names))
    return found
