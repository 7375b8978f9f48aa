"""Universal files (.unv) of I-DEAS, Salome, Gmsh and NX: nodes, elements and groups.

Data sets 2411, 781 and 15 (nodes), 2412 and 780 (elements), 2420 (coordinate systems), 164 (units)
and 752, 2417 to 2477 (groups), as described by the Structural Dynamics Research Laboratory of the
University of Cincinnati. Mid-side nodes are listed between the corners.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from jousto.base.arrays import Array, some
from jousto.base.errors import InputError, Problem
from jousto.mesh.cells import KINDS
from jousto.mesh.readers.raw import RawCells, RawMesh, sensible

# finite element descriptors by kind; 4x plane stress, 5x plane strain, 6x plate, 7x membrane,
# 8x axisymmetric, 9x shell
_KINDS = (
    {111: "tetra", 118: "tetra10", 112: "wedge", 113: "wedge15"}
    | {115: "hexahedron", 116: "hexahedron20", 71: "quad", 72: "triangle6", 74: "triangle"}
    | {10 * family + 1: "triangle" for family in (4, 5, 6, 8, 9)}
    | {10 * family + 2: "triangle6" for family in (4, 5, 6, 8, 9)}
    | {10 * family + 4: "quad" for family in (4, 5, 6, 8, 9)}
    | {10 * family + 5: "quad8" for family in range(4, 10)}
    | {11: "line", 21: "line", 22: "line", 23: "line", 24: "line"}
)
# rods and beams have a line with their orientation before the line with their nodes
_BEAMS = (11, 21, 22, 23, 24, 31, 32)
# springs, masses, rigid elements
_SILENT = (121, 122, 136, 137, 138, 139, 141, 142, 151, 152, 161)
# positions of the nodes of a kind in the file
_ORDER = {
    "triangle6": [0, 2, 4, 1, 3, 5],
    "quad8": [0, 2, 4, 6, 1, 3, 5, 7],
    "tetra10": [0, 2, 4, 9, 1, 3, 5, 6, 7, 8],
    "wedge15": [0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8],
    "hexahedron20": [0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11],
}
_NODES, _ELEMENTS = (15, 781, 2411), (780, 2412)
# data sets of groups, and count of numbers per member
_GROUPS = dict.fromkeys((752, 2417, 2429, 2430, 2432), 2) | dict.fromkeys(
    (2435, 2452, 2467, 2477), 4
)


@dataclass(frozen=True)
class _Set:
    """Data set: its number, its lines, and the number of its first line in the file."""

    number: int
    lines: list[str]
    first: int
    name: str

    def where(self, i: int) -> str:
        """File and line i of the data set, for messages."""
        return f"{self.name}:{self.first + i}: data set {self.number}"

    def whole(self, i: int, least: int) -> list[int]:
        """Return the whole numbers of line i; the line must have at least `least` of them."""
        words = self.lines[i].split() if i < len(self.lines) else []
        if len(words) < least or not all(re.fullmatch(r"[+-]?\d{1,18}", word) for word in words):
            raise self.wrong(i, f"{least} whole numbers")
        return [int(word) for word in words]

    def wrong(self, i: int, wanted: str) -> InputError:
        """Return the error for a line with wrong content."""
        message = f"'{self.lines[i].strip()[:60]}'" if i < len(self.lines) else "the end"
        return InputError(
            Problem(
                self.where(i), f"{message}, must be {wanted}; the file may be truncated or damaged"
            )
        )


def read_unv(path: Path) -> RawMesh:
    """Return the mesh of a universal file; properties, materials and groups become sets.

    Warns
    -----
    JoustoWarning
        If the file has another unit of length than the one given to `read_mesh`.

    Raises
    ------
    InputError
        With the line of truncated data, and for nodes in other systems than the basic one.
    """
    raw = RawMesh(either_sense=True)
    found = list(_sets(path))
    systems = {label for data in found if data.number == 2420 for label in _turned(data)}
    for data in found:
        if data.number in _NODES:
            _nodes(data, raw, systems)
        elif data.number in _ELEMENTS:
            _elements(data, raw)
    for data in found:
        if data.number in _GROUPS:
            _groups(data, raw)
        elif data.number == 164:
            raw.length = _length(data)
    if not raw.node_ids:
        held = some([str(data.number) for data in found]) or "none"
        sentence = f"has no nodes (data set 2411): it is not a mesh; it has the data sets {held}"
        raise InputError(Problem(path.name, sentence))
    if raw.unread:
        names = some([f"{n} of type {code}" for code, n in raw.unread.items()])
        raw.left_out.append((path.name, f"elements not read: {names}"))
    return raw


def _sets(path: Path) -> Iterator[_Set]:
    """Yield the data sets, which are enclosed in lines of -1."""
    lines = path.read_text(encoding="latin-1").splitlines()
    marks = [i for i, line in enumerate(lines) if line.strip() == "-1" and len(line) <= 6]
    if len(marks) % 2:
        raise InputError(
            Problem(
                f"{path.name}:{marks[-1] + 1}", "a data set is not closed: the file is truncated"
            )
        )
    for a, b in zip(marks[::2], marks[1::2], strict=True):
        head = re.match(r"\s*(\d+)", lines[a + 1]) if b > a + 1 else None
        if head:
            yield _Set(int(head[1]), lines[a + 2 : b], a + 3, path.name)


def _turned(data: _Set) -> list[int]:
    """Return the coordinate systems that are not the basic one."""
    out = []
    for i in range(2, len(data.lines) - 5, 6):
        label, kind = data.whole(i, 2)[:2]
        rows = np.array(_reals(data, range(i + 2, i + 6))).reshape(4, 3)
        if kind != 0 or not np.array_equal(rows, np.eye(4, 3)):
            out.append(label)
    return out


def _reals(data: _Set, lines: range) -> list[list[float]]:
    """Return three real numbers of each line; the form ``1.5D+00`` is allowed."""
    out = []
    for i in lines:
        words = data.lines[i].replace("D", "E").replace("d", "e").split()
        try:
            out.append([float(word) for word in words[:3]])
        except ValueError:
            raise data.wrong(i, "three numbers") from None
        if len(words) < 3:
            raise data.wrong(i, "three numbers")
    return out


def _nodes(data: _Set, raw: RawMesh, systems: set[int]) -> None:
    if data.number == 15:  # number, systems and position in one line
        rows = [data.lines[i].split() for i in range(len(data.lines))]
        split = [line for row in rows for line in (" ".join(row[:4]), " ".join(row[4:]))]
        data = _Set(15, split, data.first, data.name)
    heads = [data.whole(i, 4) for i in range(0, len(data.lines), 2)]
    if len(data.lines) % 2:
        raise data.wrong(len(data.lines), "three numbers")
    for i, head in enumerate(heads):
        if head[1] in systems:
            raise InputError(
                Problem(
                    data.where(2 * i),
                    f"node {head[0]} is given in the coordinate system {head[1]}, which is not the "
                    "basic one; export in one rectangular system",
                )
            )
    place: Array = np.array(_reals(data, range(1, len(data.lines), 2))).reshape(-1, 3)
    raw.node_ids.append(np.array([head[0] for head in heads], dtype=np.int64))
    raw.nodes.append(sensible(place))


def _elements(data: _Set, raw: RawMesh) -> None:
    rows: dict[str, list[tuple[int, list[int]]]] = {}
    properties: dict[str, list[int]] = {}
    materials: dict[str, list[int]] = {}
    wide = 6 if data.number == 2412 else 8
    i = 0
    while i < len(data.lines):
        head = data.whole(i, wide)
        label, code, count = head[0], head[1], head[wide - 1]
        pid, mat = (head[2], head[3]) if wide == 6 else (head[3], head[5])
        i += 2 if code in _BEAMS else 1
        nodes: list[int] = []
        while len(nodes) < count:
            nodes += data.whole(i, 1)
            i += 1
        kind = _KINDS.get(code)
        if kind is None:
            if code not in _SILENT:
                raw.unread[str(code)] += 1
            continue
        given = len(nodes)
        nodes = [nodes[0], nodes[-1]] if kind == "line" else nodes
        if len(nodes) != KINDS[kind] or count != given:
            message = f"element {label} of type {code} has {count} nodes, {given} are listed"
            sentence = f"{message}; must be {KINDS[kind]}; the file may be truncated or damaged"
            raise InputError(Problem(data.where(i - 1), sentence))
        order = _ORDER.get(kind, range(len(nodes)))
        rows.setdefault(kind, []).append((label, [nodes[j] for j in order]))
        properties.setdefault(f"pid{pid}", []).append(label)
        materials.setdefault(f"mat{mat}", []).append(label)
    for kind, found in rows.items():
        ids = np.array([label for label, _ in found], dtype=np.int64)
        raw.cells.append(RawCells(kind, np.array([n for _, n in found], dtype=np.int64), ids))
    for title, labels in (properties | materials).items():
        if title not in ("pid0", "mat0"):
            raw.element_sets.setdefault(title, []).append(np.array(labels))
    raw.materials |= {title: title for title in materials if title != "mat0"}


def _groups(data: _Set, raw: RawMesh) -> None:
    """Add the nodes (type 7) and elements (type 8) of groups as sets."""
    wide = _GROUPS[data.number]
    i = 0
    while i < len(data.lines):
        count = data.whole(i, 2)[-1]
        title = data.lines[i + 1].strip() if i + 1 < len(data.lines) else ""
        head, i = i, i + 2
        words: list[int] = []
        while len(words) < wide * count:
            words += data.whole(i, 1)
            i += 1
        members = np.array(words[: wide * count], dtype=np.int64).reshape(count, wide)
        title = title or f"group{data.whole(head, 2)[0]}"
        for code, sets in ((7, raw.node_sets), (8, raw.element_sets)):
            labels = members[members[:, 0] == code, 1]
            if len(labels):
                sets.setdefault(title, []).append(labels)


def _length(data: _Set) -> float:
    """Return the length unit in m; coordinates are divided by the factor in the data set."""
    factor = _reals(data, range(1, 2))[0][0] if len(data.lines) > 1 else 1.0
    return 1.0 / factor if factor > 0.0 else 1.0
