"""Parameters of a model file, and the expressions ``${...}`` that use them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from jousto.base.complexstep import scalar
from jousto.base.errors import InputError, Problem, suggest
from jousto.base.expressions import ExpressionError, Quantity, evaluate, read_quantity
from jousto.design.studies.parameters.parameter import Parameter
from jousto.schema.file.document import Document, Loc
from jousto.schema.file.hidden_signs import EXPRESSION

SECTION = "parameters"
LATER = "limits"
"""Texts that name parameters, which studies give their values."""
KEYS = ("value", "bounds", "distribution")
NAME = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True, eq=False)
class Expanded:
    """A document whose expressions are replaced by their values.

    Parameters
    ----------
    document : Document
        The document without its parameters.
    parameters : tuple of Parameter
        Parameters that may be varied, without those that are expressions themselves.
    unused : tuple of str
        Names of parameters without effect.
    idle : tuple of str
        Names of parameters on which only limits, or parameters of limits, depend.
    """

    document: Document
    parameters: tuple[Parameter, ...] = ()
    unused: tuple[str, ...] = ()
    idle: tuple[str, ...] = ()


def expand(document: Document, values: Mapping[str, float] | None = None) -> Expanded:
    """Replace ``${...}`` by numbers.

    Parameters
    ----------
    document : Document
        The file.
    values : mapping of str to float, optional
        Values of parameters in SI units, instead of those of the file.

    Raises
    ------
    InputError
        With all problems of parameters and expressions and their lines.
    """
    if SECTION not in document.data and "${" not in document.text:
        return Expanded(document)
    expander = _Expander(document, values or {})
    rest = {k: v for k, v in document.data.items() if k not in (SECTION, LATER)}
    expander.used, needed = set(), expander.used
    data = expander.value(rest, ())
    if LATER in document.data:
        data[LATER] = document.data[LATER]
    if expander.found:
        found = sorted(expander.found, key=lambda pair: document.line(pair[0]))
        raise InputError([problem for _, problem in found])
    made = replace(document, data=data, expressions=expander.texts)
    varied = tuple(expander.parameters.values())
    reached = expander.reached()
    unused = tuple(name for name in expander.given if name not in reached | needed)
    idle = tuple(name for name in expander.given if name not in reached)
    return Expanded(made, varied, unused, idle)


class _Expander:
    """Evaluator of the parameters and expressions of a document, with their problems."""

    def __init__(self, document: Document, values: Mapping[str, float]) -> None:
        self.document = document
        self.values = values
        self.found: list[tuple[Loc, Problem]] = []
        self.texts: dict[Loc, str] = {}
        self.used: set[str] = set()
        self.needs: dict[str, set[str]] = {}  # names used by each parameter that depends on others
        self.parameters: dict[str, Parameter] = {}
        self.given: dict[str, Any] = {}
        self.quantities: dict[str, Quantity] = {}
        self._declare(document.data.get(SECTION))

    def note(self, loc: Loc, message: str) -> None:
        """Note a problem at a place of the document."""
        self.found.append((loc, Problem(self.document.where(loc), message)))

    def _declare(self, section: Any) -> None:
        if section is None:
            section = {}
        if not isinstance(section, dict):
            self.note((SECTION,), "expects a mapping such as {wall: 4 mm}")
            return
        self.given = section
        waiting: dict[str, str] = {}
        for name, entry in section.items():
            loc: Loc = (SECTION, name)
            if not NAME.fullmatch(name) or name == "pi":
                self.note(loc, f"the name {name!r} must be letters, digits and _, and not pi")
            elif isinstance(entry, str) and (match := EXPRESSION.fullmatch(entry.strip())):
                waiting[name] = match[1]
            else:
                self._parameter(loc, name, entry)
        self._derive(waiting)
        for name in self.values:
            if name not in self.parameters:
                known = suggest(name, self.parameters)
                self.note((SECTION,), f"no parameter {name!r} that may be varied{known}")

    def _parameter(self, loc: Loc, name: str, entry: Any) -> None:
        """Read a parameter: a value, or a mapping with bounds or a distribution."""
        before = len(self.found)
        options = entry if isinstance(entry, dict) else {"value": entry}
        for key in options:
            if key not in KEYS:
                self.note((*loc, key), f"unknown key {key!r}{suggest(key, KEYS)}")
        if "value" not in options:
            self.note(loc, "'value' is missing")
        if len(self.found) > before:
            return
        at: Loc = (*loc, "value") if isinstance(entry, dict) else loc
        value = self._quantity(at, options["value"])
        bounds = self._bounds((*loc, "bounds"), options.get("bounds"), value)
        if value is None or len(self.found) > before:
            return
        distribution = options.get("distribution")
        try:
            self.parameters[name] = Parameter(name, value.value, bounds, value.unit, distribution)
        except InputError as error:
            for problem in error.problems:
                self.note(loc, problem.message)
            return
        number = scalar(self.values.get(name, value.value))
        self.quantities[name] = Quantity(number, value.exponents)

    def _quantity(self, loc: Loc, value: Any) -> Quantity | None:
        try:
            return read_quantity(value)
        except ExpressionError as error:
            self.note(loc, str(error))
            return None

    def _bounds(self, loc: Loc, entry: Any, value: Quantity | None) -> tuple[float, float] | None:
        if entry is None or value is None:
            return None
        if not isinstance(entry, list) or len(entry) != 2:
            self.note(loc, "expects two numbers such as [2 mm, 8 mm]")
            return None
        ends = [self._quantity((*loc, i), end) for i, end in enumerate(entry)]
        for i, end in enumerate(ends):
            if end is not None and end.exponents != value.exponents:
                self.note((*loc, i), f"{end.said} and {value.said} have different dimensions")
        return None if None in ends else (ends[0].value, ends[1].value)  # type: ignore[union-attr]

    def _derive(self, waiting: dict[str, str]) -> None:
        """Evaluate parameters that depend on others, each after the parameters that it uses."""
        while waiting:
            done = []
            for name, text in waiting.items():
                if not any(re.search(rf"(?<!\w){other}(?!\w)", text) for other in waiting):
                    self.used, before = set(), self.used
                    value = self._evaluate((SECTION, name), text)
                    self.needs[name] = self.used
                    self.used = before | self.used
                    if value is not None:
                        self.quantities[name] = value
                    done.append(name)
            if not done:
                names = " and ".join(repr(name) for name in waiting)
                self.note((SECTION, next(iter(waiting))), f"{names} depend on one another")
                return
            for name in done:
                del waiting[name]

    def _evaluate(self, loc: Loc, text: str) -> Quantity | None:
        try:
            return evaluate(text, self.quantities, self.used)
        except ExpressionError as error:
            names = set(re.findall(r"[^\W\d]\w*", text))
            broken = names & (set(self.given) - set(self.quantities))
            self.used |= broken
            if not broken:  # otherwise the problem of the parameter is already reported
                self.note(loc, f"${{{text}}}: {error}")
            return None

    def reached(self) -> set[str]:
        """Return the names of used parameters, including those that they depend on."""
        found: set[str] = set()
        waiting = set(self.used)
        while waiting:
            found |= waiting
            waiting = set().union(*(self.needs.get(name, ()) for name in waiting)) - found
        return found

    def value(self, value: Any, loc: Loc) -> Any:
        """Return data in which expressions are replaced by their values."""
        if isinstance(value, dict):
            return {key: self.value(item, (*loc, key)) for key, item in value.items()}
        if isinstance(value, list):
            return [self.value(item, (*loc, i)) for i, item in enumerate(value)]
        if not isinstance(value, str) or "${" not in value:
            return value
        match = EXPRESSION.fullmatch(value.strip())
        if match is None:
            self.note(loc, _apart(value))
            return value
        found = self._evaluate(loc, match[1])
        if found is None:
            return value
        self.texts[loc] = match[0]
        return found.text if found.unit != "1" else found.value


def _apart(text: str) -> str:
    """Return the remedy for an expression within a longer text."""
    inside: Iterator[str] = (match[1].strip() for match in EXPRESSION.finditer(text))
    first = next(inside, "")
    rest = EXPRESSION.sub("", text).strip()
    if not first:
        return f"{text!r}: an expression is ${{...}} in one line"
    return f"{text!r}: an expression stands alone, such as ${{{first} * 1 {rest or 'mm'}}}"
