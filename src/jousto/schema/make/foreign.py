"""Inputs, outputs and parameters of functional mock-up units, from their entries."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from jousto.base.errors import InputError, UnknownNameError, suggest
from jousto.base.units import UnitError, quantity
from jousto.mechanism.foreign.description import read_description
from jousto.schema.make.builder import CircleError
from jousto.schema.make.declared import Place


def inputs(place: Place, given: Mapping[str, Any]) -> Any:
    """Return the source of each input: sensor, component or number; None if one is invalid."""
    found = {name: _source(place.at(name), name, value) for name, value in given.items()}
    return None if None in found.values() else found


def outputs(place: Place, given: Mapping[str, str | None]) -> Any:
    """Return the inputs of the mechanism that the entry names, in its order."""
    return dict(given)


def parameters(place: Place, given: Mapping[str, Any]) -> Any:
    """Return numbers in SI; None if one is invalid."""
    found = {name: _number(place.at(name), name, value) for name, value in given.items()}
    return None if None in found.values() else found


def _source(place: Place, variable: str, value: Any) -> Any:
    """Return the source of an input of a unit: a sensor, an output of another unit, or a number."""
    if not isinstance(value, str):
        return value
    sensors, fmus = place.known["sensors"], place.known["fmus"]
    name, _, rest = value.rpartition(".")
    if value in place.builder.sensors:
        return _sensor(place, value)
    if name in place.builder.sensors:
        sensor = _sensor(place, name)
        return None if sensor is None else (sensor, int(rest) if rest.isdigit() else rest)
    if name in fmus.places:
        return _output(place, fmus, name, rest)
    if value[:1].isdigit() or value[:1] in "+-.":
        return _number(place, variable, value)
    units = [key for key in fmus.places if key]
    place.builder.note(
        place.loc,
        f"no sensor {value!r}{suggest(value, [*sensors.places, *units])}; or SENSOR.COMPONENT, "
        "UNIT.OUTPUT of another unit, or a number",
    )
    return None


def _sensor(place: Place, name: str) -> Any:
    builder = place.builder
    found = place.known["sensors"].get(name)
    if found is None and ("sensors", name) not in builder.broken:
        builder.note(
            place.loc,
            f"sensor {name!r} belongs to a flexible body, which rigid=True makes rigid; leave the "
            "unit out or measure something else",
        )
    return found


def _output(place: Place, fmus: Any, name: str, output: str) -> Any:
    """Return the sensor of an output of another unit."""
    try:
        unit = fmus.get(name)
    except CircleError:
        place.builder.note(
            place.loc,
            f"units {name!r} and this one wait for each other; let one of the two values cross "
            "through an Input and a sensor of type signal",
        )
        return None
    if unit is None:
        return None
    try:
        return unit[output]
    except UnknownNameError as error:
        place.builder.note_problem(place.loc, error.problems[0])
        return None


def _number(place: Place, variable: str, value: Any) -> float | None:
    """Return a number in SI; a string may have any unit of the variable's dimension."""
    if not isinstance(value, str):
        return float(value)
    path = place.values.get("file")
    try:
        known = read_description(path, "").variables if path is not None else {}
    except InputError:
        return 0.0  # the constructor of the unit reports the problem of its file
    found = known.get(variable)
    try:
        return quantity(value, (found.dimension if found else "") or "1")
    except UnitError as error:
        place.builder.note(place.loc, str(error))
        return None


FORMS: dict[str, Callable[[Place, Any], Any]] = {
    "fmu inputs": inputs,
    "fmu outputs": outputs,
    "fmu parameters": parameters,
}
"""How the fields of a unit become objects."""
