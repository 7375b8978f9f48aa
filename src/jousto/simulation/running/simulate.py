"""simulate: run a model through time and return the results."""

from __future__ import annotations

import errno
import logging
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.errors import JoustoError, SimulationError, warn
from jousto.certificate.load_warnings import warn_loads
from jousto.model.model import Model
from jousto.model.native.header import named
from jousto.model.native.native import Engine
from jousto.model.overlaps import refuse_deep
from jousto.model.rank.redundancy import is_drive, repeated_rows
from jousto.model.scales import largest_speed
from jousto.simulation.check_motors import motor_turns
from jousto.simulation.check_openings import opening_facts
from jousto.simulation.cosimulation.coupling import Coupling
from jousto.simulation.cosimulation.fmu_process import FmuFailed
from jousto.simulation.cosimulation.requirements import check_coupling, check_trust
from jousto.simulation.progress import Report, reporter
from jousto.simulation.results.events import Chronicle
from jousto.simulation.results.memory import Keeper
from jousto.simulation.results.solution import Solution
from jousto.simulation.results.writer import EVENTS
from jousto.simulation.running.contact_checks import check_contacts, contact_facts
from jousto.simulation.running.cosimulation_loop import Coupled
from jousto.simulation.running.inputs import Feed, InputFailed, connect
from jousto.simulation.running.run_checks import Contradiction, RunWatch
from jousto.simulation.running.start_state import initial_state
from jousto.simulation.solvers.adaptive import LONGEST, follow, too_many_steps
from jousto.simulation.solvers.base import Solver, prepared, solver_text
from jousto.simulation.solvers.beam_checks import warn_bent
from jousto.simulation.solvers.bounded_work import check_bounded, deferred_warning
from jousto.simulation.solvers.default_solver import choose
from jousto.simulation.solvers.schedule import Schedule, cautions, schedule
from jousto.simulation.solvers.stability import stability_warning
from jousto.simulation.state import State, put

log = logging.getLogger(__name__)

Record = Callable[[NDArray[np.float64]], None]

WALL_PER_CALL = 0.1  # wall time of a call of the engine, s; progress and Ctrl-C act between calls
BUFFER_BYTES = 4 << 20
JOLT = (
    1e-6  # velocity residual of a joint over the speeds of the machine, above which it is warned of
)
INSTANTS = 17  # sampling instants of a run for the largest speed of its drives
DRIFT = 1e-10  # displacement by a residual over the size of the mechanism that counts as rounding
LEAP = 1e3  # displacement in a step over the size of the mechanism, above which a run has diverged


class RunInterrupted(KeyboardInterrupt):
    """Ctrl-C during a run; `solution` contains the results up to that instant."""

    def __init__(self, message: str, solution: Solution) -> None:
        super().__init__(message)
        self.solution = solution

    __reduce__ = JoustoError.__reduce__


class RunFailed(SimulationError):
    """Run that could not continue; `solution` contains the results up to that instant."""

    def __init__(self, message: str, solution: Solution | None, *, time: float, body: str) -> None:
        super().__init__(message, time=time, body=body)
        self.solution = solution


@dataclass(frozen=True)
class Ending:
    """Early end of a run: cause as a sentence, body concerned, and whether it is a failure."""

    sentence: str
    body: str = ""
    failed: bool = True


