"""Abaqus and CalculiX input files (.inp): nodes, elements, sets, surfaces, materials' names."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from jousto.base.arrays import Array, Ints
from jousto.base.errors import InputError, Problem, count
from jousto.mesh.cells import KINDS
from jousto.mesh.readers.inp_blocks import Block, blocks, real
from jousto.mesh.readers.raw import RawCells, RawMesh, joined, sensible

# beginnings of element types, the first that fits counts
_TYPES = (
    (r"C3D20|DC3D20", "hexahedron20"),
    (r"C3D15|DC3D15", "wedge15"),
    (r"C3D10|DC3D10", "tetra10"),
    (r"C3D8|DC3D8", "hexahedron"),
    (r"C3D6|DC3D6", "wedge"),
    (r"C3D5", "pyramid"),
    (r"C3D4|DC3D4", "tetra"),
    (r"(S|DS|M3D|CPS|CPE|CAX|SFM3D|R3D)8", "quad8"),
    (r"STRI65|(S|DS|M3D|CPS|CPE|CAX|SFM3D)6", "triangle6"),
    (r"(S|DS|M3D|CPS|CPE|CAX|SFM3D|R3D)4", "quad"),
    (r"STRI3|(S|DS|M3D|CPS|CPE|CAX|SFM3D|R3D)3", "triangle"),
)
_LINES = {"B31": "line", "B21": "line", "T3D2": "line", "T2D2": "line", "R3D2": "line"} | {
    "B32": "line3",
    "B22": "line3",
    "T3D3": "line3",
    "T2D3": "line3",
}
_SIDE = re.compile(r"S(\d)$|(SPOS|SNEG|SP|SN)$", re.IGNORECASE)
_GENERATORS = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY")


def read_inp(path: Path) -> RawMesh:
    """Return the mesh of an Abaqus or CalculiX input file as it is written there.

    The own parser keeps what general libraries drop: numbers of nodes and elements, surfaces by
    element faces, sets of sets, names regardless of case, ``*SOLID SECTION``.

    Raises
    ------
    InputError
        If the file is not an input deck, or cut off, or uses several instances, or makes nodes or
        elements from others (``*NGEN``, ``*ELCOPY`` ...).
    """
    raw = RawMesh()
    names = _Names()
    system = _System()
    seen, instances = 0, []
    surfaces: list[Block] = []
    for block in blocks(path):
        seen += block.keyword in ("NODE", "ELEMENT")
        if block.keyword == "NODE":
            ids, nodes = _nodes(block)
            nodes = system(block, nodes)
            raw.node_ids.append(ids)
            raw.nodes.append(nodes)
            if title := block.parameters.get("NSET"):
                raw.node_sets.setdefault(names(title), []).append(ids)
        elif block.keyword == "ELEMENT":
            _elements(block, raw, names)
        elif block.keyword in ("NSET", "ELSET"):
            _set(block, raw, names)
        elif block.keyword == "SURFACE":
            surfaces.append(block)
        elif block.keyword in ("SYSTEM", "PART", "END PART"):
            system = _System.of(block) if block.keyword == "SYSTEM" else _System()
        elif block.keyword in _GENERATORS:
            raise InputError(
                Problem(
                    block.where,
                    "makes nodes or elements from others, which is not done here; export the full"
                    " mesh, every node under *NODE and every element under *ELEMENT",
                )
            )
        elif block.keyword in ("SOLID SECTION", "SHELL SECTION", "BEAM SECTION"):
            title, material = block.parameters.get("ELSET"), block.parameters.get("MATERIAL")
            if title and material:
                raw.materials[names(title)] = material
        elif block.keyword == "INSTANCE":
            instances.append(block)
        elif not block.keyword and block.lines:
            lost = f"'{block.lines[0][:40]}' stands below no *KEYWORD and is not read"
            raw.left_out.append((block.place, lost))
    if len(instances) > 1:
        raise InputError(
            Problem(
                instances[1].where,
                f"{len(instances)} instances in one assembly; export one part, or write the input"
                " file without parts and assemblies",
            )
        )
    if not seen:
        raise InputError(
            Problem(
                path.name, "holds neither *NODE nor *ELEMENT, so it is no Abaqus or CalculiX mesh"
            )
        )
    for block in surfaces:  # all elements are known now
        _surface(block, raw, names)
    with open(path, "rb") as file:
        file.seek(-1, 2)
        if file.read(1) not in b"\r\n":
            raw.left_out.append((path.name, "does not end with a line end; is the file cut off?"))
    return raw


class _Names:
    """Names of sets as they were first spelt; Abaqus and CalculiX do not look at the case."""

    def __init__(self) -> None:
        self.spelt: dict[str, str] = {}

    def __call__(self, name: str) -> str:
        name = name.strip().strip('"')
        return self.spelt.setdefault(name.upper(), name)


def _nodes(block: Block) -> tuple[Ints, Array]:
    rows = [line.strip().rstrip(",").split(",") for line in block.lines]
    table = np.zeros((len(rows), 3))
    try:
        if rows and all(len(row) == 4 for row in rows):
            table[:] = np.array([row[1:] for row in rows], dtype=np.float64)
            return block.whole([row[0] for row in rows]), table
    except ValueError:
        pass
    for i, row in enumerate(rows):  # zeros may be blank, and left out at the end: '1' is the origin
        try:
            values = [real(word) for word in row[1:4]]
        except ValueError:
            found = ",".join(row)[:40]
            raise InputError(
                Problem(block.where, f"'{found}' is no node: number, x, y, z are needed")
            ) from None
        table[i, : len(values)] = values
    return block.whole([row[0] for row in rows]), table


@dataclass
class _System:
    """The rectangular system that holds for nodes: x = origin + axes x'."""

    origin: Array = field(default_factory=lambda: np.zeros(3))
    axes: Array = field(default_factory=lambda: np.eye(3))

    @classmethod
    def of(cls, block: Block) -> _System:
        """Return what the points a (origin), b (on x') and c (in the plane x'y') say.

        Without c, z' is the global z and x' the projection of ab; without b, axes are global.
        """
        words = [word for line in block.lines for word in line.strip().rstrip(",").split(",")]
        try:
            numbers = sensible(np.array([real(word) for word in words]))
        except ValueError:
            numbers = np.zeros(1)
        if not len(numbers):
            return cls()
        if len(numbers) not in (3, 6, 9):
            raise InputError(Problem(block.where, "needs the coordinates of one to three points"))
        a, *more = numbers.reshape(-1, 3)
        if not more:
            return cls(a)
        x = more[0] - a
        z = np.cross(x, more[1] - a) if len(more) > 1 else np.array([0.0, 0.0, 1.0])
        x = x - z * (float(x @ z) / max(float(z @ z), float(np.finfo(np.float64).tiny)))
        if not (np.linalg.norm(x) > 0.0 and np.linalg.norm(z) > 0.0):
            raise InputError(Problem(block.where, "its points lie on a line, which gives no axes"))
        x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
        return cls(a, np.stack([x, np.cross(z, x), z], axis=1))

    def __call__(self, block: Block, x: Array) -> Array:
        """Return positions (n, 3); ``SYSTEM=C`` means radius, angle in degrees, z."""
        kind = block.parameters.get("SYSTEM", "R").upper()[:1]
        x = sensible(x)
        if kind == "C":
            angle = np.radians(x[:, 1])
            x = np.stack([x[:, 0] * np.cos(angle), x[:, 0] * np.sin(angle), x[:, 2]], axis=1)
        elif kind != "R":
            found = block.parameters["SYSTEM"]
            raise InputError(
                Problem(
                    block.where,
                    f"SYSTEM={found} is not read; export the nodes with SYSTEM=R (x, y, z) or"
                    " SYSTEM=C (radius, degrees, z)",
                )
            )
        out: Array = self.origin + x @ self.axes.T
        return out


