"""Circuit: flows, volumes, forces and powers of all elements of a network, as equations.

Every port carries its flow Q into a node. With the volume V and the compliance C of all that is
joined to a node, oil of the effective modulus K_e obeys ``(V/K_e + C) p' = sum Q - V'``, or, where
mass is the state, ``m' = sum rho Q`` with p from m/V.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.mechanism.hydraulics.laws import edge
from jousto.mechanism.hydraulics.oil import Oil
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.states.expression import (
    Expression,
    exp,
    log,
    maximum,
    minimum,
    smooth_step,
    where,
)

PRESSURE, WORK = 1e6, 1e3
"""Sizes of pressures, Pa, and of works, J, for error control."""


@dataclass
class Place:
    """Sums over what is joined to a node.

    Attributes
    ----------
    volume, rate : expression
        Volume, m3, and its rate, m3/s.
    compliance : expression
        Volume of walls and gas over pressure, m3/Pa.
    flow : expression
        Flow into the node, m3/s; in terms of the density at the atmosphere if mass is the state.
    least, first : float
        Smallest volume along the strokes, and that at the start, m3.
    slope : float
        Largest slope of the flows over the pressure: edges fully open at no pressure drop,
        m3/s/Pa.
    """

    start: float
    volume: Any = 0.0
    rate: Any = 0.0
    compliance: Any = 0.0
    flow: Any = 0.0
    least: float = 0.0
    first: float = 0.0
    slope: float = 0.0


class Circuit:
    """Equations of a network, to which each element adds its own.

    Parameters
    ----------
    refer : callable
        Returns the expression of a state, of an output, by kind and name.
    oil : Oil
        The oil.
    transition : float
        Pressure drop below which flow is laminar, Pa.
    by_mass : bool
        Whether the mass of the oil is the state of a node, instead of the pressure.
    given : mapping
        Pressures of tanks and supplies by name.
    starts : mapping
        Pressures of the nodes at the start by name.
    """

    def __init__(
        self,
        refer: Callable[[str, str], Expression],
        oil: Oil,
        transition: float,
        by_mass: bool,
        given: Mapping[str, Any],
        starts: Mapping[str, float],
    ) -> None:
        self._refer = refer
        self.oil = oil
        self.transition = transition
        self.by_mass = by_mass
        self.given = dict(given)
        self.nodes = {name: Place(start) for name, start in starts.items()}
        self.starts: dict[str, Any] = {}
        self.sizes: dict[str, float] = {}
        self.rates: dict[str, Any] = {}
        self.outputs: dict[str, Any] = {}
        self.forces: list[tuple[Coordinate, Any]] = []
        self.limits: list[tuple[Any, float, tuple[str, ...]]] = []
        """Elements with the largest pressure that they bear, and their ports."""
        self.heats: dict[str, Any] = {}
        self.openings: dict[str, Any] = {}
        self._supplied: Any = 0.0
        self._mechanical: Any = 0.0
        self._stored: Any = 0.0

    # -- what elements read ------------------------------------------------------------------

    def pressure(self, port: str) -> Any:
        """Return the gauge pressure at a node, tank or supply, Pa."""
        return self.given[port] if port in self.given else self._refer("output", port)

    def modulus(self, port: str) -> Any:
        """Return the effective modulus of the oil at a port, Pa."""
        return self.oil.effective_modulus(self.pressure(port))

    # -- what elements add -------------------------------------------------------------------

    def add_state(self, name: str, start: float, size: float) -> Expression:
        """Add a state and return it; its rate follows by `set_rate`."""
        self.starts[name], self.sizes[name] = start, size
        return self._refer("state", name)

    def set_rate(self, name: str, rate: Any) -> None:
        """Set the rate of a state."""
        self.rates[name] = rate

    def add_output(self, name: str, value: Any) -> None:
        """Add an output."""
        self.outputs[name] = value

    def opened(self, valve: str, over: Any) -> Any:
        """Return the opening ``S(over)`` of a valve that a pressure opens, with its way noted."""
        self.openings[valve] = limited(over, 0.0, 1.0)
        return smooth_step(over)

    def add_node(self, name: str, start: float) -> str:
        """Add a node inside an element."""
        self.nodes[name] = Place(start)
        return name

    def start_of(self, port: str) -> Any:
        """Return the pressure of a port at the start, Pa; 0 where a signal gives it."""
        if port in self.nodes:
            return self.nodes[port].start
        given = self.given[port]
        return given.of if isinstance(given, Expression) and given.operation == "number" else 0.0

    def add_volume(self, port: str, volume: Any, rate: Any, least: float, first: Any) -> None:
        """Join a volume, its rate, its smallest value and that at the start to a node."""
        if port not in self.nodes:
            return
        at = self.nodes[port]
        at.volume, at.rate = at.volume + volume, at.rate + rate
        at.least, at.first = at.least + least, at.first + first

    def add_compliance(self, port: str, compliance: Any) -> None:
        """Join a compliance, m3/Pa, to a node."""
        if port in self.nodes:
            self.nodes[port].compliance = self.nodes[port].compliance + compliance

    def add_growth(self, port: str, rate: Any) -> None:
        """Join a volume to a node that grows at a rate of its own, m3/s, at constant pressure."""
        if port in self.nodes:
            self.nodes[port].rate = self.nodes[port].rate + rate

    def add_flow(self, port: str, q: Any, density: Any = None) -> Any:
        """Let a flow q enter a node, m3/s; return its power, W.

        Where mass is the state, q is the flow at the density of the oil at the atmosphere, times
        `density`.
        """
        p = self.pressure(port)
        if density is not None:
            q = q * density
        if port in self.nodes:
            at = self.nodes[port]
            at.flow = at.flow + q
        return q * self._head(p)

    def add_passage(self, a: str, b: str, q: Any) -> Any:
        """Let a flow pass from a to b and return the power, W, that it leaves behind."""
        density: Any = None
        if self.by_mass:
            pa, pb = self.pressure(a), self.pressure(b)
            ratio = self.oil.volume_ratio
            density = where(q, 1.0 / ratio(pa), 1.0 / ratio(pb))
        given, taken = self.add_flow(a, -q, density), self.add_flow(b, q, density)
        for port, power in ((a, given), (b, taken)):
            if port in self.given:
                self.supplied(-power)
        return -given - taken

    def add_edge(
        self, element: str, a: str, b: str, kv: float, opening: Any = 1.0, flow: str = "flow"
    ) -> None:
        """Add an edge with a flow coefficient and an opening, its heat, and its flow as an output.

        Flow from a to b is positive.
        """
        q = kv * opening * edge(self.pressure(a) - self.pressure(b), self.transition)
        self.add_slope(a, b, kv / self.transition**0.5)
        self.add_heat(element, self.add_passage(a, b, q))
        self.outputs[f"{element}_{flow}"] = q

    def add_leak(self, element: str, a: str, b: str, conductance: Any, flow: str = "flow") -> None:
        """Add a laminar leak from a to b, its heat, and its flow as an output."""
        q = conductance * (self.pressure(a) - self.pressure(b))
        self.add_slope(a, b, constant(conductance) or 0.0)
        self.add_heat(element, self.add_passage(a, b, q))
        self.outputs[f"{element}_{flow}"] = q

    def add_slope(self, a: str, b: str, slope: float) -> None:
        """Add the largest slope of a flow between two ports over their pressures, m3/s/Pa."""
        for port in (a, b):
            if port in self.nodes:
                self.nodes[port].slope += float(np.real(slope))

    def add_loss(self, element: str, port: str, conductance: Any) -> None:
        """Add a laminar leak from a port to the outside, where the oil is lost."""
        p = maximum(self.pressure(port), 0.0)
        density = 1.0 / self.oil.volume_ratio(p) if self.by_mass else None
        self.add_heat(element, -self.add_flow(port, -(conductance * p), density))

    def add_heat(self, element: str, power: Any) -> None:
        """Add a power that becomes heat in an element, W."""
        self.heats[element] = self.heats.get(element, 0.0) + power

    def supplied(self, power: Any) -> None:
        """Add a power that enters the network from outside, W."""
        self._supplied = self._supplied + power

    def mechanical(self, power: Any) -> None:
        """Add a power that bodies receive, W."""
        self._mechanical = self._mechanical + power

    def stored(self, power: Any) -> None:
        """Add a power that an element stores, W."""
        self._stored = self._stored + power

    @property
    def fastest(self) -> dict[str, float]:
        """Largest rates of the pressures by node, 1/s, at the start and all edges open."""
        return {
            name: float(np.real(self.oil.modulus * at.slope / at.first))
            for name, at in self.nodes.items()
        }

    # -- equations of the nodes ----------------------------------------------------------------

    def _head(self, p: Any) -> Any:
        """Return the work of a unit of flow that enters at the pressure p, J/m3."""
        if not self.by_mass:
            return p
        K, K1 = self.oil.modulus, self.oil.modulus_slope
        if K1 == 0.0:  # integral of dp/rho over that of rho at the atmosphere
            return K * (1.0 - exp(-1.0 / K * p))
        if K1 == 1.0:
            return K * log(1.0 + 1.0 / K * p)
        return K / (K1 - 1.0) * ((1.0 + K1 / K * p) ** (1.0 - 1.0 / K1) - 1.0)

    def finish(self, book: bool) -> None:
        """Add the states and rates of the nodes, the powers and, if asked for, their integrals."""
        for name, at in self.nodes.items():
            (self._add_mass if self.by_mass else self._add_pressure)(name, at)
        heat: Any = 0.0
        for name, power in self.heats.items():
            self.outputs[f"{name}_heat"] = power
            heat = heat + power
        powers = {
            "supplied": self._supplied,
            "mechanical": self._mechanical,
            "stored": self._stored,
            "heat": heat,
        }
        for name, power in powers.items():
            self.outputs[f"{name}_power"] = power
            if book:
                self.add_state(f"{name}_work", 0.0, WORK)
                self.set_rate(f"{name}_work", power)

    def _add_pressure(self, name: str, at: Place) -> None:
        """``(V/K_e + C) p' = sum Q - V'``; below the vapour pressure the state counts vapour."""
        oil, key = self.oil, f"{name}_oil"
        p = y = self.add_state(key, at.start, PRESSURE)
        net = at.flow - at.rate
        if oil.air == 0.0:
            # below the floor, y is lower by K/V(start) times the volume of the vapour
            p = maximum(y, oil.floor)
            opened = oil.modulus / at.first
            stiff = 1.0 / (at.volume / oil.effective_modulus(p) + at.compliance)
            rate = net * where(y - oil.floor, stiff, opened)
            self.outputs[f"{name}_vapour"] = maximum((oil.floor - y) / opened, 0.0)
        else:
            rate = net / (at.volume / oil.effective_modulus(p) + at.compliance)
        self.set_rate(key, rate)
        self.outputs[name] = p
        self.stored(p * net)

    def _add_mass(self, name: str, at: Place) -> None:
        """``(m/rho_0)' = sum rho/rho_0 Q`` and the pressure of the mass in the volume."""
        oil, key = self.oil, f"{name}_oil"
        K, K1 = oil.modulus, oil.modulus_slope

        def ratio(p: float) -> Any:
            return (1.0 + K1 * p / K) ** (1.0 / K1) if K1 else 2.718281828459045 ** (p / K)

        m = self.add_state(key, at.first * ratio(at.start), at.first * PRESSURE / K)
        filled = m / at.volume
        p = K * log(filled) if K1 == 0.0 else K / K1 * (filled**K1 - 1.0)
        p = maximum(p, oil.floor)
        self.set_rate(key, at.flow)
        self.outputs[name] = p
        self.outputs[f"{name}_vapour"] = maximum(at.volume - m / ratio(oil.floor), 0.0)
        # (m e)' = sum h m' - p V'
        self.stored(at.flow * self._head(p) - p * at.rate)


def constant(x: Any) -> float | None:
    """Return the number of an input that is one, else None."""
    if isinstance(x, Expression):
        return float(np.real(x.of)) if x.operation == "number" else None
    return float(np.real(x))


def limited(x: Any, low: float, high: float) -> Any:
    """Return an expression within two limits."""
    return minimum(maximum(x, low), high)
