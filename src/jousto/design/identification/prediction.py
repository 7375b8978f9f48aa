"""Bench of a record: runs of its machine, and what the sensors show at the measured instants."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.design.identification.bench import machines_of
from jousto.design.identification.experiment import Comparison, Experiment, comparisons
from jousto.design.studies.case import Case, Settings, run_together
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.running.evaluator import Evaluator
from jousto.measurement.gauges.record import record_of
from jousto.mechanism.signals.piecewise import Table
from jousto.model.model import Model
from jousto.model.native.ensemble import machines
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.inputs import drive
from jousto.simulation.state import State
from jousto.simulation.statics.equilibrium import equilibrium

ALIGNED = 1e-6
"""Share of a step within which a measured instant is an instant of the run."""
FINER = 4
"""Instants of the run in a step of the record where instants between them are needed."""


@dataclass(frozen=True, eq=False)
class RecordBench:
    """Machine of an experiment, which is run at any point.

    Parameters
    ----------
    experiment : Experiment
    evaluator : Evaluator
        Machines of the experiment.
    places : (k,) array of int
        Places of the machine's parameters among all unknowns.
    t_end : float
        End of the runs, s.
    how : dict
        Solver and output step.
    held : dict of str to array
        Values of held inputs, one for each output step.
    workers : int
        Runs at the same time.
    """

    experiment: Experiment
    evaluator: Evaluator
    places: Array
    t_end: float
    how: Mapping[str, Any]
    held: Mapping[str, Array]
    workers: int

    @property
    def name(self) -> str:
        """Name for tables and messages."""
        return str(self.experiment.name)

    @property
    def solver(self) -> Any:
        """Method of the runs; None if it is not chosen yet."""
        return self.how.get("solver")

    def compare(self, problems: Problems, run: Solution) -> tuple[Comparison, ...]:
        """Return what is compared, from a run at the start values, and report all problems."""
        return comparisons(problems, self.experiment, dict(record_of(run).units))

    def show(self, run: Solution, comparison: Comparison, shift: float) -> tuple[Array, Array]:
        """Return what a sensor shows in a run at the measured instants, and its rate (n,)."""
        return sensor_values(run, comparison, shift)

    @property
    def steps(self) -> tuple[float, float]:
        """Steps of differences: runs differ by rounding only."""
        return 3e-8, 3e-6

    @property
    def scales(self) -> int:
        """Number of scales that are fitted beside the unknowns."""
        return 0

    def results(self, points: Sequence[Array]) -> list[Any]:
        """Return the runs of points (np,) of all unknowns, or the error of each."""
        found: list[Any] = []
        jobs: list[tuple[int, Case]] = []
        with self.evaluator.count_warnings():
            for theta in points:
                try:
                    case = self.evaluator.case(np.asarray(theta)[self.places])
                    case.prepare()
                    jobs.append((len(found), case))
                    found.append(InputError(Problem("identify", "has not run")))
                except Exception as error:
                    found.append(error)
            if not self.held:
                width = machines()
                for k in range(0, len(jobs), width):
                    run_together([case for _, case in jobs[k : k + width]])
            with ThreadPoolExecutor(self.workers) as pool:
                for (i, _), run in zip(
                    jobs, pool.map(self._run, (c for _, c in jobs)), strict=True
                ):
                    found[i] = run
        self.evaluator.memory.counts["runs"] += len(jobs)
        return found

    def _run(self, case: Case) -> Solution | Exception:
        """Return the run of a machine, or its error."""
        try:
            if self.held:
                return case.run_with(self.held)
            return case.run
        except Exception as error:
            return error

    def with_solver(self, solver: Any) -> RecordBench:
        """Return the bench with another method or step."""
        how = {**self.how, "solver": solver}
        return replace(self, evaluator=self._evaluator(self.t_end, how), how=how)

    def until(self, share: float) -> RecordBench:
        """Return the bench whose runs end at a share of the time."""
        step = self.how["output_step"]
        count = max(round(share * self.t_end / step), 1)
        held = {name: values[:count] for name, values in self.held.items()}
        evaluator = self._evaluator(count * step, self.how)
        return replace(self, evaluator=evaluator, t_end=count * step, held=held)

    def _evaluator(self, t_end: float, how: Mapping[str, Any]) -> Evaluator:
        """Return the evaluator of runs with other settings; it shares the compiled models."""
        source: Any = self.evaluator.source
        settings = Settings(t_end, how, source.settings.inputs)
        made = Evaluator(replace(source, settings=settings), self.evaluator.parameters, ())
        made.memory, made.notes = self.evaluator.memory, self.evaluator.notes
        return made


@dataclass(frozen=True)
class AtRest:
    """State of a machine: its position of rest under some values of its inputs.

    Parameters
    ----------
    inputs : dict of str to float
    """

    inputs: dict[str, float]

    def __call__(self, model: Model) -> State:
        """Return the state of a model."""
        return equilibrium(drive(model, self.inputs, "rest"))


def make_bench(
    problems: Problems,
    experiment: Experiment,
    model: Any,
    parameters: Sequence[Parameter],
    solver: Any,
    workers: int,
) -> RecordBench | None:
    """Return the bench of an experiment; None, with a problem, if there is none.

    Parameters
    ----------
    problems : Problems
    experiment : Experiment
    model : object
        Machine of all experiments that have none of their own.
    parameters : sequence of Parameter
        Unknowns of the model.
    solver : Solver or None
    workers : int
    """
    record = experiment.record
    shifted = any(value for value in experiment.shift.values())
    step, t_end = _output_step(record.time, shifted)
    how: dict[str, Any] = {"output_step": step}
    if solver is not None:
        how["solver"] = solver
    if experiment.state is not None:
        how["state"] = experiment.state
    if experiment.rest is not None:
        how["state"] = AtRest(dict(experiment.rest))
    made = machines_of(problems, experiment, model, parameters, Settings(t_end, how, {}))
    if made is None:
        return None
    known = tuple(made.start.inputs)
    try:
        signals, held = _drives(problems, experiment, known, round(t_end / step), step)
    except InputError as error:
        problems.found += error.problems
        return None
    for parameter in made.parameters:
        if parameter.name in signals or parameter.name in held:
            message = f"is driven by a channel of {experiment.where}, too"
            problems.add(f"parameter {parameter.name!r}", message)
    source: Any = made.source
    driven = replace(source, settings=Settings(t_end, how, signals))
    evaluator = Evaluator(driven, made.parameters, ())
    return RecordBench(experiment, evaluator, made.places, t_end, how, held, workers)


def _drives(
    problems: Problems, experiment: Experiment, known: Sequence[str], steps: int, step: float
) -> tuple[dict[str, Table], dict[str, Array]]:
    """Return the signals of driven inputs, and the values of held ones for each output step."""
    record, given = experiment.record, experiment.inputs
    if given is None:
        given = {name: name for name in known if name in record}
    signals: dict[str, Table] = {}
    held: dict[str, Array] = {}
    for name, channel in given.items():
        if name not in known:
            problems.add(experiment.where, f"inputs: no input {name!r}{suggest(name, known)}")
            continue
        good = np.isfinite(record[channel])
        time, values = record.time[good], record[channel][good]
        if name in experiment.held:
            starts = step * (np.arange(steps) + ALIGNED)
            held[name] = values[np.maximum(np.searchsorted(time, starts, "right") - 1, 0)]
        else:
            signals[name] = Table(time, values)
    for name in experiment.held:
        if name not in given:
            problems.add(experiment.where, f"held: no input {name!r}{suggest(name, given)}")
    return signals, held


def _output_step(time: Array, shifted: bool) -> tuple[float, float]:
    """Return the output step and the end of the runs of a record, s.

    The instants of an even record are instants of the run if the first is a multiple of the step.
    """
    step = float(np.median(np.diff(time)))
    count = time / step
    even = bool(np.all(np.abs(count - np.rint(count)) < 0.01))
    if even:
        # the mean step of the whole record has less rounding than one difference
        step = float(time[-1] / np.rint(count[-1]))
        even = bool(np.all(np.abs(time / step - np.rint(time / step)) < ALIGNED * len(time)))
    if not even or shifted:
        step /= FINER
    return step, step * math.ceil(time[-1] / step - ALIGNED)


def sensor_values(run: Solution, comparison: Comparison, shift: float) -> tuple[Array, Array]:
    """Return what a sensor shows at the measured instants less a shift, and its rate (n,).

    Values outside the run are nan.
    """
    wanted = comparison.time - shift
    time, values = np.asarray(run.time), np.asarray(run[comparison.sensor]).reshape(-1)
    step = (time[-1] - time[0]) / (len(time) - 1)
    place = (wanted - time[0]) / step
    near = np.rint(place).astype(int)
    inside = (near >= 0) & (near < len(time))
    sought = isinstance(comparison.shift, Parameter)
    if not sought and np.all(inside) and np.all(np.abs(place - near) < ALIGNED * len(time)):
        return values[near], np.zeros(len(near))
    from scipy.interpolate import CubicSpline

    curve = CubicSpline(time, values)
    outside = (wanted < time[0] - ALIGNED * step) | (wanted > time[-1] + ALIGNED * step)
    shown, rate = curve(wanted), curve(wanted, 1)
    shown[outside] = np.nan
    return shown, rate
