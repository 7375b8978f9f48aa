"""Checks of contacts before a run, and the report on them after it."""

from __future__ import annotations

from jousto.base.errors import warn
from jousto.model.model import Model
from jousto.model.native.native import Engine, refuse_dense
from jousto.simulation.contacts import contacts, resolved_by
from jousto.simulation.solvers.base import Solver

PROVEN = "missed: 0 (proven)"
"""Report of a run in which no contact can have been missed."""
SHOWN = 3
"""Largest number of steps that the report lists."""


def check_contacts(model: Model, solver: Solver, step: float) -> None:
    """Refuse an implicit method for more bodies that touch one another than its matrix couples.

    Warn of contacts at rest that are far stiffer than the step of an explicit method.
    """
    if solver.needs_tangent:
        refuse_dense(model)
    elif contacts(model):
        from jousto.simulation.running.closed_contacts import closed_contact_warning  # few need it

        if sentence := closed_contact_warning(model, solver, step):
            warn(f"simulate {model.name!r}", sentence)


def contact_facts(engine: Engine) -> dict[str, str]:
    """Return attributes of a run with contacts; none without them.

    "contacts": whether none can have been missed; "contact steps": how the parts of steps were
    proven; "short touches" of contacts with ``resolve="report"``: those of less than 10 steps.
    """
    forces = engine.model.forces
    if not any(force.law.yields and "approach" in force.state_names for force in forces):
        return {}
    facts = {"contacts": _missed(engine), "contact steps": _proof(engine)}
    if resolved_by(engine.model, "report"):
        facts["short touches"] = _short(engine)
    return facts


def _missed(engine: Engine) -> str:
    forces = engine.model.forces
    count, rows = engine.unproven()
    if not count:
        return PROVEN
    listed = []
    for time, index, _, _ in rows[:SHOWN].tolist():
        pair = f"'{forces[int(index)].name}'" if index >= 0 else "shapes that were not compared"
        listed.append(f"{pair} at {time:.6g} s")
    more = f" and {count - SHOWN} more" if count > SHOWN else ""
    return f"unproven: {count}, {', '.join(listed)}{more}; take a smaller step"


def _proof(engine: Engine) -> str:
    """Return how the parts of steps were proven to miss no contact."""
    proof = engine.proof
    return (
        f"{proof.at_once} at once, {proof.advanced} after halving (up to {proof.most} times), "
        f"{proof.events} up to an event"
    )


def _short(engine: Engine) -> str:
    """Return the number of touches that were too short for the step, and the first of them."""
    count, rows = engine.brief_touches()
    if not count:
        return "none"
    listed = []
    for time, state, duration in rows[:SHOWN].tolist():
        names = (f.name for f in engine.model.forces if 0 <= f.state <= state < f.state + f.states)
        listed.append(f"'{next(names)}' at {time:.6g} s lasts {1e3 * duration:.3g} ms")
    more = f" and {count - SHOWN} more" if count > SHOWN else ""
    return f"{count}: {', '.join(listed)}{more}; take a smaller step, or resolve='cut'"
