"""Friction of joints, pressed by the joint's own reaction, and its laws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from jousto.base.described import described
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.names import check_name
from jousto.base.numbers import number, set_fields
from jousto.mechanism.forces.springs import positive
from jousto.mechanism.joints.base import Joint
from jousto.mechanism.joints.coordinate import Coordinate
from jousto.mechanism.joints.hinges import Cylindrical, Revolute
from jousto.mechanism.joints.slides import Prismatic


@dataclass(frozen=True, init=False)
class Regularised:
    """Friction is a smooth function of the slip speed: no events, but what sticks creeps.

    ``mu(w) = mu_static w (15 - 10 w^2 + 3 w^4) / 8`` with ``w = speed / velocity`` up to w = 1;
    from there mu falls to mu_kinetic at w = 2 and stays. Explicit methods need a step below about
    ``velocity m / (mu_static N)``, m the mass that slips; `simulate` warns if it is larger.

    Parameters
    ----------
    velocity : float
        Speed at which friction is full, m/s; a joint that sticks creeps with less than this.
    """

    velocity: float

    def __init__(self, velocity: float = 1e-3) -> None:
        problems = Problems()
        value = number(problems, "Regularised", "velocity", velocity)
        problems.raise_if_any()
        if value is not None and value <= 0:
            raise InputError(
                Problem("Regularised", f"velocity is {value:g} m/s, must be a positive number")
            )
        set_fields(self, velocity=value)


@dataclass(frozen=True)
class StickSlip:
    """Joints stick by a constraint whose multiplier is limited by mu_static N; no creep.

    A joint at rest sticks as long as it can, then slips under mu_kinetic N until its speed passes
    zero, where it sticks again or turns round.
    """


@described
@dataclass(frozen=True, eq=False, init=False)
class Friction:
    """Coulomb friction of a joint, pressed by the joint's own reaction (Altarriba 2010, S37-S40).

    The reaction of the joint on marker b, forces F and moments M about its origin, resolved in the
    joint's axes of a (z along the axis), presses with
    ``N = preload + |F_xy| + |M_xy| / bearing_length``. Against the slip act

    * Revolute: the torque ``mu (radius N + collar_radius |F_z|)``;
    * Prismatic: the force ``mu (N + |M_z| / collar_radius)``;
    * Cylindrical: ``mu N`` against the slip velocity (s', radius phi') on the pin, a force along
      the axis and a torque about it.

    It acts on the elastic modes of flexible bodies as the reactions do.

    Parameters
    ----------
    name : str
        Name, unique among the forces.
    joint : Revolute, Prismatic or Cylindrical
        The joint.
    mu_kinetic, mu_static : float
        Coefficients; mu_static is not below mu_kinetic, None for the same.
    radius : float, optional
        Pin radius, m; needed where the joint turns.
    bearing_length : float, optional
        Length over which the bearing carries bending moments, m; None: they do not press.
    collar_radius : float, optional
        Radius of the thrust collar of a revolute joint, or arm at which the guide of a prismatic
        joint carries the moment about its axis, m; None: these do not press.
    preload : float
        Normal force that is always there, N.
    law : Regularised or StickSlip, optional
        The law at low speed; None for Regularised().
    """

    kind: ClassVar[str] = "friction"
    name: str
    joint: Joint
    mu_kinetic: float
    mu_static: float
    radius: float | None
    bearing_length: float | None
    collar_radius: float | None
    preload: float
    law: Regularised | StickSlip

    def __init__(
        self,
        name: str,
        joint: Joint,
        mu_kinetic: float,
        mu_static: float | None = None,
        *,
        radius: float | None = None,
        bearing_length: float | None = None,
        collar_radius: float | None = None,
        preload: float = 0.0,
        law: Regularised | StickSlip | None = None,
    ) -> None:
        problems = Problems()
        where = check_name(problems, self.kind, name)
        if not isinstance(joint, Revolute | Prismatic | Cylindrical):
            problems.add(
                where,
                f"joint is {joint!r}, friction acts on Revolute, Prismatic and Cylindrical joints",
            )
        elif isinstance(joint, Prismatic):
            if radius is not None:
                problems.add(where, "radius is given, but a prismatic joint does not turn")
        else:
            if radius is None:
                problems.add(where, "radius is missing: the pin radius, m, of a joint that turns")
            if isinstance(joint, Cylindrical) and collar_radius is not None:
                problems.add(
                    where,
                    "collar_radius is given, but a cylindrical joint carries no force along its "
                    "axis that could press a collar",
                )
        kinetic = positive(problems, where, "mu_kinetic", mu_kinetic)
        static = kinetic
        if mu_static is not None:
            static = positive(problems, where, "mu_static", mu_static)
        if kinetic == 0.0 and static == 0.0:
            problems.add(where, "mu_kinetic is 0, it never acts; leave the friction out")
        if kinetic is not None and static is not None and static < kinetic:
            problems.add(
                where, f"mu_static is {static:g}, must not be below mu_kinetic, {kinetic:g}"
            )
        lengths: dict[str, float | None] = {}
        for key, value in (
            ("radius", radius),
            ("bearing_length", bearing_length),
            ("collar_radius", collar_radius),
        ):
            lengths[key] = None if value is None else number(problems, where, key, value)
            found = lengths[key]
            if found is not None and found <= 0:
                problems.add(where, f"{key} is {found:g} m, must be a positive number")
        normal = positive(problems, where, "preload", preload)
        chosen: Any = Regularised() if law is None else law
        if not isinstance(chosen, Regularised | StickSlip):
            problems.add(where, f"law is {law!r}, must be Regularised(velocity) or StickSlip()")
        problems.raise_if_any()
        set_fields(
            self,
            name=name,
            joint=joint,
            mu_kinetic=kinetic,
            mu_static=static,
            preload=normal,
            law=chosen,
            **lengths,
        )

    @property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The coordinates of the joint that it acts along."""
        return self.joint.coordinates
