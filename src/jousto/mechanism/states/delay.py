"""Block that delays its input."""

from __future__ import annotations

from collections.abc import Mapping

from jousto.base.fields import field
from jousto.base.numbers import OptionalNumber, Positive, Whole
from jousto.mechanism.states.block import Block, Equations
from jousto.mechanism.states.expression import Expression
from jousto.mechanism.states.inputs import InputField


class Delay(Block, tag="delay"):
    """Output y that is the input a fixed time before, ``y(t) = u(t - time)``.

    The input is kept at the ends of steps, with its rate, and interpolated by cubic Hermite
    polynomials between them (Bellen and Zennaro, Numerical Methods for Delay Differential
    Equations, 2003, chapter 4). Steps are at most as long as the delay, and end where the output
    jumps. A loop through a delay is no algebraic loop.

    Examples
    --------
    >>> from jousto.mechanism import Delay
    >>> late = Delay("late", "pid.u", 0.05)
    >>> print(late["y"])
    late.y
    """

    kind = "delay"
    outputs = ("y",)
    input: InputField = field("Input u")
    time: Positive = field("Delay", unit="s")
    initial: OptionalNumber = field(
        "Value of u before the start; None for that at the start", default=None, kw_only=True
    )
    points: Whole = field(
        "Largest number of values that are kept; each jump of u takes one more",
        least=8,
        default=120,
        kw_only=True,
    )
    size: Positive = field(
        "Size of u for the error control of DormandPrince", default=1.0, kw_only=True
    )

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the output."""
        return Equations(outputs={"y": Expression("delayed", of=self)}, delayed=self.input)
