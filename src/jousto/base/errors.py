"""Errors and warnings: every problem with its place, its value and the remedy."""

from __future__ import annotations

import cmath
import difflib
import math
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from jousto.base.complexstep import floats, is_stepping, scalar

T = TypeVar("T")
FEW = 9  # numbers up to which those of Python are faster than those of NumPy
ASK_TRUST = (
    "which may do anything on this computer; if you trust the model file, run it with --trust "
    "(in Python: read_model(path, trust=True))"
)
"""End of the sentence about code that a model file names."""


def _again(kind: type[BaseException], args: tuple[Any, ...], facts: dict[str, Any]) -> Any:
    """Return an error made anew in another process, with all that it knows."""
    solid: Any = kind  # the exception of Python that decides how instances are laid out
    while solid.__module__ != "builtins":
        solid = solid.__base__
    error = solid.__new__(kind, *args)
    error.args = args
    error.__dict__.update(facts)
    return error


class JoustoError(Exception):
    """Base class of everything jousto raises on purpose; travels between processes."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args, self.__dict__)


class JoustoWarning(UserWarning):
    """A result is possible but probably not what was meant.

    Attributes
    ----------
    where : str
        Name of the object or place in a file, with which the text begins; empty for none.
    """

    where: str = ""


@dataclass(frozen=True)
class Problem:
    """One thing wrong with the input.

    Parameters
    ----------
    where : str
        Name of the object or place in a file (``"body 'arm'"``, ``"boom.yaml:18: joints.0.b"``).
    message : str
        What was found and what would be right.
    """

    where: str
    message: str

    def __str__(self) -> str:
        return f"{self.where}: {self.message}" if self.where else self.message


class InputError(JoustoError, ValueError):
    """The input cannot be used; all problems found are reported together. A `ValueError`, too.

    Attributes
    ----------
    problems : tuple of Problem
        In the order in which they were found.
    """

    def __init__(self, problems: Sequence[Problem] | Problem) -> None:
        self.problems = (problems,) if isinstance(problems, Problem) else tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


class CallError(InputError, TypeError):
    """A call with arguments that are missing, unknown or too many. A `TypeError`, too."""


class MissingFileError(InputError, FileNotFoundError):
    """A file that is asked for is not there. A `FileNotFoundError`, too."""


class UnknownNameError(InputError, KeyError):
    """A name that nothing has; close ones are suggested. A `KeyError`, too."""

    def __str__(self) -> str:
        return Exception.__str__(self)  # not the quoted text of a KeyError


class NotAnalytic(JoustoError):
    """Something that complex steps cannot differentiate; the message says what."""


class SimulationError(JoustoError):
    """A run failed; the results up to the failure are kept.

    Attributes
    ----------
    time : float
        Time of the failure in s.
    body : str
        Name of the body or joint that failed first, empty if none stands out.
    """

    def __init__(self, message: str, *, time: float, body: str = "") -> None:
        self.time = time
        self.body = body
        super().__init__(message)


class Problems:
    """Collects problems so that all of them are reported at once.

    Examples
    --------
    >>> problems = Problems()
    >>> problems.add("body 'arm'", "mass is -1 kg, must be positive")
    >>> problems.raise_if_any()
    Traceback (most recent call last):
        ...
    jousto.base.errors.InputError: body 'arm': mass is -1 kg, must be positive
    """

    def __init__(self) -> None:
        self.found: list[Problem] = []

    def add(self, where: str, message: str) -> None:
        """Note one problem."""
        self.found.append(Problem(where, message))

    def raise_if_any(self) -> None:
        """Raise InputError with everything noted so far, if there is anything."""
        if self.found:
            raise InputError(self.found)

    def positive(self, where: str, name: str, value: float, unit: str) -> None:
        """Note a problem unless the value is a finite number above zero."""
        self.number(where, name, value, unit, "a positive number", lambda x: x > 0.0)

    def number(
        self,
        where: str,
        name: str,
        value: Any,
        unit: str,
        wanted: str = "a finite number",
        good: Callable[[float], bool] = math.isfinite,
    ) -> bool:
        """Return whether the value is a finite number that is good, or note a problem."""
        try:
            wrong = str if is_stepping() else (str, complex)
            if isinstance(value, wrong) or np.ndim(value) != 0:
                raise TypeError
            x = scalar(value)
        except (TypeError, ValueError, OverflowError):
            self.add(where, f"{name} is {value!r}, must be {wanted}{unit and ' in '}{unit}")
            return False
        if not np.isfinite(x) or not good(x):
            found = f"{x:g} {unit}".rstrip()
            self.add(where, f"{name} is {found}, must be {wanted}")
            return False
        return True

    def whole(self, where: str, name: str, value: Any, least: int = 1, note: str = "") -> bool:
        """Return whether the value is a whole number from `least` on, or note a problem."""
        wanted = f"a whole number, {note or f'at least {least}'}"
        return self.number(where, name, value, "", wanted, lambda x: x >= least and x == int(x))

    def several(self, where: str, name: str, value: Any, kind: type[T]) -> tuple[T, ...]:
        """Return one object of a kind or a sequence of them as a tuple; note what is neither."""
        if isinstance(value, kind):
            return (value,)
        if isinstance(value, (str, Mapping)) or not isinstance(value, Iterable):
            self.add(where, f"{name} is {value!r}, must be a sequence of {kind.__name__}")
            return ()
        items = tuple(value)
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        for i, item in enumerate(items):
            if not isinstance(item, kind):
                self.add(where, f"{name}[{i}] is {item!r}, must be {article} {kind.__name__}")
        return tuple(item for item in items if isinstance(item, kind))

    def array(
        self, where: str, name: str, value: Any, shape: tuple[int | None, ...]
    ) -> NDArray[np.float64] | None:
        """Return a read-only float copy, or note why it is not a finite array of that shape.

        None in the shape allows any length.
        """
        try:
            # the same but for numbers with derivatives
            array = np.array(floats(value)) if is_stepping() else np.array(value, np.float64)
        except (TypeError, ValueError, OverflowError):
            if shape:
                wanted = _shape(shape)
                self.add(where, f"{name} is not an array of numbers of shape {wanted}")
            else:
                self.add(where, f"{name} is {value!r}, must be a number")
            return None
        if array.shape != shape and (
            array.ndim != len(shape)
            or any(n is not None and n != m for n, m in zip(shape, array.shape, strict=True))
        ):
            self.add(where, f"{name} has shape {array.shape}, must be {_shape(shape)}")
            return None
        if array.size <= FEW:
            finite = all(map(cmath.isfinite, array.ravel().tolist()))
        else:
            finite = bool(np.isfinite(array).all())
        if not finite:
            index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
            place = list(index) if index else ""
            self.add(where, f"{name}{place} is {array[index]}, must be finite")
            return None
        array.setflags(write=False)
        return array


def _shape(shape: tuple[int | None, ...]) -> str:
    """Return a shape for messages, ``(any, 3)``."""
    return "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"


def suggest(name: object, candidates: Iterable[str]) -> str:
    """Return the tail of an error sentence: the nearest known name, or all known names.

    Examples
    --------
    >>> suggest("bom", ["boom", "ground"])
    "; did you mean 'boom'?"
    """
    # the names that the user gave come before those that number the nodes
    known = sorted(candidates, key=lambda known: bool(re.fullmatch(r"n(ode)?\d+", known)))
    near = difflib.get_close_matches(str(name), known, n=1)
    if not near:  # of other letters, such as PID for pid
        small = {one.lower(): one for one in known}
        near = [small[x] for x in difflib.get_close_matches(str(name).lower(), small, n=1)]
    if near:
        return f"; did you mean '{near[0]}'?"
    if not known:
        return "; there are none"
    shown = ", ".join(known[:8]) + (", ..." if len(known) > 8 else "")
    return f"; known: {shown}"


def warn(where: str, message: str) -> None:
    """Issue a JoustoWarning that reads like a Problem and points at the code that uses jousto."""
    level = 2
    frame = sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").split(".")[0] == "jousto":
        frame = frame.f_back
        level += 1
    warning = JoustoWarning(f"{where}: {message}" if where else message)
    warning.where = where
    warnings.warn(warning, stacklevel=level)


LARGE_STRAIN = 0.01
"""m/m: what is beyond was likely given in another unit; foil and steel are long past use."""


def likely_strain_unit(size: float) -> str:
    """Return in which unit a strain was likely given that is too large for m/m.

    >>> likely_strain_unit(0.05), likely_strain_unit(10.57)
    ('%', 'um/m')
    """
    return "%" if size <= 1.0 else "um/m"


def strain_remedy(size: float) -> str:
    """Return likely unit and remedy of a strain that is too large for m/m."""
    return "percent: divide by 100" if size <= 1.0 else "um/m: divide by 1e6"


def count(number: int, noun: str) -> str:
    """Return ``1 mode`` or ``2 modes``."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
