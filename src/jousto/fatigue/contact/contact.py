"""Hertzian contact of lines and points: pressure, stress below the surface, rolling."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.base.object_repr import described
from jousto.materials.material import Material
from jousto.mechanism.contacts.hertz import line_scale, point_scale

SHALLOW = 0.04
"""Smallest depth for the stress of a point contact, over the short half axis."""


@dataclass(frozen=True)
class HertzContact:
    """Hertzian contact of two elastic bodies; x in the rolling direction, z into the body.

    Attributes
    ----------
    kind : str
        ``"line"`` or ``"point"``.
    force : float
        Normal force, N.
    p0 : float
        Largest pressure, Pa.
    a : float
        Half width of the contact along x, m.
    b : float
        Half width along y of a point contact, m; half the length of a line contact.
    approach : float
        Approach of distant points of the bodies, m; nan for a line contact, where it depends on
        the shape of the bodies.
    nu : float
        Poisson's ratio of the body whose stress is computed.

    Notes
    -----
    K. L. Johnson, *Contact Mechanics*, Cambridge 1985, chapter 4.
    """

    kind: str
    force: float
    p0: float
    a: float
    b: float
    approach: float
    nu: float

    def __str__(self) -> str:
        size = (
            f"a = {1e3 * self.a:.4g} mm, length {2e3 * self.b:.4g} mm"
            if self.kind == "line"
            else f"a = {1e3 * self.a:.4g} mm, b = {1e3 * self.b:.4g} mm"
        )
        return f"{self.kind} contact, {self.force:g} N: p0 = {1e-6 * self.p0:.4g} MPa, {size}"

    def stress(self, x: ArrayLike, z: ArrayLike, *, friction: float = 0.0) -> Array:
        """Return the stress (..., 6), Pa, at points below the surface in the plane y = 0.

        Parameters
        ----------
        x, z : array_like
            Coordinate in the rolling direction and depth below the surface, m; broadcast together.
        friction : float
            Ratio of tangential to normal traction in the whole contact (full sliding), along +x.

        Returns
        -------
        array (..., 6)
            ``[s11 s22 s33 s12 s23 s13]`` with 1 = x, 2 = y, 3 = z.

        Raises
        ------
        InputError
            For a negative depth, or a depth of a point contact that is too small.
        """
        X, Z = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(z, dtype=float))
        if Z.size and not (np.all(np.isfinite(X)) and np.all(np.isfinite(Z)) and Z.min() >= 0.0):
            raise InputError(Problem("contact", "depths z must be finite and not negative"))
        if self.kind == "line":
            return _line_stress(X, Z, self.a, self.p0, self.nu, friction)
        return _point_stress(X, Z, self, friction)

    def largest_shear(self) -> tuple[float, float]:
        """Return the largest shear stress below the centre, Pa, and its depth, m."""
        from scipy.optimize import minimize_scalar

        def shear(u: float) -> float:
            s = self._axis(math.exp(u))
            return -0.5 * (max(s) - min(s))

        top = self.a if self.kind == "line" else max(self.a, self.b)
        low = self.a if self.kind == "line" else min(self.a, self.b)
        grid = np.log(np.geomspace(0.1 * low, 2.0 * top, 40))
        best = int(np.argmin([shear(u) for u in grid]))
        around = (grid[max(best - 1, 0)], grid[min(best + 1, len(grid) - 1)])
        found = minimize_scalar(shear, bounds=around, method="bounded", options={"xatol": 1e-7})
        return -float(found.fun), math.exp(float(found.x))

    def _axis(self, z: float) -> tuple[float, float, float]:
        """Return the principal stresses, Pa, on the axis below the centre."""
        if self.kind == "line":
            s = _line_stress(np.zeros(1), np.full(1, z), self.a, self.p0, self.nu, 0.0)[0]
        else:
            s = _point_stress(np.zeros(1), np.full(1, z), self, 0.0)[0]
        return float(s[0]), float(s[1]), float(s[2])


def _combined(materials: tuple[Material, Material]) -> float:
    """Return E*, Pa, from ``1/E* = sum (1 - nu^2)/E``."""
    return 1.0 / sum((1.0 - m.nu**2) / m.E for m in materials)


def _two(material: Material | tuple[Material, Material]) -> tuple[Material, Material]:
    return (material, material) if isinstance(material, Material) else material


def _checks(force: float, radii: dict[str, float]) -> None:
    problems = Problems()
    problems.positive("contact", "force", force, "N")
    for name, R in radii.items():
        if R == 0.0 or math.isnan(R):
            problems.add("contact", f"{name} is {R} m, must be a radius (inf for flat)")
        elif abs(R) > 1e3 and not math.isinf(R):
            warn("contact", f"{name} = {R:g} m; was it given in mm?")
    problems.raise_if_any()


@explained
def hertz_line(
    force: float,
    *,
    length: float,
    radius: float,
    other: float = math.inf,
    material: Material | tuple[Material, Material],
) -> HertzContact:
    """Return the contact of two parallel cylinders, such as a cylindrical wheel on a flat rail.

    ``p0 = sqrt(F E* / (pi L R))``, ``a = sqrt(4 F R / (pi L E*))`` with ``1/R = 1/R1 + 1/R2`` and
    ``1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2``.

    Parameters
    ----------
    force : float
        Normal force over the whole length, N.
    length : float
        Length of the line, m.
    radius, other : float
        Radii of both cylinders, m; inf for a plane, negative for a concave surface.
    material : Material or two of them
        Material of both bodies.

    Raises
    ------
    InputError
        For a force, length or radii without contact.

    Examples
    --------
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> c = hertz_line(10e3, length=0.03, radius=0.1, material=steel)
    >>> print(c)
    line contact, 10000 N: p0 = 349.9 MPa, a = 0.6065 mm, length 30 mm
    """
    _checks(force, {"radius": radius, "other": other})
    problems = Problems()
    problems.positive("contact", "length", length, "m")
    curvature = 1.0 / radius + 1.0 / other
    if curvature <= 0.0:
        problems.add(
            "contact",
            f"radii {radius:g} and {other:g} m have no line contact; a concave radius must be "
            "larger than the convex one",
        )
    problems.raise_if_any()
    both = _two(material)
    one = line_scale(_combined(both), 1.0 / curvature, length)
    p0, a = one.p0 * math.sqrt(force), one.a * math.sqrt(force)
    _within(p0, both)
    return HertzContact("line", force, p0, a, 0.5 * length, math.nan, both[0].nu)


@explained
def hertz_point(
    force: float,
    *,
    radii: tuple[float, float],
    other: tuple[float, float] = (math.inf, math.inf),
    material: Material | tuple[Material, Material],
) -> HertzContact:
    """Return the elliptic point contact of two doubly curved bodies.

    The principal directions of both bodies are x (rolling) and y: a wheel of tread radius r on a
    rail of head radius h is ``radii=(R, inf or r), other=(inf, h)``. The axes of the ellipse follow
    from complete elliptic integrals (Johnson 1985, section 4.2), ``p0 = 3 F / (2 pi a b)``.

    Parameters
    ----------
    force : float
        Normal force, N.
    radii, other : (x, y)
        Radii of curvature of both bodies in the planes xz and yz, m; inf for flat, negative for
        concave.
    material : Material or two of them
        Material of both bodies.

    Raises
    ------
    InputError
        For radii without a point contact.

    Examples
    --------
    >>> steel = Material(E=210e9, nu=0.3, rho=7850.0)
    >>> ball = hertz_point(100.0, radii=(0.01, 0.01), material=steel)
    >>> tau, z = ball.largest_shear()
    >>> round(tau / ball.p0, 3), round(z / ball.a, 3)
    (0.31, 0.481)
    """
    names = {"radii[0]": radii[0], "radii[1]": radii[1]}
    _checks(force, {**names, "other[0]": other[0], "other[1]": other[1]})
    A = 0.5 * (1.0 / radii[0] + 1.0 / other[0])
    B = 0.5 * (1.0 / radii[1] + 1.0 / other[1])
    if A <= 0.0 or B <= 0.0:
        raise InputError(
            Problem(
                "contact",
                f"relative curvatures {2 * A:g} and {2 * B:g} 1/m must be positive; bodies that "
                "are flat in one direction touch along a line: hertz_line",
            )
        )
    both = _two(material)
    one = point_scale(_combined(both), (0.5 / A, 0.5 / B))
    root = force ** (1.0 / 3.0)
    p0, a, b, approach = one.p0 * root, one.a * root, one.b * root, one.approach * root * root
    _within(p0, both)
    return HertzContact("point", force, p0, a, b, approach, both[0].nu)


def _within(p0: float, materials: tuple[Material, Material]) -> None:
    stiff = min(m.E for m in materials)
    if p0 > 0.05 * stiff:
        warn(
            "contact",
            f"p0 = {1e-6 * p0:.4g} MPa is {p0 / stiff:.2g} of Young's modulus; "
            "Hertz's theory is for small elastic contacts",
        )


def _line_stress(x: Array, z: Array, a: float, p0: float, nu: float, mu: float) -> Array:
    """Return the stress (..., 6) of a line contact: Flamant's solution integrated over the contact.

    The normal traction is ``p = p0 sqrt(1 - s^2/a^2)``, the tangential one ``mu p``. With
    ``F(w) = int p(s)/(w - s) ds = (pi p0/a) (w - sqrt(w^2 - a^2))``, ``w = x + i z``, all integrals
    of Johnson 1985, eq. 2.23, are real and imaginary parts of F and z F'.
    """
    w = x + 1j * z
    root = np.sqrt(w - a) * np.sqrt(w + a)
    F = math.pi * p0 / a * (w - root)
    # z F' is 0 at the surface
    zF = math.pi * p0 / a * z * (1.0 - w / np.where(root == 0.0, 1.0, root))
    zF = np.where(z > 0.0, zF, 0.0)
    sx = (F.imag + zF.real) / math.pi
    sz = (F.imag - zF.real) / math.pi
    txz = -zF.imag / math.pi
    if mu:
        sx, sz, txz = (
            sx - 2.0 * mu / math.pi * (F.real - 0.5 * zF.imag),
            sz + mu * txz,
            txz + mu * sx,
        )
    s = np.zeros((*x.shape, 6))
    s[..., 0], s[..., 1], s[..., 2], s[..., 5] = sx, nu * (sx + sz), sz, txz
    return s


def _point_stress(x: Array, z: Array, c: HertzContact, mu: float) -> Array:
    """Return the stress (..., 6) of a point contact at y = 0.

    The solutions of Boussinesq and Cerruti for point loads are summed over the contact ellipse.
    """
    out = np.zeros((*x.shape, 6))
    if not x.size:
        return out
    short = min(c.a, c.b)
    if z.min() < SHALLOW * short:
        raise InputError(
            Problem(
                "contact",
                f"depth {z.min():g} m of a point contact is less than {SHALLOW:g} times its short "
                f"half axis of {short:g} m, too little for the numerical integration of the stress",
            )
        )
    flat, X, Z = out.reshape(-1, 6), x.ravel(), z.ravel()
    for depth in np.unique(Z):
        rows = np.flatnonzero(Z == depth)
        points = _ellipse_rule(c, float(depth))
        # number of points evaluated at a time, so that the distances fit into the cache
        step = max(1, 40_000 // len(points[0]))
        for i in range(0, len(rows), step):
            chosen = rows[i : i + step]
            flat[chosen] = _superpose(X[chosen, None], float(depth), points, c.nu, mu)
    out /= 2.0 * math.pi
    return out


def _ellipse_rule(c: HertzContact, z: float) -> tuple[Array, Array, Array]:
    """Return points x, y of half of the ellipse, y > 0, and twice the forces on them, N."""
    fine = int(np.clip(8.0 * max(c.a, c.b) / z, 24, 400))
    # substitution r = sin(f), p = p0 cos(f), which makes the integrand smooth
    u, weight = np.polynomial.legendre.leggauss(fine)
    f = 0.25 * math.pi * (u + 1.0)
    load = 0.25 * math.pi * weight * c.p0 * np.cos(f) ** 2 * np.sin(f) * c.a * c.b
    theta = (np.arange(2 * fine) + 0.5) * math.pi / (2 * fine)
    S = (c.a * np.sin(f)[:, None] * np.cos(theta)).ravel()
    T = (c.b * np.sin(f)[:, None] * np.sin(theta)).ravel()
    return S, T, np.repeat(load * math.pi / fine, 2 * fine)


def _superpose(
    x: Array, z: float, points: tuple[Array, Array, Array], nu: float, mu: float
) -> Array:
    """Return 2 pi times the stress (k, 6) at points x (k, 1) of the depth z."""
    S, T, P = points
    g = 1.0 - 2.0 * nu
    d, y2 = x - S, T * T
    d2 = d * d
    rho2 = d2 + (y2 + z * z)
    rho = np.sqrt(rho2)
    h2 = (rho + z) ** 2
    r3 = rho2 * rho
    r5 = r3 * rho2
    even = g * (2.0 * rho + z) / (r3 * h2) - 3.0 * z / r5
    rest = g * (z / r3 - 1.0 / (rho * (rho + z)))
    out = np.zeros((len(x), 6))
    out[:, 0] = (d2 * even + rest) @ P
    out[:, 1] = (y2 * even + rest) @ P
    out[:, 2] = -3.0 * z**3 * ((1.0 / r5) @ P)
    out[:, 5] = -3.0 * z * z * ((d / r5) @ P)
    if mu:
        odd = g * (1.0 / (r3 * h2) + 2.0 / (rho2 * h2 * (rho + z))) - 3.0 / r5
        flat = g / (rho * h2)
        q = g / r3
        out[:, 0] += mu * ((d * (q - 3.0 * flat + d2 * odd)) @ P)
        out[:, 1] += mu * ((d * (q - flat + y2 * odd)) @ P)
        out[:, 2] += -3.0 * z * z * mu * ((d / r5) @ P)
        out[:, 5] += -3.0 * z * mu * ((d2 / r5) @ P)
    return out


@described
@dataclass(frozen=True, eq=False)
class RollingContact:
    """Stress history of the material below a rolling contact.

    Attributes
    ----------
    contact : HertzContact
    x : (nt,) array
        Coordinate of the material point relative to the contact, m, descending over one pass.
    depth : (nd,) array
        Depth below the surface, m.
    stress : (nd, nt, 6) array
        ``[s11 s22 s33 s12 s23 s13]``, Pa; 1 = rolling direction, 2 = transverse, 3 = into the body.
    friction : float
        Ratio of tangential to normal traction.
    """

    contact: HertzContact
    x: Array
    depth: Array
    stress: Array
    friction: float


@explained
def rolling_contact(
    contact: HertzContact,
    depths: ArrayLike | None = None,
    *,
    friction: float = 0.0,
    reach: float = 5.0,
    samples: int = 201,
) -> RollingContact:
    """Return the stress history at given depths in one pass of the contact.

    Parameters
    ----------
    contact : HertzContact
        From `hertz_line` or `hertz_point`.
    depths : (nd,) array_like, optional
        Depths, m; None takes 24 depths from 0.1 to 2.4 times the half width in the rolling
        direction (of the shorter axis, for a point contact).
    friction : float
        Ratio of tangential to normal traction in full sliding, which is conservative for partial
        slip.
    reach : float
        Range of the pass to both sides of the contact, half widths.
    samples : int
        Number of positions in the pass.

    Raises
    ------
    InputError
        For depths that are not below the surface, or settings out of range.
    """
    problems = Problems()
    problems.number("rolling contact", "friction", friction, "", "in [0, 2]", lambda f: 0 <= f <= 2)
    problems.number("rolling contact", "reach", reach, "", "above 1", lambda r: r > 1.0)
    if samples < 11:
        problems.add("rolling contact", f"samples is {samples!r}, must be 11 or more")
    problems.raise_if_any()
    size = contact.a if contact.kind == "line" else min(contact.a, contact.b)
    z = size * np.linspace(0.1, 2.4, 24) if depths is None else np.atleast_1d(np.asarray(depths))
    x = np.linspace(reach, -reach, samples) * contact.a
    return RollingContact(
        contact, x, z, contact.stress(x[None, :], z[:, None], friction=friction), friction
    )


def shakedown_limit(friction: float = 0.0) -> float:
    """Return the shakedown limit p0/k of a rolling line contact, with the shear yield stress k.

    Residual stresses in equilibrium can balance every stress component of the half-plane except
    the orthogonal shear s13 (Johnson 1985, section 9.2): at the limit the largest s13 is k. The
    limit is 4.00 without friction, and 1/friction if the largest s13 is at the surface.

    Parameters
    ----------
    friction : float
        Ratio of tangential to normal traction, full sliding.

    Examples
    --------
    >>> round(shakedown_limit(), 3), round(shakedown_limit(0.5), 3)
    (4.0, 2.0)
    """
    from scipy.optimize import minimize

    problems = Problems()
    problems.number("shakedown", "friction", friction, "", "in [0, 2]", lambda f: 0 <= f <= 2)
    problems.raise_if_any()

    def shear(u: Array) -> float:
        s = _line_stress(u[:1], np.abs(u[1:]), 1.0, 1.0, 0.3, friction)
        return -abs(float(s[0, 5]))

    x, z = np.meshgrid(np.linspace(-2.0, 2.0, 161), np.linspace(0.0, 2.0, 81))
    s = np.abs(_line_stress(x, z, 1.0, 1.0, 0.3, friction)[..., 5])
    best = np.unravel_index(int(np.argmax(s)), s.shape)
    largest = float(s[best])
    if z[best] > 0.0:
        found = minimize(
            shear, [x[best], z[best]], method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12}
        )
        largest = max(largest, -float(found.fun))
    return 1.0 / max(largest, friction)
