"""Fill in the parts of the pages in docs/ that are made of the declarations.

    python tools/tables.py

They stand between a line ``<!-- tools/tables.py WHAT WORDS -->`` and a line ``<!-- end -->``:

* ``kinds SECTION ROOM``: the kinds of a section of model files, such as joints, and their keys;
* ``keys MODULE CLASS``: the keys of a class that stands alone in its section;
* ``public ROOM ...``: the public names of rooms, with the place of the help of each.
"""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Callable, Iterator
from operator import attrgetter
from pathlib import Path
from typing import Any

import jousto as jo
from jousto.base.declare import kinds
from jousto.base.lazy_exports import public_names
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.schema.entries.declared import entry_of
from jousto.schema.entries.model import ModelEntry

assert ModelEntry  # the files of the entries say how model files write each form
DOCS = Path(__file__).resolve().parents[1] / "docs"
PLACED = ("name", "a", "b", "as_placed")  # keys that the page says of all joints
PART = re.compile(
    r"(?<=^<!-- tools/tables\.py )(\w+) (.+?)( -->\n).*?(?=^<!-- end -->$)", re.M | re.S
)


def filled(text: str) -> str:
    """Return the text of a page with each of its parts as the declarations give it."""

    def part(match: re.Match[str]) -> str:
        made = "\n".join(MAKERS[match[1]](*match[2].split()))
        return f"{match[1]} {match[2]}{match[3]}\n{made}\n\n"

    return PART.sub(part, text)


def table(section: str, room: str) -> Iterator[str]:
    """Yield the lines of the table of a section, and of a folded one of its keys.

    Parameters
    ----------
    section, room : str
        As for `kinds`.
    """
    # in the order of the files, whatever was imported first, without what others have declared
    inside = [
        one
        for one in kinds(section, room).items()
        if f"{one[1].__module__}.".startswith(f"{room}.")
    ]
    classes = dict(sorted(inside, key=lambda one: one[1].__module__))
    left_out = PLACED if section == "joints" else ("name",) * (section != "signals")
    meanings: dict[tuple[str, str], list[str]] = {}
    more = [" coordinates |", "---|"] if section == "joints" else ["", ""]
    yield f"| `type` | what it is | keys |{more[0]}"
    yield f"|---|---|---|{more[1]}"
    for word, cls in classes.items():
        fields = {
            key: field
            for key, field in entry_of(cls).model_fields.items()
            if key not in ("type", *left_out)
        }
        for key, field in fields.items():
            meanings.setdefault((key, field.description or ""), []).append(word)
        needed = coded(key for key, field in fields.items() if field.is_required())
        others = coded(key for key, field in fields.items() if not field.is_required())
        what = plain((inspect.getdoc(cls) or "").partition("\n")[0])
        row = [f"`{word}`", what, "; ".join(filter(None, [needed, others and f"*{others}*"]))]
        if more[0]:
            row.append(coded(coordinates(cls)))
        yield line(row)
    yield from ["", "<details>", "<summary>What each key means</summary>", ""]
    yield from ["| key | of | meaning |", "|---|---|---|"]
    for (key, meaning), words in meanings.items():
        yield line([f"`{key}`", coded(words), plain(meaning)])
    yield from ["", "</details>"]


def keys(module: str, name: str) -> Iterator[str]:
    """Yield the lines of the table of the keys of a class that stands alone in its section."""
    entry = entry_of(getattr(importlib.import_module(module), name))
    yield from ["| key | meaning |", "|---|---|"]
    for key, field in entry.model_fields.items():
        needed = "" if field.is_required() else "*"
        yield line([f"{needed}`{key}`{needed}", plain(field.description or "")])


def public(*rooms: str) -> Iterator[str]:
    """Yield what places the help of the public names that files of some rooms define."""
    yield "```{eval-rst}"
    for place in sorted(public_names(), key=lambda place: (place.count("."), place)):
        thing = attrgetter(place.removeprefix("jo."))(jo)
        module = getattr(thing, "__module__", "")
        if f"{module}.".startswith(tuple(f"jousto.{room}." for room in rooms)):
            kind = "class" if isinstance(thing, type) else "function" if callable(thing) else "data"
            yield f"``{place}``\n\n.. auto{kind}:: {module}.{place.rpartition('.')[2]}\n"
    yield "```"


def coordinates(cls: Any) -> Iterator[str]:
    """Yield the names of the coordinates that a joint gives."""
    names = {kind.__name__ for kind in (Coordinate, *Coordinate.__subclasses__())}
    for key in dir(cls):
        made = getattr(inspect.getattr_static(cls, key), "func", None)  # of a cached property
        if made and inspect.get_annotations(made).get("return") in names:
            yield key


def plain(text: str) -> str:
    """Return a text of a docstring as Markdown."""
    return re.sub(r":\w+:`", "`", text).replace("``", "`")


def coded(words: Any) -> str:
    """Return words as code, with commas."""
    return ", ".join(f"`{word}`" for word in words)


def line(cells: list[str]) -> str:
    """Return a row of a table."""
    return f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |"


MAKERS: dict[str, Callable[..., Iterator[str]]] = {"kinds": table, "keys": keys, "public": public}

if __name__ == "__main__":
    for path in DOCS.rglob("*.md"):
        text = path.read_text(encoding="utf-8")
        if (new := filled(text)) != text:
            path.write_text(new, encoding="utf-8")
            print(f"filled in docs/{path.relative_to(DOCS)}")
