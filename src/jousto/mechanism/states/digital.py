"""Digital controllers: a sampled PID controller, and transfer functions in z."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import Choice, field, kept
from jousto.base.numbers import Number, OptionalNumber, OptionalPositive, Positive, Values
from jousto.mechanism.forces.pid import FILTER, TRACKING
from jousto.mechanism.states.control import check_gains
from jousto.mechanism.states.expression import Expression, linear, where
from jousto.mechanism.states.inputs import InputField, OptionalInput
from jousto.mechanism.states.linear import within
from jousto.mechanism.states.sampled import Ticking
from jousto.mechanism.states.state_space import of_transfer_function


class SampledTransferFunction(Ticking, tag="sampled-transfer-function"):
    """Transfer function ``y = (b0 z^m + .. + bm) / (a0 z^n + .. + an) u``, m <= n, of samples.

    Its states start at 0; y is constant between samples, and 0 before the first one.

    Examples
    --------
    >>> from jousto.mechanism import SampledTransferFunction
    >>> mean = SampledTransferFunction("mean", "pid.u", [1, 1], [2, 0], 0.01)
    >>> print(mean["y"])
    mean.y
    """

    kind = "sampled transfer function"
    input: InputField = field("Input u")
    numerator: Values = field("Coefficients b0 .. bm of falling powers of z", shape=(None,))
    denominator: Values = field("Coefficients a0 .. an of falling powers of z", shape=(None,))
    period: Positive = field("Time between samples", unit="s")
    _matrices: Any = kept()

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a denominator of 0, a numerator of higher degree, and times that do not fit."""
        super().consistent(problems, where)
        num, den = (np.trim_zeros(x, "f") for x in (self.numerator, self.denominator))
        if not len(den):
            problems.add(where, "has a denominator of zeros", "denominator")
        elif len(num) > len(den):
            text = f"has a numerator of degree {len(num) - 1} over a denominator of degree "
            text += f"{len(den) - 1} and needs samples of the future; multiply the denominator by z"
            problems.add(where, text, "numerator")
        else:
            object.__setattr__(self, "_matrices", of_transfer_function(num, den))

    @property
    def values(self) -> Mapping[str, float]:
        """Values before the first sample."""
        return {"y": 0.0} | {f"x{i + 1}": 0.0 for i in range(len(self._matrices[0]))}

    def next_values(self, x: Mapping[str, Expression]) -> Mapping[str, Any]:
        """Return the states of the next sample, and the output."""
        A, B, C, D = self._matrices
        terms = [*(x[f"x{i + 1}"] for i in range(len(A))), self.input]
        rows = linear(np.vstack([np.hstack([C, D]), np.hstack([A, B])]), terms)
        return dict(zip(self.values, rows, strict=True))


class SampledPID(Ticking, tag="sampled-pid"):
    """PID controller of a computer, which reads r and y every `period` and holds its output.

    ``v = kp (weight r - y) + I - D + feedforward``, ``u`` is v within the limits. With the period
    T and the error e, ``method="backward"``: ``I += ki T e``, ``D = (filter D + kd (y - y1))/
    (filter + T)``; ``"tustin"``: ``I += ki T (e + e1)/2``, ``D = ((2 filter - T) D + 2 kd (y -
    y1))/(2 filter + T)``; e1, y1 are those of the sample before (Astrom and Wittenmark,
    Computer-Controlled Systems, 1997, section 8.3). Anti-windup: ``"back-calculation"``, after each
    sample ``I += T (u - v)/tracking``; ``"clamping"``, I stays while v is beyond a limit and the
    error drives it further; or ``"none"``.

    Examples
    --------
    >>> from jousto.mechanism import SampledPID
    >>> level = SampledPID("level", 2.0, "tank.level", 0.01, kp=3.0, ki=0.5, limit=10.0)
    >>> print(level["u"])
    level.u
    """

    kind = "sampled PID controller"
    reference: InputField = field("Wanted value r")
    measured: InputField = field("Measured value y")
    period: Positive = field("Time between samples T", unit="s")
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
        "Time constant of the back-calculation; None for 0.9 kp/ki, but at least the period",
        unit="s",
        default=None,
        kw_only=True,
    )
    weight: Number = field(
        "Weight of the reference in the proportional part", default=1.0, kw_only=True
    )
    method: Choice = field(
        "Rule of the integral and the derivative",
        words=("backward", "tustin"),
        default="backward",
        kw_only=True,
    )
    anti_windup: Choice = field(
        "What keeps the integral part bounded while the output is limited",
        words=("back-calculation", "clamping", "none"),
        default="back-calculation",
        kw_only=True,
    )
    feedforward: OptionalInput = field(
        "Value that is added before the limits apply; None for 0", default=None, kw_only=True
    )
    initial: Number = field("Integral part before the first sample", default=0.0, kw_only=True)
    start: Number = field("Measured value before the first sample", default=0.0, kw_only=True)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report time constants that contradict the gains, and limits and times that do not fit."""
        super().consistent(problems, where)
        check_gains(self, problems, where)
        if self.tracking is not None and self.tracking < self.period:
            text = f"tracking is {self.tracking:g} s, must be the period of {self.period:g} s"
            problems.add(where, f"{text} or more: the integral part would jump too far", "tracking")

    @property
    def values(self) -> Mapping[str, float]:
        """Values before the first sample."""
        made = {"u": 0.0, "unlimited": 0.0}
        if self.ki:
            made["integral"] = self.initial
        if self.ki and self.method == "tustin":
            made["error"] = 0.0
        if self.kd:
            made |= {"derivative": 0.0, "measured": self.start}
        return made

    def next_values(self, x: Mapping[str, Expression]) -> Mapping[str, Any]:
        """Return the values from a sample on."""
        T, tustin = self.period, self.method == "tustin"
        y, error = self.measured, self.reference - self.measured
        made: dict[str, Any] = {}
        v = self.kp * (self.weight * self.reference - y)
        if self.feedforward is not None:
            v = v + self.feedforward
        if self.kd:
            time = self.filter or FILTER * self.kd / self.kp
            rise = self.kd * (y - x["measured"])
            if tustin:
                D = ((2 * time - T) * x["derivative"] + 2 * rise) / (2 * time + T)
            else:
                D = (time * x["derivative"] + rise) / (time + T)
            v = v - D
            made |= {"derivative": D, "measured": y}
        integral = grown = x.get("integral")
        if self.ki:
            mean = 0.5 * (error + x["error"]) if tustin else error
            grown = integral + self.ki * T * mean
            v = v + grown
        lower = -self.limit if self.lower is None and self.limit is not None else self.lower
        u = within(v, lower, self.limit)
        if self.ki and tustin:
            made["error"] = error
        if self.ki and self.anti_windup == "clamping":
            grown = where((v - u) * error, integral, grown)
        elif self.ki and self.anti_windup == "back-calculation":
            usual = TRACKING * self.kp / self.ki
            time = self.tracking or (usual if usual > T else T)
            grown = grown + T / time * (u - v)
        if self.ki:
            made["integral"] = grown
        return made | {"u": u, "unlimited": v}
