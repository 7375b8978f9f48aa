"""One point of a study: its machine, compiled model, run and outcomes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.complexstep import is_stepping
from jousto.base.errors import InputError, NotAnalytic, Problem
from jousto.base.object_repr import described
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.numbers import with_numbers
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.model.start_complex_step import has_steps
from jousto.model.variants import Variants
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.batched_runs import run_in_lanes
from jousto.simulation.running.inputs import drive
from jousto.simulation.running.repeated_runs import Repeated
from jousto.simulation.running.simulate import simulate
from jousto.simulation.running.start_state import initial_state

Counts = dict[str, int]


@dataclass(frozen=True)
class Settings:
    """Settings of the runs of a study: the arguments of `simulate`.

    Parameters
    ----------
    t_end : float or None
        End of the runs, s; None: that of the model.
    how : dict
        Given arguments solver, output_step and state; the state may be a function of the model,
        such as `jo.equilibrium`.
    inputs : dict
        Signals or numbers of external inputs, the same in all runs.
    """

    t_end: float | None = None
    how: Mapping[str, Any] = field(default_factory=dict)
    inputs: Mapping[str, Any] = field(default_factory=dict)

    def given(self, model: Model) -> dict[str, Any]:
        """Return the arguments of `simulate` for a model."""
        how = dict(self.how)
        if callable(how.get("state")):
            how["state"] = _begun(how["state"], model)
        return how


def _begun(begin: Callable[[Model], Any], model: Model) -> Any:
    """Return the initial state from the user's function of the model."""
    if not has_steps(model):
        return begin(model)
    from jousto.simulation.statics.equilibrium import equilibrium

    if begin is not equilibrium:
        raise NotAnalytic("a function makes the state at the start")
    return initial_state(model, start="rest")  # start at rest, with derivatives of the equilibrium


class Models:
    """Models of the machines of a study; those that differ in numbers only are compiled once.

    Parameters
    ----------
    counts : dict
        Counters, of which "compilations" is increased.

    Attributes
    ----------
    made : int
        Number of models so far, compiled or not.
    """

    def __init__(self, counts: Counts) -> None:
        self._counts = counts
        self.made = 0
        self._variants: Variants | None = None

    def variants(self, mechanism: Mechanism) -> Variants:
        """Return the variants of a mechanism, which is compiled at its first use."""
        if self._variants is None or self._variants.mechanism is not mechanism:
            self._counts["compilations"] += 1
            self._variants = Variants(mechanism)
        return self._variants

    def model(self, mechanism: Mechanism) -> Model:
        """Return the model of a mechanism: a variant of an earlier one, or compiled anew."""
        self.made += 1
        if is_stepping():
            self._counts["compilations"] += 1
            return compile(mechanism)
        if self._variants is not None:
            made = self._variants.like(mechanism)
            if made is not None:
                return made
        return self.variants(mechanism).model

    def with_numbers(self, mechanism: Mechanism, values: Mapping[str, Any]) -> Model:
        """Return the model of a mechanism with other numbers."""
        if is_stepping():
            return self.model(with_numbers(mechanism, values))
        self.made += 1
        variants = self.variants(mechanism)
        before = variants.compilations
        made = variants.with_numbers(values)
        self._counts["compilations"] += variants.compilations - before
        return made


@dataclass(frozen=True, eq=False)
class Numbered:
    """Mechanism with other numbers, which is declared only if an outcome uses it.

    Attributes
    ----------
    of : Mechanism
        The mechanism.
    values : dict
        Its new numbers by address.
    """

    of: Mechanism
    values: Mapping[str, Any]

    @cached_property
    def mechanism(self) -> Mechanism:
        """The mechanism with the new numbers."""
        return with_numbers(self.of, self.values)


