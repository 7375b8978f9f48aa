"""Abaqus and CalculiX input files (.inp): nodes, elements, sets, surfaces, material names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from jousto.base.arrays import Array, Ints, some
from jousto.base.errors import InputError, Problem, count
from jousto.mesh.cells import KINDS
from jousto.mesh.readers.element_types import abaqus
from jousto.mesh.readers.inp_assembly import Assembly, Instance, assembly, step_above
from jousto.mesh.readers.inp_blocks import Block, blocks, real
from jousto.mesh.readers.inp_sets import Names, add_set, add_surface
from jousto.mesh.readers.inp_system import LocalSystem
from jousto.mesh.readers.raw import RawCells, RawMesh, joined

# keywords of ties between nodes
_TIES = (
    *("COUPLING", "DISTRIBUTING COUPLING", "EMBEDDED ELEMENT", "EQUATION"),
    *("KINEMATIC COUPLING", "MPC", "RIGID BODY", "TIE"),
)
OUTSIDE = (
    *("BOUNDARY", "CLOAD", "DLOAD", "DSLOAD", "TEMPERATURE", "FIELD", "BASE MOTION"),
    *("INITIAL CONDITIONS", "PRE-TENSION SECTION", "INERTIA RELIEF"),
)
"""Keywords of supports, loads and initial conditions, which are ignored."""

_GENERATORS = ("NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY")


@dataclass
class Deck:
    """Content of an input file.

    Attributes
    ----------
    raw : RawMesh
        Nodes, elements and sets of all instances, with unique numbers.
    sections : list of (str, Block, Instance)
        Element set, keyword and instance of the sections of beams, shells and solids.
    others : list of Block
        Keywords besides nodes, elements and sets, in order.
    masses : list of (Block, (n,) ndarray of int)
        Each ``*MASS`` keyword with the nodes of the elements in its set.
    """

    raw: RawMesh = field(default_factory=RawMesh)
    sections: list[tuple[str, Block, Instance]] = field(default_factory=list)
    others: list[Block] = field(default_factory=list)
    masses: list[tuple[Block, Ints]] = field(default_factory=list)


def read_inp(path: Path) -> RawMesh:
    """Return the mesh of an Abaqus or CalculiX input file.

    The parser keeps data that general libraries drop: numbers of nodes and elements, surfaces by
    element faces, sets of sets, names regardless of case, ``*SOLID SECTION``, instances of parts.
    With several instances the names of sets get the name of the instance as prefix, ``A-1.corner``,
    and a power of ten is added to the node and element numbers of each further instance.

    Raises
    ------
    InputError
        If the file is no input deck, or truncated, or generates nodes or elements from others
        (``*NGEN``, ``*ELCOPY`` ...).
    """
    deck = read_deck(path)
    if outside := loads_left_out(deck, path):
        deck.raw.left_out.append((path.name, outside))
    return deck.raw


def loads_left_out(deck: Deck, path: Path) -> str:
    """Return the message about ignored supports and loads of a deck; empty if there are none."""
    acting: dict[str, list[str]] = {}
    for other in deck.others:
        if other.keyword in OUTSIDE:
            there = "" if other.path.name == path.name else f"{other.path.name}:"
            acting.setdefault(other.keyword, []).append(f"{there}{other.number}")
    names = ", ".join(
        f"*{word} (line{'s' * (len(at) > 1)} {some(at)})" for word, at in acting.items()
    )
    if not names:
        return ""
    return f"{names} ignored: declare supports and loads as joints and forces in the model file"


def read_deck(path: Path) -> Deck:
    """Return the mesh of an input file and the keywords of its properties; see `read_inp`."""
    deck, names = Deck(), Names()
    parts = assembly(blocks(path))
    found: list[tuple[Instance, Deck]] = []
    for instance in parts.instances:
        own = Deck(others=deck.others, sections=deck.sections)
        _read(instance.blocks, own, names, instance, parts)
        found.append((instance, own))
    step = step_above([own.raw.numbers(kind) for _, own in found for kind in (True, False)])
    for i, (instance, own) in enumerate(found):
        instance.shift = i * step
        _merge(deck.raw, own.raw, instance.shift)
        deck.masses += [(block, at + instance.shift) for block, at in own.masses]
    # nodes and elements that belong to no instance, such as reference points, are numbered after
    # the instances
    model = Instance("", parts.model, shift=len(found) * step if found else 0)
    if len(found) == 1:
        _apart(deck.raw, names, parts)
    _read(parts.model, deck, names, model, parts)
    if not deck.raw.seen:
        raise InputError(
            Problem(
                path.name,
                "contains neither *NODE nor *ELEMENT, so it is not an Abaqus or CalculiX mesh",
            )
        )
    ties = dict.fromkeys(f"*{block.keyword}" for block in deck.others if block.keyword in _TIES)
    if ties:
        sentence = "not read: the nodes are not tied; tie them by an Interface of the part"
        deck.raw.left_out.append((path.name, f"{', '.join(ties)} {sentence}"))
    with open(path, "rb") as file:
        file.seek(-1, 2)
        if file.read(1) not in b"\r\n":
            sentence = "does not end with a line end; the file may be truncated"
            deck.raw.left_out.append((path.name, sentence))
    return deck


def _read(
    given: Iterable[Block], deck: Deck, names: Names, instance: Instance, parts: Assembly
) -> None:
    """Add the blocks of one instance, or of the model, to a deck."""
    raw, system, surfaces = deck.raw, LocalSystem(), []
    points: dict[str, list[Ints]] = {}
    heavy = []
    for block in given:
        raw.seen |= block.keyword in ("NODE", "ELEMENT")
        if block.keyword == "NODE":
            ids, nodes = _nodes(block)
            raw.node_ids.append(ids + instance.shift)
            raw.nodes.append(instance.place(system(block, nodes)))
            if title := block.text("NSET"):
                title = names(instance.prefix + title)
                raw.node_sets.setdefault(title, []).append(raw.node_ids[-1])
        elif block.keyword == "ELEMENT":
            _elements(block, raw, names, instance)
            if block.text("TYPE").upper() == "MASS":
                ends = block.whole(block.tokens[1::2]) + instance.shift
                points.setdefault(block.text("ELSET").upper(), []).append(ends)
        elif block.keyword in ("NSET", "ELSET"):
            add_set(block, raw, names, instance, parts)
        elif block.keyword == "SURFACE":
            surfaces.append(block)
        elif block.keyword == "SYSTEM":
            system = LocalSystem.of(block)
        elif block.keyword in _GENERATORS:
            raise block.wrong(
                "generates nodes or elements from others, which is not supported; export the "
                "full mesh, every node under *NODE and every element under *ELEMENT"
            )
        elif not block.keyword and block.lines:
            lost = f"'{block.lines[0][:40]}' is below no *KEYWORD and is ignored"
            raw.left_out.append((block.place, lost))
        elif block.keyword == "MASS":
            heavy.append(block)
        else:
            deck.others.append(block)
            if block.keyword.endswith(" SECTION") and (title := block.text("ELSET")):
                title = names(instance.prefix + title)
                deck.sections.append((title, block, instance))
                if material := block.text("MATERIAL"):
                    raw.materials[title] = material
    for block in surfaces:  # all elements are known now
        add_surface(block, raw, names, instance, parts)
    for block in heavy:
        members = [np.zeros(0, np.int64), *points.get(block.text("ELSET").upper(), [])]
        deck.masses.append((block, np.concatenate(members)))


def _merge(raw: RawMesh, own: RawMesh, shift: int) -> None:
    """Add the mesh of an instance, with its numbers shifted."""
    for nodes, here, there in (
        (True, own.node_sets, raw.node_sets),
        (False, own.element_sets, raw.element_sets),
    ):
        known = own.numbers(nodes)
        for title, parts in here.items():
            there.setdefault(title, []).append(joined(parts, known) + shift)
    for title, pairs in own.sides.items():
        raw.sides.setdefault(title, []).extend((ids + shift, sides) for ids, sides in pairs)
    raw.node_ids += [ids + shift for ids in own.node_ids]
    raw.nodes += own.nodes
    for block in own.cells:
        block.nodes, block.ids = block.nodes + shift, block.ids + shift
    raw.cells += own.cells
    raw.materials |= own.materials
    raw.left_out += own.left_out
    raw.unread += own.unread
    raw.replaced += own.replaced
    raw.seen |= own.seen


def _apart(raw: RawMesh, names: Names, parts: Assembly) -> None:
    """Add the prefix ``A-1.`` to sets of a single instance whose name a set of the assembly has."""
    (instance,) = parts.instances
    kinds = {"NSET": (raw.node_sets, "NSET"), "ELSET": (raw.element_sets, "ELSET")}
    for block in parts.model:
        if block.keyword in kinds:
            sets, parameter = kinds[block.keyword]
            title = names(block.text(parameter))
            if title in sets:
                sets[names(f"{instance.name}.{title}")] = sets.pop(title)


def _nodes(block: Block) -> tuple[Ints, Array]:
    rows = [line.rstrip(",").split(",") for line in block.lines]
    table = np.zeros((len(rows), 3))
    try:
        if rows and all(len(row) == 4 for row in rows):
            table[:] = np.array([row[1:] for row in rows], dtype=np.float64)
            return block.whole([row[0] for row in rows]), table
    except ValueError:
        pass
    # coordinates may be blank for zero, and zeros at the end may be left out: '1' is the origin
    for i, row in enumerate(rows):
        try:
            values = [real(word) for word in row[1:4]]
        except ValueError:
            found = ",".join(row)[:40]
            raise block.wrong(f"'{found}' is not a node: number, x, y, z are needed") from None
        table[i, : len(values)] = values
    return block.whole([row[0] for row in rows]), table


def _elements(block: Block, raw: RawMesh, names: Names, instance: Instance) -> None:
    etype = block.text("TYPE").upper()
    known = abaqus(etype)
    if known is None:
        found = f"{count(len(block.lines), 'element')} of type {etype or '(none)'}"
        raw.left_out.append((block.where, f"{found} not read; see Part.solid for point masses"))
        raw.unread[etype or "(none)"] += len(block.lines)
        return
    wide = KINDS[known.kind] + 1
    _check_lines(block, etype, wide)
    values = block.whole(block.tokens)
    if len(values) % wide:
        raise block.wrong(
            f"{len(values)} numbers do not make whole {etype} elements of {wide} numbers each; "
            f"the file may be truncated"
        )
    table = values.reshape(-1, wide) + instance.shift
    nodes, ids = table[:, 1:], table[:, 0]
    if known.kind == "line3":  # in the file the middle node is listed between the ends
        nodes = nodes[:, [0, 2, 1]]
    raw.cells.append(RawCells(known.kind, nodes, ids, formulation=known.formulation, type=etype))
    raw.note(etype, known, len(ids))
    if title := block.text("ELSET"):
        raw.element_sets.setdefault(names(instance.prefix + title), []).append(ids)


def _check_lines(block: Block, etype: str, wide: int) -> None:
    """Raise InputError for an element with more numbers than nodes."""
    held = 0
    for line in block.lines:
        words = len(line.replace(",", " ").split())
        held = words if held >= wide else held + words
        if held > wide:
            raise block.wrong(
                f"'{line[:40]}' has too many numbers for a {etype}, which has its number and "
                f"{wide - 1} nodes; check the type"
            )
