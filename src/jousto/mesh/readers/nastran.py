"""Nastran bulk data files (.bdf, .nas): grid points in coordinate systems, elements, sets."""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path

import numpy as np

from jousto.base.arrays import Array, Ints, some
from jousto.base.errors import InputError, Problem, Problems
from jousto.mesh.cells import KINDS
from jousto.mesh.readers.bulk import Card, cards
from jousto.mesh.readers.element_types import NASTRAN, SHELL, ElementType, nastran_solid
from jousto.mesh.readers.raw import Members, RawCells, RawMesh, joined, sensible

# card -> (kind with corners only, kind with mid-side nodes)
_SOLIDS = {
    "CTETRA": ("tetra", "tetra10"),
    "CHEXA": ("hexahedron", "hexahedron20"),
    "CPENTA": ("wedge", "wedge15"),
    "CPYRAM": ("pyramid", "pyramid13"),
    "CPYRA": ("pyramid", "pyramid13"),
}
_SHELLS = {
    "CTRIA3": ("triangle", ""),
    "CTRIAR": ("triangle", ""),
    "CTRIA6": ("triangle", "triangle6"),
    "CQUAD4": ("quad", ""),
    "CQUADR": ("quad", ""),
    "CSHEAR": ("quad", ""),
    "CQUAD8": ("quad", "quad8"),
}
_LINES = {"CROD": 2, "CBAR": 2, "CBEAM": 2, "CTUBE": 2, "CONROD": 1}  # first field of the nodes
# Nastran lists the mid-side nodes of the upright edges before those of the top
_ORDER = {
    "hexahedron20": [*range(12), 16, 17, 18, 19, 12, 13, 14, 15],
    "wedge15": [*range(9), 12, 13, 14, 9, 10, 11],
}
_THIN = ("PSHELL", "PCOMP", "PSHEAR", "PBAR", "PBEAM", "PROD", "PTUBE")
# cards without effect on the mesh or its mass
_SILENT = re.compile(
    r"(PARAM|MAT|P[A-Z]|SPC|FORCE|MOMENT|LOAD|GRAV|EIG|TABLE|TSTEP|FREQ|PLOTEL|DMIG|SPOINT|ASET"
    r"|BSET|CSET|QSET|USET|SUPORT|DLOAD|RLOAD|TLOAD|DAREA|DELAY|DPHASE|TEMP|MPCADD|NSM|CORD|SET"
    r"|BC|DESVAR|DRESP|DCONSTR|DVPREL|ENDDATA|BEGIN)"
)


# remedies for unsupported cards
_REMEDIES = (
    (r"CONM|CMASS", "; give point masses to Part.solid"),
    (
        r"MPC|RBAR|RBE1|RROD|RTRPLT|RSPLINE|RJOINT",
        ": the nodes are not tied; tie them by an Interface of the part",
    ),
    (r"", ": they are ignored in the mesh"),
)


