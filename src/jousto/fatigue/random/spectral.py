"""Fatigue from spectra: random vibration of a part, spectral moments, Dirlik and others."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, suggest

Method = Literal["dirlik", "narrow-band", "tovo-benasciutti", "wirsching-light"]
METHODS = ("dirlik", "narrow-band", "tovo-benasciutti", "wirsching-light")
POINTS = 6001  # number of amplitudes of the integral of the damage
# largest amplitude in standard deviations; only Dirlik's exponential term extends further
REACH = 12.0


@explained
def spectral_moments(
    frequency: ArrayLike, psd: ArrayLike, orders: Sequence[int] = (0, 1, 2, 4)
) -> Array:
    """Return the moments ``m_n = int f^n S(f) df`` of a one-sided spectral density.

    The density is linear between its points, for which the integrals are exact.

    Parameters
    ----------
    frequency : (nf,) array_like
        Frequencies, Hz, ascending.
    psd : (..., nf) array_like
        One-sided density, unit squared per Hz.
    orders : sequence of int
        Orders n of the moments.

    Returns
    -------
    array (..., len(orders))
        Moments, unit squared times Hz^n.

    Raises
    ------
    InputError
        For frequencies that do not ascend, or densities that are negative or not finite.

    Examples
    --------
    >>> spectral_moments([10.0, 20.0], [2.0, 2.0], (0, 1, 2))  # a box
    array([  20.        ,  300.        , 4666.66666667])
    """
    f, S = _spectrum(frequency, psd)
    out = []
    f0, f1 = f[:-1], f[1:]
    slope = (S[..., 1:] - S[..., :-1]) / (f1 - f0)
    level = S[..., :-1] - slope * f0
    for n in orders:
        first = (f1 ** (n + 1) - f0 ** (n + 1)) / (n + 1)
        second = (f1 ** (n + 2) - f0 ** (n + 2)) / (n + 2)
        out.append(np.sum(level * first + slope * second, axis=-1))
    # lower bound 0, since terms that nearly cancel may give a negative moment by round-off
    return np.asarray(np.maximum(np.stack(out, axis=-1), 0.0))


def _spectrum(frequency: ArrayLike, psd: ArrayLike) -> tuple[Array, Array]:
    problems = Problems()
    f = problems.array("spectrum", "frequency", frequency, (None,))
    S = np.asarray(psd, dtype=np.float64)
    if f is not None:
        if len(f) < 2:
            problems.add("spectrum", "needs two frequencies or more")
        elif f[0] < 0.0 or np.any(np.diff(f) <= 0.0):
            problems.add("spectrum", "frequencies must ascend from zero or more, each once")
        if S.shape[-1:] != f.shape:
            problems.add(
                "spectrum", f"psd has {S.shape[-1:]} values for {f.size} frequencies, must be equal"
            )
    if not np.all(np.isfinite(S)) or (S.size and S.min() < 0.0):
        problems.add("spectrum", "spectral densities must be finite and not negative")
    problems.raise_if_any()
    assert f is not None
    return f, S


@dataclass(frozen=True)
class SpectralDamage:
    """Damage per second of a stationary Gaussian stress.

    Attributes
    ----------
    method : str
    rms : float
        Standard deviation of the stress, Pa.
    crossings : float
        Rate of upward crossings of the mean, 1/s.
    peaks : float
        Rate of maxima, 1/s.
    irregularity : float
        ``crossings / peaks``; 1 for a narrow band.
    damage : float
        Miner's sum per second, 1/s.
    """

    method: str
    rms: float
    crossings: float
    peaks: float
    irregularity: float
    damage: float

    @property
    def life(self) -> float:
        """Time to failure, s."""
        return math.inf if self.damage == 0.0 else 1.0 / self.damage

    def __str__(self) -> str:
        return (
            f"{self.method}: rms {1e-6 * self.rms:.4g} MPa, {self.crossings:.4g} crossings/s, "
            f"{self.peaks:.4g} peaks/s, irregularity {self.irregularity:.4g}, damage "
            f"{self.damage:.4g} 1/s, life {self.life / 3600:.4g} h"
        )


def amplitude_density(
    moments: ArrayLike, amplitude: ArrayLike, method: Method = "dirlik"
) -> tuple[Array, float]:
    """Return the probability density of rainflow amplitudes, 1/Pa, and the cycle rate, 1/s.

    * ``narrow-band``: Rayleigh's density, one cycle per upward crossing of the mean (Miles 1954);
    * ``dirlik``: one exponential and two Rayleigh densities fitted to simulated histories, one
      cycle per peak (T. Dirlik, PhD thesis, Warwick 1985);
    * ``tovo-benasciutti``: weighted mean of level-crossing and range counting (D. Benasciutti and
      R. Tovo, *Int. J. Fatigue* 27 (2005) 867-877).

    Parameters
    ----------
    moments : (4,) array_like
        m0, m1, m2, m4 of `spectral_moments`.
    amplitude : array_like
        Stress amplitudes, Pa.
    method : str
        "narrow-band", "dirlik" or "tovo-benasciutti".
    """
    m0, m1, m2, m4 = (float(m) for m in np.asarray(moments))
    a = np.asarray(amplitude, dtype=np.float64)
    s = math.sqrt(m0)
    nu0, nup = math.sqrt(m2 / m0), math.sqrt(m4 / m2)
    a2 = min(m2 / math.sqrt(m0 * m4), 1.0)
    narrow = _rayleigh(a, s)
    if method == "narrow-band" or 1.0 - a2 < 1e-6:
        return narrow, nu0
    if method == "tovo-benasciutti":
        a1 = min(m1 / math.sqrt(m0 * m2), 1.0)
        share = 1.112 * (1.0 + a1 * a2 - (a1 + a2)) * math.exp(2.11 * a2) + (a1 - a2)
        b = min(max((a1 - a2) * share / (a2 - 1.0) ** 2, 0.0), 1.0)
        # both densities are per peak: level crossings occur at the rate nu0, ranges at the rate nup
        return b * a2 * narrow + (1.0 - b) * _rayleigh(a, a2 * s), nup
    z = a / s
    x = m1 / m0 * math.sqrt(m2 / m4)
    D1 = 2.0 * (x - a2 * a2) / (1.0 + a2 * a2)
    rest = 1.0 - a2 - D1 + D1 * D1
    R = (a2 - x - D1 * D1) / rest
    D2 = rest / (1.0 - R)
    D3 = 1.0 - D1 - D2
    Q = 1.25 * (a2 - D3 - D2 * R) / D1
    density = D3 * z * np.exp(-0.5 * z * z) / s
    if D1 > 0.0 and Q > 0.0:
        density = density + D1 / Q * np.exp(-z / Q) / s
    density = density + D2 * z / R**2 * np.exp(-0.5 * (z / R) ** 2) / s
    return np.asarray(density), nup


def _rayleigh(a: Array, s: float) -> Array:
    return np.asarray(a / s**2 * np.exp(-0.5 * (a / s) ** 2))


@explained
def spectral_damage(
    frequency: ArrayLike, psd: ArrayLike, sn: Any, *, method: Method = "dirlik"
) -> SpectralDamage:
    """Return the damage per second of a Gaussian stress with a given one-sided density.

    ``D = cycles/s * int p(a) / N(a) da`` over the rainflow amplitudes a, for S-N curves of any
    shape. `wirsching-light` multiplies the narrow-band damage by a factor of the slope k of the
    curve (P. H. Wirsching and M. C. Light, *J. Struct. Div. ASCE* 106 (1980) 1593-1607).
    All methods are approximate. Dirlik's gives 0.81 to 1.02 times the damage of counted histories
    for one band at k = 5, 0.70 to 1.04 for several bands, less for larger k; the narrow-band
    method is conservative (table in `docs/verified-life.md`).

    Parameters
    ----------
    frequency : (nf,) array_like
        Frequencies, Hz.
    psd : (nf,) array_like
        One-sided density of a stress with zero mean, Pa^2/Hz.
    sn : SN
        S-N curve; its rule defines the damage of cycles below the knee.
    method : {"dirlik", "narrow-band", "tovo-benasciutti", "wirsching-light"}

    Raises
    ------
    InputError
        For an unknown method or an invalid density.
    """
    if method not in METHODS:
        raise InputError(
            Problem("spectral damage", f"method is {method!r}{suggest(method, METHODS)}")
        )
    return damage_of_moments(spectral_moments(frequency, psd), sn, method=method)


def damage_of_moments(moments: ArrayLike, sn: Any, *, method: Method = "dirlik") -> SpectralDamage:
    """Return the damage per second from the moments m0, m1, m2, m4 of a stress density."""
    m0, _, m2, m4 = (float(m) for m in np.asarray(moments))
    if m0 <= 0.0 or m2 <= 0.0 or m4 <= 0.0:
        return SpectralDamage(method, math.sqrt(max(m0, 0.0)), 0.0, 0.0, 1.0, 0.0)
    s, nu0, nup = math.sqrt(m0), math.sqrt(m2 / m0), math.sqrt(m4 / m2)
    factor, inner = 1.0, method
    if method == "wirsching-light":
        width = math.sqrt(max(1.0 - m2 * m2 / (m0 * m4), 0.0))
        low = 0.926 - 0.033 * sn.k
        factor = low + (1.0 - low) * (1.0 - width) ** (1.587 * sn.k - 2.323)
        inner = "narrow-band"
    # amplitudes in quadratic spacing, fine near 0; the range suffices for slopes k up to about 20
    u = np.linspace(0.0, 1.0, POINTS)[1:]
    far = REACH * s * (2.5 if inner == "dirlik" else 1.0)
    a = far * u * u
    density, rate = amplitude_density(moments, a, inner)
    with np.errstate(divide="ignore"):
        each = 1.0 / np.asarray(sn.cycles(a), dtype=np.float64)
    damage = factor * rate * float(np.trapezoid(np.maximum(density, 0.0) * each * 2 * far * u, u))
    return SpectralDamage(method, s, nu0, nup, nu0 / nup, damage)


@explained
def synthesise(
    frequency: ArrayLike, psd: ArrayLike, duration: float, *, rate: float, seed: int = 0
) -> tuple[Array, Array]:
    """Return times (nt,) in s and a Gaussian history (nt,) of a one-sided density.

    Its Fourier coefficients are independent normal numbers, so that amplitudes and phases are
    random.

    Parameters
    ----------
    frequency, psd : (nf,) array_like
        Frequencies, Hz, and one-sided density, unit squared per Hz.
    duration : float
        Length of the history, s.
    rate : float
        Samples per second; 10 or more times the highest frequency for rainflow counting.
    seed : int
        Seed of the random numbers.

    Raises
    ------
    InputError
        For a rate below twice the highest frequency, or a duration below one sample.
    """
    f, S = _spectrum(frequency, psd)
    problems = Problems()
    problems.positive("synthesise", "duration", duration, "s")
    problems.positive("synthesise", "rate", rate, "1/s")
    if rate < 2.0 * f[-1]:
        problems.add(
            "synthesise", f"rate {rate:g} 1/s is below twice the highest frequency, {f[-1]:g} Hz"
        )
    problems.raise_if_any()
    nt = max(2, round(duration * rate))
    grid = np.fft.rfftfreq(nt, 1.0 / rate)
    level = np.interp(grid, f, S, left=0.0, right=0.0)
    rng = np.random.default_rng(seed)
    scale = np.sqrt(0.5 * level * grid[1]) * nt / math.sqrt(2.0)
    spectrum = scale * (rng.normal(size=len(grid)) + 1j * rng.normal(size=len(grid)))
    spectrum[0] = 0.0
    return np.arange(nt) / rate, np.fft.irfft(spectrum, nt)
