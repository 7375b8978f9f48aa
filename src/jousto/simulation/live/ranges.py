"""Units and ranges of the external inputs of a model, from what they act on."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.mechanism.forces.law import unit_along
from jousto.model.force_numbers import law_in
from jousto.model.model import CoordinateModel, Model
from jousto.model.native.header import named

WEIGHTS = 2.0  # force that an input may have, by the weight of the machine
EARTH = 9.81  # m/s2, where there is no gravity


@dataclass(frozen=True)
class InputRange:
    """An external input as something to be moved by hand.

    Attributes
    ----------
    name, unit : str
        Its name, and the unit of what it acts on in SI; "1" for factors.
    low, high, value : float
        A range for a slider, and the value at the start.
    """

    name: str
    unit: str
    low: float
    high: float
    value: float


def input_ranges(
    model: Model, given: Mapping[str, tuple[float, float]] | None = None
) -> tuple[InputRange, ...]:
    """Return the external inputs of a model.

    Angles go a quarter turn to both sides of the value at the start, lengths a tenth of the size
    of the machine, forces to twice its weight, torques to that times its size, factors of forces
    to twice their value or 1.

    Parameters
    ----------
    model : Model
        From `compile`.
    given : dict of str to (float, float), optional
        Ranges that are known better.

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
            problems.add(f"input {name!r}", f"goes from {low:g} to {high:g}, must go upwards")
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
        If one is none.

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
    """Return the units of signals by what uses them."""
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
