"""Contact between two shapes that are fixed to markers."""

from __future__ import annotations

from collections.abc import Mapping
from math import gamma, hypot, inf, pi, sqrt
from typing import Any

from jousto.base.errors import Problems
from jousto.base.fields import Choice, field
from jousto.base.numbers import DefaultNumber, Number
from jousto.mechanism.bodies.marker import Marker, MarkerField
from jousto.mechanism.contacts.collision import DRILLING, ROLLING
from jousto.mechanism.contacts.effective_mass import angular_mobility, lightest, mobility
from jousto.mechanism.contacts.friction import default_static
from jousto.mechanism.contacts.laws import NUMBERS, TABLE, ContactLawField, Hertz, rest_damping
from jousto.mechanism.contacts.pairing import POINTS, check_pair, most_points, paired
from jousto.mechanism.contacts.shapes import Shape, ShapeField, Tip, touching
from jousto.mechanism.contacts.sticking import check_sticking, tip_slips
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.friction import CONTACT_FRICTION, ContactFriction, StickSlip
from jousto.mechanism.forces.law import EngineLaw
from jousto.mechanism.joints.coordinate import Coordinate

STATES = {
    "phase": "1",
    "approach": "m/s",
    "since": "s",
    "stretch x": "m",
    "stretch y": "m",
    "stretch z": "m",
}
"""0 apart, 1 sticks, 2 slips; speed of approach at the touch, its time; stretch of the bristle."""

SHEAR = 0.8235294117647058
"""2 (1 - nu) / (2 - nu) for nu = 0.3: shear stiffness of a contact over its normal stiffness."""

POINT_STATES = STATES | {"features": "1", "weight": "1"}
"""States of a point of two polytopes: also which features touch, and its share of the stiffness."""
TURN = {"turn x": "rad", "turn y": "rad", "turn z": "rad"}
"""Turn of the bristle of a contact that resists rolling and drilling."""
TURN_NUMBERS = ("rolling", "drilling", "inertia")
LAW_NUMBERS = (
    *("stiffness", "exponent", "damping", "slowest", "viscous", "full"),
    *("curve", "extent", "impedance", "velocity", "shear", "mass", "duration"),
    *("resolve", "restitution"),
)
RESOLVE = ("cut", "impulse", "report")
"""How a touch is resolved, in the order of ``JO_RESOLVE_CUT`` of the engine."""
RESOLVES = (
    "How a touch is resolved: cut into 20 steps, replaced by an impulse in an instant, or "
    "reported if it is too short for the step"
)
"""Description of the field `resolve`."""


def point_states(points: int) -> dict[str, str]:
    """Units of the states by name; those of the second point end with 2, and so on."""
    return {
        f"{key} {i + 1}" if i else key: unit
        for i in range(points)
        for key, unit in POINT_STATES.items()
    }


EngineLaw(
    "contact",
    units={"mu_static": "1", "mu_kinetic": "1"},
    constants=(
        "shape",
        "size",
        "centre",
        "radius",
        "ring",
        "around",
        "axes",
        *LAW_NUMBERS,
        *TURN_NUMBERS,
    ),
    states=STATES | TURN,
    between=True,
    fast={"contacts": ()},
    yields=True,
).declared()
EngineLaw(
    "contact pair",
    units={"mu_static": "1", "mu_kinetic": "1"},
    constants=LAW_NUMBERS,
    states=point_states(POINTS),
    between=True,
    fast={"contacts": ()},
    yields=True,
).declared()


