"""Evaluator: outcomes of one point, with a cache of machines and reductions."""

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
from jousto.design.studies.running.finite_differences import WIDTH, difference_models
from jousto.design.studies.running.sources import Memory, Source
from jousto.model.native.ensemble import machines
from jousto.reduction.files.memory_cache import recalling

MACHINES = 16
"""Cache size: machines; the least recently used one is removed first."""

Row = tuple[list[float], str]
"""Outcomes of a point, and the reason if the point failed (else empty)."""


class Evaluator:
    """Computation of the outcomes of points; its caches are not pickled.

    Parameters
    ----------
    source : Source
        Source of the machines.
    parameters : tuple of Parameter
        The columns of the points.
    outcomes : tuple of Outcome
        Requested outcomes.

    Attributes
    ----------
    notes : dict of str to int
        Warnings, with the number of their occurrences.
    alike : bool
        Whether the machine of the nominal values may run in one batch with others.
    """

    def __init__(
        self, source: Source, parameters: tuple[Parameter, ...], outcomes: tuple[Outcome, ...]
    ) -> None:
        self.source = source
        self.parameters = parameters
        self.outcomes = outcomes
        self.made = tuple(source.takes(p.name) for p in parameters)
        self.runs = any(outcome.needs_run for outcome in outcomes)
        self.batchable = False
        self._empty()

    def _empty(self) -> None:
        self.memory = Memory()
        self.notes: dict[str, int] = {}
        self._machines: OrderedDict[tuple[float, ...], Machine] = OrderedDict()
        self._lock = threading.RLock()

    def unbounded(self) -> Evaluator:
        """Return an evaluator without bounds that shares the caches."""
        free = tuple(replace(parameter, bounds=None) for parameter in self.parameters)
        made = Evaluator(self.source, free, self.outcomes)
        made.memory, made.notes, made.batchable = self.memory, self.notes, self.batchable
        return made

    def __getstate__(self) -> dict[str, Any]:
        keep = ("source", "parameters", "outcomes", "made", "runs", "batchable")
        return {name: getattr(self, name) for name in keep}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state)
        self._empty()

    @property
    def counts(self) -> dict[str, int]:
        """Number of reductions, compilations and runs so far."""
        return {"reductions": self.memory.reductions.made, **self.memory.counts}

    def case(self, x: Array) -> Case:
        """Return the machine with the parameter values of a point."""
        values, made = self._split_values(x)
        if not np.iscomplexobj(x):
            return self._case(self._cached_machine(made), values)
        machine = (
            self._make_machine(made) if stepped(*made.values()) else self._cached_machine(made)
        )
        return self._case(machine, values, self._reach(x))

    def _split_values(self, x: Array) -> tuple[dict[str, float], dict[str, float]]:
        """Return the values of a point, and the subset that the machine depends on."""
        values = {p.name: scalar(value) for p, value in zip(self.parameters, x, strict=True)}
        names = [p.name for p, own in zip(self.parameters, self.made, strict=True) if own]
        return values, {name: values[name] for name in names}

    def _case(self, machine: Machine, values: Mapping[str, float], reach: float = 1.0) -> Case:
        pairs = zip(self.parameters, self.made, strict=True)
        inputs = {p.name: values[p.name] for p, own in pairs if not own}
        return Case(machine, values, inputs, reach)

    def _reach(self, x: Array) -> float:
        """Return the length over which results change along the differentiated parameter."""
        j = int(np.argmax(np.imag(x) != 0.0))
        return self.parameters[j].reach(float(np.real(x[j])))

    def _cached_machine(self, made: Mapping[str, float]) -> Machine:
        """Return the machine of real parameter values, from the cache if possible."""
        place = tuple(made.values())
        machine = self._machines.get(place)
        if machine is None:
            machine = self._machines[place] = self._make_machine(made)
            while len(self._machines) > MACHINES:
                self._machines.popitem(last=False)
        self._machines.move_to_end(place)
        return machine

    def _differenced_case(self, x: Array) -> Case:
        """Return the case of a complex point from models of real points on both sides."""
        plain, direction = np.real(x), np.sign(np.imag(x))

        def sides(change: float) -> tuple[Any, ...]:
            machine = self._cached_machine(self._split_values(plain + change * direction)[1])
            return machine.model, machine.checks

        reach = self._reach(x)
        with plainly():
            machine = self._cached_machine(self._split_values(plain)[1])
            model, checks = difference_models(sides, WIDTH * reach)
        return self._case(machine.with_slope(model, checks), self._split_values(x)[0], reach)

    def _stepped(self, x: Array) -> tuple[Case, Exception | None]:
        """Return the case of a complex point, and the error that made differences necessary."""
        try:
            case = self.case(x)
            if case.runs:
                _ = case.model
        except Exception as error:
            try:
                return self._differenced_case(x), error
            except Exception:
                raise error from None
        return case, None

    def _make_machine(self, values: Mapping[str, float]) -> Machine:
        with recalling(self.memory.reductions):
            return self.source.machine(values, self.memory)

    def check(self) -> list[str]:
        """Return the units of the outcomes, from the machine of the nominal values.

        Raises
        ------
        InputError
            With all inputs and outcomes that the machine does not have.
        """
        with self._lock, self.count_warnings():
            case = self.case(np.array([p.value for p in self.parameters]))
            problems: list[Problem] = []
            for parameter, own in zip(self.parameters, self.made, strict=True):
                if not own and (not case.runs or parameter.name not in case.model.inputs):
                    known = case.model.inputs if case.runs else ()
                    message = (
                        "is unused: no argument of the function, parameter of the file "
                        "or input has its name"
                    )
                    tail = suggest(parameter.name, known) if known else ""
                    problems.append(Problem(f"parameter {parameter.name!r}", message + tail))
            for outcome in self.outcomes:
                if message := outcome.check(case):
                    problems.append(Problem(f"outcome {outcome.name!r}", message))
            if problems:
                raise InputError(problems)
            if self.runs and case.runs:
                case.prepare()
                self.batchable = case.batchable
            return [outcome.unit(case) for outcome in self.outcomes]

    @contextmanager
    def count_warnings(self) -> Iterator[None]:
        """Count warnings of jousto in `notes` instead of showing them, in all threads."""
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

    def out_of_bounds(self, x: Array) -> str:
        """Return the message for a value outside its bounds; empty if there is none."""
        for parameter, value in zip(self.parameters, x, strict=True):
            if not np.isfinite(value):
                return f"{parameter.name} is {value}, must be finite"
            if parameter.bounds is not None:
                low, high = parameter.bounds
                # tolerance for the rounding error of evenly spaced samples
                slack = 1e-12 * (high - low)
                if not low - slack <= value <= high + slack:
                    return f"{parameter.name} is {value:.6g}, outside of {low:.6g} to {high:.6g}"
        return ""

    @property
    def width(self) -> int:
        """Number of points that are best computed as one batch."""
        return machines() if self.batchable else 1

    def __call__(self, x: Array) -> Row:
        """Return the outcomes at a point; a failure becomes a reason instead of an exception."""
        return next(iter(self.rows([x])))

    def rows(self, points: Iterable[Array]) -> Iterator[Row]:
        """Yield the rows of some points, each as soon as it is complete.

        In threads only the runs are parallel.
        """
        jobs = [Job(x, self.out_of_bounds(x)) for x in points]
        with self._lock:
            self._for_each_job(jobs, self._prepare)
        if len(jobs) > 1:
            run_together([job.case for job in jobs if job.case is not None and job.run is not None])
        nothing = [float("nan")] * len(self.outcomes)
        # the caller writes each row to disk before the next point may kill the process
        for job in jobs:
            self._for_each_job([job], self._run)
            with self._lock:
                self._for_each_job([job], self._read)
            yield (nothing, job.failed) if job.failed else (job.found, "")

    def _for_each_job(self, jobs: Iterable[Job], do: Callable[[Job], None]) -> None:
        """Apply a function to every job without an error; its exception becomes the job's error."""
        for job in jobs:
            if not job.failed:
                try:
                    do(job)
                except Exception as error:
                    job.failed = reason(error)

    def outcomes_at(self, x: Array, outcomes: tuple[Outcome, ...]) -> list[OutcomeValue]:
        """Return the outcomes at a real or complex point, or the error of each."""
        found: list[OutcomeValue] = []
        why: Exception | None = None
        with self._lock, self.count_warnings(), stepping() if np.iscomplexobj(x) else nullcontext():
            try:
                if np.iscomplexobj(x):
                    case, why = self._stepped(x)
                else:
                    case = self.case(x)
            except Exception as error:
                return [OutcomeValue(error=error)] * len(outcomes)
            for outcome in outcomes:
                case.followed = case.whole = False
                try:
                    value = outcome.value(case)
                    found.append(OutcomeValue(value, case.followed, between=why, whole=case.whole))
                except Exception as error:
                    found.append(OutcomeValue(error=error))
            self.memory.counts["runs"] += case.has_run
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
        self.memory.counts["runs"] += job.case.has_run


@dataclass(frozen=True)
class OutcomeValue:
    """Value of one outcome at a point.

    Parameters
    ----------
    value : float
        NaN without a value.
    followed : bool
        Whether the derivative comes from differences along the derivative of the motion.
    error : Exception or None
        Reason for a missing value.
    between : Exception or None
        Reason why the derivative of the model comes from models on both sides.
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
    """One point during its computation.

    Parameters
    ----------
    x : (np,) array
        The point.
    failed : str
        Reason of the failure; empty without a failure.
    case : Case or None
        Machine at the point.
    run : function or None
        Function that runs the machine.
    found : list of float
        Values of the outcomes.
    """

    x: Array
    failed: str
    case: Case | None = None
    run: Callable[[], Any] | None = None
    found: list[float] = field(default_factory=list)


def reason(error: Exception) -> str:
    """Return the reason of a failure in one line."""
    text = " / ".join(str(error).splitlines())
    return text if isinstance(error, JoustoError) else f"{type(error).__name__}: {text}"
