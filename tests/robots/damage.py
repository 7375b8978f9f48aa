"""Damage to files, and a watch on what is opened meanwhile."""

from __future__ import annotations

import os
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

VALUES = ["nan", "inf", "-1", "0", "", "1e400", "1e99", "x", "1 2 3", "../../etc/passwd", "1e-300"]
VALUES += ["http://localhost/x.stl", "file:///etc/hostname", "package://p/x.stl", "ground", "l1"]
PARTS = ["<link/>", "<joint/>", "<mesh filename='/etc/passwd'/>", "&lt;", "&amp;", "<!--", "\x00"]
PARTS += ["</robot>", "\u202e", "<inertial/>", "<origin xyz='1'/>", "<limit lower='3'/>"]

_seen: list[set[str]] = []


def damaged(text: str, rng: np.random.Generator) -> bytes:
    """Return a file with one to four things wrong."""
    for _ in range(int(rng.integers(1, 5))):
        text = DAMAGE[int(rng.integers(len(DAMAGE)))](text, rng)
    data = text.encode("utf-8", "replace")
    if rng.random() < 0.1:  # bits of another encoding
        at = int(rng.integers(len(data) + 1))
        data = data[:at] + bytes(rng.integers(0, 256, 3, dtype=np.uint8)) + data[at:]
    return data


def value(text: str, rng: np.random.Generator) -> str:
    """Replace the value of an attribute."""
    found = list(re.finditer(r'"[^"]*"', text))
    if not found:
        return text
    one = found[int(rng.integers(len(found)))]
    return f'{text[: one.start()]}"{VALUES[int(rng.integers(len(VALUES)))]}"{text[one.end() :]}'


def letter(text: str, rng: np.random.Generator) -> str:
    """Lose a piece."""
    at = int(rng.integers(len(text) + 1))
    return text[:at] + text[at + int(rng.integers(1, 30)) :]


def double(text: str, rng: np.random.Generator) -> str:
    """Double a line, or put it elsewhere."""
    lines = text.splitlines()
    i, j = rng.integers(len(lines), size=2)
    moved = lines[i] if rng.random() < 0.5 else lines.pop(i)
    lines.insert(int(j), moved)
    return "\n".join(lines)


def insert(text: str, rng: np.random.Generator) -> str:
    """Put in something foreign."""
    at = int(rng.integers(len(text) + 1))
    return text[:at] + PARTS[int(rng.integers(len(PARTS)))] + text[at:]


def cut(text: str, rng: np.random.Generator) -> str:
    """Lose a line."""
    lines = text.splitlines()
    if len(lines) > 1:
        lines.pop(int(rng.integers(len(lines))))
    return "\n".join(lines)


def swap(text: str, rng: np.random.Generator) -> str:
    """Exchange the values of two attributes."""
    found = re.findall(r'"[^"]*"', text)
    if len(found) < 2:
        return text
    i, j = (found[int(k)] for k in rng.integers(len(found), size=2))
    return text.replace(i, "\x01", 1).replace(j, i, 1).replace("\x01", j, 1)


DAMAGE = (value, value, value, letter, double, insert, cut, swap)


def _hook(event: str, args: tuple[Any, ...]) -> None:
    if not _seen:
        return
    if event == "open" and isinstance(args[0], str | bytes):
        _seen[0].add(os.fsdecode(args[0]))
    elif event.startswith("socket.") or event in ("subprocess.Popen", "os.system"):
        _seen[0].add(f"/{event}")


@contextmanager
def watched() -> Iterator[set[str]]:
    """Yield the names of files that are opened, and of connections."""
    if not getattr(sys, "_jousto_hook", False):
        sys.addaudithook(_hook)
        sys._jousto_hook = True  # type: ignore[attr-defined]
    seen: set[str] = set()
    _seen.append(seen)
    try:
        yield seen
    finally:
        _seen.clear()
