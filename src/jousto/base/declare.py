"""Declared classes: their fields define constructor, checks, model-file entry and help.

A class that derives from `Declared` lists its fields, each with its meaning, unit, limits and
default::

    class Rod(Joint, tag="rod"):
        '''The origins keep their distance, ``|r_b - r_a| = L``.'''

        length: OptionalNumber = field("Distance L", unit="m", above=0, default=None)

From this declaration follow the constructor with its checks, the parameters in its help, the entry
in model files with units, the JSON schema, the row in the documentation, and the registration in
its section. The type annotation determines which values a field accepts and which type it stores:
``rod.length`` is a float or None.
"""

from __future__ import annotations

import dataclasses
import functools
import importlib
import inspect
import pkgutil
import re
import sys
from collections.abc import Callable, Mapping
from typing import Any, ClassVar, ParamSpec, Protocol, TypeVar, dataclass_transform

from jousto.base.arguments import explained
from jousto.base.constructor import construct
from jousto.base.errors import Problems
from jousto.base.fields import MISSING, Facts, Field, Name, field, kept
from jousto.base.names import check_name
from jousto.base.object_repr import describe
from jousto.base.units import KINDS, check_unit

P = ParamSpec("P")
Out = TypeVar("Out", covariant=True)
Form = TypeVar("Form")

SECTIONS: dict[str, dict[str, type[Declared]]] = {}
"""Classes by their word ``type`` in each section of a model file."""


@dataclass_transform(eq_default=False, field_specifiers=(field, kept))
class Declared:
    """Base of all classes that are declared by their fields.

    Write a subclass as ``class Kind(Base, tag="kind")``; `tag` is its ``type`` in model files. A
    base of several kinds has ``section="joints"`` instead. With ``by_value=True`` objects with
    equal fields are equal; with ``kw_only=True`` all fields are keyword-only arguments.
    """

    kind: ClassVar[str] = ""
    """What it is called in messages, before its name: ``joint 'hinge'``."""
    tag: ClassVar[str] = ""
    register: ClassVar[str] = ""
    """The section of model files whose classes it belongs to."""
    by_value: ClassVar[bool] = False
    """Whether objects with equal fields are equal, and show as the call that makes them."""
    fields: ClassVar[Mapping[str, Field[Any, Any]]] = {}
    usage: ClassVar[str] = ""
    """What to call instead where arguments are of another number than the constructor takes."""
    spread: ClassVar[tuple[str, ...]] = ()
    """The fields whose items the constructor takes one after the other."""
    together: ClassVar[tuple[str, ...]] = ()
    """The fields that `consistent` needs, where it does not need all of them."""

    def __init_subclass__(
        cls,
        *,
        tag: str = "",
        section: str = "",
        by_value: bool | None = None,
        kw_only: bool = False,
        **options: Any,
    ) -> None:
        super().__init_subclass__(**options)
        if by_value is not None:
            cls.by_value = by_value
        declared = {key: value for key, value in vars(cls).items() if isinstance(value, Facts)}
        # frame of the class statement, in which the names of the annotations are defined
        here = sys._getframe(1)
        while here.f_back and here.f_globals.get("__name__") == "abc":
            here = here.f_back
        # dataclasses look up annotations in the module, which does not exist for code run by exec
        typed = cls.__module__ in sys.modules
        written = vars(cls).get("__annotations__", {})
        problems = Problems()
        own: dict[str, Field[Any, Any]] = {}
        for key, facts in declared.items():
            made: Field[Any, Any] = _type(written[key], here)(
                facts.text, default=facts.default, kw_only=facts.kw_only or kw_only, **facts.facts
            )
            made.name = key
            made.key = made.key or key
            made.label = made.label or key
            made.compare = facts.compare
            if made.file and isinstance(made.unit, str) and made.unit not in KINDS:
                check_unit(problems, f"{cls.__name__}.{key}", made.unit)
            own[key] = made
            delattr(cls, key)  # defaults belong to the constructor only
        problems.raise_if_any()
        for key in [key for key, value in vars(cls).items() if value is MISSING]:
            delattr(cls, key)
        inherited = [vars(base).get("fields", {}) for base in reversed(cls.__mro__[1:])]
        cls.fields = {key: kind for some in (*inherited, own) for key, kind in some.items()}
        cls.spread = tuple(key for key, kind in cls.fields.items() if kind.spread)
        cls.__annotations__ = {key: made.annotation if typed else Any for key, made in own.items()}
        construct(cls)
        if section:
            cls.register = section
            SECTIONS.setdefault(section, {})
        cls.tag = tag
        if tag:
            SECTIONS[cls.register][tag] = cls
        text = vars(cls).get("__doc__") or ""
        cls.__doc__ = _Docstring(text)  # type: ignore[assignment]

    def __post_init__(self) -> None:
        problems = Problems()
        where = self.heading(problems)
        wrong = {"name"} if problems.found else set()
        values, noted = vars(self), len(problems.found)
        for key, kind in self.fields.items():
            value = values[key]
            if value is None and not kind.checks_none and (kind.optional or kind.default is None):
                continue
            if value is not kind.default or kind.default_kept is MISSING:
                found = kind.check(problems, where, value)
                if len(problems.found) > noted:
                    wrong.add(key)
                    problems.found[noted:] = map(kind.located, problems.found[noted:])
                    noted = len(problems.found)
                elif value is kind.default:
                    kind.default_kept = found
            else:  # checked before
                found = kind.default_kept
            values[key] = found
        if wrong.isdisjoint(self.together or self.fields):
            self.consistent(problems, where)
        problems.raise_if_any()

    def heading(self, problems: Problems) -> str:
        """Return the prefix of messages, such as ``joint 'hinge'``; report an invalid name."""
        kind = self.kind or type(self).__name__
        name = getattr(self, "name", "") if "name" in self.fields else ""
        if isinstance(self.fields.get("name"), Name):
            return check_name(problems, kind, name)
        return f"{kind} '{name}'" if name else kind

    def consistent(self, problems: Problems, where: str) -> None:
        """Report contradictions between fields that are valid by themselves."""

    @property
    def made(self) -> Any:
        """Object built for a model-file entry of the class: itself, or the object it describes."""
        return self

    def __repr__(self) -> str:
        return describe(self)

    def __setattr__(self, name: str, value: Any) -> None:
        raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")

    def __delattr__(self, name: str) -> None:
        raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")


