"""Lazy packages: public names are listed in a stub and loaded at first use."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from importlib import import_module
from importlib.util import resolve_name
from pathlib import Path
from types import ModuleType
from typing import Any

from jousto.base.renames import RENAMED


class Room(ModuleType):
    """Package that loads a public name of its stub when the name is first used."""

    _places: dict[str, tuple[str, str]]
    _gone: Callable[[str], str]
    __all__: list[str]

    def __getattr__(self, name: str) -> Any:
        if name not in self._places:
            new = "" if name.startswith("__") else self._gone(name)
            if new := RENAMED.get(f"{self.__name__}.{name}", new):
                message = f"{self.__name__}.{name} is now {new}"
            else:
                message = f"module {self.__name__!r} has no attribute {name!r}"
                message += "" if name.startswith("_") else _nearest(name, self.__all__)
            raise AttributeError(message, name=name, obj=self)
        module, own = self._places[name]
        names = {} if module == self.__name__ else vars(import_module(module))
        found = names[own] if own in names else import_module(f"{module}.{own}")
        vars(self)[name] = found
        return found

    def __setattr__(self, name: str, value: object) -> None:
        # an imported file does not hide the public function with the same name
        if not (isinstance(value, ModuleType) and name in self._places):
            super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        return list(self.__all__)

    def __reduce__(self) -> tuple[Callable[[str], ModuleType], tuple[str]]:
        # pickled functions contain the module that defines them
        return import_module, (self.__name__,)


def _nearest(name: str, known: list[str]) -> str:
    # only needed for a wrong name, so that imports stay quick
    from jousto.base.errors import suggest

    return suggest(name, known)


def open_room(name: str, gone: Callable[[str], str] = lambda _: "") -> None:
    """Make a package load the names of its ``__init__.pyi`` at first use.

    Parameters
    ----------
    name : str
        Name of the package.
    gone : callable, optional
        Function from a missing name to its new name; empty for unknown names.
    """
    room = sys.modules[name]
    stub = Path(str(room.__file__)).with_suffix(".pyi").read_text(encoding="utf-8")
    places = {}
    for node in ast.parse(stub).body:
        if isinstance(node, ast.ImportFrom):
            module = resolve_name("." * node.level + (node.module or ""), name)
            for alias in node.names:
                places[alias.asname or alias.name] = (module, alias.name)
    public = sorted(key for key in places if not key.startswith("_"))
    vars(room).update(_places=places, _gone=gone, __all__=public)
    room.__class__ = Room


def public_names() -> tuple[str, ...]:
    """Return all public names with their packages, as users write them.

    Examples
    --------
    >>> "jo.simulate" in public_names(), "jo.fatigue.rainflow" in public_names()
    (True, True)
    """
    top = sys.modules["jousto"]
    home = Path(str(top.__file__)).parents[1]
    found: list[str] = []
    for name in top.__all__:
        path = home.joinpath(*".".join(top._places[name]).split("."), "__init__.pyi")
        if path.is_file():
            found += (f"jo.{name}.{inner}" for inner in getattr(top, name).__all__)
        else:
            found.append(f"jo.{name}")
    return tuple(found)
