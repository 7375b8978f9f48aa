"""Ansys archives (.cdb, written by CDWRITE), read by mapdl-archive (extra ``ansys``)."""

from __future__ import annotations

import re
from collections import Counter
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from jousto.base.arrays import Ints, some
from jousto.base.errors import InputError, Problem, count
from jousto.mesh.readers.element_types import (
    ANSYS_BRICKS,
    ANSYS_FACES,
    ANSYS_LINES,
    ANSYS_SHELLS,
    ANSYS_TETRAHEDRA,
    ansys,
    ansys_name,
)
from jousto.mesh.readers.nblock import read_nblocks
from jousto.mesh.readers.raw import RawCells, RawMesh
from jousto.mesh.readers.subprocess_reader import apart

# surface, contact and target elements, constraint equations: ignored without a message
_SILENT = {170, 172, 173, 174, 175, 176, 184}
# fields of an element before its nodes in the table of mapdl-archive
_HEAD = 10
_KINDS = {4: "tetra", 10: "tetra10", 8: "hexahedron", 20: "hexahedron20", 6: "wedge"} | {
    15: "wedge15",
    5: "pyramid",
    13: "pyramid13",
}


def read_cdb(path: Path) -> RawMesh:
    """Return the mesh of an Ansys archive; components become sets, materials ``mat<number>``.

    Bricks with repeated nodes, with which Ansys describes wedges, pyramids and tetrahedra, become
    cells of these kinds.

    Raises
    ------
    InputError
        If the extra ``ansys`` is missing, the file is truncated, or mid-side nodes are missing.
    """
    if find_spec("mapdl_archive") is None:
        raise InputError(
            Problem(path.name, "Ansys archives need mapdl-archive: pip install mapdl-archive")
        )
    data = path.read_bytes()
    announced = _announced(path, data)
    ids, positions = read_nblocks(path, data)
    archive = apart(
        path,
        "jousto.mesh.readers.cdb:archive",
        "the file is probably damaged: write it again with CDWRITE, DB",
    )
    elements = np.split(archive["elem"], np.cumsum(archive["lengths"])[:-1])
    if not len(archive["lengths"]):
        elements = []
    for number, held, what in zip(
        announced, (len(ids), len(elements)), ("nodes", "elements"), strict=True
    ):
        if held < number:
            raise InputError(
                Problem(
                    path.name,
                    f"announces {number} {what} but contains {held}: the file is truncated",
                )
            )
    raw = RawMesh([ids], [positions])
    types = {int(number): int(code) for number, code in np.asarray(archive["ekey"])}
    options: dict[int, dict[int, int]] = {}
    for number, option, value in np.asarray(archive["keyopt"]).reshape(-1, 3):
        options.setdefault(int(number), {})[int(option)] = int(value)
    found: dict[tuple[str, str, str], list[tuple[int, Ints]]] = {}
    others, broken = Counter[int](), []
    for row in elements:
        code = types.get(int(row[1]), 0)
        nodes = np.asarray(row[_HEAD:], dtype=np.int64)
        number, material = int(row[8]), f"mat{int(row[0])}"
        if code in ANSYS_BRICKS:
            kind, nodes = _brick(nodes, ANSYS_BRICKS[code])
        elif code in ANSYS_TETRAHEDRA:
            nodes = nodes[: ANSYS_TETRAHEDRA[code]]
            kind = _KINDS.get(len(nodes), "")
        elif code in ANSYS_SHELLS or code in ANSYS_FACES:
            kind, nodes = _shell(nodes)
        elif code in ANSYS_LINES:
            kind, nodes = "line", nodes[:2]
        else:
            if code not in _SILENT:
                others[code] += 1
            continue
        if not kind or np.any(nodes <= 0):
            broken.append(number)
            continue
        known = ansys(code, kind, options.get(int(row[1]), {}))
        raw.note(ansys_name(code), known, 1)
        found.setdefault((kind, material, known.formulation), []).append((number, nodes))
    if broken:
        raise InputError(
            Problem(
                path.name,
                f"{count(len(broken), 'element')} (element {some([str(i) for i in broken])}) lack"
                " midside nodes; write elements with all of them or without any",
            )
        )
    for (kind, *how), rows in found.items():
        table = np.array([nodes for _, nodes in rows])
        raw.cells.append(RawCells(kind, table, np.array([n for n, _ in rows]), *how))
    for title, members in archive["node_components"].items():
        raw.node_sets[title.strip()] = [np.asarray(members, dtype=np.int64)]
    for title, members in archive["element_components"].items():
        raw.element_sets[title.strip()] = [np.asarray(members, dtype=np.int64)]
    for code, n in others.items():
        raw.unread[f"{code}"] += n
    if others:
        names = some([f"{n} of type {code}" for code, n in others.items()])
        raw.left_out.append((path.name, f"elements not read: {names}"))
    return raw


