"""Study: a model as a function from parameters to outcomes, at one point or many."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, count
from jousto.base.files import check_file
from jousto.base.object_repr import described
from jousto.base.progress import bars
from jousto.design.studies.case import Case, Settings
from jousto.design.studies.outcomes.outcome import Outcome
from jousto.design.studies.outcomes.outcomes import read_outcomes
from jousto.design.studies.parameters.parameter import Parameter
from jousto.design.studies.parameters.samples import grid, latin_hypercube, read_samples
from jousto.design.studies.running.content_hash import key_of
from jousto.design.studies.running.evaluator import Evaluator, Row
from jousto.design.studies.running.guard import lock_exclusively
from jousto.design.studies.running.journal import Journal, check_same
from jousto.design.studies.running.parallel import run_points
from jousto.design.studies.running.sources import choose_parameters, source_of
from jousto.design.studies.table import StudyTable, check_suffix, read_study

Report = Callable[[int, int], None]
Samples = ArrayLike | Mapping[str, Any] | str | Path | int
LINES = ".jsonl"
Point = tuple[float, ...]
MOST_KNOWN = 100_000
"""Cache size: rows of points beyond the bounds; the oldest is removed first."""


@described
class Study:
    """A model as a function from parameters (n, np) to outcomes (n, no); see `study`.

    ``study(X)`` returns the outcomes, NaN at failed points; ``study.run(X)`` is a `StudyTable`.
    Intermediate results are reused between points: reductions by the content of part, method and
    options, parts of a model file by their entry, compiled models by the parameter values that they
    depend on; a change of external inputs needs only a new run.

    Attributes
    ----------
    parameters : tuple of Parameter
        The columns of X.
    outcomes : tuple of str
        Names of the outcomes.
    units : tuple of str
        SI units of the outcomes.
    table : StudyTable or None
        Table of the last ``run``.
    """

    def __init__(self, evaluator: Evaluator) -> None:
        self._evaluator = evaluator
        self.parameters = evaluator.parameters
        self.outcomes = tuple(outcome.name for outcome in evaluator.outcomes)
        self.units = tuple(evaluator.check())
        self.table: StudyTable | None = None
        self._made_of: dict[str, Any] | None = None
        self._free: Evaluator | None = None
        self._known: dict[Point, Row] = {}

    def _facts(self) -> str:
        names = ", ".join(parameter.name for parameter in self.parameters)
        return f"{', '.join(self.outcomes)} of {names}"

    @property
    def nominal(self) -> Array:
        """Nominal values of the parameters (np,)."""
        return np.array([parameter.value for parameter in self.parameters])

    @property
    def counts(self) -> dict[str, int]:
        """Number of reductions, compilations and runs so far."""
        return self._evaluator.counts

    def about(self, number: int) -> Outcome:
        """Return the description of an outcome from its index."""
        return self._evaluator.outcomes[number]

    def point(self, x: ArrayLike | None = None) -> Array:
        """Return one point (np,); the nominal values if none is given.

        Raises
        ------
        InputError
            If `x` is not an array with one number for each parameter.
        """
        if x is None:
            return self.nominal
        problems = Problems()
        names = ", ".join(parameter.name for parameter in self.parameters)
        point = problems.array("point", names, x, (len(self.parameters),))
        problems.raise_if_any()
        return np.array(point, dtype=float)

    @explained
    def case(self, x: ArrayLike | None = None) -> Case:
        """Return the machine at a point, with its ``mechanism``, ``model`` and ``run``.

        Parameters
        ----------
        x : (np,) array, optional
            The point; by default the nominal values.
        """
        return self._evaluator.case(self.point(x))

    def __call__(self, x: ArrayLike) -> Array:
        """Return the outcomes (n, no) of points (n, np), or (no,) of one point (np,)."""
        points = self._points(x)
        with self._evaluator.count_warnings():
            size = self._evaluator.width
            groups = [points[k : k + size] for k in range(0, len(points), size)]
            rows = [row for group in groups for row, _ in self._evaluator.rows(group)]
            found = np.array(rows, dtype=float)
        return found[0] if np.ndim(x) < 2 else found.reshape(len(points), len(self.outcomes))

    def _points(self, x: Any) -> Array:
        """Return samples as points (n, np)."""
        if isinstance(x, str | Path):
            return read_samples(x, self.parameters)
        if isinstance(x, Mapping):
            return grid(self.parameters, x)
        if isinstance(x, int) and not isinstance(x, bool):
            return latin_hypercube(self.parameters, x)
        np_ = len(self.parameters)
        try:
            points = np.atleast_2d(np.asarray(x, dtype=float))
            if points.ndim != 2 or points.shape[1] != np_:
                raise ValueError
        except (TypeError, ValueError):
            names = ", ".join(p.name for p in self.parameters)
            found = f"have shape {np.shape(x)}" if not isinstance(x, str) else f"are {x!r}"
            message = f"{found}, must be (n, {np_}): {names}"
            raise InputError(Problem("samples", message)) from None
        return points

    def rows(self, x: ArrayLike, *, workers: Any = 1, how: str = "threads") -> list[Row]:
        """Return the outcomes of points, also beyond the bounds, each computed only once.

        Parameters
        ----------
        x : array (n, np)
            The points.
        workers, how
            As in `run`.

        Returns
        -------
        list of (list of float, str)
            Outcomes of each point, and the reason of a failure; empty without a failure.
        """
        points = self._points(x).copy()
        for k, parameter in enumerate(self.parameters):
            if parameter.name in self._evaluator.source.unused:
                points[:, k] = parameter.value
        keys: list[Point] = [tuple(point.tolist()) for point in points]
        self._free = self._free or self._evaluator.unbounded()
        todo = [(i, key) for i, key in enumerate(dict.fromkeys(keys)) if key not in self._known]
        waiting = dict(todo)
        found = {key: self._known[key] for key in keys if key in self._known}
        with self._evaluator.count_warnings():
            for i, row in run_points(self._free, todo, None, workers, how):
                found[waiting[i]] = row
        self._known |= found
        while len(self._known) > MOST_KNOWN:
            del self._known[next(iter(self._known))]
        return [found[key] for key in keys]

    @explained
    def run(
        self,
        samples: Samples,
        *,
        workers: Any = 1,
        how: str = "threads",
        path: str | Path | None = None,
        retry: bool = False,
        progress: bool | Report | None = None,
    ) -> StudyTable:
        """Compute many points and return their table.

        Parameters
        ----------
        samples : array (n, np), dict, path or int
            The points: an array, a dictionary for `grid`, the path of a CSV file, or the number of
            points of a Latin hypercube.
        workers : int, "dask" or Client
            Number of parallel points; "dask" for a cluster on this machine, or a Client of another
            Dask cluster.
        how : {"threads", "processes", "dask"}
            Threads share cached results, and only the engine runs in parallel in them; in processes
            Python code runs in parallel too, and the functions of the study must be importable.
        path : path, optional
            File of the table (.h5, .csv, .parquet). Each finished row is written to a file beside
            it, ``NAME.jsonl``, from which a killed study continues. A finished .h5 can be continued
            too. A file of another study raises an error; functions are compared by their source and
            captured values, not by the globals of their module.
        retry : bool
            Whether points that failed before are computed again.
        progress : bool or function, optional
            True shows a bar; a function is called with (points done, points).

        Returns
        -------
        StudyTable
            Points in the given order; failed points with the reason.

        Raises
        ------
        InputError
            If samples, workers or files are invalid.
        """
        points = self._points(samples)
        self._about()  # hash the study before functions change their captured values
        keys = [tuple(point.tolist()) for point in points]
        target = None if path is None else Path(path)
        lines = None if target is None else self._journal_path(target)
        with nullcontext() if lines is None else lock_exclusively(lines):
            rows = self._compute_rows(keys, target, lines, (workers, how, retry, progress))
            self.table = self._table(points, [rows[x] for x in keys])
            if target is not None and lines is not None and target.suffix != LINES:
                self.table.save(target)
                if target.suffix in (".h5", ".hdf5"):
                    lines.unlink(missing_ok=True)
        return self.table

    def _compute_rows(
        self,
        keys: Sequence[Point],
        target: Path | None,
        lines: Path | None,
        given: tuple[Any, str, bool, Any],
    ) -> dict[Point, Row]:
        """Return the rows of points: those of the journal and newly computed ones."""
        workers, how, retry, progress = given
        journal, rows = self._resumed(target, lines)
        if retry:
            rows = {x: row for x, row in rows.items() if not row[1]}
        todo = [(i, x) for i, x in enumerate(dict.fromkeys(keys)) if x not in rows]
        waiting = dict(todo)
        with reporter(progress, len(keys)) as report, self._evaluator.count_warnings():
            done = len(keys) - len(todo)
            report(done, len(keys))
            for i, row in run_points(self._evaluator, todo, journal, workers, how):
                rows[waiting[i]] = row
                done += 1
                report(done, len(keys))
        return rows

    def _table(self, points: Array, rows: Sequence[Row]) -> StudyTable:
        names = tuple(parameter.name for parameter in self.parameters)
        units = {p.name: p.unit for p in self.parameters}
        units |= dict(zip(self.outcomes, self.units, strict=True))
        return StudyTable(
            names,
            self.outcomes,
            points,
            np.array([y for y, _ in rows], dtype=float).reshape(len(points), len(self.outcomes)),
            tuple(reason for _, reason in rows),
            units,
            dict(self._evaluator.notes),
            self._about(),
        )

    def _about(self) -> dict[str, Any]:
        """Return the identity of the study, hashed at the first call."""
        if self._made_of is None:
            source: Any = self._evaluator.source
            how = {key: key_of(value) for key, value in source.settings.how.items()}
            signals = {key: key_of(value) for key, value in source.settings.inputs.items()}
            driven = {"inputs": signals} if signals else {}
            self._made_of = {
                "parameters": [parameter.label for parameter in self.parameters],
                "outcomes": {own.name: key_of(own) for own in self._evaluator.outcomes},
                "model": source.key,
                "run": {"t_end": source.settings.t_end, **how, **driven},
            }
        return self._made_of

    def _journal_path(self, target: Path) -> Path:
        """Return the path of a table's journal after a check that both files can be written."""
        if target.suffix == LINES:
            check_file(target)
            return target
        check_suffix(target)
        lines = target.with_name(target.name + LINES)
        check_file(lines)
        return lines

    def _resumed(
        self, target: Path | None, lines: Path | None
    ) -> tuple[Journal | None, dict[Point, Row]]:
        """Return the journal of a table's file with its completed rows."""
        if target is None or lines is None:
            return None, {}
        about = self._about()
        rows: dict[Point, Row] = {}
        if target.suffix in (".h5", ".hdf5") and target.exists():
            known = read_study(target)
            check_same(target, known.about, about)
            places = map(tuple, known.x.tolist())
            found = zip(known.y.tolist(), known.reasons, strict=True)
            rows = dict(zip(places, found, strict=True))
        journal = Journal(lines, about)
        return journal, rows | journal.rows


