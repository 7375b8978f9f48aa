"""Wheel on a rail with Hertz's load, creep forces and a flange."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalNumber
from jousto.base.rotations import Direction
from jousto.mechanism.bodies.marker import Marker, MarkerField
from jousto.mechanism.contacts.creep import SLENDER
from jousto.mechanism.contacts.rail_patch import RailPatch
from jousto.mechanism.contacts.rail_shapes import rail_shape, wheel_shape
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.law import EngineLaw
from jousto.mechanism.joints.rails import ALONG, STEEP, frames_of

FLANGE = math.radians(70.0)
"""Angle of the flange of wheels of the railway, rad (EN 13715)."""
GAUGE_CORNER, HALF_HEAD = 13e-3, 36e-3
"""Radius of the gauge corner and half the width of the head of the rail 60E1, m (EN 13674-1)."""
FLATTEST, STEEPEST = math.radians(30.0), math.radians(85.0)
"""Range of angles of a flange, rad."""

EngineLaw(
    "rail",
    units={"mu": "1", "damping": "s/m"},
    constants=("slow", "count"),
    between=True,
    fast={"contacts": ()},
).declared()


class RailContact(ForceElement, tag="rail-contact"):
    """A wheel on a straight rail: Hertz's load, Kalker's creep forces, a flange with play.

    The wheel is a body of revolution about its axle; its tread has the radius ``radius + cone y``
    at the distance y along the axle from marker b, or is an arc of the radius `tread` there. The
    head of the rail is a cylinder of the radius `head`; its top is the origin of a. The point of
    contact is where they are nearest, for any attitude. The load is ``N = K d^1.5 (1 + damping
    d')``, never pulling, with K and the half axes a, b of the ellipse by Hertz. With the creepages
    nu_x, nu_y and phi, the velocities and the spin of the wheel on the rail over the rolling speed,

        ``Fx = -G a b C11 nu_x``, ``Fy = -G a b (C22 nu_y + sqrt(a b) C23 phi)``,
        ``M = G a b (sqrt(a b) C23 nu_y - a b C33 phi)``,

    times ``1 - e/3 + e^2/27`` with ``e = |F| / (mu N)``, from e = 3 on 1/e (J. J. Kalker,
    Three-Dimensional Elastic Bodies in Rolling Contact, 1990; Z. Y. Shen, J. K. Hedrick, J. A.
    Elkins, 1983). Below the speed `slow` the creepages stay finite: a wheel at rest creeps slowly.

    With `play` the wheel has a flange: a cone of `flange_angle` on the arc `corner` of the rail,
    `gauge_face` beside its middle. It touches when the wheel has moved by `play` across the rail;
    tread and flange may touch together.

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> from jousto.mechanism import RailContact
    >>> axle = RigidBody("axle", 1200.0, (700, 100, 700), position=(0, 0, 0.46))
    >>> rail, hub = ground.at((0, 0.75, 0)), axle.at((0, 0.75, 0))
    >>> left = RailContact("left", rail, hub, 0.46, -0.05, mu=0.3, play=7e-3, axle=(0, 1, 0))
    >>> print(*(round(c, 2) for c in left.tread_patch.coefficients))
    4.62 4.17 1.87 0.98
    """

    kind = "rail contact"
    together = ("a", "b", "radius", "cone", "mu")
    a: MarkerField = field("Marker of the rail, at the top of its head")
    b: MarkerField = field("Marker at the centre of the wheel, on the body that spins")
    radius: Number = field("Radius of the tread at marker b", unit="m", above=0)
    cone: Number = field(
        "Conicity at marker b: increase of the radius along the axle over the length; 0 for a "
        "cylinder",
        unit="1",
        least=-STEEP,
        most=STEEP,
        default=0.0,
    )
    mu: Number = field("Coefficient of friction", unit="1", above=0, default=0.3, kw_only=True)
    head: Number = field(
        "Radius of the head of the rail; that of 60E1 if not given",
        unit="m",
        above=0,
        default=0.3,
        kw_only=True,
    )
    tread: OptionalNumber = field(
        "Radius of the section of the tread, positive if it is convex, negative if it is hollow; "
        "None for a cone",
        unit="m",
        default=None,
        kw_only=True,
    )
    play: OptionalNumber = field(
        "Way across the rail from the middle until the flange touches; None for no flange",
        unit="m",
        above=0,
        default=None,
        kw_only=True,
    )
    flange_angle: OptionalNumber = field(
        "Angle of the flange against the axle, positive if its radius grows along the axle; None "
        "for 70 degrees with the sign of the conicity",
        unit="rad",
        default=None,
        kw_only=True,
    )
    corner: Number = field(
        "Radius of the gauge corner of the rail, which the flange touches; that of 60E1 if not "
        "given",
        unit="m",
        above=0,
        default=GAUGE_CORNER,
        kw_only=True,
    )
    gauge_face: Number = field(
        "Distance of the gauge face of the rail from marker a; that of 60E1 if not given",
        unit="m",
        above=0,
        default=HALF_HEAD,
        kw_only=True,
    )
    E: Number = field(
        "Young's modulus of wheel and rail; that of steel if not given",
        unit="Pa",
        above=0,
        default=210e9,
        kw_only=True,
    )
    nu: Number = field(
        "Poisson's ratio of wheel and rail; that of steel if not given",
        unit="1",
        least=0,
        most=0.5,
        default=0.3,
        kw_only=True,
    )
    damping: Number = field(
        "Relative increase of the load over the speed of approach",
        unit="s/m",
        least=0,
        default=0.0,
        kw_only=True,
    )
    slow: Number = field(
        "Rolling speed below which the creepages stay finite",
        unit="m/s",
        above=0,
        default=0.1,
        kw_only=True,
    )
    rail: Direction = field(
        "Direction of the rail in the world frame at the initial pose, fixed to a; None for the x "
        "axis of marker a",
        default=None,
        kw_only=True,
    )
    axle: Direction = field(
        "Axle n in the world frame at the initial pose, fixed to b; None for the z axis of "
        "marker b",
        default=None,
        kw_only=True,
    )

    def __repr__(self) -> str:
        return f"<rail contact {self.name!r}: {self.a.label}, {self.b.label}>"

    def consistent(self, problems: Problems, where: str) -> None:
        """Report directions, a flange and a tread that do not fit."""
        if self.a.body is self.b.body:
            problems.add(where, f"a and b are both on {self.a.body.name!r}; take two bodies", "b")
        if self.rail is not None:
            x, up = np.real(np.asarray(self.rail)), np.real(self.a.A[:, 2])
            if np.linalg.norm(np.cross(x, up)) < ALONG * np.linalg.norm(x):
                problems.add(where, "the rail is along the z axis of marker a, its top", "rail")
                return
        a, b = self.frames
        if abs(float(np.real(a.A[:, 1] @ b.A[:, 2]))) < ALONG:
            problems.add(
                where,
                "the axle does not lie across the rail at the initial pose; turn the body, or give "
                "axle=",
                "axle",
            )
        if self.tread is not None and (
            self.tread == 0 or -self.head * (1 + ALONG) < self.tread < 0
        ):
            problems.add(
                where,
                f"tread is {self.tread:g} m, must be positive, or hollow by a radius that is "
                f"clearly larger than that of the head, {self.head:g} m",
                "tread",
            )
        self._check_flange(problems, where)
        if not problems.found:
            self._check_ellipses(problems, where)

    def _check_flange(self, problems: Problems, where: str) -> None:
        given = self.flange_angle
        if self.play is None:
            if given is not None:
                problems.add(where, "a flange has a play; give play=", "flange_angle")
            return
        if given is None and self.cone == 0:
            text = "the side of the flange of a cylinder is not known; give flange_angle="
            problems.add(where, text, "flange_angle")
        if given is not None:
            if not FLATTEST <= abs(given) <= STEEPEST:
                text = f"flange_angle is {math.degrees(given):.4g} degrees, must be 30 to 85 or "
                problems.add(where, text + "-85 to -30", "flange_angle")
            if given * self.cone < 0:
                text = "flange_angle and cone have opposite signs; the radius grows towards the "
                problems.add(where, text + "flange", "flange_angle")
        if self.corner >= self.gauge_face:
            text = f"corner is {self.corner:g} m, must be below gauge_face, {self.gauge_face:g} m"
            problems.add(where, text, "corner")

    def _check_ellipses(self, problems: Problems, where: str) -> None:
        for patch, key in zip(self.patches, ("head", "corner"), strict=False):
            ratio = patch.scale.a / patch.scale.b
            if not 1 / SLENDER <= ratio <= SLENDER:
                text = f"the half axes of its contact are as {ratio:.3g} to 1, must be within "
                problems.add(where, text + f"{SLENDER:g} and 1/{SLENDER:g}", key)

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers with x along the rail and z up, and with z along the axle."""
        return frames_of(self)

    @cached_property
    def tread_patch(self) -> RailPatch:
        """Contact of the tread with the head of the rail."""
        bend = 0.0 if self.tread is None else 1.0 / self.tread
        # the normal of a cone leans: it touches the head beside its middle
        across = -self.cone / math.sqrt(1.0 + self.cone**2) * self.head
        rolling = self.radius + self.cone * across if self.tread is None else self.radius
        shape = (0.0, -self.head), self.head, 0.0, self.radius, self.cone, bend
        return RailPatch(*shape, rolling=float(rolling), E=float(self.E), nu=float(self.nu))

    @cached_property
    def flange_patch(self) -> RailPatch | None:
        """Contact of the flange with the gauge corner of the rail; None without a flange."""
        if self.play is None:
            return None
        angle = self.flange_angle
        if angle is None:
            angle = math.copysign(FLANGE, self.cone)
        side, corner = math.copysign(1.0, angle), self.corner
        a, b = self.frames
        left = math.copysign(1.0, float(np.real(a.A[:, 1] @ b.A[:, 2])))
        middle = side * (self.gauge_face - corner)  # of the corner, along the axle
        # at the play the cone touches the corner: its distance in the middle is play sin(angle)
        gap = corner + self.play * abs(math.sin(angle))
        place = middle + math.sin(angle) * gap
        radius = self.radius + corner - math.cos(angle) * gap
        rolling = self.radius + corner * (1.0 - math.cos(angle))
        shape = (left * middle, -corner), corner, place, radius, math.tan(angle), 0.0
        return RailPatch(*shape, rolling=float(rolling), E=float(self.E), nu=float(self.nu))

    @property
    def patches(self) -> tuple[RailPatch, ...]:
        """Tread, and flange if there is one."""
        flange = self.flange_patch
        return (self.tread_patch,) if flange is None else (self.tread_patch, flange)

    @property
    def touching_shapes(self) -> tuple[tuple[Marker, Any], ...]:
        """The rail and the wheel, for pictures."""
        a, b = self.frames
        rail = rail_shape(self.head, self.corner, self.gauge_face, self.radius)
        return (a, rail), (b, wheel_shape(self.patches))

    @property
    def symbol(self) -> str:
        """Symbol of a spring between two frames."""
        return "bushing"

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The contact as a law of the engine."""
        a, b = self.frames
        names = ("mu", "damping", "slow")
        data = {name: getattr(self, name) for name in names} | {"count": len(self.patches)}
        rows = tuple(np.array(patch.numbers) for patch in self.patches)
        return (Push("rail", data, a=a, b=b, rest=rows),)
