"""Ports: what goes into an exported machine and comes out of it, by name and unit."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from jousto.base.errors import InputError, Problem
from jousto.export.constants import Constants
from jousto.mechanism.forces.stop import NEVER
from jousto.model.model import CoordinateModel, ForceModel, Model, SignalModel
from jousto.model.native.header import named, places
from jousto.model.packing.foreign import without_fmus
from jousto.simulation.results.dataframes import component_units

XYZ = ("x", "y", "z")
ANGULAR = ("axes", "angle")
FRICTION = {"mu_kinetic": "1", "mu_static": "1", "velocity": "m/s", "preload": "N"}  # else m


@dataclass(frozen=True)
class Port:
    """A number that goes in or comes out.

    Attributes
    ----------
    name : str
        As a user knows it, ``tip.x``.
    symbol : str
        As an identifier of C, ``tip_x``; unique among the ports of its kind.
    unit : str
        SI unit; "1" for none.
    about : str
        A line of description.
    place : int
        Among the inputs, sensor values or tunable numbers of the program.
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
    """A named constant of a model file that a running machine may change.

    Attributes
    ----------
    name, unit : str
        As the file has them.
    value : float
        Its value, SI.
    bounds : (float, float) or None
        Smallest and largest value that make sense.
    links : tuple of (int, float, float)
        The tunable numbers that it stands for: place, factor and offset of each.
    """

    name: str
    unit: str
    value: float
    bounds: tuple[float, float] | None
    links: tuple[tuple[int, float, float], ...]


@dataclass(frozen=True)
class Ports:
    """The inputs, outputs and parameters of a program; of the parameters the named come first."""

    inputs: tuple[Port, ...]
    outputs: tuple[Port, ...]
    parameters: tuple[Port, ...]


