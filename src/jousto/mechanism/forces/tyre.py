"""Tyres on a flat road: load, slip forces with relaxation, and aligning moment."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Nested, field
from jousto.base.numbers import DefaultValues, Number, OptionalNumber
from jousto.base.rotations import Direction, turn_onto
from jousto.mechanism.bodies.marker import Marker, MarkerField
from jousto.mechanism.forces.base import ForceElement, Push
from jousto.mechanism.forces.law import EngineLaw
from jousto.mechanism.joints.base import aligned

STATES = {"slip x": "m", "slip y": "m"}
"""Deflection of the contact patch along and across the wheel."""
SINK = 1 / 3
"""Share of the deflection by which the effective rolling radius is smaller than the radius."""

LONGITUDINAL = (1.65, -21.3, 1144.0, 49.6, 226.0, 0.069, -0.006, 0.056, 0.486)
LATERAL = (1.30, -22.1, 1011.0, 1078.0, 1.82, 0.208, 0.0, -0.354, 0.707, 0.028, 0.0, 14.8, 0.022)
ALIGNING = (
    *(2.40, -2.72, -2.28, -1.86, -2.73, 0.110, -0.070, 0.643, -4.04),
    *(0.015, -0.066, 0.945, 0.030, 0.070),
)
"""C and a1 .. of the car tyre of SAE 870421, loads in kN, slip in per cent or degrees."""

EngineLaw(
    "tyre",
    units={"stiffness": "N/m", "damping": "N s/m", "mu": "1", "resistance": "1"},
    constants=(
        *("radius", "relaxation", "lead", "slow", "sink", "law", "half_length", "load", "cx", "cy"),
        *("longitudinal", "lateral", "aligning", "peak"),
    ),
    states=STATES,
    between=True,
    fast={"tyres": ()},
).declared()


FLAT = 0.1
"""Sine of the angle between axle and normal below which a wheel lies on its side."""


class TyreLaw(Declared, section="tyre_laws", by_value=True):
    """Base of the laws of the slip forces of a tyre."""

    kind = "law of a tyre"

    @property
    def numbers(self) -> dict[str, Any]:
        """Numbers of the engine's law."""
        raise NotImplementedError

    @property
    def length(self) -> float:
        """Relaxation length where none is given, m."""
        raise NotImplementedError


class BrushTyre(TyreLaw, tag="brush"):
    """Brush with parabolic pressure: few numbers, forces in closed form.

    Bristles of the contact patch stick to the road up to mu times the pressure. With the slip ``s =
    -(Vsx, Vsy) / (Re W)``, the slip stiffness C = cx, cy at the load Fz_0, and ``g = |(cx sx, cy
    sy)| / (3 mu Fz_0)``, the force is ``F = Fz/Fz_0 (cx sx, cy sy) (1 - g + g^2/3)`` up to g = 1,
    where the whole tyre slides; from there mu Fz. The moment is ``Mz = -(a/3) Fz/Fz_0 cy sy (1 -
    g)^3``, a pneumatic trail of a/3 at small slip, ``a = half_length sqrt(Fz/Fz_0)`` (H. B.
    Pacejka, Tyre and Vehicle Dynamics, 3rd ed. 2012, section 3.2).

    Examples
    --------
    >>> BrushTyre(1.0, load=4000, stiffness_x=80e3, stiffness_y=60e3, half_length=0.06)
    BrushTyre(mu=1.0, load=4000.0, stiffness_x=80000.0, stiffness_y=60000.0, half_length=0.06)
    """

    mu: Number = field("Coefficient of friction", unit="1", above=0)
    load: Number = field(
        "Load Fz_0 at which the next numbers hold", unit="N", above=0, kw_only=True
    )
    stiffness_x: Number = field(
        "Longitudinal force per slip at small slip", unit="N", above=0, kw_only=True
    )
    stiffness_y: Number = field(
        "Cornering stiffness, lateral force per slip angle", unit="N/rad", above=0, kw_only=True
    )
    half_length: Number = field(
        "Half length a of the contact patch", unit="m", above=0, kw_only=True
    )

    @property
    def numbers(self) -> dict[str, Any]:
        """Stiffness per load."""
        return {
            "law": 0.0,
            "mu": self.mu,
            "half_length": self.half_length,
            "load": self.load,
            "cx": self.stiffness_x / self.load,
            "cy": self.stiffness_y / self.load,
            "longitudinal": np.zeros(9),
            "lateral": np.zeros(13),
            "aligning": np.zeros(14),
            "peak": np.ones(2),
        }

    @property
    def length(self) -> float:
        """Half length of the patch: the stiffness at rest is then that of its bristles."""
        return self.half_length


