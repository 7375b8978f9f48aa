"""Error messages for arguments of wrong types, in place of errors deep inside a call.

The annotations of a function contain the accepted types. They are checked only after a call has
failed, so that no valid call is refused or slowed down.
"""

from __future__ import annotations

import ast
import builtins
import functools
import inspect
import os
import re
import sys
import typing
from collections import ChainMap
from collections.abc import Callable, Iterable, Mapping
from types import UnionType
from typing import Any, TypeVar

import numpy as np

from jousto.base.errors import InputError, JoustoError, Problem
from jousto.base.lazy_exports import public_names
from jousto.base.renames import ARGUMENTS

F = TypeVar("F", bound=Callable[..., Any])
Scope = Mapping[str, Any]

DEEP = (TypeError, ValueError, AttributeError, LookupError, ArithmeticError)
"""Exceptions caused by arguments of wrong types."""

HOW = {
    "Cycles": "jo.fatigue.rainflow(series, residue=...)",
    "DamageField": "jo.damage_field(field, sn)",
    "HotSpots": "jo.hot_spots(run)",
    "Marker": 'body["point"]',
    "Material": "jo.material('S355') or jo.Material(E, nu, rho)",
    "Mechanism": "jo.Mechanism(*items)",
    "Mesh": "jo.read_mesh(path) or jo.mesh_cad(path, size=...)",
    "Model": "jo.compile(mechanism)",
    "PlaneCriterion": (
        "jo.fatigue.Findley(0.3), jo.fatigue.FatemiSocie(S_y, E) or jo.fatigue.NormalStress()"
    ),
    "Part": "jo.Part.beam(...), jo.Part.solid(mesh, material)",
    "Record": "jo.gauges.read_record(path)",
    "ReducedPart": "jo.reduce(part, method)",
    "SN": "jo.sn_curve(name), jo.fatigue.fat_class(71) or jo.fatigue.estimate_sn('S355')",
    "Solution": "jo.simulate(model, t_end) or jo.load(path)",
    "State": "jo.equilibrium(model), jo.simulation.vibration_free_state(model) or run.state()",
    "StrainLife": "jo.fatigue.strain_life(name)",
    "StressField": "jo.stress_field(run, body)",
}
"""Functions that create objects, by class, for messages."""

WORDS = {
    "float": "a number",
    "int": "a whole number",
    "bool": "True or False",
    "str": "a text",
    "Path": "a path",
    "PathLike": "a path",
    "None": "None",
    "Callable": "a function",
    "Sets": "a dictionary",
}
NUMERIC = ("ArrayLike", "Array", "Ints", "NDArray")
SEVERAL = ("Sequence", "Iterable", "list", "tuple", "set")


def explained(what: F) -> F:
    """Decorate a function or a class so that errors report arguments of wrong types.

    Examples
    --------
    >>> @explained
    ... def twice(x: float) -> float:
    ...     return 2.0 * x
    >>> twice("1 s")
    Traceback (most recent call last):
        ...
    jousto.base.errors.InputError: twice: x is '1 s', must be a number
    """
    if isinstance(what, type):
        kind: Any = what
        kind.__init__ = _watched(kind.__init__, kind.__name__)
        return what
    return typing.cast(F, _watched(what, what.__name__))


def explained_as(where: str) -> Callable[[F], F]:
    """Decorate a function like `explained`, with the name by which users call it."""

    def mark(what: F) -> F:
        return typing.cast(F, _watched(what, where))

    return mark


def _watched(function: Callable[..., Any], where: str) -> Callable[..., Any]:
    @functools.wraps(function)
    def call(*given: Any, **named: Any) -> Any:
        try:
            return function(*given, **named)
        except JoustoError:
            raise
        except DEEP as error:
            problems = misfits(function, where, given, named)
            if problems:
                raise InputError(problems) from error
            raise

    return call