@explained
def simulate(
    model: Model,
    t_end: float,
    *,
    solver: Solver | None = None,
    output_step: float | None = None,
    path: str | Path | None = None,
    progress: bool | Report | None = None,
    model_text: str = "",
    state: State | None = None,
    inputs: Mapping[str, Any] | None = None,
) -> Solution:
    """Return the results of a run of a model to time `t_end`, from 0 or the time of a state.

    With a `path` the results are written in pieces during the run and remain if the process is
    killed. Without a path they stay in memory up to 256 MB; longer runs write them into a
    temporary file, so that the memory does not grow with the length of the run.

    Parameters
    ----------
    model : Model
        From `compile`.
    t_end : float
        End of the run, s.
    solver : Solver, optional
        Method and step. None chooses them: ``ROS2(step=1e-3)``, with a shorter step for steep
        friction and dampers and for impacts on stops; ``GeneralizedAlpha(step=1e-3)`` for exact
        beams and machines too stiff for ROS2.
        ``run.attributes["solver"]`` and ``["chosen"]`` contain the choice and its reason. A fixed
        step is shortened, never lengthened, so that outputs and the end fall on steps.
    output_step : float, optional
        Time between stored instants, s; None stores every step, or the `output` of an adaptive
        solver.
    path : path, optional
        Results file (HDF5), overwritten; None keeps the results with the returned object, whose
        ``save(path)`` writes them.
    progress : bool or function, optional
        True shows a bar; a function is called about ten times a second with (simulated time,
        wall time) in s.
    model_text : str
        Text of the model file, kept with the results.
    state : State, optional
        Initial state, with its time: from `equilibrium`, or ``run.state()`` to continue a run.
        None is the `start` of the mechanism, or its initial state, at time 0.
    inputs : dict, optional
        External inputs by name. A Signal is evaluated exactly, as a signal of the model is; a
        number is constant; a function of time, s, is evaluated at the start of every step and its
        value is constant during the step; an array has one constant value for each interval
        between outputs. Inputs that are not given keep their values.

    Returns
    -------
    Solution
        The results. An event with ``stop=True`` ends a run early; ``run.attributes["ended"]``
        contains its name and time.

    Raises
    ------
    InputError
        If an argument is invalid or the file cannot be written.
    RunFailed
        If the run diverges or the disk is full; `solution` of the error has the results so far.
    RunInterrupted
        On Ctrl-C; `solution` of the error has the results so far.

    Warns
    -----
    JoustoWarning
        Before the run if the step is too large for the highest mode, the velocities of the state
        violate the joints or drives, or the modes of a body represent a load badly; after the run
        if the error of the energy balance exceeds 5 %.
    """
    state = initial_state(model, state)
    start, reason = 0.0 if state is None else state.time, ""
    if solver is None:
        solver, reason = choose(model, t_end, output_step, start)
        log.info("%s: %r, %s", model.name, solver, reason)
    plan = schedule(model, t_end, solver, output_step, start)
    check_bounded(model, solver)
    check_trust(model)
    check_coupling(model, solver, plan, state, inputs)
    model, feed = connect(model, inputs, plan.steps, plan.every)
    warn_loads(model)
    for sentence in cautions(model, solver, plan):
        warn(f"simulate {model.name!r}", sentence)
    log.info("%s: %r in %d steps to %g s", model.name, solver, plan.steps, t_end)
    check_contacts(model, solver, plan.step)
    engine = Engine(model)
    if state is None:
        _warn_at_rest(model)
        _tell_of_ringing(model)
    else:
        _start(engine, state, plan)
        engine.steps_done = plan.before
    refuse_deep(engine)
    attributes = {
        "solver": solver_text(solver),
        "chosen": reason,
        "step": plan.step,
        "t_end": float(t_end),
        "gravity": model.gravity,
        "evaluations_per_step": solver.evaluations,
    }
    rows = plan.steps // plan.every + 1
    keeper = Keeper(path, model, rows, attributes, str(model_text))
    try:
        return _run(engine, solver, plan, keeper, progress, feed)
    except BaseException as error:
        if getattr(error, "solution", None) is None:
            keeper.discard()
        raise


def _warn_at_rest(model: Model) -> None:
    """Warn if the model has no force, drive or initial velocity that starts a motion."""
    if (
        model.gravity.any()
        or model.beams
        or any(f.kind != "load" or model.markers[f.a].body >= 0 for f in model.forces)
        or any(is_drive(joint) for joint in model.joints)
        or model.v0.any()
    ):
        return
    # a bent beam moves without any load
    if not any(model.q0[b.iq + 7 : b.iq + 7 + b.n].any() for b in model.bodies):
        warn(
            f"simulate {model.name!r}",
            "no gravity, no force, no drive and no initial velocity: nothing will move",
        )


def _tell_of_ringing(model: Model) -> None:
    """Log how to avoid the vibration of moving elastic bodies that are undeformed at the start."""
    if not log.isEnabledFor(logging.INFO):
        return
    elastic = [b for b in model.bodies if b.n]
    straight = not any(model.q0[b.iq + 7 : b.iq + 7 + b.n].any() for b in elastic)
    if elastic and straight and model.v0.any():
        log.info(
            "%s: elastic bodies move and are undeformed at the first instant, which makes them "
            "vibrate; start with state=jo.simulation.vibration_free_state(model), or, if the "
            "machine turns about one axis, with jo.simulation.steady_rotation(model, axis, speed)",
            model.name,
        )


