"""Mesh and CAD files: formats, endings and signatures of their content."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

HEAD = 65536
"""Number of bytes at the beginning of a file for the detection of its format."""


@dataclass(frozen=True)
class Format:
    """File format: name, suffixes, reader and signature of its content."""

    name: str
    suffixes: tuple[str, ...]
    reader: str  # module and function below jousto.mesh.readers
    signs: tuple[bytes, ...]  # regular expressions, searched in the first bytes

    def begins(self, head: bytes) -> bool:
        """Return whether a file that begins with these bytes has this format."""
        return any(re.search(sign, head, re.MULTILINE | re.IGNORECASE) for sign in self.signs)


# in this order; the first matching signature counts
FORMATS = (
    Format("a Gmsh mesh", (".msh",), "msh.read_msh", (rb"\A\s*\$MeshFormat",)),
    Format(
        "a MED file",
        (".med", ".rmed", ".mmed"),
        "meshio_formats.read_med",
        (rb"\A\x89HDF\r\n\x1a\n",),
    ),
    Format("a VTK file", (".vtk",), "meshio_formats.read_vtk", (rb"\A# vtk DataFile",)),
    Format("a VTU file", (".vtu",), "meshio_formats.read_vtu", (rb"\A(<\?xml[^>]*>\s*)?<VTKFile",)),
    Format(
        "an Ansys archive",
        (".cdb",),
        "cdb.read_cdb",
        (rb"^[ \t]*/(COM|PREP7|TITLE)\b", rb"^[ \t]*(NBLOCK|EBLOCK|\*USE_RDB)\b"),
    ),
    Format(
        "an Abaqus or CalculiX input file",
        (".inp",),
        "inp.read_inp",
        (rb"^[ \t]*\*[ \t]*(HEADING|NODE|PART|INCLUDE|ELEMENT|NSET)\b",),
    ),
    Format(
        "a Nastran bulk data file",
        (".bdf", ".nas", ".fem"),
        "nastran.read_bulk",
        (rb"^(BEGIN\s+BULK|GRID[ *,]|SOL\s+\w+|CEND|CORD|CTETRA|CHEXA|MAT1|PSOLID)",),
    ),
    Format(
        "a universal file", (".unv",), "unv.read_unv", (rb"\A\s*-1[ \t]*\r?\n[ \t]*\d+[ \t]*\r?\n",)
    ),
)

MESHES = tuple(suffix for form in FORMATS for suffix in form.suffixes)
"""Endings of mesh files; ``.gz`` may follow."""

WRITTEN = {
    "vtu": ("vtu", True),
    "vtk": ("vtk", True),
    "inp": ("abaqus", True),
    "msh": ("gmsh22", False),
    "med": ("med", False),
    "bdf": ("nastran", False),
    "nas": ("nastran", False),
    "stl": ("stl", False),
}
"""Endings of written meshes: format name of meshio, and whether it supports named sets."""

CAD = (".step", ".stp", ".brep", ".brp")
"""Endings of supported CAD files."""

NO_SOLIDS = (".iges", ".igs")
"""Endings of CAD files without solids, which are refused with a remedy."""


def is_cad(path: Path) -> bool:
    """Return whether a file is a CAD file, by its name.

    >>> is_cad(Path("arm.STP")), is_cad(Path("arm.msh"))
    (True, False)
    """
    return path.suffix.lower() in (*CAD, *NO_SOLIDS)


def is_mesh(path: Path) -> bool:
    """Return whether a file is a mesh, by its name without ``.gz``.

    >>> is_mesh(Path("arm.fem")), is_mesh(Path("arm.msh.gz")), is_mesh(Path("arm.yaml"))
    (True, True, False)
    """
    name = path.with_suffix("") if path.suffix.lower() == ".gz" else path
    return name.suffix.lower() in MESHES


def begins_as_mesh(path: Path) -> bool:
    """Return whether the content of a file begins like a text mesh file."""
    if not path.is_file():
        return False
    with path.open("rb") as file:
        head = file.read(HEAD)
    return not head.startswith(b"\x89HDF") and any(form.begins(head) for form in FORMATS)
