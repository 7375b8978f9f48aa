"""Laws of contact by the words of robot files: ``solref``, ``solimp`` of MJCF, ``kp``, ``kd``."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import acos, acosh, exp, inf, sqrt
from typing import Any

from jousto.mechanism.contacts.curves import Impedance
from jousto.mechanism.contacts.laws import ContactLaw, PowerLaw, SpringDamper

OWN_WORDS = frozenset({"solref", "solimp", "solmix", "margin", "bounce", "contact", "kp", "kd"})
"""Words that laws of the file take, and that of the material leaves out."""
RESTITUTION = 0.2
"""Coefficient of restitution of the links of robots where their file gives none."""
SLOWEST = 0.1
"""Speed of approach below which a touch loses as much as at it, m/s: feet come to rest at once."""
LEAST_RESTITUTION = 0.01
"""Restitution of a contact that is damped so much that it does not bounce."""
LEAST_IMPEDANCE, MOST_IMPEDANCE = 1e-4, 0.9999
"""Bounds of impedances, mjMINIMP and mjMAXIMP of MuJoCo."""
LEAST_FRICTION = 1e-5
"""Smallest coefficient of friction in the stiffness of a pyramid, mjMINMU of MuJoCo."""
NO_BOUNCE = 1e5
"""Default of the speed from which shapes of SDF bounce, m/s."""
NONE = 1e-15
"""Share of a geom in a mix that counts as none, mjMINVAL of MuJoCo."""


@dataclass(frozen=True)
class Touch:
    """Pair of shapes that a law is for.

    Parameters
    ----------
    mass : float
        Mass in play at the start of the robot, kg; inf: unknown.
    friction : float
        Coefficient of friction.
    directions : int
        Directions of friction and resistance and the normal: ``condim``.
    usual : PowerLaw
        Law where the file gives none.
    """

    mass: float
    friction: float
    directions: int
    usual: PowerLaw


@dataclass(frozen=True)
class Softness:
    """What a file contains on how a shape gives way where it touches.

    Parameters
    ----------
    margin : float
        Distance from the shape at which a touch begins, m.
    priority : int
        The shape of higher priority alone gives friction and softness of a pair.
    """

    margin: float = 0.0
    priority: int = 0

    @property
    def material(self) -> Softness:
        """What of it counts for the law of the material: which friction is that of a pair."""
        return replace(type(self)(), priority=self.priority)

    def first(self, other: Softness, one: Any, another: Any, both: Any) -> Any:
        """Return the value of the shape of higher priority; `both` for equal ones."""
        if self.priority == other.priority:
            return both
        return one if self.priority > other.priority else another

    def friction(self, other: Softness, one: float, another: float) -> float:
        """Return the friction of a pair from that of both: the larger one."""
        return float(self.first(other, one, another, max(one, another)))

    def law(self, other: Softness, touch: Touch) -> ContactLaw:
        """Return the law between this and another shape: the usual one."""
        return touch.usual


@dataclass(frozen=True)
class SoftConstraint(Softness):
    """Soft constraint of MJCF, as a force with the same depth at rest and the same rebound.

    MuJoCo changes an acceleration a_0 to ``(1 - a) a_0 + a (k d - b v)`` at the depth d with the
    impedance a (MuJoCo documentation, Solver parameters). At rest this is ``m a / (1 - a) k d`` for
    the mass m in play; of a free impact the restitution follows from ``b^2 / k``. Pyramids of
    friction are stiffer, by ``(condim - 1) / (mu^2 (1 + mu^2))``.

    Parameters
    ----------
    solref : (float, float)
        Time constant, s, and damping ratio, or the negative ones of stiffness, 1/s2, and damping,
        1/s.
    solimp : tuple of float
        a at the depth 0, a at the depth width, width, m, midpoint and power.
    mix : float
        Weight in a pair.
    ratio : float
        ``impratio`` of pyramids of friction; 0: elliptic cones.
    """

    solref: tuple[float, float] = (0.02, 1.0)
    solimp: tuple[float, float, float, float, float] = (0.9, 0.95, 0.001, 0.5, 2.0)
    mix: float = 1.0
    ratio: float = 1.0

    def with_other(self, other: SoftConstraint) -> SoftConstraint:
        """Return that of a pair: of the higher priority, or mixed by their weights."""
        low = [x < NONE for x in (self.mix, other.mix)]
        share = 0.5 if all(low) else self.mix / (self.mix + other.mix)
        share = self.first(other, 1.0, 0.0, share)

        def mixed(one: Any, another: Any) -> Any:
            return tuple(share * a + (1.0 - share) * b for a, b in zip(one, another, strict=True))

        ref = mixed(self.solref, other.solref)
        if self.priority == other.priority and not (self.solref[0] > 0.0 < other.solref[0]):
            ref = tuple(map(min, self.solref, other.solref))
        return replace(self, solref=ref, solimp=mixed(self.solimp, other.solimp))

    def law(self, other: Softness, touch: Touch) -> ContactLaw:
        """Return the law between this and another shape of an MJCF file."""
        if not isinstance(other, SoftConstraint) or touch.mass == inf:
            return touch.usual
        return self.with_other(other).of(touch)

    def of(self, touch: Touch) -> ContactLaw:
        """Return the law of a pair with this softness."""
        low, high, width, middle, power = self.solimp
        low, high, middle = (
            min(max(x, LEAST_IMPEDANCE), MOST_IMPEDANCE) for x in (low, high, middle)
        )
        if self.solref[0] > 0.0:
            stiffness, damping = (high * self.solref[0] * self.solref[1]) ** -2, self.solref[1]
        else:
            stiffness = -self.solref[0] / high**2
            damping = -0.5 * self.solref[1] / sqrt(-self.solref[0])
        if not width > NONE:  # a step has the mean, as in MuJoCo
            low = high = 0.5 * (low + high)
            width = 1.0
        return Impedance(
            self.stiffer(touch) * touch.mass * stiffness,
            *(min(low, high), high, width, middle, max(power, 1.0)),
            restitution=rebound(damping),
            slowest=SLOWEST,
        )

    def stiffer(self, touch: Touch) -> float:
        """Return the stiffness of the pyramid of friction over that of the normal alone."""
        if not self.ratio or touch.directions < 3:
            return 1.0
        mu = max(touch.friction, LEAST_FRICTION)
        return (touch.directions - 1) * self.ratio / (mu * mu * (1.0 + mu * mu))


@dataclass(frozen=True)
class Spring(Softness):
    """Spring, damper and rebound of SDF and URDF files, mixed as Gazebo does.

    Springs act in series, dampers add up; friction, restitution and the speed from which shapes
    bounce are the smaller ones of both shapes.

    Parameters
    ----------
    kp, kd : float or None
        Stiffness, N/m, and damping, N s/m; None: not given.
    restitution : float
        Coefficient of restitution.
    threshold : float
        Speed of approach from which it bounces, m/s.
    """

    kp: float | None = None
    kd: float | None = None
    restitution: float = 0.0
    threshold: float = NO_BOUNCE

    def friction(self, other: Softness, one: float, another: float) -> float:
        """Return the friction of a pair: the smaller one of both."""
        return min(one, another)

    def law(self, other: Softness, touch: Touch) -> ContactLaw:
        """Return the law between this and another shape of such a file."""
        if not isinstance(other, Spring):
            return touch.usual
        springs = [x for x in (self.kp, other.kp) if x]
        stiffness = 1.0 / sum(1.0 / x for x in springs) if springs else touch.usual.stiffness
        threshold = min(self.threshold, other.threshold)
        bounce = min(self.restitution, other.restitution)
        if bounce > 0.0 and threshold < NO_BOUNCE:
            slowest = max(threshold, SLOWEST)
            return PowerLaw(stiffness, 1.0, restitution=bounce, slowest=slowest)
        dampers = [x for x in (self.kd, other.kd) if x is not None]
        if springs and dampers:
            return SpringDamper(stiffness, sum(dampers))
        return PowerLaw(stiffness, 1.0, restitution=RESTITUTION, slowest=SLOWEST)


def rebound(ratio: float) -> float:
    """Return the restitution of a spring and damper that never pull, by their damping ratio z.

    ``exp(-2 z acos(z) / sqrt(1 - z^2))``; beyond 1 with acosh and the opposite root.
    """
    z = max(ratio, 0.0)
    if z == 1.0:
        return exp(-2.0)
    turn = acos(z) / sqrt(1.0 - z * z) if z < 1.0 else acosh(z) / sqrt(z * z - 1.0)
    return max(exp(-2.0 * z * turn), LEAST_RESTITUTION)