class Contact(ForceElement, tag="contact"):
    """Two shapes touch: a normal force with restitution, and friction that sticks without creep.

    Shapes are fixed to markers of any bodies. A sphere (or a point) touches every shape; cuboids,
    hulls, capsules, cylinders and ellipsoids touch each other and half-spaces, the first three also
    surfaces of triangles by their corners; tips of a capsule or cuboid touch hollow shapes, and the
    rim of a torus a half-space. The depth
    d of the overlap gives the normal force by the law. Both bodies receive it at one common point,
    in the middle of the overlap, so that momentum is kept exactly.

    ``rolling`` and ``drilling`` are lengths l of moments up to ``l N`` against rolling and against
    turning about the normal; below the moment acts through a bristle, so that a ball that has come
    to rest does not creep. ``friction=Regularised(velocity)`` replaces the bristle of the slip by a
    smooth function of its velocity; what would stick then creeps.

    Two faces touch at the corners of the area that they share, up to 8. Each has the law, times a
    weight: 1 at each of four corners of a whole rectangular face; the sum of the weights follows
    the area, and their centre is the centre of the area. A cylinder that stands on a face touches
    it at four points of its rim, which turn with the lowest one; lying, at both ends of its side.

    Friction acts through a bristle, a spring of stiffness ``shear dN/dd`` in the contact plane that
    breaks at ``mu_static N``; then the friction is ``mu_kinetic N`` against the slip, in the
    direction of the velocity (a circle, not a pyramid), until the slip turns. A body at rest
    therefore stays where it is. Steps end where a touch, a slip, a stop and a parting begin.

    A step in which a gap could have closed and opened again is shortened until it is certain that
    it has not, so that no body flies through another one. A touch is resolved by 20 steps, and
    explicit methods shorten their steps to what the contact needs while it lasts. Elastic energy of
    the contact and of the bristle counts as stored, the rest as dissipated.

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> from jousto.mechanism import Contact, HalfSpace, PowerLaw, Sphere
    >>> ball = RigidBody.sphere("ball", radius=0.1, mass=1.0, position=(0, 0, 1.1))
    >>> law = PowerLaw(1e7, restitution=0.7)
    >>> Contact("bounce", ground["origin"], HalfSpace(), ball["origin"], Sphere(0.1), law)
    <contact 'bounce': ground.origin, ball.origin>
    """

    kind = "contact"
    summed = True
    together = (
        "a",
        "b",
        "shape_a",
        "shape_b",
        "law",
        "mu_kinetic",
        "mu_static",
        "rolling",
        "drilling",
    )
    a: MarkerField = field("Marker of the first shape")
    shape_a: ShapeField = field("Shape in the frame of a")
    b: MarkerField = field("Marker of the second shape")
    shape_b: ShapeField = field("Shape in the frame of b")
    law: ContactLawField = field("Law of the normal force")
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

    friction: ContactFriction = field(CONTACT_FRICTION, default=None, kw_only=True)
    rolling: Number = field(ROLLING, unit="m", least=0, default=0.0, kw_only=True)
    drilling: Number = field(DRILLING, unit="m", least=0, default=0.0, kw_only=True)
    resolve: Choice = field(RESOLVES, words=RESOLVE, default="cut", kw_only=True)

    def __post_init__(self) -> None:
        default_static(self)
        super().__post_init__()

    def __repr__(self) -> str:
        return f"<contact {self.name!r}: {self.a.label}, {self.b.label}>"

    def consistent(self, problems: Problems, where: str) -> None:
        """Report pairs that are not available, and laws that do not fit them."""
        if self.a.body is self.b.body:
            problems.add(where, f"a and b are both on {self.a.body.name!r}; take two bodies", "b")
        if self._tips is None and not self._paired:
            problems.add(
                where,
                f"{self.shape_a.tag} and {self.shape_b.tag} cannot touch in this version: a sphere "
                "touches every shape; cuboid, capsule, convex-hull, cylinder and ellipsoid touch "
                "each other and half-spaces, the first three also, by their vertices, "
                "triangle-mesh and height-field; cuboid and capsule touch hollow spheres and "
                "bores; a torus, which has a hole, only half-spaces",
                "shape_b",
            )
        elif self._tips is None:
            check_pair(problems, where, self.sides[1], self.sides[3])
        curvature = self._curvature
        if isinstance(self.law, Hertz) and (curvature is None or curvature <= 0.0):
            problems.add(
                where,
                "Hertz's law needs spheres, or a sphere on a half-space or in a larger hollow "
                f"sphere, not {self.shape_a.tag} and {self.shape_b.tag}; give a PowerLaw",
                "law",
            )
        if self._tips is None and self.law.curve == TABLE:
            problems.add(
                where,
                f"a {self.shape_a.tag} and a {self.shape_b.tag} share the stiffness of their faces "
                "among corners, which a TableLaw does not; give a PowerLaw",
                "law",
            )
        if self.resolve == "impulse":
            check_restitution(problems, where, self.law)
        self._check_turn(problems, where)
        if self.sticks:
            check_sticking(problems, where, self, self.sides, self._tips)
        if self.mu_static < self.mu_kinetic:
            problems.add(
                where, f"mu_static {self.mu_static:g} is below mu_kinetic {self.mu_kinetic:g}"
            )

    @property
    def sticks(self) -> bool:
        """Whether rows hold the points that stick."""
        return isinstance(self.friction, StickSlip)

    @property
    def slips(self) -> tuple[tuple[Coordinate, Coordinate], ...]:
        """Two coordinates of each tip that rows may hold, whose rates are its slip velocity."""
        if not self.sticks:
            return ()
        a, _, b, _ = self.sides
        return tuple(tip_slips(self.name, a, b, tip) for tip in self._tips)

    @property
    def mass_in_play(self) -> float:
        """Mass of both bodies in series against a push without turning, kg."""
        return lightest(self.a, self.b)

    @property
    def _turns(self) -> bool:
        """Whether it resists rolling or drilling."""
        return self.rolling > 0.0 or self.drilling > 0.0

    def _check_turn(self, problems: Problems, where: str) -> None:
        """Report resistance to rolling and drilling where there is none."""
        if not self._turns:
            return
        word = "rolling" if self.rolling else "drilling"
        if self._tips is None:
            problems.add(
                where,
                f"a {self.shape_a.tag} and a {self.shape_b.tag} touch at corners, whose forces "
                f"resist turning by themselves; leave out {word}",
                word,
            )
        if self.resolve == "impulse":
            refuse_turn(problems, where, word)

    @property
    def _paired(self) -> bool:
        """Whether both touch at several points."""
        return paired(self.shape_a, self.shape_b) or paired(self.shape_b, self.shape_a)

    @property
    def _swapped(self) -> bool:
        """Whether the tips belong to a, or b is the half-space or the surface of a pair.

        A sphere touches a polytope: it need not turn with its body.
        """
        first, second = self.shape_a, self.shape_b
        if first.round and not second.round and paired(second, first):
            return touching(first, second) is None
        if touching(first, second) is not None or paired(first, second):
            return False
        return paired(second, first) or touching(second, first) is not None

    @property
    def sides(self) -> tuple[Marker, Shape, Marker, Shape]:
        """Marker and shape that is touched, marker and shape of the tips."""
        first, second = (self.a, self.shape_a), (self.b, self.shape_b)
        return (*second, *first) if self._swapped else (*first, *second)

    @property
    def _tips(self) -> Any:
        _, on, _, of = self.sides
        return touching(on, of)

    @property
    def _curvature(self) -> float | None:
        both = (self.shape_a.curvature, self.shape_b.curvature)
        return None if None in both else sum(both)  # type: ignore[arg-type]

    @property
    def touching_shapes(self) -> tuple[tuple[Marker, Any], ...]:
        """Both shapes."""
        return ((self.a, self.shape_a), (self.b, self.shape_b))

    @property
    def symbol(self) -> str:
        """Symbol of a spring between two frames."""
        return "bushing"

    @property
    def pushes(self) -> tuple[Push, ...]:
        """One law of the engine for each tip, or one for a pair of polytopes."""
        tips = self._tips
        return (self._pair,) if tips is None else tuple(self._push(tip) for tip in tips)

    def _numbers(self, reach: float) -> dict[str, Any]:
        """Numbers of the law for a point of b at a distance `reach` from its marker, m."""
        a, on, b, _ = self.sides
        mass = 1.0 / (mobility(a, _reach(on)) + mobility(b, reach))
        return touch_numbers(self, NUMBERS | self.law.numbers(self._curvature), mass)

    def _push(self, tip: Tip) -> Push:
        a, on, b, _ = self.sides
        data: dict[str, Any] = {
            **tip_numbers(on, tip),
            "rolling": self.rolling,
            "drilling": self.drilling,
            "inertia": 1.0 / (angular_mobility(a) + angular_mobility(b)),
            **self._numbers(tip.reach),
        }
        law, curvature = self.law, self._curvature
        pressure = 0.0
        if isinstance(law, Hertz) and curvature:
            pressure = (6.0 * law.modulus**2 * curvature**2) ** (1.0 / 3.0) / pi
        return Push(
            "contact",
            data,
            rest=(law.rows,) if law.curve == TABLE else (),
            a=a,
            b=b,
            states=tuple(STATES | TURN if self._turns else STATES),
            pressure=pressure,
            thickness=self._thickness,
            restitution=self.law.asked,
            slowest=judged_from(self.law, self.resolve),
        )

    @property
    def _pair(self) -> Push:
        a, on, b, of = self.sides
        assert of.polytope is not None
        return Push(
            "contact pair",
            self._numbers(_reach(of)),
            rest=((on.mesh or on.polytope).numbers, of.polytope.numbers),  # type: ignore[union-attr]
            a=a,
            b=b,
            states=tuple(point_states(most_points(on, of))),
            thickness=self._thickness,
            restitution=self.law.asked,
            slowest=judged_from(self.law, self.resolve),
        )

    @property
    def _thickness(self) -> float:
        """Size of the smaller shape, m; 0 if both have no end."""
        sizes = (self.shape_a.size_about, self.shape_b.size_about)
        return min((x for x in sizes if 0.0 < x < inf), default=0.0)


