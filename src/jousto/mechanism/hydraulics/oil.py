"""Oil with free air: compressibility, density, viscosity and vapour pressure."""

from __future__ import annotations

import math
from typing import Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.states.expression import exp, maximum

LEAST_PRESSURE = 1.0
"""Absolute pressure, Pa, below which the stiffness of oil with air is that at this pressure."""


class Oil(Declared, by_value=True, kw_only=True):
    """Hydraulic oil, ``w(p) = (1 - a) exp(-p/K) + a (p0/(p0 + p))^(1/n)``.

    w is the volume over that at the pressure p0 of the atmosphere, p the gauge pressure and a the
    share of free air. The effective modulus is ``-w/w'``; air is not dissolved.

    Examples
    --------
    >>> Oil(modulus=1.5e9, air=0.01).effective_modulus(9.9e6)
    1442009860.9...
    """

    kind = "oil"
    modulus: Number = field(
        "Bulk modulus K of the liquid at the pressure of the atmosphere",
        unit="Pa",
        above=0,
        default=1.5e9,
    )
    modulus_slope: Number = field(
        "Increase of K over that of the pressure; 0 for a constant K", least=0, default=0.0
    )
    air: Number = field("Share a of free air in the volume", least=0, below=1, default=0.0)
    polytropic: Number = field(
        "Exponent n of the air: 1.4 for fast, 1 for slow changes", least=1, default=1.4
    )
    density: Number = field("Density", unit="kg/m3", above=0, default=860.0)
    viscosity: Number = field("Dynamic viscosity", unit="Pa s", above=0, default=0.04)
    vapour: Number = field("Absolute pressure of the vapour", unit="Pa", above=0, default=2000.0)
    atmosphere: Number = field(
        "Absolute pressure of the atmosphere, p0", unit="Pa", above=0, default=1e5
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a vapour pressure above that of the atmosphere."""
        if not self.vapour < self.atmosphere:
            problems.add(where, f"vapour is {self.vapour:g} Pa, must be below the atmosphere's "
                         f"{self.atmosphere:g} Pa")  # fmt: skip

    @property
    def floor(self) -> float:
        """Gauge pressure of the vapour, Pa."""
        return self.vapour - self.atmosphere

    def volume_ratio(self, p: Any) -> Any:
        """Return w at a gauge pressure, an expression or a number."""
        made = (1.0 - self.air) * self._liquid(p)
        return made if self.air == 0.0 else made + self.air * self._gas(p)

    def effective_modulus(self, p: Any) -> Any:
        """Return ``K_e = -w/w'`` at a gauge pressure, Pa, an expression or a number."""
        K = self.modulus + self.modulus_slope * p
        if self.air == 0.0:
            return K
        liquid, gas = (1.0 - self.air) * self._liquid(p), self.air * self._gas(p)
        return (liquid + gas) / (liquid / K + gas / (self.polytropic * self._absolute(p)))

    def _absolute(self, p: Any) -> Any:
        total = p + self.atmosphere
        return max(total, LEAST_PRESSURE) if _plain(p) else maximum(total, LEAST_PRESSURE)

    def _liquid(self, p: Any) -> Any:
        if self.modulus_slope == 0.0:
            x = -1.0 / self.modulus * p
            return math.exp(x) if _plain(p) else exp(x)
        K1 = self.modulus_slope
        return (1.0 + K1 / self.modulus * p) ** (-1.0 / K1)

    def _gas(self, p: Any) -> Any:
        return (self.atmosphere / self._absolute(p)) ** (1.0 / self.polytropic)


def _plain(p: Any) -> bool:
    return isinstance(p, float)
