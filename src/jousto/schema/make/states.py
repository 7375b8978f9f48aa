"""Initial values, formulas, inputs and forces of states, from their entries."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.base.units import UnitError, in_si
from jousto.mechanism.states.expression import Expression, expression
from jousto.mechanism.states.formula import FormulaError, formula
from jousto.schema.entries.base import Entry
from jousto.schema.make.declared import Place, build_coordinate, build_declared
from jousto.schema.make.quantities import build_amount


def formulas(place: Place, given: Mapping[str, Any]) -> Any:
    """Return formulas by name, or by coordinate; None if one is invalid."""
    made: dict[Any, Any] = {}
    for key, value in given.items():
        at = place.at(key)
        name: Any = key
        if place.field.along:
            known = place.known
            name = build_coordinate(place.builder, at.loc, key, known["bodies"], known["joints"])
        made[name] = _value(at, value)
    return None if None in made or any(value is None for value in made.values()) else made


def _value(place: Place, value: Any) -> Any:
    """Return a number in SI, a signal, a formula, or for inputs its expression."""
    if isinstance(value, Entry):
        return build_declared(place.builder, place.loc, value, {}, place.unit() or "1")
    if not isinstance(value, str):
        return value
    try:
        found = in_si(value)
    except UnitError:
        if not getattr(place.field, "numbers", False):
            inputs = place.field.name == "inputs" or place.field.form != "formulas"
            return _input(place, value) if inputs else value
    else:
        unit = place.unit()  # fields without a unit accept any
        return build_amount(place.builder, place.loc, value, unit) if unit else found
    place.builder.note(place.loc, f"{value!r} is no number with a unit")
    return None


def _input(place: Place, text: str) -> Any:
    """Return the expression of an input, in which ``joint.angle`` is a coordinate."""
    joints = place.known["joints"]

    def refer(name: str, part: str) -> Any:
        if name not in joints:
            return Expression("named", of=(name, part))
        bodies = place.known["bodies"]
        made = build_coordinate(place.builder, place.loc, f"{name}.{part}", bodies, joints)
        if made is None:
            raise FormulaError("")
        return expression(made)

    try:
        return formula(text, {}, refer)
    except FormulaError as error:
        if str(error):
            place.builder.note(place.loc, str(error))
        return None


def several(place: Place, given: Any) -> Any:
    """Return inputs; None if one is invalid."""
    made = tuple(_value(place.at(i), value) for i, value in enumerate(given))
    return None if any(value is None for value in made) else made


FORMS = {"formulas": formulas, "formula": _value, "formula list": several}
