"""Friction of joints, whose normal force is the reaction of the joint, and laws of friction."""

from __future__ import annotations

from typing import Any, ClassVar

from jousto.base.declare import Declared
from jousto.base.errors import Problems, warn
from jousto.base.fields import Name, Nested, Reference, field
from jousto.base.numbers import DefaultNumber, Number, OptionalPositive, Positive
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.hinges import Cylindrical, Revolute
from jousto.mechanism.joints.rolling import DiscOnPlane
from jousto.mechanism.joints.slides import Prismatic

CREEPS = 100.0
"""Rate of a joint, rad/s, above which smooth friction is fully developed too late."""


class Law(Declared, section="laws", by_value=True):
    """Base of the friction laws at low speed.

    Attributes
    ----------
    sticks : bool
        Whether a joint at rest is held by a constraint.
    """

    sticks: ClassVar[bool] = False


class Regularised(Law, tag="regularised"):
    """Friction as a smooth function of the slip speed: no events, but a sticking joint creeps.

    ``mu(w) = mu_static w (15 - 10 w^2 + 3 w^4) / 8`` with ``w = speed / velocity`` up to w = 1;
    from there mu falls to mu_kinetic at w = 2 and stays. Explicit methods need a step below about
    ``velocity m / (mu_static N)``, where m is the slipping mass; `simulate` warns if the step is
    larger.
    """

    velocity: Positive = field(
        "Slip speed at which friction is fully developed; a sticking joint creeps more slowly",
        unit="m/s",
        default=1e-3,
    )


class StickSlip(Law, tag="stick-slip"):
    """Stick-slip friction: sticking is a constraint with a force of at most mu_static N; no creep.

    A joint at rest sticks up to the force mu_static N, then slips under mu_kinetic N until its
    speed passes zero, where it sticks again or reverses.
    """

    sticks: ClassVar[bool] = True


class LawField(Nested["Law | None", Law]):
    """Field of a friction law; None for Regularised()."""

    section = "laws"
    room = "jousto.mechanism.forces"
    noun = "Regularised or StickSlip"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the law, or report a value of another type."""
        if not isinstance(value, Law):
            problems.add(
                where, f"law is {value!r}, must be Regularised(velocity) or StickSlip()", "law"
            )
        return value


SMOOTH = "Regularised(...) for friction as a smooth function of the slip velocity; None: a bristle"


class SmoothField(Nested["Regularised | None", "Regularised | None"]):
    """Field of the smooth law of friction of a contact; None for a bristle."""

    section = "laws"
    room = "jousto.mechanism.forces"
    noun = "Regularised"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the law, or report a value of another type."""
        if value is not None and not isinstance(value, Regularised):
            problems.add(
                where,
                f"friction is {value!r}, must be Regularised(velocity), or None for a bristle, "
                "which sticks without creep",
                "friction",
            )
        return value


CONTACT_FRICTION = (
    "Regularised(...) for friction as a smooth function of the slip velocity, StickSlip() for a "
    "point at rest that is held by rows; None: a bristle"
)


class ContactFriction(Nested["Law | None", "Law | None"]):
    """Field of the law of friction of a contact; None for a bristle."""

    section = "laws"
    room = "jousto.mechanism.forces"
    noun = "Regularised or StickSlip"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the law, or report a value of another type."""
        if value is not None and not isinstance(value, Law):
            problems.add(
                where,
                f"friction is {value!r}, must be Regularised(velocity), StickSlip(), or None for a "
                "bristle",
                "friction",
            )
        return value


class RubbingJoint(Reference[Revolute | Prismatic | Cylindrical | DiscOnPlane, Any]):
    """Field of a joint that may have friction; a model file contains its name."""

    section = ("joints", "couplings")
    word = "joint"
    noun = "Revolute, Prismatic, Cylindrical or DiscOnPlane"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the joint, or report a value of another type."""
        if not isinstance(value, Revolute | Prismatic | Cylindrical | DiscOnPlane):
            problems.add(
                where,
                f"joint is {value!r}, friction acts on Revolute, Prismatic and Cylindrical joints "
                "and on a DiscOnPlane",
                "joint",
            )
        return value


