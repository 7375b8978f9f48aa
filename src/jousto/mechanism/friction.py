"""Friction of joints, pressed by the joint's own reaction, and its laws."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from jousto.errors import InputError, Problem, Problems
from jousto.mechanism.elements import positive
from jousto.mechanism.fields import check_name, number, set_fields
from jousto.mechanism.joints import Cylindrical, Joint, Prismatic, Revolute


@dataclass(frozen=True, init=False)
class Regularised:
    """Friction grows smoothly with the slip speed and is full above `velocity` (m/s)."""

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
    """Joints stick by a constraint whose multiplier is limited by mu_static times N."""


@dataclass(frozen=True, eq=False, init=False)
class Friction:
    """Coulomb friction of a joint: ``mu N`` with N from the joint's reaction (Altarriba 2010, 2.4).

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
    bearing_length, collar_radius : float, optional
        Length that carries bending moments and radius of the thrust collar, m.
    preload : float
        Normal force that is always there, N.
    law : Regularised or StickSlip
        The law at low speed.
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
        elif not isinstance(joint, Prismatic) and radius is None:
            problems.add(where, "radius is missing: the pin radius, m, of a joint that turns")
        kinetic = positive(problems, where, "mu_kinetic", mu_kinetic)
        static = kinetic
        if mu_static is not None:
            static = positive(problems, where, "mu_static", mu_static)
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
