"""Valves that hold a pressure or a flow, or choose a way: all openings are smooth steps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.hydraulics.element import HydraulicElement, OptionalPort, Port
from jousto.mechanism.hydraulics.laws import edge, held_drop
from jousto.mechanism.hydraulics.orifice import EdgeElement
from jousto.mechanism.hydraulics.pressure_valves import check_opening
from jousto.mechanism.states.expression import maximum
from jousto.mechanism.states.inputs import InputField

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit


class ReducingValve(EdgeElement, tag="reducing-valve"):
    """Pressure reducing valve: holds the pressure at b, opening ``1 - S((p_b - setting)/full)``.

    With a tank port it also relieves b: the opening to the tank is
    ``S((p_b - setting - full)/full)``. Pressures are those over the tank, or gauge pressures.
    """

    kind = "reducing valve"
    a: Port = field("Port of the supply")
    b: Port = field("Port whose pressure is held")
    tank: OptionalPort = field("Port to which a pressure at b that is too high is relieved; None "
                               "for a valve with two ports", default=None)  # fmt: skip
    setting: InputField = field("Pressure at b at which it begins to close", unit="Pa",
                                kw_only=True)  # fmt: skip
    full: Number = field(
        "Further pressure at which it is closed", unit="Pa", above=0, default=1e6, kw_only=True
    )

    def connect(self, circuit: Circuit) -> None:
        """Add the flow, and that to the tank."""
        p = circuit.pressure(self.b)
        if self.tank is not None:
            p = p - circuit.pressure(self.tank)
        over = (p - self.setting) / self.full
        opening = 1.0 - circuit.opened(f"reducing valve {self.name!r} (full)", over)
        circuit.add_output(f"{self.name}_opening", opening)
        circuit.add_edge(self.name, self.a, self.b, self.kv, opening)
        if self.tank is not None:
            relief = circuit.opened(f"tank edge of reducing valve {self.name!r} (full)", over - 1.0)
            circuit.add_edge(self.name, self.b, self.tank, self.kv, relief, "tank_flow")


class SequenceValve(EdgeElement, tag="sequence-valve"):
    """Sequence valve: opening ``S((p_a - p_drain - setting)/full)``, whatever the pressure at b."""

    kind = "sequence valve"
    a: Port = field("Port whose pressure opens it")
    b: Port = field("Port to which the oil goes then")
    drain: OptionalPort = field("Port of the spring's side; None for the atmosphere", default=None)
    setting: InputField = field("Pressure at a at which it opens", unit="Pa", kw_only=True)
    full: Number = field(
        "Further pressure at which it is fully open", unit="Pa", above=0, default=1e6, kw_only=True
    )

    def connect(self, circuit: Circuit) -> None:
        """Add the flow."""
        p = circuit.pressure(self.a)
        if self.drain is not None:
            p = p - circuit.pressure(self.drain)
        over = (p - self.setting) / self.full
        opening = circuit.opened(f"sequence valve {self.name!r} (full)", over)
        circuit.add_output(f"{self.name}_opening", opening)
        circuit.add_edge(self.name, self.a, self.b, self.kv, opening)


class ShuttleValve(EdgeElement, tag="shuttle-valve"):
    """Shuttle valve: joins the side with the higher pressure to its outlet.

    The edge of a is open by ``S((p_a - p_b)/full + 1/2)``, that of b by the rest.
    """

    kind = "shuttle valve"
    a: Port = field("One side")
    b: Port = field("Other side")
    outlet: Port = field("Port to which the higher pressure is passed")
    full: Number = field(
        "Pressure difference along which it switches over", unit="Pa", above=0, default=1e5,
        kw_only=True,
    )  # fmt: skip

    def connect(self, circuit: Circuit) -> None:
        """Add the two flows."""
        over = (circuit.pressure(self.a) - circuit.pressure(self.b)) / self.full + 0.5
        opening = circuit.opened(f"shuttle valve {self.name!r} (full)", over)
        circuit.add_output(f"{self.name}_opening", opening)
        circuit.add_edge(self.name, self.a, self.outlet, self.kv, opening, "a_flow")
        circuit.add_edge(self.name, self.b, self.outlet, self.kv, 1.0 - opening, "b_flow")


class FlowControlValve(HydraulicElement, tag="flow-control-valve"):
    """Pressure compensated flow control: a flow that does not depend on the pressures.

    A compensator holds the drop of the metering edge: up to ``margin - full/2`` it is the whole
    drop, from ``margin + full/2`` on it is `margin`. Backwards the metering edge is free.
    """

    kind = "flow control valve"
    a: Port = field("Side from which oil flows")
    b: Port = field("Side to which oil flows")
    flow: Number = field("Flow that is held when fully open", unit="m3/s", above=0, kw_only=True)
    margin: Number = field(
        "Pressure drop that the compensator holds at the metering edge", unit="Pa", above=0,
        default=8e5, kw_only=True,
    )  # fmt: skip
    full: Number = field(
        "Pressure drop along which the compensator closes", unit="Pa", above=0, default=4e5,
        kw_only=True,
    )  # fmt: skip
    opening: InputField = field("Opening of the metering edge, 0 to 1", default=1.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a compensator that would close before there is a drop."""
        if not self.full <= 2.0 * self.margin:
            problems.add(where, f"full is {self.full:g} Pa, must be at most twice the margin "
                         f"{self.margin:g} Pa")  # fmt: skip

    def connect(self, circuit: Circuit) -> None:
        """Add the flow and its heat."""
        margin, t = self.margin, circuit.transition
        kv = self.flow / (margin / (margin**2 + t**2) ** 0.25)
        dp = circuit.pressure(self.a) - circuit.pressure(self.b)
        q = kv * self.opening * edge(held_drop(dp, margin, self.full), t)
        circuit.add_slope(self.a, self.b, kv / t**0.5)
        circuit.add_heat(self.name, circuit.add_passage(self.a, self.b, q))
        circuit.add_output(f"{self.name}_flow", q)


class PilotCheckValve(EdgeElement, tag="pilot-check-valve"):
    """Check valve from a to b that a pilot pressure opens backwards.

    Opening ``S((p_a - p_b + R max(p_pilot - p_a, 0) - cracking)/(full - cracking))``, R the area of
    the pilot piston over that of the seat.
    """

    kind = "pilot check valve"
    a: Port = field("Side of the valve, from which oil flows freely")
    b: Port = field("Side of the load, which is held")
    pilot: Port = field("Pilot port")
    ratio: Number = field("Ratio R of the areas", above=0, default=3.0, kw_only=True)
    cracking: Number = field(
        "Pressure difference at which it opens", unit="Pa", default=5e4, kw_only=True
    )
    full: Number = field(
        "Pressure difference at which it is fully open", unit="Pa", default=2e5, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a valve that is open before it opens."""
        check_opening(problems, where, self.cracking, self.full)

    def connect(self, circuit: Circuit) -> None:
        """Add the flow."""
        p = circuit.pressure(self.a)
        pushed = self.ratio * maximum(circuit.pressure(self.pilot) - p, 0.0)
        over = (p - circuit.pressure(self.b) + pushed - self.cracking) / (self.full - self.cracking)
        opening = circuit.opened(f"pilot check valve {self.name!r} (full)", over)
        circuit.add_output(f"{self.name}_opening", opening)
        circuit.add_edge(self.name, self.a, self.b, self.kv, opening)
