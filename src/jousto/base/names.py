"""Names: allowed characters, and safe display of text from other sources."""

from __future__ import annotations

import re
import unicodedata
from typing import Any

from jousto.base.errors import Problems

FORBIDDEN = {"body": "./", "part": "/\\:"}
"""Forbidden characters of names by kind: names of bodies precede a dot, names of parts become file
names."""

# control characters, and direction marks (right to left), which can hide text
HIDDEN = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\u200e\u200f\u202a-\u202e\u2066-\u2069]"
)


def check_name(problems: Problems, kind: str, name: Any) -> str:
    """Return the prefix of messages, such as ``body 'arm'``, and report a wrong name.

    Names are used in messages, in labels such as ``arm.tip`` and in HDF5 paths.
    """
    where = f"{kind} {name!r}"
    if not isinstance(name, str):
        problems.add(where, "name must be a string", "name")
    elif not name.strip() or name != name.strip():
        problems.add(where, "name must not be empty or start or end with a blank", "name")
    else:
        forbidden = [c for c in FORBIDDEN.get(kind, "/") if c in name]
        if forbidden:
            problems.add(where, f"name must not contain {forbidden[0]!r}", "name")
        elif name in (".", ".."):
            problems.add(where, "name must not be '.' or '..'", "name")
        elif not name.isprintable() and any(unicodedata.category(c) in ("Cc", "Cs") for c in name):
            problems.add(where, "name must not contain control characters", "name")
        elif kind == "body" and name == "ground":
            problems.add(where, "the name 'ground' is taken by the ground")
    return where


def file_name(name: str) -> str:
    """Return a text from another source as part of a file name in a known folder.

    >>> file_name("../../boom")
    '.._.._boom'
    """
    return re.sub(r"[/\\:\x00-\x1f]", "_", name)


def harmless(text: str) -> str:
    r"""Return text with control characters escaped, safe for a terminal.

    >>> harmless("a\x1b[2Jb")
    'a\\x1b[2Jb'
    """
    return HIDDEN.sub(lambda found: repr(found[0])[1:-1], text)
