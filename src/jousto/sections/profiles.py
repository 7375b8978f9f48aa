"""Built-up sections: I beam and rectangular hollow section."""

from __future__ import annotations

import math
from functools import cached_property

from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalPositive, Positive
from jousto.sections.section import SectionPoint


def _web_shear_coefficient(
    height: float, width: float, webs: tuple[int, float], flange: float
) -> float:
    """Return the shear coefficient along the webs of a thin-walled I or box.

    Strain energy of the shear flow q(s) = V Q(s) / I along the middle lines,
    ``1/k = A / I^2 int (Q/t)^2 t ds``; it equals Cowper (1966) with nu = 0.
    ``height`` and ``width`` are those of the middle lines; ``webs`` is number and thickness of the
    webs.
    """
    number, web = webs
    area = number * web * height + 2.0 * flange * width
    inertia = number * web * height**3 / 12.0 + 0.5 * flange * width * height**2

    # four half flanges: Q = flange height/2 s from the free end or the symmetry plane
    energy = flange * height**2 * (0.5 * width) ** 3 / 3.0
    # webs: Q = corner + web/2 (height^2/4 - z^2)
    corner = 0.5 * height * flange * width / number
    h = 0.5 * height
    energy += (number / web) * (
        corner**2 * height
        + corner * web * (4.0 / 3.0) * h**3
        + 0.25 * web**2 * (16.0 / 15.0) * h**5
    )
    return inertia**2 / (area * energy)


