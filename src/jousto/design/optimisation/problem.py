"""Interface of optimisation problems: cost, motion and limits of a design."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem as Trouble, Problems, count, suggest
from jousto.base.object_repr import described
from jousto.design.optimisation.elastic import Elastic, Motion
from jousto.design.optimisation.limits import BodyLimit, FrequencyLimit, Limit
from jousto.design.optimisation.rigid_options import RigidMachine
from jousto.design.studies.parameters.parameter import Parameter


@described
class Problem(ABC):
    """Base class: minimise the cost over parameters x subject to all limits at all instants.

    Parameters
    ----------
    parameters : sequence of Parameter
        Parameters with bounds; their values are the start.
    limits : sequence of Limit

    Attributes
    ----------
    rigid : RigidMachine or None
        Rigid machine of `optimise`, if it gets none, such as that of a model file.

    Raises
    ------
    InputError
        If a parameter has no bounds, there are no limits, or names are equal.
    """

    rigid: RigidMachine | None = None

    def __init__(self, parameters: Sequence[Parameter], limits: Sequence[Limit]) -> None:
        problems, where = Problems(), "optimisation"
        self.parameters = problems.several(where, "parameters", parameters, Parameter)
        self.limits = problems.several(where, "limits", limits, Limit)
        names = [p.name for p in self.parameters]
        if not names:
            problems.add(where, "there are no parameters")
        for name in sorted({n for n in names if names.count(n) > 1}):
            problems.add(where, f"parameter '{name}' is given twice")
        for p in self.parameters:
            if p.bounds is None or not np.all(np.isfinite(p.bounds)):
                problems.add(where, f"parameter '{p.name}' needs two finite bounds")
        if not self.limits:
            problems.add(where, "there are no limits: the least cost is at the bounds")
        problems.raise_if_any()
        bounds = np.array([p.bounds for p in self.parameters], dtype=np.float64)
        self.low, self.high = bounds.T
        self.start = np.array([p.value for p in self.parameters], dtype=np.float64)
        self.names = tuple(names)
        self.runs = 0
        self._elastic: dict[bytes, tuple[Elastic, ...]] = {}
        self._motions: dict[bytes, tuple[Motion, ...]] = {}
        self._frequencies: dict[bytes, Array] = {}

    def _facts(self) -> str:
        return f"{count(len(self.names), 'parameter')}, {count(len(self.limits), 'limit')}"

    def check(self) -> None:
        """Raise InputError if a limit names a body that does not exist."""
        problems = Problems()
        known = {body.name for body in self.bodies(self.start)}
        for limit in self.limits:
            if isinstance(limit, BodyLimit) and limit.body not in known:
                problems.add(
                    f"limit on {limit.label}",
                    f"no flexible body '{limit.body}'{suggest(limit.body, known)}",
                )
        problems.raise_if_any()

    def values(self, x: Array) -> dict[str, float]:
        """Return the parameter values by name."""
        return dict(zip(self.names, map(float, x), strict=True))

    def vector(self, values: Mapping[str, float]) -> Array:
        """Return the design (nd,) of parameter values by name."""
        return np.array([values[name] for name in self.names], dtype=np.float64)

    @abstractmethod
    def cost(self, x: Array) -> float:
        """Return the cost of a design, such as its mass."""

    @abstractmethod
    def elastic(self, x: Array) -> tuple[Elastic, ...]:
        """Return the static models of the flexible bodies; needs no run."""

    @abstractmethod
    def run(self, x: Array) -> tuple[Motion, ...]:
        """Run the machine and return the deformation of each flexible body by load case."""

    def bodies(self, x: Array) -> tuple[Elastic, ...]:
        """Return the static models of the bodies of a design, from a small cache."""
        key = x.tobytes()
        if key not in self._elastic:
            self._elastic[key] = self.elastic(x)
            forget(self._elastic, len(x))
        return self._elastic[key]

    def motions(self, x: Array) -> tuple[Motion, ...]:
        """Return the deformations of the bodies of a design, from a small cache."""
        key = x.tobytes()
        if key not in self._motions:
            self._motions[key] = self.run(x)
            self.runs += 1
            forget(self._motions, len(x))
        return self._motions[key]

    def frequencies(self, x: Array) -> Array:
        """Return the natural frequencies, Hz, ascending, without rigid-body modes."""
        raise NotImplementedError

    def fixed(self, x: Array) -> Array:
        """Return the ratios of limits that need no run."""
        limits = [limit for limit in self.limits if isinstance(limit, FrequencyLimit)]
        key = x.tobytes()
        if limits and key not in self._frequencies:
            self._frequencies[key] = self.frequencies(x)
            forget(self._frequencies, len(x))
        found = np.array([limit.ratio(self._frequencies[key]) for limit in limits])
        if not np.all(np.isfinite(found)):
            raise InputError(Trouble("frequency limit", "a frequency is not a positive number"))
        return found

    @property
    def fixed_labels(self) -> tuple[str, ...]:
        """Labels of the rows of `fixed`."""
        return tuple(limit.label for limit in self.limits if isinstance(limit, FrequencyLimit))


def forget(memory: dict[bytes, Any], nd: int) -> None:
    """Limit the cache to the designs of one central difference."""
    while len(memory) > 2 * nd + 2:
        del memory[next(iter(memory))]


@described
@dataclass(frozen=True, eq=False)
class Place:
    """One row of the ratios: place, limit, motion and instant.

    Attributes
    ----------
    limit : str
        Limited quantity.
    place : str
        Site or node; empty for limits of the whole machine.
    case : str
        Load case.
    time : float
        Instant, s; NaN for quantities of a whole run.
    """

    limit: str
    place: str = ""
    case: str = ""
    time: float = float("nan")

    def __str__(self) -> str:
        at = "" if np.isnan(self.time) else f" at {self.time:.4g} s"
        case = f" ({self.case})" if self.case else ""
        place = f", {self.place}" if self.place else ""
        return f"{self.limit}{place}{case}{at}"


@described
@dataclass(frozen=True, eq=False)
class Kept:
    """Rows of one limit in one motion that the optimisation includes.

    Attributes
    ----------
    limit : BodyLimit
    motion : int
    places, columns : (nk,) int array
        Pairs of place and column of the ratios of the limit.
    instants : (ni,) int array
        The instants of the columns; None for limits of whole runs.
    count : int
        Number of instants in the run.
    """

    limit: BodyLimit
    motion: int
    places: Any
    columns: Any
    instants: Any
    count: int
