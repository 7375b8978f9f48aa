"""Function `identify`: the numbers of a model that agree best with measurements."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, warn
from jousto.design.identification.identified import Identified
from jousto.design.identification.remarks import asides, troubles
from jousto.design.identification.residuals import Residuals
from jousto.design.identification.result import result_at
from jousto.design.identification.search import Minimum, search, staged
from jousto.design.identification.set_up import set_up
from jousto.design.identification.step_choice import choose_solver, step_error
from jousto.design.identification.unknowns import Unknown
from jousto.design.studies.parameters.parameter import Parameter
from jousto.simulation.solvers.base import Solver

SAME = 1e-3
"""Relative change of an estimated noise at which the alternation ends."""
ALTERNATIONS = 20
APART = 1e-2
"""Distance of two minima, in sizes, above which they are different."""
ACCURATE = 0.1
"""Largest rms error of the steps, in deviations of the noise."""
HALVINGS = 6
RETURNS = 4
"""Steps by which what is not seen returns to its start values; the unseen directions are curved."""


@explained
def identify(
    model: Any,
    parameters: Sequence[Parameter | str] | Parameter | str | None,
    experiments: Any,
    *,
    check: Any = (),
    loss: str = "linear",
    solver: Solver | None = None,
    starts: int = 1,
    seed: int = 0,
    workers: int = 1,
) -> Identified:
    """Return the numbers of a model that agree best with measurements, and how sure they are.

    ``F = 1/2 sum rho(r_i^2) + 1/2 sum prior^2`` is smallest, with the weighted residuals ``r_i =
    (gain h(t_i - shift) + bias - y_i) / sd_i``. Positive numbers are sought by their logarithm. A
    short part of the record is fitted first, the whole one last; a robust loss starts from the
    linear one. Noise that is not given is estimated with the numbers. Intervals allow for residuals
    with memory (White, Econometrica 50, 1982).

    Parameters
    ----------
    model : callable, ModelFile, Mechanism or Model
        As in `study`: a function of the parameters, a file from `read_model`, or a machine whose
        numbers or inputs are the parameters.
    parameters : sequence of Parameter or str
        What is sought, from the values on; bounds are kept. A normal or lognormal `distribution` is
        prior knowledge. None: all parameters of the file.
    experiments : Experiment, Values, Modal, Record, path, or sequence of these
        What was measured; a record is compared by the names of its channels.
    check : Experiment, Values, Modal, Record, path, or sequence of these
        Measurements that are only compared with the result, never fitted.
    loss : {"linear", "huber", "soft_l1", "cauchy"}
        Least squares, or a loss that wild samples do not spoil (as in `scipy.optimize`).
    solver : Solver, optional
        Method and step of the runs; by default one whose error is below the noise.
    starts : int
        Number of searches; further ones start from points within the bounds (or a factor 3).
    seed : int
        Seed of those points.
    workers : int
        Runs at the same time, in threads.

    Returns
    -------
    Identified
        Values, intervals, tests of the residuals, and what the measurement does not show.

    Raises
    ------
    InputError
        With all problems of parameters, records and channels; if there are fewer values than
        unknowns, or the machine fails at the start values.

    Warns
    -----
    JoustoWarning
        For values on their bounds, noise other than given, residuals that are not white, channels
        of the other sign or of another clock; the texts are in ``notes`` of the result.

    Examples
    --------
    >>> import jousto as jo
    >>> import numpy as np
    >>> def oscillator(mass, stiffness):
    ...     block = jo.RigidBody("block", mass, (1.0, 1.0, 1.0))
    ...     slide = jo.Prismatic("slide", jo.ground["origin"], block["origin"], axis=(1, 0, 0))
    ...     coil = jo.Spring("coil", slide.displacement, stiffness, free=0.1)
    ...     return jo.Mechanism(block, slide, coil, jo.CoordinateSensor("x", slide.displacement))
    >>> t = np.linspace(0.0, 2.0, 101)
    >>> x = 0.1 * (1.0 - np.cos(np.sqrt(50.0 / 2.0) * t))
    >>> noise = np.random.default_rng(1).normal(0.0, 1e-4, t.size)
    >>> record = jo.gauges.Record(t, {"x": x + noise}, {"x": "m"}, "test")
    >>> experiment = jo.design.Experiment(record, noise={"x": 1e-4})
    >>> stiffness = jo.Parameter("stiffness", 40.0, unit="N/m")
    >>> found = identify(lambda stiffness: oscillator(2.0, stiffness), stiffness, experiment)
    >>> round(found["stiffness"], 2), np.round(found.interval("stiffness"), 2)
    (50.0, array([50.  , 50.01]))
    """
    begun = clock.perf_counter()
    residuals, checks, estimated = set_up(
        model, parameters, experiments, check, loss, solver, starts, workers
    )
    u0 = np.array([own.u(own.start) for own in residuals.unknowns])
    residuals = choose_solver(residuals, u0) if solver is None else residuals
    residuals, best, others = _searched(residuals, u0, loss, estimated, starts, seed)
    # the steps of the runs must not be seen in the result
    error = step_error(residuals, best.u)
    notes: list[str] = []
    for _ in range(HALVINGS):
        if not error > ACCURATE or solver is not None:
            break
        residuals = residuals.with_solver(_halved(residuals))
        residuals, best = _noised(residuals, best.u, loss, estimated)
        error = step_error(residuals, best.u)
    if error > ACCURATE:
        notes.append(
            f"the steps of the runs move the sensors by {error:.2g} deviations of the noise: "
            "give a solver with a shorter step"
        )
    found = result_at(residuals, best, others, loss, estimated, checks)
    if found.certainty.unseen:
        best = _nearest(residuals, best, u0, found.certainty.hidden, loss)
        found = result_at(residuals, best, others, loss, estimated, checks)
    notes += troubles(found, residuals)
    for note in notes:
        warn("identify", note)
    notes += asides(found)
    return replace(found, notes=tuple(notes), seconds=clock.perf_counter() - begun)


def _searched(
    residuals: Residuals,
    u0: Array,
    loss: str,
    estimated: tuple[bool, ...],
    starts: int,
    seed: int,
) -> tuple[Residuals, Minimum, list[Minimum]]:
    """Return the residuals with their noise, the best minimum, and others."""
    ends = [staged(residuals, u0)]
    for point in _points(residuals.unknowns, starts, seed):
        try:
            ends.append(staged(residuals, point))
        except InputError:
            continue  # the machine fails there; its reason is kept
    best = min(ends, key=lambda one: one.F)
    residuals, found = _noised(residuals, best.u, loss, estimated)
    sizes = np.array([own.size for own in residuals.unknowns])
    others: list[Minimum] = []
    for one in sorted(ends, key=lambda one: one.F):
        apart = [np.abs((one.u - of.u) / sizes).max() > APART for of in (best, *others)]
        if one is not best and all(apart):
            others.append(one)
    trials = sum(one.trials for one in ends) + found.trials
    jacobians = sum(one.jacobians for one in ends) + found.jacobians
    return residuals, replace(found, trials=trials, jacobians=jacobians), others


def _nearest(residuals: Residuals, best: Minimum, u0: Array, N: Array, loss: str) -> Minimum:
    """Return the minimum whose unseen directions N (p, k) are as near to the start as possible."""
    sizes = np.array([own.size for own in residuals.unknowns])
    found = best
    for _ in range(RETURNS):
        back = sizes * (N @ (N.T @ ((u0 - found.u) / sizes)))
        end = search(residuals, found.u + back, loss)
        if end.F > best.F * (1.0 + SAME):
            break
        found = end
    return replace(found, trials=best.trials, jacobians=best.jacobians)


def _points(unknowns: Sequence[Unknown], starts: int, seed: int) -> list[Array]:
    """Return further start points within the bounds, or a factor 3 around the start values."""
    if starts < 2:
        return []
    from scipy.stats import qmc

    low, high = [], []
    for own in unknowns:
        a, b = own.ends
        u, size = own.u(own.start), own.size * np.log(3.0)
        low.append(a if np.isfinite(a) else u - size)
        high.append(b if np.isfinite(b) else u + size)
    count = 1 << int(np.ceil(np.log2(starts - 1)))
    drawn = qmc.Sobol(len(unknowns), seed=seed).random(count)[: starts - 1]
    return list(np.array(low) + drawn * (np.array(high) - np.array(low)))


def _noised(
    residuals: Residuals, u: Array, loss: str, estimated: tuple[bool, ...]
) -> tuple[Residuals, Minimum]:
    """Return the residuals with estimated noise, and the minimum of the loss from a point."""
    for _ in range(ALTERNATIONS if any(estimated) else 0):
        r, n, p = residuals.values(u), sum(residuals.sizes), len(u)
        factors: list[float] = []
        first = 0
        for size, free in zip(residuals.sizes, estimated, strict=True):
            own = r[first : first + size]
            first += size
            left = max(size - p * size / n, 1.0)
            spread = float(np.sqrt(own @ own / left))
            if loss != "linear":
                spread = float(np.median(np.abs(own))) / 0.6745
            factors.append(spread if free and spread > 0.0 else 1.0)
        residuals = residuals.with_noise(factors)
        u = search(residuals, u, loss).u
        if all(abs(factor - 1.0) < SAME for factor in factors):
            break
    return residuals, search(residuals, u, loss)


def _halved(residuals: Residuals) -> Any:
    """Return the method of the runs with half its step."""
    solver = residuals.solver
    return replace(solver, step=0.5 * solver.step)
