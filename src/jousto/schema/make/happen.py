"""Events in the model file: what they watch, and when they are built."""

from __future__ import annotations

from typing import Any


def is_late(entry: Any, joints: dict[str, Any]) -> bool:
    """Return whether a sensor can only be built after forces and couplings."""
    if entry.declared.late or getattr(entry, "temperature", None) is not None:
        return True
    return hasattr(entry, "joint") and entry.joint not in joints


def watches_late(entry: Any, late: set[str]) -> bool:
    """Return whether an event watches a late sensor."""
    return isinstance(entry.watch, str) and entry.watch in late
