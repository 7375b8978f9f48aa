"""From entries to geometrically exact beams."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jousto.mechanism.beams.body import BeamBody
from jousto.mechanism.beams.stiffness import BeamSection
from jousto.schema.entries.beams import BeamBodyEntry, BeamSectionEntry, OffsetSectionEntry
from jousto.schema.file.document import Loc
from jousto.schema.make.declared import build_declared, build_material

if TYPE_CHECKING:
    from jousto.schema.make.context import Builder


def build_beam(builder: Builder, loc: Loc, entry: BeamBodyEntry) -> Any:
    """Return the BeamBody of an entry, None if anything is wrong with it."""
    values = builder.orientations(loc, entry.given())
    before = len(builder.found)
    values["section"] = builder.each(
        (*loc, "section"), entry.section, lambda at, e: beam_section(builder, at, e)
    )
    if entry.material is not None:
        values["material"] = build_material(builder, (*loc, "material"), entry.material)
    if entry.damping is not None:
        values["damping"] = build_declared(builder, (*loc, "damping"), entry.damping)
    if len(builder.found) > before:
        return None
    return builder.make(loc, BeamBody, **values)


def beam_section(builder: Builder, loc: Loc, entry: Any) -> Any:
    """Return the section of an entry, None if anything is wrong with it."""
    if isinstance(entry, BeamSectionEntry):
        values = entry.given()
        if "points" in values:
            points = builder.each(
                (*loc, "points"),
                entry.points,
                lambda at, e: build_declared(builder, at, e),
            )
            if any(point is None for point in points):
                return None
            values["points"] = points
        return builder.make(loc, BeamSection, **values)
    if isinstance(entry, OffsetSectionEntry):
        values = entry.given()
        values["section"] = build_declared(builder, (*loc, "section"), entry.section)
        values["material"] = build_material(builder, (*loc, "material"), entry.material)
        if values["section"] is None or values["material"] is None:
            return None
        return builder.make(loc, BeamSection.of, **values)
    return build_declared(builder, loc, entry)
