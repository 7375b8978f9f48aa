"""Decks of other finite element programs: a part with the loads of its body as load steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TextIO

import numpy as np

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array, Ints
from jousto.base.errors import Problems, warn
from jousto.base.files import written
from jousto.base.names import harmless
from jousto.materials.material import Material
from jousto.output.files.meshes import ABAQUS_TYPES, NEAREST_TYPES
from jousto.output.style import target
from jousto.parts.interface import Tie
from jousto.parts.part import Part
from jousto.parts.solids.model import SolidGroup
from jousto.recovery.loads.body_loads import BodyLoads
from jousto.recovery.loads.nodal_forces import NodalForces, nodal_forces

PROGRAMS = {"inp": ("calculix", "abaqus"), "bdf": ("nastran",), "nas": ("nastran",)}
"""Programs by the suffix of their decks; the first one if none is named."""
IN_LINE = 15  # whole numbers in a line of an Abaqus deck; at most 16
# numbers have at most 20 characters: CalculiX reads no longer ones
SMALLEST = 1e-15  # nodal force, relative to the largest one of the step, below which it is left out
NASTRAN = {
    "tetra": ("CTETRA", range(4)),
    "tetra10": ("CTETRA", range(10)),
    "wedge": ("CPENTA", range(6)),
    "wedge15": ("CPENTA", (*range(9), 12, 13, 14, 9, 10, 11)),
    "hexahedron": ("CHEXA", range(8)),
    "hexahedron20": ("CHEXA", (*range(12), 16, 17, 18, 19, 12, 13, 14, 15)),
}
"""Cards of Nastran and their nodes in VTK's order: upright edges come before those of the top."""
INTEGRATION = {
    ("tetra", "full"): ("", ""),
    ("tetra10", "full"): ("", ""),
    ("wedge", "full"): ("TWO", "FULL"),
    ("wedge15", "full"): ("", ""),
    ("hexahedron", "full"): ("TWO", "FULL"),
    ("hexahedron", "incompatible"): ("", ""),
    ("hexahedron20", "full"): ("", ""),
    ("hexahedron20", "reduced"): ("TWO", ""),
}
"""Fields IN and ISOP of PSOLID for kind and formulation."""


@explained_as("write")
def write_deck(
    loads: BodyLoads,
    path: str | Path,
    part: Part,
    *,
    times: Sequence[float] | None = None,
    program: Literal["calculix", "abaqus", "nastran"] | None = None,
) -> Path:
    """Write a part with all loads on its body at some instants, a static load step for each.

    The deck contains mesh (node and element numbers of its file, m), materials, rigid interfaces,
    nodal forces (N) and six supports without reactions. The forces are the loads at interfaces and
    nodes, and the exact inertia forces, weight and damping as ``-M z''`` on every node
    (`nodal_forces`).

    Parameters
    ----------
    loads : BodyLoads
        From `loads_of`.
    path : path
        File, overwritten: .inp (CalculiX, Abaqus), .bdf or .nas (Nastran).
    part : Part
        Part of solids from which the body was reduced; for a rigid body, a part in its frame.
    times : sequence of float, optional
        Stored instants, s; by default all.
    program : {"calculix", "abaqus", "nastran"}
        Program that reads the file; by default CalculiX for .inp.

    Raises
    ------
    InputError
        For another ending or program, or a material that is not isotropic; see also `nodal_forces`.

    Warns
    -----
    JoustoWarning
        If the program has no element of a formulation, or the loads are not in balance.
    """
    out = target(path, tuple(PROGRAMS))
    known = PROGRAMS[out.suffix.lower().lstrip(".")]
    chosen = known[0] if program is None else program
    problems = Problems()
    if chosen not in known:
        problems.add("program", f"is {chosen!r}; {out.suffix} files are for {' or '.join(known)}")
    materials = () if part.solids is None else part.solids.materials
    for material in materials:
        if not isinstance(material, Material):
            problems.add(
                f"part '{part.name}'",
                f"{type(material).__name__} is not isotropic; decks contain isotropic materials",
            )
    problems.raise_if_any()
    deck = Deck(loads.body, part, nodal_forces(loads, part, None if times is None else [*times]))
    writer: Callable[[Deck, str], Iterator[str]] = (
        nastran_lines if chosen == "nastran" else abaqus_lines
    )
    _warn_elements(out, part, chosen)
    with written(out) as beside, beside.open("w", encoding="utf-8", newline="\n") as file:
        _write(file, writer(deck, chosen))
    return out


def _write(file: TextIO, lines: Iterator[str]) -> None:
    for line in lines:
        file.write(line + "\n")


