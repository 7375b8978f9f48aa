"""Places with a pressure: nodes, tanks, supplies; and given flows."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.hydraulics.element import HydraulicElement, Port
from jousto.mechanism.states.inputs import InputField

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit


class Node(HydraulicElement, tag="node"):
    """Oil with one pressure: own volume, and chambers, hoses and accumulators joined to it."""

    kind = "node"
    own: ClassVar[bool] = True
    volume: Number = field(
        "Volume of lines and blocks, without chambers joined to the node", unit="m3", least=0,
        default=0.0,
    )  # fmt: skip
    start: Number = field("Gauge pressure at the start", unit="Pa", default=0.0, kw_only=True)
    compliance: Number = field(
        "Volume over pressure by which walls give way, such as those of hoses", unit="m3/Pa",
        least=0, default=0.0, kw_only=True,
    )  # fmt: skip

    def connect(self, circuit: Circuit) -> None:
        """Add the own volume and compliance."""
        circuit.add_compliance(self.name, self.compliance)
        circuit.add_volume(self.name, self.volume, 0.0, self.volume, self.volume)


class Tank(HydraulicElement, tag="tank"):
    """Tank: oil at a given pressure, that of the atmosphere as a rule."""

    kind = "tank"
    own: ClassVar[bool] = True
    pressure: InputField = field("Gauge pressure", unit="Pa", default=0.0)

    def connect(self, circuit: Circuit) -> None:
        """Add nothing: the pressure is given."""


class Supply(HydraulicElement, tag="supply"):
    """Supply with a given pressure, whatever flow is taken."""

    kind = "supply"
    own: ClassVar[bool] = True
    pressure: InputField = field("Gauge pressure", unit="Pa")

    def connect(self, circuit: Circuit) -> None:
        """Add nothing: the pressure is given."""


class FlowSource(HydraulicElement, tag="flow-source"):
    """Given flow into a node, whatever its pressure."""

    kind = "flow source"
    port: Port = field("Node into which the oil flows")
    flow: InputField = field("Flow", unit="m3/s")

    def connect(self, circuit: Circuit) -> None:
        """Add the flow, and the power ``p Q`` that it supplies."""
        circuit.supplied(circuit.add_flow(self.port, self.flow))
