"""From entries to starts and frictions of coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jousto.mechanism.forces.friction import Friction, Regularised, StickSlip
from jousto.mechanism.initial import Initial
from jousto.schema.file.document import Loc
from jousto.schema.make.amounts import build_amount, per_second
from jousto.schema.make.declared import build_coordinate

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder


def with_markers(
    builder: Builder, loc: Loc, entry: Any, bodies: dict[str, Any]
) -> dict[str, Any] | None:
    """Return the values of an entry with its markers a and b, None if one is wrong."""
    values: dict[str, Any] = entry.given()
    for key in ("a", "b"):
        values[key] = builder.marker((*loc, key), values[key], bodies)
    return None if values["a"] is None or values["b"] is None else values


def build_initial(
    builder: Builder, loc: Loc, entry: Any, bodies: dict[str, Any], joints: dict[str, Any]
) -> Any:
    """Return the value and rate that a coordinate starts with, None if anything is wrong."""
    values = entry.given()
    s = build_coordinate(builder, (*loc, "coordinate"), values.pop("coordinate"), bodies, joints)
    if s is None:
        return None
    for key, unit in (("value", s.unit), ("rate", per_second(s.unit))):
        if key in values:
            values[key] = build_amount(builder, (*loc, key), values[key], unit)
            if values[key] is None:
                return None
    return builder.make(loc, Initial, s, **values)


def build_friction(builder: Builder, loc: Loc, entry: Any, joints: dict[str, Any]) -> Any:
    """Return the friction of an entry, None if anything is wrong with it."""
    values = entry.given()
    values["joint"] = joints.get(entry.joint)
    if values["joint"] is None:
        builder.unknown((*loc, "joint"), "joints", "joint", entry.joint, joints)
        return None
    if entry.law is not None:
        make: Any = StickSlip if entry.law.type == "stick-slip" else Regularised
        values["law"] = builder.make((*loc, "law"), make, **entry.law.given())
        if values["law"] is None:
            return None
    return builder.make(loc, Friction, **values)
