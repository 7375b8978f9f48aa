"""Parts of type ``matrices``: files of other programs, and superelements."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from jousto.schema.file.document import Loc
from jousto.schema.file.files import read_matrix, read_points
from jousto.schema.make.declared import build_declared

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder

# arguments of matrix files of other programs only
FOREIGN = ("dofs", "format", "units")
# arguments of matrices without a map of their rows only
ORDERED = ("dofs_per_node", "elements")


def is_superelement(entry: Any) -> bool:
    """Whether the matrices of an entry are already reduced."""
    return bool(entry.type == "matrices" and entry.reduce.type == "superelement")


def build_matrices(builder: Builder, loc: Loc, name: str, entry: Any) -> Any:
    """Return the Part of an entry; None, with problems, if it is invalid."""
    from jousto.parts.matrices.plain import SUFFIXES
    from jousto.parts.part import Part

    values = entry.given("reduce", "in_plane", "keep", "interfaces")
    before = len(builder.found)
    values["interfaces"] = [
        build_declared(builder, (*loc, "interfaces", i), item)
        for i, item in enumerate(entry.interfaces or ())
    ]
    if len(builder.found) > before:
        return None
    suffix = Path(entry.K).suffix.lower()
    plain = entry.M is not None and suffix in SUFFIXES and not any(k in values for k in FOREIGN)
    if not plain or _has_program(builder, entry):
        files = _files(builder, loc, values)
        return None if files is None else builder.make(loc, Part.from_file, **files, name=name)

    # node after node, node sets counted from 0
    for key in ("M", "K"):
        values[key] = builder.make((*loc, key), read_matrix, builder.file(values[key]))
    if isinstance(entry.nodes, str):
        values["nodes"] = builder.make((*loc, "nodes"), read_points, builder.file(entry.nodes))
    elif entry.nodes is None:
        builder.note(loc, "nodes is missing: positions, or the file of a mesh or table")
    if len(builder.found) > before:
        return None
    return builder.make(loc, Part.from_matrices, **values, name=name)


def build_superelement(builder: Builder, loc: Loc, name: str, entry: Any) -> Any:
    """Return the ReducedPart of a superelement; None, with problems, if it is invalid."""
    from jousto.parts.matrices.read import read_matrices
    from jousto.reduction.superelement import reduce_superelement

    values = entry.given("reduce", "in_plane", "keep", "interfaces")
    if entry.interfaces is not None:
        builder.note((*loc, "interfaces"), "a superelement is condensed already; leave it out")
        return None
    sets = values.pop("node_sets", {})
    files = _files(builder, loc, values)
    matrices: Any = None if files is None else builder.make(loc, read_matrices, **files, name=name)
    if matrices is not None:
        matrices = builder.make((*loc, "node_sets"), matrices.with_sets, sets)
    if matrices is None:
        return None
    limits = entry.reduce.given()
    return builder.make((*loc, "reduce"), reduce_superelement, matrices, **limits)


def _has_program(builder: Builder, entry: Any) -> bool:
    """Whether a .mtx file is from Abaqus, or the nodes come from a mesh."""
    from jousto.parts.matrices.abaqus import is_abaqus
    from jousto.parts.matrices.nodes import TABLES

    path = builder.file(entry.K)
    if path.suffix.lower() == ".mtx" and path.is_file() and is_abaqus(path):
        return True
    return isinstance(entry.nodes, str) and Path(entry.nodes).suffix.lower() not in TABLES


def _files(builder: Builder, loc: Loc, values: dict[str, Any]) -> dict[str, Any] | None:
    """Return the arguments, with the paths of files relative to the document's folder."""
    before = len(builder.found)
    for key in ORDERED:
        if key in values:
            builder.note(
                (*loc, key), "is for plain matrices node after node; here the files tell, leave out"
            )
    values = {key: value for key, value in values.items() if key not in ORDERED}
    for key in ("K", "M", "dofs", "nodes"):
        if isinstance(values.get(key), str):
            values[key] = builder.file(values[key])
    return values if len(builder.found) == before else None
