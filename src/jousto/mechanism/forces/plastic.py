"""Elastic-plastic springs: plastic hinges and bars that yield along a coordinate."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.law import EngineLaw, Unit
from jousto.mechanism.joints.coordinate import FORCE, STIFFNESS, VALUE, Along, CoordinateField

PER_VALUE = Along("1/m", "1/rad")
STATES: dict[str, Unit] = {
    "plastic": VALUE,
    "back": FORCE,
    "path": VALUE,
    "dissipated": "J",
    "flow": "1",
}
"""Plastic deformation, back force, length of the plastic path, dissipated energy, direction."""

EngineLaw(
    "plastic",
    units={
        "stiffness": STIFFNESS,
        "free": VALUE,
        "strength": FORCE,
        "kinematic": STIFFNESS,
        "recovery": PER_VALUE,
        "isotropic": STIFFNESS,
        "saturation": FORCE,
        "rate": PER_VALUE,
    },
    states=STATES,
    grows=("path", "dissipated"),
    signs=("flow",),
    between=True,
    fast={"plastic springs": ()},
    yields=True,
).declared()


class PlasticSpring(ForceElement, tag="plastic-spring"):
    """Elastic-plastic spring along a coordinate: a plastic hinge, or a bar that yields.

    ``f = -M``, ``M = k (s - free - p)``; the plastic deformation p changes while ``|M - X|``
    reaches ``strength + R``. The back force X (kinematic hardening) follows ``X' = kinematic p' -
    recovery X |p'|``. The increase R of the yield force (isotropic hardening) is
    ``R = isotropic l + saturation (1 - exp(-rate l))``, l being the length of the plastic path,
    ``l' = |p'|``. Without hardening the spring is elastic up to yielding, then perfectly
    plastic. The hardening numbers are plastic moduli: with ``kinematic = H`` alone the slope beyond
    yielding is ``k H / (k + H)``.

    `kinematic` with `recovery` is the law of Armstrong and Frederick (CEGB report RD/B/N731, 1966);
    X is then bounded by ``kinematic / recovery``. Steps end where yielding begins and where the
    coordinate turns. Energy: ``M^2 / 2k`` and, with `kinematic`, ``X^2 / 2 kinematic`` are stored,
    the rest of the work is dissipated.

    If the initial force exceeds the yield force, the spring starts with the corresponding plastic
    deformation.

    Examples
    --------
    >>> from jousto import Revolute, RigidBody, ground
    >>> boom = RigidBody("boom", 20.0, (1, 7, 7), center=(1, 0, 0))
    >>> root = Revolute("root", ground["origin"], boom["origin"], axis=(0, 0, 1))
    >>> hinge = PlasticSpring("hinge", root.angle, 2e5, 3000.0, kinematic=2e4)
    >>> round(hinge.tangent, 2)
    18181.82
    """

    kind = "plastic spring"
    coordinate: CoordinateField = field(
        "Coordinate of the spring: a length (N, m) or an angle (N m, rad)"
    )
    stiffness: Number = field(
        "k, elastic",
        unit=STIFFNESS,
        above=0,
        remedy="for a hinge that is rigid until it yields take 100 times the stiffness beside it",
    )
    strength: Number = field("Force or moment at which it first yields", unit=FORCE, above=0)
    free: OptionalNumber = field(
        "Value without force before yielding; None: value of the initial pose",
        unit=VALUE,
        default=None,
        kw_only=True,
    )
    kinematic: Number = field(
        "Modulus of the back force X", unit=STIFFNESS, least=0, default=0.0, kw_only=True
    )
    recovery: Number = field(
        "Dynamic recovery of X, per plastic deformation",
        unit=PER_VALUE,
        least=0,
        default=0.0,
        kw_only=True,
    )
    isotropic: Number = field(
        "Modulus of the yield force", unit=STIFFNESS, least=0, default=0.0, kw_only=True
    )
    saturation: Number = field(
        "Largest increase of the yield force that saturates",
        unit=FORCE,
        least=0,
        default=0.0,
        kw_only=True,
    )
    rate: Number = field(
        "Rate b of saturation, per length of the plastic path",
        unit=PER_VALUE,
        least=0,
        default=0.0,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Warn about numbers that have no effect without another one."""
        if self.recovery and not self.kinematic:
            problems.add(where, "recovery goes with kinematic; give it, too", "recovery")
        if self.saturation and not self.rate:
            problems.add(where, "saturation goes with rate; give it, too", "saturation")
        if self.rate and not self.saturation:
            problems.add(where, "rate goes with saturation; give it, too", "rate")

    @property
    def symbol(self) -> str:
        """A spring."""
        return "torsion-spring" if self.turns else "spring"

    @property
    def tangent(self) -> float:
        """Slope of the force beyond yielding, ``k H / (k + H)``, N/m or N m/rad."""
        H = self.kinematic + self.isotropic + self.saturation * self.rate
        return float(np.real(self.stiffness * H / (self.stiffness + H)))

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The law along the coordinate."""
        s = self.coordinate
        data: dict[str, Any] = {
            "stiffness": self.stiffness,
            "free": s.initial if self.free is None else self.free,
            "strength": self.strength,
            "kinematic": self.kinematic,
            "recovery": self.recovery,
            "isotropic": self.isotropic,
            "saturation": self.saturation,
            "rate": self.rate,
        }
        return (Push("plastic", data, coordinate=s, states=tuple(STATES)),)