def _start(engine: Engine, state: State, plan: Schedule) -> None:
    """Set the engine to an initial state; warn if its velocities violate joints or drives."""
    put(engine, state, "simulate")
    rates = np.abs(engine.constraints()[1] * engine.row_metres)
    row = int(np.argmax(rates)) if len(rates) else -1
    if row >= 0 and _jolts(engine, float(rates[row]), plan):
        joint = next(j for j in engine.model.joints if j.row <= row < j.row + j.rows)
        warn(
            f"simulate {engine.model.name!r}",
            f"the velocities of the state do not fit '{joint.name}' by {rates[row]:.3g} m/s "
            f"at {engine.time[0]:g} s, the run begins with a jolt; let drives start from "
            "rest, or start with the velocities of the drives: "
            "state=jo.simulation.vibration_free_state(model), bent as the motion bends it, "
            "jo.simulation.steady_rotation(model, axis, speed), or no state",
        )


def _jolts(engine: Engine, rate: float, plan: Schedule) -> bool:
    """Return whether a velocity residual, m/s, is significant compared with the speeds of the run.

    The speeds are those of the bodies at the start and of the drives at INSTANTS of the run.
    """
    if rate <= JOLT * largest_speed(engine.model, engine.v):
        return False
    if rate * plan.steps * plan.step <= DRIFT * engine.model.size:
        return False
    rewind = engine.mark()
    engine.v[:] = 0.0
    fastest = 0.0
    for share in np.linspace(0.0, 1.0, INSTANTS):
        engine.time[0] = plan.start + share * plan.steps * plan.step
        fastest = max(fastest, engine.residuals()[1])
    rewind()
    return rate > JOLT * fastest


def _run(
    engine: Engine,
    solver: Solver,
    plan: Schedule,
    keeper: Keeper,
    progress: bool | Report | None,
    feed: Feed,
) -> Solution:
    """Return the results of a run; complete and close the results file, after errors too."""
    step = 0.0 if solver.adaptive else float(solver.step)
    motors = motor_turns(engine.model, step, joint_coordinates=solver.joint_coordinates)
    watch = RunWatch(engine.model, projected=solver.projection, motors=motors)
    chronicle = Chronicle(engine)

    def record(rows: NDArray[np.float64]) -> None:
        try:
            keeper.append(rows)
            keeper.note(chronicle.read())
            if engine.model.touches:
                keeper.touch(*engine.touched())
        except OSError as error:  # full or missing disk
            raise _DiskError(f"cannot write {keeper.place}: {error}{_remedy(error)}") from error
        watch.see(rows)

    started = clock.perf_counter()

    def close(ended: str, complete: bool = False) -> Solution:
        wall = clock.perf_counter() - started
        reached = float(engine.time[0].real)
        factor = (reached - plan.start) / wall if wall > 0 else 0.0
        facts = {"ended": ended, "wall_time": wall, "real_time_factor": factor}
        if solver.bounded:
            facts["deferred"] = int(engine.counts.deferred)
        facts |= contact_facts(engine) | opening_facts(engine, step)
        try:
            if engine.model.touches:
                keeper.touch(engine.touching())
            return keeper.close(complete, facts)
        except OSError as error:
            message = f"cannot write {keeper.place}: {error}{_remedy(error)}"
            raise RunFailed(message, None, time=reached, body="") from error

    ending: Ending | None
    try:
        with reporter(progress, plan.start + plan.step * plan.steps) as report:
            ending = _loop(engine, solver, plan, record, report, feed)
    except KeyboardInterrupt:
        solution = close("interrupted")
        raise RunInterrupted(
            f"stopped at {engine.time[0]:g} s; the results up to then are in {keeper.place}",
            solution,
        ) from None
    except (_DiskError, Contradiction, InputFailed, FmuFailed) as error:
        ending = Ending(str(error))
    except BaseException as error:
        close(f"failed: {type(error).__name__} in the progress function")
        raise
    if ending is None or not ending.failed:
        solution = close("completed" if ending is None else ending.sentence, complete=True)
    else:
        solution = close(f"failed: {ending.sentence}")
        time = float(engine.time[0].real)
        sentence = f"the run stopped at {time:.6g} s: {ending.sentence}"
        raise RunFailed(sentence, solution, time=time, body=ending.body)
    if keeper.happened == EVENTS:
        warn(
            f"simulate {engine.model.name!r}",
            f"only the first {EVENTS} events are in the results; declare fewer events",
        )
    watch.judge()
    if opened := solution.attributes.get("openings"):
        warn(f"simulate {engine.model.name!r}", opened)
    if sentence := deferred_warning(int(engine.counts.deferred), int(engine.counts.steps)):
        warn(f"simulate {engine.model.name!r}", sentence)
    if engine.model.beams:
        warn_bent(engine)
    if engine.model.frictions and not watch.rubbed:
        _warn_idle_friction(engine)
    if engine.counts.singular and not engine.model.redundant:
        warn(
            f"simulate {engine.model.name!r}",
            "the mechanism passed a singular position, in which constraints of its joints are "
            "linearly dependent; the motion beyond it may be one of several, and the reactions in "
            "it are those of least norm",
        )
    return solution


