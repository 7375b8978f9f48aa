"""Valves that pressures open: relief, check and counterbalance valves."""

from __future__ import annotations

from typing import TYPE_CHECKING

from jousto.base.errors import Problems
from jousto.base.fields import Flag, field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.hydraulics.element import OptionalPort, Port
from jousto.mechanism.hydraulics.orifice import EdgeElement
from jousto.mechanism.states.expression import smooth_step
from jousto.mechanism.states.inputs import InputField

if TYPE_CHECKING:
    from jousto.mechanism.hydraulics.circuit import Circuit


class ReliefValve(EdgeElement, tag="relief-valve"):
    """Relief valve: opening ``S((p_a - p_b - setting)/full)`` with the smooth step S.

    With a lag the opening follows by ``lag o' = S - o``.
    """

    kind = "relief valve"
    a: Port = field("Side that is protected")
    b: Port = field("Side to which the oil leaves")
    setting: InputField = field("Pressure difference at which it opens", unit="Pa", kw_only=True)
    full: Number = field(
        "Further pressure at which it is fully open", unit="Pa", above=0, default=1e6, kw_only=True
    )
    lag: OptionalNumber = field(
        "Time constant of the opening; None for none", unit="s", above=0, default=None, kw_only=True
    )

    def connect(self, circuit: Circuit) -> None:
        """Add the flow."""
        dp = circuit.pressure(self.a) - circuit.pressure(self.b)
        over = (dp - self.setting) / self.full
        if self.lag is None:
            opening = circuit.opened(f"relief valve {self.name!r} (full)", over)
        else:
            opening, key = smooth_step(over), f"{self.name}_open"
            o = circuit.add_state(key, 0.0, 1.0)
            circuit.set_rate(key, (opening - o) / self.lag)
            opening = o
        circuit.add_output(f"{self.name}_opening", opening)
        circuit.add_edge(self.name, self.a, self.b, self.kv, opening)


class CheckValve(EdgeElement, tag="check-valve"):
    """Check valve: opening ``S((p_a - p_b - cracking)/(full - cracking))``, flow from a to b."""

    kind = "check valve"
    a: Port = field("Side from which oil flows")
    b: Port = field("Side to which oil flows")
    cracking: Number = field(
        "Pressure difference at which it opens", unit="Pa", default=5e4, kw_only=True
    )
    full: Number = field(
        "Pressure difference at which it is fully open", unit="Pa", default=2e5, kw_only=True
    )
    leak: Number = field(
        "Smallest opening, also backwards", least=0, below=1, default=0.0, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a valve that is open before it opens."""
        check_opening(problems, where, self.cracking, self.full)

    def connect(self, circuit: Circuit) -> None:
        """Add the flow."""
        dp = circuit.pressure(self.a) - circuit.pressure(self.b)
        over = (dp - self.cracking) / (self.full - self.cracking)
        opening = circuit.opened(f"check valve {self.name!r} (full)", over)
        opening = self.leak + (1.0 - self.leak) * opening
        circuit.add_edge(self.name, self.a, self.b, self.kv, opening)


class CounterbalanceValve(EdgeElement, tag="counterbalance-valve"):
    """Counterbalance valve: opening ``S((p_load + R p_pilot - b p_line - setting)/full)``.

    R is the pilot ratio, b is 1 + R, or 0 for a vented valve. A check valve lets oil pass from the
    line to the load.
    """

    kind = "counterbalance valve"
    load: Port = field("Port of the load that is held")
    line: Port = field("Port of the line to the directional valve")
    pilot: OptionalPort = field(
        "Pilot port; None for a valve that only its load opens", default=None
    )
    setting: InputField = field("Pressure at which it opens", unit="Pa", kw_only=True)
    full: Number = field(
        "Further pressure at which it is fully open", unit="Pa", above=0, default=2e6, kw_only=True
    )
    ratio: Number = field("Pilot ratio R", least=0, default=3.0, kw_only=True)
    vented: Flag = field(
        "Whether the pressure of the line does not act on the spring's side", default=False,
        kw_only=True,
    )  # fmt: skip
    cracking: Number = field(
        "Pressure difference at which the check valve opens", unit="Pa", default=5e4, kw_only=True
    )
    check_full: Number = field(
        "Pressure difference at which it is fully open", unit="Pa", default=2e5, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a check valve that is open before it opens."""
        check_opening(problems, where, self.cracking, self.check_full)

    def connect(self, circuit: Circuit) -> None:
        """Add the flows through both valves."""
        p, back = circuit.pressure(self.load), circuit.pressure(self.line)
        x = p - self.setting
        if self.pilot is not None:
            x = x + self.ratio * circuit.pressure(self.pilot)
        if not self.vented:
            x = x - (1.0 + self.ratio) * back
        opening = circuit.opened(f"counterbalance valve {self.name!r} (full)", x / self.full)
        over = (back - p - self.cracking) / (self.check_full - self.cracking)
        check = circuit.opened(f"check valve of {self.name!r} (check_full)", over)
        circuit.add_output(f"{self.name}_opening", opening)
        circuit.add_edge(self.name, self.load, self.line, self.kv, opening + check)


def check_opening(problems: Problems, where: str, cracking: float, full: float) -> None:
    """Report a valve that is fully open before it opens."""
    if not full > cracking:
        problems.add(where, f"is fully open at {full:g} Pa, must be above the cracking pressure "
                     f"{cracking:g} Pa")  # fmt: skip
