"""Keys of what a study is made of: equal keys mean equal results, also in another process."""

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
"""Begins the key of something whose content is unknown; it is no other's."""

LIBRARIES = {"builtins", "copyreg", "functools", "jousto", "math", "numpy", "operator", "scipy"}
"""Packages whose functions and classes are known by their name."""

NUMBERS = (bool, int, float, complex, np.ndarray, np.generic)
PLAIN = (*NUMBERS, str, bytes, Path, tuple, list, set, frozenset, Mapping)


def key_of(*things: object) -> str:
    """Return a hash of the content of things that may hold functions.

    A function counts by its name, its text, its defaults and what it encloses, not by what it
    looks up in its module; an object by its class and what it holds.

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
        what = "something that holds itself"
    return f"{UNKNOWN}{what} {uuid4().hex}"


def unknown(found: Any) -> str:
    """Return what cannot be compared in keys, lists or mappings of them; empty if nothing."""
    if isinstance(found, Mapping):
        return next(filter(None, map(unknown, found.values())), "")
    if isinstance(found, str) and found.startswith(UNKNOWN):
        return found.removeprefix(UNKNOWN).rpartition(" ")[0]
    return ""


class Contents:
    """What stands for functions, classes and objects in a hash; each is gone into once."""

    def __init__(self) -> None:
        self._seen: dict[int, tuple[int, object]] = {}

    def __call__(self, thing: Any) -> object:
        """Return the content of a thing, or the thing itself where its content is known."""
        if thing is None or isinstance(thing, PLAIN) or sp.issparse(thing):
            return thing
        if isinstance(thing, types.ModuleType):
            return "module", thing.__name__
        if id(thing) in self._seen:
            return "again", self._seen[id(thing)][0]
        # held, so that its number stays its own
        self._seen[id(thing)] = len(self._seen), thing
        name = name_of(thing)
        if library(thing):
            return "library", name
        if isinstance(thing, types.FunctionType):
            cells = [content(cell) for cell in thing.__closure__ or ()]
            given = thing.__defaults__, thing.__kwdefaults__
            return "function", name, text_of(thing.__code__), cells, given
        if isinstance(thing, types.MethodType):
            return "method", thing.__func__, thing.__self__
        if isinstance(thing, functools.partial):
            return "partial", thing.func, thing.args, thing.keywords, vars(thing)
        if isinstance(thing, type):
            return "class", name, text_of_class(thing)
        if type(thing).__module__.startswith("jousto.") and not callable(thing):
            return thing
        return "object", type(thing), reduced(thing)


def content(cell: Any) -> object:
    """Return what a cell of a closure holds."""
    try:
        return "holds", cell.cell_contents
    except ValueError:
        return "empty"


def reduced(thing: Any) -> object:
    """Return what an object without fields would be pickled as."""
    try:
        found = thing.__reduce_ex__(4)
    except Exception:
        raise NotHashable(f"a {type(thing).__qualname__}") from None
    if isinstance(found, str):  # known by a name alone
        if hasattr(thing, "__wrapped__"):
            return vars(thing)
        raise NotHashable(f"a {type(thing).__qualname__}")
    return tuple(list(part) if hasattr(part, "__next__") else part for part in found)


def name_of(thing: Any) -> str:
    """Return module and name of a function or a class."""
    own = getattr(thing, "__qualname__", getattr(thing, "__name__", ""))
    return f"{getattr(thing, '__module__', '')}.{own}"


def library(thing: Any) -> bool:
    """Return whether a function or class is one that a library has under that name."""
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
def text_of(code: types.CodeType) -> object:
    """Return the text of a function; with its instructions where the text may be of several."""
    try:
        text = inspect.getsource(code)
    except (OSError, TypeError):
        text = ""
    return text if text and code.co_name != "<lambda>" else (text, instructions(code))


def instructions(code: types.CodeType) -> object:
    """Return what a function does, as the interpreter reads it."""
    constants = [
        instructions(item) if isinstance(item, types.CodeType) else repr(ordered(item))
        for item in code.co_consts
    ]
    return code.co_code, constants, code.co_names, code.co_varnames, code.co_freevars


def ordered(constant: Any) -> object:
    """Return a constant; a set in an order that is always the same."""
    return sorted(constant, key=repr) if isinstance(constant, frozenset) else constant


@functools.lru_cache(maxsize=1000)
def text_of_class(kind: type) -> tuple[str, ...]:
    """Return the texts of a class and those it is made of, but for libraries.

    Raises
    ------
    NotHashable
        If a class has none.
    """
    texts = []
    for own in kind.__mro__:
        if not library(own):
            try:
                texts.append(inspect.getsource(own))
            except (OSError, TypeError):
                raise NotHashable(f"a {kind.__qualname__}, whose text is not known") from None
    return tuple(texts)
