"""Two nested loops: a rigid machine outside, its parts alone inside (Altarriba 2010, annex 1)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem as Trouble, count, warn
from jousto.design.optimisation import loads as esl
from jousto.design.optimisation.decoupled import Decoupled, DecoupledStructure
from jousto.design.optimisation.decoupled_machine import DecoupledMachine
from jousto.design.optimisation.limits import BodyLimit
from jousto.design.optimisation.machine import MachineProblem
from jousto.design.optimisation.methods import largest
from jousto.design.optimisation.optimum import Cycle, Optimum
from jousto.design.optimisation.problem import Problem
from jousto.design.optimisation.rigid_optimum import CARRIED, OuterCycle, Peak, RigidOptimum
from jousto.design.optimisation.rigid_options import RigidMachine
from jousto.design.optimisation.structure import StructureProblem

Inner = Callable[[Problem, Array], Optimum]


def decoupled(problem: Problem, options: RigidMachine) -> Decoupled:
    """Return the decoupled problem of a machine or structure.

    Raises
    ------
    InputError
        For other kinds of problems.
    """
    if isinstance(problem, MachineProblem):
        return DecoupledMachine(problem, options)
    if isinstance(problem, StructureProblem):
        return DecoupledStructure(problem, options)
    message = (
        f"machine='rigid' needs a MachineProblem or a StructureProblem, not a "
        f"{type(problem).__name__}"
    )
    raise InputError(Trouble("optimise", message))


def optimise_outside(
    one: Decoupled, start: Array, inner: Inner, slopes: bool, size: float
) -> RigidOptimum:
    """Return the optimum of a decoupled problem by outer and inner loops.

    Each outer cycle runs the rigid machine; it ends when the interface loads change by less than
    the tolerance (S9). Each inner optimisation ends by its own step (S17).

    Parameters
    ----------
    one : Decoupled
    start : (nd,) array
    inner : function
        Optimises a problem from a design.
    slopes : bool
        Whether the frozen loads follow the design to first order.
    size : float
        Step of differences as a share of the span of each parameter.
    """
    x, outer, history = start.copy(), list[OuterCycle](), list[Cycle]()
    ended = False
    found: Optimum | None = None
    for _ in range(one.options.cycles):
        moved = one.freeze(x)
        values, cost = one.values(x), one.cost(x)
        if found is not None and moved <= one.options.load_tolerance:
            ended = True
            outer.append(OuterCycle(values, cost, moved, 0, 0.0))
            break
        if slopes:
            one.follow(size)
        found = inner(one, x)
        x = one.vector(found.values)
        steps = [cycle.step for cycle in found.history]
        history += found.history
        outer.append(OuterCycle(values, cost, moved, len(steps), max(steps, default=0.0)))
    assert found is not None
    return compared(one, x, found, tuple(outer), tuple(history), ended)


def compared(
    one: Decoupled,
    x: Array,
    found: Optimum,
    outer: tuple[OuterCycle, ...],
    history: tuple[Cycle, ...],
    ended: bool,
) -> RigidOptimum:
    """Return the result at a design, with a run of the flexible machine beside it.

    Warns
    -----
    JoustoWarning
        If the flexible machine exceeds a limit.
    """
    own = esl.table_of(one, x)
    before = one.true.runs
    true = esl.table_of(one.true, x)
    flexible = one.true.runs - before
    carried = one.carriers(x)
    beside = one.other() if max(carried.values(), default=0.0) > CARRIED else None
    other = None if beside is None else esl.table_of(beside, x)
    peaks = peaks_of(one, x, own, true, other)
    inner = sum(cycle.inner for cycle in outer)
    message = f"{count(len(outer), 'outer cycle')}, {count(inner, 'inner cycle')}; the last loop "
    message += found.message
    if not ended:
        message += f"; the loads still change by {outer[-1].loads:.2g} after these outer cycles"
    given = {f.name: getattr(found, f.name) for f in fields(Optimum)}
    ratio = largest(true, one.fixed(x))
    given |= {
        "method": f"{found.method}, rigid outside",
        "ratio": ratio,
        "kkt": max(found.kkt, ratio - 1.0),
        "converged": found.converged and ended,
        "message": message,
        "runs": one.runs,
        "history": history,
    }
    made = RigidOptimum(
        **given,
        own_ratio=largest(own, one.fixed(x)),
        peaks=peaks,
        outer=outer,
        rigid_runs=one.rigid_runs,
        flexible_runs=flexible,
        carried=carried,
        springs=one.springs(x),
        held=one.options.held,
        beyond=one.options.beyond,
    )
    if not made.safe:
        warn("optimise", made.verdict)
    return made


def peaks_of(
    one: Decoupled, x: Array, own: esl.Table, true: esl.Table, other: esl.Table | None
) -> tuple[Peak, ...]:
    """Return the peaks of each limit in each load case."""
    cases = [motion.case for motion in one.motions(x)]
    found = []
    for i, (limit, motion, ratios) in enumerate(own):
        case = f" ({cases[motion]})" if cases[motion] else ""
        maximum, unit = limit_value(limit)
        held = None if other is None else float(other[i][2].max())
        pair = float(ratios.max()), float(true[i][2].max())
        found.append(Peak(limit.label + case, maximum, unit, *pair, held))
    return tuple(found)


def limit_value(limit: BodyLimit) -> tuple[float, str]:
    """Return the limit in its unit, or 1 for a limit without one."""
    kind = limit.fields.get("maximum")
    return (1.0, "") if kind is None else (float(vars(limit)["maximum"]), str(kind.unit))
