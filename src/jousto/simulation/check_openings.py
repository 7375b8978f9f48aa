"""Check of valves that pressures open: a step shall not open them by more than a part."""

from __future__ import annotations

from jousto.model.native.native import Engine

PART = 0.5
"""Largest change of an opening in a step, 1: from closed to open, that a step follows."""
SHOWN = 3
"""Largest number of valves in the warning."""


def opening_facts(engine: Engine, step: float) -> dict[str, str]:
    """Return the warning as an attribute of the run, which `doctor` repeats; none without it."""
    sentence = _warning(engine, step)
    return {"openings": sentence} if sentence else {}


def _warning(engine: Engine, step: float) -> str:
    """Return the warning for valves that opened or closed within few steps; empty if none did.

    The matrix of ROS2 contains the slope of a flow at the start of a step: where a valve opens
    within the step, that slope is the one of a closed valve. Stages count, since a valve may open
    in the second stage of each step and be closed at the end of all steps.
    Implicit methods weigh the flows at both ends of a step, neither of which is the one between.
    """
    names = [name for force in engine.model.forces for name in force.openings]
    if not names:
        return ""
    found = sorted(zip(engine.openings().tolist(), names, strict=True), reverse=True)
    fast = [(change, time, name) for (change, time), name in found if change > PART]
    if not fast:
        return ""
    listed = [f"{name} by {100 * x:.0f} % at {time:.4g} s" for x, time, name in fast[:SHOWN]]
    more = f" and {len(fast) - SHOWN} more" if len(fast) > SHOWN else ""
    return (
        f"valves open or close within a step of {step:.3g} s: {', '.join(listed)}{more}; flows and "
        f"pressures may be wrong by per cents there; take steps of {step / 4:.2g} s or widen the "
        "pressure in brackets, and compare"
    )
