"""GradientResult: outcomes with their derivatives and the method of each derivative."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from jousto.base.arrays import Array
from jousto.base.errors import Problem, UnknownNameError, suggest
from jousto.base.object_repr import described

EXACT, MOTION, RUN = "complex step", "complex motion", "complex run"
DIFFERENCES, NONE = "differences", "none"
WAYS = {
    EXACT: "Complex numbers from the parameter to the outcome",
    MOTION: "Complex numbers up to the results of the run. The outcome is then differentiated by "
    "fourth-order differences of these results, at the same place, the same instant and for the "
    "same cycles",
    RUN: "The model by fourth-order differences between neighbouring models, then complex numbers; "
    "the reason is appended",
    DIFFERENCES: "Central differences of whole runs with real numbers; the reason is appended",
    NONE: "There is no derivative, and the number is NaN; the reason is appended",
}
"""First words of the entries of `GradientResult.how`."""

STEPS = (EXACT, MOTION, RUN)


@described
@dataclass(frozen=True, eq=False)
class GradientResult:
    """Outcomes at a point with their derivatives by the parameters.

    ``found["drift", "length"]`` is one derivative, ``found["drift"]`` the row (np,) of an outcome.

    Attributes
    ----------
    values : (no,) array
        Outcomes, SI.
    jacobian : (no, np) array
        Derivatives of the outcomes by the parameters, SI.
    how : tuple of tuple of str
        (no, np): "complex step"; "complex motion" for stress, damage or a user's function,
        differentiated along such a motion; "complex run: ", "differences: " or "none: " with the
        reason. See `WAYS` for their meanings.
    outcomes, parameters : tuple of str
        Names of rows and columns.
    x : (np,) array
        The point.
    runs : dict of str to int
        Number of computed points, "real" and "complex", and of compiled "models".
    """

    values: Array
    jacobian: Array
    how: tuple[tuple[str, ...], ...]
    outcomes: tuple[str, ...]
    parameters: tuple[str, ...]
    x: Array
    runs: dict[str, int] = field(default_factory=dict)

    def __getitem__(self, name: str | tuple[str, str]) -> Any:
        """Return the derivatives of an outcome (np,), or that by one parameter.

        Raises
        ------
        InputError
            For an unknown name; close ones are suggested. A `KeyError`, too.
        """
        outcome, parameter = name if isinstance(name, tuple) else (name, None)
        row = self.jacobian[place_of("outcome", outcome, self.outcomes)]
        return row if parameter is None else row[place_of("parameter", parameter, self.parameters)]

    @property
    def exact(self) -> bool:
        """Whether all derivatives of the motion are by complex steps."""
        return self._count == self.jacobian.size

    @property
    def _count(self) -> int:
        return sum(how.partition(":")[0] in STEPS for row in self.how for how in row)

    def _facts(self) -> str:
        return f"{self._count} of {self.jacobian.size} derivatives by complex steps"

    def __str__(self) -> str:
        """Return all derivatives, and the methods other than complex steps."""
        width = max(map(len, (*self.outcomes, *self.parameters)))
        lines = [repr(self)]
        for i, outcome in enumerate(self.outcomes):
            lines.append(f"  {outcome} = {self.values[i]:.6g}")
            for j, parameter in enumerate(self.parameters):
                message = "" if self.how[i][j] == EXACT else f"  {self.how[i][j]}"
                lines.append(f"    by {parameter:<{width}}  {self.jacobian[i, j]: .6g}{message}")
        used = {how.partition(":")[0] for row in self.how for how in row}
        lines += [f"  {way}: {WAYS[way]}" for way in (MOTION, RUN) if way in used]
        return "\n".join(lines)


def place_of(kind: str, name: str, known: Sequence[str]) -> int:
    """Return the index of a name; raise InputError for an unknown one."""
    if name not in known:
        raise UnknownNameError(Problem("gradient", f"no {kind} {name!r}{suggest(name, known)}"))
    return known.index(name)
