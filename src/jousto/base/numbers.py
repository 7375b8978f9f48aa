"""Fields of declared classes that are numbers or arrays, and the checks of numbers."""

from __future__ import annotations

import numbers
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.complexstep import floats, scalar
from jousto.base.errors import Problems
from jousto.base.fields import Field, In, Out


def set_fields(target: Any, **values: Any) -> None:
    """Set the fields of a frozen dataclass from its constructor."""
    for key, value in values.items():
        object.__setattr__(target, key, value)


def number(
    problems: Problems, where: str, name: str, value: Any, *path: str | int, remedy: str = ""
) -> float | None:
    """Return a finite float, or report a problem at a path (the name if the path is empty).

    A remedy, such as ``; do this``, is appended to the message about an infinite value.
    """
    try:
        if value is None or isinstance(value, str):
            raise TypeError
        array = floats(value)
    except (TypeError, ValueError, OverflowError):
        array = np.empty(0)
    if array.shape != ():
        problems.add(where, f"{name} is {value!r}, must be a number", *(path or (name,)))
        return None
    if not np.isfinite(array):
        message = f"{name} is {array[()]:g}, must be finite{remedy if np.isinf(array) else ''}"
        problems.add(where, message, *(path or (name,)))
        return None
    return scalar(array[()])


class _Numeric(Field[In, Out]):
    """Base of the fields of numbers, with limits.

    Parameters
    ----------
    text, unit, default, kw_only
        As for every field.
    least : float, optional
        Smallest value.
    above : float, optional
        Exclusive lower limit.
    most : float, optional
        Largest value.
    below : float, optional
        Exclusive upper limit.
    nonzero : bool
        Whether 0 is refused.
    remedy : str
        Remedy in the message about a value outside the limits.
    """

    form = "number"
    noun = "float"

    def __init__(
        self,
        text: str = "",
        *,
        unit: Any = "1",
        least: float | None = None,
        above: float | None = None,
        most: float | None = None,
        below: float | None = None,
        nonzero: bool = False,
        remedy: str = "",
        **common: Any,
    ) -> None:
        super().__init__(text, unit=unit, **common)
        self.least = least
        self.above = above
        self.most = most
        self.below = below
        self.nonzero = nonzero
        self.remedy = f"; {remedy}" if remedy else ""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a finite float within the limits, or report what is wrong."""
        unit = self.unit if isinstance(self.unit, str) and self.unit != "1" else ""
        if self.wanted and not self.plain:
            wanted = self.wanted
            good = problems.number(
                where, self.label, value, unit, wanted, lambda x: not self.missed(x)
            )
            return scalar(value) if good else None
        if self.wanted:
            found = None if isinstance(value, bool) else number(Problems(), "", "", value)
            if found is None or self.missed(found):
                problems.add(where, f"{self.label} is {value!r}, must be {self.wanted}")
            return found
        found = number(problems, where, self.label, value, remedy=self.remedy)
        if found is not None and (missed := self.missed(found)):
            shown = f"{found:g} {unit}".rstrip()
            problems.add(where, f"{self.label} is {shown}, {missed}{self.remedy}")
        return found

    def missed(self, x: float) -> str:
        """Return the limit that a number violates, as text; empty if it violates none."""
        if self.above is not None and not x > self.above:
            return "must be positive" if self.above == 0 else f"must be above {self.above:g}"
        if self.least is not None and not x >= self.least:
            return "must not be negative" if self.least == 0 else f"must be {self.least:g} or more"
        if self.most is not None and not x <= self.most:
            return f"must be {self.most:g} or less"
        if self.below is not None and not x < self.below:
            return f"must be below {self.below:g}"
        return "must not be zero" if self.nonzero and x == 0.0 else ""


class Number(_Numeric[float, float]):
    """Field of a finite number."""


class OptionalNumber(_Numeric["float | None", "float | None"]):
    """Field of a finite number, or None."""

    optional = True


class NumberOrWord(_Numeric["float | str | None", "float | str | None"]):
    """Field of a finite number, a word that stands for one found by the program, or None.

    Parameters
    ----------
    text, default, **common
        As for every field of numbers.
    word : str
        The word.
    """

    form = "number or word"
    optional = True

    def __init__(self, text: str = "", *, word: str, **common: Any) -> None:
        super().__init__(text, **common)
        self.word = word

    @property
    def annotation(self) -> str:
        """The word and a number as a type, for signatures."""
        return f"Literal[{self.word!r}] | float | None"

    @property
    def noun(self) -> str:  # type: ignore[override]
        """The word and a number as a noun, for messages."""
        return f'"{self.word}" or float'

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the word or a finite number within the limits, or report what is wrong."""
        if isinstance(value, str) and value == self.word:
            return value
        return super().check(problems, where, value)


