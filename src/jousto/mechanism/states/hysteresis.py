"""Blocks that depend on the motion before: play, relay with hysteresis, Bouc-Wen spring."""

from __future__ import annotations

from collections.abc import Mapping

from jousto.base.errors import Problems, warn
from jousto.base.fields import Flag, field
from jousto.base.numbers import Number, Positive
from jousto.mechanism.joints.coordinate import STIFFNESS, CoordinateField
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import (
    Expression,
    absolute,
    maximum,
    minimum,
    rate,
    value,
    where,
)
from jousto.mechanism.states.inputs import InputField

TOUCH = 1e-10
"""Excess over the play, relative to it, from which on the ends touch; larger than round-off."""


class Play(Block, tag="play"):
    """Play: y rests while the input is within the play about it, else the input drags it along.

    ``y = min(max(y, u - r), u + r)``. A loop of amplitude A > r has the area ``4 r (A - r)``. Steps
    end where the input turns and where it touches, unless it depends on rates of coordinates.
    """

    kind = "play"
    outputs = ("y",)
    input: InputField = field("Input u")
    play: Positive = field("Half of the play, r")
    initial: Number = field("Value of y at the start", default=0.0, kw_only=True)

    @property
    def memories(self) -> Mapping[str, float]:
        """Value of y at the last end of a step, and the side that dragged it there."""
        return {"held": self.initial, "side": 0.0}

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the output, and what is kept of it."""
        u, r, held = self.input, self.play, x["held"]
        y = minimum(maximum(held, u - r), u + r)
        speed = Expression("rate of", (u,))
        # +1 where u - r drags y up, -1 where u + r drags it down, while u goes on
        up = where(speed, where(u - r - held, 1.0, 0.0), 0.0)
        down = where(0.0 - speed, where(held - u - r, 1.0, 0.0), 0.0)
        free = r * (1.0 + TOUCH) - absolute(u - held)
        margin = where(x["side"] * x["side"], x["side"] * speed, free)
        return Equations(outputs={"y": y}, updates={"held": y, "side": up - down}, margin=margin)


class Relay(Block, tag="relay"):
    """Relay with hysteresis: on above an input, off below a lower one, unchanged between them.

    It switches at the instant of the crossing, at which a step ends.
    """

    kind = "relay"
    outputs = ("y",)
    jumps = True
    input: InputField = field("Input u")
    lower: Number = field("Input below which the relay goes off")
    upper: Number = field("Input above which the relay goes on")
    off: Number = field("Value of y when off", default=0.0)
    on: Number = field("Value of y when on", default=1.0)
    closed: Flag = field("Whether it is on at the start", default=False, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report limits in the wrong order: without hysteresis it would switch endlessly."""
        if not self.lower < self.upper:
            text = f"lower is {self.lower:g}, must be below upper, {self.upper:g}"
            problems.add(where, f"{text}; without hysteresis, take a switch", "lower")

    @property
    def memories(self) -> Mapping[str, float]:
        """Whether the relay is on."""
        return {"state": float(self.closed)}

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the output, and the next state."""
        u, state = self.input, x["state"]
        after = where(u - self.upper, 1.0, where(self.lower - u, 0.0, state))
        margin = where(state, u - self.lower, self.upper - u)
        y = where(state, self.on, self.off)
        return Equations(outputs={"y": y}, updates={"state": after}, margin=margin)


class BoucWen(Block, tag="bouc-wen"):
    """Spring with hysteresis along a coordinate by Bouc and Wen.

    ``F = -(share k s + (1 - share) k z)``,
    ``z' = A s' - beta |s'| |z|^(n-1) z - gamma s' |z|^n``, ``|z| <= (A/(beta + gamma))^(1/n)``
    (Wen, J. Eng. Mech. Div. 102, 1976). It does not depend on the speed.
    """

    kind = "Bouc-Wen spring"
    outputs = ("force",)
    coordinate: CoordinateField = field("Coordinate s, from its initial value")
    stiffness: Number = field("Stiffness k at the first deflection over A", unit=STIFFNESS, above=0)
    share: Number = field("Share of k that stays elastic", least=0, most=1)
    beta: Number = field("Coefficient beta, 1 over the unit of s to the power n")
    gamma: Number = field("Coefficient gamma, 1 over the unit of s to the power n")
    exponent: Number = field("Exponent n: 1, or 2 and more", default=1.0, least=1)
    A: Positive = field("Coefficient A", default=1.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report exponents between 1 and 2 and an unbounded z; warn of a gain of energy."""
        if 1.0 < self.exponent < 2.0:
            text = f"exponent is {self.exponent:g}, must be 1, or 2 and more: the slope at z = 0"
            problems.add(where, f"{text} is not finite between them", "exponent")
        if not self.beta + self.gamma > 0.0:
            text = f"beta + gamma is {self.beta + self.gamma:g}, must be positive: z has no bound"
            problems.add(where, text, "beta")
        elif self.beta < abs(self.gamma):
            warn(where, "beta is below |gamma|: cycles of the spring supply energy; raise beta")

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial value of z."""
        return {"z": 0.0}

    @property
    def nominals(self) -> Mapping[str, float]:
        """Largest value of z."""
        bound = (self.A / (self.beta + self.gamma)) ** (1.0 / self.exponent)
        return {"z": float(bound)}

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the rate of z, and the force."""
        z, v, n = x["z"], rate(self.coordinate), self.exponent
        s = value(self.coordinate) - self.coordinate.initial
        lower = 1.0 if n == 1.0 else absolute(z) ** (n - 1.0)
        power = absolute(z) * lower
        rates = {"z": self.A * v - self.beta * absolute(v) * lower * z - self.gamma * v * power}
        force = -self.stiffness * (self.share * s + (1.0 - self.share) * z)
        return Equations(rates, {"force": force}, [(self.coordinate, force)])