def ports(model: Model, found: Constants, named_ones: Sequence[Named] = ()) -> Ports:
    """Return the ports of a model.

    Inputs are its external inputs, outputs the components of its sensors, damage included,
    parameters gravity and the constants of its forces, frictions and named signals.
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
    """Return a name as an identifier of C.

    Examples
    --------
    >>> identifier("tip.x"), identifier("2nd link")
    ('tip_x', '_2nd_link')
    """
    made = re.sub(r"[^0-9A-Za-z_]", "_", name)
    return f"_{made}" if not made or made[0].isdigit() else made


def _input_unit(model: Model, name: str) -> str:
    """Return the unit of an input where one force or drive uses it, else none."""
    place = next(i for i, s in enumerate(model.signals) if s.kind == "input" and s.name == name)
    units = set()
    for force in model.forces:
        if place in (force.signal, force.reference):
            units.add(_signal_unit(model, force, place))
    for joint in model.joints:
        for line in joint.lines:
            if line.signal == place:
                units.add("rad" if _angular(model, line.coordinates[0]) else "m")
    return units.pop() if len(units) == 1 else "1"


def _signal_unit(model: Model, force: ForceModel, place: int) -> str:
    if force.kind in ("along", "pid") and place == force.reference:
        unit = "rad" if _angular(model, force.coordinate) else "m"
        rate = force.kind == "pid" and bool(named("jo_pid_data", force.data).speed)
        return f"{unit}/s" if rate else unit
    if force.kind == "pid":
        return "N m" if _angular(model, force.coordinate) else "N"
    return "1"  # of a force along a coordinate times the preload


def _angular(model: Model, coordinate: int) -> bool:
    return model.coordinates[coordinate].kind in ANGULAR


def _parameters(model: Model, found: Constants) -> Iterator[tuple[str, str, str, int, float]]:
    value = found.tunable
    for k, axis in enumerate(XYZ):
        at = found.places["gravity", 0] + k
        yield f"gravity.{axis}", "m/s2", f"gravity along world {axis}", at, value[at]
    for i, force in enumerate(model.forces):
        if ("force", i) not in found.places:
            continue
        start = found.places["force", i]
        for name, unit, about, at in _force_numbers(model, force):
            yield f"{force.name}.{name}", unit, about, start + at, value[start + at]
        yield from _law(model, found, force.name, force.signal)
        if force.reference != force.signal:
            yield from _law(model, found, f"{force.name}.reference", force.reference)
    for i, friction in enumerate(model.frictions):
        start = found.places["friction", i]
        for name, place in places("jo_friction_data").items():
            where = start + place.start
            unit = FRICTION.get(name, "m")
            yield f"{friction.name}.{name}", unit, "friction", where, value[where]
    for joint in model.joints:
        for k, line in enumerate(joint.lines):
            name = joint.name if k == 0 else f"{joint.name}.{k + 1}"
            yield from _law(model, found, name, line.signal)


def state_units(model: Model) -> list[str]:
    """Return the units of the states of forces."""
    found = []
    for force in model.forces:
        if force.kind == "pid":
            angular = model.coordinates[force.coordinate].kind in ANGULAR
            rate = bool(named("jo_pid_data", force.data).speed)
            found += ["N m" if angular else "N", ("rad" if angular else "m") + "/s" * rate]
    return found


def _force_numbers(model: Model, force: ForceModel) -> Iterator[tuple[str, str, str, int]]:
    """Yield name, unit, description and place of the constants of a force."""
    if force.kind == "along":
        coordinate: CoordinateModel = model.coordinates[force.coordinate]
        angular = coordinate.kind in ANGULAR
        s, f = ("rad", "N m") if angular else ("m", "N")
        units = {
            "stiffness": f"{f}/{s}",
            "damping": f"{f} s/{s}",
            "free": s,
            "preload": f,
            "limit": f,
        }
        for name, at in places("jo_along_data").items():
            yield name, units[name], f"{name} of {force.name}", at.start
    elif force.kind == "stop":
        angular = model.coordinates[force.coordinate].kind in ANGULAR
        s, f = ("rad", "N m") if angular else ("m", "N")
        units = {"stiffness": f"{f}/{s}", "loss": "1", "speed": f"{s}/s"}
        for name, at in places("jo_stop_data").items():
            if abs(force.data[at.start]) < NEVER:
                yield name, units.get(name, s), f"{name} of {force.name}", at.start
    elif force.kind == "pid":
        angular = model.coordinates[force.coordinate].kind in ANGULAR
        s, f = ("rad", "N m") if angular else ("m", "N")
        rate = bool(named("jo_pid_data", force.data).speed)
        units = {"lower": f, "upper": f, "weight": "1", "filter": "s", "tracking": "s"}
        times = ("{}/{}/s", "{}/{}", "{} s/{}", "{} s2/{}")[rate:]
        for name, text in zip(("integral", "proportional", "derivative"), times, strict=False):
            units[name] = text.format(f, s)
        for name, at in places("jo_pid_data").items():
            if name in units and abs(force.data[at.start]) < NEVER:
                usual = ", 0 for that of its gains" if units[name] == "s" else ""
                yield name, units[name], f"{name} of {force.name}{usual}", at.start
    elif force.kind == "bushing":
        for field, letter, tail in (("K", "k", ""), ("D", "d", " s")):
            at = places("jo_bushing_data")[field].start
            for k in range(6):
                unit = f"N{tail}/m" if k < 3 else f"N m{tail}/rad"
                yield f"{letter}{k + 1}", unit, f"diagonal of {field} of {force.name}", at + 7 * k
    elif force.kind in ("load", "modal load", "moving load"):
        struct = f"jo_{force.kind.replace(' ', '_')}_data"
        for field in ("force", "torque"):
            if field in places(struct):
                unit = "N" if field == "force" else "N m"
                for k, axis in enumerate(XYZ):
                    at = places(struct)[field].start + k
                    yield f"{field}.{axis}", unit, f"{field} of {force.name}", at


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
    """Raise what an exported program cannot do.

    Raises
    ------
    InputError
        If forces are functions of Python.
    """
    problems = [
        Problem(
            f"force {force.name!r}",
            "is a function of Python, which no program outside of Python can call; "
            "use an element with a law of its own, or an Input",
        )
        for force in model.forces
        if force.function is not None
    ]
    if problems:
        raise InputError(problems)
    without_fmus(model, "export", "cannot go into another program")
