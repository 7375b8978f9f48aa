"""Schedule: the steps of a run, and warnings about probably unsuitable steps."""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.model.model import Model
from jousto.model.native.header import named
from jousto.simulation.controllers import tracking_warning
from jousto.simulation.solvers.base import Solver, known
from jousto.simulation.solvers.beam_checks import beam_steps_warning
from jousto.simulation.solvers.stability import (
    damper_warning,
    friction_warning,
    many_steps,
    stability_warning,
)

logger = logging.getLogger(__name__)

MOST_STEPS = 1e12


@dataclass(frozen=True)
class Schedule:
    """Steps of a run: `steps` of size `step` from `start`, a row every `every` steps.

    For an adaptive method they are the intervals between rows.
    """

    step: float
    steps: int
    every: int
    start: float = 0.0

    @property
    def before(self) -> int:
        """Number of steps from time 0 to the start; 0 if the start is not an instant of a row.

        Instants are counted from 0, so that a continued run has bitwise the same instants as one
        run.
        """
        count = round(self.start / self.step)
        return count if count * self.step == self.start and count % self.every == 0 else 0


def schedule(
    model: Any, t_end: Any, solver: Any, output_step: Any = None, start: float = 0.0
) -> Schedule:
    """Return the steps of a run that starts at time `start`, s.

    Raises
    ------
    InputError
        If the model, the solver or the times are invalid.
    """
    problems = Problems()
    where = "simulate"
    if not isinstance(model, Model):
        kind = type(model).__name__
        hint = (
            "; compile it first: simulate(compile(mechanism), ...)" if kind == "Mechanism" else ""
        )
        problems.add(where, f"model is a {kind}, must be a Model{hint}")
    if not isinstance(solver, Solver):
        one_of = f"must be one of {known()}, e.g. ROS2(step=1e-3)"
        problems.add(where, f"solver is {solver!r}, {one_of}", "solver")
    times = [("t_end", t_end)] + ([] if output_step is None else [("output_step", output_step)])
    for name, value in times:
        if type(value) is float and 0.0 < value < np.inf:
            continue
        if problems.array(where, name, value, ()) is not None:
            problems.positive(where, name, float(value), "s")
    problems.raise_if_any()
    end = float(t_end) - start
    if not end > 0.0:
        raise InputError(
            Problem(
                where,
                f"t_end = {t_end:g} s is not after the state's time, {start:.9g} s",
                path=("t_end",),
            )
        )
    unit = end if output_step is None else float(output_step)
    if end / min(solver.step, unit) > MOST_STEPS:
        raise InputError(
            Problem(
                where,
                f"{end:g} s in steps of {solver.step:g} s are {end / solver.step:.3g} steps, more "
                f"than {MOST_STEPS:g}; check the units of t_end, step and output_step",
            )
        )
    pieces = max(1, int(np.ceil(unit / solver.step * (1.0 - 1e-12))))
    if solver.adaptive and output_step is not None:
        pieces = 1  # rows do not coincide with steps
    step = unit / pieces
    # the step differs by the round-off of t_end only
    if abs(step - solver.step) <= 1e-12 * solver.step:
        step = solver.step
    if abs(step - solver.step) > 1e-9 * solver.step and not solver.adaptive:
        logger.info("step shortened from %g to %g s", solver.step, step)
    if output_step is None:
        return Schedule(step, pieces, 1, start)
    rows = round(end / unit)
    if rows < 1 or abs(rows * unit - end) > 1e-9 * end:
        raise InputError(
            Problem(
                where,
                f"{_span(end, start)} is not a multiple of output_step = {unit:g} s; "
                f"for example t_end = {start + max(rows, 1) * unit:g} s fits",
            )
        )
    return Schedule(step, rows * pieces, pieces, start)


def _span(length: float, start: float) -> str:
    return f"t_end = {length:g} s" if start == 0.0 else f"the run of {length:g} s"


def cautions(model: Model, solver: Solver, plan: Schedule) -> list[str]:
    """Return the warnings about a run that can be determined before it starts."""
    found = []
    sentence = stability_warning(model, solver, plan.step)
    if sentence:
        found.append(f"the run will probably diverge: {sentence}")
    if solver.adaptive:
        duration = plan.step * plan.steps
        sentences = (many_steps(model, duration), beam_steps_warning(model, duration))
        return [sentence for sentence in sentences if sentence]
    both = (friction_warning(model, solver, plan.step), damper_warning(model, solver, plan.step))
    found += [sentence for sentence in (*both, tracking_warning(model, plan.step)) if sentence]
    for force in model.forces:
        if force.signal < 0:
            continue
        signal = model.signals[force.signal]
        if signal.kind == "harmonic":
            omega = named("jo_harmonic_data", signal.data).omega
            if omega * plan.step > 0.2 * np.pi:
                frequency = omega / (2 * np.pi)
                found.append(
                    f"load '{force.name}' oscillates with {frequency:.4g} Hz, the step of "
                    f"{plan.step:.3g} s does not resolve it; take {0.05 / frequency:.2g} s or less"
                )
        elif signal.kind == "table":
            shortest = _shortest(signal.data[: len(signal.data) // 2], plan)
            if shortest < plan.step:
                found.append(
                    f"load '{force.name}' has table points {shortest:.3g} s apart, the step of "
                    f"{plan.step:.3g} s may jump over them; take {shortest:.2g} s or less"
                )
    return found


def _shortest(times: Array, plan: Schedule) -> float:
    """Return the shortest interval between points of the tables within a run, s.

    An interval that differs from the step by round-off only counts as the step.
    """
    last = plan.start + plan.step * plan.steps
    passed = (times[1:] > plan.start) & (times[:-1] < last)
    between = np.diff(times)[passed]
    rounding = 2.0 * np.finfo(float).eps * np.abs(times[1:][passed])
    shorter = between < plan.step * (1.0 - 1e-9) - rounding
    return float(between[shorter].min(initial=np.inf))
