"""One declaration a kind: a class names its fields; everything else about them follows.

A class that derives from `Declared` lists its fields, each with its meaning, unit, limits and
default::

    class Rod(Joint, tag="rod"):
        '''The origins keep their distance, ``|r_b - r_a| = L``.'''

        length: OptionalNumber = field("Distance L", unit="m", above=0, default=None)

From that come the constructor with its checks, the parameters in its help, its entry in model files
with units, the JSON schema, its row in the documentation, and its place in the register of its
section. What a field reads and shows is the type behind it: ``rod.length`` is a float or None.
"""

from __future__ import annotations

import dataclasses
import importlib
import inspect
import pkgutil
import sys
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, Generic, TypeVar, dataclass_transform, overload

from jousto.base.described import describe
from jousto.base.errors import Problems
from jousto.base.names import check_name
from jousto.base.numbers import number

In = TypeVar("In")
Out = TypeVar("Out")

MISSING: Any = dataclasses.MISSING


def field(text: str = "", *, default: Any = MISSING, kw_only: bool = False, **facts: Any) -> Any:
    """Return what a class says of a field; the annotation beside it says of which type it is.

    Parameters
    ----------
    text : str
        What it means, for help, pages and editors.
    default : object, optional
        Value where none is given; without one the field must be given.
    kw_only : bool
        Whether it is given by name only.
    **facts
        Arguments of the type: unit, limits.
    """
    return _Facts(text, default, kw_only, facts)


@dataclasses.dataclass(frozen=True)
class _Facts:
    text: str
    default: Any
    kw_only: bool
    facts: dict[str, Any]


class Field(Generic[In, Out]):
    """One field of a declared class: takes values of type In, keeps them as type Out.

    Parameters
    ----------
    text, default, kw_only
        As for `field`.
    unit : str
        SI unit; empty where there is none.
    file : bool
        Whether model files may give it.
    """

    form: ClassVar[str] = ""
    """How model files write it; `jousto.schema` knows how to read each form."""
    noun: ClassVar[str] = ""
    """What it is called in help."""

    def __init__(
        self,
        text: str = "",
        *,
        default: Any = MISSING,
        kw_only: bool = False,
        unit: Any = "",
        file: bool = True,
    ) -> None:
        self.text = text
        self.file = file
        self.default = default
        self.kw_only = kw_only
        self.unit = unit
        self.name = ""

    def __repr__(self) -> str:
        unit = f", {self.unit}" if str(self.unit) not in ("", "1") else ""
        said = f"{self.text[:200]}{unit}"
        return f"<{type(self).__name__} {self.name!r}{said and f': {said}'}>"

    @overload
    def __get__(self, obj: None, owner: type) -> Any: ...
    @overload
    def __get__(self, obj: object, owner: type) -> Out: ...
    def __get__(self, obj: object | None, owner: type) -> Any:
        """Only for type checkers: the classes keep plain attributes."""
        raise AttributeError(self.name)

    def __set__(self, obj: Any, value: In) -> None:
        """Only for type checkers: declared objects do not change."""
        raise AttributeError(self.name)

    @property
    def required(self) -> bool:
        """Whether it must be given."""
        return self.default is MISSING

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the value as it is kept, or note what is wrong with it."""
        return value

    def line(self) -> str:
        """Return the head of its parameter in help, ``pitch : float, m``."""
        head = f"{self.name} : {self.noun}" + (", optional" if not self.required else "")
        return head


class Text(Field[str, str]):
    """A word or a sentence."""

    form = "text"
    noun = "str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a string that is not empty."""
        if not (isinstance(value, str) and value.strip()):
            problems.add(where, f"{self.name} is {value!r}, must be text")
        return value


class AnyField(Field[Any, Any]):
    """Anything."""


class OptionalText(Field["str | None", str]):
    """A word or a sentence, or None for one that the object finds itself."""

    form = "text"
    noun = "str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a string."""
        if not isinstance(value, str):
            problems.add(where, f"{self.name} is {value!r}, must be a string or None")
        return value


class Name(Field[str, str]):
    """The name of the object; it was checked before all other fields."""

    form = "text"
    noun = "str"


class Flag(Field[bool, bool]):
    """True or False."""

    form = "flag"
    noun = "bool"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the truth as a bool of Python."""
        if type(value).__name__ not in ("bool", "bool_"):
            problems.add(where, f"{self.name} is {value!r}, must be True or False")
            return None
        return bool(value)


class _Numeric(Field[In, Out]):
    """What numbers share: limits.

    Parameters
    ----------
    text, unit, default, kw_only
        As for every field.
    least : float, optional
        Smallest value.
    above : float, optional
        What the value must be larger than.
    nonzero : bool
        Whether 0 is wrong.
    remedy : str
        What to do where the limits are broken.
    """

    form = "number"
    noun = "float"

    def __init__(
        self,
        text: str = "",
        *,
        unit: Any = "1",
        least: float | None = None,
        above: float | None = None,
        nonzero: bool = False,
        remedy: str = "",
        **common: Any,
    ) -> None:
        super().__init__(text, unit=unit, **common)
        self.least = least
        self.above = above
        self.nonzero = nonzero
        self.remedy = f"; {remedy}" if remedy else ""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a finite float within the limits."""
        found = number(problems, where, self.name, value)
        if found is None:
            return None
        wanted = ""
        if self.above is not None and not found > self.above:
            wanted = "must be positive" if self.above == 0 else f"must be above {self.above:g}"
        elif self.least is not None and not found >= self.least:
            wanted = (
                "must not be negative" if self.least == 0 else f"must be {self.least:g} or more"
            )
        elif self.nonzero and found == 0.0:
            wanted = "must not be zero"
        if wanted:
            unit = f" {self.unit}" if isinstance(self.unit, str) and self.unit != "1" else ""
            problems.add(where, f"{self.name} is {found:g}{unit}, {wanted}{self.remedy}")
        return found