def _named(block: Block, parameter: str, names: _Names) -> str:
    title = block.parameters.get(parameter, "").strip('" ')
    if not title:
        raise InputError(Problem(block.where, f"has no name; write {parameter}=... behind it"))
    return names(title)


def _kind(etype: str) -> str | None:
    if etype in _LINES:
        return _LINES[etype]
    for pattern, kind in _TYPES:
        if re.match(f"({pattern})(?![0-9])", etype):
            return kind
    return None


def _elements(block: Block, raw: RawMesh, names: _Names) -> None:
    etype = block.parameters.get("TYPE", "").upper()
    kind = _kind(etype)
    if kind is None:
        found = f"{count(len(block.lines), 'element')} of type {etype or '(none)'}"
        raw.left_out.append((block.where, f"{found} not read; see Part.solid for point masses"))
        raw.unread[etype or "(none)"] += len(block.lines)
        return
    wide = KINDS[kind] + 1
    _check_lines(block, etype, wide)
    values = block.whole(block.tokens)
    if len(values) % wide:
        raise InputError(
            Problem(
                block.where,
                f"{len(values)} numbers do not make whole {etype} elements of {wide} numbers each;"
                " is the file cut off?",
            )
        )
    table = values.reshape(-1, wide)
    nodes, ids = table[:, 1:], table[:, 0]
    if kind == "line3":  # the middle node stands between the ends
        nodes = nodes[:, [0, 2, 1]]
    raw.cells.append(RawCells(kind, nodes, ids))
    if title := block.parameters.get("ELSET"):
        raw.element_sets.setdefault(names(title), []).append(ids)


