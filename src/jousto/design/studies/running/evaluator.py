"""Evaluator: the outcomes of one point, with what was made for other points."""

from __future__ import annotations

import threading
import warnings
from collections import OrderedDict
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.complexstep import plainly, scalar, stepped, stepping
from jousto.base.errors import InputError, JoustoError, JoustoWarning, Problem, suggest
from jousto.design.studies.case import Case, Machine, run_together
from jousto.design.studies.outcomes.outcome import Outcome
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.running.finite_differences import WIDTH, between
from jousto.design.studies.running.sources import Memory, Source
from jousto.model.native.ensemble import machines
from jousto.reduction.files.memory_cache import recalling

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
    alike : bool
        Whether the machine of the nominal values may run side by side with others.
    """

    def __init__(
        self, source: Source, parameters: tuple[Parameter, ...], outcomes: tuple[Outcome, ...]
    ) -> None:
        self.source = source
        self.parameters = parameters
        self.outcomes = outcomes
        self.made = tuple(source.takes(p.name) for p in parameters)
        self.runs = any(outcome.needs_run for outcome in outcomes)
        self.alike = False
        self._empty()

    def _empty(self) -> None:
        self.memory = Memory()
        self.notes: dict[str, int] = {}
        self._machines: OrderedDict[tuple[float, ...], Machine] = OrderedDict()
        self._lock = threading.RLock()

    def boundless(self) -> Evaluator:
        """Return one for points beyond the bounds, which shares what is made."""
        free = tuple(replace(parameter, bounds=None) for parameter in self.parameters)
        made = Evaluator(self.source, free, self.outcomes)
        made.memory, made.notes, made.alike = self.memory, self.notes, self.alike
        return made

    def __getstate__(self) -> dict[str, Any]:
        keep = ("source", "parameters", "outcomes", "made", "runs", "alike")
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
        values, made = self._taken(x)
        if not np.iscomplexobj(x):
            return self._case(self._kept(made), values)
        machine = self._made(made) if stepped(*made.values()) else self._kept(made)
        return self._case(machine, values, self._reach(x))

    def _taken(self, x: Array) -> tuple[dict[str, float], dict[str, float]]:
        """Return the values of a point, and those that the machine is made of."""
        values = {p.name: scalar(value) for p, value in zip(self.parameters, x, strict=True)}
        names = [p.name for p, own in zip(self.parameters, self.made, strict=True) if own]
        return values, {name: values[name] for name in names}

    def _case(self, machine: Machine, values: Mapping[str, float], reach: float = 1.0) -> Case:
        pairs = zip(self.parameters, self.made, strict=True)
        inputs = {p.name: values[p.name] for p, own in pairs if not own}
        return Case(machine, values, inputs, reach)

    def _reach(self, x: Array) -> float:
        """Return over which length what depends on the parameter with a derivative changes."""
        j = int(np.argmax(np.imag(x) != 0.0))
        return self.parameters[j].reach(float(np.real(x[j])))

    def _kept(self, made: Mapping[str, float]) -> Machine:
        """Return a machine of plain numbers, made once."""
        place = tuple(made.values())
        machine = self._machines.get(place)
        if machine is None:
            machine = self._machines[place] = self._made(made)
            while len(self._machines) > MACHINES:
                self._machines.popitem(last=False)
        self._machines.move_to_end(place)
        return machine

    def _between(self, x: Array) -> Case:
        """Return the case of a complex point by the models of real ones on both sides."""
        plain, direction = np.real(x), np.sign(np.imag(x))

        def sides(change: float) -> tuple[Any, ...]:
            machine = self._kept(self._taken(plain + change * direction)[1])
            return machine.model, machine.checks

        reach = self._reach(x)
        with plainly():
            machine = self._kept(self._taken(plain)[1])
            model, checks = between(sides, WIDTH * reach)
        return self._case(machine.with_slope(model, checks), self._taken(x)[0], reach)

    def _stepped(self, x: Array) -> tuple[Case, Exception | None]:
        """Return the case of a complex point, and why its model comes from those beside it."""
        try:
            case = self.case(x)
            if case.runs:
                _ = case.model
        except Exception as error:
            try:
                return self._between(x), error
            except Exception:
                raise error from None
        return case, None

    def _made(self, values: Mapping[str, float]) -> Machine:
        with recalling(self.memory.reductions):
            return self.source.machine(values, self.memory)

    def check(self) -> list[str]:
        """Return the units of the outcomes, from the machine of the nominal values.

        Raises
        ------
        InputError
            Everything that does not fit it: inputs and outcomes that it does not know.
        """
        with self._lock, self.noting():
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
                self.alike = case.alike
            return [outcome.unit(case) for outcome in self.outcomes]

    @contextmanager
    def noting(self) -> Iterator[None]:
        """Count our warnings in `notes` meanwhile, in all threads, instead of showing them."""
        with warnings.catch_warnings():
            warnings.simplefilter("always", JoustoWarning)
            show: Callable[..., None] = warnings.showwarning

            def note(message: Warning | str, category: type[Warning], *where: Any) -> None:
                if issubclass(category, JoustoWarning):
                    self.notes[str(message)] = self.notes.get(str(message), 0) + 1
                else:
                    show(message, category, *where)

            warnings.showwarning = note  # type: ignore[assignment]
            yield

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

    @property
    def width(self) -> int:
        """How many points are best worked out at once."""
        return machines() if self.alike else 1

    def __call__(self, x: Array) -> Row:
        """Return the outcomes at a point; what fails is a reason, not an exception."""
        return next(iter(self.rows([x])))

    def rows(self, points: Iterable[Array]) -> Iterator[Row]:
        """Yield the outcomes at some points, each as soon as they are known.

        Of several threads the runs alone go side by side.
        """
        jobs = [Job(x, self.outside(x)) for x in points]
        with self._lock:
            self._each(jobs, self._prepare)
        if len(jobs) > 1:
            run_together([job.case for job in jobs if job.case is not None and job.run is not None])
        nothing = [float("nan")] * len(self.outcomes)
        for job in jobs:  # what is yielded is written down before the next one may kill the process
            self._each([job], self._run)
            with self._lock:
                self._each([job], self._read)
            yield (nothing, job.failed) if job.failed else (job.found, "")

    def _each(self, jobs: Iterable[Job], do: Callable[[Job], None]) -> None:
        """Do something for every job that has not failed; what is raised is why it did."""
        for job in jobs:
            if not job.failed:
                try:
                    do(job)
                except Exception as error:
                    job.failed = reason(error)

    def outcomes_at(self, x: Array, outcomes: tuple[Outcome, ...]) -> list[Found]:
        """Return outcomes at a point, complex ones of a complex point, or why there are none."""
        found: list[Found] = []
        why: Exception | None = None
        with self._lock, self.noting(), stepping() if np.iscomplexobj(x) else nullcontext():
            try:
                if np.iscomplexobj(x):
                    case, why = self._stepped(x)
                else:
                    case = self.case(x)
            except Exception as error:
                return [Found(error=error)] * len(outcomes)
            for outcome in outcomes:
                case.followed = case.whole = False
                try:
                    value = outcome.value(case)
                    found.append(Found(value, case.followed, between=why, whole=case.whole))
                except Exception as error:
                    found.append(Found(error=error))
            self.memory.counts["runs"] += case.ran
        return found

    def _prepare(self, job: Job) -> None:
        job.case = self.case(job.x)
        if self.runs:
            job.run = job.case.prepare()

    def _run(self, job: Job) -> None:
        if job.run is not None:
            job.run()

    def _read(self, job: Job) -> None:
        assert job.case is not None
        job.found = [outcome.value(job.case) for outcome in self.outcomes]
        self.memory.counts["runs"] += job.case.ran


@dataclass(frozen=True)
class Found:
    """What an outcome is at a point.

    Parameters
    ----------
    value : float
        NaN if there is none.
    followed : bool
        Whether its derivative is by differences along that of the motion.
    error : Exception or None
        Why there is no value.
    between : Exception or None
        Why the model has its derivative by models on both sides.
    whole : bool
        Whether a function returned a whole number by its type.
    """

    value: float = float("nan")
    followed: bool = False
    error: Exception | None = None
    between: Exception | None = None
    whole: bool = False


@dataclass
class Job:
    """A point on its way.

    Parameters
    ----------
    x : (np,) array
        The point.
    failed : str
        Why it failed; empty as long as it did not.
    case : Case or None
        Its machine.
    run : function or None
        Runs it.
    found : list of float
        Its outcomes.
    """

    x: Array
    failed: str
    case: Case | None = None
    run: Callable[[], Any] | None = None
    found: list[float] = field(default_factory=list)


def reason(error: Exception) -> str:
    """Return why a point failed, in one line."""
    text = " / ".join(str(error).splitlines())
    return text if isinstance(error, JoustoError) else f"{type(error).__name__}: {text}"
