"""What all declarations share: setting frozen fields and checking names."""

from __future__ import annotations

import unicodedata
from typing import Any

import numpy as np

from jousto.errors import Problems


def check_name(problems: Problems, kind: str, name: Any) -> str:
    """Return where-text such as ``body 'arm'`` and note what is wrong with the name.

    Names end up in messages, in labels such as ``arm.tip`` and in HDF5 paths.
    """
    where = f"{kind} {name!r}"
    if not isinstance(name, str):
        problems.add(where, "name must be a string")
    elif not name.strip() or name != name.strip():
        problems.add(where, "name must not be empty or start or end with a blank")
    else:
        forbidden = [c for c in ("./" if kind == "body" else "/") if c in name]
        if forbidden:
            problems.add(where, f"name must not contain {forbidden[0]!r}")
        elif name in (".", ".."):
            problems.add(where, "name must not be '.' or '..'")
        elif any(unicodedata.category(c) in ("Cc", "Cs") for c in name):
            problems.add(where, "name must not contain control characters")
        elif kind == "body" and name == "ground":
            problems.add(where, "the name 'ground' is taken by the ground")
    return where


def set_fields(target: Any, **values: Any) -> None:
    """Set the fields of a frozen dataclass from its constructor."""
    for key, value in values.items():
        object.__setattr__(target, key, value)


def number(problems: Problems, where: str, name: str, value: Any) -> float | None:
    """Return a finite float, or note why the value is none."""
    try:
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
