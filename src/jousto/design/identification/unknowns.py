"""Sought numbers: their scale (logarithm or number), bounds and prior knowledge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.errors import Problems, warn
from jousto.base.object_repr import described
from jousto.design.studies.parameters.parameter import Parameter

MASS = 1
"""Place of the exponent of kg in the exponents of a unit."""
INSIDE = 1e-2
"""Share of the range by which a start value on a bound is moved inside."""


@described
@dataclass(frozen=True, eq=False)
class Unknown:
    """A sought number, theta, by the coordinate u of the search: ``theta = exp(u)`` or ``u``.

    Numbers that are positive by nature are sought by their logarithm.

    Attributes
    ----------
    parameter : Parameter
    log : bool
        Whether u is the logarithm.
    start : float
        Start value of theta, within the bounds.
    """

    parameter: Parameter
    log: bool
    start: float

    def _facts(self) -> str:
        return f"from {self.start:.6g}{', by its logarithm' if self.log else ''}"

    @property
    def name(self) -> str:
        """Name of the parameter."""
        return self.parameter.name

    @property
    def size(self) -> float:
        """Change of u that is large: 1 of a logarithm (a factor e)."""
        return 1.0 if self.log else self.parameter.reach(self.start)

    def u(self, theta: float) -> float:
        """Return the coordinate of a value."""
        return float(np.log(theta)) if self.log else float(theta)

    def theta(self, u: float) -> float:
        """Return the value of a coordinate."""
        return float(np.exp(u)) if self.log else float(u)

    def slope(self, u: float) -> float:
        """Return dtheta/du."""
        return float(np.exp(u)) if self.log else 1.0

    @property
    def ends(self) -> tuple[float, float]:
        """Bounds of u, infinite if there are none."""
        low, high = self.parameter.bounds or (-np.inf, np.inf)
        if not self.log:
            return low, high
        return (np.log(low) if low > 0.0 else -np.inf), (np.log(high) if high < np.inf else np.inf)

    def prior(self, u: float) -> tuple[float, float] | None:
        """Return the residual of the prior distribution and its derivative by u, or None."""
        given = self.parameter.distribution
        if given is None:
            return None
        mean, sd, logarithmic = _moments(given)
        if logarithmic:
            ln = u if self.log else float(np.log(u))
            return (ln - mean) / sd, 1.0 / (sd if self.log else sd * u)
        return (self.theta(u) - mean) / sd, self.slope(u) / sd


def _moments(given: Any) -> tuple[float, float, bool]:
    """Return mean and deviation of a normal distribution, or those of the logarithm."""
    kind = given.dist.name
    if kind == "norm":
        return float(given.mean()), float(given.std()), False
    ratio = float(given.std() / given.mean())
    sd = float(np.sqrt(np.log1p(ratio**2)))
    return float(np.log(given.mean()) - 0.5 * sd**2), sd, True


def unknowns(problems: Problems, parameters: Sequence[Parameter]) -> tuple[Unknown, ...]:
    """Return the unknowns of parameters, and report priors that cannot be used."""
    return tuple(_unknown(problems, parameter) for parameter in parameters)


def _unknown(problems: Problems, parameter: Parameter) -> Unknown:
    where = f"parameter {parameter.name!r}"
    given = parameter.distribution
    kind = getattr(getattr(given, "dist", None), "name", "")
    if given is not None and (
        kind not in ("norm", "lognorm") or (kind == "lognorm" and given.support()[0] != 0.0)
    ):
        problems.add(where, "its distribution, the prior here, must be normal or lognormal")
        return Unknown(parameter, False, parameter.value)
    start = parameter.value
    low, high = parameter.bounds or (-np.inf, np.inf)
    positive = low >= 0.0 if parameter.bounds else parameter.exponents[MASS] != 0.0
    log = positive and start >= 0.0 and (start > 0.0 or high < np.inf)
    log = log or kind == "lognorm"
    if start in (low, high) or (log and start == 0.0):
        span = high - low
        if start == low or start == 0.0:
            moved = low + INSIDE * span
        else:
            moved = high - INSIDE * span
        warn(where, f"starts on its bound {start:g}; the search starts at {moved:.4g}")
        start = moved
    return Unknown(parameter, log, start)
