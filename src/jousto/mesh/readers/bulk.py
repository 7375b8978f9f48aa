"""Entries of Nastran bulk data: small, large and free fields, continuations, INCLUDE."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from jousto.base.errors import InputError, Problem
from jousto.base.files import check_input
from jousto.mesh.readers.raw import BIG

# pattern of data fields, and of continuation marks
_DATA = re.compile(r"[\d.-]\S*|THRU|UM|ALPHA|BY|EXCEPT", re.IGNORECASE)
_MARK = re.compile(r"([+*]\S*)?")


@dataclass
class Card:
    """One entry: its name, its fields and its position in the file."""

    name: str
    fields: list[str]
    path: Path
    number: int

    @property
    def where(self) -> str:
        """File, line and name, for messages."""
        return f"{self.path.name}:{self.number}: {self.name}"

    def field(self, i: int) -> str:
        """Return field i, counted from 0 after the name of the card; empty for a missing field."""
        return self.fields[i] if i < len(self.fields) else ""

    def whole(self, i: int, default: int | None = None) -> int:
        """Return the whole number in field i, counted from 0 after the name of the card."""
        text = self.field(i)
        if not text and default is not None:
            return default
        if not re.fullmatch(r"[+-]?\d{1,25}", text) or abs(int(text)) > BIG:
            raise self.wrong(i, "a whole number")
        return int(text)

    def real(self, i: int, default: float | None = None) -> float:
        """Return the real number in field i: ``1.5``, ``1.5E-3``, ``1.5-3`` or ``1.5D-3``."""
        text = self.field(i)
        if not text and default is not None:
            return default
        try:
            return float(text)
        except ValueError:
            pass
        try:
            repaired = re.sub(r"(?<=[\d.])[dD]?([+-]\d+)$", r"e\1", text)
            return float(repaired.replace("D", "e").replace("d", "e"))
        except ValueError:
            raise self.wrong(i, "a number") from None

    def wrong(self, i: int, wanted: str) -> InputError:
        """Return the error for a field with a wrong value."""
        found = f"is '{self.field(i)}'" if self.field(i) else "is missing"
        return InputError(
            Problem(
                self.where, f"field {i + 2} {found}, must be {wanted}; the file may be truncated"
            )
        )


def cards(path: Path, depth: int) -> Iterator[Card]:
    """Yield the entries of the bulk data section, including those of included files."""
    if depth > 10:
        raise InputError(Problem(path.name, "a file includes itself"))
    text = path.read_text(encoding="latin-1")
    lines = text.splitlines()
    begin = next(
        (i for i, line in enumerate(lines) if re.match(r"\s*BEGIN\s+BULK", line, re.IGNORECASE)), -1
    )
    card: Card | None = None
    for i in range(begin + 1, len(lines)):
        line = lines[i].split("$", 1)[0].rstrip()
        if not line:
            continue
        if re.match(r"\s*ENDDATA", line, re.IGNORECASE):
            break
        include = re.match(r"\s*INCLUDE\s+(\S.*)", line, re.IGNORECASE)
        if include:
            title = include[1].strip("'").strip()
            inner = path.parent / title
            check_input(inner)
            if not inner.is_file():
                where = f"{path.name}:{i + 1}"
                raise InputError(
                    Problem(where, f"the included file '{title}' does not exist; put it beside")
                )
            if card is not None:
                yield card
                card = None
            yield from cards(inner, depth + 1)
            continue
        head, fields = _split(line, f"{path.name}:{i + 1}")
        if card is not None and (not head or head[0] in "+*"):
            card.fields += fields
            continue
        if card is not None:
            yield card
        # meshio writes CTETRA_ for an element with midside nodes
        card = Card(head.rstrip("*_").upper(), fields, path, i + 1)
    if card is not None:
        yield card


def _split(line: str, where: str) -> tuple[str, list[str]]:
    """Return the first field and the data fields of a line: 8, 4 long ones, more in free format."""
    if "," in line:
        words = [word.strip() for word in line.split(",")]
        return words[0], _free(words, 4 if words[0].endswith("*") else 8, where)
    line = line.expandtabs(8)
    head = line[:8].strip()
    if "*" in head:
        return head, [line[8 + 16 * i : 24 + 16 * i].strip() for i in range(4)]
    return head, [line[8 + 8 * i : 16 + 8 * i].strip() for i in range(8)]


def _free(words: list[str], wide: int, where: str) -> list[str]:
    """Return the data fields of a line in free format, padded to whole lines with `wide` fields.

    A line may be longer than its data fields. It may contain the continuation marks that end the
    line and begin the next one (``..., 6, +A, +A, 7, 8``; the marks may be blank), or further data
    without marks (``..., 6, 7, 8``). A word behind the data fields that is not data is a mark or a
    comment.
    """
    fields, rest = words[1 : 1 + wide], words[1 + wide :]
    while any(rest):
        if _DATA.fullmatch(rest[0]):
            fields += rest[:wide]
            rest = rest[wide:]
        elif len(rest) > 1 and not _MARK.fullmatch(rest[1]) and not rest[0]:
            raise InputError(
                Problem(
                    where,
                    f"the field {wide + 2} is blank and '{rest[1]}' follows: not clear whether it "
                    "is a continuation mark or data; begin a new line there",
                )
            )
        else:
            following = rest[2:] if len(rest) > 1 and _MARK.fullmatch(rest[1]) else rest[1:]
            fields += following[:wide]
            rest = following[wide:]
    return fields + [""] * (-len(fields) % wide)
