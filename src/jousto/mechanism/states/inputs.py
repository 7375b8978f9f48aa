"""Fields of blocks that take expressions: inputs, and formulas by name or coordinate."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import Field
from jousto.base.numbers import number
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.states.expression import Expression, expression
from jousto.mechanism.states.formula import FormulaError, formula


def as_expression(problems: Problems, where: str, what: str, given: Any) -> Any:
    """Return an expression, coordinate, signal or number as an expression, or report it."""
    found = expression(given)
    if found is None:
        outputs = getattr(given, "outputs", None) or getattr(given, "starts", None)
        remedy = f"; take its output, block[{next(iter(outputs))!r}]" if outputs else ""
        problems.add(
            where,
            f"{what} is {given!r}, must be an expression of states, inputs, numbers, signals"
            f"{remedy}",
        )
    return found


def as_formula(
    problems: Problems, where: str, what: str, given: Any, names: Mapping[str, Any]
) -> Any:
    """Return an expression, signal, number or formula as an expression, or report it."""
    if not isinstance(given, str):
        return as_expression(problems, where, what, given)

    def refer(block: str, part: str) -> Expression:
        return Expression("named", of=(block, part))

    try:
        return formula(given, names, refer)
    except FormulaError as error:
        problems.add(where, f"{what}: {error}")
        return Expression("number", of=0.0)


class InputField(Field["Any", "Any"]):
    """Field of an expression, coordinate, signal, number, or formula such as ``oil.p - 1e5``."""

    form = "formula"
    noun = "Expression, Coordinate, Signal, float or str"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the expression, or report another value."""
        return as_formula(problems, where, self.name, value, {})


class OptionalInput(InputField):
    """Field of an input, or None."""

    optional = True


class InputsField(Field["Any", "tuple[Any, ...]"]):
    """Field of one input or several, each as for `InputField`."""

    form = "formula list"
    noun = "Expression, Coordinate, Signal, float or str, or sequence of these"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the expressions, or report other values and an empty list."""
        several = isinstance(value, Iterable) and not isinstance(value, str)
        given = list(value) if several else [value]
        if not given:
            problems.add(where, f"{self.name} is empty, must have one input or more", self.name)
        return tuple(
            as_formula(problems, where, f"{self.name}[{i}]", one, {}) for i, one in enumerate(given)
        )


class FormulasField(Field["Mapping[Any, Any] | None", "dict[Any, Any]"]):
    """Field of formulas or numbers by name, or by coordinate.

    Parameters
    ----------
    text, default, kw_only
        As for every field.
    numbers : bool
        Whether the values are numbers.
    along : bool
        Whether the keys are coordinates.
    """

    form = "formulas"
    noun = "dict"

    def __init__(
        self, text: str = "", *, numbers: bool = False, along: bool = False, **common: Any
    ) -> None:
        super().__init__(text, **common)
        self.numbers, self.along = numbers, along

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a dict, or report another type and keys or numbers that are invalid."""
        if not isinstance(value, Mapping):
            problems.add(where, f"{self.name} is {value!r}, must be a dict", self.name)
            return {}
        made: dict[Any, Any] = {}
        for key, given in value.items():
            if not isinstance(key, Coordinate if self.along else str):
                what = "coordinates" if self.along else "names"
                problems.add(where, f"{self.name} has the key {key!r}, must have {what}", self.name)
            elif isinstance(key, str) and not key.isidentifier():
                problems.add(where, f"{self.name}: {key!r} is no name of a state", self.name)
            elif self.numbers:
                made[key] = number(problems, where, f"{self.name} of {key!r}", given)
            else:
                made[key] = given
        return made
