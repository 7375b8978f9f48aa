"""Brakes that hold a joint or a rotor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import DefaultNumber, Number, OptionalPositive
from jousto.mechanism.joints.coordinate import DAMPING, FORCE, STIFFNESS, CoordinateField
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import Expression, absolute, clip, rate, value, where
from jousto.mechanism.states.hysteresis import TOUCH
from jousto.mechanism.states.inputs import InputField


class Brake(Block, tag="brake"):
    """Brake along a coordinate q, which springs close and a command releases.

    A slipping brake has the torque `torque` against the speed. When the speed passes 0 the disc
    sticks, and its torque is ``stiffness (q - q_s) + damping q'`` about the place q_s until it
    exceeds `static`; a load below that does not move it further. Steps end where the disc sticks
    and where it slips.

    Both torques have the factor c of the closing, ``lag c' = 1 - release - c``. Outputs are the
    ``torque`` along q and ``heat_power``.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> from jousto.electric import Brake
    >>> drum = RigidBody("drum", 10.0, (0.1, 0.1, 0.2))
    >>> axle = Revolute("axle", ground["origin"], drum["origin"])
    >>> brake = Brake("brake", axle.angle, 12.0, 1e5, lag=0.05)
    >>> print(brake["torque"])
    brake.torque
    """

    kind = "brake"
    jumps = True
    coordinate: CoordinateField = field("Coordinate q that the brake holds")
    torque: Number = field("Torque of the closed brake when it slips", unit=FORCE, above=0)
    stiffness: Number = field("Stiffness of disc and hub", unit=STIFFNESS, above=0)
    static: DefaultNumber = field(
        "Largest torque of the closed brake when it sticks, not below `torque`; None for `torque`",
        unit=FORCE,
        above=0,
        default=None,
    )
    damping: Number = field(
        "Damping of disc and hub while they stick", unit=DAMPING, least=0, default=0.0,
        kw_only=True,
    )  # fmt: skip
    release: InputField = field(
        "Command: 1 releases the brake, 0 lets its springs close it", default=0.0, kw_only=True
    )
    lag: OptionalPositive = field(
        "Time constant of closing and releasing; None for none", unit="s", default=None,
        kw_only=True,
    )  # fmt: skip
    closed: Number = field(
        "Closing c at the start with a lag: 1 closed, 0 released", least=0, most=1, default=1.0,
        kw_only=True,
    )  # fmt: skip

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a static torque below the other one."""
        static: float | None = self.static
        object.__setattr__(self, "static", self.torque if static is None else static)
        if self.static < self.torque:
            text = f"static is {self.static:g}, must not be below torque, {self.torque:g}"
            problems.add(where, text, "static")

    outputs = ("torque", "heat_power")

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial closing, with a lag."""
        return {} if self.lag is None else {"closing": self.closed}

    @property
    def memories(self) -> Mapping[str, float]:
        """Place of the sticking disc, direction of the slip or 0, and whether a run has begun."""
        return {"place": self.coordinate.initial, "side": 0.0, "begun": 0.0}

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return torque and heat, and what is kept of them."""
        q, v, k = value(self.coordinate), rate(self.coordinate), self.stiffness
        wanted: Any = 1.0 - clip(self.release, 0.0, 1.0)
        made = Equations()
        c = wanted
        if self.lag is not None:
            c = x["closing"]
            made.rates["closing"] = (wanted - c) / self.lag
        sliding, most = self.torque * c, (1.0 + TOUCH) * self.static * c
        side, begun = x["side"], x["begun"]
        slips = side * side
        held = k * (q - x["place"]) + self.damping * v
        torque = where(slips, side * sliding, held)
        forward = where(v, 1.0, where(0.0 - v, -1.0, 0.0))
        breaks = where(held - most, 1.0, where(0.0 - held - most, -1.0, 0.0))
        after = where(slips, where(side * v, side, 0.0), breaks)
        after = where(begun, after, forward)
        place = where(slips, q - side * sliding / k, x["place"])
        made.updates.update(side=after, place=where(begun, place, q), begun=1.0)
        made.margin = where(slips, side * v, most - absolute(held))
        heat = where(slips, sliding * absolute(v), self.damping * v * v)
        made.outputs.update(torque=0.0 - torque, heat_power=heat)
        made.forces = [(self.coordinate, 0.0 - torque)]
        return made
