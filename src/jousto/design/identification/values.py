"""Values: single measured numbers, such as masses, frequencies, and strains at rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.object_repr import described
from jousto.design.identification.bench import StillBench, machines_of
from jousto.design.identification.experiment import Comparison
from jousto.design.studies.case import Settings
from jousto.design.studies.outcomes.outcome import Outcome
from jousto.design.studies.outcomes.outcomes import read_outcomes
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.running.evaluator import Evaluator
from jousto.simulation.statics.equilibrium import equilibrium

MOMENT = 1e-3
"""Length of a run whose first instant is the position of rest, s."""


@explained
@described
@dataclass(frozen=True, eq=False)
class Values:
    """Single measured numbers of a machine: weights, frequencies, displacements, strains at rest.

    Parameters
    ----------
    values : dict
        Measured value and its standard deviation, SI, by outcome of `study`: ``{"mass(arm)":
        (12.31, 0.05), "frequency(1)": (7.58, 0.04)}``. The name of a sensor component alone is its
        value at the position of rest: ``{"root": (-3.5e-4, 1e-6)}``. An `Outcome`, such as
        `Function`, may stand for the text. The deviation may be a text, ``"0.5 %"`` of the value.
    inputs : dict of str to float, optional
        Inputs of the machine, such as the load of a static test.
    t_end : float, optional
        End of the run for outcomes over time, s.
    state : State or callable, optional
        Initial state of that run, as in `study`.
    model : callable, ModelFile, Mechanism or Model, optional
        Machine of this measurement, if it is not that of the others.
    name : str
        Name for tables.

    Raises
    ------
    InputError
        With all problems of the values.

    Examples
    --------
    >>> Values({"mass": (12.31, 0.05), "frequency(1)": (7.58, "0.5 %")})
    <Values 'values': 2 values>
    """

    values: Mapping[str | Outcome, tuple[float, float | str]]
    inputs: Mapping[str, float] = field(default_factory=dict)
    t_end: float | None = None
    state: Any = None
    model: Any = None
    name: str = "values"

    def __post_init__(self) -> None:
        problems = Problems()
        given: Any = self.values
        if not isinstance(given, Mapping) or not given:
            message = "values must be a dict, {outcome: (value, standard deviation)}"
            raise InputError(Problem(self.where, message))
        for key, pair in given.items():
            _read(problems, self.where, name_of(key), pair)
        problems.raise_if_any()

    @property
    def where(self) -> str:
        """Name in messages."""
        return f"values {self.name!r}"

    @property
    def free(self) -> tuple[Parameter, ...]:
        """Sought numbers of channels: none."""
        return ()

    def _facts(self) -> str:
        return f"{len(self.values)} values"


def name_of(key: str | Outcome) -> str:
    """Return the name of a measured number."""
    return key.name if isinstance(key, Outcome) else str(key)


def _read(problems: Problems, where: str, name: str, pair: Any) -> tuple[float, float]:
    """Return a value and its deviation, or report what they must be."""
    try:
        value, sd = pair
        value = float(value)
        if isinstance(sd, str):
            share, percent, rest = sd.partition("%")
            sd = 0.01 * float(share) * abs(value) if percent and not rest.strip() else np.nan
        sd = float(sd)
    except (TypeError, ValueError):
        value = sd = float("nan")
    if not (np.isfinite(value) and np.isfinite(sd) and sd > 0.0):
        message = "must be a pair of the value and its standard deviation, a number or '0.5 %'"
        problems.add(where, f"{name} is {pair!r:.60}, {message}")
    return value, sd


class ValuesBench(StillBench):
    """Bench of single values; see `Bench`."""

    def results(self, points: Sequence[Array]) -> list[Any]:
        """Return the outcomes (k,) at points (np,) of all unknowns, or the error of each."""
        found: list[Any] = []
        for theta in points:
            outcomes = self.evaluator.outcomes
            each = self.evaluator.outcomes_at(np.asarray(theta)[self.places], outcomes)
            errors = [one.error for one in each if one.error is not None]
            values = np.array([one.value for one in each], dtype=float)
            if not errors and not np.all(np.isfinite(values)):
                name = outcomes[int(np.argmin(np.isfinite(values)))].name
                errors = [InputError(Problem(self.experiment.where, f"{name} is not finite"))]
            found.append(errors[0] if errors else values)
        return found

    def compare(self, problems: Problems, result: Array) -> tuple[Comparison, ...]:
        """Return a comparison for each value."""
        case = self.evaluator.case(np.array([p.value for p in self.evaluator.parameters]))
        found = []
        given = zip(self.experiment.values.items(), self.evaluator.outcomes, strict=True)
        for (key, pair), outcome in given:
            name = name_of(key)
            value, sd = _read(problems, self.experiment.where, name, pair)
            each = (np.zeros(1), np.array([value]), np.array([sd]))
            found.append(Comparison(name, outcome.name, outcome.unit(case), *each, 1.0, 0.0, 0.0))
        return tuple(found)

    def show(self, result: Array, comparison: Comparison, shift: float) -> tuple[Array, Array]:
        """Return the outcome of a comparison (1,)."""
        k = [name_of(key) for key in self.experiment.values].index(comparison.channel)
        return result[k : k + 1], np.zeros(1)


def make_values_bench(
    problems: Problems, experiment: Values, model: Any, parameters: Sequence[Parameter]
) -> ValuesBench | None:
    """Return the bench of values; None, with problems, if there is none."""
    state = experiment.state if experiment.t_end is not None else equilibrium
    how = {} if state is None else {"state": state}
    settings = Settings(experiment.t_end or MOMENT, how, dict(experiment.inputs))
    made = machines_of(problems, experiment, model, parameters, settings)
    if made is None:
        return None
    sensors = {f"{s.name}.{c}" for s in made.start.sensors for c in s.components}
    sensors |= {s.name for s in made.start.sensors}
    texts = [f"first({key})" if key in sensors else key for key in experiment.values]
    try:
        evaluator = Evaluator(made.source, made.parameters, read_outcomes(texts))
        evaluator.check()
    except InputError as error:
        problems.found += error.problems
        return None
    return ValuesBench(experiment, evaluator, made.places)
