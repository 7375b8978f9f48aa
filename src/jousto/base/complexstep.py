"""Complex steps: the imaginary part of a number is its derivative by one parameter, times the step.

``df/dx = Im f(x + i h) / h`` has neither truncation nor cancellation (Squire and Trapp, SIAM Rev.
40, 1998). Outside of `stepping` no field accepts a complex number. Inside, numbers independent of
the parameter are real; comparisons use real parts.
"""

from __future__ import annotations

import copy
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import is_dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

STEP = 1e-30
"""Imaginary step; its square is negligible against every real part."""

_ACTIVE: ContextVar[bool] = ContextVar("complex step", default=False)
is_stepping = _ACTIVE.get
"""Whether complex numbers are accepted in this context."""


@contextmanager
def stepping() -> Iterator[None]:
    """Accept complex numbers within the block; it is an error to drop an imaginary part."""
    token = _ACTIVE.set(True)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", np.exceptions.ComplexWarning)
            yield
    finally:
        _ACTIVE.reset(token)


@contextmanager
def plainly() -> Iterator[None]:
    """Reject complex numbers within the block."""
    token = _ACTIVE.set(False)
    try:
        yield
    finally:
        _ACTIVE.reset(token)


def scalar(x: Any) -> float:
    """Return a float, or a complex number with its derivative while `stepping`."""
    if _ACTIVE.get() and isinstance(x, (complex, np.ndarray)) and np.iscomplexobj(x):
        made: Any = np.complex128(x)
        return made if made.imag else float(made.real)
    return float(x)


def floats(x: Any) -> NDArray[np.float64]:
    """Return an array of floats, or of complex numbers with derivatives while `stepping`."""
    if not _ACTIVE.get():
        return np.asarray(x, dtype=np.float64)
    array: Any = np.asarray(x)
    if array.dtype.kind != "c":
        return np.asarray(array, dtype=np.float64)
    made: Any = array.astype(np.complex128, copy=False) if array.imag.any() else array.real.copy()
    return made  # type: ignore[no-any-return]


def stepped(*arrays: Any) -> bool:
    """Return whether any of the arrays has derivatives, that is, complex numbers."""
    return _ACTIVE.get() and any(np.iscomplexobj(x) for x in arrays)


def parts(x: Any) -> tuple[Any, Any]:
    """Return the values, and the derivatives times `STEP`, of a number, array or sparse matrix."""
    return x.real, (x.imag if np.iscomplexobj(x) else 0.0 * x)


def real_parts(thing: Any, along: float = 0.0) -> Any:
    """Return an object without derivatives; the same object if it has none.

    Its numbers are the real parts, plus the derivatives times `along`.
    """
    if isinstance(thing, np.ndarray) or hasattr(thing, "tocsr"):
        if thing.dtype.kind != "c":
            return thing
        return thing.real + along / STEP * thing.imag if along else thing.real.copy()
    if isinstance(thing, complex):
        return float(thing.real + along / STEP * thing.imag)
    if isinstance(thing, tuple):
        made = [real_parts(item, along) for item in thing]
        same = all(a is b for a, b in zip(made, thing, strict=True))
        return thing if same else type(thing)(made)
    if not is_dataclass(thing) or isinstance(thing, type):
        return thing
    changed = {}
    for name, value in vars(thing).items():
        if (found := real_parts(value, along)) is not value:
            changed[name] = found
    if not changed:
        return thing
    twin = copy.copy(thing)
    for name, value in changed.items():
        object.__setattr__(twin, name, value)
    return twin


class SteppedText(str):
    """Quantity as text, such as ``0.004 m``, with the derivative of its number.

    Parameters
    ----------
    text : str
        Quantity.
    slope : float
        Derivative of the number in the text, times `STEP`.
    """

    slope: float

    def __new__(cls, text: str, slope: float) -> SteppedText:
        """Return the text with its slope."""
        made = super().__new__(cls, text)
        made.slope = slope
        return made

    def __repr__(self) -> str:
        return f"{super().__repr__()} with slope {self.slope!r}"


def power(x: Any, y: Any) -> Any:
    """Return ``x ** y`` for real exponents, differentiable; x may be negative."""
    if not stepped(x, y):
        return x**y
    (x0, dx), (y0, dy) = parts(np.asarray(x)), parts(np.asarray(y))
    found = x0[()] ** y0[()]
    slope = y0 * x0 ** (y0 - 1.0) * dx if np.any(dx) else 0.0
    return np.complex128(found + 1j * (slope + (found * np.log(x0) * dy if np.any(dy) else 0.0)))


def norm(x: NDArray[Any], axis: int | None = None) -> Any:
    """Return the Euclidean norm, differentiable where it is not zero."""
    if x.dtype.kind != "c":
        return np.linalg.norm(x, axis=axis)
    size = np.linalg.norm(x.real, axis=axis)
    change = np.sum(x.real * x.imag, axis=axis)
    straight = np.linalg.norm(
        x.imag, axis=axis
    )  # at zero: one-sided derivative in the direction of the step
    slope = np.where(size > 0.0, change / np.where(size > 0.0, size, 1.0), straight)
    return size + 1j * slope


def arctan2(y: Any, x: Any) -> Any:
    """Return the angle of (x, y), differentiable."""
    if not stepped(y, x):
        return np.arctan2(y, x)
    (y0, dy), (x0, dx) = parts(np.asarray(y)), parts(np.asarray(x))
    return (np.arctan2(y0, x0) + 1j * (x0 * dy - y0 * dx) / (x0 * x0 + y0 * y0))[()]


def magnitude(x: Any) -> Any:
    """Return ``|x|``, differentiable where it is not zero."""
    return np.where(np.real(x) < 0.0, -x, x)[()] if stepped(x) else np.abs(x)
