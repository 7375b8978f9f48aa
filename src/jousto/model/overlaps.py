"""Shapes of sets of contacts that overlap at the start."""

from __future__ import annotations

from dataclasses import dataclass

from jousto.base.errors import Problems, count
from jousto.mechanism.forces.contact_set import Contacts
from jousto.mechanism.mechanism import Mechanism
from jousto.model.model import Model
from jousto.model.native.header import named
from jousto.model.native.native import Engine

TOUCHING = 1e-6
"""Depth over the size of the smaller shape up to which shapes only touch."""
SHOWN = 5
"""Largest number of pairs that a message lists."""


@dataclass(frozen=True)
class Overlap:
    """Two shapes of a set that overlap at the start, with the depth, m."""

    contacts: Contacts
    first: str
    second: str
    depth: float

    def __str__(self) -> str:
        return f"{self.first!r} and {self.second!r} by {self.depth:.3g} m"


def overlaps(mechanism: Mechanism, model: Model) -> list[Overlap]:
    """Return the shapes that overlap at the start of a model, the deepest first."""
    sets = {force.name: force for force in mechanism.forces if isinstance(force, Contacts)}
    if not sets:
        return []
    found = []
    rows = named("jo_touch", Engine(model, implicit=False).contacts())
    for place, (on, of), gap in zip(rows.force, rows.shapes, rows.gap, strict=True):
        if on < 0:
            continue
        contacts = sets[model.forces[int(place)].name]
        pair = contacts.shapes[int(on)], contacts.shapes[int(of)]
        size = min(one.size for one in pair)
        if -gap > TOUCHING * size:
            found.append(Overlap(contacts, pair[0].name, pair[1].name, -gap))
    return sorted(found, key=lambda one: -one.depth)


def refuse_overlaps(mechanism: Mechanism, model: Model) -> None:
    """Raise InputError with the shapes that overlap at the start of sets that refuse this."""
    problems = Problems()
    refused = [one for one in overlaps(mechanism, model) if one.contacts.overlap == "refuse"]
    for contacts in {id(one.contacts): one.contacts for one in refused}.values():
        mine = [one for one in refused if one.contacts is contacts]
        listed = ", ".join(map(str, mine[:SHOWN])) + (", ..." if len(mine) > SHOWN else "")
        problems.add(
            f"contacts {contacts.name!r}",
            f"{count(len(mine), 'pair')} of shapes overlap at the start: {listed}; move the bodies "
            'apart, exclude the pairs with Apart, or start as they are, overlap="start"',
            "overlap",
        )
    problems.raise_if_any()


def overlap_facts(mechanism: Mechanism, model: Model) -> list[tuple[str, str]]:
    """Return a line on the shapes that overlap at the start for each set of contacts."""
    found = overlaps(mechanism, model)
    rows = []
    for force in mechanism.forces:
        if isinstance(force, Contacts):
            mine = [one for one in found if one.contacts is force]
            listed = ", ".join(map(str, mine[:SHOWN])) + (", ..." if len(mine) > SHOWN else "")
            rows.append((f"overlaps of {force.name}", listed or "none"))
    return rows
