"""What is wrong with the contacts of a run: too few steps, too deep, wrong restitution, missed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

FEW = 10
"""Steps of a contact below which its restitution is wrong by more than 0.004 (RK4, ROS2: 0.03)."""
ADVISED = 20
"""Steps that a contact should have."""
MISSED = 0.05
"""Difference of the restitution from that which is asked for, above which it is reported."""
QUICK = 20.0
"""Speed of approach over the speed that gravity gives in the same time, for a free rebound."""


def contact_findings(events: Sequence[Any], pairs: Sequence[Any], run: Any) -> tuple[str, ...]:
    """Return a sentence on each finding, with the remedy.

    Parameters
    ----------
    events : sequence of ContactEvent
        Contacts of the run.
    pairs : sequence of Pair
        The pair of each.
    run : Solution
        The run.
    """
    found = [_few_steps(events, pairs), _deep(events, pairs), _restitution(events, pairs, run)]
    proof = str(run.attributes.get("contacts", ""))
    if proof.startswith("unproven"):
        found.append(f"contacts may have been missed: {proof}")
    dropped = getattr(events, "dropped", 0)
    if dropped:
        found.append(
            f"{dropped} further contacts are not in the results and not in these findings; run "
            "shorter parts of the time"
        )
    return tuple(filter(None, found))


def _name(event: Any) -> str:
    return f"'{event.contact}' ({event.a} - {event.b})"


def _rebounds(event: Any, pair: Any) -> bool:
    """Whether a contact is a rebound that has the restitution of its law, not rest."""
    faster = pair.slowest is not None and event.approach > pair.slowest
    return bool(faster and np.isfinite(event.part))


def _few_steps(events: Sequence[Any], pairs: Sequence[Any]) -> str:
    """Report rebounds with fewer than `FEW` steps."""
    both = zip(events, pairs, strict=True)
    few = [one for one, pair in both if one.steps < FEW and _rebounds(one, pair)]
    if not few:
        return ""
    worst = min(few, key=lambda one: one.steps)
    step = (worst.part - worst.touch) / ADVISED
    return (
        f"{len(few)} of {len(events)} contacts had fewer than {FEW} steps, the fewest "
        f"{worst.steps} of {_name(worst)} at {worst.touch:.6g} s: their restitution "
        f"is not accurate; take events='located', or a step of {step:.2g} s"
    )


def _deep(events: Sequence[Any], pairs: Sequence[Any]) -> str:
    """Report the deepest contact over the size of its smaller shape."""
    from jousto.model.overlaps import DEEP

    sizes = np.array([pair.thickness for pair in pairs])
    depths = np.array([event.depth for event in events])
    if not (sizes > 0.0).any():
        return ""
    share = np.where(sizes > 0.0, depths / np.where(sizes > 0.0, sizes, 1.0), 0.0)
    k = int(np.argmax(share))
    if share[k] <= DEEP:
        return ""
    beyond = ", beyond its middle" if share[k] > 0.5 else ""
    return (
        f"{_name(events[k])} was {depths[k]:.3g} m deep at a size of {sizes[k]:.3g} m{beyond}; "
        f"take a stiffer law, some {(share[k] / (0.2 * DEEP)) ** 1.5:.2g} times"
    )


def _restitution(events: Sequence[Any], pairs: Sequence[Any], run: Any) -> str:
    """Report the free rebound whose restitution is farthest from that asked for."""
    gravity = float(np.linalg.norm(run.attributes.get("gravity", np.zeros(3))))
    worst, most = None, MISSED
    for event, pair in zip(events, pairs, strict=True):
        duration = event.part - event.touch
        free = _rebounds(event, pair) and event.approach > QUICK * gravity * duration
        # a rebound that is faster than the approach has another cause
        if not (pair.restitution and free and 0.0 < event.rebound <= event.approach):
            continue
        missed = abs(event.rebound / event.approach - pair.restitution)
        if missed > most:
            worst, most = (event, pair.restitution), missed
    if worst is None:
        return ""
    event, asked = worst
    return (
        f"{_name(event)} rebounded with {event.rebound / event.approach:.3g} of its speed at "
        f"{event.touch:.6g} s, a restitution of {asked:g} is asked for; with {event.steps} steps "
        + (
            "it needs a smaller step"
            if event.steps < FEW
            else "the cause is another force at the same time: look at both bodies then"
        )
    )
