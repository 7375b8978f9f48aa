"""How objects show themselves: ``<Kind 'name': facts>``, never longer than a few lines.

Small values, whose fields are numbers and words alone (solvers, materials, settings), keep the form
of their constructor, which can be evaluated.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sized
from typing import Any, TypeVar

import numpy as np

C = TypeVar("C", bound=type)

LIMIT = 300  # characters
WORDS = 40  # characters of a string
FEW = 4  # items that are shown


def described(kind: C) -> C:
    """Let the objects of a class show as ``<Kind 'name': facts>``."""
    kind.__repr__ = describe  # type: ignore[assignment, method-assign]
    return kind


def describe(thing: Any) -> str:
    """Return ``<Kind 'name': facts>``, shorter than `LIMIT` characters.

    The facts are the fields in their order: numbers and words as they are, arrays by their shape,
    collections by their length, other objects by their name.

    Examples
    --------
    >>> @described
    ... @dataclasses.dataclass
    ... class Run:
    ...     name: str
    ...     time: object
    ...     steps: int
    >>> Run("lift", np.zeros(1001), 3)
    <Run 'lift': time (1001,), steps 3>
    """
    values = _fields(thing)
    name = values.pop("name", None)
    head = type(thing).__name__ + (f" {_cut(name)!r}" if isinstance(name, str) else "")
    facts = [text for key, value in values.items() if (text := _fact(key, value))]
    shown = f"<{head}: {', '.join(facts)}>" if facts else f"<{head}>"
    return shown if len(shown) < LIMIT else f"{shown[: LIMIT - 5]}...>"


def _fields(thing: Any) -> dict[str, Any]:
    if dataclasses.is_dataclass(thing):
        found = [field.name for field in dataclasses.fields(thing) if field.repr]
        return {key: getattr(thing, key, None) for key in found if not key.startswith("_")}
    return {key: value for key, value in vars(thing).items() if not key.startswith("_")}


def _fact(key: str, value: Any) -> str:
    """Return what is said of a field, empty where there is nothing to say."""
    if value is None:
        return ""
    shown = _value(value)
    return f"{key} {shown}" if shown else ""


def _value(value: Any) -> str:
    if isinstance(value, bool | np.bool_):
        return str(bool(value))
    if isinstance(value, int | float | np.number):
        return f"{value:.6g}"
    if isinstance(value, str):
        return repr(_cut(value))
    if isinstance(value, np.ndarray):
        if value.size <= FEW and value.dtype.kind in "fiu" and value.ndim == 1:
            return "(" + ", ".join(f"{x:.6g}" for x in value) + ")"
        return str(value.shape)
    name = getattr(value, "label", None) or getattr(value, "name", None)
    if isinstance(name, str):
        return repr(_cut(name))
    if isinstance(value, Mapping):
        return f"{len(value)} entries"
    if isinstance(value, list | tuple):
        if len(value) <= FEW and all(isinstance(x, int | float | str) for x in value):
            return "(" + ", ".join(_value(x) for x in value) + ")" if value else ""
        return f"{len(value)} items"
    if callable(value):
        return str(getattr(value, "__name__", type(value).__name__))
    if isinstance(value, Sized):
        return f"{type(value).__name__} of {len(value)}"
    return type(value).__name__


def _cut(text: str) -> str:
    return text if len(text) <= WORDS else f"{text[: WORDS - 3]}..."