def misfits(
    function: Callable[..., Any], where: str, given: tuple[Any, ...], named: dict[str, Any]
) -> list[Problem]:
    """Return the problems with the arguments of a call that the annotations reveal."""
    signature = inspect.signature(function)
    try:
        bound = signature.bind(*given, **named).arguments
    except TypeError:  # too many, too few or unknown arguments: reported by Python
        changed = ARGUMENTS.get(where, {})
        return [
            Problem(where, f"{name}= is now {changed[name]}=") for name in named if name in changed
        ]
    scope = getattr(inspect.unwrap(function), "__globals__", {})
    if function.__name__ == "__init__" and given:  # fields declared by classes in other files
        files = (vars(sys.modules[base.__module__]) for base in type(given[0]).__mro__)
        scope = ChainMap(scope, *files)
    found = []
    for name, value in bound.items():
        parameter = signature.parameters[name]
        text = parameter.annotation
        if not isinstance(text, str) or parameter.kind in (2, 4):  # *args and **kwargs
            continue
        kind = ast.parse(text, mode="eval").body
        documented = _documented(function, name)
        alone = _is_number(value) and "array" in documented and "float" not in documented
        wanted = ""
        if not _fits(kind, value, scope):
            wanted = _wanted(kind)
        elif (_name(kind) == "Any" or alone) and not _fits_words(documented, value, scope):
            wanted = documented.removesuffix(", optional")
        if wanted:
            found.append(Problem(where, f"{name} is {_shown(value)}, must be {wanted}"))
    return found


def _documented(function: Callable[..., Any], name: str) -> str:
    """Return the type of an argument in the docstring: ``SN``, ``(3,) array_like``.

    Empty if none.
    """
    owner = getattr(sys.modules.get(function.__module__), function.__qualname__.split(".")[0], None)
    for text in (function.__doc__, owner.__doc__):
        for line in (text or "").splitlines():
            names, colon, words = line.strip().partition(" : ")
            if colon and name in names.split(", "):
                return words
    return ""


def _fits_words(words: str, value: Any, scope: Scope) -> bool:
    """Return whether a value has the type written in the docstring; True for unknown types."""
    words, _, inside = words.partition(" of ")
    checks = []
    for word in re.findall(r"\w+", words):
        if word in ("array", "array_like", "arrays"):
            checks.append(_is_numeric(value) and (np.ndim(value) > 0 or "(" not in words))
        elif word in ("sequence", "list", "tuple", "iterable"):
            items = value if isinstance(value, list | tuple) else ()
            several = isinstance(value, Iterable) and not isinstance(value, str)
            checks.append(several and all(_fits_words(inside, item, scope) for item in items))
        elif word[0].isupper():
            checks.append(_belongs(word, value, scope))
        elif (plain := _plain(word, value)) is not None:
            checks.append(plain)
    left_out = value is None and ("optional" in words or "None" in words)
    return any(checks) or not checks or left_out


