"""Outcomes: the numbers that a study wants to know of every point."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from jousto.base.arguments import explained
from jousto.base.described import described
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.names import check_name
from jousto.design.studies.case import Case
from jousto.mechanism.sensors.loads import ReactionSensor
from jousto.model.model import Model
from jousto.simulation.results.frames import component_units

Floats = np.ndarray[Any, np.dtype[np.float64]]

OVER_TIME: dict[str, Callable[[Floats], Any]] = {
    "max": np.max,
    "min": np.min,
    "last": lambda x: x[-1],
    "first": lambda x: x[0],
    "mean": np.mean,
    "rms": lambda x: np.sqrt(np.mean(x**2)),
    "range": np.ptp,
    "peak": lambda x: np.max(np.abs(x)),
}
"""Numbers of a history; the peak is the largest magnitude."""


@described
class Outcome(ABC):
    """A number that a study wants to know of every point.

    Attributes
    ----------
    name : str
        Of its column.
    needs_run : bool
        Whether the model is simulated for it.
    """

    name: str
    needs_run: ClassVar[bool] = True

    @abstractmethod
    def value(self, case: Case) -> float:
        """Return it for one point."""

    def unit(self, case: Case) -> str:
        """Return its SI unit."""
        return "1"

    def check(self, case: Case) -> str:
        """Return what is wrong with it for this machine, empty if nothing is."""
        return ""


def _body(case: Case, name: str, flexible: bool = True) -> str:
    """Return what is wrong with the name of a body."""
    known = [
        body.name
        for body, shape in zip(case.model.bodies, case.model.shapes, strict=True)
        if shape.stress is not None or not flexible
    ]
    if name in known:
        return ""
    return f"no body {name!r}{' whose stress is known' if flexible else ''}{suggest(name, known)}"


@described
@dataclass(frozen=True, eq=False)
class OfSensor(Outcome):
    """A number of the history of a sensor's component: `OVER_TIME`."""

    name: str
    how: str
    sensor: str

    def value(self, case: Case) -> float:
        """Return it for one point."""
        return float(OVER_TIME[self.how](np.ravel(case.run[self.sensor])))

    def unit(self, case: Case) -> str:
        """Return the unit of the component."""
        if not case.runs:
            return str(case.run.about(self.sensor)["unit"])
        for sensor in case.model.sensors:
            about = {"unit": sensor.unit, "components": sensor.components}
            names = [f"{sensor.name}.{c}" for c in sensor.components]
            if self.sensor in (sensor.name, *names):
                k = names.index(self.sensor) if self.sensor in names else 0
                return component_units(about)[k]
        return "1"

    def check(self, case: Case) -> str:
        """Return whether there is no such sensor, or it has several components."""
        if not case.runs:
            return ""
        known: dict[str, tuple[str, ...]] = {s.name: s.components for s in case.model.sensors}
        name, _, component = self.sensor.rpartition(".")
        if self.sensor in known:
            if len(known[self.sensor]) == 1:
                return ""
            some = ", ".join(f"{self.sensor}.{c}" for c in known[self.sensor])
            return f"sensor {self.sensor!r} has several components; name one: {some}"
        if name in known:
            if component in known[name]:
                return ""
            shown = suggest(component, known[name])
            return f"sensor {name!r} has no component {component!r}{shown}"
        return f"no sensor {self.sensor!r}{suggest(self.sensor, known)}"


@described
@dataclass(frozen=True, eq=False)
class Mass(Outcome):
    """Mass of a body or of everything that moves, kg."""

    name: str
    body: str = ""
    needs_run: ClassVar[bool] = False

    def value(self, case: Case) -> float:
        """Return it for one point."""
        model: Model = case.model
        some = [body for body in model.bodies if self.body in ("", body.name)]
        return float(sum(body.mass[0] for body in some))

    def unit(self, case: Case) -> str:
        """Return kg."""
        return "kg"

    def check(self, case: Case) -> str:
        """Return whether there is no such body."""
        return _body(case, self.body, flexible=False) if self.body else ""


@described
@dataclass(frozen=True, eq=False)
class Frequency(Outcome):
    """The n-th natural frequency about the initial pose or the position of rest, Hz."""

    name: str
    number: int
    rest: bool = False
    needs_run: ClassVar[bool] = False

    def value(self, case: Case) -> float:
        """Return it for one point."""
        found = case.once(("modes", self.rest), lambda: self._modes(case.model))
        if self.number > len(found.frequencies):
            raise InputError(Problem(self.name, f"there are {len(found.frequencies)} modes only"))
        return float(found.frequencies[self.number - 1])

    def _modes(self, model: Model) -> Any:
        from jousto.simulation.modes.linear import modes
        from jousto.simulation.statics.equilibrium import equilibrium

        return modes(model, equilibrium(model) if self.rest else None)

    def unit(self, case: Case) -> str:
        """Return Hz."""
        return "Hz"


