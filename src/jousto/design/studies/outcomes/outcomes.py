"""Outcomes of a study: numbers of sensors, masses, frequencies, stress, damage and reactions."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from jousto.base.arguments import explained
from jousto.base.complexstep import is_stepping, magnitude, norm, plainly, real_parts, scalar
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.names import check_name
from jousto.base.object_repr import described
from jousto.design.studies.case import Case
from jousto.design.studies.outcomes.complex_step import directional, has_slope
from jousto.design.studies.outcomes.deflection import Deflection
from jousto.design.studies.outcomes.function import Function
from jousto.design.studies.outcomes.outcome import Outcome
from jousto.materials.strength.sn import SN
from jousto.mechanism.sensors.loads import ReactionSensor
from jousto.model.model import Model
from jousto.model.start_complex_step import has_steps
from jousto.simulation.results.dataframes import component_units
from jousto.simulation.results.memory import displaced_results
from jousto.simulation.results.solution import Solution

Floats = np.ndarray[Any, np.dtype[np.float64]]
Laws = tuple[Any, tuple[tuple[str, Any], ...]]
"""S-N curve with options."""

OVER_TIME: dict[str, Callable[[Floats], Any]] = {
    "max": np.max,
    "min": np.min,
    "last": lambda x: x[-1],
    "first": lambda x: x[0],
    "mean": np.mean,
    "rms": lambda x: np.sqrt(np.mean(x**2)),
    "range": np.ptp,
    "peak": lambda x: np.max(magnitude(x)),
}
"""Functions of a history by name; peak is the largest magnitude."""


def _body(case: Case, name: str, flexible: bool = True) -> str:
    """Return the problem of an unknown body name, empty if the body exists."""
    known = [
        body.name
        for body, shape in zip(case.model.bodies, case.model.shapes, strict=True)
        if shape.stress is not None or not flexible
    ]
    if flexible:
        known += [beam.name for beam in case.model.beam_shapes if beam.stressed]
    if name in known:
        return ""
    return f"no body {name!r}{' whose stress is known' if flexible else ''}{suggest(name, known)}"


@described
@dataclass(frozen=True, eq=False)
class OfSensor(Outcome):
    """Number of the history of a sensor's component, by a function of `OVER_TIME`."""

    name: str
    how: str
    sensor: str

    def value(self, case: Case) -> float:
        """Return the number at one point."""
        return scalar(OVER_TIME[self.how](np.ravel(case.run[self.sensor])))

    def unit(self, case: Case) -> str:
        """Return the SI unit of the component."""
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
        """Return the problem of an unknown sensor or a missing component name."""
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
        """Return the mass at one point."""
        model: Model = case.model
        some = [body for body in model.bodies if self.body in ("", body.name)]
        return scalar(sum(body.mass[0] for body in some))

    def unit(self, case: Case) -> str:
        """Return the unit kg."""
        return "kg"

    def check(self, case: Case) -> str:
        """Return the problem of an unknown body."""
        return _body(case, self.body, flexible=False) if self.body else ""


@described
@dataclass(frozen=True, eq=False)
class Frequency(Outcome):
    """The n-th natural frequency about the initial pose or the equilibrium, Hz."""

    name: str
    number: int
    rest: bool = False
    needs_run: ClassVar[bool] = False

    def value(self, case: Case) -> float:
        """Return the frequency at one point."""
        if has_steps(case.model):
            from jousto.simulation.statics.complex_step import frequency

            return frequency(case.model, self.number, self.rest)
        found = case.cached(("modes", self.rest), lambda: self._modes(case.model))
        if self.number > len(found.frequencies):
            raise InputError(Problem(self.name, f"there are {len(found.frequencies)} modes only"))
        return scalar(found.frequencies[self.number - 1])

    def _modes(self, model: Model) -> Any:
        from jousto.simulation.modes.linear import modes
        from jousto.simulation.statics.equilibrium import equilibrium

        return modes(model, equilibrium(model) if self.rest else None)

    def unit(self, case: Case) -> str:
        """Return the unit Hz."""
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
        """Return the stress at one point."""
        from jousto.recovery.fields.build import stress_field
        from jousto.recovery.hotspots.hot_spots import hot_spots

        def spots(run: Solution) -> Any:
            return hot_spots(run, bodies=[self.body], count=1, criterion=self.criterion).spots

        def at(run: Solution, site: str, times: Any = None) -> Any:
            field = stress_field(run, self.body, sites=[site])
            return np.ravel(field.values(self.criterion, times=times))

        if not has_slope(case.run):
            if self.site:
                return float(at(case.run, self.site).max())
            worst = spots(case.run)
            return float(worst[0].value) if worst else 0.0
        # the derivative at the same place and instant
        with plainly():
            plain = displaced_results(case.run, 0.0)
            found: Any = () if self.site else spots(plain)
            if not self.site and not found:
                return 0.0
            site = self.site or found[0].site
            instant = int(np.argmax(at(plain, site)))
            if found and found[0].value < 0.0:
                instant = int(np.argmin(at(plain, site)))
        return directional(case, lambda run, _: at(run, site)[instant])

    def unit(self, case: Case) -> str:
        """Return the unit Pa."""
        return "Pa"

    def check(self, case: Case) -> str:
        """Return the problem of a body without stress data."""
        return _body(case, self.body) if case.runs else ""


