"""Reader of YAML 1.2 on the events of libyaml: plain data and the line of every entry.

libyaml, in C, yields the events of a text one by one (a scalar, the start of a list, ...), so that
no syntax tree is stored beside the data. Its grammar is YAML 1.1, which differs from 1.2 in the
meaning of plain scalars and in a few characters; this reader corrects both.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any, NoReturn

from yaml.events import (
    AliasEvent,
    CollectionEndEvent,
    CollectionStartEvent,
    DocumentStartEvent,
    Event,
    MappingEndEvent,
    MappingStartEvent,
    ScalarEvent,
    SequenceEndEvent,
    SequenceStartEvent,
    StreamEndEvent,
)

from jousto.base.errors import InputError, Problem, Problems
from jousto.schema.file.hidden_signs import ESCAPE, HIDDEN_ESCAPE, SURROGATE, UTF16, bare, shielded

try:
    from yaml.cyaml import CParser
except ImportError as error:
    raise ImportError(
        "model files are read by libyaml, without which this PyYAML was built: "
        "pip install pyyaml --force-reinstall --only-binary :all:"
    ) from error

# maximum number of entries of a file, aliases expanded
MOST_ENTRIES = 1_000_000


class YamlReader:
    """Converter of a YAML text to plain data; collects problems and, on request, line numbers.

    Parameters
    ----------
    text : str
        One document.
    name : str
        Name of the file, for problems.
    problems : Problems
        Collector of problems of entries.
    lines : dict, optional
        Mapping that receives the line (from 1) of every entry by its path.

    Raises
    ------
    yaml.YAMLError
        If the text is not YAML; also raised by `read`.
    UnicodeEncodeError
        If it contains a character that UTF-8 cannot encode.
    """

    def __init__(
        self,
        text: str,
        name: str,
        problems: Problems,
        lines: dict[tuple[int | str, ...], int] | None = None,
    ) -> None:
        self.name = name
        self.problems = problems
        self.lines = lines
        self.path: list[int | str] = []  # path of the current entry
        self.count = 0
        self.section = 1  # line of the current top-level key
        self.words: dict[tuple[str, Any, Any], Any] = {}  # cache of scalar values, which repeat
        # the cache for entries without a line
        self.known = self.words if lines is None else {}
        hidden = shielded(text)
        self.hides = hidden is not text
        self.next = CParser(hidden).get_event
        # stored events of a text with aliases
        self.events: list[Event] = []
        # index of the anchor event of an alias, by the id of the alias event
        self.targets: dict[int, int] = {}
        self.open: set[int] = set()  # ids of the events of open anchored collections
        if "*" in text:
            self.events = list(iter(self.next, None))
            self.next = self.replay(0).__next__
            self.find_targets()

    def replay(self, place: int) -> Iterator[Event]:
        """Yield the stored events from a position on."""
        while place < len(self.events):
            yield self.events[place]
            place += 1

    def find_targets(self) -> None:
        """Find the position of the anchor of every alias."""
        anchors: dict[str, int] = {}
        for place, event in enumerate(self.events):
            anchor = getattr(event, "anchor", None)
            if anchor is None:
                continue
            if not isinstance(event, AliasEvent):
                anchors[anchor] = place
            elif anchor in anchors:
                self.targets[id(event)] = anchors[anchor]
            else:
                self.refuse(event, f"found undefined alias {anchor!r}")

    def refuse(self, event: Event, message: str) -> NoReturn:
        """Raise a syntax error at an event."""
        line = event.start_mark.line + 1
        raise InputError(Problem(f"{self.name}:{line}", f"YAML syntax: {message}"))

    def read(self) -> Any:
        """Return the data of the text.

        Raises
        ------
        InputError
            If the text is empty or has too many entries, or for problems that belong to no single
            entry.
        RecursionError
            If the text is nested too deeply.
        """
        self.next()  # skip the start of the stream
        first = self.next()
        if not isinstance(first, DocumentStartEvent):
            raise InputError(Problem(self.name, "is empty"))
        if first.version == (1, 1):
            self.note(first, "is YAML 1.1, in which words mean other things; model files are 1.2")
        data = self.value(self.next())
        self.next()  # skip the end of the document
        further = self.next()
        if not isinstance(further, StreamEndEvent):
            self.refuse(further, "expected a single document in the stream, found another one")
        return data

    def value(self, event: Any) -> Any:
        """Return the plain data that begin with an event."""
        self.count += 1
        if self.count > MOST_ENTRIES:
            raise InputError(
                Problem(f"{self.name}:{self.section}", "too many entries, aliases repeat too often")
            )
        if self.lines is not None:
            self.lines.setdefault(tuple(self.path), event.start_mark.line + 1)
        if isinstance(event, ScalarEvent):
            return self.scalar(event)
        if isinstance(event, AliasEvent):
            return self.alias(event)
        if event.anchor is None:
            return self.collection(event)
        self.open.add(id(event))
        try:
            return self.collection(event)
        finally:
            self.open.discard(id(event))

    def collection(self, event: Any) -> Any:
        """Return the dictionary or the list that begins with an event."""
        return self.mapping() if isinstance(event, MappingStartEvent) else self.sequence()

    def alias(self, event: Any) -> Any:
        """Return the data of the anchor of an alias."""
        place = self.targets[id(event)]
        target = self.events[place]
        if id(target) in self.open:
            self.note(event, "refers to itself")
            return None
        after = self.next
        self.next = self.replay(place + 1).__next__
        found = self.value(target)
        self.next = after
        return found

    def at(self, key: int | str, event: Any) -> Any:
        """Return the plain data of an entry of the current collection."""
        self.path.append(key)
        found = self.value(event)
        self.path.pop()
        return found

    def sequence(self) -> list[Any]:
        """Return the list that continues with the next event."""
        data: list[Any] = []
        after, words = self.next, self.known
        while type(event := after()) is not SequenceEndEvent:
            if type(event) is ScalarEvent:
                word = (event.value, event.tag, event.style)
                if word in words:
                    self.count += 1
                    data.append(words[word])
                    continue
            data.append(self.at(len(data), event))
        return data

    def mapping(self) -> dict[str, Any]:
        """Return the dictionary that continues with the next event, with merged keys (``<<``)."""
        data: dict[str, Any] = {}
        first: dict[str, Any] = {}  # first event of each key, to report duplicates
        merged: list[Any] = []
        after, words, outermost = self.next, self.known, not self.path
        while type(event := after()) is not MappingEndEvent:
            if outermost:
                self.section = event.start_mark.line + 1
            if type(event) is not ScalarEvent:
                self.note(event, "a key must be a plain word")
                self.skip(event)
                self.skip(self.next())
                continue
            key = event.value if event.value.isascii() else self.text(event)
            if key == "<<" and event.style == "":
                merged += self.merged(self.next())
                continue
            if key in data:
                self.path.append(key)
                self.note(event, f"given twice, first in line {first[key].start_mark.line + 1}")
                self.path.pop()
                self.skip(self.next())
                continue
            first[key] = event
            if self.lines is not None:
                self.lines[*self.path, key] = event.start_mark.line + 1
            event = after()
            if type(event) is ScalarEvent:
                word = (event.value, event.tag, event.style)
                if word in words:
                    self.count += 1
                    data[key] = words[word]
                    continue
            data[key] = self.at(key, event)
        for other in merged:
            if isinstance(other, dict):
                data = {**other, **data}
        return data

    def merged(self, event: Any) -> list[Any]:
        """Return the data of the entries whose keys are merged: one, or a list of them."""
        if not isinstance(event, SequenceStartEvent):
            return [self.value(event)]
        found = []
        while type(event := self.next()) is not SequenceEndEvent:
            found.append(self.value(event))
        return found

    def skip(self, event: Any) -> None:
        """Skip the events of an entry."""
        depth = int(isinstance(event, CollectionStartEvent))
        while depth:
            event = self.next()
            depth += isinstance(event, CollectionStartEvent)
            depth -= isinstance(event, CollectionEndEvent)

    def scalar(self, event: Any) -> Any:
        """Return the text, number, boolean or None of a scalar."""
        word = (event.value, event.tag, event.style)
        if word in self.words:
            return self.words[word]
        noted = len(self.problems.found)
        found = self.meaning(event)
        if len(self.problems.found) == noted:
            self.words[word] = found
        return found

    def meaning(self, event: Any) -> Any:
        """Return the value of a scalar that is not in the cache of `scalar`."""
        text = self.text(event)
        if event.style or event.tag == "tag:yaml.org,2002:str":
            return text
        if event.tag is not None and not event.tag.startswith("tag:yaml.org,2002:"):
            self.note(event, f"unknown tag {event.tag}")
            return text
        return plain_value(text)

    def text(self, event: Any) -> str:
        """Return quoted text; a surrogate pair of ``uXXXX`` escapes becomes one character."""
        text: str = event.value
        if text.isascii() or not self.hides:
            return text
        text = bare(text)
        if ESCAPE not in text:
            return text
        if event.style != '"':
            return text.replace(ESCAPE, "\\")
        text = HIDDEN_ESCAPE.sub(lambda found: chr(int(found[1], 16)), text)
        text = text.encode(UTF16, "surrogatepass").decode(UTF16, "surrogatepass")
        half = SURROGATE.search(text)
        if half:
            escape = f"\\u{ord(half[0]):04x}, half of a character"
            self.note(event, f"contains {escape}: leave it out or pair it")
        return text

    def note(self, event: Any, message: str) -> None:
        """Add a problem at the current path, with the line of an event."""
        path = ".".join(map(str, self.path))
        place = f"{self.name}:{event.start_mark.line + 1}" + (f": {path}" if path else "")
        self.problems.add(place, message)


# plain scalars of YAML 1.2, section 10.3.2, and numbers with underscores
CONSTANTS: dict[str, Any] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL")),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
}
INTEGER = re.compile(r"[-+]?(?:0b[01_]+|0o[0-7_]+|0x[0-9a-fA-F_]+|[0-9][0-9_]*)")
REAL = re.compile(r"[-+]?(?:\.[0-9][0-9_]*|[0-9][0-9_]*(?:\.[0-9_]*)?)(?:[eE][-+]?[0-9]+)?")


def plain_value(text: str) -> Any:
    """Return the number, boolean or None that a plain scalar means, else the text itself.

    Examples
    --------
    >>> [plain_value(x) for x in ("012", "0x1F", "1e9", "yes", "true", "~", "3 mm")]
    [12, 31, 1000000000.0, 'yes', True, None, '3 mm']
    """
    if text in CONSTANTS:
        return CONSTANTS[text]
    digits = text.replace("_", "")
    try:
        if INTEGER.fullmatch(text):
            return int(digits, 0 if digits.lstrip("-+")[1:2].isalpha() else 10)
        if REAL.fullmatch(text):
            return float(digits)
    except ValueError:  # "0x_", or more digits than Python accepts
        pass
    return text
