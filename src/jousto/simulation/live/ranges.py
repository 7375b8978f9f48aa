"""Units and slider ranges of the external inputs of a model, from their use in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.mechanism.forces.law import unit_along
from jousto.model.force_numbers import law_in
from jousto.model.model import CoordinateModel, Model
from jousto.model.native.header import named

WEIGHTS = 2.0  # largest force of an input over the weight of the machine
EARTH = 9.81  # gravity for this weight in a model without gravity, m/s2


@dataclass(frozen=True)
class InputRange:
    """Unit, range and value of an external input, for a slider.

    Attributes
    ----------
    name, unit : str
        Name, and SI unit of the quantity that the input sets; "1" for factors.
    low, high, value : float
        Limits of the slider, and initial value.
    """

    name: str
    unit: str
    low: float
    high: float
    value: float


def input_ranges(
    model: Model, given: Mapping[str, tuple[float, float]] | None = None
) -> tuple[InputRange, ...]:
    """Return the unit, range and value of each external input of a model.

    The range of an angle is the initial value plus and minus 90 degrees, of a length plus and minus
    a tenth of the size of the machine; forces go up to twice its weight, torques up to twice weight
    times size, factors of forces up to twice their value or 1.

    Parameters
    ----------
    model : Model
        From `compile`.
    given : dict of str to (float, float), optional
        Ranges by name that replace the computed ones.

    Raises
    ------
    InputError
        If there is no such input, or a range is empty.
    """
    problems, given = Problems(), dict(given or {})
    for name, (low, high) in given.items():
        if name not in model.inputs:
            problems.add("live", f"no input {name!r}{suggest(name, model.inputs)}")
        elif not (np.isfinite([low, high]).all() and low < high):
            problems.add(
                f"input {name!r}", f"has the range {low:g} to {high:g}, must have low < high"
            )
    problems.raise_if_any()
    units = _units(model)
    found = []
    for place, signal in enumerate(model.signals):
        if signal.kind == "input":
            value = float(named("jo_constant_data", signal.data).value)
            unit = units.get(place, "1")
            reach = _reach(model, unit, value)
            low, high = map(float, given.get(signal.name, (value - reach, value + reach)))
            found.append((signal.count, InputRange(signal.name, unit, low, high, value)))
    return tuple(item for _, item in sorted(found, key=lambda pair: pair[0]))


def parse_ranges(texts: list[str]) -> dict[str, tuple[float, float]]:
    """Return ranges from texts such as ``luffing=-0.2..0.3``.

    Raises
    ------
    InputError
        If a text is not of this form.

    Examples
    --------
    >>> parse_ranges(["luffing = -0.2 .. 0.3"])
    {'luffing': (-0.2, 0.3)}
    """
    found = {}
    for text in texts:
        name, _, span = text.partition("=")
        low, _, high = span.partition("..")
        try:
            found[name.strip()] = (float(low), float(high))
        except ValueError:
            message = f"is {text!r}, must be NAME=LOW..HIGH in SI units, such as luffing=-0.2..0.3"
            raise InputError(Problem("--input", message)) from None
    return found


def _reach(model: Model, unit: str, value: float) -> float:
    mass = sum(float(body.mass[0]) for body in model.bodies)
    weight = mass * (float(np.linalg.norm(model.gravity)) or EARTH)
    reach = {
        "rad": 0.5 * np.pi,
        "m": 0.1 * model.size,
        "N": WEIGHTS * weight,
        "N m": WEIGHTS * weight * model.size,
    }.get(unit, max(1.0, 2.0 * abs(value)))
    return float(f"{reach:.2g}") if unit != "rad" else float(reach)


def _units(model: Model) -> dict[int, str]:
    """Return the unit of each signal from its use, by the index of the signal."""
    found: dict[int, str] = {}

    def note(signal: int, unit: str) -> None:
        if signal < 0 or signal in found:
            return
        found[signal] = unit
        if model.signals[signal].kind == "sum":
            for part in model.signals[signal].children:
                note(part, unit)

    for joint in model.joints:
        for line in joint.lines:
            if len(line.coordinates) == 1:
                note(line.signal, _length(model.coordinates[line.coordinates[0]]))
    for force in model.forces:
        if force.coordinate >= 0:
            law = law_in(force)
            angular = _length(model.coordinates[force.coordinate]) == "rad"
            for signal, unit in ((force.reference, law.reference), (force.signal, law.signal)):
                if unit != "1":
                    note(signal, unit_along(unit, angular))
    return found


def _length(coordinate: CoordinateModel) -> str:
    return "rad" if coordinate.kind == "angle" else "m"
