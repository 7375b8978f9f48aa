"""simulate: step a model through time and stream what it does into a file."""

from __future__ import annotations

import logging
import tempfile
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.engine import Engine, Model
from jousto.engine.native import NOT_FINITE
from jousto.errors import InputError, Problem, Problems, SimulationError, warn
from jousto.simulation.progress import Report, reporter
from jousto.simulation.results import ResultsWriter
from jousto.simulation.solution import Solution
from jousto.simulation.solver import ROS2, SOLVERS, Solver
from jousto.simulation.stability import stability_warning

Record = Callable[[NDArray[np.float64]], None]

logger = logging.getLogger(__name__)

WALL_PER_CALL = 0.1  # s between looks at the clock, the bar and Ctrl-C
BUFFER_BYTES = 4 << 20
ENERGY_LIMIT = 0.05  # share of the exchanged energy that the balance may miss unnoticed


class RunInterrupted(KeyboardInterrupt):
    """Ctrl-C during a run; `solution` holds the results up to then."""

    def __init__(self, message: str, solution: Solution) -> None:
        super().__init__(message)
        self.solution = solution


class RunFailed(SimulationError):
    """A run that could not go on; `solution` holds the results up to then."""

    def __init__(self, message: str, solution: Solution | None, *, time: float, body: str) -> None:
        super().__init__(message, time=time, body=body)
        self.solution = solution


@dataclass(frozen=True)
class Schedule:
    """Steps of a run: `steps` of size `step`, a row every `every` steps."""

    step: float
    steps: int
    every: int


def simulate(
    model: Model,
    t_end: float,
    *,
    solver: Solver | None = None,
    output_step: float | None = None,
    path: str | Path | None = None,
    progress: bool | Report | None = None,
    model_text: str = "",
) -> Solution:
    """Run a model from time 0 to `t_end`.

    The results are written in pieces while the run goes on; the memory it needs does not grow
    with its length.

    Parameters
    ----------
    model : Model
        From `compile`.
    t_end : float
        End of the run, s.
    solver : RK4 or ROS2, optional
        Method and step; None is ``ROS2(step=1e-3)``. The step is shortened, never lengthened, so
        that outputs and the end fall on steps.
    output_step : float, optional
        Time between stored instants, s; None stores every step.
    path : path, optional
        Results file (HDF5), overwritten; None keeps the results in a temporary file that goes
        with the returned object.
    progress : bool or function, optional
        True shows a bar; a function is called about ten times a second with (simulated time,
        wall time) in s.
    model_text : str
        Text of the model file, kept with the results.

    Returns
    -------
    Solution
        The results.

    Raises
    ------
    InputError
        If the input makes no sense or the file cannot be written.
    RunFailed
        If the run diverges or the disk is full; the results up to then are kept.
    RunInterrupted
        On Ctrl-C; the results up to then are kept.

    Warns
    -----
    JoustoWarning
        Before the run if the step is too large for the highest mode, after it if the energy
        balance misses more than 5 %.
    """
    solver = ROS2() if solver is None else solver
    schedule = _schedule(model, t_end, solver, output_step)
    sentence = stability_warning(model, solver, schedule.step)
    if sentence:
        warn(f"simulate {model.name!r}", f"the run will probably diverge: {sentence}")
    engine = Engine(model)
    target = Path(tempfile.mkdtemp(prefix="jousto-")) / "run.h5" if path is None else Path(path)
    attributes = {
        "solver": repr(solver),
        "step": schedule.step,
        "t_end": float(t_end),
        "gravity": model.gravity,
        "evaluations_per_step": solver.evaluations,
    }
    rows = schedule.steps // schedule.every + 1
    writer = ResultsWriter(target, model, rows, attributes, model_text)
    watch = EnergyWatch(model)

    def record(rows: NDArray[np.float64]) -> None:
        writer.append(rows)
        watch.see(rows)

    started = clock.perf_counter()
    ended = "completed"
    failure: tuple[str, str] | None = None
    interrupted = False
    try:
        with reporter(progress, float(t_end)) as report:
            failure = _loop(engine, solver, schedule, record, report)
        if failure:
            ended = f"failed: {failure[0]}"
    except KeyboardInterrupt:
        interrupted = True
        ended = "interrupted"
    except OSError as error:  # the disk is full or gone
        failure = (f"cannot write {target}: {error}; free some space and run again", "")
        ended = "failed: cannot write"
    wall = clock.perf_counter() - started
    reached = float(engine.time[0].real)
    try:
        writer.close(
            ended == "completed",
            {
                "ended": ended,
                "wall_time": wall,
                "real_time_factor": reached / wall if wall > 0 else 0.0,
            },
        )
        solution: Solution | None = Solution(target, temporary=path is None)
    except (OSError, InputError) as error:
        solution = None
        failure = failure or (f"cannot write {target}: {error}; free some space and run again", "")
    if interrupted and solution is not None:
        raise RunInterrupted(
            f"stopped at {reached:g} s; the results up to then are in {target}", solution
        )
    if failure is not None or solution is None:
        message, body = failure or ("interrupted", "")
        raise RunFailed(
            f"the run stopped at {reached:.6g} s: {message}", solution, time=reached, body=body
        )
    watch.judge()
    return solution