@described
@dataclass(frozen=True, eq=False)
class Stress(Outcome):
    """Largest stress of a body over the run at its hot spot, or at one place, Pa."""

    name: str
    body: str
    site: str = ""
    criterion: str = "von-mises"

    def value(self, case: Case) -> float:
        """Return it for one point."""
        from jousto.recovery.fields.build import stress_field
        from jousto.recovery.hotspots.spots import hot_spots

        if not self.site:
            run, body = case.run, self.body
            found = hot_spots(run, bodies=[body], count=1, criterion=self.criterion).spots
            return float(found[0].value) if found else 0.0
        field = stress_field(case.run, self.body, sites=[self.site])
        return float(field.envelope(self.criterion).max.max())

    def unit(self, case: Case) -> str:
        """Return Pa."""
        return "Pa"

    def check(self, case: Case) -> str:
        """Return whether its stress is unknown."""
        return _body(case, self.body) if case.runs else ""


@described
@dataclass(frozen=True, eq=False)
class Damage(Outcome):
    """Largest damage of one run at any place of a body, or its life, s.

    Of the check of the model file with that name or of that body, or by an S-N curve.
    """

    name: str
    check_name: str
    life: bool = False
    sn: Any = None
    options: Mapping[str, Any] = field(default_factory=dict)

    def value(self, case: Case) -> float:
        """Return it for one point."""
        found = case.once(("damage", self.check_name, id(self.sn)), lambda: self._field(case))
        return float(found.life.min() if self.life else found.damage.max())

    def _field(self, case: Case) -> Any:
        from jousto.fatigue.miner.damage_field import damage_field
        from jousto.recovery.fields.build import stress_field

        check = self._check(case)
        if self.sn is not None or check is None:
            field = stress_field(case.run, self.check_name)
            return damage_field(field, self.sn, **self.options)
        field = stress_field(case.run, check.body, sites=check.sites)
        return damage_field(field, check.sn, residue=check.residue, **check.options)

    def _check(self, case: Case) -> Any:
        for check in case.checks:
            if self.check_name in (check.name, check.body):
                return check
        return None

    def unit(self, case: Case) -> str:
        """Return s for a life, 1 for damage."""
        return "s" if self.life else "1"

    def check(self, case: Case) -> str:
        """Return whether there is nothing to count by."""
        if self.sn is not None:
            return _body(case, self.check_name) if case.runs else ""
        if self._check(case) is not None:
            return ""
        known = {check.name for check in case.checks} | {check.body for check in case.checks}
        tail = suggest(self.check_name, known) if known else "; the model file has no fatigue"
        return f"no check {self.check_name!r}{tail}"


@described
@dataclass(frozen=True, eq=False)
class Reaction(Outcome):
    """Largest force of a joint over the run, N; a `ReactionSensor` must measure it."""

    name: str
    joint: str

    def value(self, case: Case) -> float:
        """Return it for one point."""
        F = case.run[self._sensor(case)]
        return float(np.linalg.norm(F[:, :3], axis=1).max())

    def _sensor(self, case: Case) -> str:
        for sensor in case.mechanism.sensors:
            if isinstance(sensor, ReactionSensor) and sensor.joint.name == self.joint:
                return sensor.name
        return ""

    def unit(self, case: Case) -> str:
        """Return N."""
        return "N"

    def check(self, case: Case) -> str:
        """Return whether nothing measures it."""
        if not case.runs or self._sensor(case):
            return ""
        joints = [joint.name for joint in case.mechanism.joints]
        if self.joint not in joints:
            return f"no joint {self.joint!r}{suggest(self.joint, joints)}"
        return f"nothing measures joint {self.joint!r}; add a sensor of type reaction"


