"""Function `optimise`: least cost within limits of stress, displacement, life and frequency."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, Literal

from scipy.stats import qmc

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import JoustoError, Problems, suggest
from jousto.design.optimisation.methods import optimise_by_loads, optimise_directly
from jousto.design.optimisation.optimum import Cycle, Optimum
from jousto.design.optimisation.problem import Problem
from jousto.design.optimisation.rigid_options import RigidMachine
from jousto.design.optimisation.rigid_outside import decoupled, optimise_outside

MACHINES = ("flexible", "rigid")
SAME = 1e-3
"""Relative difference of costs within which optima count as equal."""


@explained
def optimise(
    problem: Problem,
    method: Literal["esl", "direct"] = "esl",
    *,
    order: int = 1,
    tolerance: float = 1e-5,
    cycles: int = 50,
    screen: float = 0.7,
    trust: float | None = None,
    differences: float = 1e-5,
    report: Callable[[Cycle], None] | None = None,
    starts: int = 1,
    seed: int = 0,
    machine: Literal["flexible", "rigid"] | RigidMachine | None = None,
) -> Optimum:
    """Find the parameters of least cost that satisfy all limits at all instants of the motion.

    With equivalent static loads ``f(t) = K z(t)`` each cycle runs the machine once (order 0), or
    once and twice for each parameter (order 1), and then optimises a static problem. Order 0, the
    classical method, keeps the loads constant: its result is in general not an optimum of the
    moving machine (M. Stolpe, A. Verbart, S. Rojas-Labanda, Struct. Multidisc. Optim. 58 (2018)
    139-154). Order 1 linearises the loads in the design within a trust region: its result meets the
    optimality conditions. From an infeasible start it takes a few cycles of order 0 first.

    Parameters
    ----------
    problem : Problem
        Problem, such as a `MachineProblem`.
    method : {"esl", "direct"}
        Equivalent static loads, or direct optimisation of the transient by SLSQP with derivatives
        from runs.
    order : {0, 1}
        Order of the equivalent static loads.
    tolerance : float
        Largest step, as a share of the span of each parameter, at which the optimisation ends.
    cycles : int
        Largest number of cycles.
    screen : float
        Instants and places are included if their value is at least this share of the largest value
        of the same limit.
    trust : float, optional
        First size of the trust region as a share of the spans; by default 0.2 for order 1, and the
        whole span for order 0.
    differences : float
        Step of the differences over runs as a share of the spans.
    report : function, optional
        Function that is called with each `Cycle`.
    starts : int
        Number of starts: the parameter values, then points of a Latin hypercube in their bounds.
        Each start ends at a nearby optimum; the best is returned, and its message contains the
        spread of all.
    seed : int
        Seed of the hypercube.
    machine : {"flexible", "rigid"} or RigidMachine, optional
        "flexible" runs the machine with its flexible bodies. "rigid" makes all bodies rigid in an
        outer loop, and lets each flexible part vibrate alone under the loads of that run in an
        inner loop (Altarriba 2010, annex 1); `RigidMachine` has its options. None takes that of the
        model file, else "flexible".

    Returns
    -------
    Optimum
        Optimum with its history, active limits, and the KKT residual of the moving machine; a
        `RigidOptimum`, with the peaks of the flexible machine as well, for a rigid machine.

    Raises
    ------
    InputError
        If a limit names an unknown object, or an option is impossible; for a rigid machine without
        flexible bodies, or one that does not run, and for a part without limits.

    Warns
    -----
    JoustoWarning
        If the flexible machine exceeds limits that the parts alone keep.
    """
    problems, where = Problems(), "optimise"
    if method not in ("esl", "direct"):
        problems.add(where, f"method is {method!r}, must be 'esl' or 'direct'")
    if order not in (0, 1):
        problems.add(where, f"order is {order!r}, must be 0 or 1")
    problems.positive(where, "tolerance", tolerance, "")
    problems.number(where, "screen", screen, "", "from 0 to 1", lambda v: 0.0 <= v <= 1.0)
    problems.number(
        where, "differences", differences, "", "above 0 and up to 0.1", lambda v: 0.0 < v <= 0.1
    )
    radius = (0.2 if order else 1.0) if trust is None else trust
    problems.number(where, "trust", radius, "", "above 0 and up to 1", lambda v: 0.0 < v <= 1.0)
    problems.whole(where, "starts", starts)
    if cycles < 1:
        problems.add(where, f"cycles is {cycles}, must be 1 or more")
    options = machine_options(problems, problem.rigid, machine)
    problems.raise_if_any()
    problem.check()
    common: dict[str, Any] = {"tolerance": tolerance, "screen": screen, "size": differences}
    common |= {"cycles": cycles, "report": report}

    def inner(one: Problem, start: Array) -> Optimum:
        if method == "direct":
            return optimise_directly(one, start, **common)
        return optimise_by_loads(one, order, start, trust=radius, **common)

    def found(start: Array) -> Optimum:
        if options is None:
            return inner(problem, start)
        slopes = order == 1 or method == "direct"
        one = decoupled(problem, options)
        one.check()
        return optimise_outside(one, start, inner, slopes, differences)

    first = found(problem.start)
    if starts == 1:
        return first
    others: list[Optimum] = []
    failed = 0
    for u in qmc.LatinHypercube(len(problem.names), rng=seed).random(int(starts) - 1):
        try:
            others.append(found(problem.low + u * (problem.high - problem.low)))
        except JoustoError:
            failed += 1
    return best([first, *others], failed)


def machine_options(
    problems: Problems, of_problem: RigidMachine | None, given: Any
) -> RigidMachine | None:
    """Return the options of a rigid machine outside, None for the flexible machine.

    Parameters
    ----------
    problems : Problems
    of_problem : RigidMachine or None
        Options of the problem, such as those of a model file.
    given : {"flexible", "rigid"} or RigidMachine or None
        None takes those of the problem.
    """
    if given is None or isinstance(given, RigidMachine):
        return of_problem if given is None else given
    if given not in MACHINES:
        message = f"machine is {given!r}{suggest(given, MACHINES)}; or RigidMachine(...)"
        problems.add("optimise", message)
    if given != "rigid":
        return None
    return RigidMachine() if of_problem is None else of_problem


def best(optima: Sequence[Optimum], failed: int) -> Optimum:
    """Return the cheapest feasible optimum; its message states the spread of all costs.

    If no optimum is feasible, the one with the smallest violation is returned.
    """
    kept = [one for one in optima if one.kept]
    ended = [one for one in kept if one.converged] or kept
    least = min(ended, key=lambda one: one.cost) if kept else min(optima, key=lambda o: o.ratio)
    others = tuple(one for one in optima if one is not least)
    total = len(optima) + failed
    if kept:
        costs = [one.cost for one in ended]
        size = abs(least.cost) or 1.0
        same = sum(cost - least.cost <= SAME * size for cost in costs)
        spread = (
            f"; best of {total} starts: {same} ended within {SAME:.1%} of it, costs from "
            f"{min(costs):.6g} to {max(costs):.6g}"
        )
    else:
        spread = f"; none of {total} starts met the limits"
    left = total - len(ended)
    if kept and left:
        spread += f", {left} did not end at a design within the limits"
    return replace(least, message=least.message + spread, others=others)