@dataclass(frozen=True, eq=False)
class Deck:
    """Content of a deck, and numbers of its nodes.

    Attributes
    ----------
    body : str
        Name of the body.
    part : Part
    forces : NodalForces
    """

    body: str
    part: Part
    forces: NodalForces

    @property
    def solids(self) -> Any:
        """Elements with their materials."""
        return self.part.solids

    @property
    def ids(self) -> Ints:
        """Numbers of the nodes (nn,)."""
        return np.asarray(self.solids.node_ids)

    @cached_property
    def rigid(self) -> tuple[tuple[Tie, int], ...]:
        """Rigid interfaces with the number of the first of two new nodes at their reference."""
        ties = [tie for tie in self.part.ties if tie.kind == "rigid"]
        first = int(self.ids.max()) + 1
        return tuple((tie, first + 2 * i) for i, tie in enumerate(ties))

    @property
    def title(self) -> list[str]:
        """Facts about the deck, a line each."""
        worst = float(self.forces.relief.max(initial=0.0))
        return [
            f"loads on body {harmless(self.body)} as nodal forces, m, N, kg, s",
            "in each step: joints, forces, friction, weight, exact inertia -M z'', damping",
            "the six supports bear nothing; inertia relief carries "
            f"{worst:.2g} of the loads: statics refer to the undeformed shape",
        ]

    def loads(self, step: int) -> list[tuple[int, Array]]:
        """Return the number of each loaded node and its force (3,) in a step."""
        f = self.forces.forces[step]
        least = SMALLEST * np.abs(f).max(initial=0.0)
        return [(int(self.ids[k]), f[k]) for k in np.flatnonzero(np.abs(f).max(axis=1) > least)]

    def supports(self) -> list[tuple[int, int]]:
        """Return node number and direction (1 to 3) of each support."""
        return [(int(self.ids[dof // 3]), int(dof % 3) + 1) for dof in self.forces.held]


# ---- Abaqus and CalculiX -------------------------------------------------------------------------


def abaqus_lines(deck: Deck, program: str) -> Iterator[str]:
    """Yield the lines of a deck for CalculiX or Abaqus."""
    yield "*HEADING"
    yield f"{harmless(deck.part.name)}, from jousto"
    yield from (f"** {line}" for line in deck.title)
    yield "*NODE, NSET=NALL"
    for number, x in zip(deck.ids, deck.part.nodes, strict=True):
        yield f"{number}, " + ", ".join(f"{v:.12e}" for v in x)
    for i, group in enumerate(deck.solids.groups, 1):
        yield f"*ELEMENT, TYPE={abaqus_type(group)}, ELSET=GROUP{i}"
        for number, nodes in zip(group.ids, deck.ids[group.nodes], strict=True):
            yield from continued([int(number), *map(int, nodes)])
    for i, material in enumerate(deck.solids.materials, 1):
        density = deck.solids.density_factor * material.rho
        yield f"*MATERIAL, NAME=MATERIAL{i}"
        yield from ("*ELASTIC", f"{material.E:.12e}, {material.nu:.12e}")
        yield from ("*DENSITY", f"{density:.12e}")
    for i, group in enumerate(deck.solids.groups, 1):
        yield f"*SOLID SECTION, ELSET=GROUP{i}, MATERIAL=MATERIAL{group.material + 1}"
    for i, (tie, number) in enumerate(deck.rigid, 1):
        at = ", ".join(f"{v:.12e}" for v in tie.at)
        yield f"** rigid interface {harmless(tie.name)}"
        yield from ("*NODE", f"{number}, {at}")
        yield f"*NSET, NSET=RIGID{i}"
        yield from (f"{n}," for n in deck.ids[tie.nodes])
        if program == "calculix":
            yield from ("*NODE", f"{number + 1}, {at}")
            yield f"*RIGID BODY, NSET=RIGID{i}, REF NODE={number}, ROT NODE={number + 1}"
        else:
            yield f"*RIGID BODY, PIN NSET=RIGID{i}, REF NODE={number}"
    yield from ("** six supports, statically determinate", "*BOUNDARY")
    yield from (f"{number}, {axis}, {axis}" for number, axis in deck.supports())
    for step, t in enumerate(deck.forces.time):
        yield f"** {t:.9g} s"
        yield from ("*STEP", "*STATIC", "*CLOAD, OP=NEW")
        for number, force in deck.loads(step):
            yield from (f"{number}, {i}, {v:.12e}" for i, v in enumerate(force, 1) if v)
        if program == "calculix":
            yield from ("*NODE FILE", "U, RF", "*EL FILE", "S, E")
        else:
            yield from ("*OUTPUT, FIELD, VARIABLE=PRESELECT",)
        yield "*END STEP"


def abaqus_type(group: SolidGroup) -> str:
    """Return the element of Abaqus and CalculiX for a kind and formulation, or the nearest."""
    nearest = NEAREST_TYPES.get(group.kind, ABAQUS_TYPES.get((group.kind, "full"), ""))
    return ABAQUS_TYPES.get((group.kind, group.formulation), nearest)


def continued(numbers: list[int]) -> Iterator[str]:
    """Yield lines of whole numbers; a comma at the end of a line continues it."""
    for start in range(0, len(numbers), IN_LINE):
        more = "," if start + IN_LINE < len(numbers) else ""
        yield ", ".join(map(str, numbers[start : start + IN_LINE])) + more


# ---- Nastran -------------------------------------------------------------------------------------


def nastran_lines(deck: Deck, program: str) -> Iterator[str]:
    """Yield the lines of a deck for Nastran, with a subcase of SOL 101 for each instant."""
    yield from (
        f"$ {line}" for line in [f"{harmless(deck.part.name)}, from {'jousto'}", *deck.title]
    )
    yield from (
        "SOL 101",
        "CEND",
        "SPC = 1",
        "DISPLACEMENT = ALL",
        "STRESS = ALL",
        "SPCFORCES = ALL",
    )
    for step, t in enumerate(deck.forces.time, 1):
        yield from (f"SUBCASE {step}", f"  SUBTITLE = {t:.9g} s", f"  LOAD = {step}")
    yield "BEGIN BULK"
    for number, x in zip(deck.ids, deck.part.nodes, strict=True):
        yield from card("GRID", number, "", *map(float, x))
    for i, group in enumerate(deck.solids.groups, 1):
        name, order = NASTRAN[group.kind]
        network, points = INTEGRATION.get((group.kind, group.formulation), ("", ""))
        yield from short_card("PSOLID", i, group.material + 1, "", network, "", points)
        for number, nodes in zip(group.ids, deck.ids[group.nodes], strict=True):
            yield from short_card(name, number, i, *nodes[list(order)])
    for i, material in enumerate(deck.solids.materials, 1):
        density = deck.solids.density_factor * material.rho
        yield from card("MAT1", i, float(material.E), "", float(material.nu), float(density))
    last = max(int(group.ids.max()) for group in deck.solids.groups)
    for i, (tie, number) in enumerate(deck.rigid, 1):
        yield f"$ rigid interface {harmless(tie.name)}"
        yield from card("GRID", number, "", *map(float, tie.at))
        yield from short_card("RBE2", last + i, number, 123, *deck.ids[tie.nodes])
    for number, axis in deck.supports():
        yield from short_card("SPC1", 1, axis, number)
    for step in range(len(deck.forces.time)):
        for number, force in deck.loads(step):
            yield from card("FORCE", step + 1, number, 0, 1.0, *map(float, force))
    yield "ENDDATA"


def short_card(name: str, *fields: Any) -> Iterator[str]:
    """Yield the lines of a card of whole numbers in fields of eight characters."""
    for start in range(0, len(fields), 8):
        head = name if not start else "+"
        yield f"{head:8}" + "".join(f"{field!s:>8}" for field in fields[start : start + 8])


def card(name: str, *fields: Any) -> Iterator[str]:
    """Yield the lines of a card in fields of sixteen characters."""
    for start in range(0, len(fields), 4):
        head = f"{name}*" if not start else "*"
        texts = (number_text(field) for field in fields[start : start + 4])
        yield f"{head:8}" + "".join(f"{text:>16}" for text in texts)


def number_text(field: Any) -> str:
    """Return a number with as many digits as sixteen characters hold."""
    if not isinstance(field, float):
        return str(field)
    text = f"{field:.9E}"
    return text if len(text) <= 16 else f"{field:.8E}"


def _warn_elements(out: Path, part: Part, program: str) -> None:
    """Warn about formulations that the program does not have."""
    lost = []
    for group in part.solids.groups if part.solids else ():
        form = (group.kind, group.formulation)
        known = form in (INTEGRATION if program == "nastran" else ABAQUS_TYPES)
        if not known or (program == "calculix" and abaqus_type(group) == "C3D8H"):
            lost.append(f"{group.kind} '{group.formulation}'")
    if lost:
        text = ", ".join(dict.fromkeys(lost))
        warn(out.name, f"{program} has no element for {text}; the deck has the nearest one")
