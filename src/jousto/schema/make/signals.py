"""From entries to signals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jousto.mechanism.signals.base import Constant, ConstantSpeed, Input, Product, Sum
from jousto.mechanism.signals.harmonic import Harmonic
from jousto.mechanism.signals.piecewise import Ramp, SCurve, Step, Table
from jousto.mechanism.signals.switched import Switched
from jousto.schema.entries.base import Entry
from jousto.schema.entries.signals import SwitchedEntry, TableEntry
from jousto.schema.file.document import Loc
from jousto.schema.make.amounts import build_amount, per_second
from jousto.schema.make.tables import build_table

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder

SIGNALS = {
    "constant": Constant,
    "constant-speed": ConstantSpeed,
    "harmonic": Harmonic,
    "table": Table,
    "step": Step,
    "ramp": Ramp,
    "s-curve": SCurve,
    "input": Input,
    "switched": Switched,
    "sum": Sum,
    "product": Product,
}

# keys of signals that have the unit of what the signal is used for
AMOUNTS = ("value", "values", "amplitude", "offset", "before", "after", "initial")


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
        return build_table(builder, loc, entry, "s", unit)
    values = entry.given()
    if isinstance(entry, SwitchedEntry):
        values["event"] = builder.event((*loc, "event"), entry.event)
        for key in ("before", "after"):
            values[key] = build_signal(builder, (*loc, key), values[key], unit)
        return None if None in values.values() else builder.make(loc, Switched, **values)
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