def _schedule(model: Any, t_end: float, solver: Any, output_step: float | None) -> Schedule:
    problems = Problems()
    where = "simulate"
    if not isinstance(model, Model):
        kind = type(model).__name__
        hint = (
            "; compile it first: simulate(compile(mechanism), ...)" if kind == "Mechanism" else ""
        )
        problems.add(where, f"model is a {kind}, must be a Model{hint}")
    if not isinstance(solver, SOLVERS):
        known = ", ".join(s.__name__ for s in SOLVERS)
        problems.add(where, f"solver is {solver!r}, must be one of {known}, e.g. ROS2(step=1e-3)")
        problems.raise_if_any()
    problems.positive(where, "t_end", float(t_end), "s")
    if output_step is not None:
        problems.positive(where, "output_step", float(output_step), "s")
    problems.raise_if_any()
    unit = float(t_end) if output_step is None else float(output_step)
    pieces = max(1, int(np.ceil(unit / solver.step * (1.0 - 1e-12))))
    step = unit / pieces
    if abs(step - solver.step) > 1e-9 * solver.step:
        logger.info("step shortened from %g to %g s", solver.step, step)
    if output_step is None:
        return Schedule(step, pieces, 1)
    rows = round(float(t_end) / unit)
    if rows < 1 or abs(rows * unit - t_end) > 1e-9 * t_end:
        raise InputError(
            Problem(
                where,
                f"t_end = {t_end:g} s is not a multiple of output_step = {unit:g} s; "
                f"for example t_end = {max(rows, 1) * unit:g} s fits",
            )
        )
    return Schedule(step, rows * pieces, pieces)


def _loop(
    engine: Engine, solver: Solver, schedule: Schedule, record: Record, report: Report
) -> tuple[str, str] | None:
    """Step to the end in calls of about a tenth of a second; return what went wrong and where."""
    model = engine.model
    alpha, beta = (
        (solver.baumgarte.alpha, solver.baumgarte.beta) if solver.baumgarte else (0.0, 0.0)
    )
    native = engine.native_solver(solver.method, schedule.step, solver.projection, alpha, beta)
    capacity = max(1, min(4096, BUFFER_BYTES // (8 * engine.row_size)))
    rows = np.zeros((capacity, engine.row_size))
    rows[0] = engine.row()
    record(rows[:1])
    started = clock.perf_counter()
    call = 1
    done = 0
    while done < schedule.steps:
        room = (capacity - 1) * schedule.every
        count = min(call, schedule.steps - done, max(room, schedule.every))
        before = clock.perf_counter()
        written = engine.run(native, count, schedule.every, rows)
        now = clock.perf_counter()
        if written < 0:
            kept = engine.steps_done // schedule.every - done // schedule.every
            record(rows[: max(kept, 0)])
            return _cause(model, solver, schedule, engine, -written)
        record(rows[:written])
        done += count
        report(float(engine.time[0].real), now - started)
        spent = max(now - before, 1e-6)
        call = max(1, min(int(count * WALL_PER_CALL / spent), 4 * call))
    return None


def _cause(
    model: Model, solver: Solver, schedule: Schedule, engine: Engine, status: int
) -> tuple[str, str]:
    sentence = stability_warning(model, solver, schedule.step)
    if status != NOT_FINITE and not sentence:
        problem = engine.problem(status)
        return f"{problem} (it was regular at the start: a singular position was reached)", ""
    body = ""
    if status == NOT_FINITE:
        body = model.bodies[engine.error_index].name
    if not sentence:
        sentence = (
            f"the step of {schedule.step:.3g} s may be too large for this motion, try half; or "
            "forces, masses or stiffnesses have the wrong unit"
        )
    what = f"body '{body}'" if body else "the motion"
    return f"{what} diverged; likely cause: {sentence}", body


class EnergyWatch:
    """What the energy balance missed so far, in fixed memory."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._first = 1 + model.nq + model.nv + model.nrow
        self._low = np.full(3, np.inf)
        self._high = np.full(3, -np.inf)
        self._start: float | None = None
        self.missed = 0.0

    def see(self, rows: NDArray[np.float64]) -> None:
        """Look at rows of the engine."""
        if not len(rows):
            return
        terms = rows[:, self._first : self._first + 5]
        balance = terms[:, :3].sum(axis=1) + terms[:, 3] - terms[:, 4]
        if self._start is None:
            self._start = float(balance[0])
        self.missed = max(self.missed, float(np.abs(balance - self._start).max()))
        self._low = np.minimum(self._low, terms[:, :3].min(axis=0))
        self._high = np.maximum(self._high, terms[:, :3].max(axis=0))

    def judge(self) -> None:
        """Warn if the balance misses a noticeable share of the energy exchanged."""
        exchanged = float((self._high - self._low).sum())
        if self.missed > ENERGY_LIMIT * exchanged and self.missed > 1e-9 * self._high[0]:
            warn(
                f"simulate {self._model.name!r}",
                f"the energy balance misses {self.missed:.3g} J of {exchanged:.3g} J exchanged "
                f"({100 * self.missed / max(exchanged, 1e-300):.2g} %); a smaller step is more "
                "accurate",
            )


def describe(solution: Solution) -> dict[str, Any]:
    """Return the facts about a run that are worth printing, by name."""
    residuals = solution.residuals
    return {
        "instants": len(solution),
        "end of the run (s)": float(solution.time[-1]) if len(solution) else 0.0,
        "ended": solution.attributes.get("ended", "still running or killed"),
        "solver": solution.attributes["solver"],
        "wall time (s)": solution.attributes.get("wall_time", float("nan")),
        "real-time factor": solution.attributes.get("real_time_factor", float("nan")),
        "largest position residual": float(residuals.position.max(initial=0.0)),
        "largest velocity residual": float(residuals.velocity.max(initial=0.0)),
        "largest energy error (J)": float(np.abs(solution.energy.error).max(initial=0.0)),
    }