class Number(_Numeric[float, float]):
    """A finite number."""


class OptionalNumber(_Numeric["float | None", "float | None"]):
    """A finite number, or None."""


class Numbers(Field["float | Iterable[float]", "tuple[float, ...]"]):
    """Numbers, or a single one; none is zero."""

    form = "numbers"
    noun = "float or sequence of float"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return them as a tuple."""
        found = []
        for i, x in enumerate(value if isinstance(value, Iterable) else (value,)):
            found.append(number(problems, where, f"{self.name}[{i}]", x))
            if found[-1] == 0.0:
                problems.add(where, f"{self.name}[{i}] is 0, must not be zero")
        return tuple(found)


class Choice(Field[str, str]):
    """One of a few words.

    Parameters
    ----------
    text, default, kw_only
        As for every field.
    words : tuple of str
        The words.
    """

    form = "choice"

    def __init__(self, text: str = "", *, words: tuple[str, ...], **common: Any) -> None:
        super().__init__(text, **common)
        self.words = words

    @property
    def noun(self) -> str:  # type: ignore[override]
        """The words."""
        return "{" + ", ".join(f'"{word}"' for word in self.words) + "}"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return one of the words."""
        if value not in self.words:
            *some, last = (repr(word) for word in self.words)
            problems.add(where, f"{self.name} is {value!r}, must be {', '.join(some)} or {last}")
        return value


SECTIONS: dict[str, dict[str, type[Declared]]] = {}
"""Classes by their word ``type`` in each section of a model file."""
ROOMS: dict[str, str] = {}
"""The package whose modules declare the classes of a section."""


@dataclass_transform(field_specifiers=(field,))
class Declared:
    """Base of every class that is declared by its fields.

    Subclasses are made with ``class Kind(Base, tag="kind")``: the word of `tag` names them in model
    files. A base of several kinds says ``section="joints"`` instead.
    """

    kind: ClassVar[str] = ""
    """What it is called in messages, before its name: ``joint 'hinge'``."""
    tag: ClassVar[str] = ""
    section: ClassVar[str] = ""
    fields: ClassVar[Mapping[str, Field[Any, Any]]] = {}

    def __init_subclass__(cls, *, tag: str = "", section: str = "", **options: Any) -> None:
        super().__init_subclass__(**options)
        said = {key: value for key, value in vars(cls).items() if isinstance(value, _Facts)}
        here = sys._getframe(1)  # where the class is written: its annotations mean names of there
        types = inspect.get_annotations(
            cls, globals=here.f_globals, locals=here.f_locals, eval_str=bool(said)
        )
        own: dict[str, Field[Any, Any]] = {}
        for key, facts in said.items():
            made: Field[Any, Any] = types[key](
                facts.text, default=facts.default, kw_only=facts.kw_only, **facts.facts
            )
            made.name = key
            own[key] = made
            keep = {} if made.required else {"default": facts.default}
            setattr(cls, key, dataclasses.field(kw_only=facts.kw_only, **keep))
        inherited = [vars(base).get("fields", {}) for base in reversed(cls.__mro__[1:])]
        cls.fields = {key: kind for some in (*inherited, own) for key, kind in some.items()}
        cls.__annotations__ = {key: types[key] for key in own}
        dataclasses.dataclass(frozen=True, eq=False, repr=False)(cls)
        for key in own:  # defaults live in the constructor alone
            if key in vars(cls):
                delattr(cls, key)
        if section:
            cls.section = section
            SECTIONS[section] = {}
            ROOMS[section] = cls.__module__.rpartition(".")[0]
        cls.tag = tag
        if tag:
            SECTIONS[cls.section][tag] = cls
            document(cls)

    def __post_init__(self) -> None:
        problems = Problems()
        where = self.place(problems)
        for key, field in self.fields.items():
            value = getattr(self, key)
            if value is None and field.default is None:
                continue
            object.__setattr__(self, key, field.check(problems, where, value))
        if not problems.found:
            self.consistent(problems, where)
        problems.raise_if_any()

    def place(self, problems: Problems) -> str:
        """Return what messages say first, ``joint 'hinge'``; note what is wrong with the name."""
        if "name" not in self.fields:
            return self.kind or type(self).__name__
        return check_name(problems, self.kind, getattr(self, "name", None))

    def consistent(self, problems: Problems, where: str) -> None:
        """Note what is wrong between fields that are right by themselves."""

    def __repr__(self) -> str:
        return describe(self)


def document(cls: type[Declared]) -> None:
    """Append the parameters of a class to its help."""
    text = inspect.getdoc(cls) or ""
    if "Parameters\n---" in text:
        return
    rows = []
    for field in cls.fields.values():
        rows.append(field.line())
        unit = f", {field.unit}" if str(field.unit) not in ("", "1") else ""
        rows.append(f"    {field.text}{unit}.")
    cls.__doc__ = "\n".join([text, "", "Parameters", "----------", *rows])


def kinds(section: str, room: str) -> dict[str, type[Declared]]:
    """Return the classes of a section by their word, from every module of a room.

    Parameters
    ----------
    section : str
        Such as ``"joints"``.
    room : str
        The package whose modules declare them, ``"jousto.mechanism.joints"``.
    """
    package = importlib.import_module(room)
    for module in pkgutil.iter_modules(package.__path__):
        importlib.import_module(f"{room}.{module.name}")
    return SECTIONS[section]
