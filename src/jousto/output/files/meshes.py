"""Mesh files for other programs."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arguments import explained_as
from jousto.base.errors import InputError, Problem, warn
from jousto.base.files import written
from jousto.mesh.formats import WRITTEN
from jousto.mesh.mesh import Mesh
from jousto.mesh.readers.files import unit_factor
from jousto.output.style import target


@explained_as("write")
def write_mesh(mesh: Mesh, path: str | Path, *, unit: str = "m") -> Path:
    """Write a mesh to a file of another program; `read_mesh` reads it again.

    Parameters
    ----------
    mesh : Mesh
    path : path
        File; its suffix selects the format: .vtu (ParaView; sets are data of points and cells),
        .vtk, .inp (Abaqus, CalculiX; sets keep their names), .msh (Gmsh 2.2), .med, .bdf, .nas, or
        .stl for the surface alone. Only .vtu, .vtk and .inp keep sets.
    unit : str
        Unit of length in the file; positions have eleven digits.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        For an unknown ending or unit, or a path that cannot be written.

    Warns
    -----
    JoustoWarning
        If the mesh has sets and the format keeps none.
    """
    out = target(path, tuple(WRITTEN))
    suffix = out.suffix.lower().lstrip(".")
    form, keeps = WRITTEN[suffix]
    factor = unit_factor("write", unit)
    if not keeps and (mesh.node_sets or mesh.element_sets) and suffix != "stl":
        warn(
            out.name, "this format is written without the sets of the mesh; .vtu and .inp keep them"
        )
    if suffix != "stl" and (lost := _unsupported(mesh, suffix)):
        text = "give formulation= to Part.solid where the file is read"
        warn(out.name, f"this format has no element for {lost}; {text}")
    try:
        import meshio
    except ImportError:
        raise InputError(
            Problem(out.name, "writing meshes needs the package meshio: pip install meshio")
        ) from None
    # eleven digits: some writers fail with long numbers such as 1e-17
    x = mesh.nodes / factor
    size = float(np.abs(x).max(initial=1e-300))
    x = np.round(x, 10 - int(np.floor(np.log10(size)))) + 0.0
    if suffix == "stl":
        corners = [(block.corners[:, [0, 1, 2]]) for block in mesh.faces]
        corners += [b.corners[:, [0, 2, 3]] for b in mesh.faces if b.corners.shape[1] == 4]
        cells: Any = [("triangle", np.concatenate(corners))]
        content = meshio.Mesh(x, cells)
    else:
        cells = [(block.kind, block.nodes) for block in mesh.cells]
        content = meshio.Mesh(x, cells, **_sets(mesh, suffix))
    # meshio prints remarks and may call sys.exit
    heard = io.StringIO()
    try:
        with (
            written(out) as beside,
            contextlib.redirect_stdout(heard),
            contextlib.redirect_stderr(heard),
        ):
            content.write(beside, file_format=form)
            if suffix == "inp":
                _types(beside, mesh)
    except (SystemExit, Exception) as error:
        if isinstance(error, InputError):
            raise
        message = " ".join((heard.getvalue() or str(error)).split())[:200]
        raise InputError(Problem(out.name, f"cannot be written (meshio: {message})")) from None
    return out


# Abaqus types of solid formulations; meshio writes modified and hybrid elements
ABAQUS_TYPES = {
    ("tetra", "full"): "C3D4",
    ("tetra10", "full"): "C3D10",
    ("wedge", "reduced"): "C3D6",
    ("wedge15", "reduced"): "C3D15",
    ("hexahedron", "full"): "C3D8",
    ("hexahedron20", "full"): "C3D20",
    ("hexahedron", "bbar"): "C3D8H",
    ("hexahedron", "incompatible"): "C3D8I",
    ("hexahedron", "reduced"): "C3D8R",
    ("hexahedron20", "reduced"): "C3D20R",
}
NEAREST_TYPES = {"wedge": "C3D6", "wedge15": "C3D15"}


def _types(path: Path, mesh: Mesh) -> None:
    """Write the element types of the formulations."""
    blocks = iter(mesh.cells)

    def named(found: re.Match[str]) -> str:
        block = next(blocks)
        nearest = NEAREST_TYPES.get(block.kind, found[2])
        return found[1] + ABAQUS_TYPES.get((block.kind, block.formulation), nearest)

    text = path.read_text(encoding="utf-8")
    text = re.sub(r"^(\*ELEMENT, *TYPE=)(\w+)", named, text, flags=re.MULTILINE | re.IGNORECASE)
    path.write_text(text, encoding="utf-8")


def _unsupported(mesh: Mesh, suffix: str) -> str:
    """Return the formulations that a format does not support; empty if there are none."""
    lost = []
    for block in mesh.solids:
        way = (block.kind, block.formulation)
        if way not in ABAQUS_TYPES if suffix == "inp" else block.formulation != "full":
            lost.append(f"{block.kind} '{block.formulation}'")
    return ", ".join(dict.fromkeys(lost))


def _sets(mesh: Mesh, suffix: str) -> dict[str, Any]:
    """Return node and element sets in meshio's form."""
    starts = np.cumsum([0, *(len(block) for block in mesh.solids)])
    solids = {
        id(block): (a, b) for block, a, b in zip(mesh.solids, starts, starts[1:], strict=False)
    }
    by_block: dict[str, list[Any]] = {}
    for name, members in mesh.element_sets.items():
        rows = []
        for block in mesh.cells:
            a, b = solids.get(id(block), (0, 0))
            inside = members[(members >= a) & (members < b)] - a
            rows.append(np.isin(np.arange(len(block)), inside))
        by_block[name] = rows
    own = {k: v for k, v in mesh.node_sets.items() if k not in mesh.element_sets}
    if suffix == "inp":
        return {
            "point_sets": {name: np.asarray(v) for name, v in own.items()},
            "cell_sets": {k: [np.flatnonzero(x) for x in rows] for k, rows in by_block.items()},
        }
    if suffix not in ("vtu", "vtk"):
        return {}
    everyone = np.arange(len(mesh.nodes))
    return {
        "point_data": {name: np.isin(everyone, v).astype(np.int32) for name, v in own.items()},
        "cell_data": {k: [x.astype(np.int32) for x in rows] for k, rows in by_block.items()},
    }
