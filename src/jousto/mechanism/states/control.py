"""Blocks of control: PID controller with two degrees of freedom, and limit of a rate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import Choice, field
from jousto.base.numbers import Number, OptionalNumber, OptionalPositive, Positive
from jousto.mechanism.forces.pid import FILTER, TRACKING
from jousto.mechanism.states.block import Equations
from jousto.mechanism.states.expression import Expression, clip, where
from jousto.mechanism.states.inputs import InputField, OptionalInput
from jousto.mechanism.states.linear import SIZE, Sized, within


def check_gains(pid: Any, problems: Problems, where: str) -> None:
    """Report gains of a PID controller without effect, a filter that is missing, and limits."""
    if not (pid.kp or pid.ki or pid.kd):
        problems.add(where, "kp, ki and kd are all 0: the controller has no effect")
    if pid.kd and pid.filter is None and not pid.kp:
        text = "filter is missing, which is 0.1 kd/kp only where there is kp; give it in s"
        problems.add(where, text, "filter")
    if pid.lower is not None and pid.limit is not None and pid.lower >= pid.limit:
        text = f"lower is {pid.lower:g}, must be below the limit of {pid.limit:g}"
        problems.add(where, text, "lower")
    elif pid.limit is not None and pid.lower is None and pid.limit <= 0.0:
        text = f"limit is {pid.limit:g}, must be positive, or lower must be given"
        problems.add(where, text, "limit")


class PIDController(Sized, tag="pid"):
    """PID controller of any measured value y, with filtered derivative and anti-windup.

    ``v = kp (weight r - y) + I - D + feedforward``, ``u`` is v within the limits, ``D = kd (y -
    y_f)/filter``, ``y_f' = (y - y_f)/filter`` (Astrom and Hagglund, Advanced PID Control, 2006,
    chapter 3). Anti-windup: ``"back-calculation"``, ``I' = ki (r - y) + (u - v)/tracking``;
    ``"clamping"``, ``I' = 0`` while v is beyond a limit and the error drives it further; or
    ``"none"``. With `actual`, the value that the actuator really has takes the place of u in the
    back-calculation, such as in cascades and manual operation.

    `PID` is the same controller as a force along the coordinate that it measures.

    Examples
    --------
    >>> from jousto.mechanism import PIDController
    >>> level = PIDController("level", 2.0, "tank.level", kp=3.0, ki=0.5, limit=10.0)
    >>> print(level["u"])
    level.u
    """

    kind = "PID controller"
    reference: InputField = field("Wanted value r")
    measured: InputField = field("Measured value y")
    kp: Number = field("Gain on the error", least=0, default=0.0, kw_only=True)
    ki: Number = field(
        "Gain on the integral of the error, kp/Ti", least=0, default=0.0, kw_only=True
    )
    kd: Number = field("Gain on the rate of y, kp Td", least=0, default=0.0, kw_only=True)
    limit: OptionalNumber = field("Largest output; None for no limit", default=None, kw_only=True)
    lower: OptionalNumber = field("Smallest output; None for -limit", default=None, kw_only=True)
    filter: OptionalPositive = field(
        "Time constant of the filter of the derivative; None for 0.1 kd/kp",
        unit="s",
        default=None,
        kw_only=True,
    )
    tracking: OptionalPositive = field(
        "Time constant of the back-calculation; None for 0.9 kp/ki",
        unit="s",
        default=None,
        kw_only=True,
    )
    weight: Number = field(
        "Weight of the reference in the proportional part", default=1.0, kw_only=True
    )
    anti_windup: Choice = field(
        "What keeps the integral part bounded while the output is limited",
        words=("back-calculation", "clamping", "none"),
        default="back-calculation",
        kw_only=True,
    )
    actual: OptionalInput = field(
        "Actual value of the actuator, to which the back-calculation leads; None for u",
        default=None,
        kw_only=True,
    )
    feedforward: OptionalInput = field(
        "Value that is added before the limits apply; None for 0", default=None, kw_only=True
    )
    initial: Number = field("Integral part at the start", default=0.0, kw_only=True)
    start: Number = field("Filtered value of y at the start", default=0.0, kw_only=True)
    size: Positive = field(SIZE, default=1.0, kw_only=True)
    outputs = ("u", "unlimited")

    def consistent(self, problems: Problems, where: str) -> None:
        """Report time constants that contradict the gains, and limits in the wrong order."""
        check_gains(self, problems, where)
        if self._tracks and self.tracking is None and not self.kp:
            text = "tracking is missing, which is 0.9 kp/ki only where there is kp; give it in s"
            problems.add(where, text, "tracking")
        if self.actual is not None and self.anti_windup != "back-calculation":
            text = f"actual is given, which anti_windup={self.anti_windup!r} does not take"
            problems.add(where, text, "actual")

    @property
    def _tracks(self) -> bool:
        """Whether the integral part has back-calculation."""
        limited = self.limit is not None or self.lower is not None or self.actual is not None
        return bool(self.ki) and limited and self.anti_windup == "back-calculation"

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial values of the integral part and of the filter, if they exist."""
        made = {"integral": self.initial} if self.ki else {}
        return made | ({"filtered": self.start} if self.kd else {})

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the rates, and the output with and without limits."""
        made = Equations()
        error = self.reference - self.measured
        v = self.kp * (self.weight * self.reference - self.measured)
        if self.feedforward is not None:
            v = v + self.feedforward
        if self.ki:
            v = v + x["integral"]
        if self.kd:
            time = self.filter or FILTER * self.kd / self.kp
            made.rates["filtered"] = (self.measured - x["filtered"]) / time
            v = v - self.kd * made.rates["filtered"]
        lower = -self.limit if self.lower is None and self.limit is not None else self.lower
        u = within(v, lower, self.limit)
        made.outputs.update(u=u, unlimited=v)
        if self.ki:
            rate = self.ki * error
            if self._tracks:
                time = self.tracking or TRACKING * self.kp / self.ki
                rate = rate + ((u if self.actual is None else self.actual) - v) / time
            elif self.anti_windup == "clamping":
                rate = where((v - u) * error, 0.0, rate)
            made.rates["integral"] = rate
        return made


class RateLimit(Sized, tag="rate-limit"):
    """Output y that follows an input with a limited rate.

    ``y' = clip((u - y)/filter, -falling, rising)``: within the limits a lag of first order.
    """

    kind = "rate limit"
    input: InputField = field("Input u")
    rising: Positive = field("Largest rate of y, 1/s times its unit")
    falling: OptionalPositive = field("Largest rate downwards; None for `rising`", default=None)
    filter: Positive = field("Time constant of the lag", unit="s", default=1e-3, kw_only=True)
    initial: Number = field("Value of y at the start", default=0.0, kw_only=True)
    size: Positive = field(SIZE, default=1.0, kw_only=True)

    @property
    def starts(self) -> Mapping[str, float]:
        """Initial value."""
        return {"y": self.initial}

    def equations(self, x: Mapping[str, Expression]) -> Equations:
        """Return the rate."""
        falling = self.rising if self.falling is None else self.falling
        return Equations({"y": clip((self.input - x["y"]) / self.filter, -falling, self.rising)})
