"""Representation of objects: ``<Kind 'name': facts>``, at most a few lines.

A class whose fields are not informative has a method ``_facts()``, which returns the facts as text.

Small values with fields of numbers and words only (solvers, materials, settings) have the form of
their constructor, which can be evaluated.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sized
from itertools import starmap
from typing import Any, TypeVar

import numpy as np

C = TypeVar("C", bound=type)

LIMIT = 300  # characters
WORDS = 40  # largest length of a string
FEW = 4  # largest number of displayed items


def described(kind: C) -> C:
    """Give the objects of a class the representation ``<Kind 'name': facts>``."""
    kind.__repr__ = describe  # type: ignore[assignment, method-assign]
    return kind


def describe(thing: Any) -> str:
    """Return ``<Kind 'name': facts>``, shorter than `LIMIT` characters.

    The facts are the result of ``thing._facts()``, else the fields in their order: numbers and
    words as they are, arrays by their shape, collections by their length, other objects by their
    name.

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
    name = getattr(thing, "name", None)
    head = type(thing).__name__ + (f" {_cut(name)!r}" if isinstance(name, str) else "")
    method = getattr(thing, "_facts", None)
    facts = method() if method else ", ".join(filter(None, starmap(_fact, _fields(thing).items())))
    shown = f"<{head}: {facts}>" if facts else f"<{head}>"
    return shown if len(shown) < LIMIT else f"{shown[: LIMIT - 5]}...>"


def _fields(thing: Any) -> dict[str, Any]:
    if dataclasses.is_dataclass(thing):
        found = [field.name for field in dataclasses.fields(thing) if field.repr]
    else:
        found = list(vars(thing))
    shown = [key for key in found if key != "name" and not key.startswith("_")]
    return {key: getattr(thing, key, None) for key in shown}


def _fact(key: str, value: Any) -> str:
    """Return the text of a field for `describe`; empty if the field is left out."""
    if value is None or (isinstance(value, str) and not value):
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
        if value.ndim == 0:
            return _value(value[()])
        if value.size <= FEW and value.dtype.kind in "fiu" and value.ndim == 1:
            # a coordinate of 1e-18 beside one of 1 is shown as zero
            none = 1e-12 * np.abs(value).max(initial=0.0)
            few = (f"{0.0 if abs(x) <= none else x:.6g}" for x in value)
            return "(" + ", ".join(few) + ")"
        return str(value.shape)
    name = getattr(value, "label", None) or getattr(value, "name", None)
    if isinstance(name, str):
        return repr(_cut(name))
    if isinstance(value, Mapping):
        return f"{len(value)} {'entry' if len(value) == 1 else 'entries'}"
    if isinstance(value, list | tuple):
        if len(value) <= FEW and all(isinstance(x, int | float | str) for x in value):
            return "(" + ", ".join(_value(x) for x in value) + ")" if value else ""
        return f"{len(value)} item{'s' if len(value) != 1 else ''}"
    if callable(value):
        return str(getattr(value, "__name__", type(value).__name__))
    if isinstance(shape := getattr(value, "shape", None), tuple):  # a sparse matrix
        return str(shape)
    if isinstance(value, Sized):
        return f"{type(value).__name__} of {len(value)}"
    return type(value).__name__


def _cut(text: str) -> str:
    return text if len(text) <= WORDS else f"{text[: WORDS - 3]}..."
