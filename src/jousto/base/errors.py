"""Errors and warnings: every problem with place, value and remedy."""

from __future__ import annotations

import cmath
import difflib
import math
import re
import sys
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from jousto.base.complexstep import floats, is_stepping, scalar

T = TypeVar("T")
Path: TypeAlias = tuple[str | int, ...]
FEW = 9  # size up to which Python numbers are faster than NumPy arrays
ASK_TRUST = (
    "which may do anything on this computer; if you trust the model file, run it with --trust "
    "(in Python: read_model(path, trust=True))"
)
"""End of the message about code referenced by a model file."""


def _again(kind: type[BaseException], args: tuple[Any, ...], facts: dict[str, Any]) -> Any:
    """Return an error recreated in another process, with all its attributes."""
    solid: Any = kind  # built-in exception that determines the memory layout
    while solid.__module__ != "builtins":
        solid = solid.__base__
    error = solid.__new__(kind, *args)
    error.args = args
    error.__dict__.update(facts)
    return error


class JoustoError(Exception):
    """Base class of the errors of jousto; can be pickled."""

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), self.args, self.__dict__)


class JoustoWarning(UserWarning):
    """Warning: a result is possible, but the input is probably wrong.

    Attributes
    ----------
    where : str
        Name of the object or place in a file, the prefix of the text; empty for none.
    message : str
        The text without it.
    path : tuple of (str or int)
        Path of the field that the warning concerns, as for `Problem`.
    """

    where: str = ""
    message: str = ""
    path: Path = ()

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.message = text


@dataclass(frozen=True)
class Problem:
    """Problem found in the input.

    Parameters
    ----------
    where : str
        Name of the object or place in a file (``"body 'arm'"``, ``"boom.yaml:18: joints.0.b"``).
    message : str
        What is wrong, and what is allowed.
    path : tuple of (str or int)
        Path of the field that the problem concerns, from the outermost field to the innermost item:
        ``("limit",)``, ``("points", 3)``; empty if it concerns no single field.
    named : bool
        Whether the message names the field; if not, the path is put before the message.
    """

    where: str
    message: str
    path: Path = field(default=(), kw_only=True, compare=False, repr=False)
    named: bool = field(default=True, kw_only=True, compare=False, repr=False)

    def __str__(self) -> str:
        return f"{self.where}: {self.sentence}" if self.where else self.sentence

    @property
    def sentence(self) -> str:
        """The message, preceded by the field unless the message names it."""
        return self.message if self.named else f"{'.'.join(map(str, self.path))}: {self.message}"

    def inside(self, where: str, *path: str | int, named: bool = False) -> Problem:
        """Return the same problem for the larger object that has the object as a field or item."""
        text = self.sentence if self.where in path[-1:] else str(self)
        return Problem(where, text, path=(*path, *self.path), named=named)


class InputError(JoustoError, ValueError):
    """Error: the input cannot be used; contains all problems. Also a `ValueError`.

    Attributes
    ----------
    problems : tuple of Problem
        Problems in the order of detection.
    """

    def __init__(self, problems: Sequence[Problem] | Problem) -> None:
        self.problems = (problems,) if isinstance(problems, Problem) else tuple(problems)
        super().__init__("\n".join(str(problem) for problem in self.problems))


class CallError(InputError, TypeError):
    """Error: missing, unknown or superfluous arguments of a call. Also a `TypeError`."""


class MissingFileError(InputError, FileNotFoundError):
    """Error: a file does not exist. Also a `FileNotFoundError`."""


class UnknownNameError(InputError, KeyError):
    """Error: an unknown name, with similar ones. Also a `KeyError`."""

    def __str__(self) -> str:
        return Exception.__str__(self)  # not the quoted text of a KeyError


class NotAnalytic(JoustoError):
    """Error: a quantity that complex steps cannot differentiate; the message contains it.

    Attributes
    ----------
    noisy : bool
        Whether decisions within a run, such as the number of its steps, add noise of the size of
        its errors.
    """

    def __init__(self, message: str, *, noisy: bool = False) -> None:
        super().__init__(message)
        self.noisy = noisy


class SimulationError(JoustoError):
    """Error: a run failed; the results up to the failure are available.

    Attributes
    ----------
    time : float
        Time of the failure in s.
    body : str
        Name of the body or joint that failed first, empty if unknown.
    """

    def __init__(self, message: str, *, time: float, body: str = "") -> None:
        self.time = time
        self.body = body
        super().__init__(message)