def _warn_idle_friction(engine: Engine) -> None:
    """Warn of friction elements that dissipated no energy."""
    for i, friction in enumerate(engine.model.frictions):
        mu = named("jo_friction_data", friction.data).mu_kinetic
        if mu > 0.0 and not (friction.sticks and engine.slip[i] == 0):
            warn(
                f"friction '{friction.name}'",
                "dissipated no energy: its joint does not move, or has no normal force. Forces "
                "along the axis of a hinge give a normal force with collar_radius only, bending "
                "moments with bearing_length only; preload gives one always",
            )


class _DiskError(Exception):
    """Error of writing the results."""


def _remedy(error: OSError) -> str:
    full = error.errno in (errno.ENOSPC, errno.EDQUOT)
    return "; free some space and run again" if full else ""


def _loop(
    engine: Engine, solver: Solver, plan: Schedule, record: Record, report: Report, feed: Feed
) -> Ending | None:
    """Step to the end in calls of WALL_PER_CALL; return the cause of an early end, or None."""
    model = engine.model
    native = prepared(engine, solver, plan.step)
    most = plan.steps // plan.every + 3
    capacity = max(2, min(4096, most, BUFFER_BYTES // (8 * engine.row_size)))
    rows = np.zeros((capacity, engine.row_size))
    if solver.adaptive:
        native.largest = native.largest or LONGEST * plan.step * plan.steps
        return _adaptive(engine, solver, plan, native, rows, record, report, feed)
    if model.fmus:
        return _coupled(engine, solver, plan, native, record, report, feed)
    done = 0
    feed.set(engine, done)
    rows[0] = engine.row()
    record(rows[:1])
    started = clock.perf_counter()
    call = 1
    while done < plan.steps:
        room = (capacity - 1) * plan.every
        count = min(call, plan.steps - done, max(room, plan.every), feed.ahead(done))
        if done:
            feed.set(engine, done)
        before, first = clock.perf_counter(), engine.steps_done
        status, written = engine.run(native, count, plan.every, rows)
        now = clock.perf_counter()
        record(rows[:written])
        if status == "event":
            return event_ending(engine)
        if status != "ok":
            return failure_ending(model, solver, plan, engine, status)
        count = engine.steps_done - first  # fewer than requested if the event log was full
        done += count
        report(float(engine.time[0].real), now - started)
        spent = max(now - before, 1e-6)
        call = max(1, min(int(count * WALL_PER_CALL / spent), 4 * call))
    return None


def _coupled(
    engine: Engine,
    solver: Solver,
    plan: Schedule,
    native: Any,
    record: Record,
    report: Report,
    feed: Feed,
) -> Ending | None:
    """Step to the end, coupled with FMUs; return the cause of an early end, or None."""
    feed.set(engine, 0)
    coupling = Coupling(engine, plan)
    suspects = ""
    try:
        status = Coupled(engine, native, plan, feed, coupling, record).run(report)
        suspects = coupling.suspects
    finally:
        coupling.close()
    if status == "event":
        return event_ending(engine)
    if status != "ok":
        ending = failure_ending(engine.model, solver, plan, engine, status)
        return replace(ending, sentence=f"{ending.sentence}; {suspects}") if suspects else ending
    coupling.judge()
    return None


def _adaptive(
    engine: Engine,
    solver: Solver,
    plan: Schedule,
    native: Any,
    rows: NDArray[np.float64],
    record: Record,
    report: Report,
    feed: Feed,
) -> Ending | None:
    """Step to the end with error control; return the cause of an early end, or None.

    The integration restarts at every jump of an input.
    """
    done = 0
    while done < plan.steps:
        feed.set(engine, done)
        count = min(plan.steps - done, feed.ahead(done))
        engine.steps_done = 0  # counter of the rows of this interval
        seen: Record = record if done == 0 else _without_first(record)
        status = follow(engine, native, count, rows, seen, report)
        if status == "event":
            return event_ending(engine)
        if status == "step too small":
            return Ending(*too_many_steps(engine, plan.start + done * plan.step, plan.step))
        if status != "ok":
            return failure_ending(engine.model, solver, plan, engine, status)
        done += count
    return None


def _without_first(record: Record) -> Record:
    """Return a function that records all rows but the first, which is already recorded."""
    waiting = [True]

    def rest(rows: NDArray[np.float64]) -> None:
        skipped = 1 if waiting and len(rows) and waiting.pop() else 0
        record(rows[skipped:])

    return rest


def event_ending(engine: Engine) -> Ending:
    """Return the ending of a run that an event with ``stop=True`` stopped."""
    name = engine.model.events[engine.error_index].name
    return Ending(f"stopped by event '{name}' at {engine.time[0]:.9g} s", failed=False)


def failure_ending(
    model: Model, solver: Solver, plan: Schedule, engine: Engine, status: str
) -> Ending:
    """Return the cause of a failed run, as a sentence, and the body that moves most."""
    if status == "no convergence":
        body = model.bodies[engine.error_index].name
        text = f"{engine.problem(status)}; "
        text += f"the step is {plan.step:.3g} s, try {0.5 * plan.step:.3g} s"
        found = repeated_rows(model) if model.redundant else None
        if found and found.weak:
            text += f"; constraints of the joints are linearly dependent, and {found.weak}"
        return Ending(text, body)
    if status not in ("not finite", "singular body", "singular joint"):
        return Ending(str(engine.problem(status)))
    sentence = stability_warning(model, solver, plan.step)
    gap = engine.residuals()[0]
    fast = largest_speed(model, engine.v) * plan.step > LEAP * model.size
    diverged = bool(sentence) or not gap < 1e-3 * model.size or fast
    if status != "not finite" and not diverged:
        problem = engine.problem(status)
        return Ending(f"{problem} (it was regular at the start: a singular position was reached)")
    body = ""
    if status == "not finite":
        body = model.bodies[engine.error_index].name
    if not sentence:
        sentence = (
            f"the step of {plan.step:.3g} s may be too large for this motion, try half; or "
            "forces, masses or stiffnesses have the wrong unit"
        )
        drives = ", ".join(f"'{joint.name}'" for joint in model.joints if is_drive(joint))
        if drives:
            sentence += f"; or the lengths do not allow the motion of the drives ({drives})"
    what = f"body '{body}'" if body else "the motion"
    return Ending(f"{what} diverged; likely cause: {sentence}", body)


def describe(solution: Solution) -> dict[str, Any]:
    """Return the summary of a run: its end, wall time, largest residuals and energy error."""
    residuals, energy = solution.residuals, solution.energy
    chosen = str(solution.attributes.get("chosen", ""))
    contacts = solution.attributes.get("contacts")
    return {
        "instants": solution.nt,
        "end of the run (s)": float(solution.time[-1]) if solution.nt else 0.0,
        "ended": solution.attributes.get("ended", "still running or killed"),
        "solver": solution.attributes["solver"] + (f", {chosen}" if chosen else ""),
        "steps": int(solution.work.steps[-1]) if solution.nt else 0,
        "wall time (s)": solution.attributes.get("wall_time", float("nan")),
        "real-time factor": solution.attributes.get("real_time_factor", float("nan")),
        "largest position residual": float(residuals.position.max(initial=0.0)),
        "largest velocity residual": float(residuals.velocity.max(initial=0.0)),
        "largest energy error (J)": float(np.abs(energy.error).max(initial=0.0)),
        "energy": energy.verdict.removeprefix("energy "),
    } | ({"contacts": contacts} if contacts else {})
