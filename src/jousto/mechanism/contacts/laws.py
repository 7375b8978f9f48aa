"""Laws of contact: the normal force over the depth of the overlap and its rate."""

from __future__ import annotations

from collections.abc import Mapping
from math import expm1, hypot, log, log1p, pi, sqrt
from typing import Any, ClassVar

import numpy as np

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Nested, field
from jousto.base.numbers import Number
from jousto.materials.material import Material

SOFTEST = 0.01
"""Restitution below which a law has the loss of this one, 1: its damping is 1 / e."""
SLOWEST = 1e-3
"""Speed of approach below which a touch counts as one with this speed, m/s."""


POWER, LINE, TABLE, IMPEDANCE = 0, 1, 2, 3
"""Forms of the force over the depth in the engine, ``JO_CURVE_POWER`` and others."""
NUMBERS: dict[str, Any] = {
    "stiffness": 0.0,
    "exponent": 1.0,
    "damping": 0.0,
    "slowest": SLOWEST,
    "viscous": 0.0,
    "full": 0.0,
    "curve": 0.0,
    "extent": 0.0,
    "impedance": (0.0,) * 5,
}
"""Numbers of the normal force in the engine, as they are where a law does not give them."""


class ContactLaw(Declared, section="contact laws", by_value=True):
    """Base of the laws of contact.

    Attributes
    ----------
    curve : int
        Form of the force over the depth: `POWER`, `LINE`, `TABLE` or `IMPEDANCE`.
    """

    kind = "law of contact"
    curve: ClassVar[int] = POWER

    @property
    def asked(self) -> float:
        """Coefficient of restitution that is asked for; 0 if it follows from other numbers."""
        e = getattr(self, "restitution", None)
        return 0.0 if e is None else max(SOFTEST, float(e))

    @property
    def rows(self) -> Array:
        """Rows of a table (n, 4); none for other laws."""
        return np.zeros((0, 4))

    def numbers(self, curvature: float | None) -> dict[str, Any]:
        """Return the numbers of the engine's law at the sum of both curvatures, 1/m."""
        raise NotImplementedError


class Rebounding(ContactLaw):
    """Base of the laws with a coefficient of restitution."""

    restitution: Number = field(
        "Coefficient of restitution e: speed after a touch over speed before it; 1 for no loss. "
        "Below 0.01 the force has the loss of 0.01; impulses have e itself",
        unit="1",
        least=0,
        most=1,
        default=0.5,
        kw_only=True,
    )
    slowest: Number = field(
        "Speed of approach below which a touch loses as much as one with this speed, which ends "
        "a row of ever smaller bounces",
        unit="m/s",
        above=0,
        default=SLOWEST,
        kw_only=True,
    )

    @property
    def damping(self) -> float:
        """Damping u of ``N = K d^n (1 + u d' / v_in)``."""
        return damping_of(self.asked)

    @property
    def loss(self) -> dict[str, float]:
        """Numbers of the engine's law by which energy is lost."""
        return {"damping": self.damping, "slowest": self.slowest}


class Hertz(Rebounding, tag="hertz"):
    """Elastic spheres: ``N = K d^1.5 (1 + u d' / v_in)``, ``K = 4/3 E* sqrt(R)``.

    ``1/E* = sum (1 - nu^2)/E`` and ``1/R = 1/R_1 + 1/R_2`` of both bodies (K. L. Johnson, Contact
    Mechanics, 1985, chapter 4); d is the depth of the overlap, v_in the speed of approach at the
    touch. u follows from the restitution: see `PowerLaw`.
    """

    modulus: Number = field("E* of both bodies", unit="Pa", above=0)

    @classmethod
    def between(
        cls, material: Material, other: Material | None = None, *, restitution: float = 0.5
    ) -> Hertz:
        """Return the law between two materials; `other` None: the same one."""
        return cls(modulus_of(material, other), restitution=restitution)

    def numbers(self, curvature: float | None) -> dict[str, float]:
        """Stiffness, exponent and damping."""
        assert curvature is not None and curvature > 0.0
        stiffness = 4.0 / 3.0 * self.modulus / sqrt(curvature)
        return self.loss | {"stiffness": stiffness, "exponent": 1.5}


