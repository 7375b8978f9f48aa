"""What fields of declared classes are: words, numbers, arrays, references and objects.

A field takes what a user gives, checks it against its limits and keeps it as one type: the first
type in its brackets is what it takes, the second what it keeps.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any, ClassVar, Generic, Literal, TypeVar, get_args, overload

from jousto.base.errors import Problem, Problems

In = TypeVar("In")
Out = TypeVar("Out")
T = TypeVar("T")

MISSING: Any = dataclasses.MISSING


def field(
    text: str = "",
    *,
    default: Any = MISSING,
    kw_only: bool = False,
    compare: bool = True,
    **facts: Any,
) -> Any:
    """Return what a class says of a field; the annotation beside it says of which type it is.

    Parameters
    ----------
    text : str
        What it means, for help, pages and editors.
    default : object, optional
        Value where none is given; without one the field must be given.
    kw_only : bool
        Whether it is given by name only.
    compare : bool
        Whether objects that differ in it alone are different, where a class compares values.
    **facts
        Arguments of the type: unit, limits.
    """
    return Facts(text, default, kw_only, compare, facts)


def kept(*, init: Literal[False] = False) -> Any:
    """Mark an attribute that the object computes from its fields when it is made."""
    return MISSING


@dataclasses.dataclass(frozen=True)
class Facts:
    """What `field` was given, until the class makes the field of it."""

    text: str
    default: Any
    kw_only: bool
    compare: bool
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
    key : str
        What model files call it; its name if empty.
    label : str
        What messages call it; its name if empty.
    wanted : str
        What a value must be, in messages.
    plain : bool
        Whether messages show the value as it was given, without its unit.
    """

    form: str = ""
    """How model files write it; `jousto.schema` knows how to read each form."""
    noun: str = ""
    """What it is called in help."""
    optional: ClassVar[bool] = False
    """Whether None is a value, also where it is not the default."""
    checks_none: ClassVar[bool] = False
    """Whether None stands for a value, which `check` returns."""
    spread: ClassVar[bool] = False
    """Whether the constructor takes its items one after the other, ``Sum(a, b, c)``."""

    def __init__(
        self,
        text: str = "",
        *,
        default: Any = MISSING,
        kw_only: bool = False,
        unit: Any = "",
        file: bool = True,
        key: str = "",
        label: str = "",
        wanted: str = "",
        plain: bool = False,
    ) -> None:
        self.text = text
        self.file = file
        self.key = key
        self.default = default
        self.default_kept: Any = MISSING
        self.kw_only = kw_only
        self.unit = unit
        self.label = label
        self.wanted = wanted
        self.plain = plain
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

    def located(self, problem: Problem) -> Problem:
        """Return a problem that `check` noted, at the path that begins with this field."""
        inside = problem.path[1:] if problem.path[:1] == (self.label,) else problem.path
        return dataclasses.replace(problem, path=(self.key, *inside))

    @property
    def annotation(self) -> str:
        """What signatures say of it."""
        said = self.noun if self.noun.isidentifier() else "Any"
        return f"{said} | None" if self.optional or self.default is None else said

    def line(self) -> str:
        """Return the head of its parameter in help, ``pitch : float, m``."""
        star, optional = "*" * self.spread, "" if self.required else ", optional"
        return f"{star}{self.name} : {self.noun}{optional}"


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
    """Anything; what it must be is checked with the other fields, in `consistent`.

    Parameters
    ----------
    text, unit, default, kw_only
        As for every field.
    form, noun : str
        How model files write it, and what it is called in help.
    shapes : tuple of tuple
        Shapes of arrays that it may be, None for any length.
    """

    def __init__(
        self,
        text: str = "",
        *,
        form: str = "",
        noun: str = "",
        shapes: tuple[tuple[int | None, ...], ...] = (),
        **common: Any,
    ) -> None:
        super().__init__(text, **common)
        self.form, self.noun, self.shapes = form, noun, shapes


class OptionalText(Field["str | None", str]):
    """A word or a sentence, or None for one that the object finds itself."""

    form = "text"
    noun = "str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a string."""
        if not isinstance(value, str):
            problems.add(where, f"{self.name} is {value!r}, must be a string or None")
        return value


class Label(Field[str, str]):
    """A text for tables and messages; it may be empty."""

    form = "text"
    noun = "str"


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


class Texts(Field["Iterable[str]", "tuple[str, ...]"]):
    """Words."""

    form = "texts"
    noun = "sequence of str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return them as a tuple."""
        found = () if isinstance(value, str) or not isinstance(value, Iterable) else tuple(value)
        if not found or not all(isinstance(word, str) for word in found):
            wanted = self.wanted or "must be a list of words"
            problems.add(where, f"{self.label} is {value!r}, {wanted}")
        return found


class Reference(Field[In, Out]):
    """Another object, which a model file calls by its name.

    Attributes
    ----------
    section : str or tuple of str
        The section of a model file that declares it, or several.
    word : str
        What messages call it.
    """

    form = "reference"
    section: ClassVar[str | tuple[str, ...]] = ""
    word: ClassVar[str] = ""


class Nested(Field[In, Out]):
    """An object that belongs to this one; a model file declares it inside, by its ``type``.

    Attributes
    ----------
    section, room : str
        Its register, and the package that declares its classes.
    """

    form = "nested"
    section: ClassVar[str] = ""
    room: ClassVar[str] = ""


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
    def annotation(self) -> str:
        """The words."""
        return f"Literal[{', '.join(map(repr, self.words))}]"

    @property
    def noun(self) -> str:  # type: ignore[override]
        """The words."""
        return "{" + ", ".join(f'"{word}"' for word in self.words) + "}"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return one of the words."""
        if value not in self.words:
            *some, last = (repr(word) for word in self.words)
            wanted = self.wanted or f"{', '.join(some)} or {last}"
            problems.add(where, f"{self.label} is {value!r}, must be {wanted}")
        return value


class _Of(Field[In, Out]):
    @property
    def of(self) -> type[Any]:
        """The declared class."""
        found: type[Any] = get_args(vars(self)["__orig_class__"])[0]
        return found


class Item(_Of[T, T]):
    """An object of a declared class; a model file writes a mapping with its keys."""

    form = "item"

    @property
    def noun(self) -> str:  # type: ignore[override]
        """The class."""
        return self.of.__name__

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return an object of the class."""
        if not isinstance(value, self.of):
            problems.add(where, f"{self.label} is {value!r}, must be {self.wanted or self.noun}")
        return value


class OptionalItem(Item[T | None], Generic[T]):
    """An object of a declared class, or None."""


class Items(_Of[Iterable[T], tuple[T, ...]]):
    """Objects of a declared class; a model file writes a list of mappings."""

    form = "items"

    @property
    def noun(self) -> str:  # type: ignore[override]
        """What they are."""
        return f"sequence of {self.of.__name__}"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return them as a tuple."""
        return problems.several(where, self.label, value, self.of)
