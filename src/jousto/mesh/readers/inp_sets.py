"""Sets and surfaces of Abaqus and CalculiX input files."""

from __future__ import annotations

import re

import numpy as np

from jousto.base.arrays import Ints
from jousto.mesh.readers.inp_assembly import Assembly, Instance, is_number
from jousto.mesh.readers.inp_blocks import Block
from jousto.mesh.readers.raw import Members, RawMesh, joined

_SIDE = re.compile(r"S(\d)$|(SPOS|SNEG|SP|SN)$", re.IGNORECASE)


class Names:
    """Set names in the spelling of their first occurrence; Abaqus and CalculiX ignore case."""

    def __init__(self) -> None:
        self.spelt: dict[str, str] = {}

    def __call__(self, name: str) -> str:
        """Return the spelling of the first occurrence of a name."""
        name = name.strip().strip('"')
        return self.spelt.setdefault(name.upper(), name)


def add_set(block: Block, raw: RawMesh, names: Names, instance: Instance, parts: Assembly) -> None:
    """Read a set of numbers, of ranges (GENERATE) or of other sets."""
    title = _title(block, block.keyword, names, instance)
    sets = raw.node_sets if block.keyword == "NSET" else raw.element_sets
    own = sets.setdefault(title, [])
    of = parts.find(block, block.text("INSTANCE")) if block.text("INSTANCE") else instance
    if "GENERATE" in block.parameters:
        for line in block.lines:
            row = block.whole(line.replace(",", " ").split())
            if len(row) not in (2, 3) or (len(row) == 3 and row[2] <= 0):
                raise block.wrong("GENERATE needs first, last and step")
            step = row[2] if len(row) == 3 else 1
            first, last = int(row[0]) + of.shift, int(row[1]) + of.shift
            own.append(range(first, last + 1, int(step)))
        return
    plain = []
    for word in (word for row in block.rows for word in row if word):
        if is_number(word):
            plain.append(word)
            continue
        found = _members(block, word, raw, names, of, parts, nodes=block.keyword == "NSET")
        if found is not None:
            own += found
        elif block.keyword == "NSET" and names(of.prefix + word) in raw.element_sets:
            raw.left_out.append((block.where, f"nodes of element set '{word}' not read"))
        else:
            raise block.wrong(f"'{word}' is neither a number nor a set")
    if plain:
        own.append(block.whole(plain) + of.shift)


def add_surface(
    block: Block, raw: RawMesh, names: Names, instance: Instance, parts: Assembly
) -> None:
    """Read a surface of nodes or of element faces."""
    title = _title(block, "NAME", names, instance)
    of_nodes = block.parameters.get("TYPE", "ELEMENT").upper() == "NODE"
    for row in block.rows:
        if not row[0]:
            continue
        found = _members(block, row[0], raw, names, instance, parts, nodes=of_nodes)
        if found is None:
            raise block.wrong(f"'{row[0]}' is neither a number nor a set")
        members = joined(found, raw.numbers(of_nodes))
        if of_nodes:
            raw.node_sets.setdefault(title, []).append(members)
            continue
        side = _SIDE.match(row[1]) if len(row) > 1 else None
        if side is None:
            raw.left_out.append((block.where, f"faces '{','.join(row)}' not read"))
            continue
        number = int(side[1]) - 1 if side[1] else 0
        raw.sides.setdefault(title, []).append((members, np.full(len(members), number)))


def _title(block: Block, parameter: str, names: Names, instance: Instance) -> str:
    title = block.text(parameter)
    if not title:
        raise block.wrong(f"has no name; add {parameter}=...")
    return names(instance.prefix + title)


def _members(
    block: Block,
    word: str,
    raw: RawMesh,
    names: Names,
    instance: Instance,
    parts: Assembly,
    *,
    nodes: bool,
) -> Members | None:
    """Return the members that a word refers to: a number or a set, also of an instance; or None."""
    sets = raw.node_sets if nodes else raw.element_sets
    of, rest = parts.split(word)
    if is_number(word) or (of is not None and is_number(rest)):
        number: Ints = block.whole([rest]) + (instance if of is None else of).shift
        return [number]
    names_of_it = [names(instance.prefix + word), names(word)]
    if of is not None and not of.prefix:
        names_of_it.append(names(rest))
    for name in names_of_it:
        if name in sets:
            return list(sets[name])
    return None