class DefaultNumber(_Numeric["float | None", float]):
    """Field of a finite number; None for one that the object determines itself."""


class _Seconds(_Numeric[In, Out]):
    form = "duration"
    wish = "a positive number of seconds"

    def __init__(self, text: str = "", **common: Any) -> None:
        super().__init__(text, unit="s", above=0, wanted=self.wish, plain=True, **common)


class Duration(_Seconds[float, float]):
    """Field of a time above zero."""


class OptionalDuration(_Seconds["float | None", "float | None"]):
    """Field of a time above zero, or None."""

    optional = True

    wish = "None or positive, s"


class OnlyPositive(_Numeric[In, Out]):
    """Base of the fields of numbers above zero."""

    def __init__(self, text: str = "", **common: Any) -> None:
        super().__init__(text, above=0, wanted="a positive number", **common)


class Positive(OnlyPositive[float, float]):
    """Field of a number above zero."""


class OptionalPositive(OnlyPositive["float | None", "float | None"]):
    """Field of a number above zero, or None."""

    optional = True


class _Whole(Field[In, Out]):
    """Base of the fields of whole numbers, with limits.

    Parameters
    ----------
    text, default, kw_only
        As for every field.
    least, most : int
        Smallest value; largest value, if there is one.
    """

    form = "count"
    noun = "int"

    def __init__(
        self, text: str = "", *, least: int, most: int | None = None, **common: Any
    ) -> None:
        super().__init__(text, **common)
        self.least, self.most = least, most

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a whole number within the limits, or report what is wrong."""
        whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
        if not (whole and self.least <= value and (self.most is None or value <= self.most)):
            most = "" if self.most is None else f" to {self.most}"
            wanted = self.wanted or f"a whole number from {self.least}{most}"
            problems.add(where, f"{self.label} is {value!r}, must be {wanted}")
            return None
        return int(value)


class Whole(_Whole[int, int]):
    """Field of a whole number."""


class OptionalWhole(_Whole["int | None", "int | None"]):
    """Field of a whole number, or None."""

    optional = True


class Numbers(Field["float | Iterable[float]", "tuple[float, ...]"]):
    """Field of one or several numbers; at least one is required."""

    form = "numbers"
    noun = "float or sequence of float"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the numbers as a tuple, or report what is wrong."""
        found = []
        for i, x in enumerate(value if isinstance(value, Iterable) else (value,)):
            found.append(number(problems, where, f"{self.name}[{i}]", x, self.label, i))
            if found[-1] == 0.0:
                message = f"{self.name}[{i}] is 0, must not be zero"
                problems.add(where, message, self.label, i)
        return tuple(found)


class Vector(Field[ArrayLike, NDArray[np.float64]]):
    """Field of three numbers."""

    form = "vector"
    noun = "(3,) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the numbers as a read-only array (3,), or report what is wrong."""
        return problems.array(where, self.label, value, (3,))


class _Values(Field[In, Out]):
    """Base of the fields of arrays of numbers, with a shape.

    Parameters
    ----------
    text, unit, default, kw_only
        As for every field.
    shape : tuple
        Lengths along its axes, None for any.
    """

    form = "array"

    def __init__(self, text: str = "", *, shape: tuple[int | None, ...], **common: Any) -> None:
        super().__init__(text, **common)
        self.shape = shape

    @property
    def noun(self) -> str:  # type: ignore[override]
        """The shape, as a noun in messages."""
        sizes = ", ".join("n" if n is None else str(n) for n in self.shape)
        return f"({sizes}{',' * (len(self.shape) == 1)}) array_like"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a read-only array of this shape, or report what is wrong."""
        return problems.array(where, self.label, value, self.shape)


class Values(_Values[ArrayLike, NDArray[np.float64]]):
    """Field of an array of numbers."""


class OptionalValues(_Values["ArrayLike | None", "NDArray[np.float64] | Any"]):
    """Field of an array of numbers, or None."""

    optional = True


class DefaultValues(_Values["ArrayLike | None", NDArray[np.float64]]):
    """Field of an array of numbers; None for one that the object determines itself."""
