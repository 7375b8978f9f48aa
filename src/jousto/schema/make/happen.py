"""Events in the model file: what they watch, and when they are built."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jousto.base.errors import suggest
from jousto.base.units import KINDS
from jousto.mechanism.signals.event import Event
from jousto.schema.entries.base import Entry
from jousto.schema.file.document import Loc
from jousto.schema.make.amounts import build_amount
from jousto.schema.make.declared import build_coordinate

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder

# sensors that stand on forces, couplings or signals, which events may switch, or on other sensors:
# they come after
LATE = ("force", "signal", "damage", "bridge")


def is_late(entry: Any, joints: dict[str, Any]) -> bool:
    """Return whether a sensor can only be built after forces and couplings."""
    kind = getattr(entry, "type", "")
    if getattr(entry, "temperature", None) is not None:
        return True
    return kind in LATE or (kind == "reaction" and entry.joint not in joints)


def watches_late(entry: Any, late: set[str]) -> bool:
    """Return whether an event watches a late sensor."""
    return isinstance(entry.watch, str) and entry.watch in late


def build_event(
    builder: Builder, loc: Loc, entry: Any, known: dict[str, dict[str, Any]], sensors: list[str]
) -> Any:
    """Return the event of an entry, None if anything is wrong with it.

    Parameters
    ----------
    builder, loc, entry
        As everywhere.
    known : dict
        The objects that could be built, by section and name.
    sensors : list of str
        Names of all sensors of the file.
    """
    values = entry.given()
    watch = values["watch"]
    if isinstance(watch, str) and watch in sensors:
        values["watch"] = known["sensors"].get(watch)
        if values["watch"] is None and ("sensors", watch) not in builder.broken:
            builder.note(
                (*loc, "watch"),
                f"sensor {watch!r} belongs to a flexible body, which rigid=True makes rigid; leave "
                "the event out or watch something else",
            )
    elif isinstance(watch, Entry) or "." in watch:
        values["watch"] = build_coordinate(
            builder, (*loc, "watch"), watch, known["bodies"], known["joints"]
        )
    else:
        builder.note(
            (*loc, "watch"),
            f"no sensor {watch!r}{suggest(watch, sensors)}; or a coordinate such as hinge.angle",
        )
        return None
    if values["watch"] is None:
        return None
    if "threshold" in values:
        unit = unit_of(values["watch"], values.get("component"))
        place = (*loc, "threshold")
        values["threshold"] = build_amount(builder, place, values["threshold"], unit)
    if any(value is None for value in values.values()):
        return None
    return builder.make(loc, Event, **values)


def unit_of(watch: Any, component: Any) -> str:
    """Return the SI unit of what an event watches; "1" where it is not one the file knows."""
    units = [unit.strip() for unit in watch.unit.split(",")]
    names = getattr(watch, "components", ())
    unit = units[0]
    if len(units) == 2 and component is not None:  # forces, then moments
        at = component if isinstance(component, int) else list(names).index(component)
        unit = units[1] if at >= len(names) // 2 else units[0]
    return unit if unit in KINDS else "1"
