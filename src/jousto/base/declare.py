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
import functools
import importlib
import inspect
import numbers
import pkgutil
import re
import sys
from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, Generic, TypeVar, dataclass_transform, get_args, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.described import describe
from jousto.base.errors import Problems
from jousto.base.names import check_name
from jousto.base.numbers import number

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
    return _Facts(text, default, kw_only, compare, facts)


@dataclasses.dataclass(frozen=True)
class _Facts:
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
    label : str
        What messages call it; its name if empty.
    wanted : str
        What a value must be, in messages.
    plain : bool
        Whether messages show the value as it was given, without its unit.
    """

    form: ClassVar[str] = ""
    """How model files write it; `jousto.schema` knows how to read each form."""
    noun: ClassVar[str] = ""
    """What it is called in help."""
    optional: ClassVar[bool] = False
    """Whether None is a value, also where it is not the default."""
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
        label: str = "",
        wanted: str = "",
        plain: bool = False,
    ) -> None:
        self.text = text
        self.file = file
        self.default = default
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
    most : float, optional
        Largest value.
    below : float, optional
        What the value must be smaller than.
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
        most: float | None = None,
        below: float | None = None,
        nonzero: bool = False,
        remedy: str = "",
        **common: Any,
    ) -> None:
        super().__init__(text, unit=unit, **common)
        self.least = least
        self.above = above
        self.most = most
        self.below = below
        self.nonzero = nonzero
        self.remedy = f"; {remedy}" if remedy else ""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a finite float within the limits."""
        unit = self.unit if isinstance(self.unit, str) and self.unit != "1" else ""
        if self.wanted and not self.plain:
            wanted = self.wanted
            good = problems.number(
                where, self.label, value, unit, wanted, lambda x: not self.missed(x)
            )
            return float(value) if good else None
        if self.wanted:
            found = None if isinstance(value, bool) else number(Problems(), "", "", value)
            if found is None or self.missed(found):
                problems.add(where, f"{self.label} is {value!r}, must be {self.wanted}")
            return found
        found = number(problems, where, self.label, value)
        if found is not None and (missed := self.missed(found)):
            shown = f"{found:g} {unit}".rstrip()
            problems.add(where, f"{self.label} is {shown}, {missed}{self.remedy}")
        return found

    def missed(self, x: float) -> str:
        """Return which limit a number misses, empty if none."""
        if self.above is not None and not x > self.above:
            return "must be positive" if self.above == 0 else f"must be above {self.above:g}"
        if self.least is not None and not x >= self.least:
            return "must not be negative" if self.least == 0 else f"must be {self.least:g} or more"
        if self.most is not None and not x <= self.most:
            return f"must be {self.most:g} or less"
        if self.below is not None and not x < self.below:
            return f"must be below {self.below:g}"
        return "must not be zero" if self.nonzero and x == 0.0 else ""


class Number(_Numeric[float, float]):
    """A finite number."""


class OptionalNumber(_Numeric["float | None", "float | None"]):
    """A finite number, or None."""

    optional = True


class DefaultNumber(_Numeric["float | None", float]):
    """A finite number, or None for one that the object finds itself."""


class _Seconds(_Numeric[In, Out]):
    form = "duration"
    wish = "a positive number of seconds"

    def __init__(self, text: str = "", **common: Any) -> None:
        super().__init__(text, unit="s", above=0, wanted=self.wish, plain=True, **common)


class Duration(_Seconds[float, float]):
    """A time above zero."""


class OptionalDuration(_Seconds["float | None", "float | None"]):
    """A time above zero, or None."""

    optional = True

    wish = "None or positive, s"


class OnlyPositive(_Numeric[In, Out]):
    """What numbers above zero share."""

    def __init__(self, text: str = "", **common: Any) -> None:
        super().__init__(text, above=0, wanted="a positive number", **common)


class Positive(OnlyPositive[float, float]):
    """A number above zero."""


class OptionalPositive(OnlyPositive["float | None", "float | None"]):
    """A number above zero, or None."""

    optional = True


class Whole(Field[int, int]):
    """A whole number.

    Parameters
    ----------
    text, default, kw_only
        As for every field.
    least, most : int
        Smallest and largest.
    """

    form = "count"
    noun = "int"

    def __init__(self, text: str = "", *, least: int, most: int, **common: Any) -> None:
        super().__init__(text, **common)
        self.least, self.most = least, most

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a whole number within the limits."""
        whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
        if not (whole and self.least <= value <= self.most):
            wanted = f"a whole number from {self.least} to {self.most}"
            problems.add(where, f"{self.label} is {value!r}, must be {wanted}")
            return None
        return int(value)


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


class Vector(Field[ArrayLike, NDArray[np.float64]]):
    """Three numbers."""

    form = "vector"
    noun = "(3,) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return them as a read-only array."""
        return problems.array(where, self.label, value, (3,))


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


class Item(Field[T, T]):
    """An object of a declared class; a model file writes a mapping with its keys."""

    form = "item"

    @property
    def of(self) -> type[Declared]:
        """The class."""
        found: type[Declared] = get_args(vars(self)["__orig_class__"])[0]
        return found

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


