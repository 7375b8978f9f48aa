"""PID controllers of a coordinate or of its rate, with anti-windup."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.forces.base import Actuator, Push
from jousto.mechanism.forces.law import NEVER, EngineLaw, Unit
from jousto.mechanism.joints.coordinate import (
    DAMPING,
    FORCE,
    RATE,
    STIFFNESS,
    VALUE,
    Along,
    CoordinateField,
)
from jousto.mechanism.signals.base import OptionalSignal, SignalField

STIFFNESS_RATE = Along("N/m/s", "N m/rad/s")
INERTIA = Along("N s2/m", "N m s2/rad")
FILTER = 0.1
"""Filter time over derivative time kd / kp, where no filter time is given (N = 10)."""
TRACKING = 0.9
"""Tracking time over integral time kp / ki, where no tracking time is given."""
SHARED: dict[str, Unit] = {
    "weight": "1",
    **dict.fromkeys(("filter", "tracking"), "s"),
    **dict.fromkeys(("lower", "upper"), FORCE),
}


class _PidLaw(EngineLaw):
    def with_numbers(self, numbers: Any) -> EngineLaw:
        """Return the law of a coordinate, or of its rate."""
        return _OF_RATE if numbers.speed else self


_OF_VALUE = _PidLaw(
    "pid",
    units={
        "proportional": STIFFNESS,
        "integral": STIFFNESS_RATE,
        "derivative": DAMPING,
        **SHARED,
    },
    notes=dict.fromkeys(("filter", "tracking"), "0 for that of its gains"),
    constants=("filter_share", "tracking_share", "start", "speed"),
    # integral part, and filtered measured value
    states={"integral": FORCE, "filtered": VALUE},
    reference=VALUE,
    signal=FORCE,
    between=True,
    fast={"controllers": ()},
).declared()
_OF_RATE = replace(
    _OF_VALUE,
    units={
        "proportional": DAMPING,
        "integral": STIFFNESS,
        "derivative": INERTIA,
        **SHARED,
    },
    states={"integral": FORCE, "filtered": RATE},
    reference=RATE,
)


class _Controller(Actuator):
    """Base of controllers of a coordinate or its rate, with gains of different units."""

    speed = False
    coordinate: CoordinateField = field(
        "The coordinate that is controlled, or whose rate is controlled"
    )
    reference: SignalField
    kp: Number
    ki: Number
    kd: Number
    limit: OptionalNumber = field(
        "Largest force; 0 for a force that only pulls; None for no limit",
        unit=FORCE,
        least=0,
        remedy="None for no limit",
        default=None,
        kw_only=True,
    )
    lower: OptionalNumber = field(
        "Smallest force; None for -limit", unit=FORCE, default=None, kw_only=True
    )
    filter: OptionalNumber = field(
        "Time constant of the filter of the derivative; None for 0.1 kd/kp",
        unit="s",
        above=0,
        default=None,
        kw_only=True,
    )
    tracking: OptionalNumber = field(
        "Time constant of the back-calculation; None for 0.9 kp/ki",
        unit="s",
        above=0,
        default=None,
        kw_only=True,
    )
    weight: Number = field(
        "Weight of the reference in the proportional part", unit="1", default=1.0, kw_only=True
    )
    feedforward: OptionalSignal = field(
        "Feedforward force, added before the limits apply; None for zero",
        unit=FORCE,
        default=None,
        kw_only=True,
    )
    initial: Number = field(
        "Integral part at the start, such as the load that the controller balances",
        unit=FORCE,
        default=0.0,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report time constants that contradict the gains, and limits in the wrong order."""
        if not (self.kp or self.ki or self.kd):
            problems.add(where, "kp, ki and kd are all 0: the controller has no effect")
        if self.kd and self.filter is None and not self.kp:
            message = "filter is missing, which is 0.1 kd/kp only where there is kp; give it in s"
            problems.add(where, message)
        if self.ki and self.limit is not None and self.tracking is None and not self.kp:
            message = "tracking is missing, which is 0.9 kp/ki only where there is kp; give it in s"
            problems.add(where, message)
        if self.limit == 0.0 and self.lower is None:
            problems.add(
                where,
                "limit is 0: the controller has no effect; for a force that only pulls "
                "give lower as well",
                "limit",
            )
        if self.lower is not None and self.limit is None:
            problems.add(where, "lower needs limit, the largest force; give limit as well", "lower")
        elif self.lower is not None and self.limit is not None and self.lower >= self.limit:
            low, high = f"{self.lower:g}", f"{self.limit:g}"
            problems.add(where, f"lower is {low}, must be below the limit of {high}", "lower")

    @property
    def filter_time(self) -> float:
        """Time constant of the filter of the derivative, s; 0 without derivative."""
        if not self.kd:
            return 0.0
        return FILTER * self.kd / self.kp if self.filter is None else self.filter

    @property
    def tracking_time(self) -> float:
        """Time constant of the back-calculation while the force is limited, s; 0 for none."""
        if self.limit is None or not self.ki:
            return 0.0
        return TRACKING * self.kp / self.ki if self.tracking is None else self.tracking

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The controller as a law of the engine."""
        limited = self.limit is not None
        high = NEVER if self.limit is None else self.limit
        data = {
            "proportional": self.kp,
            "integral": self.ki,
            "derivative": self.kd,
            "weight": self.weight,
            "filter": self.filter or 0.0,
            "filter_share": FILTER if self.filter is None and self.kp else 0.0,
            "tracking": (self.tracking or 0.0) if limited else 0.0,
            "tracking_share": TRACKING if self.tracking is None and limited else 0.0,
            "lower": -high if self.lower is None else self.lower,
            "upper": high,
            "start": self.initial,
            "speed": float(self.speed),
        }
        return (
            Push(
                "pid",
                data,
                coordinate=self.coordinate,
                active=True,
                reference=self.reference,
                signal=self.feedforward,
                states=tuple(_OF_VALUE.states),
            ),
        )


class PID(_Controller, tag="pid"):
    """PID controller of a coordinate s, with filtered derivative and anti-windup.

    ``u = kp (weight r - s) + I - kd s_f' + feedforward``, ``f`` is u within the limits, ``I' = ki
    (r - s) + (f - u)/tracking``, and ``s_f'`` is the rate of s after a filter of first order,
    ``s_f' = (s - s_f)/filter`` (Astrom and Hagglund, Advanced PID Control, 2006, chapter 3). While
    the force is limited, the last term of I', the back-calculation, keeps the integral part from
    winding up. The derivative part uses s only, so that a jump of the reference causes no impulse.

    Examples
    --------
    >>> from jousto import Prismatic, RigidBody, ground
    >>> cart = RigidBody("cart", 2.0, (0.1, 0.1, 0.1))
    >>> rail = Prismatic("rail", ground["origin"], cart["origin"], axis=(1, 0, 0))
    >>> hold = PID("hold", rail.displacement, 0.25, kp=200.0, ki=100.0, kd=30.0, limit=20.0)
    >>> round(hold.filter_time, 4), round(hold.tracking_time, 4)
    (0.015, 1.8)
    """

    kind = "PID"
    reference: SignalField = field("Wanted value r", unit=VALUE)
    kp: Number = field("Gain on the error", unit=STIFFNESS, least=0, kw_only=True)
    ki: Number = field(
        "Gain on the integral of the error", unit=STIFFNESS_RATE, least=0, default=0.0, kw_only=True
    )
    kd: Number = field(
        "Gain on the rate of the coordinate", unit=DAMPING, least=0, default=0.0, kw_only=True
    )


class SpeedPID(_Controller, tag="speed-pid"):
    """PID controller of the rate s' of a coordinate; see `PID` for the value itself.

    ``u = kp (weight r - s') + I - kd s_f'' + feedforward`` and ``I' = ki (r - s') +
    (f - u)/tracking``, with the derivative of s' after a filter of first order. With kp and ki
    only, this is the usual PI speed controller of a motor.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> wheel = RigidBody("wheel", 1.0, (0.01, 0.01, 0.02))
    >>> axle = Revolute("axle", ground["origin"], wheel["origin"])
    >>> motor = SpeedPID("motor", axle.angle, 50.0, kp=0.4, ki=2.0, limit=1.5)
    >>> round(motor.tracking_time, 4)
    0.18
    """

    kind = "speed PID"
    speed = True
    reference: SignalField = field("Wanted rate r", unit=RATE)
    kp: Number = field("Gain on the error", unit=DAMPING, least=0, kw_only=True)
    ki: Number = field(
        "Gain on the integral of the error", unit=STIFFNESS, least=0, default=0.0, kw_only=True
    )
    kd: Number = field("Gain on the acceleration", unit=INERTIA, least=0, default=0.0, kw_only=True)