class PowerLaw(Rebounding, tag="power-law"):
    """``N = K d^n (1 + u d' / v_in)``, never pulling, with the restitution that is asked for.

    The law of Hunt and Crossley (Journal of Applied Mechanics 42, 1975, 440-445) with ``u (1 + e) =
    log((1 + u) / (1 - e u))``: integrated along the motion of two bodies, the speed after the touch
    is e times the speed v_in of approach, for any K, n and masses.

    Examples
    --------
    >>> round(PowerLaw(1e8, restitution=0.5).damping, 9)
    1.432750533
    """

    stiffness: Number = field("K, N/m^n", unit="1", above=0)
    exponent: Number = field(
        "n: 1.5 between round bodies, 1 between flat ones", unit="1", least=1, default=1.5
    )

    def numbers(self, curvature: float | None) -> dict[str, float]:
        """Stiffness, exponent and damping."""
        return self.loss | {"stiffness": self.stiffness, "exponent": self.exponent}


class Impact(ContactLaw, tag="impact"):
    """``N = max(0, K d^n + c step(d / d1) d')``: the law IMPACT of other programs.

    step rises from 0 to 1 by a cubic polynomial up to the depth d1. The restitution follows from
    the numbers and the mass.
    """

    stiffness: Number = field("K, N/m^n", unit="1", above=0)
    exponent: Number = field("n", unit="1", least=1, default=2.2)
    damping: Number = field("c", unit="N s/m", least=0, default=1e4)
    full_depth: Number = field("d1, depth of full damping", unit="m", above=0, default=1e-4)

    def numbers(self, curvature: float | None) -> dict[str, float]:
        """Stiffness, exponent, damper and its depth."""
        return {
            "stiffness": self.stiffness,
            "exponent": self.exponent,
            "viscous": self.damping,
            "full": self.full_depth,
        }


class SpringDamper(ContactLaw, tag="spring-damper"):
    """``N = max(0, k d + c d')``: restitution ``exp(-2 z acos(z) / sqrt(1 - z^2))``.

    z is the damping ratio ``c / (2 sqrt(k m))``, m the mass in play.
    """

    stiffness: Number = field("k", unit="N/m", above=0)
    damping: Number = field("c", unit="N s/m", least=0, default=0.0)

    def numbers(self, curvature: float | None) -> dict[str, float]:
        """Spring and damper."""
        return {"stiffness": self.stiffness, "exponent": 1.0, "viscous": self.damping}


class ContactLawField(Nested[ContactLaw, ContactLaw]):
    """Field of a law of contact."""

    section = "contact laws"
    room = "jousto.mechanism.contacts"
    noun = "Hertz, PowerLaw, Impact, SpringDamper or another law"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the law, or report a value of another type."""
        if not isinstance(value, ContactLaw):
            problems.add(where, f"{self.label} is {value!r}, must be {self.noun}(...)", self.key)
        return value


def rest_damping(law: ContactLaw, numbers: Mapping[str, float]) -> float:
    """Return ``c T / m`` of the damper of a contact whose touches are impulses.

    What is left for the force of the law is rest: c gives a spring of the duration of the slowest
    touch the restitution e, ``c = 2 z m pi / T_s``, ``e = exp(-pi z / sqrt(1 - z^2))``. T is the
    duration at 1 m/s: ``T_s = T v_s^((1-n)/(1+n))`` of a law ``K d^n``.
    """
    decay = -log(law.asked)
    share = 2.0 * pi * decay / hypot(pi, decay)
    n = numbers["exponent"]
    return float(share * numbers["slowest"] ** ((n - 1.0) / (n + 1.0)))


def modulus_of(material: Material, other: Material | None = None) -> float:
    """Return E* of two materials, ``1/E* = sum (1 - nu^2)/E``, Pa; `other` None: the same one."""
    both = (material, other or material)
    return float(1.0 / sum((1.0 - one.nu**2) / one.E for one in both))


def damping_of(e: float) -> float:
    """Return the damping u for a restitution e: ``u (1 + e) = log((1 + u) / (1 - e u))``.

    With ``w = 1 - e u`` in (0, 1); for small e, w decreases as ``exp(-1/e)``.
    """
    if e == 1.0:
        return 0.0

    def missing(log_w: float) -> float:
        u = -expm1(log_w) / e
        return log1p(u) - log_w - u * (1.0 + e)

    # it changes its sign between the end of w and, by two terms of its series in u, near u = 0
    near = 0.7 * (1.0 - e * e) / (1.0 + e**3)
    low, high = -(1.0 + e) / e - 5.0, log1p(-e * near)
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if missing(middle) > 0.0 else (low, middle)
    return -expm1(0.5 * (low + high)) / e
