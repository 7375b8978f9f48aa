"""Optimisation methods: equivalent static loads, and direct optimisation of the runs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from scipy.optimize import minimize

from jousto.base.arrays import Array
from jousto.design.optimisation import loads as esl
from jousto.design.optimisation.elastic import EquivalentLoad
from jousto.design.optimisation.feasibility import nearest
from jousto.design.optimisation.optimum import ACTIVE, Cycle, Optimum, multipliers
from jousto.design.optimisation.problem import Kept, Problem
from jousto.design.optimisation.slopes import Function, differences

SMALL = 1e-5
"""Step of central differences of statics, as a share of the span of the bounds."""

FEASIBLE = 1e-5
"""Tolerance of ratios above 1."""

AHEAD, NEAR = 6, 0.02
"""Maximum number of order-0 cycles before order 1, and the limit excess that requires them."""

STALLED, NUDGE = 8, 1e-4
"""Status of SLSQP for a line search without descent, and the shift of the next start in bounds."""

PENALTY = 10.0
"""Penalty on a ratio above 1, in costs of the initial design, if no design is feasible."""


def solve(
    problem: Problem, x: Array, ratios: Function, slopes: Function, low: Array, high: Array
) -> Array:
    """Minimise the cost between bounds with all ratios at most 1 by SLSQP; return the design.

    If no design satisfies all limits, the result is the design of least violation.
    """
    span, scale = problem.high - problem.low, abs(problem.cost(x)) or 1.0

    def design(u: Array) -> Array:
        return np.asarray(problem.low + u * span)

    def cost(u: Array) -> float:
        return problem.cost(design(u)) / scale

    def down(u: Array) -> Array:
        found = differences(problem, lambda v: np.array([problem.cost(v)]), design(u), SMALL)
        return np.asarray(found[0] * span / scale)

    box = list(zip((low - problem.low) / span, (high - problem.low) / span, strict=True))
    start = (x - problem.low) / span
    options = {"ftol": 1e-10, "maxiter": 60}

    def search(begin: Array) -> Any:
        return minimize(  # type: ignore[call-overload]
            cost,
            begin,
            jac=down,
            bounds=box,
            method="SLSQP",
            options=options,
            constraints={
                "type": "ineq",
                "fun": lambda u: 1.0 - ratios(design(u)),
                "jac": lambda u: -slopes(design(u)) * span,
            },
        )

    found = search(start)
    if found.status == STALLED:
        # beside the design the line search has room again
        ends = np.array(box).T
        again = search(np.clip(found.x + NUDGE * (ends[1] - ends[0]), *ends))
        found = again if again.success else found
    # a search that stops early at a feasible design is a valid step as well
    if np.max(ratios(design(found.x)), initial=0.0) <= 1.0 + FEASIBLE:
        return np.clip(design(found.x), low, high)
    # one more variable: the common relaxation of all limits
    over = float(max(np.max(ratios(x), initial=1.0) - 1.0, 0.0))
    relaxed: Any = minimize(  # type: ignore[call-overload]
        lambda w: cost(w[:-1]) + PENALTY * w[-1],
        np.append(start, over),
        jac=lambda w: np.append(down(w[:-1]), PENALTY),
        bounds=[*box, (0.0, None)],
        method="SLSQP",
        options=options,
        constraints={
            "type": "ineq",
            "fun": lambda w: 1.0 + w[-1] - ratios(design(w[:-1])),
            "jac": lambda w: np.hstack(
                [-slopes(design(w[:-1])) * span, np.ones((len(ratios(design(w[:-1]))), 1))]
            ),
        },
    )
    return np.clip(design(relaxed.x[:-1]), low, high)


def largest(table: esl.Table, fixed: Array) -> float:
    """Return the largest ratio of a table and of the limits without a run."""
    return float(np.max([np.max(r) for _, _, r in table] + list(fixed), initial=0.0))


def change(old: Sequence[EquivalentLoad], new: Sequence[EquivalentLoad]) -> float:
    """Return the relative change of loads ``sum |f_new - f_old| / sum |f_old|``."""
    total, moved = 0.0, 0.0
    for a, b in zip(old, new, strict=True):
        f, g = a.columns @ a.values, b.columns @ b.values
        if f.shape != g.shape:
            return float("nan")
        total += float(np.linalg.norm(f, axis=0).sum())
        moved += float(np.linalg.norm(g - f, axis=0).sum())
    return moved / total if total else 0.0


def optimise_by_loads(
    problem: Problem,
    order: int,
    start: Array,
    *,
    tolerance: float,
    cycles: int,
    screen: float,
    trust: float,
    size: float,
    report: Callable[[Cycle], None] | None,
) -> Optimum:
    """Optimise by equivalent static loads of order 0 or 1; see `optimise`."""
    span = problem.high - problem.low
    x, radius = start.copy(), trust
    history: list[Cycle] = []
    last: Array | None = None
    old: list[EquivalentLoad] | None = None
    converged, message = False, f"not converged in {cycles} cycles"
    for _ in range(cycles):
        plain = esl.classical(x, problem.bodies(x), problem.motions(x))
        table = esl.table_of(problem, x)
        ratio = largest(table, problem.fixed(x))
        # order 0 finds a feasible design from any start; order 1 then finds the optimum near it
        ahead = order == 1 and len(history) < AHEAD and ratio > 1.0 + NEAR
        loads = esl.first_order(problem, x, size) if order and not ahead else plain
        kept = esl.screened(table, screen)

        def ratios(y: Array, loads: list[EquivalentLoad] = loads, kept: list[Kept] = kept) -> Array:
            return esl.ratios_of(problem, y, kept, loads)

        def slopes(y: Array, ratios: Function = ratios) -> Array:
            return differences(problem, ratios, y, SMALL)

        reach = 1.0 if ahead else radius
        low = np.maximum(problem.low, x - reach * span)
        high = np.minimum(problem.high, x + reach * span)
        new = solve(problem, x, ratios, slopes, low, high)
        step = (new - x) / span
        moved = float(np.max(np.abs(step)))
        history.append(
            Cycle(
                problem.values(x),
                problem.cost(x),
                ratio,
                float("nan") if old is None else change(old, plain),
                moved,
                problem.runs,
            )
        )
        if report is not None:
            report(history[-1])
        if moved <= tolerance and not ahead:
            converged, message = True, f"converged in {len(history)} cycles"
            break
        if ahead:
            x, old = new, plain
            continue
        if last is not None and float(step @ last) < 0.0:
            radius = 0.5 * min(radius, moved)
        else:
            radius = min(1.5 * radius, 1.0)
        x, last, old = new, step, plain
    return make_optimum(
        problem, f"esl, order {order}", x, converged, message, history, screen, size
    )


def optimise_directly(
    problem: Problem,
    start: Array,
    *,
    tolerance: float,
    cycles: int,
    screen: float,
    size: float,
    report: Callable[[Cycle], None] | None,
) -> Optimum:
    """Optimise by runs of every trial design; see `optimise`."""
    span = problem.high - problem.low
    x, history = start.copy(), list[Cycle]()
    converged, message = False, f"not converged in {cycles} rounds"
    for _ in range(cycles):
        table = esl.table_of(problem, x)
        ratio = largest(table, problem.fixed(x))
        kept = esl.screened(table, screen)

        def ratios(y: Array, kept: list[Kept] = kept) -> Array:
            return esl.ratios_of(problem, y, kept)

        def slopes(y: Array, ratios: Function = ratios) -> Array:
            return differences(problem, ratios, y, size)

        new = solve(problem, x, ratios, slopes, problem.low, problem.high)
        moved = float(np.max(np.abs(new - x) / span))
        history.append(
            Cycle(problem.values(x), problem.cost(x), ratio, float("nan"), moved, problem.runs)
        )
        if report is not None:
            report(history[-1])
        if moved <= tolerance:
            converged, message = True, f"converged in {len(history)} rounds"
            break
        x = new
    return make_optimum(problem, "direct", x, converged, message, history, screen, size)


def make_optimum(
    problem: Problem,
    method: str,
    x: Array,
    converged: bool,
    message: str,
    history: Sequence[Cycle],
    screen: float,
    size: float,
) -> Optimum:
    """Return the `Optimum` of a design, with the ratios of its own motion."""
    span = problem.high - problem.low
    table = esl.table_of(problem, x)
    ratio = largest(table, problem.fixed(x))
    kept = esl.screened(table, screen)
    ratios = esl.ratios_of(problem, x, kept)
    names = esl.labels(problem, x, kept)
    scale = abs(problem.cost(x)) or 1.0
    slopes = differences(problem, lambda y: esl.ratios_of(problem, y, kept), x, size) * span
    gradient = differences(problem, lambda y: np.array([problem.cost(y)]), x, SMALL)[0]
    gradient = gradient * span / scale
    edge = 1e-9 * span
    kkt, found = multipliers(
        gradient, ratios, slopes, x <= problem.low + edge, x >= problem.high - edge
    )
    if ratio > 1.0 + ACTIVE:
        converged = False
        message += f"; a limit is exceeded, the largest ratio is {ratio:.4g}"
        other = nearest(problem, x, screen, size)
        message += other.message
        if other.ratio <= 1.0 + ACTIVE:
            message += ", ".join(f"{k} = {v:.6g}" for k, v in problem.values(other.x).items())
    kkt = max(kkt, ratio - 1.0)
    active = tuple((names[row], m) for row, m in sorted(found.items(), key=lambda p: -p[1]))
    return Optimum(
        method,
        problem.values(x),
        problem.cost(x),
        ratio,
        converged,
        message,
        active,
        kkt,
        problem.runs,
        tuple(history),
    )
