"""Entry types of declared classes, derived from their fields: one per `type` of a section."""

from __future__ import annotations

import functools
import importlib
import inspect
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Discriminator, Field as Key, Tag, create_model

from jousto.base.declare import SECTIONS, Declared, kinds
from jousto.base.fields import Field
from jousto.schema.entries.base import (
    Amount,
    Count,
    Direction,
    Duration as Seconds,
    Entry,
    Flag,
    Marker,
    Number,
    Orientation,
    Text,
    Unit,
    Vector,
)
from jousto.schema.entries.choices import Later, Tagged, later

Implied: TypeAlias = Callable[[dict[str, Any]], str | None] | None
Others: TypeAlias = Mapping[str, "type[Entry] | EntryBy"]
NO_OTHERS: Others = MappingProxyType({})

FORMS: dict[str, Callable[[Any], Any]] = {
    "text": lambda field: Text,
    "texts": lambda field: tuple[Text, ...],
    "reference": lambda field: Text,
    "references": lambda field: tuple[Text, ...],
    "flag": lambda field: Flag,
    "number": lambda field: amount(field.unit),
    "number or word": lambda field: number_or_word(field),
    "flag or choice": lambda field: flag_or_choice(field),
    "duration": lambda field: Seconds,
    "count": lambda field: Count,
    "numbers": lambda field: tuple[Number, ...],
    "series": lambda field: ROW[amount(field.unit), ...],
    "choice": lambda field: Literal[field.words],
    "vector": lambda field: vector(field.unit),
    "nested": lambda field: one_of(field.section, field.room),
    "several nested": lambda field: several(one_of(field.section, field.room)),
    "port": lambda field: Text,
    "direction": lambda field: Direction,
    "marker": lambda field: Marker,
    "markers": lambda field: ROW[Marker, ...],
    "item": lambda field: item(field),
    "event": lambda field: Text,
    "items": lambda field: several(item(field)),
    "array": lambda field: array(field.unit, field.shape),
    "orientation": lambda field: Orientation,
}
"""Pydantic type of each kind of field; files that declare other kinds add theirs."""

SPECIAL: dict[type[Declared], type[Entry]] = {}
"""Entries of the few classes whose form in files differs from their fields."""

# types composed at run time, which type checkers cannot follow
NOTED: Any = Annotated
ROW: Any = tuple


def amount(unit: Any) -> Any:
    """Return the type of a number; a unit that depends on other fields is checked with them."""
    if not isinstance(unit, str):
        return Amount
    return Annotated[float, Unit(unit.replace("^", ""))]


def number_or_word(field: Any) -> Any:
    """Return the type of a number in SI or the word of a field."""
    word = NOTED[Literal[field.word], Tag("word")]
    number = NOTED[amount(field.unit), Tag("number")]
    return NOTED[
        word | number, Discriminator(lambda value: "word" if value == field.word else "number")
    ]


def flag_or_choice(field: Any) -> Any:
    """Return the type of a flag or one of the words of a field."""
    word, flag = NOTED[Literal[field.words], Tag("word")], NOTED[Flag, Tag("flag")]
    return NOTED[
        word | flag, Discriminator(lambda value: "word" if isinstance(value, str) else "flag")
    ]


def vector(unit: Any) -> Any:
    """Return the type of three numbers."""
    one = amount(unit)
    return NOTED[ROW[one, one, one], Vector(3)]


def item(field: Any) -> Any:
    """Return the entry of a field's class."""
    return entry_of(field.of)


def array(unit: str, shape: tuple[int | None, ...]) -> Any:
    """Return the type of an array: nested lists."""
    item: Any = amount(unit or "1")
    for n in reversed(shape):
        row: Any = (item,) * (n or 0)
        item = several(item) if n is None else NOTED[ROW[row], Vector(n)]
    return item


def several(item: Any) -> Any:
    """Return the type of a list."""
    return ROW[item, ...]


@functools.cache
def entry_of(
    cls: type[Declared],
    implied: bool = False,
    without: tuple[str, ...] = (),
    base: type[Entry] = Entry,
) -> Any:
    """Return the entry type of a class: its tag in ``type``, and a key for each field.

    Parameters
    ----------
    cls : type
    implied : bool
        Whether the key ``type`` is optional.
    without : tuple of str
        Fields with another form in files.
    base : type
        Base entry with further keys.
    """
    if cls in SPECIAL:
        return SPECIAL[cls]
    word = (Literal[cls.tag], cls.tag if implied else ...)
    keys: dict[str, Any] = {"type": word} if cls.tag else {}
    keys |= keys_of(cls, without)
    return _entry(cls, keys, base)


def _entry(cls: type[Declared], keys: dict[str, Any], base: type[Entry]) -> Any:
    """Return the entry of a class with given keys."""
    made: Any = create_model(f"{cls.__name__}Entry", __base__=base, **keys)
    made.__doc__ = f"`{cls.__name__}`: {(inspect.getdoc(cls) or '').partition(chr(10))[0]}"
    made.declared = cls
    return made


