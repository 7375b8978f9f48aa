"""One point of a study: a machine with given numbers, its model, its run and what follows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.errors import InputError, NotAnalytic, Problem
from jousto.base.object_repr import described
from jousto.mechanism.mechanism import Mechanism
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.model.start_complex_step import has_steps
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.batched_runs import run_in_lanes
from jousto.simulation.running.repeated_runs import Repeated
from jousto.simulation.running.start_state import initial_state

Counts = dict[str, int]


@dataclass(frozen=True)
class Settings:
    """How the runs of a study go: the arguments of `simulate`.

    Parameters
    ----------
    t_end : float or None
        End, s; None if the model says it.
    how : dict
        solver, output_step and state, where they are given; a function of the model as state is
        asked for it, such as `jo.equilibrium`.
    """

    t_end: float | None = None
    how: Mapping[str, Any] = field(default_factory=dict)

    def given(self, model: Model) -> dict[str, Any]:
        """Return the arguments for a model."""
        how = dict(self.how)
        if callable(how.get("state")):
            how["state"] = _begun(how["state"], model)
        return how


def _begun(begin: Callable[[Model], Any], model: Model) -> Any:
    """Return the state that a function of the model says."""
    if not has_steps(model):
        return begin(model)
    from jousto.simulation.statics.equilibrium import equilibrium

    if begin is not equilibrium:
        raise NotAnalytic("a function makes the state at the start")
    return initial_state(model, start="rest")  # with its derivatives


@dataclass(frozen=True, eq=False)
class Machine:
    """A mechanism or a compiled model with what belongs to it, for runs that differ by inputs.

    Parameters
    ----------
    made : Mechanism, Model or Solution
        What the user's function returned.
    settings : Settings
        How it is run.
    checks : tuple
        What is to be checked for fatigue.
    counts : dict
        Where compilations and runs are counted.
    plain : bool
        Whether the mechanism has no derivatives that the model has.
    """

    made: Any
    settings: Settings
    checks: tuple[Any, ...]
    counts: Counts
    plain: bool = False

    def with_slope(self, model: Model, checks: tuple[Any, ...]) -> Machine:
        """Return one whose model and checks have derivatives, the mechanism none."""
        made = replace(self, checks=checks, plain=True)
        vars(made)["model"] = model
        return made

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism."""
        if not isinstance(self.made, Mechanism):
            raise InputError(Problem("study", "a compiled model has no mechanism to look into"))
        return self.made

    @cached_property
    def model(self) -> Model:
        """The compiled model."""
        if isinstance(self.made, Model):
            return self.made
        self.counts["compilations"] += 1
        return compile(self.mechanism)

    @cached_property
    def repeated(self) -> Repeated:
        """What runs it."""
        if self.settings.t_end is None:
            message = "how long to simulate? give t_end, or simulation: {t_end: ...} in the file"
            raise InputError(Problem("study", message))
        return Repeated(self.model, self.settings.t_end, **self.settings.given(self.model))


@described
class Case:
    """One point of a study, for outcomes that need more than the results of a run.

    Parameters
    ----------
    machine : Machine
        With its caches.
    values : dict
        Values of the parameters, SI.
    inputs : dict
        Values of external inputs.

    Attributes
    ----------
    values : dict
        Values of the parameters, SI.
    reach : float
        Over which what depends on the parameter that has a derivative changes.
    followed : bool
        Whether `along` was asked since it was set to False.
    whole : bool
        Whether the last outcome that a function returned was a whole number by its type.
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
        """The mechanism.

        Raises
        ------
        NotAnalytic
            If the model alone has derivatives.
        """
        if self._machine.plain:
            raise NotAnalytic("what looks into the mechanism needs its numbers")
        return self._machine.mechanism

    @property
    def model(self) -> Model:
        """The compiled model."""
        return self._machine.model

    @property
    def checks(self) -> tuple[Any, ...]:
        """What the model file wants checked for fatigue."""
        return self._machine.checks

    @property
    def runs(self) -> bool:
        """Whether there is something to run, not results alone."""
        return not isinstance(self._machine.made, Solution)

    def prepare(self) -> Callable[[], Solution]:
        """Do everything that the run needs; return the function that runs."""
        if not self.runs:
            return lambda: self._machine.made
        repeated = self._machine.repeated
        return lambda: self.once("run", lambda: repeated.run(self._inputs))

    @property
    def alike(self) -> bool:
        """Whether it may run side by side with others of its structure."""
        stepped = any(np.iscomplexobj(value) for value in self._inputs.values())
        return self.runs and not stepped and self._machine.repeated.alike is not None

    @property
    def ran(self) -> bool:
        """Whether it was simulated."""
        return "run" in self._kept

    @property
    def run(self) -> Solution:
        """The results of the run."""
        found: Solution = self.prepare()()
        return found

    def once(self, name: object, make: Callable[[], Any]) -> Any:
        """Return what several outcomes need, made once."""
        if name not in self._kept:
            self._kept[name] = make()
        return self._kept[name]


def run_together(cases: Sequence[Case]) -> None:
    """Run machines of one structure side by side; the others run when their results are wanted."""
    waiting = [case for case in cases if not case.ran and case.alike]
    runs = [(case._machine.repeated, case._inputs) for case in waiting]
    for case, solution in zip(waiting, run_in_lanes(runs), strict=True):
        if solution is not None:
            case._kept["run"] = solution
