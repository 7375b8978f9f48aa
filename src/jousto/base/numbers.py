"""What all declarations share: setting frozen fields and checking names."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.errors import Problems


def set_fields(target: Any, **values: Any) -> None:
    """Set the fields of a frozen dataclass from its constructor."""
    for key, value in values.items():
        object.__setattr__(target, key, value)


def number(problems: Problems, where: str, name: str, value: Any) -> float | None:
    """Return a finite float, or note why the value is none."""
    try:
        if isinstance(value, str):
            raise TypeError
        array = np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    if array.shape != ():
        problems.add(where, f"{name} is {value!r}, must be a number")
        return None
    if not np.isfinite(array):
        problems.add(where, f"{name} is {float(array):g}, must be finite")
        return None
    return float(array)
