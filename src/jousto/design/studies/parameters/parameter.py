"""Parameter: a number of a model that a study varies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from jousto.base.arguments import explained
from jousto.base.errors import Problems
from jousto.base.expressions import measure, unit_of
from jousto.base.names import check_name
from jousto.base.object_repr import described
from jousto.base.units import UnitError
from jousto.design.studies.parameters.distributions import (
    check_moments,
    is_distribution,
    read_distribution,
)


@explained
@described
@dataclass(frozen=True, eq=False)
class Parameter:
    """A number of a model that a study varies.

    Parameters
    ----------
    name : str
        Name of the parameter in the model.
    value : float
        Nominal value.
    bounds : (float, float), optional
        Smallest and largest meaningful value.
    unit : str
        SI unit of the value: "m", "Pa", "N/m"; "1" for a plain number.
    distribution : str or distribution of scipy.stats, optional
        Distribution: ``scipy.stats.norm(4e-3, 1e-4)``, or a text such as
        ``"lognormal(mean=1 kN, sd=100 N)"`` (normal, lognormal, gumbel, uniform, triangular,
        weibull; ``cov=`` instead of ``sd=``; without a mean the value is the mean).

    Raises
    ------
    InputError
        If the bounds are reversed or do not include the value, the unit is not SI, or the
        distribution is unknown or has no finite mean and deviation.

    Examples
    --------
    >>> Parameter("wall", 4e-3, bounds=(2e-3, 8e-3), unit="m")
    <Parameter 'wall': 0.004 m, from 0.002 to 0.008>
    """

    name: str
    value: float
    bounds: tuple[float, float] | None = None
    unit: str = "1"
    distribution: Any = None

    def __post_init__(self) -> None:
        problems = Problems()
        where = check_name(problems, "parameter", self.name)
        good = problems.number(where, "value", self.value, "")
        exponents = self._exponents(problems, where)
        if good:
            object.__setattr__(self, "value", float(self.value))
        if self.bounds is not None:
            ends = problems.array(where, "bounds", self.bounds, (2,))
            if ends is not None:
                low, high = map(float, ends)
                object.__setattr__(self, "bounds", (low, high))
                if not low < high:
                    problems.add(where, f"bounds are {low:g} and {high:g}, the first must be lower")
                elif good and not low <= self.value <= high:
                    outside = f"value is {self.value:g}, must be between {low:g} and {high:g}"
                    problems.add(where, outside)
        problems.raise_if_any()
        given = self.distribution
        if isinstance(given, str):
            made = read_distribution(given, self.value, exponents, f"{where}: distribution")
            object.__setattr__(self, "distribution", made)
        elif given is not None and not is_distribution(given):
            message = "must be a text such as 'normal(sd=0.1)' or a distribution of scipy.stats"
            problems.add(where, f"distribution is {given!r}, {message}")
        problems.raise_if_any()
        if self.distribution is not None:
            check_moments(problems, where, self.distribution)
        problems.raise_if_any()

    def _exponents(self, problems: Problems, where: str) -> tuple[float, ...]:
        """Return the SI exponents of the unit, and add a problem for a unit outside SI."""
        try:
            factor, exponents = measure(self.unit)
        except (UnitError, TypeError, AttributeError):
            problems.add(where, f"unit is {self.unit!r}, must be an SI unit such as 'm' or 'N/m'")
            return ()
        if factor != 1.0:
            problems.add(where, f"unit is {self.unit!r}, must be SI: {unit_of(exponents)!r}")
        return exponents

    @property
    def exponents(self) -> tuple[float, ...]:
        """Exponents of m, kg, s and rad in its unit."""
        return measure(self.unit)[1]

    @property
    def label(self) -> str:
        """Name and unit for tables and axes, ``wall (m)``."""
        return self.name if self.unit == "1" else f"{self.name} ({self.unit})"

    def reach(self, value: float) -> float:
        """Return the length along the parameter over which a dependent quantity changes."""
        low, high = self.bounds or (0.0, 0.0)
        return max(abs(value), 0.1 * (high - low)) or 1.0

    def _facts(self) -> str:
        unit = "" if self.unit == "1" else f" {self.unit}"
        facts = f"{self.value:.6g}{unit}"
        if self.bounds is not None:
            facts += f", from {self.bounds[0]:.6g} to {self.bounds[1]:.6g}"
        if self.distribution is not None:
            facts += f", scatters by {self.distribution.std():.3g}"
        return facts
