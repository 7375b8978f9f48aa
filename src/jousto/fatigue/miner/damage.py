"""Damage, life and safety of one history."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ndtr

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.base.object_repr import described
from jousto.fatigue.cycles.rainflow import Cycles, rainflow
from jousto.fatigue.miner.spectrum import Spectrum
from jousto.materials.strength.mean_stress import MeanStress, PartCompression, WeldRatio
from jousto.materials.strength.sn import SN, miner

FACTORS = (1e-9, 1e9)
"""Limits of the factor on the load in the search for the safety."""


def reference(sn: SN, mean: MeanStress | None) -> SN:
    """Return the S-N curve at R = -1, for amplitudes after the mean stress correction.

    For a curve from tests at another stress ratio R, S_D is replaced by the corrected amplitude of
    the cycle with amplitude S_D and mean ``S_D (1 + R) / (1 - R)``.
    """
    S_D = _reversed(sn, mean, sn.S_D)
    if S_D == sn.S_D:
        return sn
    if not (math.isfinite(S_D) and S_D > 0.0):
        raise InputError(
            Problem(
                "mean stress",
                f"{mean} has no fully reversed equivalent of S_D ="
                f" {sn.S_D / 1e6:g} MPa at R = {sn.R:g}",
            )
        )
    return replace(sn, S_D=S_D, R=-1.0)


def _reversed(sn: SN, mean: MeanStress | None, S_D: float) -> float:
    """Return the equivalent amplitude at R = -1, Pa, of an amplitude at the R of the curve."""
    if mean is None or sn.R is None or sn.R == -1.0:
        return S_D
    if isinstance(mean, WeldRatio | PartCompression):
        return S_D
    return float(mean.equivalent(S_D, S_D * (1.0 + sn.R) / (1.0 - sn.R)))


def check_stress(
    sn: SN, amplitude: float, peak: float, mean: MeanStress | None, where: str = "damage"
) -> None:
    """Warn if stresses and curve seem to be in different units, or a stress is above S_u.

    Parameters
    ----------
    sn : SN
    amplitude, peak : float
        Largest amplitude and largest stress, Pa.
    mean : MeanStress or None
        Mean stress correction, whose tensile strength is checked like that of the curve.
    """
    if sn.S_D >= 1e6 and 1e-2 < amplitude < min(5e3, 1e-4 * sn.S_D):
        warn(
            where,
            f"the largest amplitude is {amplitude:.4g} Pa where the S-N curve has S_D ="
            f" {sn.S_D / 1e6:.4g} MPa; are the stresses in MPa? SI needs Pa",
        )
    elif amplitude > 1e4 * sn.S_D:
        warn(
            where,
            f"the largest amplitude is {amplitude / 1e6:.4g} MPa where the S-N curve has S_D ="
            f" {sn.S_D:.4g} Pa; was the curve given in MPa? SI needs Pa",
        )
    for name, strength in (
        ("tensile strength", sn.S_u),
        ("tensile strength", getattr(mean, "S_u", None)),
        ("yield stress", getattr(mean, "S_y", None)),
    ):
        if strength is not None and peak > strength:
            warn(
                where,
                f"the largest stress, {peak / 1e6:.4g} MPa, is above the {name}"
                f" {strength / 1e6:.4g} MPa: check the load and the unit, or use strain life at a"
                " notch",
            )
            return


def equivalents(cycles: Cycles, mean: MeanStress | None) -> Array:
    """Return equivalent amplitudes (nc,) in Pa, corrected for their mean stress."""
    if mean is None:
        return cycles.amplitude
    return mean.equivalent(cycles.amplitude, cycles.mean)


def proportional(mean: MeanStress | None) -> bool:
    """Return whether equivalent amplitudes are proportional to the load.

    The amplitudes of Goodman and Gerber are not proportional.
    """
    return mean is None or mean.law[0] not in ("line", "gerber")


@explained
def damage(cycles: Cycles, sn: SN, mean: MeanStress | None = None) -> float:
    """Return Miner's sum ``D = sum n_i / N_i`` of counted cycles.

    Parameters
    ----------
    cycles : Cycles
        From `rainflow`, Pa.
    sn : SN
    mean : MeanStress, optional
        Correction such as ``Goodman(S_u)``; None is no correction.

    Returns
    -------
    float
        Miner's sum; inf if a mean stress exceeds the strength.

    Warns
    -----
    JoustoWarning
        If stresses and curve seem to be in different units, or a stress is above S_u.

    Examples
    --------
    >>> history = [25e6 * x for x in (-2, 1, -3, 5, -1, 3, -4, 4, -2)]  # ASTM E1049, figure 6
    >>> curve = SN(S_D=100e6, N_D=1e6, k=5)
    >>> print(f"{damage(rainflow(history, residue='half'), curve):.8e}")
    2.07025146e-06
    """
    if not isinstance(cycles, Cycles):
        raise InputError(Problem("damage", "cycles must be Cycles: rainflow(history, residue=...)"))
    if not len(cycles):
        check_stress(sn, 0.0, float(np.max(np.abs(cycles.open), initial=0.0)), mean)
        return math.inf if _breaks(cycles, mean) else 0.0
    check_stress(sn, float(cycles.amplitude.max()), _peak(cycles), mean)
    return _sum(cycles, reference(sn, mean), mean)


@explained
def life(cycles: Cycles, sn: SN, mean: MeanStress | None = None, *, duration: float = 1.0) -> float:
    """Return the life ``duration / D`` with Miner's sum D; inf without damage.

    Parameters
    ----------
    cycles, sn, mean
        As for `damage`.
    duration : float
        Duration of the history, s, for a life in s; 1 for a number of repetitions.
    """
    problems = Problems()
    problems.positive("life", "duration", duration, "s")
    problems.raise_if_any()
    D = damage(cycles, sn, mean)
    return math.inf if D == 0.0 else duration / D


def _peak(cycles: Cycles) -> float:
    return float(np.max(np.abs(cycles.mean) + cycles.amplitude, initial=0.0))


def _breaks(cycles: Cycles, mean: MeanStress | None, factor: float = 1.0) -> bool:
    """Return whether a mean stress times a factor exceeds the strength."""
    if mean is None or len(cycles):
        return False
    top = factor * float(np.max(cycles.open, initial=0.0))
    return bool(np.isinf(mean.equivalent(0.0, top)))


def _sum(cycles: Cycles, sn: SN, mean: MeanStress | None, factor: float = 1.0) -> float:
    """Return Miner's sum with all stresses multiplied by a factor."""
    if _breaks(cycles, mean, factor):
        return math.inf
    S = cycles.amplitude * factor
    if mean is not None:
        S = mean.equivalent(S, cycles.mean * factor)
    if np.any(np.isinf(S)):
        return math.inf
    return sn.damage(S, cycles.count)


