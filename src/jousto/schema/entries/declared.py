"""Entries of declared classes, made of their fields: one for each word of a section."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field as Key, create_model

from jousto.base.declare import Declared, Field, kinds
from jousto.schema.entries.base import (
    Count,
    Direction,
    Duration as Seconds,
    Entry,
    Flag,
    Marker,
    Number,
    Text,
    Unit,
    Vector,
)
from jousto.schema.entries.choices import Tagged
from jousto.schema.entries.signals import Amount

Forms: TypeAlias = Mapping[str, Callable[[Any], Any]]

FORMS: dict[str, Callable[[Any], Any]] = {
    "text": lambda field: Text,
    "texts": lambda field: tuple[Text, ...],
    "reference": lambda field: Text,
    "flag": lambda field: Flag,
    "number": lambda field: amount(field.unit),
    "duration": lambda field: Seconds,
    "count": lambda field: Count,
    "numbers": lambda field: tuple[Number, ...],
    "choice": lambda field: Literal[field.words],
    "vector": lambda field: vector(field.unit),
    "nested": lambda field: one_of(field.section, field.room),
    "direction": lambda field: Direction,
    "marker": lambda field: Marker,
    "item": lambda field: entry_of(field.of),
}
"""What a field of each form looks like in a model file, as a type that pydantic checks."""

# types that are put together here, which type checkers cannot follow
NOTED: Any = Annotated
ROW: Any = tuple


def amount(unit: Any) -> Any:
    """Return the type of a number; a unit that depends on other fields is checked with them."""
    return Annotated[float, Unit(unit)] if isinstance(unit, str) else Amount


def vector(unit: Any) -> Any:
    """Return the type of three numbers."""
    one = amount(unit)
    return NOTED[ROW[one, one, one], Vector(3)]


def entry_of(cls: type[Declared], forms: Forms = FORMS) -> Any:
    """Return the entry of a class in model files: its word, and a key for each field."""
    keys: dict[str, Any] = {"type": (Literal[cls.tag], ...)} if cls.tag else {}
    for name, field in cls.fields.items():
        if not field.file:
            continue
        form = forms[field.form](field)
        if field.required:
            keys[name] = (form, Key(description=said(field)))
        else:
            keys[name] = (form | None, Key(None, description=said(field)))
    made: Any = create_model(f"{cls.__name__}Entry", __base__=Entry, **keys)
    made.__doc__ = f"`{cls.__name__}`: {(inspect.getdoc(cls) or '').partition(chr(10))[0]}"
    made.declared = cls
    return made


def said(field: Field[Any, Any]) -> str | None:
    """Return what editors show of a field, None if there is nothing to say."""
    unit = "" if isinstance(field.unit, str) else f", {field.unit}"
    plain = field.required or field.default is None or isinstance(field.default, bool)
    default = "" if plain else f"; {field.default} if not given"
    return f"{field.text}{unit}{default}" or None


def one_of(section: str, room: str, forms: Forms = FORMS) -> Any:
    """Return the type of an entry of a section: one of its classes, by the key ``type``.

    The classes are imported and their entries made when a file has one of the section.

    Parameters
    ----------
    section, room : str
        As for `kinds`.
    forms : mapping
        Types for each form of a field.
    """
    made: dict[type[Declared], type[Entry]] = {}

    def entries() -> Mapping[str, type[Entry]]:
        found = kinds(section, room)  # with those that a user has declared
        for cls in found.values():
            if cls not in made:
                made[cls] = entry_of(cls, forms)
        return {tag: made[cls] for tag, cls in found.items()}

    return Annotated[Any, Tagged(classes=entries)]
