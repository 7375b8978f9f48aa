"""Checks of rigid stops and locks beside the other rows of a mechanism."""

from __future__ import annotations

from typing import Any

from jousto.base.errors import Problems
from jousto.mechanism.checks import drives_of, where
from jousto.mechanism.items_by_kind import Members
from jousto.mechanism.joints.switched import SwitchedRow


def check_switched(problems: Problems, mechanism: Members) -> None:
    """Report stops and locks on a coordinate that another row may hold at the same time."""
    held: dict[Any, str] = {}
    for drive in drives_of(mechanism):
        held[drive.coordinate.key] = f"drive {drive.name!r} prescribes"
    for friction in mechanism.frictions:
        if friction.law.sticks:
            for s in friction.coordinates:
                held.setdefault(s.key, f"stick-slip friction {friction.name!r} may hold")
    for row in mechanism.couplings:
        if not isinstance(row, SwitchedRow):
            continue
        s = row.coordinate
        if s.key in held:
            problems.add(
                where(row),
                f"{held[s.key]} {s.name}, and both cannot hold it; use an elastic Stop, "
                "law=Regularised(), or leave one out",
                "coordinate",
            )
        held.setdefault(s.key, f"{row.kind} {row.name!r} may hold")
