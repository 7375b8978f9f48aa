"""verify: comparison of the engine with a second formulation, the moving frame."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problems, SimulationError
from jousto.base.numbers import number
from jousto.mechanism.mechanism import Mechanism
from jousto.mechanism.sensors.base import Sensor
from jousto.model.compile import compile
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.packing.foreign import without_fmus
from jousto.model.packing.sensors import NOT_UNIQUE
from jousto.natural.added_sensors import largest_of, typical_sizes, with_added_sensors
from jousto.natural.comparison import Compared, Way, sizes
from jousto.natural.engine_variants import FOLLOWING, SHAKY, Course, by_other_method, others
from jousto.natural.equations.supported import check_known, is_read
from jousto.natural.equations.trapezoidal_step import PENALTY
from jousto.natural.moving_frame import moving_frame
from jousto.natural.rebuilt_mechanism import with_constant_inputs
from jousto.natural.result import NaturalRun
from jousto.natural.sensors_at_state import at_states
from jousto.natural.verification import Verification
from jousto.simulation.results.dataframes import component_units
from jousto.simulation.results.solution import Solution
from jousto.simulation.running.simulate import RunFailed, simulate
from jousto.simulation.running.start_state import initial_state
from jousto.simulation.solvers.base import Solver
from jousto.simulation.solvers.default_solver import choose
from jousto.simulation.state import MEMORY, State, put

OUTPUTS, EVERY = 200, 10
OPEN = 1e-8  # gap over the size of the mechanism, or rad, above which a joint is open
STILL = 1e-12  # change over the largest position, below which it is round-off
DONE = ("dissipated", "friction", "work")
PENALTIES = (PENALTY, 1e4 * PENALTY)
"""Penalties of the moving frame; the second one is for bodies with almost no inertia."""


@explained
def verify(
    mechanism: Mechanism,
    t_end: float,
    *,
    step: float = 1e-3,
    solver: Solver | None = None,
    begin: Callable[[Model], State | None] | None = None,
    beside: Mapping[str, Mechanism] | None = None,
) -> Verification:
    """Return a comparison of the engine with the moving frame, a second formulation.

    At 21 states of the run both formulations compute accelerations, reactions and sensor values
    from the same positions and velocities; these must be equal to round-off. Both also make runs
    with the step and with half of it, whose differences must decrease with the order of the
    methods. Further runs of the engine use another method, flexible bodies in another body frame,
    and bodies of small meshes with twice the modes. If the moving frame does not support the
    mechanism, two methods of the engine and the energy balance are the criterion. The comparison
    includes all sensors, the accelerations of all bodies, the reactions of all joints and drives,
    all forces and the energies. If a run does not reach its end, only states are compared (those of
    the first half if the engine stopped), and the verdict contains the reason. If the engine cannot
    start, the verdict is undecided.

    Parameters
    ----------
    mechanism : Mechanism
        Mechanism to verify.
    t_end : float
        End of the runs, s.
    step : float
        Longer step of the moving frame and, without `solver`, of the engine, s.
    solver : Solver, optional
        Method of the engine and its longer step; None: the choice of `simulate`, with `step` if
        that is shorter.
    begin : callable, optional
        Function of the compiled model that returns the initial state, such as `equilibrium` or
        `vibration_free_state`; None is the `start` of the mechanism, or its initial state.
    beside : mapping of str to Mechanism, optional
        Variants of the machine, such as one with a finer mesh, by name; sensors of equal name are
        compared.

    Returns
    -------
    Verification
        Differences with their orders, energy, constraints and verdict; printed as a table.

    Raises
    ------
    InputError
        If a value is invalid, or the mechanism cannot be compiled.

    Examples
    --------
    >>> import jousto as jo
    >>> ball = jo.RigidBody("ball", 1.0, (1, 1, 1), position=(1, 0, 0))
    >>> rod = jo.Rod("rod", jo.ground["origin"], ball["origin"])
    >>> found = verify(jo.Mechanism(ball, rod, jo.Gravity((0, -9.81, 0))), 0.1, step=2e-3)
    >>> found.agrees
    True
    """
    _check(t_end, step, begin, beside)
    without_fmus(mechanism, "verify", "has no second formulation")
    if begin is None and mechanism.start != "initial":
        begin = partial(initial_state, start=mechanism.start)
    mechanism = with_constant_inputs(mechanism)
    unknown = not_known(mechanism)
    whole = with_added_sensors(mechanism, every=bool(unknown))
    output, step = outputs_of(t_end, step)
    try:
        model = compile(whole)
        state = None if begin is None else begun_by(begin, model)
        solver = method(solver or choose(model, t_end, output)[0], solver is None, output, step)
        runs, stopped = by_both_steps(model, t_end, solver, output, state)
    except SimulationError as error:
        return not_begun(mechanism, step, unknown, f"the engine cannot begin: {error}")
    run, begun = runs[1], runs[0].state(0.0)
    last = len(run.time) if not stopped[1] else half(run)
    every = max(1, last * EVERY // OUTPUTS)
    typical = typical_sizes(whole, t_end, largest_of(run, last))
    ways: tuple[Way, ...] = ()
    if not any(stopped):
        course = Course(whole, runs, solver, t_end, output, begin, typical)
        ways = (by_other_method(course, model), *others(course, beside or {}))
    kept = Verification(
        name=mechanism.name,
        rows=ways[0].rows if ways else (),
        instants=len(run.time[:last:every]),
        step=float(step),
        open_joints=(),
        energy=(runs[0].energy.relative_error, run.energy.relative_error, np.nan, np.nan),
        residual=np.nan,
        iterations=np.nan,
        left_out=() if unknown else tuple(s.name for s in mechanism.sensors if not is_read(s)),
        ways=ways,
        unknown=unknown,
        still=is_still(run, last, every),
        shared=friction_not_unique(whole, model),
        stopped=tuple(filter(None, stopped)),
        ended=not stopped[1],
    )
    if unknown:
        return kept
    frames: list[NaturalRun] = []
    if not any(stopped):
        frames, why = by_moving_frame(whole, t_end, step, output, begun)
        kept = replace(kept, stopped=tuple(filter(None, [why])))
    states = (run.state(float(t)) for t in run.time[:last])
    found = at_states(whole, states, whole.sensors, every)
    times = run.time[:last:every]
    engine = by_engine(model, run, times)
    rows = tuple(
        compare_reading(s, run, times, (engine[s.name], found.readings[s.name]), typical)
        for s in whole.sensors
    )
    if frames:
        rows = tuple(with_runs(row, runs, frames, typical) for row in rows)
    if kept.shared:
        kinds = {s.name: s.reading.kind for s in whole.sensors}
        rows = tuple(of_position(row, kinds[row.name]) for row in rows)
    kept = replace(kept, rows=rows, open_joints=found.open_joints(OPEN))
    return replace(kept, **facts_of(frames, kept.energy)) if frames else kept


def not_begun(
    mechanism: Mechanism, step: float, unknown: tuple[str, ...], why: str
) -> Verification:
    """Return an undecided verification for a mechanism whose run cannot start."""
    return Verification(
        name=mechanism.name,
        rows=(),
        instants=0,
        step=float(step),
        open_joints=(),
        energy=(np.nan,) * 4,
        residual=np.nan,
        iterations=np.nan,
        left_out=(),
        unknown=unknown,
        stopped=(why,),
        ended=False,
    )


def _check(t_end: object, step: object, begin: object, beside: object) -> None:
    """Raise InputError with all invalid arguments."""
    problems = Problems()
    for name, value in {"t_end": t_end, "step": step}.items():
        given = number(problems, "verify", name, value)
        if given is not None and given <= 0.0:
            problems.add("verify", f"{name} is {given:g} s, must be positive")
    if begin is not None and not callable(begin):
        problems.add("verify", f"begin is {begin!r}, must be a function such as jo.equilibrium")
    if beside is not None and not (
        isinstance(beside, Mapping)
        and all(isinstance(other, Mechanism) for other in beside.values())
    ):
        problems.add("verify", "beside must be mechanisms by names, {'finer mesh': mechanism}")
    problems.raise_if_any()


def outputs_of(t_end: float, step: float) -> tuple[float, float]:
    """Return the time between outputs, s, and a step that divides it, s."""
    each = max(1, int(np.ceil(t_end / step / OUTPUTS * (1 - 1e-9))))
    output = t_end / max(1, round(t_end / step / each))
    return output, output / each


def method(solver: Any, chosen: bool, output: float, step: float) -> Any:
    """Return a method whose step, and half of it, divide the time between outputs."""
    longest = min(solver.step, step) if chosen else solver.step
    return at_step(solver, output / np.ceil(output / longest * (1 - 1e-9)))


def by_both_steps(
    model: Model, t_end: float, solver: Any, output: float, state: State | None
) -> tuple[list[Solution], list[str]]:
    """Return runs of the engine with the step and half of it, and the reasons of early ends."""
    runs, stopped = [], []
    for k in (1, 2):
        by = at_step(solver, solver.step / k)
        try:
            runs.append(simulate(model, t_end, solver=by, output_step=output, state=state))
            stopped.append("")
        except RunFailed as error:
            if error.solution is None:
                raise
            runs.append(error.solution)
            why = str(error).removeprefix("the run ")
            stopped.append(f"the engine with a step of {by.step:g} s {why}")
    return runs, stopped


def half(run: Solution) -> int:
    """Return the number of outputs in the first half of a run that stopped early."""
    return max(1, int(np.searchsorted(run.time, 0.5 * run.time[-1], side="right")))


def by_moving_frame(
    mechanism: Mechanism, t_end: float, step: float, output: float, begun: State
) -> tuple[list[NaturalRun], str]:
    """Return runs of the moving frame with the step and half of it, or none and the reason.

    Bodies with almost no inertia, such as rotors of elastic joints, need a larger penalty.
    """
    why = ""
    for penalty in PENALTIES:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", RuntimeWarning)  # overflow before it stops
                return [
                    moving_frame(
                        *(mechanism, t_end),
                        step=step / k,
                        output_step=output,
                        state=begun,
                        penalty=penalty,
                    )
                    for k in (1, 2)
                ], ""
        except SimulationError as error:
            why = why or str(error)
    return [], why


def facts_of(frames: list[NaturalRun], energy: tuple[float, ...]) -> dict[str, Any]:
    """Return energy errors of both formulations, and residuals of the moving frame."""
    return {
        "energy": (*energy[:2], *(frame.energy.relative_error for frame in frames)),
        "residual": float(frames[1].position_residual.max()),
        "iterations": float(np.mean(frames[0].iterations[1:])),
    }


def begun_by(begin: Callable[[Model], State | None], model: Model) -> State | None:
    """Return the initial state by `begin`; InputError for another model or a time other than 0."""
    state = begin(model)
    if state is None:
        return None
    problems, engine = Problems(), Engine(model)
    rooms = ("q", "v", *(name for name in MEMORY if name not in ("input", "joint")))
    given = {name: getattr(state, name) for name in rooms}
    if any(x is not None and np.shape(x) != getattr(engine, n).shape for n, x in given.items()):
        problems.add(
            "verify",
            "begin returned a state of another model; compute it from the argument of begin, a "
            "model with further sensors, as begin=jo.equilibrium does",
        )
    if state.time != 0.0:
        problems.add(
            "verify",
            f"begin returned a state at {state.time:g} s, must be at 0; return "
            "dataclasses.replace(state, time=0.0)",
        )
    problems.raise_if_any()
    return state


def friction_not_unique(mechanism: Mechanism, model: Model) -> tuple[str, ...]:
    """Return the names of frictions whose normal force is a reaction that is not unique."""
    open_ended = {s.name for s in model.sensors if s.description.endswith(NOT_UNIQUE)}
    return tuple(
        s.reading.of.name
        for s in mechanism.sensors
        if s.reading.kind == "friction" and s.name in open_ended
    )


def of_position(row: Compared, kind: str) -> Compared:
    """Return a row without its comparison of runs, for mechanisms where only positions are unique.

    Used if friction, on which accelerations and reactions depend, is not unique.
    """
    row = replace(row, coarse=np.nan, fine=np.nan)
    return replace(row, unique=False) if kind in SHAKY else row


def is_still(run: Solution, last: int, every: int) -> bool:
    """Return whether positions change only by round-off in a run."""
    q = np.array([run.state(float(t)).q for t in run.time[:last:every]])
    return bool(np.abs(q - q[0]).max(initial=0.0) <= STILL * np.abs(q).max(initial=0.0))


def not_known(mechanism: Mechanism) -> tuple[str, ...]:
    """Return messages on the items of a mechanism that the moving frame does not support."""
    try:
        check_known(mechanism, sensors=False)
    except InputError as error:
        return tuple(str(problem) for problem in error.problems)
    return ()


def at_step(solver: Any, step: float) -> Any:
    """Return a method with another step; adaptive methods are unchanged."""
    return solver if solver.adaptive else replace(solver, step=step)


def by_engine(model: Model, run: Solution, times: Array) -> dict[str, Array]:
    """Return sensor values by the equations of the engine, at instants of a run.

    The accelerations stored by implicit methods satisfy the velocity constraints, but differ from
    these equations by the error of a step.
    """
    engine = Engine(model)
    rows = []
    for t in times:
        put(engine, run.state(float(t)), "verify")
        engine.row()
        rows.append(np.array(engine.sensors()))
    values = np.stack(rows)
    return {s.name: values[:, s.offset : s.offset + s.count] for s in model.sensors}


def largest_difference(a: Array, b: Array) -> Array:
    """Return the largest absolute difference over the components, (nt,)."""
    return np.asarray(np.abs(a - b).max(axis=1, initial=0.0, where=np.isfinite(a - b)))


def compare_reading(
    sensor: Sensor,
    run: Solution,
    times: Array,
    found: tuple[Array, Array],
    typical: dict[str, float],
) -> Compared:
    """Return the difference of a reading between both formulations at the same states."""
    name, reading = sensor.name, sensor.reading
    about = run.about(name)
    values = run[name][run.time <= times[-1]]
    apart = largest_difference(
        *(x / sizes(values, list(component_units(about)), typical) for x in found)
    )
    worst = int(np.argmax(apart))
    unknown = reading.kind == "energy" and reading.of in DONE
    return Compared(
        name=name,
        size=float(np.abs(values).max(initial=0.0)),
        unit=str(about["unit"]),
        at_instants=np.nan if unknown else float(apart[worst]),
        coarse=np.nan,
        fine=np.nan,
        unique=not about["description"].endswith(NOT_UNIQUE),
        direct=reading.kind not in FOLLOWING,
        worst=float(times[worst]),
    )


def with_runs(
    row: Compared, runs: list[Solution], frames: list[NaturalRun], typical: dict[str, float]
) -> Compared:
    """Return a compared reading with its differences between the runs."""
    units = list(component_units(runs[1].about(row.name)))
    size = sizes(runs[1][row.name], units, typical)
    coarse, fine = (
        float(largest_difference(a[row.name] / size, b[row.name] / size).max())
        for a, b in zip(frames, runs, strict=True)
    )
    return replace(row, coarse=coarse, fine=fine)
