"""Sections: constants against tables and closed forms, section-point stresses against integrals."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

import session
from jousto.base.errors import InputError
from jousto.sections.profiles import Box, IBeam
from jousto.sections.section import (
    Circle,
    GeneralSection,
    Rectangle,
    Section,
    SectionPoint,
    Tube,
)

WIDE = Rectangle(0.12, 0.05)
TALL = Rectangle(0.05, 0.12)
TUBE = Tube(0.1, 0.012)
ROD = Circle(0.06)
WELDED = IBeam(height=0.3, width=0.15, web=0.008, flange=0.012)
HOLLOW = Box(0.1, 0.2, web=0.006, flange=0.01)
GENERAL = GeneralSection(
    A=1e-3, Iy=2e-6, Iz=1e-6, J=5e-7, ky=0.8, kz=0.7, points=(SectionPoint("top", 0.0, 0.05),)
)
SECTIONS = (WIDE, TALL, TUBE, ROD, WELDED, HOLLOW, GENERAL)

# horizontal width b(z) of each solid shape and its half height
WIDTHS: tuple[tuple[Section, Callable[[float], float], float], ...] = (
    (WIDE, lambda z: 0.12, 0.025),
    (TALL, lambda z: 0.05, 0.06),
    (ROD, lambda z: 2.0 * math.sqrt(0.03**2 - z**2), 0.03),
    (
        TUBE,
        lambda z: 2.0 * (math.sqrt(0.05**2 - z**2) - math.sqrt(max(0.038**2 - z**2, 0.0))),
        0.05,
    ),
    (WELDED, lambda z: 0.008 if abs(z) < 0.138 else 0.15, 0.15),
    (HOLLOW, lambda z: 0.012 if abs(z) < 0.09 else 0.1, 0.1),
)


def test_every_exported_section_is_tested() -> None:
    kinds = {
        thing
        for thing in session.public().values()
        if isinstance(thing, type)
        and {"A", "Iy", "J"} <= {*dir(thing), *getattr(thing, "__annotations__", {})}
    }
    assert kinds == {type(s) for s in SECTIONS}
    assert all(isinstance(s, Section) for s in SECTIONS)


@pytest.mark.parametrize(("section", "width", "top"), WIDTHS)
def test_area_moments_and_jourawski_by_quadrature(
    section: Section, width: Callable[[float], float], top: float
) -> None:
    breaks = [z for z in (0.038, 0.138, 0.09) if z < top]

    def integral(f: Callable[[float], float], a: float) -> float:
        points = [z for z in breaks if z > a]
        return float(quad(f, a, top, points=points, limit=400, epsabs=0.0, epsrel=1e-10)[0])

    # QUADPACK with the square-root ends of the circles
    assert_allclose(2.0 * integral(width, 0.0), section.A, rtol=1e-8)
    Iy = 2.0 * integral(lambda z: z**2 * width(z), 0.0)
    assert_allclose(Iy, section.Iy, rtol=1e-8)

    # every point where the cut is that of solid walls: V Q / (I b)
    checked = 0
    for p in section.points:
        if p.name in ("left", "right", "centre", "web", "web_top", "web_bottom") or (
            "_" in p.name and isinstance(section, Box)
        ):
            z = min(abs(p.z), 0.09) if isinstance(section, Box) else abs(p.z)
            Q = integral(lambda s: s * width(s), z)
            assert_allclose(p.shear[1][1], Q / (Iy * width(z - 1e-12)), rtol=1e-7, err_msg=p.name)
            checked += 1
    assert checked >= 2


def test_turned_sections_exchange_their_axes() -> None:
    for one, turned in (
        (WIDE, TALL),
        (HOLLOW, Box(width=0.2, height=0.1, web=0.01, flange=0.006)),
    ):
        assert_allclose([one.Iy, one.ky, one.J], [turned.Iz, turned.kz, turned.J], rtol=1e-14)
        at = {p.name: p for p in one.points}
        turned_at = {p.name: p for p in turned.points}
        assert_allclose(at["top"].shear[0][0], turned_at["left"].shear[1][1], rtol=1e-14)
        assert_allclose(-at["top"].shear[0][2], turned_at["left"].shear[1][2], rtol=1e-14)


def test_fillets_by_quadrature() -> None:
    h, b, tw, tf, r = 0.2, 0.1, 0.0056, 0.0085, 0.012
    s = IBeam(height=h, width=b, web=tw, flange=tf, fillet=r)

    def width(z: float) -> float:
        below = 0.5 * h - tf - z
        return tw + 2.0 * (r - math.sqrt(r**2 - (r - below) ** 2)) if below < r else tw

    def integral(f: Callable[[float], float]) -> float:
        points = [0.5 * h - tf - r]
        value = quad(f, 0.0, 0.5 * h - tf, points=points, limit=400, epsabs=0.0, epsrel=1e-11)
        return float(value[0])

    flange = 0.5 * (h - tf)
    A = 2 * (b * tf + integral(width))
    Iy = 2 * (b * tf**3 / 12 + b * tf * flange**2 + integral(lambda z: z**2 * width(z)))
    Iz = 2 * (tf * b**3 / 12 + integral(lambda z: width(z) ** 3 / 12))
    assert_allclose([s.A, s.Iy, s.Iz], [A, Iy, Iz], rtol=1e-9)
    Q = b * tf * flange + integral(lambda z: z * width(z))
    web = {p.name: p for p in s.points}["web"]
    assert_allclose(web.shear[1][1], Q / (Iy * tw), rtol=1e-9)


# h, b, tw, tf, r in mm; A cm2, Iy cm4, Iz cm4, It cm4 as printed: ArcelorMittal, Sections and
# Merchant Bars (2019), tables IPE, HE
PROFILES = (
    ("IPE 200", (200, 100, 5.6, 8.5, 12), (28.5, 1943, 142.4, 6.98)),
    ("IPE 300", (300, 150, 7.1, 10.7, 15), (53.8, 8356, 603.8, 20.12)),
    ("HE 200 A", (190, 200, 6.5, 10, 18), (53.8, 3692, 1336, 20.98)),
    ("HE 200 B", (200, 200, 9, 15, 18), (78.1, 5696, 2003, 59.28)),
)


@pytest.mark.parametrize(("name", "mm", "table"), PROFILES, ids=[p[0] for p in PROFILES])
def test_rolled_profiles_against_the_table(
    name: str, mm: tuple[float, ...], table: tuple[float, ...]
) -> None:
    h, b, tw, tf, r = (x * 1e-3 for x in mm)
    s = IBeam(height=h, width=b, web=tw, flange=tf, fillet=r)
    # three to four printed digits
    assert_allclose([s.A * 1e4, s.Iy * 1e8, s.Iz * 1e8, s.J * 1e8], table, rtol=1.2e-3)
    # without fillets the area misses the table by the four corners, (4 - pi) r^2
    sharp = IBeam(height=h, width=b, web=tw, flange=tf)
    assert_allclose(s.A - sharp.A, (4 - math.pi) * r**2, rtol=1e-12)


# Timoshenko and Goodier, Theory of Elasticity, art. 109, table: long/short, k1 = J/(long short^3),
# k2 = T/(tau_max long short^2)
TORSION = (
    (1.0, 0.1406, 0.208),
    (1.2, 0.166, 0.219),
    (1.5, 0.196, 0.231),
    (2.0, 0.229, 0.246),
    (2.5, 0.249, 0.258),
    (3.0, 0.263, 0.267),
    (4.0, 0.281, 0.282),
    (5.0, 0.291, 0.291),
    (10.0, 0.312, 0.312),
)


@pytest.mark.parametrize(("ratio", "k1", "k2"), TORSION)
def test_rectangle_torsion_against_the_table(ratio: float, k1: float, k2: float) -> None:
    s = Rectangle(0.01, 0.01 * ratio)
    assert_allclose(s.J / (0.01**4 * ratio), k1, atol=6e-4)
    at_long, _ = s.torsion_shear()
    left = {p.name: p for p in s.points}["left"]  # the middle of the long side
    assert_allclose(left.shear[1][2], at_long, rtol=1e-12)
    assert_allclose(1.0 / (at_long * 0.01**3 * ratio), k2, atol=6e-4)


@pytest.mark.parametrize("ratio", [1.0, 1.7, 4.0])
def test_rectangle_torsion_against_a_collocation_solution(ratio: float) -> None:
    # laplace(phi) = -2 on the rectangle, phi = 0 on its edge, by Chebyshev collocation
    n = 40
    x = np.cos(np.pi * np.arange(n + 1) / n)
    c = np.where((np.arange(n + 1) == 0) | (np.arange(n + 1) == n), 2.0, 1.0)
    c = c * (-1.0) ** np.arange(n + 1)
    dx = x[:, None] - x
    D = np.outer(c, 1.0 / c) / (dx + np.eye(n + 1))
    D -= np.diag(D.sum(axis=1))
    w = np.array([_clenshaw_curtis(n, k) for k in range(n + 1)])
    a, b = 0.5 * ratio, 0.5
    D2 = (D @ D)[1:-1, 1:-1]
    E = np.eye(n - 1)
    phi = np.zeros((n + 1, n + 1))
    operator = np.kron(D2 / a**2, E) + np.kron(E, D2 / b**2)
    phi[1:-1, 1:-1] = np.linalg.solve(operator, -2.0 * np.ones((n - 1) ** 2)).reshape(n - 1, n - 1)

    s = Rectangle(ratio, 1.0)
    J = 2.0 * a * b * w @ phi @ w
    assert_allclose(s.J, J, rtol=1e-6)  # corner singularities limit the collocation
    middle = n // 2
    at_long, at_short = -(phi @ D.T / b)[middle, 0], -(D @ phi / a)[0, middle]
    assert_allclose(s.torsion_shear(), [at_long / J, at_short / J], rtol=1e-5)


def _clenshaw_curtis(n: int, k: int) -> float:
    s = sum(
        (1.0 if j in (0, n // 2) else 2.0) / (1.0 - 4.0 * j**2) * math.cos(2 * math.pi * j * k / n)
        for j in range(n // 2 + 1)
    )
    return s / n * (1.0 if k in (0, n) else 2.0)


def test_circles() -> None:
    assert_allclose(ROD.J, math.pi * 0.06**4 / 32, rtol=1e-14)
    assert_allclose(TUBE.J, math.pi * (0.1**4 - 0.076**4) / 32, rtol=1e-13)
    assert_allclose(TUBE.A, math.pi * (0.1**2 - 0.076**2) / 4, rtol=1e-13)
    # Cowper 1966, nu = 0: solid 6/7, thin tube 1/2
    assert_allclose(Tube(0.06, 0.03).ky, ROD.ky, rtol=1e-14)
    assert_allclose(Tube(1.0, 1e-6).kz, 0.5, rtol=1e-5)
    left = {p.name: p for p in ROD.points}["left"]
    assert_allclose(left.shear[1][2], 16.0 / (math.pi * 0.06**3), rtol=1e-13)  # T / Wp


def test_thin_walled_shear_coefficients_are_those_of_cowper() -> None:
    # Cowper (1966), table 1, with nu = 0; b, h between middle lines
    def cowper(m: float, n: float) -> float:
        return (
            10 * (1 + 3 * m) ** 2 / (12 + 72 * m + 150 * m**2 + 90 * m**3 + 30 * n**2 * (m + m**2))
        )

    h, b = 0.3 - 0.012, 0.15
    assert_allclose(WELDED.kz, cowper(2 * b * 0.012 / (h * 0.008), b / h), rtol=1e-12)
    h, b = 0.2 - 0.01, 0.1 - 0.006
    assert_allclose(HOLLOW.kz, cowper(b * 0.01 / (h * 0.006), b / h), rtol=1e-12)
    # web alone, flanges alone: the rectangle's 5/6
    assert_allclose(IBeam(height=1.0, width=1.0, web=1e-9, flange=0.01).ky, 5 / 6, rtol=1e-6)
    assert_allclose(IBeam(height=1.0, width=1e-9, web=1e-9, flange=1e-9).kz, 5 / 6, rtol=1e-6)


def test_shear_flow_carries_the_whole_force() -> None:
    # flanges of an I under Vy: parabola with its middle value, 2/3 of it on the mean
    top = {p.name: p for p in WELDED.points}["top"]
    share = 2 * (2 / 3) * top.shear[0][0] * 0.15 * 0.012
    assert_allclose(share, (2 * 0.012 * 0.15**3 / 12) / WELDED.Iz, rtol=1e-13)
    # thin box: the two webs carry Vz, parabola on top of the value at their ends
    thin = Box(0.1, 0.2, web=1e-6)
    at = {p.name: p for p in thin.points}
    end, middle = at["top_left"].shear[1][1], at["left"].shear[1][1]
    assert_allclose(2 * 1e-6 * 0.2 * (end + (middle - end) * 2 / 3), 1.0, rtol=1e-4)
    # under Vy the flow comes down the left web's upper half and up the right one's
    across = {name: at[name].shear[1][0] for name in at if "_" in name}
    end, middle = across["top_right"], at["top"].shear[0][0]
    assert end > 0.0
    assert across == {
        "top_right": end,
        "top_left": -end,
        "bottom_left": end,
        "bottom_right": -end,
    }
    assert_allclose(2 * 1e-6 * 0.1 * (end + (middle - end) * 2 / 3), 1.0, rtol=1e-4)


def test_box_torsion_is_bredt_for_thin_walls() -> None:
    thin = Box(0.1, 0.2, web=1e-6)
    assert_allclose(thin.J, 4 * 0.02**2 * 1e-6 / 0.6, rtol=1e-4)
    for p in thin.points:
        assert_allclose(np.hypot(p.shear[0][2], p.shear[1][2]), 1 / (2 * 0.02 * 1e-6), rtol=1e-4)
    # EN 10210-2:2006: t^3 h/3 + 2 K Ah with K = 2 Ah t/h; here without corner radius
    t, h, Ah = 0.02, 2 * (0.08 + 0.18), 0.08 * 0.18
    assert_allclose(Box(0.1, 0.2, web=t).J, t**3 * h / 3 + 2 * (2 * Ah * t / h) * Ah, rtol=1e-12)
    # EN 10210-2:2006, 200 x 100 x 8 hollow section: It = 1804 cm4 with rounded corners, A 44.8 cm2
    s = Box(0.1, 0.2, web=0.008)
    assert_allclose(s.J * 1e8, 1804, rtol=0.03)
    assert_allclose(s.A * 1e4, 44.8, rtol=0.02)


@pytest.mark.parametrize("section", SECTIONS)
def test_torsion_turns_around_the_centre(section: Section) -> None:
    for p in section.points:
        # moment of the shear of a positive torque about the centre is positive
        assert p.y * p.shear[1][2] - p.z * p.shear[0][2] >= 0.0


BAD = (
    (lambda: Rectangle(0.0, 0.1), ["width is 0 m"]),
    (lambda: Rectangle(-1.0, float("nan")), ["width is -1 m", "height is nan m"]),
    (lambda: Circle(float("inf")), ["diameter is inf m"]),
    (lambda: Tube(0.1, 0.06), ["wall 0.06 m is thicker than the radius 0.05 m"]),
    (lambda: IBeam(height=0.1, width=0.1, web=0.005, flange=0.05), ["fill the whole height"]),
    (lambda: IBeam(height=0.1, width=0.01, web=0.02, flange=0.005), ["wider than the width"]),
    (
        lambda: IBeam(height=0.1, width=0.1, web=0.005, flange=0.005, fillet=-1.0),
        ["fillet is -1 m"],
    ),
    (lambda: Box(0.1, 0.1, web=0.06, flange=0.05), ["webs (2 x 0.06 m)", "flanges (2 x 0.05 m)"]),
    (lambda: GeneralSection(A=1e-3, Iy=1e-6, Iz=1e-6, J=3e-6), ["J = 3e-06 m^4 is above Iy + Iz"]),
    (
        lambda: GeneralSection(A=0.0, Iy=1e-6, Iz=-1e-6, J=1e-6, ky=-1.0),
        ["A is 0", "Iz is -1e-06", "ky is -1"],
    ),
    (
        lambda: GeneralSection(
            A=1e-3,
            Iy=1e-6,
            Iz=1e-6,
            J=1e-6,
            points=(SectionPoint("a", 0, 0), SectionPoint("a", 1, 0)),
        ),
        ["two points are named 'a'"],
    ),
)


@pytest.mark.parametrize(("make", "messages"), BAD)
def test_bad_sections(make: Callable[[], Section], messages: list[str]) -> None:
    with pytest.raises(InputError) as caught:
        make()
    for message in messages:
        assert message in str(caught.value)
    assert len(caught.value.problems) == len(messages)


@pytest.mark.parametrize(
    ("make", "written"),
    [
        (
            # an IPE 200 and its width and height exchanged are sections alike
            lambda: IBeam(0.2, 0.1, 0.0056, 0.0085),  # type: ignore[misc]
            "IBeam(height=..., width=..., web=..., flange=..., fillet=...)",
        ),
        (
            lambda: Box(0.1, 0.2, 0.006, 0.01),  # type: ignore[misc]
            "Box(width, height, web=..., flange=...)",
        ),
        (
            lambda: GeneralSection(1e-3, 1e-6, 2e-6, 1e-6),  # type: ignore[misc]
            "GeneralSection(A=..., Iy=..., Iz=..., J=..., ky=..., kz=..., points=...)",
        ),
    ],
)
def test_dimensions_whose_order_differs_are_given_by_name(make: Any, written: str) -> None:
    with pytest.raises(InputError, match="4 arguments without a name are too many") as error:
        make()
    assert str(error.value).endswith(f"it is called {written}")
