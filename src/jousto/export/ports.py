"""Ports: inputs, outputs and parameters of an exported machine, with names and units."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from jousto.base.errors import InputError, Problem
from jousto.export.constants import Constants
from jousto.mechanism.forces.law import NEVER, unit_along
from jousto.model.force_numbers import law_in, struct_of
from jousto.model.model import ForceModel, Model, SignalModel
from jousto.model.native.header import named, places
from jousto.model.packing.foreign import without_fmus
from jousto.simulation.results.dataframes import component_units

XYZ = ("x", "y", "z")
ANGULAR = ("axes", "angle")
# all others in m
FRICTION = {"mu_kinetic": "1", "mu_static": "1", "velocity": "m/s", "preload": "N"}


@dataclass(frozen=True)
class Port:
    """Input, output or parameter of an exported machine: one number.

    Attributes
    ----------
    name : str
        Name of the sensor or input, such as ``tip.x``.
    symbol : str
        C identifier, such as ``tip_x``; unique among the ports of its kind.
    unit : str
        SI unit; "1" for none.
    about : str
        Description in one line.
    place : int
        Index among the inputs, sensor values or tunable numbers of the program.
    start : float
        Value at the beginning.
    """

    name: str
    symbol: str
    unit: str
    about: str
    place: int
    start: float = 0.0


@dataclass(frozen=True)
class Named:
    """Named constant of a model file that can change while an exported machine runs.

    Attributes
    ----------
    name, unit : str
        Name and unit in the file.
    value : float
        Its value, SI.
    bounds : (float, float) or None
        Smallest and largest meaningful value.
    links : tuple of (int, float, float)
        Tunable numbers that depend on it: index, factor and offset of each.
    """

    name: str
    unit: str
    value: float
    bounds: tuple[float, float] | None
    links: tuple[tuple[int, float, float], ...]


@dataclass(frozen=True)
class Ports:
    """Inputs, outputs and parameters of a program; named parameters come first."""

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    parameters: tuple[Port, ...]


def ports(model: Model, found: Constants, named_ones: Sequence[Named] = ()) -> Ports:
    """Return the ports of a model.

    Inputs are the external inputs of the model. Outputs are the components of its sensors,
    including damage. Parameters are gravity and the constants of its forces, frictions and named
    signals.
    """
    starts = {
        s.name: float(named("jo_constant_data", s.data).value)
        for s in model.signals
        if s.kind == "input"
    }
    inputs = [
        (
            "input",
            name,
            _input_unit(model, name),
            "external input, held between steps",
            k,
            starts[name],
        )
        for k, name in enumerate(model.inputs)
    ]
    outputs = []
    for sensor in model.sensors:
        about = {"unit": sensor.unit, "components": sensor.components}
        units = component_units(about)
        alone = sensor.count == 1
        for k, (component, unit) in enumerate(zip(sensor.components, units, strict=True)):
            name = sensor.name if alone else f"{sensor.name}.{component}"
            text = sensor.description
            if sensor.resolved_in not in ("", "world"):
                text += f", resolved in {sensor.resolved_in}"
            outputs.append(("output", name, unit, text, sensor.offset + k, 0.0))
    parameters = [
        ("parameter", x.name, x.unit, "named constant", found.places["named", k], x.value)
        for k, x in enumerate(named_ones)
    ]
    parameters += [("parameter", *row) for row in _parameters(model, found)]
    return Ports(_unique(inputs), _unique(outputs), _unique(parameters))


Row = tuple[str, str, str, str, int, float]


def _unique(rows: list[Row]) -> tuple[Port, ...]:
    used: set[str] = set()
    made = []
    for kind, name, unit, about, place, start in rows:
        symbol = base = identifier(name)
        k = 2
        while symbol in used:
            symbol, k = f"{base}_{k}", k + 1
        used.add(symbol)
        made.append(Port(name, symbol, unit or "1", f"{about}".strip() or kind, place, start))
    return tuple(made)


def identifier(name: str) -> str:
    """Return a name converted to a C identifier.

    Examples
    --------
    >>> identifier("tip.x"), identifier("2nd link")
    ('tip_x', '_2nd_link')
    """
    made = re.sub(r"[^0-9A-Za-z_]", "_", name)
    return f"_{made}" if not made or made[0].isdigit() else made


def _input_unit(model: Model, name: str) -> str:
    """Return the unit of an input if exactly one force or drive uses it, else an empty unit."""
    place = next(i for i, s in enumerate(model.signals) if s.kind == "input" and s.name == name)
    units = set()
    for force in model.forces:
        for used, unit in _function_units(model, force):
            if used == place:
                units.add(unit)
    for joint in model.joints:
        for line in joint.lines:
            if line.signal == place:
                units.add("rad" if _angular(model, line.coordinates[0]) else "m")
    return units.pop() if len(units) == 1 else "1"


def _angular(model: Model, coordinate: int) -> bool:
    return coordinate >= 0 and model.coordinates[coordinate].kind in ANGULAR


def _parameters(model: Model, found: Constants) -> Iterator[tuple[str, str, str, int, float]]:
    value = found.tunable
    for k, axis in enumerate(XYZ):
        at = found.places["gravity", 0] + k
        yield f"gravity.{axis}", "m/s2", f"gravity along world {axis}", at, value[at]
    sticking = {friction.contact for friction in model.frictions}
    for i, force in enumerate(model.forces):
        if ("force", i) not in found.places:
            continue
        start = found.places["force", i]
        for name, unit, about, at in _force_numbers(model, force):
            if i in sticking and name.startswith("mu_"):  # those of its frictions
                continue
            yield f"{force.name}.{name}", unit, about, start + at, value[start + at]
        yield from _law(model, found, force.name, force.signal)
        if force.reference != force.signal:
            yield from _law(model, found, f"{force.name}.reference", force.reference)
    for i, friction in enumerate(model.frictions):
        start = found.places["friction", i]
        for name, place in places("jo_friction_data").items():
            if name == "mass" or (friction.contact >= 0 and not name.startswith("mu_")):
                continue
            where = start + place.start
            unit = FRICTION.get(name, "m")
            yield f"{friction.name}.{name}", unit, "friction", where, value[where]
    for joint in model.joints:
        for k, line in enumerate(joint.lines):
            name = joint.name if k == 0 else f"{joint.name}.{k + 1}"
            yield from _law(model, found, name, line.signal)


def _function_units(model: Model, force: ForceModel) -> Iterator[tuple[int, str]]:
    """Yield the positions of the time functions of a force, and the units of their values."""
    law, angular = law_in(force), _angular(model, force.coordinate)
    yield force.reference, unit_along(law.reference, angular)
    yield force.signal, unit_along(law.signal, angular)


def state_units(model: Model) -> list[str]:
    """Return the units of the states of forces, 1 for those of equations of the user."""
    return [
        unit_along(unit, _angular(model, force.coordinate))
        for force in model.forces
        if force.states
        for unit in law_in(force).states.values() or ("1",) * force.states
    ]


def _force_numbers(model: Model, force: ForceModel) -> Iterator[tuple[str, str, str, int]]:
    """Yield name, unit, description and position of the tunable numbers of a force."""
    law, angular = law_in(force), _angular(model, force.coordinate)
    for name, at in places(struct_of(force.kind)).items():
        unit = law.units.get(name)
        if unit is None:
            continue
        note = f", {law.notes[name]}" if name in law.notes else ""
        if isinstance(unit, tuple):  # the diagonal of a matrix
            for k, one in enumerate(unit):
                place = at.start + k * (len(unit) + 1)
                yield f"{name.lower()}{k + 1}", one, f"diagonal of {name} of {force.name}", place
        elif at.stop - at.start == len(XYZ):
            for k, axis in enumerate(XYZ):
                about = f"{name} of {force.name}{note}"
                yield f"{name}.{axis}", unit_along(unit, angular), about, at.start + k
        elif abs(force.data[at.start]) < NEVER:
            about = f"{name} of {force.name}{note}"
            yield name, unit_along(unit, angular), about, at.start


LAWS = {
    "constant": ("jo_constant_data", {"value": "1"}),
    "harmonic": (
        "jo_harmonic_data",
        {"offset": "1", "amplitude": "1", "omega": "rad/s", "phase": "rad"},
    ),
    "step": ("jo_step_data", {"time": "s", "before": "1", "after": "1"}),
    "speed": ("jo_speed_data", {"offset": "1", "speed": "1/s"}),
}


def _law(
    model: Model, found: Constants, name: str, place: int
) -> Iterator[tuple[str, str, str, int, float]]:
    """Yield the constants of the signal of a force or drive."""
    if place < 0:
        return
    signal: SignalModel = model.signals[place]
    if signal.kind not in LAWS or ("signal", place) not in found.places:
        return
    struct, units = LAWS[signal.kind]
    start = found.places["signal", place]
    for key, at in places(struct).items():
        where = start + at.start
        yield (
            f"{name}.{key}",
            units[key],
            f"{signal.kind} signal of {name}",
            where,
            found.tunable[where],
        )


def refuse(model: Model) -> None:
    """Raise InputError for elements that an exported program cannot contain.

    Raises
    ------
    InputError
        If forces are Python functions.
    """
    problems = [
        Problem(
            f"force {force.name!r}",
            "is a Python function, which an exported program cannot call; use a force element "
            "with its own law, or an Input",
        )
        for force in model.forces
        if force.function is not None
    ]
    if problems:
        raise InputError(problems)
    without_fmus(model, "export", "cannot be exported to another program")