def _check_lines(block: Block, etype: str, wide: int) -> None:
    """Refuse an element with more numbers than it has nodes; the next would take what is left."""
    held = 0
    for line in block.lines:
        words = len(line.replace(",", " ").split())
        held = words if held >= wide else held + words
        if held > wide:
            raise InputError(
                Problem(
                    block.where,
                    f"'{line.strip()[:40]}' has too many numbers for a {etype}: number and"
                    f" {wide - 1} nodes; is the type right?",
                )
            )


def _set(block: Block, raw: RawMesh, names: _Names) -> None:
    """Read a set of numbers, of ranges (GENERATE) or of other sets."""
    title = _named(block, block.keyword, names)
    sets = raw.node_sets if block.keyword == "NSET" else raw.element_sets
    parts = sets.setdefault(title, [])
    if "GENERATE" in block.parameters:
        for line in block.lines:
            row = block.whole(line.replace(",", " ").split())
            if len(row) not in (2, 3) or (len(row) == 3 and row[2] <= 0):
                raise InputError(Problem(block.where, "GENERATE needs first, last and step"))
            step = row[2] if len(row) == 3 else 1
            parts.append(range(int(row[0]), int(row[1]) + 1, int(step)))
        return
    words = []
    for line in block.lines:
        for word in (part.strip() for part in line.split(",")):
            if not word:
                continue
            if re.fullmatch(r"[+-]?\d+", word):
                words.append(word)
            elif names(word) in sets:
                parts += list(sets[names(word)])
            elif block.keyword == "NSET" and names(word) in raw.element_sets:
                raw.left_out.append((block.where, f"nodes of element set '{word}' not read"))
            else:
                raise InputError(Problem(block.where, f"'{word}' is neither a number nor a set"))
    if words:
        parts.append(block.whole(words))


def _surface(block: Block, raw: RawMesh, names: _Names) -> None:
    """Read a surface of nodes or of element faces."""
    title = _named(block, "NAME", names)
    of_nodes = block.parameters.get("TYPE", "ELEMENT").upper() == "NODE"
    rows = [[word.strip() for word in line.strip().rstrip(",").split(",")] for line in block.lines]
    for row in rows:
        if not row[0]:
            continue
        sets = raw.node_sets if of_nodes else raw.element_sets
        if re.fullmatch(r"\d+", row[0]):
            members = block.whole(row[:1])
        elif names(row[0]) in sets:
            members = joined(sets[names(row[0])], raw.numbers(of_nodes))
        else:
            raise InputError(Problem(block.where, f"'{row[0]}' is neither a number nor a set"))
        if of_nodes:
            raw.node_sets.setdefault(title, []).append(members)
            continue
        side = _SIDE.match(row[1]) if len(row) > 1 else None
        if side is None:
            raw.left_out.append((block.where, f"faces '{','.join(row)}' not read"))
            continue
        number = int(side[1]) - 1 if side[1] else 0
        raw.sides.setdefault(title, []).append((members, np.full(len(members), number)))
