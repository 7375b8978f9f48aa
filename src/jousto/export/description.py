"""Description of a functional mock-up unit: modelDescription.xml of FMI 2.0 and 3.0."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass
from xml.etree import ElementTree as xml

from jousto.base.units import parse_unit
from jousto.base.version import __version__
from jousto.export.ports import Port, state_units
from jousto.export.program import Program

BASE = {"[mass]": "kg", "[length]": "m", "[time]": "s", "[angle]": "rad", "[temperature]": "K"}
SHOWN = {  # display unit and its factor by SI unit
    "Pa": ("MPa", 1e-6),
    "m": ("mm", 1e3),
    "rad": ("deg", 57.29577951308232),
    "rad/s": ("rpm", 9.549296585513721),
    "N": ("kN", 1e-3),
    "N m": ("kN m", 1e-3),
}
CATEGORIES = ("logAll", "logStatusWarning", "logStatusDiscard", "logStatusError", "logStatusFatal")
STATE_LETTERS = ("x", "y", "z", "e0", "e1", "e2", "e3")
RATE_LETTERS = ("vx", "vy", "vz", "wx", "wy", "wz")


@dataclass(frozen=True)
class Variable:
    """Variable of the description.

    Attributes
    ----------
    name, about, unit : str
        Name, description and unit.
    ref : int
        Value reference, see fmu.h.
    causality, variability, initial : str
        Attributes of the standard; an empty `initial` is omitted.
    start : float or None
        Initial value of a variable that can be set.
    derivative : int
        Reference of the state whose derivative this variable is; -1 for none.
    """

    name: str
    about: str
    unit: str
    ref: int
    causality: str
    variability: str
    initial: str = ""
    start: float | None = None
    derivative: int = -1


def variables(made: Program, *, exchange: bool) -> tuple[Variable, ...]:
    """Return the variables of a unit: time, inputs, outputs, parameters, then states."""
    found = [Variable("time", "simulated time", "s", 0, "independent", "continuous")]
    used = {"time"}

    def name_of(port: Port, tail: str) -> str:
        name = port.name
        while name in used:
            name += tail
        used.add(name)
        return name

    p, ref = made.ports, 1
    for port in p.inputs:
        name = name_of(port, ".input")
        row = (name, port.about, port.unit, ref, "input", "continuous", "", port.start)
        found.append(Variable(*row))
        ref += 1
    for port in p.outputs:
        name = name_of(port, ".output")
        found.append(
            Variable(name, port.about, port.unit, ref, "output", "continuous", "calculated")
        )
        ref += 1
    for port in p.parameters:
        name = name_of(port, ".parameter")
        row = (name, port.about, port.unit, ref, "parameter", "tunable", "exact", port.start)
        found.append(Variable(*row))
        ref += 1
    return (*found, *_states(made, ref)) if exchange else tuple(found)


def _states(made: Program, ref: int) -> Iterator[Variable]:
    m = made.model
    n = m.nq + m.nv + m.nstate
    names, units = [""] * n, ["1"] * n
    for body in m.bodies:
        modes = [f"p{j + 1}" for j in range(body.n)]
        places = [f"q.{body.name}.{x}" for x in (*STATE_LETTERS, *modes)]
        rates = [f"v.{body.name}.{x}" for x in (*RATE_LETTERS, *(f"d{x}" for x in modes))]
        names[body.iq : body.iq + len(places)] = places
        names[m.nq + body.iv : m.nq + body.iv + len(rates)] = rates
        units[body.iq : body.iq + 3] = ["m"] * 3
        units[m.nq + body.iv : m.nq + body.iv + 6] = ["m/s"] * 3 + ["rad/s"] * 3
    names[m.nq + m.nv :] = [f"x.{name}" for name in m.state_names]
    units[m.nq + m.nv :] = state_units(m)
    starts = [*m.q0, *m.v0, *made.states.tolist()]
    for k in range(n):
        about = "state of the machine"
        row = (names[k], about, units[k], ref + k, "local", "continuous", "exact", starts[k])
        yield Variable(*row)
    for k in range(n):
        about = f"derivative of {names[k]}"
        usual = {"1": "1/s", "m/s": "m/s2", "rad/s": "rad/s2"}
        unit = usual.get(units[k], f"{units[k]}/s")
        yield Variable(
            f"der({names[k]})",
            about,
            unit,
            ref + n + k,
            "local",
            "continuous",
            "calculated",
            None,
            ref + k,
        )


def token(made: Program, code: str) -> str:
    """Return the token of binary and description: a hash of the code."""
    digest = hashlib.sha256(code.encode()).hexdigest()
    return f"{{{digest[:8]}-{digest[8:12]}-{digest[12:16]}-{digest[16:20]}-{digest[20:32]}}}"


def _units(root: xml.Element, found: tuple[Variable, ...], version: int) -> None:
    parent = xml.SubElement(root, "UnitDefinitions")
    for unit in sorted({x.unit for x in found} - {"1", ""}):
        node = xml.SubElement(parent, "Unit", name=unit)
        base = xml.SubElement(node, "BaseUnit")
        powers = parse_unit(unit).dimensionality
        for dimension, power in sorted(powers.items()):
            if dimension in BASE and power == int(power):
                base.set(BASE[dimension], str(int(power)))
        if unit in SHOWN:
            name, factor = SHOWN[unit]
            xml.SubElement(node, "DisplayUnit", name=name, factor=repr(factor))


def description(
    made: Program,
    version: int,
    identity: str,
    *,
    exchange: bool,
    stop: float,
    derivatives: bool = False,
) -> str:
    """Return the text of modelDescription.xml.

    Parameters
    ----------
    made : Program
    version : int
        2 or 3.
    identity : str
        From `token`.
    exchange : bool
        Whether model exchange is provided in addition to co-simulation.
    stop : float
        Stop time of the default experiment, s.
    derivatives : bool
        Whether directional derivatives are provided.
    """
    found = variables(made, exchange=exchange)
    root = xml.Element("fmiModelDescription", fmiVersion=f"{version}.0")
    root.set("modelName", made.model.name)
    root.set("instantiationToken" if version == 3 else "guid", identity)
    root.set("description", f"flexible multibody machine, {type(made.solver).__name__}")
    root.set("generationTool", f"jousto {__version__}")
    if version == 2:
        root.set("variableNamingConvention", "flat")
        root.set("numberOfEventIndicators", "0")
    state = "FMUState" if version == 3 else "FMUstate"
    common = {
        "modelIdentifier": made.name,
        f"canGetAndSet{state}": "true",
        f"canSerialize{state}": "true",
    }
    if derivatives:
        common[
            f"provides{'DirectionalDerivatives' if version == 3 else 'DirectionalDerivative'}"
        ] = "true"
    if exchange:
        needs = {
            "needsCompletedIntegratorStep"
            if version == 3
            else "completedIntegratorStepNotNeeded": "true" if version == 3 else "false"
        }
        xml.SubElement(root, "ModelExchange", {**common, **needs})
    steps = {"canHandleVariableCommunicationStepSize": "true"}
    if version == 3:
        steps |= {
            "fixedInternalStepSize": repr(float(made.solver.step)),
            "hasEventMode": "false",
        }
    xml.SubElement(root, "CoSimulation", {**common, **steps})
    _units(root, found, version)
    logs = xml.SubElement(root, "LogCategories")
    for name in CATEGORIES:
        xml.SubElement(logs, "Category", name=name)
    xml.SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=repr(float(stop)),
        stepSize=repr(float(made.solver.step)),
    )
    (_model3 if version == 3 else _model2)(root, found)
    xml.indent(root)
    text = xml.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _facts(x: Variable) -> dict[str, str]:
    facts = {"name": x.name, "valueReference": str(x.ref), "description": x.about}
    facts |= {"causality": x.causality, "variability": x.variability}
    return facts | ({"initial": x.initial} if x.initial else {})


def _value(x: Variable) -> dict[str, str]:
    facts = {} if x.unit in ("1", "") else {"unit": x.unit}
    if x.unit in SHOWN:
        facts["displayUnit"] = SHOWN[x.unit][0]
    return facts | ({} if x.start is None else {"start": repr(float(x.start))})


def _model3(root: xml.Element, found: tuple[Variable, ...]) -> None:
    parent = xml.SubElement(root, "ModelVariables")
    for x in found:
        facts = {**_facts(x), **_value(x)}
        if x.derivative >= 0:
            facts["derivative"] = str(x.derivative)
        xml.SubElement(parent, "Float64", facts)
    structure = xml.SubElement(root, "ModelStructure")
    kinds = (
        ("Output", [x for x in found if x.causality == "output"]),
        ("ContinuousStateDerivative", [x for x in found if x.derivative >= 0]),
        ("InitialUnknown", [x for x in found if x.initial == "calculated"]),
    )
    for kind, those in kinds:
        for x in those:
            xml.SubElement(structure, kind, valueReference=str(x.ref))


def _model2(root: xml.Element, found: tuple[Variable, ...]) -> None:
    parent = xml.SubElement(root, "ModelVariables")
    index = {x.ref: k + 1 for k, x in enumerate(found)}
    for x in found:
        node = xml.SubElement(parent, "ScalarVariable", _facts(x))
        facts = _value(x)
        if x.derivative >= 0:
            facts["derivative"] = str(index[x.derivative])
        xml.SubElement(node, "Real", facts)
    structure = xml.SubElement(root, "ModelStructure")
    kinds = (
        ("Outputs", [x for x in found if x.causality == "output"]),
        ("Derivatives", [x for x in found if x.derivative >= 0]),
        ("InitialUnknowns", [x for x in found if x.initial == "calculated"]),
    )
    for kind, those in kinds:
        if those:
            node = xml.SubElement(structure, kind)
            for x in those:
                xml.SubElement(node, "Unknown", index=str(index[x.ref]))
