"""Checks of rigid stops and locks beside the other rows of a mechanism."""

from __future__ import annotations

from typing import Any

from jousto.base.errors import Problems
from jousto.mechanism.checks import drives_of, where
from jousto.mechanism.initial import Initial
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
    starts = {initial.coordinate.key: initial for initial in mechanism.initials}
    for row in mechanism.couplings:
        if not isinstance(row, SwitchedRow):
            continue
        _check_start(problems, row, starts.get(row.coordinate.key))
        s = row.coordinate
        if s.key in held:
            problems.add(
                where(row),
                f"{held[s.key]} {s.name}, and both cannot hold it; use an elastic Stop, "
                "law=Regularised(), or leave one out",
                "coordinate",
            )
        held.setdefault(s.key, f"{row.kind} {row.name!r} may hold")


def _check_start(problems: Problems, row: SwitchedRow, initial: Initial | None) -> None:
    """Report an initial value beyond the limits of a stop."""
    value: Any = None if initial is None else initial.value
    if initial is not None and value is not None and row.exceeded(value):
        problems.add(
            where(initial),
            f"value {value:g} is beyond a limit of {row.kind} {row.name!r}; start within them",
            "value",
        )
