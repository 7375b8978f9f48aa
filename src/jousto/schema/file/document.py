"""Reading YAML (or JSON): plain data together with the line of every entry."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

from jousto.base.errors import InputError, MissingFileError, Problem, Problems
from jousto.base.files import check_text
from jousto.base.garbage_collection import uncollected
from jousto.base.object_repr import described
from jousto.mesh.formats import is_cad, is_mesh
from jousto.schema.file.composer import compose

DOCUMENTS = (".yaml", ".yml", ".json")  # endings of files that people write

Loc: TypeAlias = tuple[int | str, ...]

# entries of a file with its aliases written out
MOST_ENTRIES = 1_000_000
TOO_DEEP = "is nested too deeply"


@described
@dataclass(frozen=True, eq=False)
class Document:
    """The content of a model file.

    Parameters
    ----------
    name : str
        File name for messages.
    text : str
        The text of the file.
    data : dict
        Plain mappings, lists, strings, numbers, booleans and None.
    folder : Path
        Folder against which file names in the document are resolved.
    expressions : dict
        Text of every expression that was replaced by its value, by its path.
    lines : dict
        Line number (from 1) of every entry by its path, such as ``("joints", 0, "b")``; found when
        a message needs it.
    """

    name: str
    text: str
    data: dict[str, Any]
    folder: Path = field(default_factory=Path)
    expressions: dict[Loc, str] = field(default_factory=dict)

    @cached_property
    def lines(self) -> dict[Loc, int]:
        """Line number (from 1) of every entry by its path, such as ``("joints", 0, "b")``."""
        return read_lines(self.text)

    def line(self, loc: Loc) -> int:
        """Return the line of an entry, or of the innermost existing one around it."""
        while loc and loc not in self.lines:
            loc = loc[:-1]
        return self.lines.get(loc, 1)

    def at(self, loc: Loc) -> Any:
        """Return the entry at a path, None if there is none."""
        value: Any = self.data
        for key in loc:
            try:
                value = value[key]
            except (KeyError, IndexError, TypeError):
                return None
        return value

    def told(self, loc: Loc, message: str) -> str:
        """Return a message with the expression that the value at a path comes from."""
        text = self.expressions.get(loc)
        return message if text is None else f"{message}; from {text}"

    def where(self, loc: Loc) -> str:
        """Return the place of an entry for messages, ``boom.yaml:18: joints.0.b``."""
        path = ".".join(str(key) for key in loc)
        return f"{self.name}:{self.line(loc)}" + (f": {path}" if path else "")


def read_document(path: str | Path) -> Document:
    """Read a YAML or JSON file.

    Raises
    ------
    InputError
        If there is no such file or it is not text, syntax errors with their line, keys given
        twice, content that is not a mapping, is nested too deeply or has too many entries.
    """
    path = Path(path)
    check_text(path)
    if path.is_file() and (is_cad(path) or is_mesh(path)):
        raise InputError(Problem(path.name, _geometry(path)))
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise MissingFileError(Problem(str(path), "no such file")) from None
    except UnicodeDecodeError:
        hint = " (it looks like HDF5)" if is_hdf5(path) else ""
        raise InputError(Problem(str(path), f"is not a text file{hint}")) from None
    except OSError as error:
        raise InputError(Problem(str(path), f"cannot be read: {error.strerror}")) from None
    return parse_document(text, name=path.name, folder=path.parent)


def _geometry(path: Path) -> str:
    """Return what to do with a CAD file or a mesh in the place of a model file."""
    if is_cad(path):
        what, mesh, look = "a CAD file", f"{{cad: {path.name}, size: 8 mm}}", " --size '8 mm'"
    else:
        # VTK files say metres, as jousto writes them; decks leave the unit to who reads them
        unit = "" if path.suffix.lower() in (".vtu", ".vtk") else ", unit: mm"
        what, mesh, look = "a mesh", f"{{file: {path.name}{unit}}}", ""
    return (
        f"is {what}, not a model or part file: jousto mesh {path.name}{look} shows what is in it. "
        f"A part file {path.stem}.yaml of it has the lines\n"
        f"type: solid\nmesh: {mesh}\nmaterial: S355"
    )


def is_hdf5(path: Path) -> bool:
    """Return whether a file starts like an HDF5 file."""
    try:
        with path.open("rb") as file:
            return file.read(8) == b"\x89HDF\r\n\x1a\n"
    except OSError:
        return False


@uncollected()
def parse_document(text: str, *, name: str = "model", folder: Path | None = None) -> Document:
    """Parse YAML or JSON text; see `read_document`."""
    # imported here: it is needed for model files only
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    try:
        root = compose(shielded(text))
    except MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark is not None else 1
        column = mark.column if mark is not None else 0
        raise InputError(
            Problem(f"{name}:{line}", syntax_hint(error, text, line, column))
        ) from None
    except YAMLError as error:
        raise InputError(Problem(name, f"cannot be read: {error}")) from None
    except RecursionError:
        raise InputError(Problem(name, TOO_DEEP)) from None
    if root is None:
        raise InputError(Problem(name, "is empty"))
    problems = Problems()
    try:
        data = _Reader(name, problems).value(root)
    except RecursionError:
        raise InputError(Problem(name, TOO_DEEP)) from None
    problems.raise_if_any()
    if not isinstance(data, dict):
        raise InputError(
            Problem(f"{name}:1", "must be a mapping such as 'bodies: ...' at the top level")
        )
    return Document(name, text, data, folder or Path())


@uncollected()
def read_lines(text: str) -> dict[Loc, int]:
    """Return the line (from 1) of every entry of a text that can be read, by its path."""
    reader = _Reader("", Problems(), lines={})
    reader.value(compose(shielded(text)))
    return reader.lines or {}


def syntax_hint(error: Any, text: str, line: int, column: int) -> str:
    """Return a YAML syntax error as one sentence."""
    message = str(error.problem or error.context or "cannot be read")
    if message.startswith("but found"):
        message = f"{error.context} {message}"
    lines = text.splitlines()
    content = lines[line - 1] if 0 < line <= len(lines) else ""
    hint = ""
    opening = unclosed(lines[: line - 1] + [content[:column]])
    if opening is not None:
        hint = f"; the {opening[0]} opened in line {opening[1]} is not closed"
    elif "\\t" in message or "\t" in content[: len(content) - len(content.lstrip())]:
        hint = "; indent with blanks, not with tabs"
    elif "mapping values are not allowed" in message:
        hint = "; check the indentation and put text with a colon in quotes"
    elif "could not find expected ':'" in message or "expected <block end>" in message:
        hint = "; check the indentation and the brackets"
    return f"YAML syntax: {message}{hint}"


# comments, texts in quotes and brackets; quotes within a word are none
SIGNS = re.compile(
    r"""(?:^|(?<=\s))\#.*|(?<![^\s\[{,:])'(?:[^']|'')*(?:'|\Z)|(?<![^\s\[{,:])"(?:\\.|[^"\\])*(?:"|\Z)"""
    r"""|[\[\]{}]""",
    re.M,
)
PAIRS = {"]": "[", "}": "{"}


