"""Tests of residuals: memory, and what is left to explain."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described

ORDERS = 40
"""Largest order of the autoregression of residuals."""
FEWEST = 8
"""Samples that a test of memory needs."""
LAGS = 20
"""Lags of the test of Ljung and Box."""


def _sums(x: Array, lags: int) -> Array:
    """Return ``sum x_i x_(i+k) / n`` for k = 0 .. lags."""
    n = len(x)
    size = 1 << int(np.ceil(np.log2(2 * n)))
    spectrum = np.abs(np.fft.rfft(x, size)) ** 2
    return np.asarray(np.fft.irfft(spectrum, size)[: lags + 1] / n)


def autoregression(x: Array) -> tuple[Array, float]:
    """Return coefficients (k,) and variance of the noise of an autoregression of residuals.

    ``x_i = sum a_j x_(i-j) + e_i``; Levinson and Durbin's recursion, the order k by Schwarz's
    criterion (Ann. Statist. 6, 1978).

    Parameters
    ----------
    x : (n,) array
        Residuals; their mean is not removed, since the model explains it.
    """
    n = len(x)
    c = _sums(x, min(ORDERS, max((n - 1) // 4, 0)))
    a, variance = np.zeros(0), float(c[0])
    best, least = (a, variance), n * np.log(max(variance, 1e-300))
    for k in range(1, len(c)):
        if variance <= 1e-12 * c[0]:
            break
        reflection = (c[k] - a @ c[k - 1 : 0 : -1]) / variance if k > 1 else c[1] / variance
        a = np.append(a - reflection * a[::-1], reflection)
        variance *= 1.0 - reflection**2
        criterion = n * np.log(max(variance, 1e-300)) + k * np.log(n)
        if criterion < least:
            best, least = (a, variance), criterion
    return best


def autocovariance(coefficients: Array, variance: float, n: int) -> Array:
    """Return the covariances (n,) at lags 0 .. n-1 of an autoregression.

    They are the sums over the response to one disturbance, cut off where it has decayed.
    """
    from scipy.signal import lfilter

    k = len(coefficients)
    if not k:
        found = np.zeros(n)
        found[0] = variance
        return found
    roots = np.roots(np.concatenate([[1.0], -coefficients]))
    slowest = min(float(np.abs(roots).max()), 1.0 - 1e-6)
    length = int(min(np.ceil(np.log(1e-10) / np.log(slowest)) + k, 1_000_000))
    pulse = np.zeros(length)
    pulse[0] = 1.0
    response = lfilter([1.0], np.concatenate([[1.0], -coefficients]), pulse)
    found = np.zeros(n)
    lags = min(n, length)
    found[:lags] = variance * length * _sums(response, lags - 1)
    return found


@described
@dataclass(frozen=True, eq=False)
class Whiteness:
    """Test of the residuals of a comparison.

    Attributes
    ----------
    rms : float
        Root mean square of the residuals, in deviations of the noise: 1 for a right model.
    explained : float
        Share of the variance of the measurement that the model explains.
    Q : float
        Statistic of Ljung and Box (Biometrika 65, 1978) over 20 lags.
    p : float
        Probability of a larger Q for white residuals.
    outside : float
        Share of the lags with a correlation beyond 1.96/sqrt(n); 0.05 for white residuals.

    All but `rms` are nan for fewer than 8 samples.
    """

    rms: float
    explained: float
    Q: float
    p: float
    outside: float

    def _facts(self) -> str:
        return f"rms {self.rms:.3g} sd, Ljung-Box p {self.p:.2g}"


def whiteness(r: Array, y: Array, sd: Array, unknowns: float) -> Whiteness:
    """Return the tests of residuals.

    Parameters
    ----------
    r : (n,) array
        Weighted residuals.
    y, sd : (n,) array
        Measured values and deviations of their noise.
    unknowns : float
        Number of unknowns that these samples have determined.
    """
    from scipy.stats import chi2

    n, nothing = len(r), float("nan")
    c = _sums(r, min(LAGS, n - 1))
    if n < FEWEST:
        return Whiteness(float(np.sqrt(c[0])), nothing, nothing, nothing, nothing)
    rho = c[1:] / c[0] if c[0] > 0.0 else np.zeros(len(c) - 1)
    lags = np.arange(1, len(rho) + 1)
    Q = float(n * (n + 2) * np.sum(rho**2 / (n - lags)))
    spread = float(np.var(y))
    left = float(np.mean((r * sd) ** 2))
    return Whiteness(
        float(np.sqrt(n * c[0] / max(n - unknowns, 1.0))),
        1.0 - left / spread if spread > 0.0 else float("nan"),
        Q,
        float(chi2.sf(Q, len(rho))),
        float(np.mean(np.abs(rho) > 1.96 / np.sqrt(n))),
    )
