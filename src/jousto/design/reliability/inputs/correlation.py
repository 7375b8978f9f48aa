"""Correlation of the normal variables behind correlated variables (Nataf)."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import scipy.optimize

from jousto.base.arrays import Array
from jousto.design.reliability.inputs.random import Affine, Exponential, Random, density

ORDER = 40  # number of Hermite polynomials
# grid in standard deviations; the density beyond is below the smallest double
POINTS = np.linspace(-12.0, 12.0, 961)
BOUND = 1.0 - 1e-10


@lru_cache(1)
def _polynomials() -> Array:
    """Return normalised Hermite polynomials times density and step (order, points)."""
    u, step = POINTS, POINTS[1] - POINTS[0]
    h = np.empty((ORDER + 1, len(u)))
    h[0], h[1] = 1.0, u
    for k in range(1, ORDER):
        h[k + 1] = (u * h[k] - math.sqrt(k) * h[k - 1]) / math.sqrt(k + 1)
    return np.asarray(h * density(u) * step)


def series(variable: Random) -> Array:
    """Return coefficients c_k, k = 1 .. ORDER, of the Hermite series.

    ``(x - mean) / deviation = sum c_k He_k(y) / sqrt(k!)``

    The integrals are sums with equal steps, which converge exponentially for such integrands.
    """
    law = variable.law
    if isinstance(law, Affine):
        return np.asarray(np.eye(1, ORDER)[0])
    if isinstance(law, Exponential):
        s = float(law.shape)
        powers = np.array(
            [0.5 * (2 * k * math.log(s) - math.lgamma(k + 1)) for k in range(1, ORDER + 1)]
        )
        return np.asarray(np.exp(powers) / math.sqrt(math.expm1(s * s)))
    x = (law.value(POINTS) - variable.mean) / variable.deviation
    x = np.where(np.isfinite(x), x, 0.0)  # infinite only where the weight is below 1e-30
    return np.asarray(_polynomials()[1:] @ x)


def normal_correlation(a: Random, b: Random, wanted: float) -> tuple[float | None, float, float]:
    """Return the correlation rho_0 of the normal variables for rho, and the possible range.

    ``rho = sum_k c_k(a) c_k(b) rho_0^k`` (Mehler), a function that grows with rho_0.

    Returns
    -------
    rho_0 : float or None
        Correlation of the normal variables; None if it is impossible.
    low, high : float
        Range of the possible correlations of such variables.
    """
    weights = np.concatenate([[0.0], series(a) * series(b)])
    if isinstance(a.law, Exponential) and isinstance(b.law, Exponential):
        s = float(a.law.shape) * float(b.law.shape)
        scale = math.sqrt(math.expm1(float(a.law.shape) ** 2) * math.expm1(float(b.law.shape) ** 2))
        low, high = math.expm1(-s) / scale, math.expm1(s) / scale
        inside = low < wanted < high
        return (math.log1p(wanted * scale) / s if inside else None), low, high

    def rho(rho_0: float) -> float:
        return float(np.polynomial.polynomial.polyval(rho_0, weights))

    low, high = rho(-1.0), rho(1.0)
    if not rho(-BOUND) < wanted < rho(BOUND):
        return None, low, high
    return (
        float(scipy.optimize.brentq(lambda r: rho(r) - wanted, -BOUND, BOUND, xtol=1e-14)),
        low,
        high,
    )