@dataclass(frozen=True, eq=False)
class Machine:
    """Mechanism or compiled model with its settings, shared by runs that differ in their inputs.

    Parameters
    ----------
    made : Mechanism, Numbered, Model or Solution
        Object that the user's function returned, or a mechanism with other numbers.
    settings : Settings
        Settings of the runs.
    checks : tuple
        Fatigue checks.
    models : Models
        Models of the study.
    plain : bool
        Whether the model has derivatives that the mechanism lacks.
    """

    made: Any
    settings: Settings
    checks: tuple[Any, ...]
    models: Models
    plain: bool = False

    def with_slope(self, model: Model, checks: tuple[Any, ...]) -> Machine:
        """Return a copy whose model and checks have derivatives; the mechanism has none."""
        made = replace(self, checks=checks, plain=True)
        vars(made)["model"] = model
        return made

    @property
    def mechanism(self) -> Mechanism:
        """Mechanism of the machine."""
        if isinstance(self.made, Numbered):
            return self.made.mechanism
        if not isinstance(self.made, Mechanism):
            raise InputError(
                Problem("study", "a compiled model contains no mechanism; give the mechanism")
            )
        return self.made

    @cached_property
    def model(self) -> Model:
        """Compiled model, driven by the signals of the settings."""
        return drive(self._compiled(), self.settings.inputs, "study")

    def _compiled(self) -> Model:
        if isinstance(self.made, Model):
            return self.made
        if isinstance(self.made, Numbered):
            return self.models.with_numbers(self.made.of, self.made.values)
        return self.models.model(self.mechanism)

    @cached_property
    def repeated(self) -> Repeated:
        """Runner of repeated simulations of the model."""
        if self.settings.t_end is None:
            message = "no end time: give t_end, or simulation: {t_end: ...} in the file"
            raise InputError(Problem("study", message))
        given = self.settings.given(self.model)
        return Repeated(self.model, self.settings.t_end, smooth=True, **given)


@described
class Case:
    """One point of a study, for outcomes that need more than the results of the run.

    Parameters
    ----------
    machine : Machine
        Machine with its caches.
    values : dict
        Values of the parameters, SI.
    inputs : dict
        Values of external inputs.

    Attributes
    ----------
    values : dict
        Values of the parameters, SI.
    reach : float
        Length along the differentiated parameter over which dependent quantities change.
    followed : bool
        Whether `directional` was called since the flag was last cleared.
    whole : bool
        Whether the type of the last function outcome was a whole number.
    """

    def __init__(
        self,
        machine: Machine,
        values: Mapping[str, float],
        inputs: Mapping[str, float],
        reach: float = 1.0,
    ) -> None:
        self._machine = machine
        self.values = dict(values)
        self._inputs = dict(inputs)
        self._kept: dict[object, Any] = {}
        self.reach = reach
        self.followed = False
        self.whole = False

    @property
    def mechanism(self) -> Mechanism:
        """Mechanism at this point.

        Raises
        ------
        NotAnalytic
            If only the model has derivatives, not the mechanism.
        """
        if self._machine.plain:
            raise NotAnalytic("what looks into the mechanism needs its numbers")
        return self._machine.mechanism

    @property
    def model(self) -> Model:
        """Compiled model at this point."""
        return self._machine.model

    @property
    def solver(self) -> Any:
        """Method of the runs that the study or the model file gives; None if there is none."""
        return self._machine.settings.how.get("solver")

    @property
    def checks(self) -> tuple[Any, ...]:
        """Fatigue checks of the model file."""
        return self._machine.checks

    @property
    def runs(self) -> bool:
        """Whether the point has a model to simulate, not only given results."""
        return not isinstance(self._machine.made, Solution)

    def prepare(self) -> Callable[[], Solution]:
        """Prepare the run and return the function that executes it."""
        if not self.runs:
            return lambda: self._machine.made
        repeated = self._machine.repeated
        return lambda: self.cached("run", lambda: repeated.run(self._inputs))

    @property
    def batchable(self) -> bool:
        """Whether the point can run in one batch with points of the same structure."""
        stepped = any(np.iscomplexobj(value) for value in self._inputs.values())
        return self.runs and not stepped and self._machine.repeated.alike is not None

    @property
    def has_run(self) -> bool:
        """Whether the run has been simulated."""
        return "run" in self._kept

    @property
    def run(self) -> Solution:
        """Results of the run."""
        found: Solution = self.prepare()()
        return found

    def run_with(self, samples: Mapping[str, Array]) -> Solution:
        """Return the results of a run whose inputs have samples, held over each output step."""
        settings = self._machine.settings
        assert settings.t_end is not None
        inputs = {**self._inputs, **samples}
        return simulate(self.model, settings.t_end, inputs=inputs, **settings.given(self.model))

    def cached(self, name: object, make: Callable[[], Any]) -> Any:
        """Return a value shared by several outcomes, computed at the first request."""
        if name not in self._kept:
            self._kept[name] = make()
        return self._kept[name]


def run_together(cases: Sequence[Case]) -> None:
    """Run machines of equal structure as one batch; others run when their results are used."""
    waiting = [case for case in cases if not case.has_run and case.batchable]
    runs = [(case._machine.repeated, case._inputs) for case in waiting]
    for case, solution in zip(waiting, run_in_lanes(runs), strict=True):
        if solution is not None:
            case._kept["run"] = solution