def keys_of(
    cls: type[Declared], without: tuple[str, ...] = (), optional: tuple[str, ...] = ()
) -> dict[str, Any]:
    """Return the keys of a class's fields; optional fields may be missing in files."""
    keys: dict[str, Any] = {}
    for field in cls.fields.values():
        if not field.file or field.name in without:
            continue
        form = FORMS[field.form](field)
        if field.required and field.name not in optional:
            keys[field.key] = (form, Key(description=said(field)))
        else:
            keys[field.key] = (form | None, Key(None, description=said(field)))
    return keys


def special(cls: Any, word: str, *, implied: bool = False, base: Any = Entry, **keys: Any) -> Any:
    """Return the entry type of a class whose keys in files differ from its fields.

    Parameters
    ----------
    cls : type
    word : str
        Value of its ``type``.
    implied : bool
        Whether the key ``type`` is optional.
    base : type
        Base entry with further keys.
    **keys
        Its keys, most of them from `keys_of`.
    """
    return _entry(cls, {"type": (Literal[word], word if implied else ...), **keys}, base)


def extended(entry: Any, prefix: str = "", **keys: Any) -> Any:
    """Return an entry with additional keys; a prefix changes its name."""
    return create_model(f"{prefix}{entry.__name__}", __base__=entry, **keys)


def said(field: Field[Any, Any]) -> str | None:
    """Return the JSON schema metadata of a field, None without any."""
    unit = f", {field.unit}" if str(field.unit) not in ("", "1") else ""
    some = field.default
    empty = some == "" or (isinstance(some, tuple | Mapping) and not any(some))
    plain = field.required or some is None or isinstance(some, bool | Declared) or empty
    default = "" if plain else f"; {some} if not given"
    return f"{field.text}{unit}{default}" or None


def alone(cls: Any) -> Any:
    """Return the entry type of a section that has one class and no key ``type``."""
    return Annotated[entry_of(cls), Later()]


class Declarations(Tagged):
    """Annotation of an entry of a section: the key ``type`` selects the class.

    The classes are imported, and their entry types built, when a file uses the section. Classes
    that are declared later are included.

    Parameters
    ----------
    section : str
        As for `kinds`.
    room : str or tuple of str
        Package that declares the classes, or several.
    implied : callable, optional
        Returns the type of a mapping without the key ``type``.
    others : mapping, optional
        Entries of types without a declared class, by word.
    unsaid : tuple of str
        Types that are optional in the file, if not all of them are.
    base : type
        Base entry with the keys that all entries have besides their fields.
    """

    def __init__(
        self,
        section: str,
        room: str | tuple[str, ...],
        implied: Implied = None,
        others: Others = NO_OTHERS,
        unsaid: tuple[str, ...] = (),
        base: type[Entry] = Entry,
    ) -> None:
        super().__init__(implied)
        self.base = base
        self.unsaid = unsaid
        self.others = others
        self.section = section
        self.rooms = (room,) if isinstance(room, str) else room
        self.imported = False

    def known(self, source: Any) -> Callable[[], Mapping[str, Any]]:
        """Return the lookup of the section's classes by word."""

        def find() -> Mapping[str, Any]:
            if not self.imported:
                for room in self.rooms:
                    kinds(self.section, room)
                self.imported = True
            return (
                {**SECTIONS[self.section], **self.others} if self.others else SECTIONS[self.section]
            )

        return find

    def entry(self, kind: Any) -> type[Entry]:
        """Return the entry of a class."""
        word = getattr(kind, "tag", "")
        implied = bool(self.tag) and word in (self.unsaid or (word,))
        if isinstance(kind, EntryBy):
            kind = kind.entry
        found: type[Entry] = (
            kind if issubclass(kind, Entry) else entry_of(kind, implied, base=self.base)
        )
        return found


def one_of(*given: Any, **named: Any) -> Any:
    """Return the type of a section's entry; arguments as in `Declarations`."""
    return Annotated[Any, Declarations(*given, **named)]


class EntryBy:
    """Annotation of an entry that is built at the first use.

    Parameters
    ----------
    make : callable
        Returns the entry.
    """

    def __init__(self, make: Callable[[], Any]) -> None:
        self.make = make

    @functools.cached_property
    def entry(self) -> Any:
        """Entry."""
        return self.make()

    def __get_pydantic_core_schema__(self, source: Any, handler: Any) -> Any:
        """Validate with the entry."""
        return later(lambda: self.entry)


class EntryOf(EntryBy):
    """Annotation of the entry of one class, imported at the first use.

    Parameters
    ----------
    module, name : str
        Module and name of the class.
    without : tuple of str
        As for `entry_of`.
    **keys
        Further keys, and the prefix of its name, as for `extended`.
    """

    def __init__(self, module: str, name: str, without: tuple[str, ...] = (), **keys: Any) -> None:
        def make() -> Any:
            made = entry_of(getattr(importlib.import_module(module), name), without=without)
            return extended(made, **keys) if keys else made

        super().__init__(make)