class Friction(Declared, section="frictions"):
    """Coulomb friction of a joint, with normal force from its reaction (Altarriba 2010, S37-S40).

    The reaction of the joint on marker b, force F and moment M about its origin, resolved in the
    joint axes of a (z along the axis), gives the normal force ``N = preload + |F_xy| + |M_xy| /
    bearing_length``. Friction opposes the slip with

    * Revolute: the torque ``mu (radius N + collar_radius |F_z|)``;
    * Prismatic: the force ``mu (N + |M_z| / collar_radius)``;
    * Cylindrical: ``mu N`` against the slip velocity (s', radius phi') on the pin, a force along
      the axis and a torque about it;
    * DiscOnPlane: ``mu (preload + |F_z|)`` against the slip of the lowest point, F_z along the
      normal of the plane.

    Friction acts on the elastic modes of flexible bodies as reactions do. A torque T whatever the
    reaction is ``StickSlip()`` with a radius far below ``T / (mu |F_xy|)``, such as 1e-9 m, and
    ``preload = T / (mu radius)``.
    """

    kind = "friction"
    name: Name = field("Unique among the forces")
    joint: RubbingJoint = field("The joint")
    mu_kinetic: Number = field("Friction coefficient of a slipping joint", least=0)
    mu_static: DefaultNumber = field(
        "Friction coefficient of a sticking joint, not below mu_kinetic; None for mu_kinetic",
        least=0,
        default=None,
    )
    radius: OptionalPositive = field(
        "Pin radius, required for joints that turn", unit="m", default=None, kw_only=True
    )
    bearing_length: OptionalPositive = field(
        "Length over which the bearing carries bending moments; None: they cause no normal force",
        unit="m",
        default=None,
        kw_only=True,
    )
    collar_radius: OptionalPositive = field(
        "Radius of the thrust collar of a revolute joint, or lever arm at which the guide of a "
        "prismatic joint carries the moment about its axis; None: these cause no normal force",
        unit="m",
        default=None,
        kw_only=True,
    )
    preload: Number = field(
        "Constant normal force, in addition to the reaction",
        unit="N",
        least=0,
        default=0.0,
        kw_only=True,
    )
    law: LawField = field(
        "Friction law at low speed; None for Regularised()", default=None, kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report lengths that do not apply to this joint; set defaults from other fields."""
        static: float | None = self.mu_static
        law: Law | None = self.law
        object.__setattr__(self, "mu_static", self.mu_kinetic if static is None else static)
        object.__setattr__(self, "law", Regularised() if law is None else law)
        if isinstance(self.joint, DiscOnPlane):
            for key in ("radius", "bearing_length", "collar_radius"):
                if getattr(self, key) is not None:
                    problems.add(where, f"{key} is given, but a disc on a plane has none", key)
        elif isinstance(self.joint, Prismatic):
            if self.radius is not None:
                problems.add(
                    where, "radius is given, but a prismatic joint does not turn", "radius"
                )
        elif self.radius is None:
            problems.add(
                where, "radius is missing: the pin radius, m, of a joint that turns", "radius"
            )
        if isinstance(self.joint, Cylindrical) and self.collar_radius is not None:
            problems.add(
                where,
                "collar_radius is given, but a cylindrical joint carries no force along its "
                "axis that could load a collar",
                "collar_radius",
            )
        if self.mu_kinetic == 0.0 and self.mu_static == 0.0:
            problems.add(
                where,
                "mu_kinetic is 0, so that friction never acts; leave the friction out",
                "mu_kinetic",
            )
        self._warn_of_creep(where)
        if self.mu_static < self.mu_kinetic:
            problems.add(
                where,
                f"mu_static is {self.mu_static:g}, must not be below mu_kinetic, "
                f"{self.mu_kinetic:g}",
                "mu_static",
            )

    def _warn_of_creep(self, where: str) -> None:
        """Warn of a pin so thin that it turns fast before smooth friction is fully developed."""
        velocity = getattr(self.law, "velocity", 0.0)
        if self.radius is None or not velocity > CREEPS * self.radius:
            return
        warn(
            where,
            f"Regularised({velocity:g}) has its full friction above {velocity / self.radius:.3g} "
            f"rad/s at a pin radius of {self.radius:g} m; take StickSlip(), or a smaller velocity",
            "law",
        )

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """Coordinates of the joint along which friction acts."""
        joint = self.joint
        return joint.slips if isinstance(joint, DiscOnPlane) else joint.coordinates