@explained
def stress_safety(
    cycles: Cycles, sn: SN, mean: MeanStress | None = None, *, allowable: float = 1.0
) -> float:
    """Return the safety in stress: the largest factor on all stresses with an allowable sum.

    If Miner's sum jumps over the allowable sum at an endurance limit, the result is the factor just
    below the jump.

    Parameters
    ----------
    cycles, sn, mean
        As for `damage`.
    allowable : float
        Allowable Miner's sum: 1, or 0.5 or 0.3 by some guidelines.

    Examples
    --------
    >>> cycles = rainflow([0.0, 100e6, 0.0, 100e6, 0.0], residue="repeat")
    >>> curve = SN(S_D=100e6, N_D=1e6, k=5)  # amplitude 50 MPa, 2 cycles
    >>> round(stress_safety(cycles, curve), 6) == round(2 * (1e6 / 2) ** 0.2, 6)
    True
    """
    problems = Problems()
    problems.positive("stress_safety", "allowable", allowable, "")
    problems.raise_if_any()
    breaks = _breaks(cycles, mean)
    if not breaks and not np.any(cycles.range > 0.0):
        return math.inf
    curve = reference(sn, mean)
    if proportional(mean) and not breaks:
        S = equivalents(cycles, mean)
        return Spectrum(S, cycles.count, curve).factor(allowable)
    low, high = math.log(FACTORS[0]), math.log(FACTORS[1])
    if _sum(cycles, curve, mean, FACTORS[1]) <= allowable:
        return math.inf
    # bisection: the interval of 41 (logarithm of the factor) over 2^48
    for _ in range(48):
        middle = 0.5 * (low + high)
        if _sum(cycles, curve, mean, math.exp(middle)) <= allowable:
            low = middle
        else:
            high = middle
    return math.exp(low)


def survival_of(
    cycles: Cycles, sn: SN, mean: MeanStress | None = None, *, allowable: float = 1.0
) -> float:
    """Return the probability of survival P of counted cycles.

    P solves ``sum n_i / N_P(S_i) = allowable`` with the curve N_P of `SN.at_survival`. It does not
    follow from Miner's sum of one curve, because cycles below the knee of one curve are above the
    knee of a lower one and have another slope.

    Parameters
    ----------
    cycles, sn, mean
        As for `damage`; the curve must have a scatter.
    allowable : float
        Allowable Miner's sum.

    Raises
    ------
    InputError
        If the curve has no scatter.

    Examples
    --------
    >>> cycles = rainflow([0.0, 198e6, 0.0], residue="repeat").times(1e7)  # just below the limit
    >>> round(survival_of(cycles, SN(S_D=100e6, N_D=1e6, k=5, rule="original", T_S=1.25)), 3)
    0.546
    """
    S = equivalents(cycles, mean)

    def survives(z: float) -> bool:
        S_D, N_D, k, k2, limit = sn.numbers_at(float(ndtr(z)))
        strength = _reversed(sn, mean, S_D)
        if not (math.isfinite(strength) and strength > 0.0):  # curve above the static strength
            return True
        at = (strength, N_D, k, k2, limit * strength / S_D)
        return float(np.sum(cycles.count * miner(S, at))) <= allowable

    low, high = (
        -8.0,
        8.0,
    )  # limits of z in standard deviations; beyond them P is 0 or 1 in double precision
    if np.any(np.isinf(S)) or _breaks(cycles, mean) or not survives(low):
        return 0.0
    if survives(high):
        return 1.0
    for _ in range(48):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if survives(middle) else (low, middle)
    return float(ndtr(low))


