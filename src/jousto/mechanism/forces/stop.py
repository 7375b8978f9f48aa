"""Stops: elastic limits of a coordinate with restitution."""

from __future__ import annotations

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.law import NEVER, EngineLaw
from jousto.mechanism.joints.coordinate import RATE, STIFFNESS, VALUE, CoordinateField

SLOW = {"rad": 0.1, "m": 0.02}
"""Speed of a stop where none is given, rad/s and m/s."""


EngineLaw(
    "stop",
    units={"stiffness": STIFFNESS, "lower": VALUE, "upper": VALUE, "loss": "1", "speed": RATE},
    between=True,
    fast={"stops": ()},
    side_by_side=True,
).declared()


class Stop(ForceElement, tag="stop"):
    """Elastic limits of a coordinate with a coefficient of restitution e.

    ``f = -k d (1 + h s(d'/speed))`` where d is the distance of the coordinate beyond the limit, ``h
    = (1 - e^2)/(1 + e^2)`` and ``s(x) = x (3 - x^2)/2`` up to ``|x| = 1``, beyond that s is the
    sign of x. The rebound speed is e times the impact speed, for any mass and stiffness; since ``h
    <= 1`` the stop never pulls.

    The variables separate in ``m v dv = -k d phi(v) dd`` with ``phi = 1 + h s``, as in the law of
    Hunt and Crossley (Journal of Applied Mechanics 42, 1975, 440-445), ``phi = 1 + a v``, whose
    restitution decreases with the impact speed. Here ``v_out^2 = e^2 v_in^2 + C speed^2`` with C
    between 0 and 1, if both speeds exceed `speed`. Slower impacts lose less energy. A body that
    lies on the stop comes to rest as if it were on a damper of ``3 h F / (2 speed)``, where F is
    its load.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> door = RigidBody("door", 20.0, (1, 1, 2), center=(0.4, 0, 0))
    >>> hinge = Revolute("hinge", ground["origin"], door["origin"])
    >>> stop = Stop("stop", hinge.angle, upper=1.6, stiffness=5e3, restitution=0.4)
    >>> round(stop.loss, 4)
    0.7241
    """

    kind = "stop"
    together = ("lower", "upper")
    coordinate: CoordinateField = field(
        "Coordinate of the stop: a length (N, m) or an angle (N m, rad)"
    )
    lower: OptionalNumber = field("Lower limit; None for no limit", unit=VALUE, default=None)
    upper: OptionalNumber = field("Upper limit; None for no limit", unit=VALUE, default=None)
    stiffness: Number = field("k", unit=STIFFNESS, above=0, kw_only=True)
    restitution: Number = field(
        "Coefficient of restitution e: speed after an impact over speed before it; 1 for no loss",
        unit="1",
        least=0,
        most=1,
        default=0.5,
        kw_only=True,
    )
    speed: OptionalNumber = field(
        "Impact speed above which the restitution applies, slower impacts lose less; None for "
        "0.1 rad/s or 0.02 m/s",
        unit=RATE,
        above=0,
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report missing limits, and limits in the wrong order."""
        low, high = self.lower, self.upper
        if low is None and high is None:
            problems.add(where, "has no limit; give lower, upper or both")
        elif low is not None and high is not None and np.real(low) > np.real(high):
            problems.add(where, f"lower limit {low:g} lies above the upper one, {high:g}", "lower")

    @property
    def symbol(self) -> str:
        """Symbol of a spring."""
        return "torsion-spring" if self.turns else "spring"

    @property
    def loss(self) -> float:
        """Coefficient h: relative difference of the force from that of a spring."""
        e = self.restitution
        return (1.0 - e * e) / (1.0 + e * e)

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The stop as a law of the engine."""
        s = self.coordinate
        data = {
            "stiffness": self.stiffness,
            "lower": -NEVER if self.lower is None else self.lower,
            "upper": NEVER if self.upper is None else self.upper,
            "loss": self.loss,
            "speed": SLOW[s.unit] if self.speed is None else self.speed,
        }
        return (Push("stop", data, coordinate=s),)
