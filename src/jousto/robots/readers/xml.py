"""Safe reader of XML files: no entities, no network access, with the line of each element."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any
from xml.parsers import expat

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, MissingFileError, Problem, warn
from jousto.base.files import check_input
from jousto.base.names import harmless

LARGEST = 64 * 2**20  # largest size of a file, bytes
MOST = 200_000  # maximum number of elements
DEEPEST = 100  # maximum depth of nested elements


@dataclass
class Element:
    """Element of an XML file.

    Parameters
    ----------
    tag : str
        Name of the element.
    given : dict of str to str
        Attributes.
    line : int
        Line of its first character, from 1.
    children : list of Element
        Child elements in their order.
    text : str
        Text besides the children.
    file : str
        Name of the file.
    """

    tag: str
    given: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    text: str = ""
    file: str = ""

    def all(self, *tags: str) -> Iterator[Element]:
        """Yield the children with given names."""
        return (child for child in self.children if child.tag in tags)

    def first(self, tag: str) -> Element | None:
        """Return the first child of a name, or None."""
        return next(self.all(tag), None)


class Refused(Exception):
    """Error raised for a file with forbidden content."""


class _Builder:
    """Builder of elements from the events of an XML parser."""

    def __init__(self, file: str) -> None:
        self.file = file
        self.parser = expat.ParserCreate()
        self.root: Element | None = None
        self.open: list[Element] = []
        self.count = 0
        self.parser.StartElementHandler = self.start
        self.parser.EndElementHandler = self.end
        self.parser.CharacterDataHandler = self.characters
        self.parser.StartDoctypeDeclHandler = self.doctype

    def start(self, tag: str, given: dict[str, str]) -> None:
        """Begin an element."""
        self.count += 1
        if self.count > MOST or len(self.open) >= DEEPEST:
            raise Refused(f"has more than {MOST} elements, or {DEEPEST} within each other")
        # remove control characters, since attributes appear in messages
        known = {key: harmless(value) for key, value in given.items()}
        line = self.parser.CurrentLineNumber
        element = Element(harmless(tag), known, line, file=self.file)
        if self.open:
            self.open[-1].children.append(element)
        elif self.root is None:
            self.root = element
        self.open.append(element)

    def end(self, _: str) -> None:
        """End the innermost element."""
        self.open.pop()

    def characters(self, text: str) -> None:
        """Add text to the innermost element."""
        if self.open:
            self.open[-1].text += text

    def doctype(self, *_: object) -> None:
        """Raise an error for a DOCTYPE, which may declare entities."""
        raise Refused("has a DOCTYPE, which could include other files; remove it")


def parse_file(path: Path) -> Element:
    """Return the root of an XML file.

    Raises
    ------
    InputError
        If the file does not exist, is too large, is not XML, or has a DOCTYPE.
    """
    where = harmless(path.name)
    try:
        check_input(path)
        if not path.exists():
            raise MissingFileError(Problem(where, f"no such file '{path}'"))
        if path.stat().st_size > LARGEST:
            size = path.stat().st_size / 2**20
            raise InputError(
                Problem(where, f"has {size:.0f} MB, must have at most {LARGEST // 2**20} MB")
            )
        data = path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(Problem(where, f"cannot be read: {error}")) from None
    return parse_bytes(data, where)


def parse_bytes(data: bytes, where: str) -> Element:
    """Return the root element of XML data, see `parse_file`."""
    builder = _Builder(where)
    try:
        builder.parser.Parse(data, True)
    except Refused as error:
        raise InputError(
            Problem(f"{where}:{builder.parser.CurrentLineNumber}", str(error))
        ) from None
    except (expat.ExpatError, LookupError, ValueError) as error:
        line = getattr(error, "lineno", builder.parser.CurrentLineNumber)
        text = harmless(str(error).partition(":")[0])
        raise InputError(Problem(f"{where}:{line}", f"is not valid XML: {text}")) from None
    if builder.root is None:
        raise InputError(Problem(where, "is empty"))
    return builder.root


class Reading:
    """Collector of the errors and warnings of a file.

    Parameters
    ----------
    path : Path
        Path of the file.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.problems: list[Problem] = []
        self.odd: list[Problem] = []
        self.ignored: dict[str, tuple[str, int]] = {}
        self.effects: dict[str, tuple[str, dict[str, int]]] = {}

    def where(self, element: Element | None, what: str = "") -> str:
        """Return the location of an element for messages, ``arm.urdf:12: joint 'elbow'``."""
        file = harmless(self.path.name)
        if element is None:
            return file if not what else f"{file}: {what}"
        name = element.given.get("name", "")
        what = what or (f"{element.tag} {name!r}" if name else element.tag)
        return f"{self.line(element)}: {what}"

    def line(self, element: Element) -> str:
        """Return file and line of an element, ``arm.urdf:12``."""
        return f"{element.file or harmless(self.path.name)}:{element.line}"

    def add(self, element: Element | None, message: str, what: str = "") -> None:
        """Add an error."""
        self.problems.append(Problem(self.where(element, what), message))

    def note(self, element: Element | None, message: str, what: str = "") -> None:
        """Add a warning."""
        self.odd.append(Problem(self.where(element, what), message))

    def leave_out(self, element: Element, name: str = "") -> None:
        """Add an ignored element to the warnings; all of one name are reported together."""
        name = name or element.tag
        line, times = self.ignored.get(name, (self.line(element), 0))
        self.ignored[name] = (line, times + 1)

    def effect(self, element: Element, word: str, effect: str) -> None:
        """Add a word with its effect to the warnings; words of one effect are reported together."""
        _, words = self.effects.setdefault(effect, (self.where(element), {}))
        words[word] = words.get(word, 0) + 1

    def finish(self) -> tuple[Problem, ...]:
        """Raise InputError with all errors, or issue the warnings and return them."""
        if self.problems:
            raise InputError(self.problems)
        for effect, (where, words) in self.effects.items():
            named = ", ".join(words)
            again = f" ({times} places)" if (times := sum(words.values())) > 1 else ""
            self.odd.append(Problem(where, f"{named}{again}: {effect}"))
        for name, (line, times) in self.ignored.items():
            again = f" and {times - 1} more" if times > 1 else ""
            self.odd.append(Problem(line, f"<{name}>{again} is ignored"))
        for odd in self.odd:
            warn(odd.where, odd.message)
        return tuple(self.odd)

    # -- values -----------------------------------------------------------------------------

    def numbers(
        self, element: Element, text: str | None, what: str, count: int, default: Array | None
    ) -> Array:
        """Return the numbers in a text; for an invalid text add an error, return the default."""
        spare = np.zeros(count) if default is None else np.array(default, dtype=np.float64)
        if text is None:
            if default is None:
                self.add(element, f"{what} is missing")
            return spare
        words = text.split()
        try:
            if any("_" in word for word in words):
                raise ValueError
            values = np.array([float(word) for word in words])
        except ValueError:
            self.add(element, f"{what} is {text.strip()[:60]!r}, must be {_wanted(count)}")
            return spare
        if len(values) != count:
            self.add(element, f"{what} has {len(values)} numbers, must be {_wanted(count)}")
            return spare
        # magnitudes above 1e100, whose squares overflow
        if not np.isfinite(values).all() or np.abs(values).max() > 1e100:
            self.add(element, f"{what} is {text.strip()[:60]!r}, must be finite")
            return spare
        return values

    def list(self, element: Element, key: str) -> Array | None:
        """Return all numbers of an attribute; None if it is missing or not numeric."""
        try:
            values = np.array([float(word) for word in element.given.get(key, "").split()])
        except ValueError:
            return None
        return values if len(values) and (np.abs(values) <= 1e100).all() else None

    def vector(self, element: Element, key: str, default: tuple[float, ...] | None) -> Array:
        """Return three numbers of an attribute."""
        spare = None if default is None else np.array(default)
        return self.numbers(element, element.given.get(key), key, 3, spare)

    def number(self, element: Element, key: str, default: float | None = None) -> float:
        """Return the number of an attribute."""
        spare = None if default is None else np.array([default])
        if default is not None and not math.isfinite(default) and key not in element.given:
            return default
        return float(self.numbers(element, element.given.get(key), key, 1, spare)[0])

    def limit(self, element: Element, key: str, default: float) -> float:
        """Return the number of an attribute that may be infinite."""
        text = element.given.get(key)
        if text is not None and text.strip().lower().lstrip("+-") in ("inf", "infinity"):
            return -math.inf if text.strip().startswith("-") else math.inf
        return default if text is None else self.number(element, key)


class Adder:
    """Collector of errors and warnings with the location of a link or joint."""

    def __init__(self, reading: Reading) -> None:
        self.reading = reading

    def __call__(self, thing: Any, message: str) -> None:
        """Add an error."""
        self.reading.problems.append(Problem(self.where(thing), message))

    def note(self, thing: Any, message: str) -> None:
        """Add a warning."""
        self.reading.odd.append(Problem(self.where(thing), message))

    def where(self, thing: Any) -> str:
        """Return the location of a link or joint for messages."""
        return self.reading.where(None) if thing is None else thing.where or thing.name


def _wanted(count: int) -> str:
    return "a number" if count == 1 else f"{count} numbers"
