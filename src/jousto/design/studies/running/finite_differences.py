"""Derivatives of models that take real numbers only, by differences between two models."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from dataclasses import is_dataclass
from typing import Any

import numpy as np

from jousto.base.complexstep import STEP
from jousto.base.errors import NotAnalytic

WIDTH = 1e-3
"""Step relative to a parameter: wide enough for the rounding error of modes (order 4)."""
SMOOTH = 0.05
"""Second differences relative to the first up to which there is no kink or jump."""
ROUGH = 1e-5
"""Second differences relative to a number that count as curvature."""
TINY = 1e-12
"""SI magnitude of arrays below which they are rounding error and are not checked."""
STILL = ("Model.size", "StressModes.scatter")
"""Fields without influence on results: a scale of tolerances, notes on stress."""
CHANGED = "what is made changes its form with the parameter"


def difference_models(make: Callable[[float], Any], h: float) -> Any:
    """Return ``make(0)`` with its derivative, ``(8 (f1 - f-1) - (f2 - f-2)) / 12 h``.

    Parameters
    ----------
    make : callable
        Function of a change; returns dataclasses, tuples, arrays and numbers, of equal form at all
        five points.
    h : float
        The step.

    Raises
    ------
    NotAnalytic
        If the form changes, or numbers have kinks or jumps.
    """
    return _differentiate([make(k * h) for k in (0, 1, -1, 2, -2)], h)


def _differentiate(five: Sequence[Any], h: float) -> Any:
    """Return the first of five equal structures with its derivative; unchanged if it has none."""
    thing = five[0]
    if isinstance(thing, np.ndarray) or hasattr(thing, "tocsr"):
        return _differentiate_array(five, h)
    if isinstance(thing, float):
        if not all(isinstance(one, float) for one in five):
            raise NotAnalytic(CHANGED)
        return _differentiate_array([np.asarray(one, dtype=float) for one in five], h)
    if any(type(one) is not type(thing) for one in five):
        raise NotAnalytic(CHANGED)
    if isinstance(thing, tuple):
        if len({len(one) for one in five}) > 1:
            raise NotAnalytic(CHANGED)
        made = [_differentiate(items, h) for items in zip(*five, strict=True)]
        same = all(a is b for a, b in zip(made, thing, strict=True))
        return thing if same else type(thing)(made)
    if is_dataclass(thing) and not isinstance(thing, type):
        return _differentiate_fields(five, h)
    if isinstance(thing, (bool, int, str)) and any(one != thing for one in five):
        raise NotAnalytic(CHANGED)
    return thing


def _differentiate_fields(five: Sequence[Any], h: float) -> Any:
    thing = five[0]
    known = vars(thing)
    changed = {}
    for name in thing.__dataclass_fields__:
        if name not in known or f"{type(thing).__name__}.{name}" in STILL:
            continue
        values = [vars(one)[name] for one in five]
        if (found := _differentiate(values, h)) is not values[0]:
            changed[name] = found
    if not changed:
        return thing
    twin = copy.copy(thing)
    for name in set(known) - set(thing.__dataclass_fields__):
        vars(twin).pop(name, None)  # remove cached values that were computed from real numbers
    for name, value in changed.items():
        object.__setattr__(twin, name, value)
    return twin


def _differentiate_array(five: Sequence[Any], h: float) -> Any:
    """Return an array, sparse matrix or number with its derivative."""
    zero = five[0]
    if hasattr(zero, "tocsr"):
        if any(not _same_pattern(one, zero) for one in five):
            raise NotAnalytic(CHANGED)
        data = _differentiate_array([one.data for one in five], h)
        if data is zero.data:
            return zero
        twin = zero.astype(np.complex128)
        twin.data = data
        return twin
    if any(np.shape(one) != zero.shape for one in five):
        raise NotAnalytic(CHANGED)
    if zero.dtype.kind != "f":
        if any(not np.array_equal(one, zero) for one in five):
            raise NotAnalytic(CHANGED)
        return zero
    zero, up, down, far, near = five
    if all(np.array_equal(one, zero, equal_nan=True) for one in (up, down, far, near)):
        return zero[()] if not zero.shape else zero
    size, first = np.abs(zero).max(), np.abs(up - down).max()
    bend = np.abs(up + down - 2.0 * zero).max()
    twist = np.abs(far - near - 2.0 * (up - down)).max()
    if size > TINY and max(bend, twist) > SMOOTH * first + ROUGH * size:
        raise NotAnalytic("what is made has a kink or a jump there")
    slope = (8.0 * (up - down) - (far - near)) / (12.0 * h)
    return (zero + 1j * STEP * slope)[()]


def _same_pattern(a: Any, b: Any) -> bool:
    if type(a) is not type(b) or a.shape != b.shape or not hasattr(b, "indptr"):
        return False
    return np.array_equal(a.indptr, b.indptr) and np.array_equal(a.indices, b.indices)