def _shown(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 and " at 0x" not in text else f"a {type(value).__name__}"


def _name(kind: ast.expr) -> str:
    """Return the last word of a type such as ``np.ndarray``, ``Sequence[str]`` or ``Model``."""
    if isinstance(kind, ast.Subscript):
        return _name(kind.value)
    if isinstance(kind, ast.Attribute):
        return kind.attr
    if isinstance(kind, ast.Name):
        return kind.id
    return str(kind.value) if isinstance(kind, ast.Constant) else ""


def _union(kind: ast.expr) -> list[ast.expr]:
    """Return the members of a union type, or the one type."""
    if isinstance(kind, ast.BinOp):
        return [*_union(kind.left), *_union(kind.right)]
    return [kind]


def _inside(kind: ast.expr) -> list[ast.expr]:
    """Return the arguments of an annotation such as ``Sequence[...]``; empty for other types."""
    if not isinstance(kind, ast.Subscript):
        return []
    return list(kind.slice.elts) if isinstance(kind.slice, ast.Tuple) else [kind.slice]


def _fits(kind: ast.expr, value: Any, scope: Scope) -> bool:
    """Return whether a value has an annotated type; True if this cannot be checked."""
    if isinstance(kind, ast.BinOp):
        return any(_fits(part, value, scope) for part in _union(kind))
    name = _name(kind)
    plain = _plain(name, value)
    if plain is not None:
        return plain
    if name in SEVERAL:
        if not isinstance(value, Iterable) or (
            isinstance(value, str) and name not in ("Sequence", "Iterable")
        ):
            return False
        # other iterables may yield their items only once
        some = value if isinstance(value, list | tuple | str) else ()
        return all(_fits(item, one, scope) for item in _inside(kind)[:1] for one in some)
    if name == "Literal":
        return any(value == ast.literal_eval(part) for part in _inside(kind))
    return _belongs(name, value, scope)


def _plain(name: str, value: Any) -> bool | None:
    """Return whether a value has a built-in type given by name; None for names of other types."""
    checks: dict[str, Callable[[Any], bool]] = {
        "float": _is_number,
        "int": lambda x: _is_number(x) and isinstance(x, int | np.integer),
        "bool": lambda x: isinstance(x, bool | np.bool_),
        "str": lambda x: isinstance(x, str),
        "None": lambda x: x is None,
        "Path": lambda x: isinstance(x, str | os.PathLike),
        "PathLike": lambda x: isinstance(x, str | os.PathLike),
        "Callable": callable,
        "Mapping": lambda x: isinstance(x, Mapping),
        "dict": lambda x: isinstance(x, Mapping),
        **dict.fromkeys(NUMERIC, _is_numeric),
        **dict.fromkeys(("Any", "object"), lambda x: True),
    }
    return checks[name](value) if name in checks else None


def _is_number(value: Any) -> bool:
    number = isinstance(value, int | float | np.number) and not isinstance(value, bool)
    if isinstance(value, np.ndarray) and value.ndim == 0:
        number = value.dtype.kind in "iuf"
    return bool(number and np.isfinite(value))


def _is_numeric(value: Any) -> bool:
    try:
        array = np.asarray(value)
        return bool(array.dtype.kind in "biufc" and np.isfinite(array).all())
    except (TypeError, ValueError):
        return False


def _belongs(name: str, value: Any, scope: Scope) -> bool:
    """Return whether a value has the class or alias of that name in the module of the function."""
    if name in scope or hasattr(builtins, name):
        return _is_of(scope[name] if name in scope else getattr(builtins, name), value)
    if "jousto" in sys.modules and _is_public(name):  # imported for annotations only
        return any(base.__name__ == name for base in type(value).__mro__)
    return True


def _is_public(name: str) -> bool:
    return any(place.endswith(f".{name}") for place in public_names())


def _is_of(kind: Any, value: Any) -> bool:
    origin = typing.get_origin(kind)
    if origin in (UnionType, typing.Union):
        return any(_is_of(part, value) for part in typing.get_args(kind))
    if origin is typing.Literal:
        return value in typing.get_args(kind)
    if kind is None or kind is type(None):
        return value is None
    found = origin or kind
    if not isinstance(found, type):
        return True
    if getattr(found, "_is_protocol", False):
        wanted = [key for key in vars(found) if not key.startswith("_")]
        return all(hasattr(value, key) for key in [*wanted, *found.__annotations__])
    plain = _plain(found.__name__, value)
    return isinstance(value, found) if plain is None else plain


def _wanted(kind: ast.expr) -> str:
    """Return the text by which messages describe an annotated type."""
    texts: list[str] = []
    for part in _union(kind):
        name = _name(part)
        if name in NUMERIC:
            text = "finite numbers"
        elif name in SEVERAL:
            inside = {_name(one) for one in _inside(part)}
            text = "texts" if "str" in inside else f"a sequence of {' or '.join(sorted(inside))}"
            text = text.removesuffix(" of ")
        elif name in ("Mapping", "dict"):
            text = "a dictionary"
        elif name == "Literal":
            text = " or ".join(ast.unparse(one) for one in _inside(part))
        else:
            text = WORDS.get(name, f"a {name}" if name[:1] not in "AEIOS" else f"an {name}")
            if name[:1] == "S" and name != "SN":
                text = f"a {name}"
        if text not in texts:
            texts.append(text)
    how = [HOW[name] for part in _union(kind) if (name := _name(part)) in HOW]
    return " or ".join(texts) + (f": {', '.join(how)}" if how else "")
