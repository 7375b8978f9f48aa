"""Objects of declared classes from their entries: references become what they name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

from jousto.base.declare import SECTIONS, Declared, Field, Item
from jousto.base.errors import suggest
from jousto.schema.entries.base import Entry
from jousto.schema.file.document import Loc
from jousto.schema.make.amounts import build_amount
from jousto.schema.make.signals import build_signal

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder

Known: TypeAlias = Mapping[str, Mapping[str, Any]]
"""For each section the objects made before, by their names."""


def build_declared(builder: Builder, loc: Loc, entry: Any, section: str, known: Known) -> Any:
    """Return the object of an entry, None if anything is wrong with it.

    Parameters
    ----------
    builder, loc, entry
        As everywhere.
    section : str
        The section of the document.
    known : mapping
        What the entry may name.
    """
    return build_one(builder, loc, entry, SECTIONS[section][entry.type], known)


def build_one(builder: Builder, loc: Loc, entry: Any, cls: type[Declared], known: Known) -> Any:
    """Return the object of a class from its entry, None if anything is wrong with it."""
    given = entry.given()
    values: dict[str, Any] = {}
    for key, field in cls.fields.items():
        if key not in given:
            continue
        if isinstance(field, Item):
            values[key] = build_one(builder, (*loc, key), given[key], field.of, known)
            continue
        make = FORMS.get(field.form)
        unit = unit_of(field, values)
        if make is None:
            values[key] = given[key]
        else:
            values[key] = (
                None if unit is None else make(builder, (*loc, key), given[key], known, unit)
            )
    return None if None in values.values() else builder.make(loc, cls, **values)


def unit_of(field: Field[Any, Any], values: Mapping[str, Any]) -> str | None:
    """Return the SI unit of a field, None if the coordinate that it depends on is wrong."""
    if isinstance(field.unit, str):
        return field.unit
    source = values[field.unit.field]
    if source is None:
        return None
    units = {field.unit.of(s) for s in (source if isinstance(source, list) else [source])}
    return units.pop() if len(units) == 1 else "1"


def number(builder: Builder, loc: Loc, value: Any, known: Known, unit: str) -> Any:
    """Return a number in SI; those of a fixed unit are it already."""
    return build_amount(builder, loc, value, unit) if isinstance(value, str) else value


def marker(builder: Builder, loc: Loc, value: Any, known: Known, unit: str) -> Any:
    """Return the marker that an entry names."""
    return builder.marker(loc, value, known["bodies"])


def coordinate(builder: Builder, loc: Loc, value: Any, known: Known, unit: str) -> Any:
    """Return the coordinate that an entry names."""
    return build_coordinate(builder, loc, value, known["bodies"], known["joints"])


def coordinates(builder: Builder, loc: Loc, value: Any, known: Known, unit: str) -> Any:
    """Return the coordinates of a list, None if one is wrong."""
    found = [coordinate(builder, (*loc, i), one, known, unit) for i, one in enumerate(value)]
    return None if None in found else found


def signal(builder: Builder, loc: Loc, value: Any, known: Known, unit: str) -> Any:
    """Return the signal of an entry."""
    return build_signal(builder, loc, value, unit)


FORMS: dict[str, Callable[[Builder, Loc, Any, Known, str], Any]] = {
    "number": number,
    "marker": marker,
    "coordinate": coordinate,
    "coordinates": coordinates,
    "signal": signal,
}
"""How a value of each form becomes an object; those of other forms stay as they are."""


def build_coordinate(
    builder: Builder, loc: Loc, entry: Any, bodies: Mapping[str, Any], joints: Mapping[str, Any]
) -> Any:
    """Return the coordinate that ``hinge.angle`` or a mapping says, None if there is none."""
    if isinstance(entry, Entry):
        return build_declared(builder, loc, entry, "coordinates", {"bodies": bodies})
    name, _, key = entry.rpartition(".")
    if name not in joints:
        builder.unknown(loc, "joints", "joint", name, joints)
        return None
    joint = joints[name]
    known = {s.name.rpartition(".")[2]: s for s in joint.coordinates}
    if key not in known:
        kind = type(joint).__name__
        hint = suggest(key, known) if known else f"; a {kind} joint has no coordinates"
        builder.note(loc, f"joint {name!r} has no {key}{hint}")
        return None
    return known[key]
