"""Events in the model file: what they watch, and when they are built."""

from __future__ import annotations

from typing import Any

# sensors that stand on forces, couplings or signals, which events may switch, or on other sensors:
# they come after
LATE = ("force", "signal", "damage", "bridge")


def is_late(entry: Any, joints: dict[str, Any]) -> bool:
    """Return whether a sensor can only be built after forces and couplings."""
    kind = getattr(entry, "type", "")
    if getattr(entry, "temperature", None) is not None:
        return True
    return kind in LATE or (kind == "reaction" and entry.joint not in joints)


def watches_late(entry: Any, late: set[str]) -> bool:
    """Return whether an event watches a late sensor."""
    return isinstance(entry.watch, str) and entry.watch in late
