"""S-N curves of welds by FAT class (IIW) or detail category (EN 1993-1-9), for stress ranges."""

from __future__ import annotations

from typing import Any

from jousto.base.declare import Declared, maker
from jousto.base.errors import Problems, suggest
from jousto.base.fields import Choice, Flag, field
from jousto.base.numbers import Number, OptionalNumber, Positive
from jousto.materials.strength.sn import SN

STANDARDS = ("iiw", "en")
CLASSES = (
    *(12, 14, 16, 18, 20, 22, 25, 28, 32, 36, 40, 45, 50, 56, 63, 71),
    *(80, 90, 100, 112, 125, 140, 160),
)
"""Classes of direct stress in both standards: IIW 12 to 71 for aluminium, from 36 for steel."""
SHEAR_CLASSES = (28, 36, 80, 100)
"""Classes of shear stress: aluminium (IIW), steel."""
_EN = "EN 1993-1-9:2005, 7.1"
_IIW = "IIW-2259-15 (Hobbacher, Recommendations for fatigue design of welded joints, 2016), 3.2"

EXPONENTS = {
    "cruciform": 0.3,
    "cruciform-ground": 0.2,
    "butt": 0.2,
    "butt-flush": 0.1,
    "longitudinal": 0.1,
}
"""Thickness exponents of IIW-2259-15, 3.5.2: joints across the load as welded or with ground toes,
butt welds, butt welds ground flush, and base metal or attachments along the load."""


class Standard(Choice):
    """Field of the standard that defines the FAT classes."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the standard, or report an unknown one."""
        if value not in self.words:
            known = suggest(value, self.words)
            problems.add(where, f"standard is {value!r}, must be iiw or en{known}", "standard")
        return value


class FatClass(Declared):
    """S-N curve of a weld by its FAT class: the stress range in MPa at 2e6 cycles.

    ========  ======  =====================================================================
    standard  stress  curve
    ========  ======  =====================================================================
    iiw       direct  slope 3 to 1e7 cycles, then 5, under constant amplitude 22
    iiw       shear   slope 5 to 1e8 cycles, then 9, under constant amplitude 22
    en        direct  slope 3 to 5e6 (0.737 of the class), 5 to 1e8 (0.405), nothing below;
                      under constant amplitude nothing below 5e6
    en        shear   slope 5 to 1e8 (0.457), nothing below
    ========  ======  =====================================================================

    IIW-2259-15, 3.2 and 4.3.1; EN 1993-1-9:2005, 7.1. The curves apply to the nominal (or
    structural hot-spot) stress **range**; `SN` contains amplitudes, half of the range. They include
    the effect of residual stress, so that mean stress has no effect (``R`` is None).

    Raises
    ------
    InputError
        If the class is out of range, or the standard is unknown.

    Examples
    --------
    >>> weld = fat_class(71, "en")
    >>> round(float(weld.cycles(71e6 / 2))), round(2 * weld.S_D / 1e6, 2)
    (2000000, 52.31)
    """

    kind = "fat_class"
    fat: Number = field(
        "Class, a number such as 71 (MPa)",
        least=5,
        most=250,
        wanted="a class from 5 to 250, a range in MPa at 2e6 cycles such as 71",
    )
    standard: Standard = field("IIW or Eurocode 3", words=STANDARDS, default="iiw")
    shear: Flag = field(
        "Whether the class is one of shear stress (80 or 100)", default=False, kw_only=True
    )
    constant: Flag = field(
        "Whether the load has constant amplitude, for which the knee is an endurance limit; not"
        " for histories with different cycles",
        default=False,
        kw_only=True,
    )
    factor: Positive = field(
        "Factors of the stress: `thickness_factor`, 1/gamma_Mf (partial factor, EN 1993-1-9 "
        "table 3.1) ...",
        file=False,
        default=1.0,
        kw_only=True,
    )
    T_N: OptionalNumber = field(
        "Scatter band in cycles, for other probabilities of survival than that of the class: 0.977 "
        "(IIW), 0.95 (EN)",
        default=None,
        kw_only=True,
    )

    @property
    def made(self) -> SN:
        """The S-N curve."""
        kind = "shear " if self.shear else ""
        scaled = "" if self.factor == 1.0 else f" x {self.factor:.4g}"
        name = f"FAT {self.fat:g} {kind}{self.standard}{scaled}"
        about: dict[str, Any] = {"R": None, "T_N": self.T_N, "name": name}
        half = 0.5e6 * self.fat * self.factor
        if self.standard == "en":
            about |= {"survival": 0.95, "source": _EN}
            k, N_D = (5.0, 1e8) if self.shear else (3.0, 5e6)
            S_D = half * (2e6 / N_D) ** (1.0 / k)
            if self.shear or self.constant:
                return SN(S_D, N_D, k, "original", **about)
            return SN(S_D, N_D, k, "haibach", k2=5.0, N_cut=1e8, **about)
        about |= {"survival": 0.977, "source": _IIW}
        k, N_D = (5.0, 1e8) if self.shear else (3.0, 1e7)
        k2 = 22.0 if self.constant else 2.0 * k - 1.0
        return SN(half * (2e6 / N_D) ** (1.0 / k), N_D, k, "haibach", k2=k2, **about)


fat_class = maker("fat_class", FatClass, returns="SN")


def thickness_factor(
    thickness: float, joint: str | float = "cruciform", *, reference: float = 0.025
) -> float:
    """Return the FAT class factor of thick plates, ``(t_ref / t)^n``, 1 for thin ones.

    IIW-2259-15, 3.5.2; EN 1993-1-9 has ``(25 mm / t)^0.2`` for butt welds across the load (table
    8.3) and ``(30 mm / d)^0.25`` for bolts in tension (7.2.2): ``joint=0.25, reference=0.03``.

    Parameters
    ----------
    thickness : float
        Plate thickness, m.
    joint : str or float
        One of `EXPONENTS`: "cruciform" (0.3), "cruciform-ground" (0.2), "butt" (0.2),
        "butt-flush" (0.1), "longitudinal" (0.1); or the exponent n itself.
    reference : float
        Thickness of the tests, m.

    Raises
    ------
    InputError
        If the joint is unknown or a thickness impossible.

    Examples
    --------
    >>> round(thickness_factor(0.050, "cruciform"), 4), thickness_factor(0.012)
    (0.8123, 1.0)
    """
    where = "thickness_factor"
    problems = Problems()
    size = "a positive number below 2 (SI: 0.025 is 25 mm)"
    problems.number(where, "thickness", thickness, "m", size, lambda x: 0.0 < x < 2.0)
    problems.number(where, "reference", reference, "m", size, lambda x: 0.0 < x < 2.0)
    if isinstance(joint, str):
        if joint not in EXPONENTS:
            problems.add(where, f"no joint {joint!r}{suggest(joint, EXPONENTS)}")
    else:
        problems.number(where, "exponent", joint, "", "from 0 to 1", lambda x: 0.0 <= x <= 1.0)
    problems.raise_if_any()
    n = EXPONENTS[joint] if isinstance(joint, str) else float(joint)
    return float(min(1.0, (reference / thickness) ** n))
