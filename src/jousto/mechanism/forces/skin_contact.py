"""Contact of the skin of a flexible body with a shape."""

from __future__ import annotations

from functools import cached_property
from math import inf
from typing import Any

import numpy as np

from jousto.base.errors import Problems
from jousto.base.fields import Choice, Texts, field
from jousto.base.numbers import DefaultNumber, Number
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.bodies.marker import Marker, MarkerField, world_positions
from jousto.mechanism.contacts.effective_mass import angular_mobility, mobility
from jousto.mechanism.contacts.friction import default_static
from jousto.mechanism.contacts.laws import NUMBERS, POWER, ContactLawField, Hertz
from jousto.mechanism.contacts.shapes import ShapeField, Tip
from jousto.mechanism.contacts.skins import SkinBodyField, check_skin, skin_markers
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.contact import (
    RESOLVE,
    RESOLVES,
    SHEAR,
    STATES,
    check_restitution,
    judged_from,
    tip_numbers,
    touch_numbers,
)
from jousto.mechanism.forces.friction import SMOOTH, SmoothField


class SkinNodes(Texts):
    """Field of names of node sets; none for the whole skin."""

    checks_none = True

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the names as a tuple, or report values that are no names."""
        if value is None or (isinstance(value, tuple) and not value):
            return ()
        return super().check(problems, where, [value] if isinstance(value, str) else value)


class SkinContact(ForceElement, tag="skin-contact"):
    """Skin of a flexible body on a shape: its surface nodes touch, and the force bends the body.

    Each node of the outer faces touches the shape, with the law times the area for which the node
    stands: the law gives a pressure, so that its stiffness is in N/m^(n+2) and the sum of the
    forces does not depend on the mesh. Where the depth d is the same everywhere, the nodal forces
    are those of the constant pressure ``K d^n``. Of a part of beams, and of an exact beam, the law
    gives a force per length, in N/m^(n+1), and `radius` is the distance of the surface from the
    axis.

    The nodes move with the modes, so the force reaches them; the modes represent the deformation
    under the contact only if its shape is among them: take residual vectors of the loaded faces.
    Restitution, friction that sticks, events, energy and the proof that nothing is missed are those
    of `Contact`, for each node.

    Between its nodes the skin is not felt: the mesh must be finer than the shape.

    Examples
    --------
    >>> import jousto as jo
    >>> from jousto.mechanism import HalfSpace, PowerLaw, SkinContact
    >>> steel = jo.Material(E=210e9, nu=0.3, rho=7850.0)
    >>> rod = jo.BeamBody("rod", [(0, 0, 0), (1, 0, 0)], jo.Circle(0.01), steel, elements=4)
    >>> law = PowerLaw(1e7, 1.0)
    >>> SkinContact("lies", jo.ground["origin"], HalfSpace(), rod, law, radius=0.01)
    <skin-contact 'lies': 5 nodes of rod, ground.origin>
    """

    kind = "contact of a skin"
    measured = ("force",)
    summed = True
    together = ("a", "shape", "body", "law", "nodes", "radius", "mu_kinetic", "mu_static")
    a: MarkerField = field("Marker of the shape")
    shape: ShapeField = field("Shape in the frame of a")
    body: SkinBodyField = field("Flexible body, or exact beam, whose skin touches the shape")
    law: ContactLawField = field("Law of the pressure; of beams that of the force per length")
    nodes: SkinNodes = field(
        "Names of node sets: only faces all of whose nodes are in them touch; none for all outer "
        "faces",
        wanted="must be a list of names of node sets",
        default=(),
        kw_only=True,
    )
    radius: Number = field(
        "Distance of the surface from the nodes, as of the axis of a beam",
        unit="m",
        least=0,
        default=0.0,
        kw_only=True,
    )
    mu_kinetic: Number = field(
        "Coefficient of friction while it slips; 0 for no friction",
        unit="1",
        least=0,
        default=0.0,
        kw_only=True,
    )
    mu_static: DefaultNumber = field(
        "Coefficient of friction up to which it sticks; None: mu_kinetic",
        unit="1",
        least=0,
        default=None,
        kw_only=True,
    )
    shear: Number = field(
        "Stiffness of the bristle over that of the normal force, 2 (1 - nu) / (2 - nu)",
        unit="1",
        above=0,
        default=SHEAR,
        kw_only=True,
    )
    friction: SmoothField = field(SMOOTH, default=None, kw_only=True)
    resolve: Choice = field(RESOLVES, words=RESOLVE, default="cut", kw_only=True)

    def __post_init__(self) -> None:
        default_static(self)
        super().__post_init__()

    def __repr__(self) -> str:
        return (
            f"<skin-contact {self.name!r}: {len(self.markers)} nodes of {self.body.name}, "
            f"{self.a.label}>"
        )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report shapes and laws that a skin cannot have, and skins without area."""
        if getattr(self.a.body, "beam", self.a.body.name) == self.body.name:
            problems.add(
                where, f"a and the skin are both on {self.body.name!r}; take two bodies", "a"
            )
        if self.shape.code < 0:
            problems.add(
                where,
                f"a skin and a {self.shape.tag} cannot touch in this version: a skin touches "
                "half-space, sphere, hollow-sphere, capsule, cuboid, cylinder, bore, torus and "
                "ellipsoid",
                "shape",
            )
        if isinstance(self.law, Hertz) or self.law.curve != POWER:
            problems.add(
                where,
                f"a skin has a law of the pressure over the depth, not {type(self.law).__name__}; "
                "give a PowerLaw, an Impact or a SpringDamper",
                "law",
            )
        if self.resolve == "impulse":
            check_restitution(problems, where, self.law)
        if self.mu_static < self.mu_kinetic:
            problems.add(
                where, f"mu_static {self.mu_static:g} is below mu_kinetic {self.mu_kinetic:g}"
            )
        check_skin(problems, where, self.body, self.nodes)

    @cached_property
    def markers(self) -> tuple[Marker, ...]:
        """Markers of the nodes."""
        return tuple(marker for marker, _ in self._weighted)

    @cached_property
    def weights(self) -> tuple[float, ...]:
        """Area for which each node stands, m2; of beams the length, m."""
        return tuple(weight for _, weight in self._weighted)

    @cached_property
    def _weighted(self) -> list[tuple[Marker, float]]:
        return skin_markers(self.body, self.nodes)

    @property
    def turning(self) -> tuple[tuple[str, Marker], ...]:
        """Marker a: nodes have no orientation of their own here."""
        return (("a", self.a),)

    @property
    def touching_shapes(self) -> tuple[tuple[Marker, Any], ...]:
        """The shape that the skin touches."""
        return ((self.a, self.shape),)

    @property
    def drawn_at(self) -> tuple[Marker, ...]:
        """The shape and the first node."""
        return self.a, self.markers[0]

    @property
    def symbol(self) -> str:
        """Symbol of a spring between two frames."""
        return "bushing"

    @property
    def pushes(self) -> tuple[Push, ...]:
        """A contact of the engine for each node."""
        about_a = mobility(self.a, float(np.hypot.reduce(self.shape.size, initial=0.0)))
        turn_a, thickness = angular_mobility(self.a), self._thickness
        tip, found = Tip((0.0, 0.0, 0.0), self.radius), []
        for marker, weight in self._weighted:
            law = NUMBERS | self.law.numbers(None)
            law |= {key: weight * law[key] for key in ("stiffness", "viscous")}
            mass = 1.0 / (about_a + mobility(marker, self.radius))
            data = {
                **tip_numbers(self.shape, tip),
                "rolling": 0.0,
                "drilling": 0.0,
                "inertia": 1.0 / (turn_a + angular_mobility(marker)),
                **touch_numbers(self, law, mass),
            }
            found.append(
                Push(
                    "contact",
                    data,
                    a=self.a,
                    b=marker,
                    turns=bool(np.any(marker.Psi)) if isinstance(self.body, FlexibleBody) else True,
                    states=tuple(STATES),
                    thickness=thickness,
                    restitution=self.law.asked,
                    slowest=judged_from(self.law, self.resolve),
                )
            )
        return tuple(found)

    @property
    def _thickness(self) -> float:
        """Size of the smaller one of shape and body, m."""
        x = np.real(world_positions(self.markers))
        body = float(np.ptp(x, axis=0).max(initial=0.0)) + self.radius
        return min(x for x in (self.shape.size_about, body or inf) if x > 0.0)