class MagicFormula(TyreLaw, tag="magic-formula"):
    """Magic formula of Bakker, Nyborg and Pacejka with published coefficients.

    ``y = D sin(C atan(B z - E (B z - atan(B z)))) + Sv``, ``z = slip + Sh`` for the longitudinal
    force (slip kappa in per cent), the lateral force and the aligning moment (slip angle in
    degrees), with the load F in kN and the camber angle g in degrees (E. Bakker, L. Nyborg, H. B.
    Pacejka, Tyre modelling for use in vehicle dynamics studies, SAE 870421, 1987):

    * ``D = a1 F^2 + a2 F``, ``E = a6 F^2 + a7 F + a8``, ``B = BCD / (C D)``;
    * ``BCD = (a3 F^2 + a4 F) exp(-a5 F)``, for the lateral force ``a3 sin(a4 atan(a5 F))``;
    * ``Sh = a9 g``, ``Sv = (a10 F^2 + a11 F) g``, B times ``1 - a12 |g|``, and E of the moment over
      ``1 - a13 |g|``.

    Combined slip by similarity: both slips relative to those of the largest forces at the load
    `nominal` have the length s, and each force is that of its pure slip s times its share of s.

    Examples
    --------
    >>> law = MagicFormula()
    >>> print(*(round(x, 1) for x in law.peak))
    10.3 9.4
    """

    nominal: Number = field("Nominal load", unit="N", above=0, default=4000.0)
    longitudinal: DefaultValues = field(
        "C, a1 .. a8; None for the car tyre of the source", shape=(9,), default=None, kw_only=True
    )
    lateral: DefaultValues = field(
        "C, a1 .. a12; None for the car tyre of the source", shape=(13,), default=None, kw_only=True
    )
    aligning: DefaultValues = field(
        "C, a1 .. a13; None for the car tyre of the source", shape=(14,), default=None, kw_only=True
    )

    def __post_init__(self) -> None:
        for key, given in (
            ("longitudinal", LONGITUDINAL),
            ("lateral", LATERAL),
            ("aligning", ALIGNING),
        ):
            if getattr(self, key) is None:
                object.__setattr__(self, key, np.array(given))
        super().__post_init__()

    @cached_property
    def peak(self) -> tuple[float, float]:
        """Slip of the largest longitudinal (per cent) and lateral force (degrees)."""
        return tuple(_peak(c, self.nominal / 1e3) for c in (self.longitudinal, self.lateral))  # type: ignore[return-value]

    @property
    def numbers(self) -> dict[str, Any]:
        """The coefficients."""
        return {
            "law": 1.0,
            "mu": 1.0,
            "half_length": 1.0,
            "load": self.nominal,
            "cx": 1.0,
            "cy": 1.0,
            "longitudinal": self.longitudinal,
            "lateral": self.lateral,
            "aligning": self.aligning,
            "peak": np.array(self.peak),
        }

    @property
    def length(self) -> float:
        """0.3 m, of a car tyre (Pacejka 2012, section 7.2)."""
        return 0.3


def magic_curve(c: Any, load: float, slip: Any) -> Any:
    """Return the magic formula at a load, kN, without camber; slip in per cent or degrees.

    `c` are the coefficients C, a1 .. a8 of `MagicFormula`; 13 of a lateral force, or 9 or 14.
    """
    D = (c[1] * load + c[2]) * load
    if len(c) == len(LATERAL):
        stiffness = c[3] * np.sin(c[4] * np.arctan(c[5] * load))
    else:
        stiffness = (c[3] * load + c[4]) * load * np.exp(-c[5] * load)
    b = stiffness / (c[0] * D) * slip
    E = (c[6] * load + c[7]) * load + c[8]
    return D * np.sin(c[0] * np.arctan(b - E * (b - np.arctan(b))))


MOST_SLIP = 60.0
"""Largest slip at which the largest force is searched, per cent or degrees."""


def _peak(c: Any, load: float) -> float:
    """Return the slip of the largest force, per cent or degrees, by repeated refinement."""
    low, high = 0.0, MOST_SLIP
    for _ in range(12):
        grid = np.linspace(low, high, 41)
        best = int(np.argmax(magic_curve(np.real(c), load, grid)))
        low, high = float(grid[max(best - 1, 0)]), float(grid[min(best + 1, 40)])
    return 0.5 * (low + high)


