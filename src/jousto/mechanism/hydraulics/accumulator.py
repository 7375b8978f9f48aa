"""Gas accumulators."""

from __future__ import annotations

from typing import TYPE_CHECKING

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.hydraulics.element import HydraulicElement, Port
from jousto.mechanism.states.expression import clip, maximum, smooth_step

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit

OPENED = 1e-3
"""Pressure over the precharge, by which the oil has filled the gap under the bladder."""


class Accumulator(HydraulicElement, tag="accumulator"):
    """Accumulator joined to a node: ``p V^n`` of the gas is constant, no state of its own."""

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

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a precharge above the largest pressure."""
        if self.most is not None and not self.precharge < self.most:
            problems.add(where, f"precharge is {self.precharge:g} Pa, must be below its largest "
                         f"pressure {self.most:g} Pa")  # fmt: skip

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
        p0 = self.precharge + circuit.oil.atmosphere
        p = circuit.pressure(self.port) + circuit.oil.atmosphere
        full = maximum(p, p0)  # the gas has its precharge, as long as there is no oil
        ratio = (p0 / full) ** (1.0 / n)
        z = clip((p - p0) / (OPENED * p0), 0.0, 1.0)
        opened, slope = smooth_step(z), 6.0 * z * (1.0 - z) / (OPENED * p0)
        V = V0 * (1.0 - ratio)
        circuit.add_compliance(self.port, slope * V + opened * (V0 / n) * ratio / full)
        circuit.add_output(f"{self.name}_oil", opened * V)
