"""Requirements: outcomes with an upper or lower bound, such as ``max(tip.y) <= 12 mm``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from jousto.base.errors import InputError, Problem
from jousto.base.expressions import NONE, ExpressionError, Quantity, evaluate, measure
from jousto.base.object_repr import described
from jousto.base.units import UnitError
from jousto.design.studies.outcomes.outcome import Outcome
from jousto.design.studies.outcomes.outcomes import read_outcome

TEXT = re.compile(r"\s*(?:([^=()<>]+?)\s*=\s*)?([^=<>]+?)\s*([<>]=?)\s*([^<>=]+?)\s*", re.S)
MARKED = re.compile(r"\$\{([^{}\n]*)\}")
NAME = re.compile(r"(?<![\w.])[^\W\d]\w*")
WORD = re.compile(r"(?<![\w.])[^\W\d]|(?<=\d)\s+[^\W\d]|%")
HELP = "a limit is an outcome, <= or >=, and a value, such as 'max(tip.y) <= 12 mm'"


@described
@dataclass(frozen=True)
class Requirement:
    """Outcome of a study with an upper or lower bound.

    Attributes
    ----------
    name : str
        Name of the requirement, by default that of the outcome.
    left : str
        The outcome, or the name of one.
    below : bool
        Whether the bound is an upper one.
    bound : str
        Expression of parameters.
    """

    name: str
    left: str
    below: bool
    bound: str

    def _facts(self) -> str:
        return self.text

    @property
    def text(self) -> str:
        """Requirement as text."""
        return f"{self.left} {'<=' if self.below else '>='} {self.bound}"

    @property
    def outcome(self) -> Outcome:
        """Limited outcome.

        Raises
        ------
        InputError
            If there is no such outcome.
        """
        return read_outcome(self.left)

    def names(self, known: Mapping[str, object]) -> tuple[str, ...]:
        """Return the parameter names, among the known ones, that the bound depends on."""
        found = NAME.findall(self.bound)
        return tuple(name for name in known if name in found)

    def value(self, known: Mapping[str, Quantity], unit: str | None = None) -> float:
        """Return the bound in the unit of the outcome; a plain number has that unit.

        Parameters
        ----------
        known : dict of Quantity
            The parameters by name.
        unit : str, optional
            Unit of the outcome; None if it is not known yet: the bound is then in SI.

        Raises
        ------
        InputError
            If the bound is not an expression of these parameters, or has another dimension than the
            outcome.
        """
        where = f"limit {self.text!r}"
        try:
            found = evaluate(self.bound, known)
        except ExpressionError as error:
            raise InputError(Problem(where, str(error))) from None
        if unit is None:
            return found.value
        try:
            factor, exponents = measure(unit)
        except UnitError:
            return found.value
        if found.exponents == NONE and (exponents != NONE or not WORD.search(self.bound)):
            return found.value
        if found.exponents != exponents:
            message = f"{found.said} is not a bound for {self.left}, which is in {unit}"
            raise InputError(Problem(where, message))
        return found.value / factor


def read_requirement(text: str) -> Requirement:
    """Return the requirement of a text ``max(tip.y) <= 12 mm``, with a name ``tip = ...``.

    Raises
    ------
    InputError
        If the text is not a requirement.

    Examples
    --------
    >>> read_requirement("stress(arm) <= ${strength / 1.5}")
    <Requirement 'stress(arm)': stress(arm) <= strength / 1.5>
    """
    match = TEXT.fullmatch(MARKED.sub(r"\1", text)) if type(text) is str else None
    if match is None:
        raise InputError(Problem(f"limit {text!r}", HELP))
    name, left, sign, bound = match.groups()
    return Requirement(name or left, left, sign[0] == "<", bound)
