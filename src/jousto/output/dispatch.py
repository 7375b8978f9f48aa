"""Lookup of the function that draws or writes an object, by its type; imported when needed."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any, TypeVar

from jousto.base.errors import CallError, InputError, Problem

T = TypeVar("T")


def find_entry(table: Mapping[str, T], thing: object, verb: str) -> tuple[str, T]:
    """Return the name of an object's type and its entry in a table.

    Raises
    ------
    InputError
        If the table has no entry for the type.
    """
    for kind in type(thing).__mro__:
        if kind.__name__ in table and kind.__module__.startswith("jousto."):
            return kind.__name__, table[kind.__name__]
    known = ", ".join(table)
    raise InputError(Problem(verb, f"does not accept a {type(thing).__name__}; known: {known}"))


def implementation(place: str) -> Callable[..., Any]:
    """Return ``module.function`` of this room, or of another room named from the top."""
    module, _, name = place.rpartition(".")
    whole = module if module.startswith("jousto.") else f"jousto.output.{module}"
    function: Callable[..., Any] = getattr(import_module(whole), name)
    return function


def call(place: str, what: str, *given: Any, **options: Any) -> Any:
    """Call ``module.function`` of this room; messages on wrong arguments begin with `what`.

    Raises
    ------
    CallError
        If an argument is missing or unknown; the message lists the known ones.
    """
    function = implementation(place)
    signature = inspect.signature(function)
    try:
        signature.bind(*given, **options)
    except TypeError as error:
        known = signature.parameters
        needed = [key for key, one in known.items() if one.default is one.empty and one.kind != 2]
        example = f"jo.{'write' if what[0] == '.' else 'plot'}({', '.join(needed)}, ...)"
        message = f"{error}; it takes {', '.join(list(known)[1:])}, such as {example}"
        raise CallError(Problem(what, message)) from None
    return function(*given, **options)
