"""Directional valves with four edges and a spool."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.hydraulics.circuit import limited
from jousto.mechanism.hydraulics.element import OptionalPort, Port
from jousto.mechanism.hydraulics.laws import spool_opening
from jousto.mechanism.hydraulics.orifice import EdgeElement
from jousto.mechanism.states.expression import absolute, clip, maximum, minimum, where
from jousto.mechanism.states.inputs import InputField, OptionalInput

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit

RETURN = 10.0
"""Rate over the natural frequency with which a spool returns to its largest speed."""
STOP = 100.0
"""Rate over the natural frequency with which a stuck spool stops."""


class DirectionalValve(EdgeElement, tag="directional-valve"):
    """4/3 valve: a spool position x > 0 opens P to A and B to T, x < 0 opens P to B and A to T.

    Each edge opens over ``r((x - d)/(1 - d))`` with its overlap d; a negative one leaves the edge
    open in the centre. With a frequency the spool follows the command by
    ``x'' = w^2 (u - x) - 2 D w x'``, without one at once.
    """

    kind = "directional valve"
    supply: Port = field("Port P")
    tank: Port = field("Port T")
    a: Port = field("Port A")
    b: OptionalPort = field("Port B; None for a 3/3 valve", default=None)
    command: InputField = field("Command u from -1 to 1", default=0.0, kw_only=True)
    overlap: Number = field(
        "Overlap d of the edges at P over the stroke", above=-1, below=1, default=0.0, kw_only=True
    )
    tank_overlap: OptionalNumber = field(
        "Overlap of the edges at T; None for the same", above=-1, below=1, default=None,
        kw_only=True,
    )  # fmt: skip
    leak: Number = field(
        "Smallest opening of each edge", least=0, below=1, default=0.0, kw_only=True
    )
    frequency: OptionalNumber = field(
        "Natural frequency of the spool; None for a spool without delay", unit="Hz", above=0,
        default=None, kw_only=True,
    )  # fmt: skip
    damping: Number = field("Damping ratio D of the spool", above=0, default=0.9, kw_only=True)
    rate_limit: OptionalNumber = field(
        "Largest rate of the spool, strokes per second", unit="1/s", above=0, default=None,
        kw_only=True,
    )  # fmt: skip
    stuck: OptionalInput = field(
        "1 while the spool is stuck, 0 while it moves", default=None, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report options of a spool that has no dynamics."""
        for key in ("rate_limit", "stuck"):
            if self.frequency is None and getattr(self, key) is not None:
                problems.add(where, f"{key} needs a spool with dynamics; give its frequency")

    def connect(self, circuit: Circuit) -> None:
        """Add the spool and the four edges."""
        x = self._spool(circuit)
        circuit.add_output(f"{self.name}_spool", x)
        first = self.overlap
        second = first if self.tank_overlap is None else self.tank_overlap
        back = 0.0 - x
        edges = [
            ("pa", self.supply, self.a, x, first),
            ("at", self.a, self.tank, back, second),
        ]
        if self.b is not None:
            edges += [
                ("pb", self.supply, self.b, back, first),
                ("bt", self.b, self.tank, x, second),
            ]
        for name, one, two, way, overlap in edges:
            opening = self.leak + (1.0 - self.leak) * spool_opening(way, overlap)
            circuit.add_edge(self.name, one, two, self.kv, opening, f"{name}_flow")

    def _spool(self, circuit: Circuit) -> Any:
        u = clip(self.command, -1.0, 1.0)
        if self.frequency is None:
            return u
        w, D, R = 2.0 * math.pi * self.frequency, self.damping, self.rate_limit
        position, speed = f"{self.name}_position", f"{self.name}_speed"
        x = circuit.add_state(position, 0.0, 1.0)
        v = circuit.add_state(speed, 0.0, w)
        moving = v if R is None else limited(v, -R, R)
        a = w * w * (u - x) - 2.0 * D * w * moving
        if R is not None:  # at the limit the speed stays while it would grow
            back = RETURN * w
            a = where(
                absolute(v) - R,
                where(v, minimum(a, back * (R - v)), maximum(a, back * (0.0 - R - v))),
                a,
            )
        if self.stuck is not None:
            free = 1.0 - self.stuck
            moving, a = free * moving, free * a - self.stuck * (STOP * w) * v
        circuit.set_rate(position, moving)
        circuit.set_rate(speed, a)
        return clip(x, -1.0, 1.0)