class TyreLawField(Nested[TyreLaw, TyreLaw]):
    """Field of the law of a tyre."""

    section = "tyre_laws"
    room = "jousto.mechanism.forces"
    noun = "BrushTyre or MagicFormula"

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the law, or report a value of another type."""
        if not isinstance(value, TyreLaw):
            problems.add(where, f"{self.label} is {value!r}, must be {self.noun}(...)", self.key)
        return value


class Tyre(ForceElement, tag="tyre"):
    """Tyre of a wheel on a flat road: load, longitudinal and lateral force, aligning moment.

    With the normal k of the road, the axle n of the wheel (to its left if it rolls forward), and
    the lowest point e of its rim, the deflection is ``D = R s - k . r``, s the sine between k and
    n, and the load ``N = max(0, stiffness D + damping D')``. The tyre may leave the road and land.
    The slip velocities of the point of the road under the wheel, ``Vsx = Vx - Re W`` with ``Re = R
    - sink D`` and Vsy, give the forces by the law.

    The slip follows with the relaxation length L: ``x' = -Vs - V x / L`` is the deflection of the
    contact patch, ``x / L`` the slip (Pacejka, Tyre and Vehicle Dynamics, 2012, section 7.2). So
    nothing is divided by the speed: a wheel at rest stands on springs of the stiffness C / L and
    does not creep on a slope. Below the speed `slow` the springs are damped by the time `lead`.

    The stored energy is that of the load; slip, moment and `resistance` dissipate. The longitudinal
    force has the lever Re about the axle.

    Examples
    --------
    >>> from jousto import RigidBody, ground
    >>> from jousto.mechanism import BrushTyre, Tyre
    >>> law = BrushTyre(1.0, load=4000, stiffness_x=80e3, stiffness_y=60e3, half_length=0.06)
    >>> wheel = RigidBody("wheel", 20.0, (0.5, 1.0, 0.5), position=(0, 0, 0.3))
    >>> Tyre("tyre", ground["origin"], wheel["origin"], 0.31, law, 2e5, axle=(0, 1, 0))
    <tyre 'tyre': ground.origin, wheel.origin>
    """

    kind = "tyre"
    together = ("a", "b", "radius", "law", "stiffness")
    a: MarkerField = field("Marker of the road, at any point of its plane")
    b: MarkerField = field("Marker at the centre of the wheel, on the body that spins")
    radius: Number = field("Radius R without load", unit="m", above=0)
    law: TyreLawField = field("Law of the slip forces")
    stiffness: Number = field("Vertical stiffness", unit="N/m", above=0)
    damping: Number = field("Vertical damping", unit="N s/m", least=0, default=0.0, kw_only=True)
    normal: Direction = field(
        "Normal k of the road in the world frame at the initial pose, fixed to a; None for the z "
        "axis of marker a",
        default=None,
        kw_only=True,
    )
    axle: Direction = field(
        "Axle n in the world frame at the initial pose, fixed to b; None for the z axis of "
        "marker b; about it the wheel turns positively if it rolls forward",
        default=None,
        kw_only=True,
    )
    relaxation: OptionalNumber = field(
        "Relaxation length L; None for that of the law: half the contact patch of a brush, 0.3 m "
        "of the magic formula",
        unit="m",
        above=0,
        default=None,
        kw_only=True,
    )
    sink: Number = field(
        "Share of the deflection by which the effective rolling radius is below R",
        unit="1",
        least=0,
        most=1,
        default=SINK,
        kw_only=True,
    )
    resistance: Number = field(
        "Rolling resistance: torque about the axle over N R",
        unit="1",
        least=0,
        default=0.0,
        kw_only=True,
    )
    slow: Number = field(
        "Speed below which the contact patch is damped as at rest",
        unit="m/s",
        above=0,
        default=1.0,
        kw_only=True,
    )
    lead: Number = field(
        "Damping of the contact patch at rest over its stiffness",
        unit="s",
        least=0,
        default=0.01,
        kw_only=True,
    )

    def __repr__(self) -> str:
        return f"<tyre {self.name!r}: {self.a.label}, {self.b.label}>"

    def consistent(self, problems: Problems, where: str) -> None:
        """Report one body on both sides, and a wheel that lies flat."""
        if self.a.body is self.b.body:
            problems.add(where, f"a and b are both on {self.a.body.name!r}; take two bodies", "b")
        k, n = (np.real(marker.A[:, 2]) for marker in self.frames)
        if float(np.linalg.norm(np.cross(k, n))) < FLAT:
            problems.add(
                where, "the axle is normal to the road at the initial pose; turn the wheel", "axle"
            )

    @cached_property
    def frames(self) -> tuple[Marker, Marker]:
        """Markers with z axes along the normal and along the axle."""
        made = [
            marker if given is None else aligned(marker, turn_onto(marker.A, given))
            for marker, given in ((self.a, self.normal), (self.b, self.axle))
        ]
        return made[0], made[1]

    @property
    def symbol(self) -> str:
        """Symbol of a spring between two frames."""
        return "bushing"

    @property
    def pushes(self) -> tuple[Push, ...]:
        """The tyre as a law of the engine."""
        a, b = self.frames
        length = self.law.length if self.relaxation is None else self.relaxation
        data = {
            "radius": self.radius,
            "stiffness": self.stiffness,
            "damping": self.damping,
            "relaxation": np.array([length, length]),
            "lead": self.lead,
            "slow": self.slow,
            "sink": self.sink,
            "resistance": self.resistance,
            **self.law.numbers,
        }
        return (Push("tyre", data, a=a, b=b, states=tuple(STATES)),)