def unclosed(lines: Sequence[str]) -> tuple[str, int] | None:
    """Return the innermost bracket or quote that is open at the end of lines, and its line.

    Examples
    --------
    >>> unclosed(["bodies: # [", "  - {name: 'a}', at: [0, 0, 0]", "  "])
    ("'{'", 2)
    """
    text = "\n".join(lines)
    opened: list[tuple[str, int]] = []
    for found in SIGNS.finditer(text):
        sign, line = found[0], text.count("\n", 0, found.start()) + 1
        if sign in ("[", "{"):
            # in plain text of a block a bracket is a letter
            if opened or text[: found.start()].rstrip(" ")[-1:] in ("", "\n", ":", "-"):
                opened.append((f"'{sign}'", line))
        elif sign in PAIRS:
            if opened and opened[-1][0] == f"'{PAIRS[sign]}'":
                opened.pop()
        elif sign[0] in "'\"" and (len(sign) == 1 or sign[-1] != sign[0]):
            opened.append(("quote", line))
    return opened[-1] if opened else None


class _Reader:
    """Turns a tree of YAML nodes into plain data and notes problems, and lines where asked to."""

    def __init__(self, name: str, problems: Problems, lines: dict[Loc, int] | None = None) -> None:
        self.name = name
        self.problems = problems
        self.lines = lines
        self.path: list[int | str] = []  # of the node that is read
        self.open: set[int] = set()
        self.count = 0
        self.section = 1  # line of the key at the top
        self.words: dict[tuple[str, str, Any], Any] = {}  # values of scalars; those repeat

    def value(self, node: Any) -> Any:
        """Return the plain data of a node."""
        self.count += 1
        if self.count > MOST_ENTRIES:
            raise InputError(
                Problem(f"{self.name}:{self.section}", "too many entries, aliases repeat too often")
            )
        if self.lines is not None:
            self.lines.setdefault(tuple(self.path), node.start_mark.line + 1)
        if node.id == "scalar":
            return self.scalar(node)
        if id(node) in self.open:
            self.note(node, "refers to itself")
            return None
        self.open.add(id(node))
        try:
            return self.mapping(node) if node.id == "mapping" else self.sequence(node)
        finally:
            self.open.discard(id(node))

    def at(self, key: int | str, node: Any) -> Any:
        """Return the plain data of a node below the present one."""
        if node.id == "scalar" and self.lines is None:
            word = (node.value, node.tag, node.style)
            if word in self.words:
                self.count += 1
                return self.words[word]
        self.path.append(key)
        found = self.value(node)
        self.path.pop()
        return found

    def sequence(self, node: Any) -> list[Any]:
        """Return the list of a node."""
        return [self.at(i, item) for i, item in enumerate(node.value)]

    def mapping(self, node: Any) -> dict[str, Any]:
        """Return the dictionary of a node, its merged keys included."""
        data: dict[str, Any] = {}
        first: dict[str, Any] = {}  # nodes of the keys
        merged: list[dict[str, Any]] = []
        for key_node, value_node in node.value:
            if not self.path:
                self.section = key_node.start_mark.line + 1
            if key_node.id != "scalar":
                self.note(key_node, "a key must be a plain word")
                continue
            key = self.text(key_node, str(key_node.value))
            if key_node.tag.endswith(":merge"):
                parts = value_node.value if value_node.id == "sequence" else [value_node]
                merged += [d for part in parts if isinstance(d := self.value(part), dict)]
                continue
            if key in data:
                self.path.append(key)
                line = first[key].start_mark.line + 1
                self.note(key_node, f"given twice, first in line {line}")
                self.path.pop()
                continue
            first[key] = key_node
            if self.lines is not None:
                self.lines[*self.path, key] = key_node.start_mark.line + 1
            data[key] = self.at(key, value_node)
        for other in merged:
            data = {**other, **data}
        return data

    def scalar(self, node: Any) -> Any:
        """Return the text, number, truth or None of a node."""
        word = (node.value, node.tag, node.style)
        if word in self.words:
            return self.words[word]
        noted = len(self.problems.found)
        found = self.plain(node)
        if len(self.problems.found) == noted:
            self.words[word] = found
        return found

    def plain(self, node: Any) -> Any:
        """Return the same, of a word that was not read before."""
        text, kind = self.text(node, bare(str(node.value))), str(node.tag).rpartition(":")[2]
        if node.style in ("'", '"', "|", ">"):
            # ruamel.yaml marks with a bell where it folded a line
            return text.replace("\a", "") if node.style == ">" else text
        if kind == "null":
            return None
        if kind == "bool":
            return text.lower() in ("true", "yes", "on", "y")
        if kind == "int":
            return parse_int(text)
        if kind == "float":
            return parse_float(text)
        if not str(node.tag).startswith("tag:yaml.org,2002:"):
            self.note(node, f"unknown tag {node.tag}")
        return text

    def text(self, node: Any, found: str) -> str:
        """Return text whose pairs of escapes, two of ``uXXXX`` in JSON, are the characters."""
        if found.isascii() or not SURROGATE.search(found):
            return found
        code = "utf-16-le"
        text = found.encode(code, "surrogatepass").decode(code, "replace")
        half = SURROGATE.search(found.encode(code, "surrogatepass").decode(code, "surrogatepass"))
        if half:
            message = (
                f"contains \\u{ord(half[0]):04x}, half of a character: leave it out or pair it"
            )
            self.note(node, message)
        return text

    def note(self, node: Any, message: str) -> None:
        """Note a problem at the present path, with the line of a node."""
        path = ".".join(map(str, self.path))
        place = f"{self.name}:{node.start_mark.line + 1}" + (f": {path}" if path else "")
        self.problems.add(place, message)


