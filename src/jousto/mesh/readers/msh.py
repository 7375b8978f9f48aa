"""Gmsh's mesh files (.msh), formats 2.2 and 4.1, text and binary."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Ints
from jousto.base.errors import InputError, Problem
from jousto.mesh.cells import KINDS
from jousto.mesh.readers.raw import RawCells, RawMesh

# element numbers of Gmsh
KIND = {
    1: "line",
    2: "triangle",
    3: "quad",
    4: "tetra",
    5: "hexahedron",
    6: "wedge",
    7: "pyramid",
    8: "line3",
    9: "triangle6",
    11: "tetra10",
    15: "vertex",
    16: "quad8",
    17: "hexahedron20",
    18: "wedge15",
    19: "pyramid13",
}
# refused kinds, with the remedy
_FULL = {10: "quad9", 12: "hexahedron27", 13: "wedge18", 14: "pyramid14"}
# position in Gmsh's element of each node in VTK's order, if different
ORDER = {
    "tetra10": [0, 1, 2, 3, 4, 5, 6, 7, 9, 8],
    "hexahedron20": [0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15],
    "wedge15": [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11],
}
_NAMES = ("point", "curve", "surface", "volume")


def vtk_order(kind: str, nodes: Ints) -> Ints:
    """Return Gmsh's elements (ne, k) with their nodes in VTK's order."""
    return nodes[:, ORDER[kind]] if kind in ORDER else nodes


def read_msh(path: Path) -> RawMesh:
    """Return the content of a Gmsh mesh file.

    The parser keeps the numbers of nodes and elements, which general libraries drop. Physical
    groups keep their names: volumes as element sets, surfaces as surfaces, curves and points as
    node sets; groups without a name are ``volume1``, ``surface2`` and so on.

    Raises
    ------
    InputError
        If the file is truncated, of another version, or contains complete second-order elements.
    """
    data = path.read_bytes()
    head = re.match(rb"\s*\$MeshFormat\s+([\d.]+)\s+(\d)\s+(\d+)[ \t]*\r?\n", data)
    if head is None:
        raise InputError(
            Problem(path.name, "does not begin with $MeshFormat: this is not a Gmsh mesh")
        )
    version, binary = head[1].decode(), head[2] == b"1"
    if head[3] not in (b"4", b"8"):
        raise InputError(
            Problem(path.name, f"has a data size of {head[3].decode()}, must be 4 or 8")
        )
    reader = _Reader(path, data, binary, int(head[3]))
    if binary and data[head.end() : head.end() + 4] != b"\x01\0\0\0":
        raise InputError(Problem(path.name, "is a big-endian binary file; save it as text"))
    if version.startswith("2"):
        return reader.version_2()
    if version == "4.1":
        return reader.version_4()
    raise InputError(
        Problem(
            path.name,
            f"has Gmsh's format {version}; formats 2.2 and 4.1 are supported: open the mesh in Gmsh"
            " and save it again",
        )
    )


class _Reader:
    def __init__(self, path: Path, data: bytes, binary: bool, size: int) -> None:
        self.path, self.data, self.binary = path, data, binary
        self.size = np.dtype(f"u{size}")
        self.raw = RawMesh()
        # (dimension, group) -> name
        self.names: dict[tuple[int, int], str] = {}
        for dim, tag, name in re.findall(
            rb'^(\d)\s+(\d+)\s+"(.*)"', self.section("PhysicalNames", False), re.MULTILINE
        ):
            self.names[int(dim), int(tag)] = name.decode(errors="replace")

    def section(self, name: str, needed: bool = True) -> bytes:
        """Return the text between $Name and $EndName."""
        begin = re.search(rb"^\$%s[ \t]*\r?\n" % name.encode(), self.data, re.MULTILINE)
        end = self.data.rfind(b"$End%s" % name.encode())
        if begin is None or end < begin.end():
            if not needed and begin is None:
                return b""
            where = self.path.name
            found = "has no" if begin is None else "is truncated in"
            raise InputError(Problem(where, f"{found} ${name}; save the mesh in Gmsh again"))
        return self.data[begin.end() : end]

    def stream(self, name: str) -> _Text | _Binary:
        text = self.section(name)
        where = f"{self.path.name}: ${name}"
        return _Binary(where, text, self.size) if self.binary else _Text(where, text)

    def group(self, dim: int, tag: int, ids: Ints) -> None:
        """Store that elements belong to a physical group."""
        title = self.names.get((dim, tag), f"{_NAMES[dim]}{tag}")
        self.raw.element_sets.setdefault(title, []).append(ids)

    def cells(self, code: int, nodes: Ints, ids: Ints) -> None:
        kind = self.kind(code)
        self.raw.cells.append(RawCells(kind, vtk_order(kind, nodes), ids))

    def kind(self, code: int) -> str:
        if code in KIND:
            return KIND[code]
        if code in _FULL:
            message = (
                f"holds elements of kind {_FULL[code]}; set Mesh.SecondOrderIncomplete = 1 in Gmsh"
                " for elements without nodes inside faces and volumes"
            )
        else:
            message = f"holds elements of Gmsh's kind {code}; mesh with order 1 or 2"
        raise InputError(Problem(self.path.name, message))

    # ---- format 4.1 ------------------------------------------------------------------------------

    def version_4(self) -> RawMesh:
        groups = self._entities()
        s = self.stream("Nodes")
        blocks = int(s.sizes(4)[0])
        for _ in range(blocks):
            dim, _, parametric = s.ints(3)
            n = int(s.sizes(1)[0])
            ids = s.sizes(n)
            wide = 3 + (int(dim) if parametric else 0)
            self.raw.node_ids.append(ids)
            self.raw.nodes.append(s.floats(n * wide).reshape(n, wide)[:, :3])
        s.done()
        s = self.stream("Elements")
        blocks = int(s.sizes(4)[0])
        for _ in range(blocks):
            dim, entity, code = (int(x) for x in s.ints(3))
            n = int(s.sizes(1)[0])
            table = s.sizes(n * (1 + KINDS[self.kind(code)])).reshape(n, -1)
            self.cells(code, table[:, 1:], table[:, 0])
            for tag in groups.get((dim, entity), ()):
                self.group(dim, tag, table[:, 0])
        s.done()
        return self.raw

    def _entities(self) -> dict[tuple[int, int], list[int]]:
        """Return the physical groups of each entity (dimension, tag)."""
        groups: dict[tuple[int, int], list[int]] = {}
        if not self.section("Entities", False):
            return groups
        s = self.stream("Entities")
        for dim, n in enumerate(s.sizes(4)):
            for _ in range(int(n)):
                tag = int(s.ints(1)[0])
                s.floats(3 if dim == 0 else 6)
                tags = s.ints(int(s.sizes(1)[0]))
                groups[dim, tag] = [abs(int(t)) for t in tags]
                if dim:
                    s.ints(int(s.sizes(1)[0]))
        return groups

    # ---- format 2.2 ------------------------------------------------------------------------------

    def version_2(self) -> RawMesh:
        nodes, elements = self.section("Nodes"), self.section("Elements")
        where = self.path.name
        if self.binary:
            self._binary_2(nodes, elements)
            return self.raw
        s = _Text(f"{where}: $Nodes", nodes)
        n = int(s.sizes(1)[0])
        table = s.floats(4 * n).reshape(n, 4)
        s.done()
        self.raw.node_ids.append(whole(s.where, table[:, 0]))
        self.raw.nodes.append(table[:, 1:])
        s = _Text(f"{where}: $Elements", elements)
        values = whole(s.where, s.values)
        rows: dict[tuple[int, int], list[Ints]] = {}
        at = 1
        for _ in range(int(values[0]) if len(values) else 0):
            code, tags = (
                (int(x) for x in values[at + 1 : at + 3]) if at + 3 <= len(values) else (0, 0)
            )
            wide = 3 + tags + KINDS[self.kind(code)] if code else 3
            row = values[at : at + wide]
            if len(row) < wide or not code:
                s.cut_off()
            rows.setdefault((code, tags), []).append(row)
            at += wide
        for (code, tags), found in rows.items():
            self._rows_2(code, np.array(found)[:, 0], np.array(found)[:, 3:], tags)
        return self.raw

    def _binary_2(self, nodes: bytes, elements: bytes) -> None:
        n, rest = self._counted("Nodes", nodes)
        record = np.dtype([("id", "<i4"), ("x", "<f8", 3)])
        if len(rest) < n * record.itemsize:
            raise InputError(Problem(self.path.name, "is truncated in $Nodes"))
        table = np.frombuffer(rest, dtype=record, count=n)
        self.raw.node_ids.append(table["id"].astype(np.int64))
        self.raw.nodes.append(table["x"].copy())
        left, rest = self._counted("Elements", elements)
        s = _Binary(f"{self.path.name}: $Elements", rest, self.size)
        found: dict[tuple[int, int], list[Ints]] = {}
        while left > 0:
            code, n, tags = (int(x) for x in s.ints(3))
            rows = s.ints(n * (1 + tags + KINDS[self.kind(code)])).reshape(n, -1)
            found.setdefault((code, tags), []).append(rows)
            left -= n
        for (code, tags), parts in found.items():
            rows = np.concatenate(parts)
            self._rows_2(code, rows[:, 0], rows[:, 1:], tags)

    def _counted(self, name: str, data: bytes) -> tuple[int, bytes]:
        """Return the count in the first line of a binary section, and the bytes after it."""
        first, _, rest = data.partition(b"\n")
        if not first.strip().isdigit():
            where = f"{self.path.name}: ${name}"
            raise InputError(
                Problem(where, "does not begin with a number; the file may be damaged")
            )
        return int(first), rest

    def _rows_2(self, code: int, ids: Ints, rest: Ints, tags: int) -> None:
        """Add elements of one kind from rows of tags (the first is the group), then nodes."""
        kind = self.kind(code)
        dim = 0 if kind == "vertex" else 1 if "line" in kind else 2
        if kind not in ("vertex", "line", "line3", "triangle", "triangle6", "quad", "quad8"):
            dim = 3
        if tags:
            for tag in np.unique(rest[:, 0]):
                if tag:
                    self.group(dim, abs(int(tag)), ids[rest[:, 0] == tag])
        # an element in two groups is listed twice
        same = np.column_stack([ids, rest[:, tags:]])
        _, keep = np.unique(same, axis=0, return_index=True)
        keep = np.sort(keep)
        self.cells(code, rest[keep, tags:], ids[keep])


def whole(where: str, values: NDArray[np.float64]) -> Ints:
    """Return numbers read from text as whole numbers, or raise InputError."""
    bad = values[~((values == np.round(values)) & (np.abs(values) < 2.0**53))]
    if len(bad):
        raise InputError(
            Problem(where, f"'{bad[0]:g}' is not a whole number in range; the file may be damaged")
        )
    return values.astype(np.int64)


class _Text:
    """Numbers of a section in text form, read one group after another."""

    def __init__(self, where: str, data: bytes) -> None:
        self.where, self.at = where, 0
        try:
            self.values = np.array(data.split(), dtype=np.float64)
        except ValueError:
            raise InputError(
                Problem(where, "contains a word that is not a number; the file may be damaged")
            ) from None

    def floats(self, n: int) -> NDArray[np.float64]:
        out = self.values[self.at : self.at + n]
        if n < 0 or len(out) < n:
            self.cut_off()
        self.at += n
        return out

    def ints(self, n: int) -> Ints:
        return whole(self.where, self.floats(n))

    sizes = ints

    def done(self) -> None:
        if self.at != len(self.values):
            extra = len(self.values) - self.at
            raise InputError(
                Problem(
                    self.where, f"contains {extra} superfluous numbers; the file may be damaged"
                )
            )

    def cut_off(self) -> Any:
        raise InputError(Problem(self.where, "ends too early; the file is truncated"))


class _Binary:
    """Numbers of a binary section, read one group after another."""

    def __init__(self, where: str, data: bytes, size: np.dtype[Any]) -> None:
        self.where, self.data, self.at, self.size = where, data, 0, size

    def _take(self, n: int, dtype: Any) -> NDArray[Any]:
        kind = np.dtype(dtype)
        end = self.at + n * kind.itemsize
        if n < 0 or end > len(self.data):
            raise InputError(Problem(self.where, "ends too early; the file is truncated"))
        out = np.frombuffer(self.data, dtype=kind, count=n, offset=self.at)
        self.at = end
        return out

    def floats(self, n: int) -> NDArray[np.float64]:
        return self._take(n, "<f8").copy()

    def ints(self, n: int) -> Ints:
        return self._take(n, "<i4").astype(np.int64)

    def sizes(self, n: int) -> Ints:
        return self._take(n, self.size).astype(np.int64)

    def done(self) -> None:
        pass