def touch_numbers(force: Any, law: Mapping[str, float], mass: float) -> dict[str, float]:
    """Return the numbers of the law of a touch, of its friction and of how it is resolved.

    Parameters
    ----------
    force : Contact or SkinContact
        Has coefficients of friction and a law.
    law : mapping of str to float
        Numbers of the normal force.
    mass : float
        Smallest mass in play, kg.
    """
    strikes = force.resolve == "impulse"
    sticks = isinstance(force.friction, StickSlip)  # its friction is elsewhere
    return {
        **law,
        "damping": rest_damping(force.law, law) if strikes else law["damping"],
        "mu_static": 0.0 if sticks else force.mu_static,
        "mu_kinetic": 0.0 if sticks else force.mu_kinetic,
        "shear": force.shear if force.mu_static and force.friction is None else 0.0,
        "velocity": getattr(force.friction, "velocity", 0.0),
        "resolve": RESOLVE.index(force.resolve),
        "restitution": getattr(force.law, "restitution", 0.0),
        "mass": mass,
        "duration": duration(mass, law["stiffness"], law["exponent"]),
    }


def judged_from(law: Any, resolve: str) -> float:
    """Return the speed of approach above which a touch has the restitution of its law, m/s.

    Infinite for touches that are impulses: what is left for the force is rest.
    """
    return inf if resolve == "impulse" else float(getattr(law, "slowest", 0.0))


