"""Tables of the documentation that are made of the declarations."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Iterator
from typing import Any

from jousto.base.declare import kinds
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.schema.entries.declared import entry_of
from jousto.schema.entries.model import ModelEntry

assert ModelEntry  # the files of the entries say how model files write each form
PLACED = ("name", "a", "b", "as_placed")  # keys that the page says of all joints


def filled(text: str) -> str:
    """Replace lines ``KINDS section room`` and ``KEYS module class`` of a page by tables."""
    text = re.sub(
        r"^KEYS (\S+) (\S+)$", lambda match: "\n".join(keys(*match.groups())), text, flags=re.M
    )
    return re.sub(
        r"^KINDS (\S+) (\S+)$", lambda match: "\n".join(table(*match.groups())), text, flags=re.M
    )


def table(section: str, room: str) -> Iterator[str]:
    """Yield the lines of the table of a section, and of a folded one of its keys.

    Parameters
    ----------
    section, room : str
        As for `kinds`.
    """
    classes = kinds(section, room)
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
