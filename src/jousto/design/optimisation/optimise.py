"""Optimise: the least cost within limits of stress, displacement, life and frequency."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

from jousto.base.arguments import explained
from jousto.base.errors import Problems
from jousto.design.optimisation.methods import by_loads, directly
from jousto.design.optimisation.optimum import Cycle, Optimum
from jousto.design.optimisation.problem import Problem


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
) -> Optimum:
    """Find the parameters of least cost that keep all limits at all instants of the motion.

    With equivalent static loads ``f(t) = K z(t)`` each cycle runs the machine once (order 0), or
    once and twice for each parameter (order 1), and then optimises statics alone. Order 0, the
    classical method, freezes the loads: where it ends is in general not an optimum of the moving
    machine (M. Stolpe, A. Verbart, S. Rojas-Labanda, Struct. Multidisc. Optim. 58 (2018) 139-154).
    Order 1 lets the loads follow the design to first order within a trust region: where it ends
    the conditions of an optimum hold. From a start that exceeds limits it takes a few cycles of
    order 0 first.

    Parameters
    ----------
    problem : Problem
        Such as `MachineProblem`.
    method : {"esl", "direct"}
        Equivalent static loads, or the transient itself by SLSQP with slopes from runs.
    order : {0, 1}
        Of equivalent static loads.
    tolerance : float
        Largest step, as a share of the span of each parameter, that ends.
    cycles : int
        Most cycles.
    screen : float
        Instants and places count whose value is at least this share of the largest of its limit.
    trust : float, optional
        First size of the trust region as a share of the spans; 0.2 for order 1, the whole for
        order 0.
    differences : float
        Step of the differences over runs as a share of the spans.
    report : function, optional
        Is called with each `Cycle`.

    Returns
    -------
    Optimum
        With its history, what is active, and the KKT residual of the moving machine.

    Raises
    ------
    InputError
        If limits name what is not there, or an option is impossible.
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
    if cycles < 1:
        problems.add(where, f"cycles is {cycles}, must be 1 or more")
    problems.raise_if_any()
    problem.check()
    common = {"tolerance": tolerance, "screen": screen, "size": differences}
    if method == "direct":
        return directly(problem, cycles=cycles, report=report, **common)
    return by_loads(problem, order, cycles=cycles, trust=radius, report=report, **common)
