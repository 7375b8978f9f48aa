"""Edges and gaps between two places."""

from __future__ import annotations

from typing import TYPE_CHECKING

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.hydraulics.element import HydraulicElement, Port
from jousto.mechanism.hydraulics.laws import area_coefficient, coefficient, gap_conductance
from jousto.mechanism.states.inputs import InputField, OptionalInput

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit


class EdgeElement(HydraulicElement):
    """Base of the elements whose edges have a nominal flow at a nominal pressure drop."""

    flow: Number = field(
        "Flow of a fully open edge at the nominal drop", unit="m3/s", above=0, kw_only=True
    )
    drop: Number = field(
        "Nominal pressure drop of one edge", unit="Pa", above=0, default=3.5e6, kw_only=True
    )

    @property
    def kv(self) -> float:
        """Flow coefficient ``Q/sqrt(dp)`` of a fully open edge."""
        return coefficient(self.flow, self.drop)


class Orifice(HydraulicElement, tag="orifice"):
    """Edge ``Q = kv o dp/(dp^2 + t^2)^(1/4)``, turbulent above the transition pressure t.

    Give a nominal flow and drop, or an area.
    """

    kind = "orifice"
    a: Port = field("One side")
    b: Port = field("Other side; flow from a to b is positive")
    flow: OptionalNumber = field(
        "Flow when fully open at the nominal drop", unit="m3/s", above=0, default=None, kw_only=True
    )
    drop: Number = field("Nominal pressure drop", unit="Pa", above=0, default=3.5e6, kw_only=True)
    area: OptionalNumber = field(
        "Area of the opening, instead of flow and drop", unit="m2", above=0, default=None,
        kw_only=True,
    )  # fmt: skip
    discharge: Number = field("Discharge coefficient", above=0, default=0.7, kw_only=True)
    opening: InputField = field("Opening from 0 to 1", default=1.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a size that is missing or given twice."""
        if (self.flow is None) == (self.area is None):
            problems.add(where, "give either flow, with its drop, or area")

    def connect(self, circuit: Circuit) -> None:
        """Add the flow and its heat."""
        if self.flow is None:
            kv = area_coefficient(self.area or 0.0, self.discharge, circuit.oil.density)
        else:
            kv = coefficient(self.flow, self.drop)
        circuit.add_edge(self.name, self.a, self.b, kv, self.opening)


class Leak(HydraulicElement, tag="leak"):
    """Laminar leak ``Q = G dp``: a conductance, which may grow, or an annular gap."""

    kind = "leak"
    a: Port = field("One side")
    b: Port = field("Other side")
    conductance: OptionalInput = field("Conductance G", unit="m3/s/Pa", default=None)
    diameter: OptionalNumber = field(
        "Diameter of a gap", unit="m", above=0, default=None, kw_only=True
    )
    clearance: OptionalNumber = field(
        "Radial clearance of the gap", unit="m", above=0, default=None, kw_only=True
    )
    length: OptionalNumber = field(
        "Length of the gap", unit="m", above=0, default=None, kw_only=True
    )
    eccentricity: Number = field(
        "Eccentricity over the clearance", least=0, most=1, default=0.0, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a gap that is incomplete, or given beside a conductance."""
        gap = (self.diameter, self.clearance, self.length)
        given = sum(x is not None for x in gap)
        if given not in (0, 3) or (given == 3) == (self.conductance is not None):
            problems.add(where, "give either conductance, or diameter, clearance and length")

    def connect(self, circuit: Circuit) -> None:
        """Add the flow and its heat."""
        G = self.conductance
        if G is None:
            assert self.diameter and self.clearance and self.length
            size = (self.diameter, self.clearance, self.length, self.eccentricity)
            G = gap_conductance(*size, circuit.oil.viscosity)
        circuit.add_leak(self.name, self.a, self.b, G)
