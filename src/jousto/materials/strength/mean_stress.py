"""Mean stress corrections: the fully reversed amplitude with the same damage as a cycle."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import Problems, suggest
from jousto.base.fields import Choice, Flag, field
from jousto.base.numbers import Number
from jousto.materials.strength.sn import Strength, check_unit


class MeanStress(Declared, ABC, section="mean stress", by_value=True):
    """Base of the mean stress corrections."""

    @abstractmethod
    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude (...,), Pa, of cycles with amplitude and mean, Pa.

        It is inf if the mean stress alone exceeds the strength.
        """

    @property
    @abstractmethod
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law in the engine, as for a ``jo_meter`` in jousto.h."""

    @property
    def name(self) -> str:
        """Name, for tables."""
        return str(self)


def _pair(amplitude: ArrayLike, mean: ArrayLike) -> tuple[Array, Array]:
    return np.asarray(amplitude, dtype=np.float64), np.asarray(mean, dtype=np.float64)


def _line(S_a: Array, S_m: Array, S_u: float, credit: bool) -> Array:
    """Return S_a / (1 - S_m / S_u), inf if the mean reaches S_u."""
    S_m = S_m if credit else np.maximum(S_m, 0.0)
    rest = 1.0 - S_m / S_u
    return np.where(rest > 0.0, S_a / np.where(rest > 0.0, rest, 1.0), np.inf)


class Goodman(MeanStress, tag="goodman"):
    """``S_ar = S_a / (1 - S_m / S_u)`` (J. Goodman 1899).

    Examples
    --------
    >>> float(Goodman(S_u=500e6).equivalent(100e6, 250e6))
    200000000.0
    """

    S_u: Strength = field("Tensile strength", unit="Pa")
    credit: Flag = field(
        "Whether compressive means increase life; False treats them as zero, which is conservative",
        default=True,
    )

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude, Pa; see the class."""
        return _line(*_pair(amplitude, mean), self.S_u, self.credit)

    @property
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law; see the class."""
        return "line", {"strength": float(self.S_u), "credit": float(self.credit)}


class Soderberg(MeanStress, tag="soderberg"):
    """``S_ar = S_a / (1 - S_m / S_y)``: Goodman's line to the yield stress (Soderberg 1930)."""

    S_y: Strength = field("Yield stress", unit="Pa")
    credit: Flag = field(
        "Whether compressive means increase life; False treats them as zero, which is conservative",
        default=True,
    )

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude, Pa; see the class."""
        return _line(*_pair(amplitude, mean), self.S_y, self.credit)

    @property
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law; see the class."""
        return "line", {"strength": float(self.S_y), "credit": float(self.credit)}


class Morrow(MeanStress, tag="morrow"):
    """``S_ar = S_a / (1 - S_m / sf)`` with the fatigue strength coefficient (J. Morrow 1968)."""

    sf: Strength = field("sigma_f', or the true fracture stress", unit="Pa")
    credit: Flag = field(
        "Whether compressive means increase life; False treats them as zero, which is conservative",
        default=True,
    )

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude, Pa; see the class."""
        return _line(*_pair(amplitude, mean), self.sf, self.credit)

    @property
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law; see the class."""
        return "line", {"strength": float(self.sf), "credit": float(self.credit)}


class Gerber(MeanStress, tag="gerber"):
    """``S_ar = S_a / (1 - (S_m / S_u)^2)`` (W. Gerber 1874); compressive means count as zero.

    The parabola applies to tension; its other half would make compression equally damaging.

    Examples
    --------
    >>> round(float(Gerber(S_u=500e6).equivalent(75e6, 250e6)))
    100000000
    """

    S_u: Strength = field("Tensile strength", unit="Pa")

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude, Pa; see the class."""
        S_a, S_m = _pair(amplitude, mean)
        rest = 1.0 - (np.maximum(S_m, 0.0) / self.S_u) ** 2
        return np.where(rest > 0.0, S_a / np.where(rest > 0.0, rest, 1.0), np.inf)

    @property
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law; see the class."""
        return "gerber", {"strength": float(self.S_u)}


class Walker(MeanStress, tag="walker"):
    """``S_ar = S_max^(1 - gamma) S_a^gamma`` (K. Walker 1970); zero if S_max is not tensile."""

    gamma: Number = field(
        "Between 0 and 1: 1 is insensitive to mean stress, 0.5 is `SWT`; about 0.65 for steels, "
        "0.45 for high-strength aluminium (N. E. Dowling, Fatigue Fract. Eng. Mater. Struct. 32 "
        "(2009) 163)",
        above=0,
        most=1,
        wanted="above 0 and at most 1",
    )

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude, Pa; see the class."""
        S_a, S_m = _pair(amplitude, mean)
        top = np.maximum(S_a + S_m, 0.0)
        return np.asarray(top ** (1.0 - self.gamma) * S_a**self.gamma)

    @property
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law; see the class."""
        return "walker", {"exponent": float(self.gamma)}


class SWT(MeanStress, tag="swt"):
    """``S_ar = sqrt(S_max S_a)`` (Smith, Watson, Topper 1970); zero if S_max is not tensile.

    Examples
    --------
    >>> float(SWT().equivalent(100e6, 300e6))  # max 400 MPa
    200000000.0
    """

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude, Pa; see the class."""
        S_a, S_m = _pair(amplitude, mean)
        return np.asarray(np.sqrt(np.maximum(S_a + S_m, 0.0) * S_a))

    @property
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law; see the class."""
        return "walker", {"exponent": 0.5}


# mean stress sensitivity M = a S_u / 1000 MPa + b
SENSITIVITY: dict[str, tuple[float, float]] = {
    "steel": (0.35, -0.10),
    "cast-steel": (0.35, 0.05),
    "nodular-iron": (0.35, 0.08),
    "malleable-iron": (0.35, 0.13),
    "grey-iron": (0.0, 0.5),
    "aluminium": (1.0, -0.04),
    "cast-aluminium": (1.0, 0.2),
}


