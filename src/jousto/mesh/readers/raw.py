"""Content of a mesh file in the numbering of the file, and its conversion to a Mesh."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array, Ints, some
from jousto.base.errors import InputError, Problem, Problems, count
from jousto.mesh.cells import LINES, SOLIDS, SURFACES, Cells, base, faces, mirrored
from jousto.mesh.mesh import Mesh
from jousto.mesh.quality import volumes
from jousto.mesh.readers.element_types import ElementType
from jousto.mesh.surface import face_kind

# limits of coordinates and of node and element numbers; a file beyond them is damaged
FAR = 1e12
BIG = 2**62

# single numbers, or a range of which only existing numbers count
Members = list[Ints | range]


@dataclass
class RawCells:
    """Elements of one kind in the numbering of the file."""

    kind: str
    nodes: Ints  # (ne, k) node numbers
    ids: Ints  # (ne,) element numbers
    material: str = ""
    formulation: str = "full"  # see Cells
    type: str = ""  # its name in the file


@dataclass
class RawMesh:
    """Data collected by a reader; nodes in the unit of the file, all numbers as in the file."""

    node_ids: list[Ints] = field(default_factory=list)
    nodes: list[Array] = field(default_factory=list)
    cells: list[RawCells] = field(default_factory=list)
    node_sets: dict[str, Members] = field(default_factory=dict)
    element_sets: dict[str, Members] = field(default_factory=dict)
    # faces of elements: element numbers and sides from 0
    sides: dict[str, list[tuple[Ints, Ints]]] = field(default_factory=dict)
    # materials of element sets
    materials: dict[str, str] = field(default_factory=dict)
    # ignored content: place and message
    left_out: list[tuple[str, str]] = field(default_factory=list)
    # elements of unsupported kinds, by the name of their type
    unread: Counter[str] = field(default_factory=Counter)
    # whether the format allows both node orders of solids
    either_sense: bool = False
    # unit of length in m, if the file contains one
    length: float | None = None
    # elements that differ from those of the file, by type and replacement
    replaced: Counter[tuple[str, ElementType]] = field(default_factory=Counter)
    # whether the file has nodes and elements
    seen: bool = False

    def note(self, name: str, found: ElementType, number: int) -> None:
        """Note that elements of a type of the file are replaced by elements of another type."""
        if found.replaced:
            self.replaced[name, found] += number

    def numbers(self, nodes: bool) -> Ints:
        """Return the numbers of all nodes, or of all elements."""
        parts = self.node_ids if nodes else [block.ids for block in self.cells]
        return np.concatenate([np.zeros(0, np.int64), *parts])

    def build(self, where: str, name: str, factor: float) -> Mesh:
        """Return the mesh in m, or raise InputError with all inconsistencies."""
        problems = Problems()
        ids, nodes = self._all_nodes(problems, where)
        index = Numbers(ids)
        self._twice(problems, where)
        blocks = []
        for block in self._by_material():
            found = index(block.nodes.ravel()).reshape(block.nodes.shape)
            missing = np.argwhere(found < 0)
            if len(missing):
                i, j = missing[0]
                wrong = len(np.unique(missing[:, 0]))
                problems.add(
                    where,
                    f"element {block.ids[i]} needs node {block.nodes[i, j]}, which the file does "
                    f"not contain ({count(wrong, 'element')} like that); is it complete?",
                )
            else:
                if self.either_sense:
                    found = right_handed(block.kind, found, nodes)
                how = (block.material, block.formulation)
                blocks.append(Cells(block.kind, found, block.ids, *how))
        problems.raise_if_any()
        if not blocks and self.unread:
            types = some([f"{name} ({number})" for name, number in self.unread.most_common()])
            raise InputError(
                Problem(
                    where,
                    f"contains only elements of type {types}, which are not supported; supported "
                    f"are "
                    f"{' '.join(SOLIDS)}, and, for names only, shells, beams and trusses",
                )
            )
        if not blocks:
            raise InputError(Problem(where, "contains no elements; the file may be incomplete"))

        node_sets = {}
        for title, parts in self.node_sets.items():
            members = joined(parts, ids)
            at = index(members)
            if np.any(at < 0):
                lost = some([str(i) for i in members[at < 0]])
                problems.add(
                    where, f"node set '{title}' contains node {lost}, which does not exist"
                )
            node_sets[title] = np.unique(at[at >= 0])
        problems.raise_if_any()
        elements, surfaces, more = self._element_sets(blocks)
        for title, members in more.items():
            node_sets.setdefault(title, members)
        surfaces |= self._side_sets(blocks, where)
        self._say_replaced(where, any(block.kind in SOLIDS for block in blocks))
        return Mesh(name, nodes * factor, tuple(blocks), ids, node_sets, elements, surfaces)

    def _all_nodes(self, problems: Problems, where: str) -> tuple[Ints, Array]:
        if not self.node_ids or not sum(len(part) for part in self.node_ids):
            raise InputError(Problem(where, "contains no nodes; the file may be incomplete"))
        ids, nodes = np.concatenate(self.node_ids), np.concatenate(self.nodes)
        values, first, number = np.unique(ids, return_index=True, return_counts=True)
        if np.any(number > 1):
            # a node that is repeated at the same position is harmless
            order = np.argsort(ids, kind="stable")
            again = np.flatnonzero(np.diff(ids[order]) == 0)
            apart = nodes[order[again]] != nodes[order[again + 1]]
            wrong = np.unique(ids[order[again[apart.any(axis=1)]]])
            if len(wrong):
                names = some([str(i) for i in wrong])
                problems.add(where, f"node {names} is defined twice, at different positions")
            keep = np.sort(first)
            ids, nodes = ids[keep], nodes[keep]
        bad = ids[~(np.abs(nodes) < FAR).all(axis=1)]
        if len(bad):
            problems.add(where, f"node {some([str(i) for i in bad])} has a position out of range")
        problems.raise_if_any()
        return ids, nodes

    def _twice(self, problems: Problems, where: str) -> None:
        """Report element numbers that occur twice, which makes sets and materials ambiguous."""
        ids = self.numbers(nodes=False)
        values, number = np.unique(ids, return_counts=True)
        wrong = values[number > 1]
        drawn = [block.ids for block in self.cells if block.kind in (*SOLIDS, *SURFACES)]
        wrong = np.intersect1d(wrong, np.concatenate([np.zeros(0, np.int64), *drawn]))
        if len(wrong):
            names = some([str(i) for i in wrong])
            problems.add(
                where,
                f"number {names} belongs to more than one element, so that sets and materials are "
                f"ambiguous; export with unique numbers",
            )

    def _by_material(self) -> list[RawCells]:
        """Return one block of elements for each kind and material, in file order."""
        ids = self.numbers(nodes=False)
        material: dict[str, Ints] = {}
        for title, name in self.materials.items():
            members = joined(self.element_sets.get(title, []), ids)
            material[name] = np.union1d(material.get(name, np.zeros(0, np.int64)), members)
        groups: dict[tuple[str, str, str], list[tuple[Ints, Ints]]] = {}
        for block in self.cells:
            rest = np.ones(len(block.ids), dtype=bool)
            for name, members in material.items():
                here = rest & np.isin(block.ids, members)
                if here.any():
                    group = groups.setdefault((block.kind, name, block.formulation), [])
                    group.append((block.nodes[here], block.ids[here]))
                    rest &= ~here
            if rest.any():
                place = (block.kind, block.material, block.formulation)
                group = groups.setdefault(place, [])
                group.append((block.nodes[rest], block.ids[rest]))
        return [
            RawCells(kind, np.concatenate([p[0] for p in g]), np.concatenate([p[1] for p in g]), *m)
            for (kind, *m), g in groups.items()
        ]

    def _say_replaced(self, where: str, solid: bool) -> None:
        """Warn about elements of other programs that became different elements."""
        bare: dict[str, list[str]] = {}
        for (name, found), number in self.replaced.items():
            if found.solid:
                how = "" if found.formulation == "full" else f", formulation '{found.formulation}'"
                sentence = f"{number} {name} read as {found.kind}{how}: {found.replaced}"
                self.left_out.append((where, sentence))
            elif (
                solid and "pyramid" not in found.kind
            ):  # pyramids are reported as an error of the part
                bare.setdefault(found.replaced, []).append(f"{number} {name}")
        for what, names in bare.items():
            sentence = f"{some(names)}: {what} has no stiffness and mass beside solids here"
            self.left_out.append((where, f"{sentence}; kept for names and drawing"))

    def _element_sets(
        self, blocks: Sequence[Cells]
    ) -> tuple[dict[str, Ints], dict[str, Ints], dict[str, Ints]]:
        """Return sets of solid elements, surfaces (from shells) and nodes (from lines)."""
        solid = [block for block in blocks if block.kind in SOLIDS]
        number = Numbers(np.concatenate([np.zeros(0, np.int64), *(b.ids for b in solid)]))
        others = [(block, Numbers(block.ids)) for block in blocks if block.kind not in SOLIDS]
        elements: dict[str, Ints] = {}
        surfaces: dict[str, Ints] = {}
        nodes: dict[str, Ints] = {}
        for title, parts in self.element_sets.items():
            members = np.unique(joined(parts, self.numbers(nodes=False)))
            solids = number(members)
            found = [block.nodes[at[at >= 0]] for block, at in ((b, n(members)) for b, n in others)]
            kinds = [block.kind for block, _ in others]
            shells = [x for x, kind in zip(found, kinds, strict=True) if kind in SURFACES]
            lines = [x.ravel() for x, kind in zip(found, kinds, strict=True) if kind in LINES]
            surface = padded([part for part in shells if len(part)])
            if np.any(solids >= 0) or not (len(surface) or any(len(x) for x in lines)):
                elements[title] = solids[solids >= 0]
            if len(surface):
                surfaces[title] = surface
            elif any(len(x) for x in lines):
                nodes[title] = np.unique(np.concatenate(lines))
        return elements, surfaces, nodes

    def _side_sets(self, blocks: Sequence[Cells], where: str) -> dict[str, Ints]:
        """Return surfaces given by sides of elements."""
        problems = Problems()
        out: dict[str, Ints] = {}
        numbers = [(block, Numbers(block.ids)) for block in blocks]
        for title, pairs in self.sides.items():
            parts = []
            for members, sides in pairs:
                missing = np.ones(len(members), dtype=bool)
                for block, number in numbers:
                    at = number(members)
                    here = at >= 0
                    missing &= ~here
                    if block.kind in SURFACES:  # a shell is its own face
                        parts.append(block.nodes[at[here]])
                        continue
                    if block.kind not in SOLIDS:
                        if here.any():
                            named = some([str(i) for i in members[here]])
                            sentence = f"faces of element {named} not read: a {block.kind} has none"
                            self.left_out.append((f"{where}: surface '{title}'", sentence))
                        continue
                    known = faces(block.kind)
                    wrong = here & ((sides < 0) | (sides >= len(known)))
                    if wrong.any():
                        problems.add(
                            where,
                            f"surface '{title}' has face {sides[wrong][0] + 1} of element"
                            f" {some([str(i) for i in members[wrong]])}; a {block.kind} has"
                            f" {len(known)}",
                        )
                    for side, face in enumerate(known):
                        chosen = here & (sides == side)
                        parts.append(block.nodes[at[chosen]][:, face])
                if missing.any():
                    lost = some([str(i) for i in members[missing]])
                    problems.add(
                        where,
                        f"surface '{title}' contains element {lost}, which is not in the file",
                    )
            out[title] = padded([part for part in parts if len(part)])
        problems.raise_if_any()
        return out


def right_handed(kind: str, cells: Ints, nodes: Array) -> Ints:
    """Return solid cells (ne, k), with those of negative volume mirrored."""
    if kind not in SOLIDS or not len(cells):
        return cells
    straight = Cells(base(kind), cells[:, : SOLIDS[base(kind)]])
    left = volumes(nodes, [straight]) < 0.0
    out: Ints = np.where(left[:, None], cells[:, mirrored(kind)], cells)
    return out


def sensible(x: Array) -> Array:
    """Return coordinates with nan for values out of range; rotations keep the nan."""
    out: Array = np.where(np.abs(x) < FAR, x, np.nan)
    return out


def joined(parts: Members, known: Ints) -> Ints:
    """Return the numbers of a set; from ranges only the numbers that exist."""
    out = [np.zeros(0, np.int64)]
    for part in parts:
        if isinstance(part, range):
            inside = (known >= part.start) & (known < part.stop)
            inside &= (known - part.start) % part.step == 0
            out.append(np.unique(known[inside]))
        else:
            out.append(part)
    return np.concatenate(out)


class Numbers:
    """Index of each number of the file; -1 for a missing number."""

    def __init__(self, ids: Ints) -> None:
        self.order = np.argsort(ids, kind="stable")
        self.sorted = ids[self.order]

    def __call__(self, wanted: Ints) -> Ints:
        """Return the indices (m,) of numbers (m,)."""
        if not len(self.sorted):
            return np.full(len(wanted), -1)
        at = np.minimum(np.searchsorted(self.sorted, wanted), len(self.sorted) - 1)
        found: Ints = np.where(self.sorted[at] == wanted, self.order[at], -1)
        return found


def padded(parts: Sequence[Ints]) -> Ints:
    """Return faces of different kinds as one array, corners first, rows padded with -1.

    The row of a face with fewer nodes has its corners, its mid-side nodes, then -1.
    """
    width = max((part.shape[1] for part in parts), default=3)
    face_kind(width)
    out = [np.pad(part, ((0, 0), (0, width - part.shape[1])), constant_values=-1) for part in parts]
    return np.concatenate(out) if out else np.zeros((0, 3), dtype=np.int64)
