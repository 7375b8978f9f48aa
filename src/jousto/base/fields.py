"""Fields of declared classes: texts, flags, references, choices and nested objects.

A field accepts the value of a user, checks it, and stores it as one type: ``Field[In, Out]``
accepts In and stores Out.
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
    """Return the declaration of a field; the annotation beside it gives the type.

    Parameters
    ----------
    text : str
        Meaning of the field, for help, pages and editors.
    default : object, optional
        Default value; a field without one must be given.
    kw_only : bool
        Whether it is given by name only.
    compare : bool
        Whether the field takes part in comparisons, for classes whose objects are compared by
        value.
    **facts
        Arguments of the type: unit, limits.
    """
    return Facts(text, default, kw_only, compare, facts)


def kept(*, init: Literal[False] = False) -> Any:
    """Declare an attribute that is computed from the fields when the object is created."""
    return MISSING


@dataclasses.dataclass(frozen=True)
class Facts:
    """Arguments of `field`, until the class creates the field."""

    text: str
    default: Any
    kw_only: bool
    compare: bool
    facts: dict[str, Any]


class Field(Generic[In, Out]):
    """Field of a declared class: accepts values of type In, stores them as type Out.

    Parameters
    ----------
    text, default, kw_only
        As for `field`.
    unit : str
        SI unit; empty where there is none.
    file : bool
        Whether model files may contain the field.
    key : str
        Key in model files; the name of the field if empty.
    label : str
        Name in messages; the name of the field if empty.
    wanted : str
        Description of valid values, for messages.
    plain : bool
        Whether messages show the value exactly as given, without a unit.
    """

    form: str = ""
    """How model files write it; `jousto.schema` knows how to read each form."""
    noun: str = ""
    """Name in help texts."""
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
        self.compare = True

    def __repr__(self) -> str:
        unit = f", {self.unit}" if str(self.unit) not in ("", "1") else ""
        message = f"{self.text[:200]}{unit}"
        return f"<{type(self).__name__} {self.name!r}{message and f': {message}'}>"

    @overload
    def __get__(self, obj: None, owner: type) -> Any: ...
    @overload
    def __get__(self, obj: object, owner: type) -> Out: ...
    def __get__(self, obj: object | None, owner: type) -> Any:
        """For type checkers only: the objects have plain attributes."""
        raise AttributeError(self.name)

    def __set__(self, obj: Any, value: In) -> None:
        """For type checkers only: declared objects cannot be changed."""
        raise AttributeError(self.name)

    @property
    def required(self) -> bool:
        """Whether the field has no default."""
        return self.default is MISSING

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the value to store, or report what is wrong with it."""
        return value

    def located(self, problem: Problem) -> Problem:
        """Return a problem found by `check`, with the path that begins with this field."""
        inside = problem.path[1:] if problem.path[:1] == (self.label,) else problem.path
        return dataclasses.replace(problem, path=(self.key, *inside))

    @property
    def annotation(self) -> str:
        """Type of the field in signatures."""
        name = self.noun if self.noun.isidentifier() else "Any"
        return f"{name} | None" if self.optional or self.default is None else name

    def line(self) -> str:
        """Return the first line of the parameter in the docstring, ``pitch : float, m``."""
        star, optional = "*" * self.spread, "" if self.required else ", optional"
        return f"{star}{self.name} : {self.noun}{optional}"


class Text(Field[str, str]):
    """Field of a text that is not empty."""

    form = "text"
    noun = "str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the text, or report one that is empty or no string."""
        if not (isinstance(value, str) and value.strip()):
            problems.add(where, f"{self.name} is {value!r}, must be text")
        return value


class AnyField(Field[Any, Any]):
    """Field of any value, which `consistent` checks together with the other fields.

    Parameters
    ----------
    text, unit, default, kw_only
        As for every field.
    form, noun : str
        Form of the value in model files, and noun for it in help.
    shapes : tuple of tuple
        Allowed shapes of an array, with None for any length.
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
    """Field of a text; None for a text that the object determines itself."""

    form = "text"
    noun = "str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the text, or report a value of another type."""
        if not isinstance(value, str):
            problems.add(where, f"{self.name} is {value!r}, must be a string or None")
        return value


