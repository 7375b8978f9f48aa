"""Evaluator: the outcomes of one point, with what was made for other points."""

from __future__ import annotations

import threading
import warnings
from collections import OrderedDict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, JoustoError, JoustoWarning, Problem, suggest
from jousto.design.studies.case import Case, Machine
from jousto.design.studies.outcomes import Outcome
from jousto.design.studies.parameter import Parameter
from jousto.design.studies.sources import Memory, Source
from jousto.reduction.files.recalled import recalling

MACHINES = 16
"""Machines that are kept, the one used last goes last."""

Row = tuple[list[float], str]
"""Outcomes, and why the point failed; empty if it did not."""


class Evaluator:
    """Works out the outcomes of points; can be pickled, without what it keeps.

    Parameters
    ----------
    source : Source
        Makes the machines.
    parameters : tuple of Parameter
        The columns of the points.
    outcomes : tuple of Outcome
        What is wanted.

    Attributes
    ----------
    notes : dict of str to int
        What was warned of, and how often.
    alone : bool
        Whether no other thread asks as well.
    """

    def __init__(
        self, source: Source, parameters: tuple[Parameter, ...], outcomes: tuple[Outcome, ...]
    ) -> None:
        self.source = source
        self.parameters = parameters
        self.outcomes = outcomes
        self.made = tuple(source.takes(p.name) for p in parameters)
        self.runs = any(outcome.needs_run for outcome in outcomes)
        self._empty()

    def _empty(self) -> None:
        self.memory = Memory()
        self.notes: dict[str, int] = {}
        self.alone = True
        self._machines: OrderedDict[tuple[float, ...], Machine] = OrderedDict()
        self._lock = threading.RLock()

    def __getstate__(self) -> dict[str, Any]:
        keep = ("source", "parameters", "outcomes", "made", "runs")
        return {name: getattr(self, name) for name in keep}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._empty()

    @property
    def counts(self) -> dict[str, int]:
        """How many reductions, compilations and runs were done."""
        return {"reductions": self.memory.reductions.made, **self.memory.counts}

    def case(self, x: Array) -> Case:
        """Return the machine with the values of a point."""
        values = {p.name: float(value) for p, value in zip(self.parameters, x, strict=True)}
        made = {
            p.name: values[p.name] for p, own in zip(self.parameters, self.made, strict=True) if own
        }
        place = tuple(made.values())
        machine = self._machines.get(place)
        if machine is None:
            with recalling(self.memory.reductions):
                machine = self.source.machine(made, self.memory)
            self._machines[place] = machine
            while len(self._machines) > MACHINES:
                self._machines.popitem(last=False)
        self._machines.move_to_end(place)
        return Case(machine, values, {n: v for n, v in values.items() if n not in made})

    def check(self) -> list[str]:
        """Return the units of the outcomes, from the machine of the nominal values.

        Raises
        ------
        InputError
            Everything that does not fit it: inputs and outcomes that it does not know.
        """
        with self._lock, self._noting():
            case = self.case(np.array([p.value for p in self.parameters]))
            problems: list[Problem] = []
            for parameter, own in zip(self.parameters, self.made, strict=True):
                if not own and (not case.runs or parameter.name not in case.model.inputs):
                    known = case.model.inputs if case.runs else ()
                    message = "nothing takes it: no argument, no parameter of the file, no input"
                    tail = suggest(parameter.name, known) if known else ""
                    problems.append(Problem(f"parameter {parameter.name!r}", message + tail))
            for outcome in self.outcomes:
                if message := outcome.check(case):
                    problems.append(Problem(f"outcome {outcome.name!r}", message))
            if problems:
                raise InputError(problems)
            if self.runs and case.runs:
                case.prepare()
            return [outcome.unit(case) for outcome in self.outcomes]

    @contextmanager
    def _noting(self) -> Iterator[None]:
        """Keep warnings instead of showing them once for each point."""
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            yield
        for item in caught:
            if issubclass(item.category, JoustoWarning):
                text = str(item.message)
                self.notes[text] = self.notes.get(text, 0) + 1
            else:
                warnings.warn_explicit(item.message, item.category, item.filename, item.lineno)

    def outside(self, x: Array) -> str:
        """Return which value is outside of its bounds."""
        for parameter, value in zip(self.parameters, x, strict=True):
            if not np.isfinite(value):
                return f"{parameter.name} is {value}, must be finite"
            if parameter.bounds is not None:
                low, high = parameter.bounds
                slack = 1e-12 * (high - low)  # round-off of whoever spread the points
                if not low - slack <= value <= high + slack:
                    return f"{parameter.name} is {value:.6g}, outside of {low:.6g} to {high:.6g}"
        return ""

    def __call__(self, x: Array) -> Row:
        """Return the outcomes at a point; what fails is a reason, not an exception."""
        nothing = [float("nan")] * len(self.outcomes)
        if outside := self.outside(x):
            return nothing, outside
        try:
            if self.alone:
                with self._noting():
                    return self._evaluate(x), ""
            return self._shared(x), ""
        except Exception as error:
            return nothing, reason(error)

    def _evaluate(self, x: Array) -> list[float]:
        case = self.case(x)
        found = [outcome.value(case) for outcome in self.outcomes]
        self.memory.counts["runs"] += case.ran
        return found

    def _shared(self, x: Array) -> list[float]:
        """Do the same while other threads do: only the engine works beside them."""
        go: Callable[[], Any] | None = None
        with self._lock, self._noting():
            case = self.case(x)
            if self.runs:
                go = case.prepare()
        if go is not None:
            go()
        with self._lock, self._noting():
            found = [outcome.value(case) for outcome in self.outcomes]
            self.memory.counts["runs"] += case.ran
            return found


def reason(error: Exception) -> str:
    """Return why a point failed, in one line."""
    text = " / ".join(str(error).splitlines())
    return text if isinstance(error, JoustoError) else f"{type(error).__name__}: {text}"