def read_bulk(path: Path) -> RawMesh:
    """Return the mesh of a Nastran bulk data file.

    Supported are GRID in coordinate systems CORD1R/C/S and CORD2R/C/S, CTETRA, CHEXA, CPENTA and
    CPYRAM with or without all their midside nodes, shells and lines for drawing, SET1, and the
    nodes of RBE2 and RBE3 as the node sets ``rbe2_<number>``. Properties become element sets
    ``pid<number>``, their materials ``mat<number>``. The parser keeps numbers and coordinate
    systems, which general libraries drop.

    Warns
    -----
    JoustoWarning
        If the end of the bulk data is missing.

    Raises
    ------
    InputError
        With the line of the first entry that cannot be read.
    """
    raw = RawMesh(either_sense=True)
    points: list[tuple[int, int, float, float, float]] = []
    systems: dict[int, Card] = {}
    elements: dict[str, list[tuple[Card, list[int]]]] = {}
    networks: dict[int, tuple[str, str]] = {}  # IN and ISOP of PSOLID
    thin = set[
        int
    ]()  # property for shells, beams and rods without one, by which Gmsh describes surfaces
    properties: dict[int, list[int]] = {}
    materials: dict[int, int] = {}
    numbers: list[tuple[Card, Members]] = []
    default: int | None = None
    problems, other, partial = Problems(), Counter[str](), Counter[str]()
    for card in cards(path, 0):
        name = card.name
        if name == "GRID":
            cp = card.whole(1, -1)
            xyz = (card.real(2, 0.0), card.real(3, 0.0), card.real(4, 0.0))
            points.append((card.whole(0), cp, *xyz))
        elif name == "GRDSET":
            if default not in (None, card.whole(1, 0)):
                problems.add(card.where, "is defined twice with different systems; remove one")
            default = card.whole(1, 0)
        elif name in _SOLIDS or name in _SHELLS:
            kind, nodes = _element(card, problems, partial)
            elements.setdefault(kind, []).append((card, nodes))
            properties.setdefault(card.whole(1, 0), []).append(card.whole(0))
        elif name in _LINES:
            first = _LINES[name]
            nodes = [card.whole(first), card.whole(first + 1)]
            elements.setdefault("line", []).append((card, nodes))
        elif name.startswith("CORD"):
            _system(card, systems)
        elif name == "PSOLID":
            materials[card.whole(0)] = card.whole(1, 0)
            networks[card.whole(0)] = card.field(3), card.field(5)
        elif name.startswith(_THIN):
            thin.add(card.whole(0))
        elif name in ("RBE2", "RBE3", "SET1"):
            numbers.append((card, _members(card)))
        elif not _SILENT.match(name):
            other[name] += 1
    problems.raise_if_any()
    if not points:
        raise InputError(
            Problem(
                path.name, "contains no GRID entries; check that it is a complete bulk data file"
            )
        )

    ids = np.array([p[0] for p in points])
    raw.node_ids.append(ids)
    # blank fields of GRID have the values of GRDSET; 0 is the basic system
    points = [(p[0], (default or 0) if p[1] == -1 else p[1], *p[2:]) for p in points]
    raw.nodes.append(_positions(path, points, systems))
    for kind, rows in elements.items():
        of_type: dict[ElementType, list[tuple[Card, list[int]]]] = {}
        for card, nodes in rows:
            found_type = _type(card, kind, networks)
            of_type.setdefault(found_type, []).append((card, nodes))
            if found_type.solid or card.name == "CONROD" or card.whole(1, 0) in thin:
                raw.note(card.name, found_type, 1)
        for found_type, some_rows in of_type.items():
            table = np.array([nodes for _, nodes in some_rows])
            table = table[:, _ORDER[kind]] if kind in _ORDER else table
            labels = np.array([card.whole(0) for card, _ in some_rows])
            how = found_type.formulation
            raw.cells.append(RawCells(kind, table, labels, formulation=how))
    for pid, members in properties.items():
        title = f"pid{pid}"
        raw.element_sets[title] = [np.array(members)]
        if pid in materials:
            raw.materials[title] = f"mat{materials[pid]}"
    for card, found in numbers:
        _add_set(raw, card, found, ids)
    text = path.read_text(encoding="latin-1").upper()
    if "BEGIN BULK" in text and "ENDDATA" not in text:
        raw.left_out.append((path.name, "has no ENDDATA; the file may be truncated"))
    if partial:
        names = some([f"{n} {name}" for name, n in partial.items()])
        raw.left_out.append((path.name, f"{names} lack some midside nodes: read by their corners"))
    if other:
        for pattern, remedy in _REMEDIES:
            held = {name: n for name, n in other.items() if re.match(pattern, name)}
            other -= Counter(held)
            if held:
                names = some([f"{n} {name}" for name, n in held.items()])
                raw.left_out.append((path.name, f"{names} not read{remedy}"))
    return raw


# ---- entries -----------------------------------------------------------------------------------


def _element(card: Card, problems: Problems, partial: Counter[str]) -> tuple[str, list[int]]:
    """Return kind and nodes of a solid or shell element; a shell may lack some midside nodes."""
    low, high = (_SOLIDS | _SHELLS)[card.name]
    corners = [card.whole(2 + i) for i in range(KINDS[low])]
    middle = range(2 + len(corners), 2 + KINDS[high]) if high else range(0)
    given = [i for i in middle if card.field(i) not in ("", "0")]
    if given and len(given) == len(middle):
        return high, corners + [card.whole(i) for i in middle]
    if given and card.name in _SHELLS:
        partial[card.name] += 1
    elif given:
        problems.add(
            card.where,
            f"element {card.field(0)} has {len(given)} of {len(middle)} midside"
            " nodes; export with all of them or with none (the file may be truncated)",
        )
    return low, corners


def _type(card: Card, kind: str, networks: dict[int, tuple[str, str]]) -> ElementType:
    """Return the kind for an element, with the integration given by its PSOLID."""
    if card.name in _SOLIDS and not kind.startswith("pyramid"):
        return nastran_solid(card.name, KINDS[kind], *networks.get(card.whole(1, 0), ("", "")))
    known = NASTRAN.get(
        (card.name, KINDS[kind])
    )  # shells without mid-side nodes are not in the table
    return known or ElementType(kind, replaced=SHELL)


def _title(card: Card) -> str:
    return f"{'set' if card.name == 'SET1' else card.name.lower() + '_'}{card.field(0)}"


def _members(card: Card) -> Members:
    """Return the nodes of an RBE2, an RBE3 or a set, with ranges ``1 THRU 9``."""
    first = {"SET1": 1, "RBE2": 3, "RBE3": 4}[card.name]
    fields = card.fields[first:]
    single: list[int] = []
    out: Members = []
    skip = 0
    for i, word in enumerate(fields):
        if skip:
            skip -= 1
        elif not word:
            continue
        elif word.upper() == "THRU" and single:
            last = card.whole(first + i + 1)
            if last < single[-1]:
                raise card.wrong(first + i + 1, f"{single[-1]} or more")
            out.append(range(single.pop(), last + 1))
            skip = 1
        elif card.name == "RBE3" and word.upper() in ("UM", "ALPHA"):
            break
        elif re.fullmatch(r"\d+", word):
            single.append(card.whole(first + i))
        elif card.name == "RBE3":  # a weight, followed by its components
            skip = 1
        elif card.name == "RBE2":  # the coefficient of thermal expansion comes last
            break
        else:
            raise card.wrong(first + i, "a whole number")
    return [np.array(single, dtype=np.int64), *out]


