"""Constructors of declared classes: what `dataclasses` makes from text, as plain functions.

A dataclass takes 0.4 ms, since Python compiles the text of its methods; a start declares 200
classes. `dataclasses.fields` and `replace` work on the objects: what they read of a class is made
at its first use.
"""

from __future__ import annotations

import dataclasses
import functools
import inspect
import reprlib
import sys
from collections.abc import Callable, Mapping
from typing import Any

from jousto.base.errors import CallError, Problem, suggest
from jousto.base.fields import MISSING
from jousto.base.renames import ARGUMENTS

POSITIONAL = inspect.Parameter.POSITIONAL_OR_KEYWORD
KEYWORD_ONLY = inspect.Parameter.KEYWORD_ONLY


def construct(cls: Any) -> None:
    """Give a class with `fields` its constructor and, if it is `by_value`, its comparison."""
    names = tuple(key for key, kind in cls.fields.items() if not kind.kw_only)
    for before, key in zip(names, names[1:], strict=False):
        if cls.fields[key].required and not cls.fields[before].required:
            raise TypeError(f"non-default argument {key!r} follows default argument {before!r}")
    cls.__match_args__ = names  # type: ignore[misc]
    cls.__dataclass_fields__ = _FIELDS
    if "__init__" in vars(cls):
        cls.__init__ = _answering(cls, cls.__init__)
        cls.__signature__ = None  # the one of its function
    else:
        cls.__init__ = _constructor(cls, names)
        cls.__signature__ = _SIGNATURE
    if cls.by_value:
        _compare(cls)


def _constructor(cls: Any, names: tuple[str, ...]) -> Callable[..., None]:
    """Return the constructor of a class; the named arguments are also taken by position."""
    defaults = {key: kind.default for key, kind in cls.fields.items()}
    required = tuple(key for key, kind in cls.fields.items() if kind.required)
    size = len(defaults)

    def __init__(self: Any, /, *given: Any, **named: Any) -> None:
        values = vars(self)
        values.update(defaults)
        values.update(zip(names, given, strict=False))
        values.update(named)
        wrong = (
            len(given) > len(names)
            or len(values) > size
            or not named.keys().isdisjoint(names[: len(given)])
        )
        for key in required:
            wrong |= values[key] is MISSING
        if wrong:
            raise _refused(cls, given, named)
        self.__post_init__()

    __init__.__qualname__ = f"{cls.__qualname__}.__init__"
    __init__.__module__ = cls.__module__
    return __init__


def _answering(cls: Any, made: Callable[..., None]) -> Callable[..., None]:
    """Return a constructor that reports missing and unknown arguments as a CallError."""

    @functools.wraps(made)
    def call(self: Any, *given: Any, **named: Any) -> None:
        try:
            made(self, *given, **named)
        except TypeError as error:
            # the TypeError was raised inside the constructor, not by this call
            if error.__traceback__ is None or error.__traceback__.tb_next:
                raise
            raise _refused(cls, given, named) from None

    return call


def _compare(cls: Any) -> None:
    """Make objects with equal fields equal, with one hash, and show them as their call."""
    names = tuple(key for key, kind in cls.fields.items() if kind.compare)

    def values(thing: Any) -> tuple[Any, ...]:
        return tuple(getattr(thing, key) for key in names)

    def __eq__(self: Any, other: object) -> Any:
        return values(self) == values(other) if type(other) is type(self) else NotImplemented

    def __hash__(self: Any) -> int:
        return hash(values(self))

    @reprlib.recursive_repr()
    def __repr__(self: Any) -> str:
        shown = ", ".join(f"{key}={getattr(self, key)!r}" for key in cls.fields)
        return f"{type(self).__qualname__}({shown})"

    for method in (__eq__, __hash__, __repr__):
        # a class with its own comparison has None as its hash
        if vars(cls).get(method.__name__) is None:
            setattr(cls, method.__name__, method)


class _Fields:
    """The fields of a declared class as `dataclasses` reads them, made at the first use."""

    def __get__(self, obj: object, owner: Any) -> dict[str, Any]:
        rows = []
        for key, kind in owner.fields.items():
            keep = {} if kind.required else {"default": kind.default}
            one = dataclasses.field(kw_only=kind.kw_only, compare=kind.compare, **keep)
            rows.append((key, kind.annotation, one))
        made: Any = dataclasses.make_dataclass(owner.__name__, rows)
        owner.__dataclass_fields__ = made.__dataclass_fields__
        found: dict[str, Any] = made.__dataclass_fields__
        return found


class _Signature:
    """The signature of the constructor of a declared class, made when it is asked for."""

    def __get__(self, obj: object, owner: Any) -> inspect.Signature:
        if obj is not None:  # of a class, not of its objects
            raise AttributeError("__signature__")
        typed = owner.__module__ in sys.modules
        rows = sorted(owner.fields.items(), key=lambda row: row[1].kw_only)
        return inspect.Signature(
            [
                inspect.Parameter(
                    key,
                    KEYWORD_ONLY if kind.kw_only else POSITIONAL,
                    default=inspect.Parameter.empty if kind.required else kind.default,
                    annotation=kind.annotation if typed else Any,
                )
                for key, kind in rows
            ],
            return_annotation=None,
        )


_FIELDS, _SIGNATURE = _Fields(), _Signature()


def _refused(cls: Any, given: Any, named: Mapping[str, Any]) -> CallError:
    """Return the problems of the arguments of a constructor."""
    name = named.get("name", given[0] if given and "name" in cls.fields else "")
    where = (
        f"{cls.kind or cls.__name__} {name!r}" if isinstance(name, str) and name else cls.__name__
    )
    parameters = inspect.signature(cls).parameters
    names = list(parameters)
    unknown = [key for key in named if key not in names]
    renamed = ARGUMENTS.get(cls.__name__, {})
    problems = [
        f"{key}= is now {renamed[key]}="
        if key in renamed
        else f"there is no argument {key!r}{suggest(key, names)}"
        for key in unknown
    ]
    if not problems:
        unnamed = [key for key, one in parameters.items() if one.kind is POSITIONAL]
        twice = [key for key in unnamed[: len(given)] if key in named]
        missing = [
            key
            for i, (key, one) in enumerate(parameters.items())
            if one.default is one.empty
            and one.kind in (POSITIONAL, KEYWORD_ONLY)
            and key not in named
            and not (one.kind is POSITIONAL and i < len(given))
        ]
        spread = any(one.kind is one.VAR_POSITIONAL for one in parameters.values())
        if twice:
            text = f"{twice[0]!r} is given twice, by its place and by its name"
        elif len(given) > len(unnamed) and not spread:
            text = f"{len(given)} arguments without a name are too many"
        else:
            plural = "arguments" if len(missing) > 1 else "argument"
            text = f"missing {len(missing)} {plural}: {', '.join(map(repr, missing))}"
        written = (
            f"{key}=..." if one.kind is KEYWORD_ONLY else key for key, one in parameters.items()
        )
        usage = cls.usage or f"{cls.__name__}({', '.join(written)})"
        problems = [f"{text}; it is called {usage}"]
    return CallError([Problem(where, one) for one in problems])
