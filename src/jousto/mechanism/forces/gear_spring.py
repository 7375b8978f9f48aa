"""Elastic gears: springs between a joint coordinate and the angle of its motor."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Nested, field
from jousto.base.numbers import Number, OptionalNumber, Values
from jousto.base.object_repr import described
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.law import EngineLaw
from jousto.mechanism.joints.coordinate import (
    DAMPING,
    STIFFNESS,
    VALUE,
    Along,
    Angle,
    CoordinateField,
)
from jousto.mechanism.signals.piecewise import Table

RATIO = Along("1/m", "1")

EngineLaw(
    "gear spring",
    units={"stiffness": STIFFNESS, "damping": DAMPING, "ratio": RATIO, "free": VALUE},
    between=True,
    fast={"gear springs": ("stiffness", "spring"), "gear dampers": ("damping",)},
    side_by_side=True,
).declared()


class GearLaw(Declared, section="gear_laws"):
    """Base of the laws of the torque of a gear over its wind-up."""

    @property
    def outer(self) -> float:
        """Stiffness beyond the last corner, N m/rad."""
        raise NotImplementedError

    @property
    def table(self) -> Table | None:
        """Torque against the wind-up, N m, in addition to that of the stiffness `outer`."""
        raise NotImplementedError


@described
class HarmonicDrive(GearLaw, tag="harmonic-drive"):
    """Piecewise linear stiffness of a strain wave gear: K1 up to T1, K2 up to T2, then K3.

    The law is odd; catalogues state ``stiffness = (K1, K2, K3)`` and ``torques = (T1, T2)``. Any
    other number of corners is possible.

    Examples
    --------
    >>> law = HarmonicDrive(stiffness=(1e4, 1.4e4, 1.7e4), torques=(14, 48))
    >>> law.windup(80.0)
    0.00571092...
    """

    stiffness: Values = field("Stiffness of each piece", unit="N m/rad", shape=(None,))
    torques: Values = field("Torques of the corners, ascending", unit="N m", shape=(None,))

    def consistent(self, problems: Problems, where: str) -> None:
        """Report stiffness that is not positive, and corners that do not fit."""
        K, T = np.real(self.stiffness), np.real(self.torques)
        if np.any(K <= 0.0):
            problems.add(where, f"stiffness is {K.tolist()} N m/rad, must be positive", "stiffness")
        if len(K) != len(T) + 1:
            problems.add(
                where,
                f"{len(K)} values of stiffness but {len(T)} torques of corners; give one corner "
                "less than values of stiffness",
                "torques",
            )
        if np.any(np.diff(T, prepend=0.0) <= 0.0):
            problems.add(
                where, f"torques is {T.tolist()} N m, must be positive and ascending", "torques"
            )

    @property
    def corners(self) -> Any:
        """Wind-up at the corners (k,), rad."""
        return np.cumsum(np.diff(self.torques, prepend=0.0) / self.stiffness[:-1])

    @property
    def outer(self) -> float:
        """Stiffness of the last piece, N m/rad."""
        outer: float = self.stiffness[-1].item()
        return outer

    @property
    def table(self) -> Table | None:
        """Torque along the coordinate, N m, minus that of the last stiffness; constant outside."""
        if not len(self.torques):
            return None
        e = np.concatenate([-self.corners[::-1], [0.0], self.corners])
        T = np.concatenate([-self.torques[::-1], [0.0], self.torques])
        return Table(e, self.outer * e - T)

    def windup(self, torque: float) -> float:
        """Return the wind-up under a torque, rad."""
        size = abs(torque)
        piece = int(np.searchsorted(np.real(self.torques), size))
        below = np.concatenate([[0.0], self.torques])[piece]
        start = np.concatenate([[0.0], self.corners])[piece]
        wound: float = (start + (size - below) / self.stiffness[piece]).item()
        return wound if torque >= 0.0 else -wound


class GearLawField(Nested["GearLaw | None", "GearLaw | None"]):
    """Field of the law of a gear; None for a constant stiffness."""

    section = "gear_laws"
    room = "jousto.mechanism.forces"
    noun = "HarmonicDrive"
    optional = True

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the law, or report that the value is none."""
        if not isinstance(value, GearLaw):
            problems.add(where, f"law is {value!r}, must be a HarmonicDrive or None", "law")
        return value


def check_stiffness(problems: Problems, where: str, gear: Any) -> None:
    """Report a gear with both a stiffness and a law or with neither, or a law along a length."""
    if (gear.stiffness is None) == (gear.law is None):
        problems.add(where, "give either stiffness or law", "stiffness")
    if gear.law is not None and not isinstance(gear.coordinate, Angle):
        problems.add(where, f"law is for angles, but {gear.coordinate.name} is a length", "law")


class GearSpring(ForceElement, tag="gear-spring"):
    """Spring and damper between a coordinate s and the angle phi of a shaft with a gear ratio N.

    ``e = (s - s0) - (phi - phi0) / N - windup``, index 0 at the start; ``f = -k e - c e'`` acts
    along s and ``-f / N`` along phi (virtual work ``f de``). It is the elasticity of a gear;
    `ElasticJoint` adds the motor. The stored energy is ``k e^2 / 2``; the difference of a law from
    its last stiffness counts as work.

    An `Initial` value of s or phi moves the start with it; one of the rate of s sets that of phi,
    unless it has its own.
    """

    kind = "gear spring"
    coordinate: CoordinateField = field("Coordinate s of the driven joint, an angle or a length")
    motor: CoordinateField = field("Angle phi of the motor's shaft")
    ratio: Number = field(
        "Turns of the shaft per turn of the joint, or radians per metre; negative if the shaft "
        "turns the other way",
        unit=RATIO,
        nonzero=True,
    )
    stiffness: OptionalNumber = field(
        "k on the side of the joint; None for `law`", unit=STIFFNESS, least=0, default=None
    )
    damping: Number = field(
        "c on the side of the joint", unit=DAMPING, least=0, default=0.0, kw_only=True
    )
    law: GearLawField = field(
        "Torque over the wind-up, such as `HarmonicDrive`, instead of the stiffness",
        default=None,
        kw_only=True,
    )
    windup: Number = field(
        "Wind-up at the start, the angle of the motor through the gear ahead of the joint",
        unit=VALUE,
        default=0.0,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a shaft that does not turn, one coordinate given twice, a missing stiffness."""
        check_stiffness(problems, where, self)
        if not isinstance(self.motor, Angle):
            problems.add(where, f"motor is {self.motor.name}, a length; must be an angle", "motor")
        if self.motor.same_as(self.coordinate):
            problems.add(where, f"couples {self.motor.name} with itself", "motor")

    @property
    def symbol(self) -> str:
        """Symbol of a spring, a damper or both."""
        return "torsion-spring-damper" if self.damping else "torsion-spring"

    @property
    def outer(self) -> float:
        """Stiffness, or that of the last piece of the law, N m/rad or N/m."""
        law, k = self.law, self.stiffness
        return law.outer if law is not None else 0.0 if k is None else k

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The law along both coordinates."""
        s, phi = self.coordinate, self.motor
        data = {
            "stiffness": self.outer,
            "damping": self.damping,
            "ratio": self.ratio,
            "free": s.initial - phi.initial / self.ratio + self.windup,
        }
        table = None if self.law is None else self.law.table
        return (Push("gear spring", data, coordinate=s, other=phi, spring=table),)