def _add_set(raw: RawMesh, card: Card, members: Members, nodes: Ints) -> None:
    """Add the nodes of a rigid element, or of a set, to the node or element sets."""
    elements = raw.numbers(nodes=False)
    sets = raw.node_sets if _of_nodes(members, nodes, elements) else raw.element_sets
    if card.name == "SET1" and sets is raw.element_sets:
        single = np.concatenate([part for part in members if not isinstance(part, range)])
        lost = single[~np.isin(single, elements)]
        if len(lost):
            names = some([str(i) for i in lost])
            raw.left_out.append((card.where, f"{names} is neither a node nor a supported element"))
        if not np.isin(joined(members, elements), elements).any():
            return
    sets.setdefault(_title(card), []).extend(members)


def _of_nodes(members: Members, nodes: Ints, elements: Ints) -> bool:
    """Return whether a set of undeclared type is a set of nodes: all its members are nodes."""
    ends = [i for part in members if isinstance(part, range) for i in (part[0], part[-1])]
    single = np.concatenate([part for part in members if not isinstance(part, range)])
    if not np.all(np.isin(single, nodes)) or np.all(np.isin(ends, nodes)):
        return bool(np.all(np.isin(single, nodes)))
    return bool(len(joined(members, nodes))) and not np.all(np.isin(ends, elements))


# ---- coordinate systems --------------------------------------------------------------------------


def _system(card: Card, systems: dict[int, Card]) -> None:
    """Store the coordinate systems of a card; CORD1x may contain two."""
    if card.name[:5] == "CORD1":
        for first in (0, 4):
            if card.field(first):
                part = Card(card.name, card.fields[first : first + 4], card.path, card.number)
                systems[part.whole(0)] = part
    else:
        systems[card.whole(0)] = card


def _positions(
    path: Path, points: list[tuple[int, int, float, float, float]], systems: dict[int, Card]
) -> Array:
    """Return positions (nn, 3) in the basic system."""
    local = sensible(np.array([p[2:] for p in points]))
    cp = np.array([p[1] for p in points])
    place = {p[0]: i for i, p in enumerate(points)}
    frames: dict[int, tuple[str, Array, Array]] = {0: ("R", np.zeros(3), np.eye(3))}
    out = np.full_like(local, np.nan)

    def frame(cid: int, above: tuple[int, ...]) -> tuple[str, Array, Array]:
        """Return kind, origin and axes (columns) of a system, resolved in the basic system."""
        if cid in frames:
            return frames[cid]
        if cid not in systems:
            raise InputError(
                Problem(path.name, f"coordinate system {cid} is used but not defined (CORD2R ...)")
            )
        if cid in above:
            raise InputError(
                Problem(systems[cid].where, f"coordinate system {cid} refers to itself")
            )
        card = systems[cid]
        if card.name[:5] == "CORD1":
            abc = [position(card.whole(i), (*above, cid)) for i in (1, 2, 3)]
        else:
            rows = np.array([[card.real(2 + 3 * r + c, 0.0) for c in range(3)] for r in range(3)])
            abc = list(_basic(sensible(rows), *frame(card.whole(1, 0), (*above, cid))))
        z = abc[1] - abc[0]
        y = np.cross(z, abc[2] - abc[0])
        if not np.linalg.norm(y) > 0.0:
            raise InputError(Problem(card.where, "its three points lie on a line"))
        z, y = z / np.linalg.norm(z), y / np.linalg.norm(y)
        frames[cid] = (card.name[-1], abc[0], np.stack([np.cross(y, z), y, z], axis=1))
        return frames[cid]

    def position(number: int, above: tuple[int, ...]) -> Array:
        if number not in place:
            raise InputError(
                Problem(
                    path.name,
                    f"a coordinate system refers to grid point {number}, which does not exist",
                )
            )
        i = place[number]
        x: Array = _basic(local[i : i + 1], *frame(int(cp[i]), above))[0]
        return x

    for cid in np.unique(cp):
        here = cp == cid
        out[here] = _basic(local[here], *frame(int(cid), ()))
    return out


def _basic(x: Array, kind: str, origin: Array, axes: Array) -> Array:
    """Return positions (n, 3) in the basic system, from coordinates of any kind."""
    a, b, c = x.T
    if kind == "C":
        x = np.stack([a * np.cos(np.radians(b)), a * np.sin(np.radians(b)), c], axis=1)
    elif kind == "S":
        theta, phi = np.radians(b), np.radians(c)
        flat = a * np.sin(theta)
        x = np.stack([flat * np.cos(phi), flat * np.sin(phi), a * np.cos(theta)], axis=1)
    out: Array = origin + x @ axes.T
    return out