@explained
@described
@dataclass(frozen=True, eq=False)
class Damage(Outcome):
    """Largest damage of one run at any place of a body, or its life, s.

    Parameters
    ----------
    name : str
        Name of the column.
    check_name : str
        Name of a check in the model file or of its body, or of the body whose cycles are evaluated
        by `sn`.
    life : bool
        Life, s, instead of damage.
    sn : SN, optional
        S-N curve; by default that of the check.
    options : dict
        Options of `jousto.fatigue.damage_field`, with an S-N curve: criterion, residue, mean and
        others.

    Examples
    --------
    ``Damage("life", "arm", life=True, sn=SN(50e6, 2e6, 3), options={"residue": "repeat"})``
    """

    name: str
    check_name: str
    life: bool = False
    sn: Any = None
    options: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        problems, given = Problems(), dict(vars(self))
        where = check_name(problems, "outcome", self.name)
        kinds = {"check_name": str, "life": bool, "options": Mapping}
        for key, kind in kinds.items():
            if not isinstance(given[key], kind):
                problems.add(where, f"{key} is {given[key]!r}, must be a {kind.__name__}")
        if not (self.sn is None or isinstance(self.sn, SN)):
            problems.add(where, f"sn is {self.sn!r}, must be an S-N curve, SN(S_D, N_D, k)")
        problems.raise_if_any()

    def value(self, case: Case) -> float:
        """Return damage or life at one point."""
        laws = self._laws(case)
        if has_slope(case.run) or is_stepping() and real_parts(laws) is not laws:
            return self._with_slope(case, laws)
        how = tuple(sorted(map(repr, self.options.items())))
        where = ("damage", self.check_name, id(self.sn), how)
        return self._number(case.cached(where, lambda: self._field(case, case.run, laws)))

    def _with_slope(self, case: Case, laws: Laws) -> float:
        """Return damage or life with its derivative at the same place and for the same cycles.

        Turning points are stored instants. A small change of a parameter moves them to neighbouring
        instants, so that differences must not count the cycles again.
        """
        from jousto.fatigue.miner.damage import damage
        from jousto.recovery.fields.criteria import Plane

        run = displaced_results(case.run, 0.0) if has_slope(case.run) else case.run
        with plainly():
            found = self._field(case, run, real_parts(laws))
            worst = int(np.argmax(found.damage))
            if not 0.0 < found.damage[worst] < np.inf:
                return self._number(found)
            site, criterion = found.labels[worst], found.criterion
            cycles = found.cycles(self._stress(case, run, [site]), site)
            if found.normals is not None and np.any(found.normals[worst]):
                criterion = Plane(found.normals[worst])

        def again(run: Solution, change: float) -> float:
            sigma = self._stress(case, run, [site]).values(criterion)[:, 0]
            ends = sigma[cycles.from_index], sigma[cycles.to_index]
            span, mean = abs(ends[1] - ends[0]), 0.5 * (ends[0] + ends[1])
            sn, options = real_parts(laws, change)
            given = dict(options)
            survival = given.get("survival", sn.survival)
            curve = sn if survival == sn.survival else sn.at_survival(survival)
            total = damage(replace(cycles, range=span, mean=mean), curve, given.get("mean"))
            return given.get("allowable", 1.0) * found.duration / total if self.life else total

        return directional(case, again)

    def _number(self, found: Any) -> float:
        return float(found.life.min() if self.life else found.damage.max())

    def _laws(self, case: Case) -> Laws:
        """Return the S-N curve and the given options of `damage_field`."""
        check = self._check(case)
        if self.sn is not None or check is None:
            options: Mapping[str, Any] = self.options
            return self.sn, tuple((k, v) for k, v in options.items() if v is not None)
        return check.sn, (("residue", check.residue), *check.options.items())

    def _field(self, case: Case, run: Solution, laws: Laws) -> Any:
        from jousto.fatigue.miner.damage_field import damage_field

        sn, options = laws
        return damage_field(self._stress(case, run), sn, **dict(options))

    def _stress(self, case: Case, run: Solution, sites: Any = None) -> Any:
        from jousto.recovery.fields.build import stress_field

        check = self._check(case)
        if self.sn is not None or check is None:
            return stress_field(run, self.check_name, sites=sites)
        return stress_field(run, check.body, sites=check.sites if sites is None else sites)

    def _check(self, case: Case) -> Any:
        for check in case.checks:
            if self.check_name in (check.name, check.body):
                return check
        return None

    def unit(self, case: Case) -> str:
        """Return the unit: s for a life, 1 for damage."""
        return "s" if self.life else "1"

    def check(self, case: Case) -> str:
        """Return the problem of a body without S-N curve or check."""
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
        """Return the force at one point."""
        F = case.run[self._sensor(case)]
        return scalar(norm(F[:, :3], axis=1).max())

    def _sensor(self, case: Case) -> str:
        for sensor in case.mechanism.sensors:
            if isinstance(sensor, ReactionSensor) and sensor.joint.name == self.joint:
                return sensor.name
        return ""

    def unit(self, case: Case) -> str:
        """Return the unit N."""
        return "N"

    def check(self, case: Case) -> str:
        """Return the problem of a joint without reaction sensor."""
        if not case.runs or self._sensor(case):
            return ""
        joints = [joint.name for joint in case.mechanism.joints]
        if self.joint not in joints:
            return f"no joint {self.joint!r}{suggest(self.joint, joints)}"
        return f"nothing measures joint {self.joint!r}; add a sensor of type reaction"