@described
@dataclass(frozen=True, eq=False)
class Assessment:
    """Fatigue assessment of a stress history.

    Attributes
    ----------
    damage : float
        Miner's sum of one repetition of the history.
    duration : float
        Duration of the history, s; 1 if not known.
    life : float
        ``allowable duration / damage``, s (or repetitions); inf without damage.
    safety : float
        Factor on the stress with which the required life, or one repetition, has the allowable
        sum, see `stress_safety`.
    life_safety : float
        Life over required life.
    probability : float
        Probability of survival of the required life, see `survival_of`; nan if the curve has no
        scatter.
    survival : float
        Probability of survival to which damage, life and safety refer.
    allowable, required : float
        Allowable Miner's sum; required life, s (or repetitions), by default the duration.
    cycles : Cycles
    sn : SN
        S-N curve at that probability of survival.
    mean : MeanStress or None
    """

    damage: float
    duration: float
    life: float
    safety: float
    life_safety: float
    probability: float
    survival: float
    allowable: float
    required: float
    cycles: Cycles
    sn: SN
    mean: MeanStress | None

    @property
    def residue(self) -> str:
        """The residue rule."""
        return self.cycles.residue

    def __str__(self) -> str:
        mean = "not corrected" if self.mean is None else str(self.mean)
        rows = [
            ("S-N curve", str(self.sn)),
            ("mean stress", mean),
            ("cycles", f"{self.cycles.total:g}, residue: {self.residue}"),
            ("damage", f"{self.damage:.6g} (Miner's sum, allowed {self.allowable:g})"),
            ("life", f"{duration_text(self.life)} for a history of {duration_text(self.duration)}"),
            ("safety", f"{self.safety:.4g} in stress, {self.life_safety:.4g} in life"),
        ]
        if not math.isnan(self.probability):
            rows.append(
                ("survival", f"{100 * self.probability:.6g} % after {duration_text(self.required)}")
            )
        return "\n".join(f"{name:12s} {text}" for name, text in rows)


def duration_text(seconds: float) -> str:
    """Return a time, s, as a text, with a larger unit if it is long.

    Examples
    --------
    >>> duration_text(90.0), duration_text(7.3e8), duration_text(float("inf"))
    ('90 s', '7.3e+08 s (23.1 years)', 'for ever')
    """
    if math.isinf(seconds):
        return "for ever"
    text = f"{seconds:.4g} s"
    for size, unit in ((31556952.0, "years"), (86400.0, "days"), (3600.0, "h")):
        if seconds >= size:
            return f"{text} ({seconds / size:.3g} {unit})"
    return text


@explained
def assess(
    history: ArrayLike | Cycles,
    sn: SN,
    *,
    residue: str | None = None,
    mean: MeanStress | None = None,
    duration: float = 1.0,
    required: float | None = None,
    allowable: float = 1.0,
    survival: float | None = None,
) -> Assessment:
    """Return damage, life and safety of a stress history.

    Parameters
    ----------
    history : (nt,) array_like or Cycles
        Stress, Pa; or counted cycles.
    sn : SN
        S-N curve.
    residue : str
        "half", "repeat" or "ignore", see `rainflow`; needed unless the cycles are counted.
    mean : MeanStress, optional
        Mean stress correction.
    duration : float
        Duration of the history, s; 1 for a life in repetitions.
    required : float, optional
        Required life, in the unit of `duration`; None is one repetition.
    allowable : float
        Allowable Miner's sum.
    survival : float, optional
        Probability of survival of damage, life and safety; None: that of the curve.

    Raises
    ------
    InputError
        See `rainflow`; also if `survival` differs from that of a curve without scatter.

    Examples
    --------
    >>> curve = SN(S_D=100e6, N_D=1e6, k=5, T_S=1.25)
    >>> found = assess([0, 240e6, 0], curve, residue="repeat", required=1e5, survival=0.9)
    >>> round(found.life), round(found.safety, 3), round(100 * found.probability, 1)
    (230048, 1.181, 99.9)
    """
    problems = Problems()
    problems.positive("assess", "duration", duration, "s")
    problems.positive("assess", "allowable", allowable, "")
    if required is not None:
        problems.positive("assess", "required", required, "s")
    problems.raise_if_any()
    cycles = history if isinstance(history, Cycles) else rainflow(history, residue=residue)
    curve = sn if survival is None or survival == sn.survival else sn.at_survival(survival)
    D = damage(cycles, curve, mean)
    wanted = duration if required is None else required
    left = math.inf if D == 0.0 else allowable * duration / D
    share = allowable * duration / wanted
    safety = stress_safety(cycles, curve, mean, allowable=share)
    known = sn.T_S is not None or sn.T_N is not None
    return Assessment(
        D,
        duration,
        left,
        safety,
        left / wanted,
        survival_of(cycles, curve, mean, allowable=share) if known else math.nan,
        curve.survival,
        allowable,
        wanted,
        cycles,
        curve,
        mean,
    )