def _type(written: Any, here: Any) -> Any:
    """Return the type of a field from its annotation in the frame of the class statement."""
    if not isinstance(written, str):
        return written
    for names in (here.f_locals, here.f_globals):
        if written in names:
            return names[written]
    return eval(written, here.f_globals, here.f_locals)


class _Docstring:
    """Docstring of a declared class, to which its parameters are appended at the first use."""

    def __init__(self, text: str) -> None:
        self.text = text

    def __get__(self, obj: object, owner: type[Declared]) -> str:
        found = owner.__doc__ = with_parameters(self.text, owner)
        return found


def with_parameters(text: str, cls: type[Declared]) -> str:
    """Return the docstring of a class with its parameters."""
    text = inspect.cleandoc(text)
    if "Parameters\n---" in text or not cls.fields:
        return text
    rows = []
    for kind in sorted(cls.fields.values(), key=lambda kind: kind.kw_only):
        unit = f", {kind.unit}" if str(kind.unit) not in ("", "1") else ""
        rows += [kind.line(), f"    {kind.text}{unit}."]
    head, *rest = re.split(
        r"\n\n(?=(?:Attributes|Raises|Warns|See Also|Notes|Examples)\n---)", text
    )
    parameters = "\n".join(["Parameters", "----------", *rows])
    return "\n\n".join([head, parameters, *rest])


class Makes(Protocol[Out]):
    """Base of declared classes whose objects describe an object of another class."""

    @property
    def made(self) -> Out:
        """The described object."""


def maker(name: str, cls: Callable[P, Makes[Out]], returns: str = "") -> Callable[P, Out]:
    """Return the function that makes the object described by a declared class.

    Parameters
    ----------
    name : str
        Name by which users call it, such as ``"RigidBody.box"`` or ``"fat_class"``.
    cls : type
        The class; the function has its arguments and its help.
    returns : str
        Name of the returned class, if it is not the part of the name before the dot.
    """
    return made_by(name, cls, lambda form: form.made, returns)


def made_by(
    name: str, cls: Callable[P, Form], make: Callable[[Form], Out], returns: str = ""
) -> Callable[P, Out]:
    """Return the function that makes an object of another class from a declared object.

    Parameters
    ----------
    name, cls, returns
        As for `maker`.
    make : function
        Function that converts the declared object to the other object.
    """

    def call(*given: P.args, **named: P.kwargs) -> Out:
        return make(cls(*given, **named))

    call.__qualname__, call.__name__ = name, name.rpartition(".")[2]
    call.__module__ = cls.__module__
    call.__doc__ = (inspect.getdoc(cls) or "").replace("A ", "Return a ", 1)
    found = returns or name.partition(".")[0]
    signature = inspect.signature(cls).replace(return_annotation=found)
    call.__dict__["__signature__"] = signature
    return explained(call)


def kinds(section: str, room: str) -> dict[str, type[Declared]]:
    """Return the classes of a section by tag, from every module of a package.

    Parameters
    ----------
    section : str
        Name of the section, such as ``"joints"``.
    room : str
        The package whose modules declare them, ``"jousto.mechanism.joints"``, or a module.
    """
    _load(room)
    return SECTIONS[section]


@functools.cache
def _load(room: str) -> None:
    """Import every module of a package, which registers its classes."""
    package = importlib.import_module(room)
    for module in pkgutil.iter_modules(getattr(package, "__path__", ())):
        importlib.import_module(f"{room}.{module.name}")
