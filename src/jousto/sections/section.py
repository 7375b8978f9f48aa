"""Cross sections: stiffness constants, and stresses at named section points per unit resultant.

Section axes: y to the left and z up when looking along the member (x forward), through the
centroid and along the principal axes. ``Iy`` is the second moment for bending about y, in the
xz plane.

The shear coefficients are those of Cowper, *J. Appl. Mech.* 33 (1966) 335-340, for nu = 0,
for which they agree with the strain-energy definition and depend on the section only. Use
``Timoshenko(ky=, kz=)`` or a :class:`GeneralSection` to use others.
"""

from __future__ import annotations

import math
from functools import cache, cached_property
from typing import Any, Protocol, TypeGuard, runtime_checkable

import numpy as np

from jousto.base.complexstep import scalar
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import Field, Items, Label, field
from jousto.base.numbers import Number, OptionalPositive, Positive
from jousto.base.object_repr import describe

Shear = tuple[tuple[float, float, float], tuple[float, float, float]]
NO_SHEAR: Shear = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


ROUND = 24
"""Number of points on the circumference of a round section."""


class ShearField(Field[Shear, Shear]):
    """Field of two rows of three numbers, stored as tuples."""

    form = "array"
    shape = (2, 3)

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the rows, or report wrong ones."""
        found = problems.array(where, self.label, value, self.shape)
        return None if found is None else tuple(map(tuple, found.tolist()))


class SectionPoint(Declared, by_value=True):
    """Point of a section where stress is recovered."""

    name: Label = field("Unique within the section")
    y: Number = field("Position along y, section axes", unit="m")
    z: Number = field("Position along z, section axes", unit="m")
    shear: ShearField = field(
        "Rows s12 (= xy) and s13 (= xz); columns are the stress per unit shear force Vy and Vz,"
        " 1/m^2, and per unit torque, 1/m^3",
        default=NO_SHEAR,
    )

    __repr__ = describe


@runtime_checkable
class Section(Protocol):
    """Protocol of a beam section: any object with these properties is a section.

    Attributes
    ----------
    A : float
        Area in m^2.
    Iy, Iz : float
        Second moments of area for bending about y (int z^2 dA) and about z (int y^2 dA) in m^4.
    J : float
        Saint-Venant torsion constant in m^4.
    ky, kz : float or None
        Shear coefficients: the shear areas are ky A along y and kz A along z.
    points : tuple of SectionPoint Points where stress is recovered.
    """

    @property
    def A(self) -> float:
        """Area in m^2."""
        ...

    @property
    def Iy(self) -> float:
        """Second moment for bending about y in m^4."""
        ...

    @property
    def Iz(self) -> float:
        """Second moment for bending about z in m^4."""
        ...

    @property
    def J(self) -> float:
        """Saint-Venant torsion constant in m^4."""
        ...

    @property
    def ky(self) -> float | None:
        """Shear coefficient along y."""
        ...

    @property
    def kz(self) -> float | None:
        """Shear coefficient along z."""
        ...

    @property
    def points(self) -> Any:
        """Points where stress is recovered."""
        ...


def is_section(value: object) -> TypeGuard[Section]:
    """Return whether a value has the properties of a section; known classes compute nothing."""
    kind: Any = type(value)
    return _has_properties(kind) or isinstance(value, Section)


@cache
def _has_properties(kind: type) -> bool:
    """Return whether a class itself has all properties of a section."""
    wanted = (name for name, one in vars(Section).items() if isinstance(one, property))
    return all(hasattr(kind, name) for name in wanted)


class Rectangle(Declared, section="sections", tag="rectangle", by_value=True):
    """Solid rectangle.

    Torsion by Saint-Venant's series, Timoshenko and Goodier, *Theory of Elasticity*, art. 109;
    shear by Jourawski, V Q / (I b); shear coefficients 5/6.

    Raises
    ------
    InputError
        If a side is not positive.

    Examples
    --------
    >>> f"{Rectangle(0.1, 0.1).J:.6e}"
    '1.405770e-05'
    """

    width: Positive = field("Side along y", unit="m")
    height: Positive = field("Side along z", unit="m")

    @property
    def A(self) -> float:
        """Area in m^2."""
        return self.width * self.height

    @property
    def Iy(self) -> float:
        """Second moment for bending about y in m^4."""
        return self.width * self.height**3 / 12.0

    @property
    def Iz(self) -> float:
        """Second moment for bending about z in m^4."""
        return self.height * self.width**3 / 12.0

    @property
    def J(self) -> float:
        """Saint-Venant torsion constant in m^4."""
        long, short = max(self.width, self.height), min(self.width, self.height)
        n = np.arange(1, 60, 2)
        series = scalar(np.sum(np.tanh(0.5 * n * np.pi * long / short) / n**5))
        return long * short**3 / 3.0 * (1.0 - 192.0 / np.pi**5 * short / long * series)

    @property
    def ky(self) -> float:
        """Shear coefficient along y."""
        return 5.0 / 6.0

    @property
    def kz(self) -> float:
        """Shear coefficient along z."""
        return 5.0 / 6.0

    def torsion_shear(self) -> tuple[float, float]:
        """Return the shear stress at the middle of the long and short sides for a unit torque.

        The values are in 1/m^3; the largest shear stress is the first value times the torque. They
        follow from the stress function of Timoshenko and Goodier, art. 109; its series for the
        short side is summed with Catalan's constant, so that both converge exponentially.
        """
        long, short = max(self.width, self.height), min(self.width, self.height)
        n = np.arange(1, 60, 2)
        decay = np.exp(-0.5 * n * np.pi * long / short)
        signs = np.where(n % 4 == 1, 1.0, -1.0)
        cosh = scalar(np.sum(2.0 * decay / (1.0 + decay**2) / n**2))
        one_minus_tanh = scalar(np.sum(signs * 2.0 * decay**2 / (1.0 + decay**2) / n**2))
        catalan = 0.9159655941772190
        at_long = short * (1.0 - 8.0 / np.pi**2 * cosh)
        at_short = 8.0 * short / np.pi**2 * (catalan - one_minus_tanh)
        return at_long / self.J, at_short / self.J

    @cached_property
    def points(self) -> tuple[SectionPoint, ...]:
        """Stress points: corners, middles of the sides and centre."""
        y, z, vy, vz = 0.5 * self.width, 0.5 * self.height, 1.5 / self.A, 1.5 / self.A
        at_long, at_short = self.torsion_shear()
        at_top, at_left = (at_long, at_short) if y >= z else (at_short, at_long)
        return (
            SectionPoint("top", 0.0, z, ((vy, 0.0, -at_top), (0.0, 0.0, 0.0))),
            SectionPoint("bottom", 0.0, -z, ((vy, 0.0, at_top), (0.0, 0.0, 0.0))),
            SectionPoint("left", y, 0.0, ((0.0, 0.0, 0.0), (0.0, vz, at_left))),
            SectionPoint("right", -y, 0.0, ((0.0, 0.0, 0.0), (0.0, vz, -at_left))),
            SectionPoint("top_left", y, z),
            SectionPoint("top_right", -y, z),
            SectionPoint("bottom_left", y, -z),
            SectionPoint("bottom_right", -y, -z),
            SectionPoint("centre", 0.0, 0.0, ((vy, 0.0, 0.0), (0.0, vz, 0.0))),
        )


class Tube(Declared, section="sections", tag="tube", by_value=True):
    """Circular tube, thick or thin.

    Shear coefficient of the hollow circle, Cowper (1966) with nu = 0; shear by Jourawski.

    Raises
    ------
    InputError
        If a dimension is not positive or the wall is thicker than the radius.

    Examples
    --------
    >>> tube = Tube(outer_diameter=0.1, wall=0.005)
    >>> f"{tube.A:.4e} {tube.J:.4e}"
    '1.4923e-03 3.3762e-06'
    """

    outer_diameter: Positive = field("Outer diameter", unit="m")
    wall: Positive = field("Thickness of the wall", unit="m")

    def consistent(self, problems: Problems, where: str) -> None:
        """Report a wall that does not fit."""
        if self.wall > 0.5 * self.outer_diameter:
            problems.add(
                where,
                f"wall {self.wall:g} m is thicker than the radius {0.5 * self.outer_diameter:g} m",
                "wall",
            )

    @property
    def _radii(self) -> tuple[float, float]:
        return 0.5 * self.outer_diameter, 0.5 * self.outer_diameter - self.wall

    @property
    def A(self) -> float:
        """Area in m^2."""
        return math.pi * self.wall * (self.outer_diameter - self.wall)

    @property
    def Iy(self) -> float:
        """Second moment for bending about y in m^4."""
        ro, ri = self._radii
        return 0.25 * self.A * (ro**2 + ri**2)

    @property
    def Iz(self) -> float:
        """Second moment for bending about z in m^4."""
        return self.Iy

    @property
    def J(self) -> float:
        """Torsion constant in m^4."""
        return 2.0 * self.Iy

    @property
    def ky(self) -> float:
        """Shear coefficient along y."""
        ro, ri = self._radii
        f = (1.0 + (ri / ro) ** 2) ** 2
        return 6.0 * f / (7.0 * f + 20.0 * (ri / ro) ** 2)

    @property
    def kz(self) -> float:
        """Shear coefficient along z."""
        return self.ky

    @cached_property
    def points(self) -> tuple[SectionPoint, ...]:
        """24 stress points: top, bottom, left, right, ``deg15`` ... by the angle from left."""
        ro, ri = self._radii
        # first moment of the half section over the width of the cut, 2 wall
        v = (ro**2 + ro * ri + ri**2) / (3.0 * self.Iy)
        return _around(ro, v, ro / self.J)


class Circle(Declared, section="sections", tag="circle", by_value=True):
    """Solid circle.

    Shear coefficient 6/7, Cowper (1966) with nu = 0; shear by Jourawski, 4/3 of the mean.

    Raises
    ------
    InputError
        If the diameter is not positive.

    Examples
    --------
    >>> round(Circle(0.02).A * 1e4, 4)
    3.1416
    """

    diameter: Positive = field("Diameter", unit="m")

    @property
    def A(self) -> float:
        """Area in m^2."""
        return 0.25 * math.pi * self.diameter**2

    @property
    def Iy(self) -> float:
        """Second moment for bending about y in m^4."""
        return math.pi * self.diameter**4 / 64.0

    @property
    def Iz(self) -> float:
        """Second moment for bending about z in m^4."""
        return self.Iy

    @property
    def J(self) -> float:
        """Torsion constant in m^4."""
        return 2.0 * self.Iy

    @property
    def ky(self) -> float:
        """Shear coefficient along y."""
        return 6.0 / 7.0

    @property
    def kz(self) -> float:
        """Shear coefficient along z."""
        return 6.0 / 7.0

    @cached_property
    def points(self) -> tuple[SectionPoint, ...]:
        """24 stress points on the circumference, see `Tube`, and the centre."""
        v = 4.0 / (3.0 * self.A)
        radius = 0.5 * self.diameter
        return (
            *_around(radius, v, radius / self.J),
            SectionPoint("centre", 0.0, 0.0, ((v, 0.0, 0.0), (0.0, v, 0.0))),
        )


class GeneralSection(Declared, section="sections", tag="general", by_value=True):
    """Section given by its constants, about its principal axes.

    Raises
    ------
    InputError
        If a constant is not positive, a coefficient is not a positive number, J exceeds Iy + Iz,
        or two points share a name.

    Examples
    --------
    >>> GeneralSection(A=1e-2, Iy=8e-6, Iz=8e-6, J=1.4e-5).ky is None
    True
    """

    A: Positive = field("Area", unit="m^2", kw_only=True)
    Iy: Positive = field("Second moment for bending about y", unit="m^4", kw_only=True)
    Iz: Positive = field("Second moment for bending about z", unit="m^4", kw_only=True)
    J: Positive = field("Saint-Venant torsion constant", unit="m^4", kw_only=True)
    ky: OptionalPositive = field(
        "Shear coefficient along y; needed by :class:`Timoshenko` only",
        default=None,
        kw_only=True,
    )
    kz: OptionalPositive = field("Shear coefficient along z", default=None, kw_only=True)
    points: Items[SectionPoint] = field(
        "Points where stress is recovered", default=(), kw_only=True
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report an impossible torsion constant, and points with the same name."""
        if self.J > (self.Iy + self.Iz) * (1.0 + 1e-9):
            problems.add(
                where,
                f"torsion constant J = {self.J:g} m^4 is above Iy + Iz = {self.Iy + self.Iz:g} "
                f"m^4, the upper bound of any section",
            )
        names = [p.name for p in self.points]
        for name in sorted({n for n in names if names.count(n) > 1}):
            problems.add(where, f"two points are named '{name}'")

    __repr__ = describe


def _around(radius: float, v: float, t: float) -> tuple[SectionPoint, ...]:
    """Return the points on the circumference of a round section, every 15 degrees.

    The largest bending stress is at most 7.5 degrees from a point. Shear stress is tangential: ``V
    v cos(a)`` at the angle a from the neutral axis of bending, by Jourawski, and ``T t`` from
    torsion.
    """
    four = {0: "left", 90: "top", 180: "right", 270: "bottom"}
    found = {}
    for k in range(ROUND):
        degrees = 360 * k // ROUND
        c, s = math.cos(2.0 * math.pi * k / ROUND), math.sin(2.0 * math.pi * k / ROUND)
        if degrees in four:
            c, s = float(round(c)), float(round(s))
        shear = ((v * s * s, -v * s * c, -t * s), (-v * s * c, v * c * c, t * c))
        name = four.get(degrees, f"deg{degrees}")
        found[name] = SectionPoint(name, radius * c, radius * s, shear)
    first = ("top", "bottom", "left", "right")
    return (*(found.pop(name) for name in first), *found.values())