def tip_numbers(on: Shape, tip: Tip) -> dict[str, Any]:
    """Return the numbers of a shape that is touched, and of the tip that touches it."""
    return {
        "shape": on.code,
        "size": (*on.size, 0.0, 0.0, 0.0)[:3],
        "centre": tip.centre,
        "radius": tip.radius,
        "ring": tip.ring,
        "around": tip.place,
        "axes": tip.axes or (0.0, 0.0, 0.0),
    }


def check_restitution(problems: Problems, where: str, law: Any) -> None:
    """Report a law without a coefficient of restitution or a power, which an impulse needs."""
    if not hasattr(law, "restitution") or law.curve:
        problems.add(
            where,
            f"resolve='impulse' needs a law with a restitution, not {type(law).__name__}; give a "
            "PowerLaw or Hertz",
            "resolve",
        )


def refuse_turn(problems: Problems, where: str, word: str) -> None:
    """Report resistance to rolling or drilling (`word`) of touches that are impulses."""
    problems.add(
        where,
        f"an impulse has no moment that resists {word}; take resolve='cut', or leave out {word}",
        word,
    )


def _reach(shape: Shape) -> float:
    """Return the distance from the marker to the farthest place that can be touched, m."""
    return hypot(*shape.size)


def duration(mass: float, stiffness: float, exponent: float) -> float:
    """Return the duration of a touch at 1 m/s without loss, s; at v ``v^((1-n)/(1+n))`` of it."""
    n = exponent
    span = sqrt(pi) * gamma(1.0 + 1.0 / (n + 1.0)) / gamma(0.5 + 1.0 / (n + 1.0))
    return float(2.0 * span * ((n + 1.0) * mass / (2.0 * stiffness)) ** (1.0 / (n + 1.0)))
