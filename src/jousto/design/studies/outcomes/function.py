"""Outcomes that a Python function computes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.complexstep import is_stepping, scalar
from jousto.base.errors import InputError, Problem, Problems, suggest
from jousto.base.names import check_name
from jousto.base.object_repr import described
from jousto.design.studies.case import Case
from jousto.design.studies.outcomes.complex_step import directional, has_slope
from jousto.design.studies.outcomes.outcome import Outcome


@explained
@described
@dataclass(frozen=True, eq=False)
class Function(Outcome):
    """Number that a Python function computes.

    Parameters
    ----------
    name : str
        Name of the column.
    function : callable
        ``function(run)`` of the `Solution`, or of the argument that `of` names.
    of : {"run", "model", "mechanism", "case"}
        Argument of the function; only "run" and "case" need a simulation. A case has all of them
        and ``case.values``.
    measured_in : str
        SI unit.

    Examples
    --------
    ``Function("swing", lambda run: np.ptp(run["tip.x"]), measured_in="m")``
    """

    name: str
    function: Callable[[Any], Any]
    of: str = "run"
    measured_in: str = "1"

    def __post_init__(self) -> None:
        problems = Problems()
        where = check_name(problems, "outcome", self.name)
        given: Any = self.function
        if not callable(given):
            problems.add(where, f"function is {given!r}, must be a function")
        known = ("run", "model", "mechanism", "case")
        if self.of not in known:
            problems.add(where, f"of is {self.of!r}{suggest(str(self.of), known)}")
        problems.raise_if_any()

    @property
    def needs_run(self) -> bool:  # type: ignore[override]
        """Whether the function needs a simulated run."""
        return self.of in ("run", "case")

    def value(self, case: Case) -> float:
        """Return the number at one point."""
        given = case if self.of == "case" else getattr(case, self.of)
        try:
            found = self.function(given)
        except Exception:
            if self.of != "run" or not has_slope(case.run):
                raise
            return directional(case, lambda run, _: float(self.function(run)))
        array = np.asarray(found)
        if array.size != 1 or array.dtype.kind not in ("fiubc" if is_stepping() else "fiub"):
            message = f"its function returned {found!r:.60}, must be one number"
            raise InputError(Problem(f"outcome '{self.name}'", message))
        case.whole = array.dtype.kind in "iub"
        return scalar(array.reshape(()))

    def unit(self, case: Case) -> str:
        """Return the unit of the number."""
        return self.measured_in