CALL = re.compile(r"\s*(?:([^=()]+?)\s*=\s*)?([a-z]+)\s*(?:\((.*)\))?\s*", re.S)
HELP = (
    "an outcome is mass, mass(BODY), frequency(N), stress(BODY), stress(BODY, SITE), "
    "deflection(BODY, NODE, SEEN FROM), damage(CHECK), life(CHECK), reaction(JOINT), or max, min, "
    "peak, range, rms, mean, first, last of a sensor, such as max(tip.y)"
)
WORDS = ("mass", "frequency", "stress", "deflection", "damage", "life", "reaction", *OVER_TIME)
COUNTS = {"mass": (0, 1), "stress": (1, 2), "deflection": (3, 3), "frequency": (1, 2)}
"""Numbers of arguments in the brackets, where other than one."""


def read_outcome(text: str) -> Outcome:
    """Return the outcome of a text: ``max(tip.y)``, or with a name ``rise = max(tip.y)``.

    Raises
    ------
    InputError
        If the text is not an outcome.

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
    least, most = COUNTS.get(word, (1, 1))
    if not least <= len(inside) <= most:
        raise InputError(Problem(where, HELP))
    if word in OVER_TIME:
        return OfSensor(name, word, inside[0])
    if word == "mass":
        return Mass(name, *inside)
    if word == "stress":
        return Stress(name, *inside)
    if word == "deflection":
        return Deflection(name, *inside)
    if word == "reaction":
        return Reaction(name, inside[0])
    if word in ("damage", "life"):
        return Damage(name, inside[0], life=word == "life")
    if not inside[0].isdecimal() or int(inside[0]) < 1 or inside[1:] not in ([], ["rest"]):
        message = f"frequency({', '.join(inside)}): give the number of a mode from 1, and rest"
        raise InputError(Problem(where, message + " for that about the position of rest"))
    return Frequency(name, int(inside[0]), rest=bool(inside[1:]))


def read_outcomes(given: Any) -> tuple[Outcome, ...]:
    """Return the outcomes of a text, a function, an `Outcome`, or a list or mapping of these.

    Raises
    ------
    InputError
        With all problems.
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