def archive(path: Path) -> dict[str, Any]:
    """Return the content read by mapdl-archive; runs in a separate process, since it may crash."""
    import mapdl_archive

    try:
        found: Any = mapdl_archive.Archive(path, parse_vtk=False)
        elements = [np.asarray(row, dtype=np.int64) for row in found.elem]
        return {
            "ekey": np.asarray(found.ekey),
            "keyopt": np.array(
                [(n, *pair) for n, pairs in found.key_option.items() for pair in pairs], np.int64
            ).reshape(-1, 3),
            "elem": np.concatenate([np.zeros(0, np.int64), *elements]),
            "lengths": np.array([len(row) for row in elements], dtype=np.int64),
            "node_components": {k: np.asarray(v) for k, v in found.node_components.items()},
            "element_components": {k: np.asarray(v) for k, v in found.element_components.items()},
        }
    except Exception as error:
        message = f"{type(error).__name__}: {error}"[:160]
        raise InputError(
            Problem(path.name, f"cannot be read; it may be truncated (mapdl-archive: {message})")
        ) from None


def _announced(path: Path, data: bytes) -> tuple[int, int]:
    """Return the numbers of nodes and elements that the archive states (0 if it states none)."""
    out = []
    for name in (b"NBLOCK", b"EBLOCK"):
        line = re.search(rb"^[ \t]*%s\b[^\r\n]*[\r\n]" % name, data, re.MULTILINE | re.IGNORECASE)
        if line is None:
            raise InputError(
                Problem(
                    path.name,
                    f"has no {name.decode()}: the file is truncated or no archive with blocks; "
                    f"write it"
                    " with CDWRITE, DB",
                )
            )
        # name, number of fields, SOLID, highest number, number of lines
        number = b"".join(line[0].split(b",")[4:]).strip()
        out.append(int(number) if number.isdigit() else 0)
    return out[0], out[1]


def _brick(nodes: Ints, full: int) -> tuple[str, Ints]:
    """Return kind and nodes of a brick whose nodes may repeat.

    Ansys writes a wedge as ``I J K K M N O O``, a pyramid as ``I J K L M M M M`` and a tetrahedron
    as ``I J K K M M M M``, with mid-side nodes after the corners in the order of VTK.
    """
    a = nodes[:8]
    if len(a) < 8:
        return "", nodes
    quadratic = full == 20 and len(nodes) >= 20 and bool(np.any(nodes[8:20] > 0))
    m = nodes[8:20] if quadratic else np.zeros(12, dtype=np.int64)
    same = a[2] == a[3]
    if same and a[4] == a[5] == a[6] == a[7]:
        corners, middle = a[[0, 1, 2, 4]], m[[0, 1, 3, 8, 9, 10]]
    elif same and a[6] == a[7]:
        corners, middle = a[[0, 1, 2, 4, 5, 6]], m[[0, 1, 3, 4, 5, 7, 8, 9, 10]]
    elif a[4] == a[5] == a[6] == a[7]:
        corners, middle = a[:5], m[[0, 1, 2, 3, 8, 9, 10, 11]]
    else:
        corners, middle = a, m
    out = np.concatenate([corners, middle]) if quadratic else corners
    return _KINDS[len(out)], out


def _shell(nodes: Ints) -> tuple[str, Ints]:
    a = nodes[:4]
    if len(a) == 4 and a[2] != a[3]:
        return "quad", a
    return "triangle", a[:3]
