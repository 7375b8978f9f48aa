"""Objects of declared classes from their entries; names are replaced by objects."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeAlias

from jousto.base.errors import suggest
from jousto.mechanism.signals.base import Use
from jousto.mechanism.signals.piecewise import Table
from jousto.schema.entries.base import Entry
from jousto.schema.file.document import Loc
from jousto.schema.make.quantities import build_amount, per_second
from jousto.schema.make.tables import build_table

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder

Known: TypeAlias = Mapping[str, Any]
"""For each section the objects made before, by their names; the part or mesh that is read."""
NOTHING: Known = MappingProxyType({})


@dataclass(frozen=True)
class Place:
    """Path of the value of a field in a document, and the objects that it may refer to.

    Parameters
    ----------
    builder, loc
        Builder, and path of the entry.
    field : Field
        Field of the declared class.
    known : mapping
        Objects that the entry may name.
    values : mapping
        Values of the fields before this one.
    use : str
        SI unit of the quantity that a signal prescribes.
    """

    builder: Builder
    loc: Loc
    field: Any
    known: Known
    values: Mapping[str, Any]
    use: str = "1"

    def at(self, key: Any) -> Place:
        """Return the place of one item of a value."""
        return replace(self, loc=(*self.loc, key))

    def unit(self, unit: Any = None) -> str:
        """Return the SI unit of the field, or that of a given unit for the same coordinate."""
        unit = self.field.unit if unit is None else unit
        if isinstance(unit, str):
            return unit
        if isinstance(unit, Use):
            return per_second(self.use) if unit.rate else self.use
        source = self.values[unit.field]
        units = {unit.of(s) for s in (source if isinstance(source, list) else [source])}
        return units.pop() if len(units) == 1 else "1"


def build_declared(
    builder: Builder,
    loc: Loc,
    entry: Any,
    known: Known = NOTHING,
    use: str = "1",
    more: Mapping[str, Any] = NOTHING,
) -> Any:
    """Return the object of an entry; None, with problems, if it is invalid.

    Parameters
    ----------
    builder, loc, entry
        Builder, path of the entry, and the entry.
    known : mapping
        Objects that the entry may name.
    use : str
        SI unit of the quantity that a signal prescribes.
    more : mapping
        Values of fields that are not in the entry.
    """
    cls = entry.declared
    if cls in SPECIAL:
        return SPECIAL[cls](builder, loc, entry, use)
    given = entry.given()
    values: dict[str, Any] = {}
    items: tuple[Any, ...] = ()
    complete = True
    for key, field in cls.fields.items():
        if field.key not in given:
            continue
        make = builder.forms.get(field.form) or FORMS.get(field.form)
        if make is None or (make is number and type(given[field.key]) is float):
            values[key] = given[field.key]
        elif values.get(getattr(field.unit, "field", ""), given) is None:
            values[key] = None  # its unit depends on an invalid coordinate
        else:
            place = Place(builder, (*loc, field.key), field, known, values, use)
            values[key] = make(place, given[field.key])
        complete = complete and values[key] is not None
    if not complete:
        return None
    for key in cls.spread:
        items = values.pop(key, ())
    return builder.make(loc, cls, *items, **values, **more)


def check_names(
    builder: Builder, loc: Loc, cls: Any, given: Mapping[str, Any], known: Known, wrong: set[Loc]
) -> None:
    """Add a problem for each unknown name in an entry that is invalid for other reasons.

    Parameters
    ----------
    builder, loc
        Builder, and path of the entry.
    cls : class
        Class that the entry declares.
    given : mapping
        The entry as written in the document.
    known : mapping
        Objects that the entry may name.
    wrong : set of paths
        Paths of fields already known as invalid.
    """
    for field in cls.fields.values():
        place = Place(builder, (*loc, field.key), field, known, {})
        if field.form not in NAMING or place.loc in wrong:
            continue
        names = given.get(field.key)
        if isinstance(names, str) or (isinstance(names, list) and set(map(type, names)) == {str}):
            (builder.forms.get(field.form) or FORMS[field.form])(place, names)


def build_material(builder: Builder, loc: Loc, entry: Any) -> Any:
    """Return the material of an entry or of a name in the library."""
    from jousto.materials.library import material

    if isinstance(entry, str):
        return builder.make(loc, material, entry)
    return build_declared(builder, loc, entry)


def a_material(place: Place, value: Any) -> Any:
    """Return the material of an entry or of a name in the library."""
    return build_material(place.builder, place.loc, value)


def several(place: Place, value: Any) -> Any:
    """Return one object or a list of objects; None if one is invalid."""
    make = build_material if place.field.form == "materials" else build_declared
    found = place.builder.each(place.loc, value, lambda at, e: make(place.builder, at, e))
    return None if isinstance(found, list) and None in found else found


def number(place: Place, value: Any) -> Any:
    """Return a number in SI; numbers of a fixed unit are already converted."""
    if not isinstance(value, str):
        return value
    return build_amount(place.builder, place.loc, value, place.unit())


def series(place: Place, value: Any) -> Any:
    """Return numbers in SI; None if one is invalid."""
    return build_amount(place.builder, place.loc, value, place.unit())


def marker(place: Place, value: Any) -> Any:
    """Return the marker that an entry names."""
    return place.builder.marker(place.loc, value, place.known["bodies"])


def markers(place: Place, values: Any) -> Any:
    """Return the markers that an entry names; None if one is invalid."""
    made = tuple(marker(place.at(i), value) for i, value in enumerate(values))
    return None if None in made else made


def reference(place: Place, name: str) -> Any:
    """Return the object that an entry names."""
    section, word = place.field.section, place.field.word
    sections = (section,) if isinstance(section, str) else section
    known = [place.known[key] for key in sections]
    found = next((items[name] for items in known if name in items), None)
    if found is None:
        place.builder.unknown(place.loc, sections, word, name, [k for x in known for k in x])
    return found


def references(place: Place, names: Any) -> Any:
    """Return the objects that an entry names; None if one does not exist."""
    found = [reference(place.at(i), name) for i, name in enumerate(names)]
    return None if any(one is None for one in found) else found


def nested(place: Place, value: Any) -> Any:
    """Return the object of a nested entry; other values are returned unchanged."""
    if not isinstance(value, Entry):
        return value
    return build_declared(place.builder, place.loc, value, place.known)


def coordinate(place: Place, value: Any) -> Any:
    """Return the coordinate that an entry names."""
    known = place.known
    return build_coordinate(place.builder, place.loc, value, known["bodies"], known["joints"])


def coordinates(place: Place, value: Any) -> Any:
    """Return the coordinates of a list; None if one is invalid."""
    found = [coordinate(place.at(i), one) for i, one in enumerate(value)]
    return None if None in found else found


def signal(place: Place, value: Any) -> Any:
    """Return the signal of an entry."""
    return build_signal(place.builder, place.loc, value, place.unit())


def signals(place: Place, value: Any) -> Any:
    """Return the signals of a list; None if one is invalid."""
    rest = place.field.rest
    units = [place.unit(rest if i and rest else None) for i in range(len(value))]
    found = [
        build_signal(place.builder, (*place.loc, i), one, unit)
        for i, (one, unit) in enumerate(zip(value, units, strict=True))
    ]
    return None if None in found else found


def event(place: Place, value: Any) -> Any:
    """Return the event that an entry names."""
    return place.builder.event(place.loc, value)


def each(place: Place, value: Any) -> Any:
    """Return the object of an entry, or of each entry of a list; None if one is invalid."""
    found = place.builder.each(place.loc, value, partial(build_declared, place.builder))
    return None if isinstance(found, list) and None in found else found


def file(place: Place, value: str) -> Any:
    """Return the path of a file, relative to the model file."""
    return place.builder.file(value)


def items(place: Place, value: Any) -> Any:
    """Return the objects of a list of nested entries; None if one is invalid."""
    found = [nested(place.at(i), one) for i, one in enumerate(value)]
    return None if None in found else found


def orientation(place: Place, value: Any) -> Any:
    """Return an orientation; rotations about an axis become `Rotate`."""
    return place.builder.orientation(place.loc, value)


FORMS: dict[str, Callable[[Place, Any], Any]] = {
    "number": number,
    "material": a_material,
    "materials": several,
    "sections": several,
    "members": several,
    "point masses": several,
    "marker": marker,
    "markers": markers,
    "reference": reference,
    "references": references,
    "nested": nested,
    "item": nested,
    "damping": nested,
    "section": nested,
    "beam sections": each,
    "shape functions": each,
    "file": file,
    "coordinate": coordinate,
    "coordinates": coordinates,
    "series": series,
    "signal": signal,
    "items": items,
    "several nested": items,
    "orientation": orientation,
    "signals": signals,
    "event": event,
}
"""How a value of each form becomes an object; those of other forms stay as they are."""


NAMING = ("marker", "markers", "reference", "references", "coordinate", "coordinates", "event")
"""Forms whose values name entries of the file."""


def build_signal(builder: Builder, loc: Loc, entry: Any, unit: str) -> Any:
    """Return the signal or the number of an entry; None, with problems, if it is invalid.

    Parameters
    ----------
    builder, loc, entry
        Builder, path of the entry, and the entry.
    unit : str
        SI unit of the values of the signal.
    """
    if not isinstance(entry, Entry):
        return build_amount(builder, loc, entry, unit)
    return build_declared(builder, loc, entry, {}, unit)


def build_times(builder: Builder, loc: Loc, entry: Any, unit: str) -> Any:
    """Return the table of a signal."""
    return build_table(builder, loc, entry, "s", unit)


SPECIAL: dict[Any, Callable[[Builder, Loc, Any, str], Any]] = {Table: build_times}
"""How the few classes are made that files write in other ways than their fields say."""


def build_coordinate(
    builder: Builder, loc: Loc, entry: Any, bodies: Mapping[str, Any], joints: Mapping[str, Any]
) -> Any:
    """Return the coordinate of a text ``hinge.angle`` or a mapping; None if it is invalid."""
    if isinstance(entry, Entry):
        return build_declared(builder, loc, entry, {"bodies": bodies})
    name, _, key = entry.rpartition(".")
    if name not in joints:
        builder.unknown(loc, "joints", "joint", name, joints)
        return None
    joint = joints[name]
    known = {s.name.rpartition(".")[2]: s for s in (*joint.coordinates, *joint.held)}
    if key not in known:
        kind = type(joint).__name__
        hint = suggest(key, known) if known else f"; a {kind} joint has no coordinates"
        builder.note(loc, f"joint {name!r} has no {key}{hint}")
        return None
    return known[key]
