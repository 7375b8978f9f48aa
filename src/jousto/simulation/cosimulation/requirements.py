"""Checks of a run with functional mock-up units before any of them is loaded."""

from __future__ import annotations

from jousto.base.errors import ASK_TRUST, InputError, Problems
from jousto.model.model import Model
from jousto.simulation.solvers.base import Solver
from jousto.simulation.solvers.schedule import Schedule
from jousto.simulation.state import State

REST = 1e-9  # difference of times over a step, below which they are equal


def check_trust(model: Model) -> None:
    """Raise an error for FMUs of a model file that the user has not declared as trusted.

    Raises
    ------
    InputError
        With all these units.
    """
    problems = Problems()
    for unit in model.fmus:
        fmu = unit.fmu
        if fmu.untrusted:
            problems.add(
                f"{fmu.untrusted}: fmu {fmu.name!r}",
                f"{fmu.file.name!r} contains native code, {ASK_TRUST}",
            )
    problems.raise_if_any()


def check_coupling(
    model: Model, solver: Solver, plan: Schedule, state: State | None, inputs: object
) -> None:
    """Raise an error if method, steps, state or inputs of a run do not fit its FMUs.

    Raises
    ------
    InputError
        With all errors.
    """
    problems = Problems()
    steps = {unit.fmu.step for unit in model.fmus}
    for unit in model.fmus:
        fmu, where = unit.fmu, f"fmu {unit.fmu.name!r}"
        if solver.adaptive:
            problems.add(
                where,
                f"{type(solver).__name__} chooses its steps itself; use a method with a fixed "
                "step, "
                "such as ROS2",
            )
            continue
        if state is not None and state.time != 0.0:
            problems.add(
                where,
                f"starts at time 0 and its state at {state.time:g} s is not known: a run with it "
                "cannot be continued, run from 0 to the new end",
            )
        every = fmu.step / plan.step
        if round(every) < 1 or abs(every - round(every)) > REST * every:
            good = max(1, round(every)) * plan.step
            problems.add(
                where,
                f"step is {fmu.step:g} s, must be a multiple of the step of the run, "
                f"{plan.step:g} s; for example {good:g} s",
            )
        elif plan.steps % round(every):
            problems.add(
                where,
                f"the run of {plan.steps * plan.step:g} s is not a multiple of its step, "
                f"{fmu.step:g} s",
            )
        elif fmu.estimate and round(every) % 2:
            problems.add(
                where,
                f"estimate=True halves its step of {fmu.step:g} s, which the step of the run, "
                f"{plan.step:g} s, does not divide; take {0.5 * plan.step:g} s or "
                f"{2 * fmu.step:g} s",
            )
        if any(other.fmu.estimate for other in model.fmus):
            if len(steps) > 1:
                problems.add(where, "with estimate=True all units need the same step")
            if not fmu.description.states:
                problems.add(where, "cannot restore a state, which estimate=True needs")
        for name in fmu.driven:
            if isinstance(inputs, dict) and name in inputs:
                problems.add("simulate", f"inputs: {name!r} is set by {where}; remove it")
    if problems.found:
        raise InputError(problems.found)