class FKM(MeanStress, tag="fkm"):
    """Mean stress sensitivity M in the four regimes of the FKM guideline (6th ed., 4.4.2).

    With R = S_min / S_max of a cycle, the fully reversed amplitude is

    * I, R > 1 (all in compression): ``S_a (1 - M)``, the value of R = -inf
    * II, -inf <= R <= 0: ``S_a + M S_m``
    * III, 0 < R < 0.5: ``(1 + M) (S_a + M/3 S_m) / (1 + M/3)``
    * IV, R >= 0.5: ``S_a 3 (1 + M)^2 / (3 + M)``

    Examples
    --------
    >>> rule = FKM.of("steel", S_u=1000e6)
    >>> round(rule.M, 3), float(rule.equivalent(100e6, 100e6))
    (0.25, 125000000.0)
    """

    M: Number = field(
        "Sensitivity, 0 to below 1; `FKM.of` estimates it",
        least=0,
        below=1,
        wanted="0 or more, below 1",
    )

    @classmethod
    def of(cls, kind: str, S_u: float) -> FKM:
        """Return the sensitivity of a kind of material, ``M = a S_u/1000 MPa + b``.

        Parameters
        ----------
        kind : str
            "steel", "cast-steel", "nodular-iron", "malleable-iron", "grey-iron", "aluminium"
            or "cast-aluminium".
        S_u : float
            Tensile strength, Pa.

        Raises
        ------
        InputError
            If the kind is not known or the strength not positive.
        """
        problems = Problems()
        if kind not in SENSITIVITY:
            problems.add("FKM", f"no kind of material {kind!r}{suggest(kind, SENSITIVITY)}")
        problems.positive("FKM", "S_u", S_u, "Pa")
        problems.raise_if_any()
        check_unit("FKM", "S_u", S_u)
        a, b = SENSITIVITY[kind]
        return cls(max(a * S_u / 1e9 + b, 0.0))

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude, Pa; see the class."""
        S_a, S_m = _pair(amplitude, mean)
        M = self.M
        third = (1.0 + M) * (S_a + M / 3.0 * S_m) / (1.0 + M / 3.0)
        fourth = S_a * 3.0 * (1.0 + M) ** 2 / (3.0 + M)
        # R > 1 is S_m < -S_a, R = 0 is S_m = S_a, R = 0.5 is S_m = 3 S_a
        return np.select(
            [S_m < -S_a, S_m <= S_a, S_m < 3.0 * S_a],
            [S_a * (1.0 - M), S_a + M * S_m, third],
            fourth,
        )

    @property
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law; see the class."""
        return "fkm", {"sensitivity": float(self.M)}


class WeldRatio(MeanStress, tag="weld-ratio"):
    """Bonus of the stress ratio for welds, ``S_a / f(R)`` (IIW-2259-15, 3.5.2).

    Examples
    --------
    >>> float(WeldRatio("low").equivalent(160e6, 0.0))  # R = -1: f = 1.6
    100000000.0
    """

    residual: Choice = field(
        '"high" residual stresses: f = 1 (the usual case of welded structures). "medium", parts of '
        'thin simple elements: 1.3 for R < -1, -0.4 R + 0.9 to R = -0.25, then 1. "low", base '
        "material or stress relieved: 1.6 for R < -1, -0.4 R + 1.2 to R = 0.5, then 1",
        words=("low", "medium", "high"),
        wanted="low, medium or high",
        default="high",
    )

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude, Pa; see the class."""
        S_a, S_m = _pair(amplitude, mean)
        if self.residual == "high":
            return np.array(S_a + 0.0 * S_m)
        offset, top = (1.2, 1.6) if self.residual == "low" else (0.9, 1.3)
        peak = S_m + S_a
        # R falls to -inf as the peak goes to zero; all compression counts as R < -1
        with np.errstate(divide="ignore", invalid="ignore"):
            R = np.where(peak > 0.0, (S_m - S_a) / np.where(peak > 0.0, peak, 1.0), -np.inf)
        factor = np.clip(np.where(R < -1.0, top, offset - 0.4 * np.maximum(R, -1.0)), 1.0, top)
        return np.asarray(S_a / factor)

    @property
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law; see the class."""
        return "weld", {"relief": float(("high", "medium", "low").index(self.residual))}


class PartCompression(MeanStress, tag="part-compression"):
    """Reduced effect of compression (EN 1993-1-9, 7.2.1), for base metal and stress-relieved welds.

    ``S_ar = (max(S_max, 0) - max(S_min, 0) + share (max(-S_min, 0) - max(-S_max, 0))) / 2``

    Examples
    --------
    >>> float(PartCompression().equivalent(100e6, 0.0))  # 100 in tension + 60 in compression
    80000000.0
    """

    share: Number = field(
        "Of the compressive part of a range, 0.6 in the standard",
        least=0,
        most=1,
        wanted="from 0 to 1",
        default=0.6,
    )

    def equivalent(self, amplitude: ArrayLike, mean: ArrayLike) -> Array:
        """Return the equivalent amplitude, Pa; see the class."""
        S_a, S_m = _pair(amplitude, mean)
        high, low = S_m + S_a, S_m - S_a
        tension = np.maximum(high, 0.0) - np.maximum(low, 0.0)
        compression = np.maximum(-low, 0.0) - np.maximum(-high, 0.0)
        return np.asarray(0.5 * (tension + self.share * compression))

    @property
    def law(self) -> tuple[str, dict[str, float]]:
        """Name and parameters of the law; see the class."""
        return "compression", {"share": float(self.share)}
