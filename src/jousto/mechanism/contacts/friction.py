"""Coefficients of friction of contacts."""

from __future__ import annotations

from typing import Any


def default_static(item: Any) -> None:
    """Let the coefficient up to which an item sticks be that of its slip, where none is given."""
    if item.mu_static is None:
        object.__setattr__(item, "mu_static", item.mu_kinetic)
