"""Reader of YAML and JSON files: plain data and the line of every entry."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

from jousto.base.errors import InputError, MissingFileError, Problem, Problems
from jousto.base.files import check_text
from jousto.base.garbage_collection import uncollected
from jousto.base.object_repr import described
from jousto.mesh.formats import is_cad, is_mesh
from jousto.robots.readers.suffixes import SUFFIXES

DOCUMENTS = (".yaml", ".yml", ".json")  # suffixes of hand-written files
MODELS = (*DOCUMENTS, *SUFFIXES)  # suffixes of files that `read_model` reads

Loc: TypeAlias = tuple[int | str, ...]


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
        """Return a message, with the expression that gave the value at a path if there is one."""
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
        If the file does not exist or is not text; for syntax errors, with their lines; for repeated
        keys, and for content that is not a mapping, is nested too deeply or has too many entries.
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
    """Return the advice for a CAD file or a mesh that was given instead of a model file."""
    if is_cad(path):
        what, mesh, look = "a CAD file", f"{{cad: {path.name}, size: 8 mm}}", " --size '8 mm'"
    else:
        # VTK files written by jousto are in metres; decks contain no unit
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
    # local import: needed for model files only
    from yaml import MarkedYAMLError, YAMLError

    from jousto.schema.file.syntax_errors import syntax_problem, wrong_sign
    from jousto.schema.file.yaml_reader import YamlReader

    problems = Problems()
    try:
        data = YamlReader(text, name, problems).read()
    except MarkedYAMLError as error:
        raise InputError(syntax_problem(error, text, name)) from None
    except (YAMLError, UnicodeEncodeError) as error:
        found = wrong_sign(text, name) or Problem(name, f"cannot be read: {error}")
        raise InputError(found) from None
    except RecursionError:
        raise InputError(Problem(name, "is nested too deeply")) from None
    problems.raise_if_any()
    if not isinstance(data, dict):
        raise InputError(
            Problem(f"{name}:1", "must be a mapping such as 'bodies: ...' at the top level")
        )
    return Document(name, text, data, folder or Path())


@uncollected()
def read_lines(text: str) -> dict[Loc, int]:
    """Return the line (from 1) of every readable entry of a text, by the path of the entry."""
    from jousto.schema.file.yaml_reader import YamlReader

    lines: dict[Loc, int] = {}
    YamlReader(text, "", Problems(), lines).read()
    return lines