class IBeam(Declared, section="sections", tag="i-beam", by_value=True):
    """Doubly symmetric I section with the web along z.

    Area and second moments are exact for the outline, root fillets included. The torsion constant
    has the junction term of ArcelorMittal, *Sections and Merchant Bars* (2019), notations and
    formulae: ``2/3 (b - 0.63 tf) tf^3 + 1/3 (h - 2 tf) tw^3 + 2 (tw/tf) (0.145 + 0.1 r/tf) D^4``,
    ``D = ((r + tw/2)^2 + (r + tf)^2 - r^2) / (2 r + tf)``. The shear coefficient along z follows
    from the strain energy of the thin-walled section (Cowper 1966, nu = 0); along y it is 5/6 of
    the flanges.

    Raises
    ------
    InputError
        If a dimension is not positive or the plates do not fit.

    Examples
    --------
    IPE 200, whose tables give A = 28.5 cm2, Iy = 1943 cm4, Iz = 142 cm4, It = 6.98 cm4:

    >>> ipe = IBeam(height=0.2, width=0.1, web=0.0056, flange=0.0085, fillet=0.012)
    >>> f"{ipe.A * 1e4:.1f} {ipe.Iy * 1e8:.0f} {ipe.Iz * 1e8:.0f} {ipe.J * 1e8:.2f}"
    '28.5 1943 142 6.98'
    """

    height: Positive = field("Overall size along z", unit="m", kw_only=True)
    width: Positive = field("Overall size along y", unit="m", kw_only=True)
    web: Positive = field("Thickness of the web", unit="m", kw_only=True)
    flange: Positive = field("Thickness of the flanges", unit="m", kw_only=True)
    fillet: Number = field(
        "Root radius, zero for a welded section",
        unit="m",
        least=0,
        wanted="zero or positive",
        default=0.0,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report flanges and webs that do not fit."""
        if 2.0 * (self.flange + self.fillet) >= self.height:
            problems.add(
                where,
                f"flanges and fillets (2 x {self.flange + self.fillet:g} m) fill the whole height"
                f" {self.height:g} m",
            )
        elif self.web + 2.0 * self.fillet > self.width:
            problems.add(
                where,
                f"web and fillets ({self.web + 2.0 * self.fillet:g} m) are wider than the width"
                f" {self.width:g} m",
                "web",
            )

    @property
    def A(self) -> float:
        """Area in m^2."""
        sharp = 2.0 * self.width * self.flange + self.web * (self.height - 2.0 * self.flange)
        return sharp + (4.0 - math.pi) * self.fillet**2

    @property
    def _fillet_moments(self) -> tuple[float, float, float]:
        """Area, distance of the centroid from the plates, and own second moment of one fillet."""
        r = self.fillet
        area = (1.0 - 0.25 * math.pi) * r**2
        distance = r * (10.0 - 3.0 * math.pi) / (12.0 - 3.0 * math.pi)
        about_plate = r**4 * (1.0 / 3.0 - (5.0 * math.pi / 16.0 - 2.0 / 3.0))
        return area, distance, about_plate - area * distance**2

    @property
    def Iy(self) -> float:
        """Second moment for bending about y, the strong axis, in m^4."""
        clear = self.height - 2.0 * self.flange
        area, distance, own = self._fillet_moments
        sharp = (self.width * self.height**3 - (self.width - self.web) * clear**3) / 12.0
        return sharp + 4.0 * (own + area * (0.5 * clear - distance) ** 2)

    @property
    def Iz(self) -> float:
        """Second moment for bending about z, the weak axis, in m^4."""
        clear = self.height - 2.0 * self.flange
        area, distance, own = self._fillet_moments
        sharp = (2.0 * self.flange * self.width**3 + clear * self.web**3) / 12.0
        return sharp + 4.0 * (own + area * (0.5 * self.web + distance) ** 2)

    @property
    def J(self) -> float:
        """Saint-Venant torsion constant in m^4."""
        b, tw, tf, r = self.width, self.web, self.flange, self.fillet
        D = ((r + 0.5 * tw) ** 2 + (r + tf) ** 2 - r**2) / (2.0 * r + tf)
        plates = 2.0 * (b - 0.63 * tf) * tf**3 / 3.0 + (self.height - 2.0 * tf) * tw**3 / 3.0
        return plates + 2.0 * (tw / tf) * (0.145 + 0.1 * r / tf) * D**4

    @property
    def ky(self) -> float:
        """Shear coefficient along y, from the two flanges."""
        return (5.0 / 6.0) * 2.0 * self.width * self.flange / self.A

    @property
    def kz(self) -> float:
        """Shear coefficient along z, mostly from the web."""
        return _web_shear_coefficient(
            self.height - self.flange, self.width, (1, self.web), self.flange
        )

    @cached_property
    def points(self) -> tuple[SectionPoint, ...]:
        """Stress points: tips and outer middles of the flanges, ends and middle of the web."""
        h, b, tw, tf = self.height, self.width, self.web, self.flange
        flow = b * tf * 0.5 * (h - tf)
        v_end = flow / (self.Iy * tw)
        area, distance, _ = self._fillet_moments
        fillets = 2.0 * area * (0.5 * h - tf - distance)
        v_mid = (flow + fillets + 0.5 * tw * (0.5 * h - tf) ** 2) / (self.Iy * tw)
        v_flange = 0.125 * b**2 / self.Iz
        t_web, t_flange = tw / self.J, tf / self.J
        top = ((0.0, 0.0, -t_flange), (0.0, 0.0, 0.0))
        bottom = ((0.0, 0.0, t_flange), (0.0, 0.0, 0.0))
        web_end = ((0.0, 0.0, 0.0), (0.0, v_end, t_web))
        other_end = ((0.0, 0.0, 0.0), (0.0, v_end, -t_web))
        other = ((0.0, 0.0, 0.0), (0.0, v_mid, -t_web))
        return (
            SectionPoint("top", 0.0, 0.5 * h, ((v_flange, 0.0, -t_flange), (0.0, 0.0, 0.0))),
            SectionPoint("bottom", 0.0, -0.5 * h, ((v_flange, 0.0, t_flange), (0.0, 0.0, 0.0))),
            SectionPoint("top_left", 0.5 * b, 0.5 * h, top),
            SectionPoint("top_right", -0.5 * b, 0.5 * h, top),
            SectionPoint("bottom_left", 0.5 * b, -0.5 * h, bottom),
            SectionPoint("bottom_right", -0.5 * b, -0.5 * h, bottom),
            SectionPoint("web", 0.5 * tw, 0.0, ((0.0, 0.0, 0.0), (0.0, v_mid, t_web))),
            SectionPoint("web_top", 0.5 * tw, 0.5 * h - tf, web_end),
            SectionPoint("web_bottom", 0.5 * tw, tf - 0.5 * h, web_end),
            SectionPoint("web_right", -0.5 * tw, 0.0, other),
            SectionPoint("web_top_right", -0.5 * tw, 0.5 * h - tf, other_end),
            SectionPoint("web_bottom_right", -0.5 * tw, tf - 0.5 * h, other_end),
        )


class Box(Declared, section="sections", tag="box", by_value=True):
    """Rectangular hollow section with sharp corners.

    Torsion by Bredt's formula plus the Saint-Venant torsion of the walls, as in EN 10210-2:2006:
    ``J = 4 Am^2 / oint ds/t + 1/3 oint t^3 ds``. Shear coefficients by the strain energy of the
    thin-walled section (Cowper 1966, nu = 0).

    Raises
    ------
    InputError
        If a dimension is not positive or the walls do not fit.

    Examples
    --------
    >>> box = Box(width=0.1, height=0.2, web=0.008)
    >>> f"{box.A * 1e4:.2f} {box.Iy * 1e8:.0f} {box.Iz * 1e8:.0f}"
    '45.44 2306 758'
    """

    width: Positive = field("Outer size along y", unit="m")
    height: Positive = field("Outer size along z", unit="m")
    web: Positive = field("Thickness of the two walls along z", unit="m", kw_only=True)
    flange: OptionalPositive = field(
        "Thickness of the two walls along y; None for that of the webs",
        unit="m",
        default=None,
        kw_only=True,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Report walls that do not fit."""
        for wall, size, names in (
            (self.web, self.width, ("webs", "width")),
            (self._tf, self.height, ("flanges", "height")),
        ):
            if 2.0 * wall >= size:
                problems.add(
                    where, f"{names[0]} (2 x {wall:g} m) fill the whole {names[1]} {size:g} m"
                )

    @property
    def _tf(self) -> float:
        return self.web if self.flange is None else self.flange

    @property
    def _inner(self) -> tuple[float, float]:
        return self.width - 2.0 * self.web, self.height - 2.0 * self._tf

    @property
    def A(self) -> float:
        """Area in m^2."""
        b, h = self._inner
        return self.width * self.height - b * h

    @property
    def Iy(self) -> float:
        """Second moment for bending about y in m^4."""
        b, h = self._inner
        return (self.width * self.height**3 - b * h**3) / 12.0

    @property
    def Iz(self) -> float:
        """Second moment for bending about z in m^4."""
        b, h = self._inner
        return (self.height * self.width**3 - h * b**3) / 12.0

    @property
    def J(self) -> float:
        """Torsion constant in m^4."""
        b, h, tw, tf = self.width - self.web, self.height - self._tf, self.web, self._tf
        bredt = 4.0 * (b * h) ** 2 / (2.0 * b / tf + 2.0 * h / tw)
        return bredt + 2.0 * (b * tf**3 + h * tw**3) / 3.0

    @property
    def ky(self) -> float:
        """Shear coefficient along y."""
        b, h = self.width - self.web, self.height - self._tf
        return _web_shear_coefficient(b, h, (2, self._tf), self.web)

    @property
    def kz(self) -> float:
        """Shear coefficient along z."""
        b, h = self.width - self.web, self.height - self._tf
        return _web_shear_coefficient(h, b, (2, self.web), self._tf)

    @cached_property
    def points(self) -> tuple[SectionPoint, ...]:
        """Stress points: outer middles of the walls, and outer corners."""
        y, z, tw, tf = 0.5 * self.width, 0.5 * self.height, self.web, self._tf
        b, h = self._inner
        # first moments at mid-wall and at the ends of the webs
        q_z = 0.5 * self.width * tf * (z - 0.5 * tf)
        v_web = (q_z + 0.5 * tw * (0.5 * h) ** 2) / (self.Iy * tw)
        q_y = 0.5 * self.height * tw * (y - 0.5 * tw)
        v_flange = (q_y + 0.5 * tf * (0.5 * b) ** 2) / (self.Iz * tf)
        v_corner = q_z / (self.Iy * tw)
        v_across = tw * (y - 0.5 * tw) * 0.5 * h / (self.Iz * tw)

        # Bredt's shear flow plus the linear part in the wall at the outer face
        flow = 2.0 * (y - 0.5 * tw) * 2.0 * (z - 0.5 * tf)
        bredt = 2.0 * flow / (2.0 * (2.0 * y - tw) / tf + 2.0 * (2.0 * z - tf) / tw)
        t_web, t_flange = (bredt / tw + tw) / self.J, (bredt / tf + tf) / self.J

        def corner(name: str, side: float, level: float) -> SectionPoint:
            shear = ((0.0, 0.0, 0.0), (-side * level * v_across, v_corner, side * t_web))
            return SectionPoint(name, side * y, level * z, shear)

        return (
            SectionPoint("top", 0.0, z, ((v_flange, 0.0, -t_flange), (0.0, 0.0, 0.0))),
            SectionPoint("bottom", 0.0, -z, ((v_flange, 0.0, t_flange), (0.0, 0.0, 0.0))),
            SectionPoint("left", y, 0.0, ((0.0, 0.0, 0.0), (0.0, v_web, t_web))),
            SectionPoint("right", -y, 0.0, ((0.0, 0.0, 0.0), (0.0, v_web, -t_web))),
            corner("top_left", 1.0, 1.0),
            corner("top_right", -1.0, 1.0),
            corner("bottom_left", 1.0, -1.0),
            corner("bottom_right", -1.0, -1.0),
        )
