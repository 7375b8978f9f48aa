"""Checks of contacts before a run, and the report on them after it."""

from __future__ import annotations

from jousto.model.model import Model
from jousto.model.native.native import Engine, refuse_dense
from jousto.simulation.solvers.base import Solver

PROVEN = "missed: 0 (proven)"
"""Report of a run in which no contact can have been missed."""
SHOWN = 3
"""Largest number of steps that the report lists."""


def check_contacts(model: Model, solver: Solver) -> None:
    """Refuse an implicit method for more bodies that touch one another than its matrix couples."""
    if solver.needs_tangent:
        refuse_dense(model)


def contact_facts(engine: Engine) -> dict[str, str]:
    """Return the attribute "contacts" of a run: whether no contact can have been missed.

    Empty without contacts.
    """
    forces = engine.model.forces
    if not any(force.law.yields and "approach" in force.state_names for force in forces):
        return {}
    count, rows = engine.unproven()
    if not count:
        return {"contacts": PROVEN}
    listed = []
    for time, index, _, _ in rows[:SHOWN].tolist():
        pair = f"'{forces[int(index)].name}'" if index >= 0 else "shapes that were not compared"
        listed.append(f"{pair} at {time:.6g} s")
    more = f" and {count - SHOWN} more" if count > SHOWN else ""
    return {"contacts": f"unproven: {count}, {', '.join(listed)}{more}; take a smaller step"}
