"""VTK, VTU and MED files, read by meshio."""

from __future__ import annotations

import contextlib
import io
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from jousto.base.arrays import Ints
from jousto.base.errors import InputError, Problem, count
from jousto.mesh.cells import KINDS, SOLIDS, Cells, base, mirrored
from jousto.mesh.quality import volumes
from jousto.mesh.readers.raw import Members, RawCells, RawMesh
from jousto.mesh.readers.subprocess_reader import apart

# largest number of different values of whole-number arrays that become sets
_VALUES = 64


def read_vtu(path: Path) -> RawMesh:
    """Return the mesh of a VTU file; whole-number data of cells and points become sets."""
    return _with_data(path, _load(path, "vtu"))


def read_vtk(path: Path) -> RawMesh:
    """Return the mesh of a legacy VTK file; see :func:`read_vtu`."""
    mesh = _load(path, "vtk")
    # meshio reads truncated files without an error
    match = re.search(rb"^CELL_TYPES\s+(\d+)", path.read_bytes(), re.MULTILINE)
    found = sum(len(block.data) for block in mesh.cells)
    if match and int(match[1]) > found:
        raise InputError(
            Problem(
                path.name,
                f"announces {int(match[1])} cells but contains {found}; the file is truncated",
            )
        )
    return _with_data(path, mesh)


def read_med(path: Path) -> RawMesh:
    """Return the mesh of a MED file (Salome, Code_Aster, Gmsh) with its groups as sets."""
    mesh = _load(path, "med")
    raw = _plain(path, mesh)
    _mirror(raw)
    for tags, families, sets, all_ids in (
        (mesh.point_data.get("point_tags"), mesh.point_tags, raw.node_sets, raw.node_ids),
        *(
            (tags, mesh.cell_tags, raw.element_sets, [block.ids])
            for tags, block in zip(mesh.cell_data.get("cell_tags", []), raw.cells, strict=False)
        ),
    ):
        if tags is None:
            continue
        for number, titles in families.items():
            members = all_ids[0][np.asarray(tags) == number]
            for title in titles:
                if title:
                    sets.setdefault(title, []).append(members)
    return raw


def _with_data(path: Path, mesh: Any) -> RawMesh:
    raw = _plain(path, mesh)
    _mirror(raw, only="wedge")
    # numbers of nodes and elements, by the array names that various programs use
    for title, values in mesh.point_data.items():
        _sets(raw.node_sets, title, [np.asarray(values)], [raw.node_ids[0]])
    for title, parts in mesh.cell_data.items():
        kept = [np.asarray(v) for v, c in zip(parts, mesh.cells, strict=True) if c.type in KINDS]
        _sets(raw.element_sets, title, kept, [block.ids for block in raw.cells])
    return raw


def _sets(sets: dict[str, Members], title: str, values: list[Any], ids: list[Ints]) -> None:
    """Create sets from data that have only a few different whole numbers."""
    if not values or any(v.ndim != 1 or v.dtype.kind not in "iu" for v in values):
        return
    every = np.unique(np.concatenate(values))
    if not 1 <= len(every) <= _VALUES:
        return
    flag = set(every.tolist()) <= {0, 1}
    for value in every:
        if flag and value == 0:
            continue
        name = title if flag else f"{title}={value}"
        members: Members = [i[v == value] for v, i in zip(values, ids, strict=True)]
        sets[name] = members


def load_meshio() -> Any:
    """Return the package meshio, with the 15-node wedge added to its table of dimensions."""
    import meshio

    with contextlib.suppress(ImportError):
        from meshio._mesh import topological_dimension

        topological_dimension.setdefault("wedge15", 3)
    return meshio


def _load(path: Path, form: str) -> Any:
    """Return meshio's mesh; any error of meshio becomes one message."""
    try:
        meshio = load_meshio()
    except ImportError:
        raise InputError(
            Problem(path.name, f"a .{form} file needs the package meshio: pip install meshio")
        ) from None
    if form == "med":  # HDF5 may crash on damaged files
        found = apart(
            path, f"{__name__}:med_arrays", "the file is probably damaged: export it again"
        )
        cells = [SimpleNamespace(type=kind, data=data) for kind, data in found.pop("cells")]
        return SimpleNamespace(**found, cells=cells)
    return _loaded(meshio, path, form)


def med_arrays(path: Path) -> dict[str, Any]:
    """Return the content of a MED file read by meshio; runs in a separate process."""
    mesh = _loaded(load_meshio(), path, "med")
    return {
        "points": mesh.points,
        "cells": [[block.type, block.data] for block in mesh.cells],
        "point_data": mesh.point_data,
        "cell_data": mesh.cell_data,
        "point_tags": mesh.point_tags,
        "cell_tags": mesh.cell_tags,
    }


def _loaded(meshio: Any, path: Path, form: str) -> Any:
    heard = io.StringIO()
    try:
        # meshio prints its messages and exits
        with contextlib.redirect_stdout(heard), contextlib.redirect_stderr(heard):
            return meshio.read(path, file_format=form)
    except SystemExit:
        message = " ".join(heard.getvalue().split()).removeprefix("Error: ")
    except Exception as error:
        message = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    raise InputError(
        Problem(
            path.name,
            f"cannot be read as a .{form} file; it may be truncated or damaged (meshio: "
            f"{message[:200]})",
        )
    )


def _plain(path: Path, mesh: Any) -> RawMesh:
    """Return nodes and cells numbered from 1 in the order of the file."""
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        dimensions = points.shape[1] if points.ndim == 2 else 0
        raise InputError(
            Problem(path.name, f"is a mesh in {count(dimensions, 'dimension')}, three are needed")
        )
    raw = RawMesh([np.arange(1, len(points) + 1)], [points])
    first = 1
    for block in mesh.cells:
        ids = np.arange(first, first + len(block.data))
        first += len(block.data)
        if block.type in KINDS:
            raw.cells.append(RawCells(block.type, np.asarray(block.data, np.int64) + 1, ids))
        elif block.type in ("hexahedron27", "wedge18", "tetra14", "hexahedron24"):
            raise InputError(
                Problem(
                    path.name,
                    f"holds {count(len(ids), 'element')} of kind {block.type}; write quadratic"
                    " elements without nodes inside faces and volumes (serendipity)",
                )
            )
        else:
            raw.left_out.append((path.name, f"{len(ids)} cells of kind {block.type} are not read"))
    for block in raw.cells:
        low, high = block.nodes.min(initial=1), block.nodes.max(initial=1)
        if low < 1 or high > len(points):
            raise InputError(
                Problem(path.name, f"an element uses node {high}, there are {len(points)}")
            )
    return raw


def _mirror(raw: RawMesh, only: str = "") -> None:
    """Mirror elements with negative volume if all elements have it, by the format's node order.

    The node order of MED gives all solids negative volumes, and the node order of VTK the linear
    wedges; files in which only some volumes are negative are left unchanged.
    """
    nodes = raw.nodes[0]
    for block in raw.cells:
        if block.kind not in SOLIDS or (only and base(block.kind) != only) or not len(block.ids):
            continue
        corners = SOLIDS[base(block.kind)]
        straight = Cells(base(block.kind), block.nodes[:, :corners] - 1)
        if np.all(volumes(nodes, [straight]) < 0.0):
            block.nodes = block.nodes[:, mirrored(block.kind)]
