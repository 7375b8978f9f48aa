"""Hashes of the content of a study: equal in every process for equal results."""

from __future__ import annotations

import functools
import inspect
import sys
import types
from collections.abc import Mapping
from pathlib import Path
from typing import Any
from uuid import uuid4

import numpy as np
import scipy.sparse as sp

from jousto.reduction.files.cache import NotHashable, key

UNKNOWN = "cannot be compared: "
"""First word of the key of an object without comparable content; the key is unique."""

LIBRARIES = {"builtins", "copyreg", "functools", "jousto", "math", "numpy", "operator", "scipy"}
"""Packages whose functions and classes are identified by their names."""

NUMBERS = (bool, int, float, complex, np.ndarray, np.generic)
PLAIN = (*NUMBERS, str, bytes, Path, tuple, list, set, frozenset, Mapping)


def key_of(*things: object) -> str:
    """Return a hash of the content of objects, including functions.

    The hash of a function includes its name, source, defaults and captured values, but no globals
    of its module; the hash of an object includes its class and its fields.

    Examples
    --------
    >>> def times(factor):
    ...     return lambda x: factor * x
    >>> key_of(times(2.0)) == key_of(times(2.0)) != key_of(times(3.0))
    True
    """
    try:
        return key(*things, instead=Contents())
    except NotHashable as error:
        what = str(error)
    except RecursionError:
        what = "something that contains itself"
    return f"{UNKNOWN}{what} {uuid4().hex}"


def incomparable(found: Any) -> str:
    """Return the name of an object that cannot be compared by content; empty if there is none."""
    if isinstance(found, Mapping):
        return next(filter(None, map(incomparable, found.values())), "")
    if isinstance(found, str) and found.startswith(UNKNOWN):
        return found.removeprefix(UNKNOWN).rpartition(" ")[0]
    return ""


class Contents:
    """Representation of functions, classes and objects by their content, each visited once."""

    def __init__(self) -> None:
        self._seen: dict[int, tuple[int, object]] = {}

    def __call__(self, thing: Any) -> object:
        """Return the content of an object, or the object itself if it is plain data."""
        if thing is None or isinstance(thing, PLAIN) or sp.issparse(thing):
            return thing
        if isinstance(thing, types.ModuleType):
            return "module", thing.__name__
        if id(thing) in self._seen:
            return "again", self._seen[id(thing)][0]
        # a reference prevents the reuse of the id
        self._seen[id(thing)] = len(self._seen), thing
        name = qualified_name(thing)
        if is_library(thing):
            return "library", name
        if isinstance(thing, types.FunctionType):
            cells = [cell_content(cell) for cell in thing.__closure__ or ()]
            given = thing.__defaults__, thing.__kwdefaults__
            return "function", name, source_of(thing.__code__), cells, given
        if isinstance(thing, types.MethodType):
            return "method", thing.__func__, thing.__self__
        if isinstance(thing, functools.partial):
            return "partial", thing.func, thing.args, thing.keywords, vars(thing)
        if isinstance(thing, type):
            return "class", name, class_sources(thing)
        if type(thing).__module__.startswith("jousto.") and not callable(thing):
            return thing
        return "object", type(thing), pickled_form(thing)


def cell_content(cell: Any) -> object:
    """Return the content of a cell of a closure."""
    try:
        return "holds", cell.cell_contents
    except ValueError:
        return "empty"


def pickled_form(thing: Any) -> object:
    """Return the pickled form of an object without fields."""
    try:
        found = thing.__reduce_ex__(4)
    except Exception:
        raise NotHashable(f"a {type(thing).__qualname__}") from None
    if isinstance(found, str):  # an object identified by its name
        if hasattr(thing, "__wrapped__"):
            return vars(thing)
        raise NotHashable(f"a {type(thing).__qualname__}")
    return tuple(list(part) if hasattr(part, "__next__") else part for part in found)


def qualified_name(thing: Any) -> str:
    """Return module and qualified name of a function or class."""
    own = getattr(thing, "__qualname__", getattr(thing, "__name__", ""))
    return f"{getattr(thing, '__module__', '')}.{own}"


def is_library(thing: Any) -> bool:
    """Return whether a function or class belongs to a library and has that name there."""
    own = getattr(thing, "__qualname__", getattr(thing, "__name__", ""))
    module = getattr(thing, "__module__", None) or type(thing).__module__
    if not isinstance(own, str) or not own or not isinstance(module, str):
        return False
    if module.lstrip("_").partition(".")[0] not in LIBRARIES:
        return False
    found: Any = sys.modules.get(module)
    for part in own.split("."):
        found = getattr(found, part, None)
    return found is thing


@functools.lru_cache(maxsize=1000)
def source_of(code: types.CodeType) -> object:
    """Return the source of a function, with its bytecode if several share a line."""
    try:
        text = inspect.getsource(code)
    except (OSError, TypeError):
        text = ""
    return text if text and code.co_name != "<lambda>" else (text, instructions(code))


def instructions(code: types.CodeType) -> object:
    """Return the bytecode and constants of a function."""
    constants = [
        instructions(item) if isinstance(item, types.CodeType) else repr(sort_constant(item))
        for item in code.co_consts
    ]
    return code.co_code, constants, code.co_names, code.co_varnames, code.co_freevars


def sort_constant(constant: Any) -> object:
    """Return a constant; a set in sorted order."""
    return sorted(constant, key=repr) if isinstance(constant, frozenset) else constant


@functools.lru_cache(maxsize=1000)
def class_sources(kind: type) -> tuple[str, ...]:
    """Return the sources of a class and its bases outside of libraries.

    Raises
    ------
    NotHashable
        If a class has no source.
    """
    texts = []
    for own in kind.__mro__:
        if not is_library(own):
            try:
                texts.append(inspect.getsource(own))
            except (OSError, TypeError):
                raise NotHashable(f"a {kind.__qualname__}, whose text is not known") from None
    return tuple(texts)
