"""From entries to joints, coordinates, signals, couplings and drives."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jousto import mechanism as jm
from jousto.errors import suggest
from jousto.schema.document import Loc
from jousto.schema.entries import Entry
from jousto.schema.signals import SwitchedEntry, TableEntry
from jousto.schema.units import UnitError, quantity

if TYPE_CHECKING:
    from jousto.schema.build import Builder

JOINTS = {
    "spherical": jm.Spherical,
    "revolute": jm.Revolute,
    "fixed": jm.Fixed,
    "prismatic": jm.Prismatic,
    "cylindrical": jm.Cylindrical,
    "screw": jm.Screw,
    "universal": jm.Universal,
    "planar": jm.Planar,
    "point-on-line": jm.PointOnLine,
    "point-on-plane": jm.PointOnPlane,
    "constant-orientation": jm.ConstantOrientation,
    "rod": jm.Rod,
}
COUPLINGS = {"gear": jm.Gear, "rack": jm.Rack, "coupling": jm.Coupling, "drive": jm.Drive}
COORDINATES = {"angle": jm.Angle, "displacement": jm.Displacement, "distance": jm.Distance}
SIGNALS = {
    "constant": jm.Constant,
    "constant-speed": jm.ConstantSpeed,
    "harmonic": jm.Harmonic,
    "table": jm.Table,
    "step": jm.Step,
    "ramp": jm.Ramp,
    "s-curve": jm.SCurve,
    "input": jm.Input,
    "switched": jm.Switched,
    "sum": jm.Sum,
    "product": jm.Product,
}

# keys of signals that have the unit of what the signal is used for
AMOUNTS = ("value", "values", "amplitude", "offset", "before", "after", "initial")


def build_joint(builder: Builder, loc: Loc, entry: Any, bodies: dict[str, Any]) -> Any:
    """Return the joint of an entry, None if anything is wrong with it."""
    values = with_markers(builder, loc, entry, bodies)
    return None if values is None else builder.make(loc, JOINTS[entry.type], **values)


def with_markers(
    builder: Builder, loc: Loc, entry: Any, bodies: dict[str, Any]
) -> dict[str, Any] | None:
    """Return the values of an entry with its markers a and b, None if one is wrong."""
    values: dict[str, Any] = entry.given()
    for key in ("a", "b"):
        values[key] = builder.marker((*loc, key), values[key], bodies)
    return None if values["a"] is None or values["b"] is None else values


def build_coordinate(
    builder: Builder, loc: Loc, entry: Any, bodies: dict[str, Any], joints: dict[str, Any]
) -> Any:
    """Return the coordinate that ``hinge.angle`` or a mapping says, None if there is none."""
    if isinstance(entry, Entry):
        values = with_markers(builder, loc, entry, bodies)
        kind: Any = COORDINATES[entry.type]  # type: ignore[attr-defined]
        return None if values is None else builder.make(loc, kind, **values)
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


def build_amount(builder: Builder, loc: Loc, value: Any, unit: str) -> Any:
    """Return a number in SI, or a tuple of them; None if a unit is wrong."""
    if isinstance(value, tuple):
        found = tuple(build_amount(builder, (*loc, i), x, unit) for i, x in enumerate(value))
        return None if None in found else found
    try:
        return quantity(value, unit)
    except UnitError as error:
        builder.note(loc, str(error))
        return None


def build_signal(builder: Builder, loc: Loc, entry: Any, unit: str) -> Any:
    """Return the signal of an entry or the number it is, None if anything is wrong with it.

    Parameters
    ----------
    builder, loc, entry
        As everywhere.
    unit : str
        SI unit of its values. In a product it is that of the first factor, the others are
        plain numbers.
    """
    if not isinstance(entry, Entry):
        return build_amount(builder, loc, entry, unit)
    if isinstance(entry, TableEntry):
        from jousto.schema.tables import build_table

        return build_table(builder, loc, entry, "s", unit)
    values = entry.given()
    if isinstance(entry, SwitchedEntry):
        values["event"] = builder.event((*loc, "event"), entry.event)
        for key in ("before", "after"):
            values[key] = build_signal(builder, (*loc, key), values[key], unit)
        return None if None in values.values() else builder.make(loc, jm.Switched, **values)
    for key in ("terms", "factors"):
        if key in values:
            units = [unit if key == "terms" or i == 0 else "1" for i in range(len(values[key]))]
            parts = [
                build_signal(builder, (*loc, key, i), part, one)
                for i, (part, one) in enumerate(zip(values[key], units, strict=True))
            ]
            make: Any = SIGNALS[entry.type]  # type: ignore[attr-defined]
            return None if None in parts else builder.make(loc, make, *parts)
    for key in AMOUNTS:
        if key in values:
            values[key] = build_amount(builder, (*loc, key), values[key], unit)
    if "speed" in values:
        values["speed"] = build_amount(builder, (*loc, "speed"), values["speed"], per_second(unit))
    if None in values.values():
        return None
    make = SIGNALS[entry.type]  # type: ignore[attr-defined]
    return builder.make(loc, make, **values)


def per_second(unit: str) -> str:
    """Return the SI unit of a rate; "1" where the file has no name for it."""
    return {"m": "m/s", "rad": "rad/s", "1": "1/s"}.get(unit, "1")


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
    return builder.make(loc, jm.Initial, s, **values)


def build_coupler(
    builder: Builder, loc: Loc, entry: Any, bodies: dict[str, Any], joints: dict[str, Any]
) -> Any:
    """Return the gear, rack, coupling or drive of an entry, None if anything is wrong with it."""
    values = entry.given()
    for key in ("a", "b", "pinion", "rack", "coordinate"):
        if key in values:
            values[key] = build_coordinate(builder, (*loc, key), values[key], bodies, joints)
    if "coordinates" in values:
        values["coordinates"] = [
            build_coordinate(builder, (*loc, "coordinates", i), one, bodies, joints)
            for i, one in enumerate(values["coordinates"])
        ]
        units = {s.unit for s in values["coordinates"] if s is not None}
    if "coordinate" in values and values["coordinate"] is not None:
        unit = values["coordinate"].unit
        values["signal"] = build_signal(builder, (*loc, "signal"), values["signal"], unit)
    if "offset" in values:
        unit = units.pop() if len(units) == 1 else "1"
        values["offset"] = build_amount(builder, (*loc, "offset"), values["offset"], unit)
    if any(value is None for value in (*values.values(), *values.get("coordinates", ()))):
        return None
    return builder.make(loc, COUPLINGS[entry.type], **values)


def build_friction(builder: Builder, loc: Loc, entry: Any, joints: dict[str, Any]) -> Any:
    """Return the friction of an entry, None if anything is wrong with it."""
    values = entry.given()
    values["joint"] = joints.get(entry.joint)
    if values["joint"] is None:
        builder.unknown((*loc, "joint"), "joints", "joint", entry.joint, joints)
        return None
    if entry.law is not None:
        make: Any = jm.StickSlip if entry.law.type == "stick-slip" else jm.Regularised
        values["law"] = builder.make((*loc, "law"), make, **entry.law.given())
        if values["law"] is None:
            return None
    return builder.make(loc, jm.Friction, **values)
