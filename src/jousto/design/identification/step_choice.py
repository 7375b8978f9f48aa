"""Method and step of the runs: as coarse as the noise allows."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.design.identification.residuals import Residuals
from jousto.simulation.solvers.base import Solver
from jousto.simulation.solvers.default_solver import choose
from jousto.simulation.solvers.runge_kutta import RK4

LONGEST, SHORTEST = 2e-3, 5e-5
"""Steps of the explicit method that are tried, s."""
FINE = 0.02
"""Root mean square of the error of the steps, in deviations, that is not seen."""


def step_error(residuals: Residuals, u: Array, solver: Any = None) -> float:
    """Return the rms change of the residuals if the step of the runs is halved.

    Parameters
    ----------
    residuals : Residuals
    u : (p,) array
    solver : Solver, optional
        Another method with the full step.

    Returns
    -------
    float
        In deviations of the noise; infinite if a run fails.
    """
    given: Any = solver or residuals.solver
    if given is None or given.adaptive:
        return 0.0
    coarse = residuals.with_solver(given).values(u)
    fine = residuals.with_solver(_with_step(given, 0.5 * given.step)).values(u)
    if not (np.all(np.isfinite(coarse)) and np.all(np.isfinite(fine))):
        return np.inf
    return float(np.sqrt(np.mean((coarse - fine) ** 2)))


def _with_step(solver: Any, step: float) -> Any:
    return replace(solver, step=step)


def choose_solver(residuals: Residuals, u: Array) -> Residuals:
    """Return the residuals with a method whose error is below the noise at the start values.

    The explicit method RK4 with the longest of some steps whose error is small, else the method of
    the model file, else the default method of the machine.
    """
    bench: Any = next((one for one in residuals.benches if one.t_end is not None), None)
    if bench is None:
        return residuals
    step = bench.how["output_step"]
    while step > LONGEST:
        step *= 0.5
    failed = len(residuals.failures)
    chosen: Solver | None = None
    while step >= SHORTEST and chosen is None:
        trial = RK4(step)
        if step_error(residuals, u, trial) < FINE:
            chosen = trial
        step *= 0.5
    del residuals.failures[failed:]
    if chosen is None:
        case = bench.evaluator.case(residuals.theta(u)[bench.places])
        chosen = case.solver or choose(case.model, bench.t_end, bench.how["output_step"])[0]
    return residuals.with_solver(chosen)
