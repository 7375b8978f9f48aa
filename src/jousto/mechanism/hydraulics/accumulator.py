"""Gas accumulators."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.hydraulics.element import HydraulicElement, Port
from jousto.mechanism.states.expression import clip, exp, maximum, smooth_step

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit

OPENED = 1e-3
"""Pressure over the precharge, by which the oil has filled the gap under the bladder."""


class Accumulator(HydraulicElement, tag="accumulator"):
    """Accumulator joined to a node: ``p V^n`` of the gas is constant, no state of its own.

    With a thermal time constant the gas exchanges heat with its wall, whose temperature is that of
    the precharge: ``T' = -(n - 1) T V'/V + (T_wall - T)/thermal`` (Otis, Pourmovahed, J. Dyn. Sys.,
    Meas., Control 107, 1985), n the ratio of its heat capacities.
    """

    kind = "accumulator"
    port: Port = field("Node to which it is joined")
    volume: Number = field("Volume of the gas at the precharge", unit="m3", above=0)
    precharge: Number = field("Gauge pressure of the gas without oil", unit="Pa", above=0)
    polytropic: Number = field(
        "Exponent n of the gas: 1.4 for fast, 1 for slow changes", least=1, default=1.4
    )
    most: OptionalNumber = field(
        "Largest gauge pressure that it bears", unit="Pa", above=0, default=None, kw_only=True
    )
    thermal: OptionalNumber = field(
        "Thermal time constant of the gas; None for n alone", unit="s", above=0, default=None,
        kw_only=True,
    )  # fmt: skip

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a precharge above the largest pressure, and heat without a ratio of capacities."""
        if self.most is not None and not self.precharge < self.most:
            problems.add(where, f"precharge is {self.precharge:g} Pa, must be below its largest "
                         f"pressure {self.most:g} Pa")  # fmt: skip
        if self.thermal is not None and not self.polytropic > 1.0:
            problems.add(where, "thermal needs the ratio of the heat capacities; give polytropic, "
                         "1.4 for nitrogen")  # fmt: skip

    def check_with(self, problems: Problems, where: str, circuit: Circuit) -> None:
        """Report a port with a given pressure, and relief valves that open too late."""
        if self.port in circuit.given:
            problems.add(where, f"port is {self.port!r}, must be a node")
        if self.most is not None:
            circuit.limits.append((self, self.most, (self.port,)))

    def connect(self, circuit: Circuit) -> None:
        """Add the compliance ``dV/dp`` of the oil V in it, and V as an output.

        ``V = S(z) V0 (1 - (p0/p)^(1/n))``, ``z = (p - p0)/(1e-3 p0)``, absolute pressures: above
        z = 1 the law of the gas, below it a smooth end at p0.
        """
        n, V0 = self.polytropic, self.volume
        p0: Any = self.precharge + circuit.oil.atmosphere
        tau = self.thermal
        heat = None if tau is None else self._heat(circuit, p0)
        if heat is not None:
            p0 = p0 * exp(n * heat)
        p = circuit.pressure(self.port) + circuit.oil.atmosphere
        full = maximum(p, p0)  # the gas has its precharge, as long as there is no oil
        ratio = (p0 / full) ** (1.0 / n)
        z = clip((p - p0) / (OPENED * p0), 0.0, 1.0)
        opened, steep = smooth_step(z), 6.0 * z * (1.0 - z)
        V = V0 * (1.0 - ratio)
        slope = steep / (OPENED * p0)
        circuit.add_compliance(self.port, slope * V + opened * (V0 / n) * ratio / full)
        circuit.add_output(f"{self.name}_oil", opened * V)
        if heat is None or tau is None:
            return
        # the same at constant pressure, by the heat: dz/dheat = -n p/(1e-3 p0)
        by_heat = 0.0 - steep * (n / OPENED) * (p / p0) * V - opened * V0 * ratio
        T = (full / p0) ** (1.0 - 1.0 / n) * exp(n * heat)  # over that of the wall
        gained = (1.0 / T - 1.0) / (n * tau)
        circuit.set_rate(f"{self.name}_gas", gained)
        circuit.add_growth(self.port, by_heat * gained)
        # the gas gives the wall m cv (T - T_wall)/thermal = p V n/(n - 1) times minus its gain
        lost = 0.0 - full * (V0 * (n / (n - 1.0))) * ratio * gained
        circuit.add_heat(self.name, lost)
        circuit.stored((p - circuit.oil.atmosphere) * by_heat * gained - lost)
        circuit.add_output(f"{self.name}_temperature", T)

    def _heat(self, circuit: Circuit, p0: float) -> Any:
        """Return the state s of the gas: ``p V^n`` is ``exp(n s)`` times that at the precharge.

        At the start the gas has the temperature of its wall.
        """
        p = max(circuit.start_of(self.port) + circuit.oil.atmosphere, p0)
        start = 0.0 - (1.0 - 1.0 / self.polytropic) * math.log(p / p0)
        return circuit.add_state(f"{self.name}_gas", start, 0.1)
