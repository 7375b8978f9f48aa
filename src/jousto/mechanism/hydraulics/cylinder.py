"""Hydraulic cylinders between two bodies."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import OptionalItem, field, kept
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.bodies.marker import MarkerField
from jousto.mechanism.hydraulics.element import HydraulicElement, OptionalPort, Port
from jousto.mechanism.hydraulics.laws import coefficient, edge
from jousto.mechanism.joints.coordinate import Distance
from jousto.mechanism.states.expression import (
    absolute,
    exp,
    maximum,
    rate,
    smooth_step,
    value,
    where,
)
from jousto.mechanism.states.inputs import InputField

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit

PLACED = 1e-9
"""Distance beyond an end of the stroke, over the stroke, that is rounding."""


class Cushion(Declared, by_value=True, kw_only=True):
    """Cushion at an end of the stroke: an edge that closes over the last way.

    Oil leaves through ``least + (1 - least) S(way/length)`` of the edge, with the smooth step S;
    it enters through a check valve of the same size, too.
    """

    kind = "cushion"
    length: Number = field("Way along which the edge closes", unit="m", above=0)
    flow: Number = field("Flow through the open edge at the nominal drop", unit="m3/s", above=0)
    drop: Number = field("Nominal pressure drop", unit="Pa", above=0, default=3.5e6)
    least: Number = field("Opening at the end", above=0, most=1, default=0.01)
    start: OptionalNumber = field(
        "Gauge pressure of the chamber at the start; None for that of the port", unit="Pa",
        default=None,
    )  # fmt: skip


class HydraulicCylinder(HydraulicElement, tag="cylinder"):
    """Cylinder between two markers: force ``p1 A1 - p2 A2`` apart, less friction.

    Chambers have the volumes ``V1 + A1 x`` and ``V2 + A2 (s - x)``, x the distance of the markers
    less the closed length, s the stroke.
    """

    kind = "cylinder"
    a: MarkerField = field("Marker at the housing")
    b: MarkerField = field("Marker at the rod")
    piston: Port = field("Node of the piston side, which pushes the markers apart")
    rod_side: OptionalPort = field("Node of the rod side; None for a plunger", default=None)
    bore: Number = field("Diameter of the piston", unit="m", above=0, kw_only=True)
    rod: Number = field("Diameter of the rod", unit="m", least=0, default=0.0, kw_only=True)
    stroke: Number = field("Stroke s", unit="m", above=0, kw_only=True)
    closed: Number = field(
        "Distance of the markers with the rod fully in", unit="m", least=0, kw_only=True
    )
    piston_volume: Number = field(
        "Volume V1 of the piston side at x = 0", unit="m3", least=0, default=1e-4, kw_only=True
    )
    rod_volume: Number = field(
        "Volume V2 of the rod side at x = s", unit="m3", least=0, default=1e-4, kw_only=True
    )
    leak: InputField = field("Leak across the piston", unit="m3/s/Pa", default=0.0, kw_only=True)
    rod_leak: InputField = field(
        "Leak of the rod side to the outside", unit="m3/s/Pa", default=0.0, kw_only=True
    )
    damping: Number = field("Viscous friction", unit="N s/m", least=0, default=0.0, kw_only=True)
    seal: Number = field(
        "Friction of the seals when they slide", unit="N", least=0, default=0.0, kw_only=True
    )
    seal_pressure: Number = field(
        "Further friction over the pressure difference", unit="N/Pa", least=0, default=0.0,
        kw_only=True,
    )  # fmt: skip
    stick: Number = field(
        "Largest friction at rest over that when sliding", least=1, default=1.0, kw_only=True
    )
    stribeck: Number = field(
        "Speed at which the difference has fallen to 1/e", unit="m/s", above=0, default=0.01,
        kw_only=True,
    )  # fmt: skip
    seal_stiffness: Number = field(
        "Stiffness of the seals before they slide", unit="N/m", above=0, default=1e7, kw_only=True
    )
    end_stiffness: Number = field(
        "Stiffness of the metal stops at both ends", unit="N/m", above=0, default=2e8, kw_only=True
    )
    piston_cushion: OptionalItem[Cushion] = field(
        "Cushion at x = 0, between the chamber and its port", default=None, kw_only=True
    )
    rod_cushion: OptionalItem[Cushion] = field("Cushion at x = s", default=None, kw_only=True)
    start: Any = kept()
    length: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a rod that does not fit; keep the distance of the markers."""
        if not self.rod < self.bore:
            problems.add(where, f"rod is {self.rod:g} m, must be below the bore {self.bore:g} m")
        line = Distance(self.a, self.b, name=f"length of {self.name}")
        object.__setattr__(self, "length", line)
        object.__setattr__(self, "start", line.initial - self.closed)

    @property
    def areas(self) -> tuple[float, float]:
        """Areas of the piston side and of the rod side, m2."""
        first = math.pi / 4 * self.bore**2
        return first, first - math.pi / 4 * self.rod**2

    def check_with(self, problems: Problems, where: str, circuit: Circuit) -> None:
        """Report a start beyond the stroke, and a cushion or a seal without rod side."""
        x, limit = self.start.real, PLACED * self.stroke
        if not -limit <= x <= self.stroke + limit:
            text = f"the markers are {x + self.closed:g} m apart, which is not within closed to"
            problems.add(where, f"{text} closed + stroke, {self.closed:g} to "
                         f"{self.closed + self.stroke:g} m; change closed or the pose")  # fmt: skip
        if self.rod_side is None and self.rod_cushion is not None:
            problems.add(where, "has a rod_cushion but no rod_side; give the node of the rod side")

    def connect(self, circuit: Circuit) -> None:
        """Add volumes, leaks, friction and the force."""
        A1, A2 = self.areas
        x, v, s = value(self.length) - self.closed, rate(self.length), self.stroke
        start = self.start
        one = self._chamber(circuit, self.piston, self.piston_cushion, x, "piston")
        circuit.add_volume(one, self.piston_volume + A1 * x, A1 * v, self.piston_volume,
                           self.piston_volume + A1 * start)  # fmt: skip
        p1, p2 = circuit.pressure(one), 0.0
        if self.rod_side is not None:
            two = self._chamber(circuit, self.rod_side, self.rod_cushion, s - x, "rod")
            circuit.add_volume(two, self.rod_volume + A2 * (s - x), -A2 * v, self.rod_volume,
                               self.rod_volume + A2 * (s - start))  # fmt: skip
            p2 = circuit.pressure(two)
            if not _is_zero(self.leak):
                circuit.add_leak(self.name, one, two, self.leak, "leak_flow")
            if not _is_zero(self.rod_leak):
                circuit.add_loss(self.name, two, self.rod_leak)
        else:
            A2 = 0.0
        for port, p, flow in ((one, p1, A1 * v), (self.rod_side and two, p2, -A2 * v)):
            if port in circuit.given:  # a chamber with a given pressure takes oil from there
                circuit.supplied(p * flow)
        push = A1 * p1 - A2 * p2
        friction = self._friction(circuit, v, p1 - p2)
        circuit.mechanical((push - friction) * v)
        end = self.end_stiffness
        stops = end * maximum(0.0, -x) - end * maximum(0.0, x - s)
        force = push - friction + stops
        circuit.forces.append((self.length, force))
        for key, found in (("force", force), ("x", x), ("friction", friction)):
            circuit.add_output(f"{self.name}_{key}", found)

    def _chamber(self, circuit: Circuit, port: str, cushion: Any, way: Any, side: str) -> str:
        """Return the node of a chamber: that of its port, or its own one behind a cushion."""
        if cushion is None:
            return port
        start = circuit.start_of(port) if cushion.start is None else cushion.start
        name = circuit.add_node(f"{self.name}_{side}", start)
        kv = coefficient(cushion.flow, cushion.drop)
        left = cushion.least
        opening = left + (1.0 - left) * smooth_step(way / cushion.length)
        # towards the chamber the check valve opens beside the edge
        dp = circuit.pressure(port) - circuit.pressure(name)
        q = kv * (opening + where(dp, 1.0, 0.0)) * edge(dp, circuit.transition)
        circuit.add_slope(port, name, 2.0 * kv / circuit.transition**0.5)
        circuit.add_heat(self.name, circuit.add_passage(port, name, q))
        return name

    def _friction(self, circuit: Circuit, v: Any, dp: Any) -> Any:
        """Return viscous friction and that of seals, which are elastic before they slide."""
        force = self.damping * v
        heat: Any = force * v
        if self.seal or self.seal_pressure:
            slide = self.seal + self.seal_pressure * absolute(dp)
            most = slide * (1.0 + (self.stick - 1.0) * exp(0.0 - (v / self.stribeck) ** 2.0))
            k, key = self.seal_stiffness, f"{self.name}_seal"
            z = circuit.add_state(key, 0.0, 1e-5)
            dz = v - k / most * absolute(v) * z
            circuit.set_rate(key, dz)
            force = force + k * z
            heat = heat + k * z * (v - dz)
            circuit.stored(k * z * dz)
        circuit.add_heat(self.name, heat)
        return force


def _is_zero(x: Any) -> bool:
    return bool(x.operation == "number" and x.of == 0.0)
