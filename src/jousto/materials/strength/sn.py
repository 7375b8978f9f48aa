"""S-N curves: how many cycles of a stress amplitude a material or a weld endures."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import scipy
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.base.fields import Choice, In, Label, Out, field
from jousto.base.numbers import Number, OnlyPositive, OptionalNumber

BAND = "1 or larger (10 % over 90 % of survival)"

RULES = ("original", "elementary", "haibach")
"""What happens below the knee: no damage, the same slope, or the slope 2 k - 1."""

SPAN = 2.5631031310892007
"""Standard deviations between the lines of 10 and 90 % survival, twice the normal quantile."""


class _Strength(OnlyPositive[In, Out]):
    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return a positive stress, or report the value; warn about a stress in another unit."""
        found = super().check(problems, where, value)
        if found is not None:
            check_unit(where, self.label, found)
        return found


class Strength(_Strength[float, float]):
    """Field of a strength, Pa."""


class OptionalStrength(_Strength["float | None", "float | None"]):
    """Field of a strength, Pa, or None."""

    optional = True


class SN(Declared, section="curves", tag="sn", by_value=True):
    """S-N (Basquin, Woehler) curve with one knee.

    ``N = N_D (S_D / S)^k`` for stress amplitudes S above S_D. Below, by the rule: ``original``
    (Miner), no damage; ``elementary`` (Miner), the same line; ``haibach``, the slope 2 k - 1
    (E. Haibach, Betriebsfestigkeit, 1989), or `k2` if given. Damage of n cycles is n / N.

    Raises
    ------
    InputError
        With all values out of range.

    Warns
    -----
    JoustoWarning
        If S_D or S_u is probably in MPa instead of Pa, or was converted twice.

    Examples
    --------
    >>> steel = SN(S_D=100e6, N_D=1e6, k=5)
    >>> float(steel.cycles(200e6)), float(steel.amplitude(31250))
    (31250.0, 200000000.0)
    >>> float(replace(steel, rule="original").cycles(99e6))
    inf
    """

    kind = "S-N curve"
    S_D: Strength = field("Stress **amplitude** (half of the range) at the knee", unit="Pa")
    N_D: Number = field("Cycles at the knee", unit="cycles", above=1, wanted="a number above 1")
    k: Number = field(
        "Slope above the knee, larger than 1; Basquin's exponent is ``b = -1/k``",
        above=1,
        wanted="a number above 1 (N falls with S^k; Basquin's exponent b is -1/k)",
    )
    rule: Choice = field(
        'Rule below the knee. "elementary" is conservative: under variable amplitudes small '
        "cycles extend cracks that large ones have started",
        words=RULES,
        default="elementary",
    )
    k2: OptionalNumber = field(
        'Slope below the knee with the rule "haibach"; 2 k - 1 if None', default=None, kw_only=True
    )
    N_cut: OptionalNumber = field(
        "Number of cycles of the cut-off limit, where the second line ends: smaller amplitudes "
        "cause no damage",
        unit="cycles",
        default=None,
        kw_only=True,
    )
    R: OptionalNumber = field(
        "Stress ratio min/max of the tests, -1 fully reversed. None if it has no effect, as in "
        "welds without stress relief",
        below=1,
        wanted="below 1 (min/max of the tests)",
        default=-1.0,
        kw_only=True,
    )
    T_S: OptionalNumber = field(
        "Scatter band in stress: ``S(10 %) / S(90 %)`` of survival, 1 or larger. The scatter is "
        "log-normal with the standard deviation ``lg(T_S) / 2.5631``",
        least=1,
        wanted=BAND,
        default=None,
        kw_only=True,
    )
    T_N: OptionalNumber = field(
        "Scatter band in cycles, ``N(10 %) / N(90 %)``; ``T_S^k`` if only T_S is given, and "
        "vice versa",
        least=1,
        wanted=BAND,
        default=None,
        kw_only=True,
    )
    survival: Number = field(
        "Probability of survival for which the curve is valid, 0.5 for the mean of tests",
        above=0,
        below=1,
        wanted="between 0 and 1 (0.975, not 97.5)",
        default=0.5,
        kw_only=True,
    )
    S_u: OptionalStrength = field(
        "Tensile strength, above which stresses are reported", unit="Pa", default=None, kw_only=True
    )
    name: Label = field("For tables", default="", kw_only=True)
    source: Label = field("Source of the values", default="", kw_only=True, compare=False)

    def consistent(self, problems: Problems, where: str) -> None:
        """Report inconsistent values."""
        if self.k2 is not None:
            if self.rule != "haibach":
                problems.add(
                    where, f'k2 is allowed with rule="haibach" only, not with {self.rule!r}', "k2"
                )
            if self.k2 < self.k:
                problems.add(where, f"k2 is {self.k2:g}, must be k = {self.k:g} or larger", "k2")
        if self.N_cut is not None:
            if self.rule == "original":
                problems.add(
                    where, 'rule="original" has no damage below the knee; leave N_cut out', "rule"
                )
            if self.N_cut < self.N_D:
                problems.add(where, f"N_cut is {self.N_cut:g} cycles, must be N_D or more", "N_cut")
        if self.S_u is not None and self.S_u < self.S_D:
            problems.add(
                where,
                f"S_u = {self.S_u / 1e6:g} MPa is below the amplitude S_D ="
                f" {self.S_D / 1e6:g} MPa at the knee, must be above it",
                "S_u",
            )

    @classmethod
    def basquin(cls, sf: float, b: float, *, N_D: float = 1e6, **others: Any) -> SN:
        """Return the curve ``S = sf (2 N)^b`` from constants of stress-life and strain-life tables.

        Parameters
        ----------
        sf : float
            Fatigue strength coefficient sigma_f', Pa.
        b : float
            Fatigue strength exponent, negative.
        N_D : float
            Number of cycles of the knee.
        **others
            Other fields of the class.

        Raises
        ------
        InputError
            If a value is impossible.

        Examples
        --------
        >>> curve = SN.basquin(1758e6, -0.0977, name="AISI 4340")  # Dowling, table 9.1
        >>> round(float(curve.amplitude(0.5)) / 1e6)
        1758
        """
        problems = Problems()
        where = "S-N curve"
        problems.positive(where, "sf", sf, "Pa")
        problems.number(where, "b", b, "", "between -1 and 0", lambda x: -1.0 < x < 0.0)
        problems.number(where, "N_D", N_D, "cycles", "a number above 1", _above_one)
        problems.raise_if_any()
        return cls(sf * (2.0 * N_D) ** b, N_D, -1.0 / b, **others)

    # -- evaluation --------------------------------------------------------------------------

    @property
    def slope2(self) -> float:
        """Slope below the knee: k, 2 k - 1 or k2; inf for the rule "original"."""
        if self.rule == "original":
            return math.inf
        if self.rule == "elementary":
            return float(self.k)
        return float(2.0 * self.k - 1.0 if self.k2 is None else self.k2)

    @property
    def S_limit(self) -> float:
        """Amplitude below which there is no damage, Pa; 0 if there is none."""
        if self.rule == "original":
            return float(self.S_D)
        if self.N_cut is None:
            return 0.0
        return float(self.S_D * (self.N_D / self.N_cut) ** (1.0 / self.slope2))

    @property
    def numbers(self) -> tuple[float, float, float, float, float]:
        """Numbers of the curve for the engine: S_D, N_D, k, slope2 and S_limit.

        The damage of a cycle of amplitude S is 0 for S < S_limit, else ``(S/S_D)^m / N_D`` with m =
        k for S >= S_D, m = slope2 below.
        """
        return (float(self.S_D), float(self.N_D), float(self.k), self.slope2, self.S_limit)

    def cycles(self, amplitude: ArrayLike) -> Array:
        """Return the cycles N (...,) to failure at stress amplitudes (...,), Pa.

        Inf for no failure.

        Raises
        ------
        InputError
            If an amplitude is negative or not a number.
        """
        with np.errstate(divide="ignore", over="ignore"):
            return np.asarray(1.0 / self._each(amplitude))

    def damage(self, amplitude: ArrayLike, count: ArrayLike = 1.0) -> float:
        """Return Miner's sum ``sum n_i / N_i`` of `count` cycles of stress amplitudes, Pa."""
        return float(np.sum(np.asarray(count, dtype=np.float64) * self._each(amplitude)))

    def amplitude(self, cycles: ArrayLike) -> Array:
        """Return the stress amplitude (...,), Pa, for a number of cycles to failure.

        Beyond the knee of a curve with endurance limit, or beyond the cut-off, it is that limit.
        """
        N = np.asarray(cycles, dtype=np.float64)
        if not np.all(N > 0.0):
            raise InputError(Problem("S-N curve", "cycles must be positive numbers"))
        m = np.where(self.N_D >= N, self.k, self.slope2)
        with np.errstate(over="ignore"):
            S = self.S_D * (self.N_D / N) ** (1.0 / m)
        return np.asarray(np.maximum(S, self.S_limit))

    def _each(self, amplitude: ArrayLike) -> Array:
        """Return the damage of one cycle at each amplitude."""
        S = np.asarray(amplitude, dtype=np.float64)
        if not np.all(S >= 0.0):  # also false for nan
            raise InputError(
                Problem(
                    "S-N curve",
                    "stress amplitudes must be zero or positive numbers in Pa",
                    path=("stress",),
                )
            )
        return miner(S, self.numbers)

    # -- derived curves ---------------------------------------------------------------------

    def with_factors(self, *factors: float, pivot: float | None = None) -> SN:
        """Return the curve with S_D multiplied by factors: surface, size, load, thickness ...

        Parameters
        ----------
        *factors : float
            Factors from `roughness_factor`, `size_factor` or other sources.
        pivot : float, optional
            Number of cycles at which the factors have no effect, such as 1e3 (Shigley): the line is
            rotated about that point, so that k changes. None shifts the whole line (FKM).

        Raises
        ------
        InputError
            If a factor is not positive, or the rotated line does not fall.

        Examples
        --------
        >>> smooth = SN(S_D=100e6, N_D=1e6, k=5)
        >>> rough = smooth.with_factors(0.8, 0.9)
        >>> float(rough.S_D), rough.k
        (72000000.0, 5.0)
        >>> turned = smooth.with_factors(0.72, pivot=1e3)
        >>> round(float(turned.amplitude(1e3) / smooth.amplitude(1e3)), 12), round(turned.k, 3)
        (1.0, 4.039)
        """
        problems = Problems()
        for i, factor in enumerate(factors):
            problems.positive("with_factors", f"factor {i + 1}", factor, "")
        problems.raise_if_any()
        product = float(np.prod(factors)) if factors else 1.0
        if pivot is None:
            return replace(self, S_D=self.S_D * product)
        problems.number(
            "with_factors", "pivot", pivot, "cycles", "below N_D", lambda x: 0.0 < x < self.N_D
        )
        problems.raise_if_any()
        # lg of the ratio of strengths at the pivot and at the knee
        drop = math.log(self.N_D / pivot) / self.k - math.log(product)
        k = math.log(self.N_D / pivot) / drop if drop > 0.0 else 0.0
        if not k > 1.0:
            raise InputError(
                Problem(
                    "with_factors",
                    f"factors {product:g} lead to a line through {pivot:g} cycles that does not "
                    f"fall, or is too steep; choose another pivot",
                    path=("factors",),
                )
            )
        k2 = None if self.k2 is None else max(self.k2, k)
        return replace(self, S_D=self.S_D * product, k=k, k2=k2)

    @property
    def deviation(self) -> float:
        """Standard deviation of lg N at a given amplitude.

        Raises
        ------
        InputError
            If no scatter was given.
        """
        if self.T_N is not None:
            return math.log10(self.T_N) / SPAN
        if self.T_S is not None:
            return self.k * math.log10(self.T_S) / SPAN
        where = f"S-N curve '{self.name}'" if self.name else "S-N curve"
        raise InputError(
            Problem(
                where,
                "has no scatter; give T_S (scatter band in stress, such as 1.25) or T_N (in "
                "cycles, such as 3)",
            )
        )

    def at_survival(self, probability: float) -> SN:
        """Return the curve for another probability of survival.

        ``lg S_P = lg S_0 - (z_P - z_0) lg(T_S) / 2.5631`` with the quantiles z of the normal
        distribution; the knee moves in proportion to T_N (FKM guideline; J. Schijve, Fatigue of
        Structures and Materials).

        Parameters
        ----------
        probability : float
            Probability of survival, such as 0.9, 0.975, 0.999.

        Raises
        ------
        InputError
            If the probability is not between 0 and 1, or the curve has no scatter.

        Examples
        --------
        >>> mean = SN(S_D=100e6, N_D=1e6, k=5, T_S=1.25)
        >>> safe = mean.at_survival(0.9)
        >>> round(safe.S_D / mean.S_D, 6) == round(1.25**-0.5, 6)
        True
        """
        problems = Problems()
        wanted = "between 0 and 1 (0.975, not 97.5)"
        problems.number("at_survival", "probability", probability, "", wanted, _share)
        problems.raise_if_any()
        factor, knee = self._shift(probability)
        N_D = self.N_D * knee
        cut = None if self.N_cut is None else self.N_cut * knee
        return replace(self, S_D=self.S_D * factor, N_D=N_D, N_cut=cut, survival=probability)

    def numbers_at(self, probability: float) -> tuple[float, float, float, float, float]:
        """Return the `numbers` of the curve at a probability of survival, without checks."""
        factor, knee = self._shift(probability)
        S_D, N_D, k, k2, limit = self.numbers
        return (S_D * factor, N_D * knee, k, k2, limit * factor)

    def _shift(self, probability: float) -> tuple[float, float]:
        """Return the factors on S_D and on N_D for another probability of survival."""
        shift = float(scipy.special.ndtri(self.survival) - scipy.special.ndtri(probability))
        sigma = self.deviation
        sigma_S = math.log10(self.T_S) / SPAN if self.T_S is not None else sigma / self.k
        # the finite-life line scatters by T_N, the limit by T_S: the knee moves by the ratio
        return 10.0 ** (shift * sigma_S), 10.0 ** (shift * (sigma - self.k * sigma_S))

    def __str__(self) -> str:
        named = f"{self.name}: " if self.name else ""
        text = f"{named}S_D {self.S_D / 1e6:.4g} MPa (amplitude) at {self.N_D:.4g} cycles"
        text += f", k {self.k:.4g}, {self.rule}"
        if self.rule == "haibach":
            text += f" ({self.slope2:.4g})"
        if self.N_cut is not None:
            text += f", cut-off at {self.N_cut:.4g} ({self.S_limit / 1e6:.4g} MPa)"
        if self.R is not None:
            text += f", R {self.R:g}"
        return text + f", survival {100 * self.survival:.5g} %"


def miner(amplitude: Array, numbers: tuple[float, float, float, float, float]) -> Array:
    """Return the damage of one cycle at each amplitude, from the `SN.numbers` of a curve."""
    S = amplitude
    S_D, N_D, k, k2, limit = numbers
    with np.errstate(over="ignore"):
        ratio = S / S_D
        low = ratio**k2 if math.isfinite(k2) else np.zeros_like(ratio)
        each = np.where(S >= S_D, ratio**k, low) / N_D
    return np.asarray(np.where((limit > S) | (S == 0.0), 0.0, each))


def check_unit(where: str, name: str, stress: float) -> None:
    """Warn if a strength is probably in MPa instead of Pa, or was converted to Pa twice."""
    if stress < 1e5:
        warn(
            where,
            f"{name} = {stress:g} Pa is weaker than foam; was it given in MPa? SI needs Pa, so"
            f" {stress:g}e6",
            name,
        )
    elif stress > 2e10:
        warn(
            where,
            f"{name} = {stress:g} Pa is stronger than any metal; was a value in Pa multiplied by "
            f"1e6?",
            name,
        )


def _above_one(x: float) -> bool:
    return x > 1.0


def _share(x: float) -> bool:
    return 0.0 < x < 1.0
