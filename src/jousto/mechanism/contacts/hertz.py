"""Hertz's contact of points and lines: half axes, pressure and approach."""

from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class HertzScale:
    """Contact under a force of 1 N; pressure and half axes grow with ``F^power``.

    Attributes
    ----------
    p0 : float
        Largest pressure, Pa.
    a, b : float
        Half axes along x (rolling) and y, m; of a line b is half its length, which is constant.
    power : float
        1/3 for a point, 1/2 for a line.
    approach : float
        Approach of distant points, m, which grows with ``F^(2/3)``; nan for a line.
    """

    p0: float
    a: float
    b: float
    power: float
    approach: float


def line_scale(modulus: float, radius: float, length: float) -> HertzScale:
    """Return the contact of parallel cylinders: ``p0 = sqrt(F E*/(pi L R))``.

    The half width is ``a = sqrt(4 F R/(pi L E*))`` with ``1/R = 1/R1 + 1/R2`` (K. L. Johnson,
    Contact Mechanics, 1985, section 4.2).
    """
    p0 = math.sqrt(modulus / (math.pi * length * radius))
    a = math.sqrt(4.0 * radius / (math.pi * length * modulus))
    return HertzScale(p0, a, 0.5 * length, 0.5, math.nan)


def point_scale(modulus: float, radii: tuple[float, float]) -> HertzScale:
    """Return the elliptic contact of a point, ``p0 = 3 F/(2 pi a b)``.

    ``radii`` are the relative radii along x and y, ``1/R = 1/R1 + 1/R2``. The axes of the ellipse
    follow from complete elliptic integrals (Johnson 1985, section 4.2).
    """
    A, B = 0.5 / radii[0], 0.5 / radii[1]
    # the long half axis is in the direction of the smaller relative curvature
    k = axis_ratio(max(A, B) / min(A, B))  # short over long
    K, L = _elliptic(k)
    # Johnson 4.26: c^3 = (a b)^(3/2) = 3 F R_e / (4 E) F1^3 written out with the integrals
    m = 1.0 - k * k
    D = (K - L) / m if m > 1e-9 else math.pi / 4.0
    long = (3.0 * D / (2.0 * math.pi * modulus * min(A, B))) ** (1.0 / 3.0)
    short = k * long
    a, b = (short, long) if A >= B else (long, short)
    approach = 3.0 * K / (2.0 * math.pi * modulus * long)
    return HertzScale(3.0 / (2.0 * math.pi * a * b), a, b, 1.0 / 3.0, approach)


def _elliptic(k: float) -> tuple[float, float]:
    """Return the complete elliptic integrals K and E of the modulus sqrt(1 - k^2)."""
    from scipy.special import ellipe, ellipk

    return float(ellipk(1.0 - k * k)), float(ellipe(1.0 - k * k))


def axis_ratio(ratio: float) -> float:
    """Return k = short/long with ``(E/k^2 - K) / (K - E) = ratio`` (Johnson 1985, eq. 4.29)."""
    from scipy.optimize import brentq

    if ratio - 1.0 < 1e-9:
        return 1.0

    def gap(u: float) -> float:
        k = math.exp(u)
        K, L = _elliptic(k)
        return math.log((L / (k * k) - K) / (K - L)) - math.log(ratio)

    return math.exp(float(brentq(gap, -0.9 * math.log(ratio) - 5.0, -1e-9, xtol=1e-15, rtol=1e-14)))
