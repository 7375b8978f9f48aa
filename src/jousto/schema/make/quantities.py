"""Amounts: numbers or strings whose expected unit depends on the field that uses them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jousto.base.units import UnitError, quantity
from jousto.schema.file.document import Loc

if TYPE_CHECKING:
    from jousto.schema.make.builder import Builder


def build_amount(builder: Builder, loc: Loc, value: Any, unit: str) -> Any:
    """Return a number in SI, or a tuple of numbers; None if a unit is wrong."""
    if isinstance(value, tuple):
        found = tuple(build_amount(builder, (*loc, i), x, unit) for i, x in enumerate(value))
        return None if None in found else found
    try:
        return quantity(value, unit)
    except UnitError as error:
        builder.note(loc, str(error))
        return None


def per_second(unit: str) -> str:
    """Return the SI unit of a rate; "1" if files have no name for it."""
    return {"m": "m/s", "rad": "rad/s", "1": "1/s"}.get(unit, "1")
