"""Fmu: a model of another program, simulated together with the mechanism."""

from __future__ import annotations

import os
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problem, Problems, UnknownNameError, suggest, warn
from jousto.base.fields import AnyField, Choice, Flag, OptionalText, field, kept
from jousto.base.names import check_name
from jousto.base.numbers import Duration, number
from jousto.mechanism.event import component_of
from jousto.mechanism.foreign.description import Description, Variable, fits, read_description
from jousto.mechanism.sensors.base import Sensor
from jousto.mechanism.sensors.scalar import SignalSensor
from jousto.mechanism.signals.base import Input

ENERGIES = ("delivered", "received", "energy_error")


class FmuSensor(SignalSensor):
    """Value of a functional mock-up unit, or exchanged energy, at the last communication point.

    Attributes
    ----------
    unit, description : str
        Unit and description of the value.
    """

    unit = ""
    description = ""

    def __init__(self, name: str, unit: str, description: str) -> None:
        super().__init__(name, Input(name))
        object.__setattr__(self, "unit", unit)
        object.__setattr__(self, "description", description)


class Fmu(Declared, section="fmus"):
    """Functional mock-up unit (FMI 2.0 or 3.0, co-simulation) of another program.

    Every `step` the unit receives values of sensors and sets inputs of the mechanism. Between these
    instants unit and mechanism are integrated separately: exchanged values are held constant (error
    of order 1 in the step) or extrapolated linearly (order 2). Values are in SI; units of the
    description are converted.

    The exchanged energy is ``int F v dt``. The unit computes it with its own force and the received
    velocity, the mechanism with its own velocity and the received force; their difference is the
    energy that the exchange itself adds or removes (Sadjina, Kyllingstad, Skjong and Pedersen,
    Engineering with Computers 33, 2017, 607-620). The results contain these energies as the sensors
    ``NAME.delivered``, ``NAME.received`` and ``NAME.energy_error`` for each `power`.

    The unit runs in a separate process. Its native code is not checked: run only units that you
    trust.

    Attributes
    ----------
    untrusted : str
        Line of the model file that contains the unit, if that file was read as untrusted;
        `simulate` then refuses to load the unit's native code. Empty for units created in Python.
    """

    kind = "fmu"
    file: AnyField = field("File ``.fmu``", form="file", noun="path")
    name: OptionalText = field("Name; the name of the file if left out", default=None)
    inputs: AnyField = field(
        "Inputs or tunable parameters of the unit, each with a scalar sensor, (sensor, "
        "component), or a number",
        form="fmu inputs",
        noun="dict",
        default=None,
        kw_only=True,
    )
    outputs: AnyField = field(
        "Outputs of the unit, each with the Input of the mechanism that it sets, or None to store "
        "it in the results only",
        form="fmu outputs",
        noun="dict",
        default=None,
        kw_only=True,
    )
    parameters: AnyField = field(
        "Values of parameters and start values of variables, in SI",
        form="fmu parameters",
        noun="dict",
        default=None,
        kw_only=True,
    )
    power: AnyField = field(
        "Output and input of the unit whose product is power into the mechanism, such as "
        "{'force': 'speed'}",
        form="fmu pairs",
        noun="dict",
        default=None,
        kw_only=True,
    )
    step: Duration = field("Time between two exchanges", default=1e-3, kw_only=True)
    between: Choice = field(
        "Values between two exchanges: held constant or extrapolated linearly",
        words=("hold", "linear"),
        default="hold",
        kw_only=True,
    )
    estimate: Flag = field(
        "Whether each step is repeated as two half steps, whose result is used; the difference is "
        "the estimated error of a step, ``NAME.OUTPUT.error`` in the results. The unit must be "
        "able to restore its state",
        default=False,
        kw_only=True,
    )
    patience: Duration = field(
        "Wall-clock time limit for one answer of the unit (to load it, at least a minute); the "
        "run ends when it is exceeded",
        default=60.0,
        kw_only=True,
    )
    description: Description = kept()
    sensors: tuple[FmuSensor, ...] = kept()
    untrusted: str = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Read the description and report inputs, outputs and parameters that do not fit it."""
        if not isinstance(self.file, str | os.PathLike):
            problems.add("fmu", f"file is {self.file!r}, must be the path of a .fmu", "file")
            return
        path = Path(self.file)
        name = self.name or path.stem
        where = check_name(problems, "fmu", name)
        maps: dict[str, dict[str, Any]] = {}
        for key in ("inputs", "outputs", "parameters", "power"):
            given = getattr(self, key)
            if given is not None and not isinstance(given, Mapping):
                problems.add(where, f"{key} is {given!r}, must be a dict by names of variables")
                given = None
            maps[key] = dict(given or {})
        problems.raise_if_any()
        about = read_description(path, where)
        for key, value in {**maps, "file": path, "name": name, "description": about}.items():
            object.__setattr__(self, key, value)
        self._check_inputs(problems, where)
        self._check_outputs(problems, where)
        self._check_parameters(problems, where)
        for out, into in self.power.items():
            if out not in self.outputs:
                problems.add(where, f"{out!r} is not among its outputs here", "power", named=False)
            if into not in self.inputs or not isinstance(self.inputs.get(into), tuple):
                problems.add(
                    where,
                    f"{into!r} is not among its inputs from sensors here",
                    "power",
                    named=False,
                )
        if self.estimate and not about.states:
            problems.add(
                where,
                "cannot restore its state (canGetAndSetFMUState is false), which estimate=True "
                "needs; leave estimate out and compare two runs with different steps",
            )
        object.__setattr__(self, "sensors", tuple(self._sensors()))
        object.__setattr__(self, "untrusted", "")

    def _variable(self, problems: Problems, where: str, name: Any, *fit: str) -> Variable | None:
        """Return a variable with one of the given causalities, or report that there is none."""
        about = self.description
        known = [x.name for x in about.variables.values() if x.causality in fit]
        if "input" in fit:
            known += [x.name for x in about.variables.values() if x.variability == "tunable"]
        found = about.variables.get(name)
        if found is None:
            problems.add(where, f"has no {fit[0]} {name!r}{suggest(name, known)}")
        elif name not in known:
            problems.add(
                where,
                f"{name!r} has causality {found.causality}, must be {fit[0]}{suggest(name, known)}",
                name,
            )
        elif not found.real:
            problems.add(
                where,
                f"{fit[0]} {name!r} is not one real number; only real numbers can be exchanged",
            )
        else:
            if found.unit and not found.dimension:
                warn(where, f"{name!r} is in {found.unit!r}, which is not known: taken as SI", name)
            return found
        return None

    def _check_inputs(self, problems: Problems, where: str) -> None:
        for name, value in self.inputs.items():
            variable = self._variable(problems, where, name, "input")
            sensor, component = value if isinstance(value, tuple | list) else (value, None)
            if isinstance(sensor, Sensor):
                place = component_of(problems, f"{where}: input {name!r}", sensor, component)
                self.inputs[name] = (sensor, place)
                if variable and variable.dimension:
                    unit = _unit_of(sensor, place)
                    if unit != "1" and not fits(variable.dimension, unit):
                        warn(
                            where,
                            f"input {name!r} is in {variable.unit}, sensor {sensor.name!r} "
                            f"measures {unit}: check that it is the right sensor",
                        )
            else:
                self.inputs[name] = number(problems, where, f"input {name!r}", value)

    def _check_outputs(self, problems: Problems, where: str) -> None:
        for name, value in self.outputs.items():
            self._variable(problems, where, name, "output")
            if isinstance(value, str):
                self.outputs[name] = Input(value)
            elif value is not None and not isinstance(value, Input):
                problems.add(
                    where,
                    f"output {name!r} is for {value!r}, must be an Input of the mechanism, or None",
                    "output",
                )

    def _check_parameters(self, problems: Problems, where: str) -> None:
        about = self.description
        known = [x.name for x in about.variables.values() if x.settable]
        for name, value in self.parameters.items():
            found = about.variables.get(name)
            if found is None or not found.settable:
                problems.add(where, f"has no parameter or start value {name!r}"
                             f"{suggest(name, known)}")  # fmt: skip
            elif not found.real:
                problems.add(where, f"parameter {name!r} is not one real number")
            else:
                if found.unit and not found.dimension:
                    warn(
                        where,
                        f"{name!r} is in {found.unit!r}, which is not known: taken as SI",
                        name,
                    )
                self.parameters[name] = number(problems, where, f"parameter {name!r}", value)

    def _sensors(self) -> list[FmuSensor]:
        made = []
        for name in self.outputs:
            found = self.description.variables.get(name)
            unit = (found.dimension if found else "") or "1"
            made.append(FmuSensor(f"{self.name}.{name}", unit, f"output {name} of {self.name}"))
            if self.estimate:
                message = f"estimated error of {name} in one step"
                made.append(FmuSensor(f"{self.name}.{name}.error", unit, message))
        if self.power:
            texts = (
                "energy delivered by the unit",
                "energy received by the mechanism",
                "received - delivered",
            )
            for key, text in zip(ENERGIES, texts, strict=True):
                made.append(FmuSensor(f"{self.name}.{key}", "J", text))
        return made

    def __getitem__(self, name: str) -> FmuSensor:
        """Return the sensor of an output, which may be an input of other units."""
        known = {sensor.name.removeprefix(f"{self.name}."): sensor for sensor in self.sensors}
        if name not in known:
            raise UnknownNameError(
                Problem(
                    f"fmu {self.name!r}", f"no output {name!r} is declared{suggest(name, known)}"
                )
            )
        return known[name]

    @cached_property
    def driven(self) -> tuple[str, ...]:
        """Names of the inputs of the mechanism that the unit sets."""
        return tuple(x.name for x in self.outputs.values() if x is not None)

    def __repr__(self) -> str:
        return (
            f"<Fmu {self.name!r}: FMI {self.description.version}, {len(self.inputs)} inputs, "
            f"{len(self.outputs)} outputs, a step of {self.step:g} s>"
        )


def _unit_of(sensor: Any, place: int) -> str:
    units = [x.strip() for x in sensor.unit.split(",")]
    half = len(sensor.components) // 2
    return str(units[-1] if len(units) > 1 and place >= half else units[0])