EXPRESSION = re.compile(r"\$\{([^{}\n]*)\}")
SURROGATE = re.compile("[\ud800-\udfff]")  # halves of characters, which UTF-8 does not have
SHIELD = 0xE000  # the private area of Unicode
SHIELDED = re.compile("[\ue020-\ue07e]")


def shielded(text: str) -> str:
    """Return text in which signs within ``${...}`` mean nothing to YAML; see `bare`."""
    if "${" not in text or SHIELDED.search(text):
        return text
    return EXPRESSION.sub(lambda found: "$" + "".join(map(_shield, found[0][1:])), text)


def _shield(sign: str) -> str:
    plain = sign.isalnum() or sign == " " or not " " < sign <= "~"
    return sign if plain else chr(SHIELD + ord(sign))


def bare(text: str) -> str:
    """Return text as it was before it was shielded."""
    return SHIELDED.sub(lambda found: chr(ord(found[0]) - SHIELD), text)


def parse_int(text: str) -> int | str:
    """Return a YAML 1.2 integer, the text itself if Python cannot read it."""
    try:
        return int(text.replace("_", ""), 0 if re.match(r"[-+]?0[xob]", text) else 10)
    except ValueError:
        return text


def parse_float(text: str) -> float | str:
    """Return a YAML 1.2 float including ``.nan`` and ``.inf``."""
    plain = text.replace("_", "").lower()
    if plain.lstrip("+-") in (".nan", ".inf"):
        plain = plain.replace(".", "")
    try:
        return float(plain)
    except ValueError:
        return text


def join(locs: Sequence[int | str]) -> str:
    """Return a path as text, ``joints.0.b``."""
    return ".".join(str(key) for key in locs)