class Problems:
    """Collection of problems, to report all of them together.

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

    def add(self, where: str, message: str, *path: str | int, named: bool = True) -> None:
        """Add a problem with the path of the field that it concerns; see `Problem`."""
        self.found.append(Problem(where, message, path=path, named=named))

    def raise_if_any(self) -> None:
        """Raise InputError with all problems, if there are any."""
        if self.found:
            raise InputError(self.found)

    def positive(self, where: str, name: str, value: float, unit: str) -> None:
        """Add a problem unless the value is a finite number above zero."""
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
        """Return whether the value is a finite, valid number, or add a problem."""
        try:
            wrong = str if is_stepping() else (str, complex)
            if isinstance(value, wrong) or np.ndim(value) != 0:
                raise TypeError
            x = scalar(value)
        except (TypeError, ValueError, OverflowError):
            self.add(where, f"{name} is {value!r}, must be {wanted}{unit and ' in '}{unit}", name)
            return False
        if not np.isfinite(x) or not good(x):
            found = f"{x:g} {unit}".rstrip()
            self.add(where, f"{name} is {found}, must be {wanted}", name)
            return False
        return True

    def whole(self, where: str, name: str, value: Any, least: int = 1, note: str = "") -> bool:
        """Return whether the value is a whole number from `least` on, or add a problem."""
        wanted = f"a whole number, {note or f'at least {least}'}"
        return self.number(where, name, value, "", wanted, lambda x: x >= least and x == int(x))

    def several(self, where: str, name: str, value: Any, kind: type[T]) -> tuple[T, ...]:
        """Return one object or a sequence of a kind as a tuple; add problems for other values."""
        if isinstance(value, kind):
            return (value,)
        if isinstance(value, (str, Mapping)) or not isinstance(value, Iterable):
            self.add(where, f"{name} is {value!r}, must be a sequence of {kind.__name__}", name)
            return ()
        items = tuple(value)
        article = "an" if kind.__name__[0] in "AEIOU" else "a"
        for i, item in enumerate(items):
            if not isinstance(item, kind):
                message = f"{name}[{i}] is {item!r}, must be {article} {kind.__name__}"
                self.add(where, message, name, i)
        return tuple(item for item in items if isinstance(item, kind))

    def array(
        self, where: str, name: str, value: Any, shape: tuple[int | None, ...]
    ) -> NDArray[np.float64] | None:
        """Return a read-only float copy; add a problem unless it is finite and has the shape.

        None in the shape allows any length.
        """
        try:
            # the same for numbers with derivatives
            array = np.array(floats(value)) if is_stepping() else np.array(value, np.float64)
        except (TypeError, ValueError, OverflowError):
            if shape:
                wanted = _shape(shape)
                self.add(where, f"{name} is not an array of numbers of shape {wanted}", name)
            else:
                self.add(where, f"{name} is {value!r}, must be a number", name)
            return None
        if array.shape != shape and (
            array.ndim != len(shape)
            or any(n is not None and n != m for n, m in zip(shape, array.shape, strict=True))
        ):
            self.add(where, f"{name} has shape {array.shape}, must be {_shape(shape)}", name)
            return None
        if array.size <= FEW:
            finite = all(map(cmath.isfinite, array.ravel().tolist()))
        else:
            finite = bool(np.isfinite(array).all())
        if not finite:
            index = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
            place = list(index) if index else ""
            self.add(where, f"{name}{place} is {array[index]}, must be finite", name, *index)
            return None
        array.setflags(write=False)
        return array


def _shape(shape: tuple[int | None, ...]) -> str:
    """Return a shape as text for messages, such as ``(any, 3)``."""
    return "(" + ", ".join("any" if n is None else str(n) for n in shape) + ")"


def suggest(name: object, candidates: Iterable[str]) -> str:
    """Return the end of an error message: the most similar known name, or all known names.

    Examples
    --------
    >>> suggest("bom", ["boom", "ground"])
    "; did you mean 'boom'?"
    """
    # names given by the user precede names of numbered nodes
    known = sorted(candidates, key=lambda known: bool(re.fullmatch(r"n(ode)?\d+", known)))
    near = difflib.get_close_matches(str(name), known, n=1)
    if not near:  # another capitalisation, such as PID for pid
        small = {one.lower(): one for one in known}
        near = [small[x] for x in difflib.get_close_matches(str(name).lower(), small, n=1)]
    if near:
        return f"; did you mean '{near[0]}'?"
    if not known:
        return "; there are none"
    shown = ", ".join(known[:8]) + (", ..." if len(known) > 8 else "")
    return f"; known: {shown}"


def warn(where: str, message: str, *path: str | int) -> None:
    """Issue a JoustoWarning in the form of a Problem, at the line that calls jousto."""
    level = 2
    frame = sys._getframe(1)
    while frame.f_back and frame.f_globals.get("__name__", "").split(".")[0] == "jousto":
        frame = frame.f_back
        level += 1
    warning = JoustoWarning(f"{where}: {message}" if where else message)
    warning.where, warning.message, warning.path = where, message, path
    warnings.warn(warning, stacklevel=level)


LARGE_STRAIN = 0.01
"""Largest plausible strain, m/m; larger values are probably in another unit."""


def likely_strain_unit(size: float) -> str:
    """Return the unit in which a strain too large for m/m was probably given.

    >>> likely_strain_unit(0.05), likely_strain_unit(10.57)
    ('%', 'um/m')
    """
    return "%" if size <= 1.0 else "um/m"


def strain_remedy(size: float) -> str:
    """Return the probable unit of a strain too large for m/m, and the remedy."""
    return "percent: divide by 100" if size <= 1.0 else "um/m: divide by 1e6"


def count(number: int, noun: str) -> str:
    """Return ``1 mode`` or ``2 modes``."""
    return f"{number} {noun}{'' if number == 1 else 's'}"