class Label(Field[str, str]):
    """Field of a text for tables and messages, which may be empty."""

    form = "text"
    noun = "str"


class Name(Field[str, str]):
    """Field of the object's name, which is checked before all other fields."""

    form = "text"
    noun = "str"


class Flag(Field[bool, bool]):
    """Field of a boolean."""

    form = "flag"
    noun = "bool"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a Python bool, or report that the value is no boolean."""
        if type(value).__name__ not in ("bool", "bool_"):
            problems.add(where, f"{self.name} is {value!r}, must be True or False")
            return None
        return bool(value)


class Texts(Field["Iterable[str]", "tuple[str, ...]"]):
    """Field of several texts."""

    form = "texts"
    noun = "sequence of str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the values as a tuple, or report wrong ones."""
        found = () if isinstance(value, str) or not isinstance(value, Iterable) else tuple(value)
        if not found or not all(isinstance(word, str) for word in found):
            wanted = self.wanted or "must be a list of words"
            problems.add(where, f"{self.label} is {value!r}, {wanted}")
        return found


class Reference(Field[In, Out]):
    """Field of another object; a model file contains its name.

    Attributes
    ----------
    section : str or tuple of str
        The section of a model file that declares it, or several.
    word : str
        Noun for the object in messages.
    """

    form = "reference"
    section: ClassVar[str | tuple[str, ...]] = ""
    word: ClassVar[str] = ""


class Nested(Field[In, Out]):
    """Field of an object that a model file declares inside this one, by its ``type``.

    Attributes
    ----------
    section, room : str
        Section in which the classes are registered, and the package that declares them.
    """

    form = "nested"
    section: ClassVar[str] = ""
    room: ClassVar[str] = ""


class Choice(Field[str, str]):
    """Field of one of a few allowed texts.

    Parameters
    ----------
    text, default, kw_only
        As for every field.
    words : tuple of str
        The allowed texts, as a type in signatures.
    """

    form = "choice"

    def __init__(self, text: str = "", *, words: tuple[str, ...], **common: Any) -> None:
        super().__init__(text, **common)
        self.words = words

    @property
    def annotation(self) -> str:
        """The allowed texts as a type, for signatures."""
        return f"Literal[{', '.join(map(repr, self.words))}]"

    @property
    def noun(self) -> str:  # type: ignore[override]
        """The allowed texts as a noun, for messages."""
        return "{" + ", ".join(f'"{word}"' for word in self.words) + "}"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the value if it is an allowed text, or report it."""
        if value not in self.words:
            *some, last = (repr(word) for word in self.words)
            wanted = self.wanted or f"{', '.join(some)} or {last}"
            problems.add(where, f"{self.label} is {value!r}, must be {wanted}")
        return value


class _Of(Field[In, Out]):
    @property
    def of(self) -> type[Any]:
        """The declared class of the objects."""
        found: type[Any] = get_args(vars(self)["__orig_class__"])[0]
        return found


class Item(_Of[T, T]):
    """Field of an object of a declared class; a model file contains a mapping with its keys."""

    form = "item"

    @property
    def noun(self) -> str:  # type: ignore[override]
        """Name of the class, for messages and signatures."""
        return self.of.__name__

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the object, or report a value that is not an object of the class."""
        if not isinstance(value, self.of):
            problems.add(where, f"{self.label} is {value!r}, must be {self.wanted or self.noun}")
        return value


class OptionalItem(Item[T | None], Generic[T]):
    """Field of an object of a declared class, or None."""


class Items(_Of[Iterable[T], tuple[T, ...]]):
    """Field of objects of a declared class; a model file contains a list of mappings."""

    form = "items"

    @property
    def noun(self) -> str:  # type: ignore[override]
        """Noun for the objects, for messages and signatures."""
        return f"sequence of {self.of.__name__}"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the values as a tuple, or report wrong ones."""
        return problems.several(where, self.label, value, self.of)