class Items(Field[Iterable[T], tuple[T, ...]]):
    """Objects of a declared class; a model file writes a list of mappings."""

    form = "items"

    @property
    def of(self) -> type[Declared]:
        """The class."""
        found: type[Declared] = get_args(vars(self)["__orig_class__"])[0]
        return found

    @property
    def noun(self) -> str:  # type: ignore[override]
        """What they are."""
        return f"sequence of {self.of.__name__}"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return them as a tuple."""
        return problems.several(where, self.label, value, self.of)


class Values(Field[ArrayLike, NDArray[np.float64]]):
    """An array of numbers.

    Parameters
    ----------
    text, unit, default, kw_only
        As for every field.
    shape : tuple
        Lengths along its axes, None for any.
    """

    form = "array"

    def __init__(self, text: str = "", *, shape: tuple[int | None, ...], **common: Any) -> None:
        super().__init__(text, **common)
        self.shape = shape

    @property
    def noun(self) -> str:  # type: ignore[override]
        """The shape."""
        sizes = ", ".join("n" if n is None else str(n) for n in self.shape)
        return f"({sizes}{',' * (len(self.shape) == 1)}) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a read-only array of this shape."""
        return problems.array(where, self.label, value, self.shape)


SECTIONS: dict[str, dict[str, type[Declared]]] = {}
"""Classes by their word ``type`` in each section of a model file."""


@dataclass_transform(field_specifiers=(field,))
class Declared:
    """Base of every class that is declared by its fields.

    Subclasses are made with ``class Kind(Base, tag="kind")``: the word of `tag` names them in model
    files. A base of several kinds says ``section="joints"`` instead. With ``by_value=True`` objects
    of equal fields are equal; with ``kw_only=True`` all fields of the class are given by name.
    """

    kind: ClassVar[str] = ""
    """What it is called in messages, before its name: ``joint 'hinge'``."""
    tag: ClassVar[str] = ""
    section: ClassVar[str] = ""
    by_value: ClassVar[bool] = False
    """Whether objects with equal fields are equal, and show as the call that makes them."""
    fields: ClassVar[Mapping[str, Field[Any, Any]]] = {}
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
        said = {key: value for key, value in vars(cls).items() if isinstance(value, _Facts)}
        here = sys._getframe(1)  # where the class is written: its annotations mean names of there
        while here.f_back and here.f_globals.get("__name__") == "abc":
            here = here.f_back
        types = inspect.get_annotations(
            cls, globals=here.f_globals, locals=here.f_locals, eval_str=bool(said)
        )
        own: dict[str, Field[Any, Any]] = {}
        for key, facts in said.items():
            made: Field[Any, Any] = types[key](
                facts.text, default=facts.default, kw_only=facts.kw_only, **facts.facts
            )
            made.name = key
            made.label = made.label or key
            own[key] = made
            keep = {} if made.required else {"default": facts.default}
            by_name = facts.kw_only or kw_only
            setattr(cls, key, dataclasses.field(kw_only=by_name, compare=facts.compare, **keep))
        inherited = [vars(base).get("fields", {}) for base in reversed(cls.__mro__[1:])]
        cls.fields = {key: kind for some in (*inherited, own) for key, kind in some.items()}
        # dataclasses look words up in the module, which code that is only executed has not
        words = cls.__module__ in sys.modules
        cls.__annotations__ = {key: made.annotation if words else Any for key, made in own.items()}
        own_repr = "__repr__" in vars(cls)
        shown = cls.by_value and not own_repr
        dataclasses.dataclass(frozen=True, eq=cls.by_value, repr=shown)(cls)
        for key in own:  # defaults live in the constructor alone
            if key in vars(cls):
                delattr(cls, key)
        if section:
            cls.section = section
            SECTIONS.setdefault(section, {})
        cls.tag = tag
        if tag:
            SECTIONS[cls.section][tag] = cls
        document(cls)

    def __post_init__(self) -> None:
        problems = Problems()
        where = self.place(problems)
        wrong = {"name"} if problems.found else set()
        for key, field in self.fields.items():
            value = getattr(self, key)
            if value is None and (field.optional or field.default is None):
                continue
            before = len(problems.found)
            object.__setattr__(self, key, field.check(problems, where, value))
            if len(problems.found) > before:
                wrong.add(key)
        if wrong.isdisjoint(self.together or self.fields):
            self.consistent(problems, where)
        problems.raise_if_any()

    def place(self, problems: Problems) -> str:
        """Return what messages say first, ``joint 'hinge'``; note what is wrong with the name."""
        kind = self.kind or type(self).__name__
        name = getattr(self, "name", "") if "name" in self.fields else ""
        if isinstance(self.fields.get("name"), Name):
            return check_name(problems, kind, name)
        return f"{kind} '{name}'" if name else kind

    def consistent(self, problems: Problems, where: str) -> None:
        """Note what is wrong between fields that are right by themselves."""

    def __repr__(self) -> str:
        return describe(self)


def document(cls: type[Declared]) -> None:
    """Append the parameters of a class to its help."""
    text = inspect.cleandoc(vars(cls).get("__doc__") or "")
    if "Parameters\n---" in text or not cls.fields:
        return
    rows = []
    for field in cls.fields.values():
        rows.append(field.line())
        unit = f", {field.unit}" if str(field.unit) not in ("", "1") else ""
        rows.append(f"    {field.text}{unit}.")
    head, *rest = re.split(
        r"\n\n(?=(?:Attributes|Raises|Warns|See Also|Notes|Examples)\n---)", text
    )
    parameters = "\n".join(["Parameters", "----------", *rows])
    cls.__doc__ = "\n\n".join([head, parameters, *rest])


def kinds(section: str, room: str) -> dict[str, type[Declared]]:
    """Return the classes of a section by their word, from every module of a room.

    Parameters
    ----------
    section : str
        Such as ``"joints"``.
    room : str
        The package whose modules declare them, ``"jousto.mechanism.joints"``, or a module.
    """
    _load(room)
    return SECTIONS[section]


@functools.cache
def _load(room: str) -> None:
    """Import every module of a room, which puts its classes into their register."""
    package = importlib.import_module(room)
    for module in pkgutil.iter_modules(getattr(package, "__path__", ())):
        importlib.import_module(f"{room}.{module.name}")