@explained
@described
@dataclass(frozen=True, eq=False)
class Function(Outcome):
    """A number that a Python function works out.

    Parameters
    ----------
    name : str
        Of its column.
    function : callable
        ``function(run)`` of the `Solution`, or of what `of` names.
    of : {"run", "model", "mechanism", "case"}
        What the function gets; only "run" and "case" need a simulation. A case has all of them
        and ``case.values``.
    measured_in : str
        SI unit.

    Examples
    --------
    ``Function("swing", lambda run: np.ptp(run["tip.x"]), measured_in="m")``
    """

    name: str
    function: Callable[[Any], Any]
    of: str = "run"
    measured_in: str = "1"

    def __post_init__(self) -> None:
        problems = Problems()
        where = check_name(problems, "outcome", self.name)
        given: Any = self.function
        if not callable(given):
            problems.add(where, f"function is {given!r}, must be a function")
        known = ("run", "model", "mechanism", "case")
        if self.of not in known:
            problems.add(where, f"of is {self.of!r}{suggest(str(self.of), known)}")
        problems.raise_if_any()

    @property
    def needs_run(self) -> bool:  # type: ignore[override]
        """Whether the model is simulated for it."""
        return self.of in ("run", "case")

    def value(self, case: Case) -> float:
        """Return it for one point."""
        found = self.function(case if self.of == "case" else getattr(case, self.of))
        array = np.asarray(found)
        if array.size != 1 or array.dtype.kind not in "fiub":
            message = f"its function returned {found!r:.60}, must be one number"
            raise InputError(Problem(f"outcome '{self.name}'", message))
        return float(array.reshape(()))

    def unit(self, case: Case) -> str:
        """Return what it is measured in."""
        return self.measured_in


CALL = re.compile(r"\s*(?:([^=()]+?)\s*=\s*)?([a-z]+)\s*(?:\((.*)\))?\s*", re.S)
HELP = (
    "an outcome is mass, mass(BODY), frequency(N), stress(BODY), stress(BODY, SITE), "
    "damage(CHECK), life(CHECK), reaction(JOINT), or max, min, peak, range, rms, mean, first, "
    "last of a sensor, such as max(tip.y)"
)
WORDS = ("mass", "frequency", "stress", "damage", "life", "reaction", *OVER_TIME)


def read_outcome(text: str) -> Outcome:
    """Return the outcome of a text, ``max(tip.y)`` or with a name ``rise = max(tip.y)``.

    Raises
    ------
    InputError
        If it is none.

    Examples
    --------
    >>> read_outcome("rise = max(tip.y)").name
    'rise'
    """
    where = f"outcome {text!r}"
    match = CALL.fullmatch(text) if type(text) is str else None
    if match is None:
        raise InputError(Problem(where, HELP))
    word, inside = match[2], [x.strip() for x in (match[3] or "").split(",") if x.strip()]
    name = (match[1] or f"{word}({', '.join(inside)})" if inside else match[1] or word).strip()
    if word not in WORDS:
        raise InputError(Problem(where, f"no outcome {word!r}{suggest(word, WORDS)}"))
    least, most = {"mass": (0, 1), "stress": (1, 2), "frequency": (1, 2)}.get(word, (1, 1))
    if not least <= len(inside) <= most:
        raise InputError(Problem(where, HELP))
    if word in OVER_TIME:
        return OfSensor(name, word, inside[0])
    if word == "mass":
        return Mass(name, *inside)
    if word == "stress":
        return Stress(name, *inside)
    if word == "reaction":
        return Reaction(name, inside[0])
    if word in ("damage", "life"):
        return Damage(name, inside[0], life=word == "life")
    if not inside[0].isdecimal() or int(inside[0]) < 1 or inside[1:] not in ([], ["rest"]):
        message = f"frequency({', '.join(inside)}): give the number of a mode from 1, and rest"
        raise InputError(Problem(where, message + " for that about the position of rest"))
    return Frequency(name, int(inside[0]), rest=bool(inside[1:]))


def read_outcomes(given: Any) -> tuple[Outcome, ...]:
    """Return the outcomes of a text, a function, an `Outcome`, a list or a mapping of them.

    Raises
    ------
    InputError
        Everything that is wrong with them.
    """
    if isinstance(given, (str, Outcome)) or callable(given):
        given = [given]
    problems: list[Problem] = []
    found: list[Outcome] = []
    pairs = given.items() if isinstance(given, Mapping) else ((None, item) for item in given)
    for name, item in pairs:
        try:
            if isinstance(item, Outcome):
                found.append(item)
            elif isinstance(item, str):
                found.append(read_outcome(item if name is None else f"{name} = {item}"))
            elif callable(item):
                own = name or str(getattr(item, "__name__", "outcome"))
                found.append(Function("outcome" if own == "<lambda>" else own, item))
            else:
                message = f"is {item!r}, must be a text, a function of a Solution or an Outcome"
                problems.append(Problem("outcome", message))
        except InputError as error:
            problems += error.problems
    names = [outcome.name for outcome in found]
    for name in dict.fromkeys(names):
        if names.count(name) > 1:
            message = "given twice; name them, as in {'a': ..., 'b': ...} or 'a = max(tip.y)'"
            problems.append(Problem(f"outcome {name!r}", message))
    if not found and not problems:
        problems.append(Problem("study", f"no outcomes; {HELP}"))
    if problems:
        raise InputError(problems)
    return tuple(found)