@contextmanager
def reporter(progress: bool | Report | None, total: int) -> Iterator[Report]:
    """Yield a progress function of completed and total points: bar, callback, or no output."""
    if callable(progress):
        yield progress
        return
    if not progress:
        yield lambda done, total: None
        return
    with bars() as bar:
        task = bar.add_task(f"study of {count(total, 'point')}", total=total)
        yield lambda done, total: bar.update(task, completed=done, total=total)


@explained
def study(
    model: Any,
    parameters: Sequence[Parameter | str] | Parameter | str | None = None,
    outcomes: Any = (),
    samples: Samples | None = None,
    *,
    t_end: float | None = None,
    solver: Any = None,
    output_step: float | None = None,
    state: Any = None,
    inputs: Mapping[str, Any] | None = None,
    **run: Any,
) -> Study:
    """Return a model as a function of its parameters; with samples, the table of outcomes.

    Parameters
    ----------
    model : callable, ModelFile, Mechanism or Model
        A function of parameters that returns a `Mechanism`, a `Model` or a `Solution`; a file from
        `read_model` with ``parameters``; or a machine whose external inputs (`Input`) are the
        parameters. Parameters that are not arguments of the function are inputs too.
    parameters : sequence of Parameter or str, optional
        Parameters to vary; for a file also names of its parameters, by default all of them.
    outcomes : str, callable, Outcome, sequence or dict
        Outcomes to compute: ``"max(tip.y)"`` (also min, peak, range, rms, mean, first, last),
        ``"mass"``, ``"mass(arm)"``, ``"frequency(1)"``, ``"stress(arm)"`` at its hot spot,
        ``"damage(arm)"``, ``"life(arm)"``, ``"reaction(pivot)"``, or a function of the `Solution`.
    samples : array (n, np), dict, path or int, optional
        Points to compute immediately, see `Study.run`; the table is ``study.table``.
    t_end, solver, output_step : optional
        Settings as in `simulate`; they take precedence over those of the file.
    state : State or callable, optional
        Initial state of the runs, or a function of the model that returns it: `jo.equilibrium`.
    inputs : dict, optional
        Signals of time, such as `Table`, or numbers of external inputs, the same in all runs.
    **run
        Arguments of `Study.run`: workers, how, path, retry, progress.

    Returns
    -------
    Study
        The function.

    Raises
    ------
    InputError
        With all problems of parameters, outcomes and inputs for the nominal machine.

    Examples
    --------
    >>> import jousto as jo
    >>> def pendulum(length):
    ...     bob = jo.RigidBody("bob", 1.0, (1e-9, 1e-9, 1e-9), center=(length, 0, 0))
    ...     pivot = jo.Revolute("pivot", jo.ground["origin"], bob["origin"])
    ...     place = jo.PositionSensor("bob", bob.at((length, 0, 0)))
    ...     return jo.Mechanism(bob, pivot, jo.Gravity((0, -9.81, 0)), place)
    >>> found = study(pendulum, jo.Parameter("length", 1.0, unit="m"), "range(bob.x)", t_end=1.5)
    >>> found([[0.5], [0.6]]).round(3)
    array([[1. ],
           [1.2]])
    """
    how = {"solver": solver, "output_step": output_step, "state": state}
    given = {key: value for key, value in how.items() if value is not None}
    source = source_of(model, Settings(t_end, given, inputs or {}))
    checked = Problems()
    if t_end is not None:
        checked.positive("study", "t_end", t_end, "s")
    problems: list[Problem] = checked.found
    chosen: tuple[Parameter, ...] = ()
    wanted: tuple[Outcome, ...] = ()
    try:
        chosen = choose_parameters(source, parameters)
    except InputError as error:
        problems += error.problems
    try:
        wanted = read_outcomes(outcomes)
    except InputError as error:
        problems += error.problems
    names = {parameter.name for parameter in chosen}
    for name in sorted(names.intersection(inputs or ())):
        message = "is one of the inputs, too; leave it out of the parameters or of the inputs"
        problems.append(Problem(f"parameter {name!r}", message))
    for outcome in wanted:
        if outcome.name in names:
            message = f"is the name of a parameter, too; name it: 'my {outcome.name} = ...'"
            problems.append(Problem(f"outcome {outcome.name!r}", message))
    if problems:
        raise InputError(problems)
    made = Study(Evaluator(source, chosen, wanted))
    if samples is not None:
        made.run(samples, **run)
    elif run:
        raise InputError(Problem("study", f"{', '.join(run)} without samples to compute"))
    return made
