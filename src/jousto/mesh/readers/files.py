"""read_mesh: reading of mesh files, with the reader for their format."""

from __future__ import annotations

import gzip
import logging
import math
import os
import re
from collections.abc import Callable
from dataclasses import replace
from importlib import import_module
from pathlib import Path

from jousto.base.arguments import explained
from jousto.base.errors import InputError, MissingFileError, Problem, suggest, warn
from jousto.base.files import check_input
from jousto.base.units import LENGTHS
from jousto.mesh.formats import CAD, FORMATS, HEAD, MESHES, Format
from jousto.mesh.mesh import Mesh
from jousto.mesh.readers.raw import RawMesh

log = logging.getLogger(__name__)


# text meshes are compressed to a fifth or tenth of their size
MOST_PACKED = 100
LARGEST_UNPACKED = 1 << 26  # size, bytes, up to which a file is unpacked at any compression ratio
_MESHED = (
    "a %s file: name it STEM.%s and mesh it, jousto mesh STEM.%s --size '8 mm' or"
    " jo.mesh_cad(path, size=...)"
)
# other files, and the remedy
_STRANGE = (
    (rb"\AISO-10303-21", _MESHED % ("STEP", "step", "step")),
    (rb"\A(DBRep_DrawableShape|CASCADE Topology)", _MESHED % ("BREP", "brep", "brep")),
    (rb"\A.{72}S *0*1\s", "an IGES file, which contains faces but no solid: export STEP instead"),
    (rb"\A\s*solid\b[\s\S]*facet", "an STL surface: fill it with elements in a mesher first"),
    (rb"\APK\x03\x04", "a ZIP archive: unpack it first"),
    (rb"\A\s*<(!DOCTYPE html|html)", "a web page: download the file itself"),
    (rb"\A%!PS|\A%PDF|\A\x89PNG|\A\xff\xd8", "a picture or a document"),
)


@explained
def read_mesh(path: str | os.PathLike[str], *, unit: str = "m", name: str | None = None) -> Mesh:
    """Return the mesh in a file.

    The supported formats are Gmsh ``.msh`` (2.2 and 4.1), Abaqus and CalculiX ``.inp``, Nastran
    ``.bdf .nas .fem``, ``.med``, VTK ``.vtk .vtu``, universal files ``.unv`` and Ansys ``.cdb``
    (extra ``ansys``); ``.gz`` may be appended. Files with other suffixes are recognised by their
    content. Order and numbers of nodes and elements and the names of sets are those of the file.

    Parameters
    ----------
    path : path
        Path of the file.
    unit : {"m", "mm", "cm", "in", "ft", "um"}
        Unit of the coordinates in the file; mesh files have none.
    name : str, optional
        Name of the mesh; None for the name of the file.

    Raises
    ------
    InputError
        If the file is missing, empty, truncated, damaged, of another kind than its suffix, or
        contains unsupported elements.

    Warns
    -----
    JoustoWarning
        With the ignored content of the file: point masses, springs, elements of other kinds; or if
        the file contains another unit of length than the given one.

    See Also
    --------
    mesh_cad : Mesh a CAD file.
    Mesh.check : Errors and doubtful points of the mesh.

    Examples
    --------
    >>> mesh = read_mesh("tests/data/bracket.inp", unit="mm")  # doctest: +SKIP
    """
    path = Path(path)
    where = path.name
    factor = unit_factor(where, unit)
    exists(path)
    if path.suffix.lower() == ".gz":
        return _unpacked(path, unit, name)
    raw = _read(which(path), path)
    mesh = replace(raw.build(where, name or path.stem, factor), source=where)
    for place, sentence in raw.left_out:
        warn(place, sentence)
    if raw.length is not None and not math.isclose(raw.length, factor, rel_tol=1e-6):
        named = next((u for u, f in LENGTHS.items() if math.isclose(f, raw.length)), None)
        remedy = f"; give unit='{named}'" if named else ""
        warn(
            where, f"contains the unit of length {raw.length:.6g} m, but is read in {unit}{remedy}"
        )
    log.info("%s: %s", where, mesh)
    return mesh


def _read(form: Format, path: Path) -> RawMesh:
    """Return the content of a file of a format."""
    module, function = form.reader.split(".")
    reader: Callable[[Path], RawMesh] = getattr(
        import_module(f"jousto.mesh.readers.{module}"), function
    )
    return reader(path)


def exists(path: Path) -> None:
    """Raise InputError if the file does not exist; the message suggests the most similar name."""
    check_input(path)
    if not path.is_file():
        near = [file.name for file in path.parent.glob("*")] if path.parent.is_dir() else []
        hint = suggest(path.name, near) if near else f"; there is no folder '{path.parent}'"
        raise MissingFileError(Problem(path.name, f"no such file{hint}"))


def which(path: Path) -> Format:
    """Return the format of a file by suffix and content; raise InputError if the two contradict."""
    where = path.name
    with open(path, "rb") as file:
        head = file.read(HEAD)
    if not head.strip():
        raise InputError(Problem(where, "is empty"))
    for sign, what in _STRANGE:
        if re.search(sign, head[:2048], re.IGNORECASE):
            what = what.replace("STEM", path.stem)
            raise InputError(Problem(where, f"is {what}"))
    suffix = path.suffix.lower()
    named = next((fmt for fmt in FORMATS if suffix in fmt.suffixes), None)
    inside = next((fmt for fmt in FORMATS if fmt.begins(head)), None)
    if named is None and inside is None:
        known = f"{' '.join(MESHES)}; CAD files to be meshed: {' '.join(CAD)}"
        raise InputError(Problem(where, f"has no supported format; known: {known}"))
    if named is None:
        assert inside is not None
        return inside
    if named.begins(head) or inside is None:
        if inside is None and b"\0" in head[:1024] and named.name != "a MED file":
            raise InputError(Problem(where, f"is a binary file, not {named.name}"))
        return named
    raise InputError(
        Problem(
            where,
            f"has the suffix of {named.name} but contains {inside.name}; rename it to"
            f" '{path.stem}{inside.suffixes[0]}'",
        )
    )


def unit_factor(where: str, unit: str) -> float:
    """Return the length of a unit in m."""
    if unit not in LENGTHS:
        hint = suggest(unit, LENGTHS)
        raise InputError(Problem(where, f"unit is '{unit}'{hint}", path=("unit",)))
    return LENGTHS[unit]


def _unpacked(path: Path, unit: str, name: str | None) -> Mesh:
    """Read a file compressed by gzip from an unpacked copy."""
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        inner = Path(folder) / path.stem
        try:
            most = LARGEST_UNPACKED + MOST_PACKED * path.stat().st_size
            with gzip.open(path, "rb") as packed, open(inner, "wb") as copy:
                while piece := packed.read(1 << 20):
                    copy.write(piece)
                    if copy.tell() > most:
                        raise InputError(
                            Problem(
                                path.name,
                                f"unpacks to more than {MOST_PACKED} times its size, which is "
                                f"suspicious for a mesh; unpack it yourself if it is right",
                            )
                        )
        except (OSError, EOFError) as error:
            raise InputError(Problem(path.name, f"cannot be unpacked: {error}")) from None
        return read_mesh(inner, unit=unit, name=name or Path(path.stem).stem)
