"""Values of requests of the page, with checks of their types."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem

MOST_NAMES = 64  # sensors or measures in a request
LONGEST_NAME = 1000


class Request:
    """Values of a request; a wrong one raises InputError with its name.

    Examples
    --------
    >>> Request({"body": 2}).whole("body", 5)
    2
    >>> Request({"body": 7}).whole("body", 5)
    Traceback (most recent call last):
    ...
    jousto.base.errors.InputError: request: body is 7, must be a whole number from 0 to 4
    """

    def __init__(self, given: Mapping[str, Any]) -> None:
        self._given = given

    def whole(self, name: str, below: int, *, least: int = 0, default: int | None = None) -> int:
        """Return a whole number in [least, below)."""
        value = self._given.get(name, default)
        if isinstance(value, bool) or not isinstance(value, int) or not least <= value < below:
            span = f"from {least} to {below - 1}" if below > least else "of which there is none"
            raise _wrong(name, value, f"a whole number {span}")
        return value

    def number(self, name: str) -> float:
        """Return a number."""
        value = self._given.get(name)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise _wrong(name, value, "a number")
        try:
            found = float(value)
        except OverflowError:
            found = math.inf
        if not math.isfinite(found):
            raise _wrong(name, "too large", "a number")
        return found

    def vector(self, name: str) -> Array:
        """Return three numbers."""
        value = self._given.get(name)
        if not isinstance(value, list) or len(value) != 3:
            raise _wrong(name, value, "three numbers")
        return np.array([Request({name: x}).number(name) for x in value])

    def name(self, name: str) -> str:
        """Return a text."""
        value = self._given.get(name)
        if not isinstance(value, str) or len(value) > LONGEST_NAME:
            raise _wrong(name, value, "a text")
        return value

    def names(self, name: str) -> list[str]:
        """Return texts."""
        value = self._given.get(name)
        good = isinstance(value, list) and 0 < len(value) <= MOST_NAMES
        if not good or not all(isinstance(x, str) and len(x) <= LONGEST_NAME for x in value):  # type: ignore[union-attr]
            raise _wrong(name, value, f"a list of 1 to {MOST_NAMES} texts")
        return list(value)  # type: ignore[arg-type]


def _wrong(name: str, value: Any, wanted: str) -> InputError:
    text = repr(value)
    shown = text if len(text) < 60 else f"{text[:57]}..."
    return InputError(Problem("request", f"{name} is {shown}, must be {wanted}"))
