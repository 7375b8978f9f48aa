"""Hertz contact: closed forms, subsurface stress, rolling, shakedown."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jousto as jo

STEEL = jo.Material(E=210e9, nu=0.3, rho=7850.0)


def line(force: float = 10e3) -> jo.fatigue.HertzContact:
    return jo.fatigue.hertz_line(force, length=0.03, radius=0.1, material=STEEL)


def test_check_value_of_a_wheel_on_a_rail() -> None:
    # p0 = sqrt(F E* / (pi L R)), a = sqrt(4 F R / (pi L E*))
    c = line()
    # half of the last digit
    assert c.p0 == pytest.approx(349.9e6, abs=0.05e6)
    assert c.a == pytest.approx(0.6065e-3, abs=0.5e-7)
    # the pressure carries the force
    assert 0.5 * math.pi * c.a * c.p0 * 0.03 == pytest.approx(10e3)


def test_largest_shear_of_a_line() -> None:
    # Johnson 1985, section 4.2: 0.300 p0 at 0.786 a
    c = line()
    tau, z = c.largest_shear()
    assert tau / c.p0 == pytest.approx(0.3003, abs=1e-4)
    assert z / c.a == pytest.approx(0.7861, abs=2e-4)


def test_line_on_the_axis_and_at_the_surface() -> None:
    # Johnson 1985, eq. 4.45: closed forms at x = 0
    c = line()
    u = np.array([0.1, 0.5, 1.0, 3.0])
    s = c.stress(0.0, u * c.a)
    root = np.sqrt(1.0 + u * u)
    assert s[:, 0] == pytest.approx(-c.p0 * ((1 + 2 * u * u) / root - 2 * u), rel=1e-10)
    assert s[:, 2] == pytest.approx(-c.p0 / root, rel=1e-12)
    x = np.array([-2.0, -0.5, 0.3, 1.4])
    s = c.stress(x * c.a, 0.0, friction=0.2)
    p = c.p0 * np.sqrt(np.maximum(1 - x * x, 0.0))
    assert s[:, 2] == pytest.approx(-p, abs=1e-6)
    assert s[:, 5] == pytest.approx(-0.2 * p, abs=1e-6)
    # tension of 2 mu p0 at the trailing edge (Johnson 1985, eq. 7.5)
    assert c.stress(-c.a, 0.0, friction=0.2)[0] == pytest.approx(2 * 0.2 * c.p0, rel=1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.3, -0.3])
def test_equilibrium_below_a_line(friction: float) -> None:
    # div s = 0 by central differences in the plane
    c = line()
    x, z, h = 0.6 * c.a, 0.7 * c.a, 1e-4 * c.a

    def s(dx: float, dz: float) -> np.ndarray:
        return c.stress(x + dx, z + dz, friction=friction)

    dx, dz = (s(h, 0) - s(-h, 0)) / (2 * h), (s(0, h) - s(0, -h)) / (2 * h)
    size = np.abs(dx).max()
    assert dx[0] + dz[5] == pytest.approx(0.0, abs=1e-6 * size)
    assert dx[5] + dz[2] == pytest.approx(0.0, abs=1e-6 * size)


@pytest.mark.parametrize("friction", [0.0, 0.3, -0.3])
@pytest.mark.parametrize("depth", [0.2, 0.8, 2.0])
def test_a_line_carries_its_load(depth: float, friction: float) -> None:
    # what presses and rubs on the surface goes through every plane below: s33 and s13 integrate to
    # -F and -mu F, as on the surface; what lies beyond the last x is 1e-3 of that
    c = line()
    t = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 4001)[1:-1]
    x = c.a * np.tan(t)
    s = c.stress(x, depth * c.a, friction=friction)
    width = 2.0 * c.b
    pressed, rubbed = (np.trapezoid(s[:, k] / np.cos(t) ** 2, t) * c.a * width for k in (2, 5))
    assert pressed == pytest.approx(-c.force, rel=2e-3)
    assert rubbed == pytest.approx(-friction * c.force, abs=2e-3 * c.force)


def test_symmetry_below_a_point() -> None:
    # symmetric in x without friction; what friction adds is antisymmetric
    c = jo.fatigue.hertz_point(900.0, radii=(0.02, 0.01), material=STEEL)
    z = 0.8 * c.a
    right, left = c.stress(0.5 * c.a, z), c.stress(-0.5 * c.a, z)
    assert right[[0, 1, 2]] == pytest.approx(left[[0, 1, 2]], rel=1e-10)
    assert right[5] == pytest.approx(-left[5], rel=1e-10)
    both = sum(c.stress(x * c.a, z, friction=0.3) for x in (-0.5, 0.5))
    assert both[[0, 1, 2]] == pytest.approx(2 * right[[0, 1, 2]], rel=1e-8)


@pytest.mark.parametrize("friction", [0.3, -0.3])
def test_a_ball_that_slides(friction: float) -> None:
    c = jo.fatigue.hertz_point(500.0, radii=(0.01, 0.01), material=STEEL)
    # Cerruti below the middle (Johnson 1985, eq. 3.76): dt = -3 z x^2 q dA / (2 pi rho^5), over the
    # traction q0 sqrt(1 - r^2/a^2) along +x
    u = np.array([0.1, 0.5, 1.0, 2.0])
    exact = 1.0 - 1.5 * u * np.arctan(1 / u) + 0.5 * u * u / (1 + u * u)
    s = c.stress(0.0, u * c.a, friction=friction)
    assert s[:, 5] == pytest.approx(-friction * c.p0 * exact, abs=1e-6 * c.p0)
    # Boussinesq and Cerruti: s11 + s22 + s33 = -(1 + nu) (P z + Q x) / (pi rho^3)
    r, weight = np.polynomial.legendre.leggauss(60)
    r, weight = 0.5 * c.a * (r + 1.0), 0.5 * c.a * weight
    theta = 2.0 * np.pi * (np.arange(200) + 0.5) / 200
    force = np.outer(c.p0 * np.sqrt(1 - (r / c.a) ** 2) * r * weight, np.full(200, 2 * np.pi / 200))
    for x in (-0.7 * c.a, 0.4 * c.a):
        z = 0.6 * c.a
        d = x - np.outer(r, np.cos(theta))
        rho = np.sqrt(d**2 + np.outer(r, np.sin(theta)) ** 2 + z**2)
        trace = -1.3 / np.pi * np.sum(force * (z + friction * d) / rho**3)
        found = c.stress(x, z, friction=friction)[:3].sum()
        assert found == pytest.approx(trace, abs=2e-5 * c.p0)


@pytest.mark.parametrize("friction", [0.3, -0.3])
def test_a_long_ellipse_slides_as_a_line(friction: float) -> None:
    # of the same pressure and half width; ahead of the contact and behind it
    c = jo.fatigue.hertz_point(100.0, radii=(0.01, 1.0), material=STEEL)
    same = jo.fatigue.HertzContact("line", 1.0, c.p0, c.a, 1.0, math.nan, c.nu)
    x, z = np.array([-0.8, -0.3, 0.3, 0.8]) * c.a, 0.5 * c.a
    rubbed, there = (one.stress(x, z, friction=friction) - one.stress(x, z) for one in (c, same))
    # ends that are missing, and the pressure that falls towards them: of second order in a/b
    ends = 3.0 * abs(friction) * c.p0 * (c.a / c.b) ** 2
    assert np.abs(there[:, [0, 2, 5]]).max(axis=0).min() > 25.0 * ends
    assert rubbed[:, [0, 2, 5]] == pytest.approx(there[:, [0, 2, 5]], abs=ends)


def test_ball_on_a_flat() -> None:
    # Johnson 1985, eqs. 4.22-4.24 and 3.45
    F, R = 500.0, 0.01
    c = jo.fatigue.hertz_point(F, radii=(R, R), material=STEEL)
    E = 210e9 / (2 * (1 - 0.09))
    assert c.a == pytest.approx((3 * F * R / (4 * E)) ** (1 / 3), rel=1e-9)
    assert c.b == pytest.approx(c.a, rel=1e-9)
    assert c.approach == pytest.approx(c.a**2 / R, rel=1e-9)
    assert c.p0 == pytest.approx(3 * F / (2 * math.pi * c.a**2), rel=1e-9)
    u = np.array([0.1, 0.481, 1.0, 2.0])
    s = c.stress(0.0, u * c.a)
    radial = -1.3 * (1 - u * np.arctan(1 / u)) + 0.5 / (1 + u * u)
    assert s[:, 0] == pytest.approx(c.p0 * radial, rel=1e-6, abs=1e-6 * c.p0)
    assert s[:, 1] == pytest.approx(c.p0 * radial, rel=1e-6, abs=1e-6 * c.p0)
    assert s[:, 2] == pytest.approx(-c.p0 / (1 + u * u), rel=1e-6)
    tau, z = c.largest_shear()
    assert tau / c.p0 == pytest.approx(0.310, abs=5e-4)
    assert z / c.a == pytest.approx(0.481, abs=1e-3)


def test_long_ellipse_is_a_line() -> None:
    # the line's stress below the middle, with the same pressure and half width
    c = jo.fatigue.hertz_point(100.0, radii=(0.01, 1.0), material=STEEL)
    assert c.b > 15 * c.a
    u = np.array([0.3, 0.786])
    s = c.stress(0.0, u * c.a) / c.p0
    root = np.sqrt(1 + u * u)
    # the ends that are missing press (1 - 2 nu) a/b less along x, of second order along z
    ends = 1.1 * (1 - 2 * 0.3) * c.a / c.b
    assert s[:, 0] == pytest.approx(-((1 + 2 * u * u) / root - 2 * u), abs=ends)
    assert s[:, 2] == pytest.approx(-1 / root, abs=2e-3)


def test_ellipse_of_the_literature() -> None:
    # Johnson 1985, section 4.2: a mild ellipse is nearly (B/A)^(2/3), mean radius formula near 1
    c = jo.fatigue.hertz_point(1000.0, radii=(0.02, 0.03), material=STEEL)
    assert c.b / c.a == pytest.approx((0.03 / 0.02) ** (2 / 3), rel=0.01)
    # crossed cylinders of equal radius are a ball on a flat
    cross = jo.fatigue.hertz_point(
        1000.0, radii=(0.02, math.inf), other=(math.inf, 0.02), material=STEEL
    )
    ball = jo.fatigue.hertz_point(1000.0, radii=(0.02, 0.02), material=STEEL)
    assert (cross.a, cross.p0) == pytest.approx((ball.a, ball.p0), rel=1e-12)
    # turning both bodies by 90 degrees swaps the axes
    turned = jo.fatigue.hertz_point(1000.0, radii=(0.03, 0.02), material=STEEL)
    assert (turned.a, turned.b, turned.p0) == pytest.approx((c.b, c.a, c.p0), rel=1e-12)


def test_gap_closes_over_the_ellipse() -> None:
    # displacement of the pressure by quadrature against approach - A x^2 - B y^2
    c = jo.fatigue.hertz_point(1000.0, radii=(0.02, 0.05), material=STEEL)
    E = 210e9 / (2 * (1 - 0.09))

    def lift(x: float, y: float) -> float:
        # integrate in polar coordinates about the point: the root 1/r goes
        theta = (np.arange(400) + 0.5) * np.pi / 200
        co, si = np.cos(theta), np.sin(theta)
        qa = (co / c.a) ** 2 + (si / c.b) ** 2
        qb = x * co / c.a**2 + y * si / c.b**2
        qc = 1 - (x / c.a) ** 2 - (y / c.b) ** 2
        far = (-qb + np.sqrt(qb * qb + qa * qc)) / qa
        u, w = np.polynomial.legendre.leggauss(60)
        f = 0.5 * np.pi * (u + 1) / 2
        r = far[:, None] * np.sin(f)
        p = np.sqrt(np.maximum(qc - 2 * qb[:, None] * r - qa[:, None] * r * r, 0.0))
        inner = (p * far[:, None] * np.cos(f)) @ w * 0.25 * np.pi
        return float(inner.sum() * np.pi / 200 * c.p0 / (np.pi * E))

    for x, y in ((0.0, 0.0), (0.5, 0.0), (0.0, 0.5), (0.3, 0.4)):
        X, Y = x * c.a, y * c.b
        want = c.approach - X * X / 0.04 - Y * Y / 0.1
        assert lift(X, Y) == pytest.approx(want, rel=2e-4)


def test_shakedown() -> None:
    # Johnson 1985, section 9.2: p0 = 4 k in free rolling; 1/mu where the surface decides
    assert jo.fatigue.shakedown_limit() == pytest.approx(4.0, abs=1e-6)
    assert jo.fatigue.shakedown_limit(0.6) == pytest.approx(1 / 0.6)
    limits = [jo.fatigue.shakedown_limit(mu) for mu in (0.0, 0.1, 0.2, 0.3, 0.4)]
    assert all(a > b for a, b in zip(limits, limits[1:], strict=False))


def test_rolling_history() -> None:
    # orthogonal shear +-0.25 p0 at x = -+0.866 a, z = 0.5 a (Johnson 1985, section 9.2)
    c = line()
    roll = jo.fatigue.rolling_contact(c, [0.5 * c.a], samples=2001)
    shear = roll.stress[0, :, 5]
    assert shear.max() == pytest.approx(0.25 * c.p0, rel=1e-4)
    assert shear.min() == pytest.approx(-0.25 * c.p0, rel=1e-4)
    assert abs(roll.x[shear.argmax()]) == pytest.approx(0.866 * c.a, rel=1e-2)
    # what is far away is not stressed
    far = jo.fatigue.rolling_contact(c, reach=200.0)
    assert np.abs(far.stress[:, 0]).max() < 0.01 * c.p0


def test_mistakes() -> None:
    with pytest.raises(jo.InputError) as told:
        jo.fatigue.hertz_line(-1.0, length=0.03, radius=0.0, material=STEEL)
    assert len(told.value.problems) == 2
    with pytest.raises(jo.InputError, match="have no line contact"):
        jo.fatigue.hertz_line(1.0, length=0.03, radius=0.1, other=-0.09, material=STEEL)
    with pytest.raises(jo.InputError, match="hertz_line"):
        jo.fatigue.hertz_point(1.0, radii=(0.1, math.inf), material=STEEL)
    with pytest.warns(jo.JoustoWarning, match="mm"):
        jo.fatigue.hertz_line(1e4, length=30.0, radius=1e4, material=STEEL)
    with pytest.warns(jo.JoustoWarning, match="small elastic"):
        jo.fatigue.hertz_line(1e9, length=0.03, radius=0.1, material=STEEL)
    with pytest.raises(jo.InputError, match="depth"):
        jo.fatigue.hertz_point(1.0, radii=(0.1, 0.1), material=STEEL).stress(0.0, 0.0)
    with pytest.raises(jo.InputError, match="negative"):
        line().stress(0.0, -1.0)
    with pytest.raises(jo.InputError) as told:
        jo.fatigue.rolling_contact(line(), friction=-1.0, reach=0.5, samples=3)
    assert len(told.value.problems) == 3
