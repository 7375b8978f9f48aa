"""Hoses and lines with the inertia, friction and compliance of their oil."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber, Whole
from jousto.mechanism.hydraulics.element import HydraulicElement, Port
from jousto.mechanism.states.expression import absolute

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit

BLASIUS = 1187.0
"""Reynolds number at which the laws of laminar and of turbulent flow (Blasius) meet."""


class Hose(HydraulicElement, tag="hose"):
    """Hose from a to b in cells: ``rho l/A Q' = dp - f(Q)`` each, and the compliance of its wall.

    Friction f goes from laminar flow to the law of Blasius,
    ``128 mu l Q/(pi d^4) (1 + (Re/1187)^3)^(1/4)``. The volume of the last cell belongs to the
    node b. n cells have the first frequency ``2 n sin(pi/(2 (2 n + 1)))/(l sqrt(rho/K))``: with 8
    cells that is 6 % below the quarter wave.
    """

    kind = "hose"
    a: Port = field("One end")
    b: Port = field("Other end, a node")
    length: Number = field("Length", unit="m", above=0)
    diameter: Number = field("Inner diameter", unit="m", above=0)
    wall: Number = field(
        "Volume of the wall over volume and pressure, D/(E t) for a pipe", unit="1/Pa", least=0,
        default=0.0, kw_only=True,
    )  # fmt: skip
    cells: Whole = field("Number of cells", least=1, default=1, kw_only=True)
    burst: OptionalNumber = field(
        "Burst pressure; pressures at the start and relief valves above it are refused",
        unit="Pa",
        above=0,
        default=None,
        kw_only=True,
    )

    def check_with(self, problems: Problems, where: str, circuit: Circuit) -> None:
        """Report an end b that is no node."""
        if self.b in circuit.given:
            problems.add(where, f"b is {self.b!r}, must be a node; swap a and b, or add a node")
        if self.burst is not None:
            circuit.limits.append((self, self.burst, (self.a, self.b)))

    def connect(self, circuit: Circuit) -> None:
        """Add the cells."""
        n, oil = self.cells, circuit.oil
        A, l = math.pi / 4 * self.diameter**2, self.length / n
        at = self.a
        first = circuit.start_of(self.b)
        for i in range(n):
            last = i == n - 1
            to = self.b if last else circuit.add_node(f"{self.name}_{i + 1}", first)
            circuit.add_volume(to, A * l, 0.0, A * l, A * l)
            circuit.add_compliance(to, A * l * self.wall)
            key = f"{self.name}_q{i + 1}"
            q = circuit.add_state(key, 0.0, 1e-4)
            drop = circuit.pressure(at) - circuit.pressure(to)
            friction = self._friction(q, l, A, oil.viscosity, oil.density)
            slope = (drop - friction) * (A / (oil.density * l))
            circuit.set_rate(key, slope)
            circuit.add_passage(at, to, q)
            circuit.add_heat(self.name, friction * q)
            circuit.stored((drop - friction) * q)
            at = to
        circuit.add_output(f"{self.name}_flow", q)

    def _friction(self, q: Any, l: float, A: float, viscosity: float, density: float) -> Any:
        d = self.diameter
        re = absolute(q) * (d * density / (A * viscosity * BLASIUS))
        return 128.0 * viscosity * l / (math.pi * d**4) * q * (1.0 + re * re * re) ** 0.25
