"""Keywords of Abaqus and CalculiX input files with their data lines, and included files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from jousto.base.arrays import Ints
from jousto.base.errors import InputError, Problem
from jousto.base.files import check_input
from jousto.mesh.readers.raw import BIG

# keywords whose INPUT is a file of data lines; for others it is, for example, a results file
_DATA_FILES = ("NODE", "ELEMENT", "NSET", "ELSET")
# keywords whose blank data lines mean defaults
_BLANK = ("BEAM GENERAL SECTION",)
# largest depth of nested files; Abaqus allows five
DEPTH = 10


@dataclass
class Block:
    """Keyword with its parameters, data lines and position in the file."""

    keyword: str
    parameters: dict[str, str]
    path: Path
    number: int
    lines: list[str] = field(default_factory=list)

    @classmethod
    def of(cls, text: str, path: Path, number: int) -> Block:
        """Return the block that begins with a keyword line such as ``*ELEMENT, TYPE=C3D8``."""
        words = [word.strip() for word in text.lstrip("* ").split(",")]
        parameters = {}
        for word in words[1:]:
            key, _, value = word.partition("=")
            parameters[key.strip().upper()] = value.strip()
        return cls(re.sub(r"\s+", " ", words[0]).upper(), parameters, path, number)

    @property
    def place(self) -> str:
        """File and line of the keyword."""
        return f"{self.path.name}:{self.number}"

    @property
    def where(self) -> str:
        """Prefix of messages."""
        return f"{self.place}: *{self.keyword}"

    def text(self, parameter: str) -> str:
        """Return the value of a parameter without quotes, empty if it has none."""
        return self.parameters.get(parameter, "").strip('" ')

    @property
    def tokens(self) -> list[str]:
        """All words of the data lines."""
        return [word for line in self.lines for word in line.replace(",", " ").split()]

    @property
    def rows(self) -> list[list[str]]:
        """The data lines as lists of words; a word may be empty."""
        return [
            [word.strip() for word in line.strip().rstrip(",").split(",")] for line in self.lines
        ]

    def whole(self, words: list[str]) -> Ints:
        """Return words as whole numbers, or raise InputError."""
        try:
            return np.array(words, dtype=np.int64)
        except (ValueError, OverflowError):
            pass
        numbers = []
        for word in words:
            plain = re.fullmatch(r"([+-]?\d+)(\.0*)?", word.strip())
            if plain is None or abs(int(plain[1][:25])) > BIG:
                wrong = "is not a whole number" if plain is None else "is too large for a number"
                raise self.wrong(f"'{word[:25]}' {wrong}; the file may be truncated or damaged")
            numbers.append(int(plain[1]))
        return np.array(numbers, dtype=np.int64)

    def wrong(self, sentence: str) -> InputError:
        """Return the error with a message about the block."""
        return InputError(Problem(self.where, sentence))


def real(word: str) -> float:
    """Return a number; blank means zero, and Fortran's ``1.5D+00`` is accepted."""
    word = word.strip()
    return float(re.sub(r"(?<=[\d.])[dD](?=[+-]?\d+$)", "e", word)) if word else 0.0


def blocks(path: Path) -> Iterator[Block]:
    """Yield the keyword blocks of a file; data before any keyword have an empty keyword.

    The lines of an included file replace ``*INCLUDE``: data at its beginning belong to the previous
    keyword, and data after it to its last keyword, as in Abaqus and CalculiX.

    Raises
    ------
    InputError
        If an included file is missing or includes itself.
    """
    block: Block | None = None
    for here, number, line, opens in _lines(path, ()):
        if opens:
            if block is not None:
                yield block
            block = Block.of(line, here, number)
        else:
            block = block or Block("", {}, here, number)
            if line or (block.keyword in _BLANK and block.lines):
                block.lines.append(line)
    if block is not None:
        yield block


_Line = tuple[Path, int, str, bool]


def _lines(path: Path, above: tuple[Path, ...]) -> Iterator[_Line]:
    """Yield file, line number, text, and whether it is a keyword line, included files inserted.

    Keyword lines that continue after a comma are joined to one line.
    """
    if len(above) > DEPTH:
        raise InputError(Problem(path.name, "**INCLUDE: a file includes itself"))
    above = (*above, path)
    begun, first = "", 0
    with open(path, encoding="latin-1") as file:
        for number, line in enumerate(file, start=1):
            text = line.strip()
            if line.startswith("**") or (begun and not text):
                continue
            if begun and re.match(r"[-+.\d]", text):  # a superfluous comma, since data follow
                yield from _opened(begun.rstrip(","), first, above)
                begun = ""
            if begun or text.startswith("*"):
                first = first if begun else number
                begun += text
                if not text.endswith(","):
                    yield from _opened(begun, first, above)
                    begun = ""
            else:
                yield path, number, text, False
    if begun:
        yield from _opened(begun.rstrip(","), first, above)


def _opened(text: str, number: int, above: tuple[Path, ...]) -> Iterator[_Line]:
    """Yield a keyword line, or the lines of the file that it includes."""
    block = Block.of(text, above[-1], number)
    if block.keyword != "INCLUDE":
        yield above[-1], number, text, True
    target = block.text("INPUT")
    if block.keyword != "INCLUDE" and (not target or block.keyword not in _DATA_FILES):
        return
    # beside the including file or, as in Abaqus and CalculiX, beside the deck
    found = [file.parent / target for file in (above[-1], above[0])]
    inner = next((file for file in found if target and file.is_file()), None)
    if inner is None:
        raise block.wrong(f"the included file '{target}' does not exist; put it beside")
    check_input(inner)
    yield from _lines(inner, above)
