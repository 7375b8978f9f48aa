"""Rule of a damage meter: S-N curve, mean stress correction, residue, memory and resolution."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.errors import Problems, suggest
from jousto.base.numbers import number
from jousto.materials.strength.mean_stress import MeanStress

RESIDUES = ("half", "repeat", "ignore")
"""Rules for the residue of the rainflow count."""
SHALLOWEST = 6


@dataclass(frozen=True)
class MeterRule:
    """Counting rule of a damage meter, common to all meters that share it.

    Attributes
    ----------
    curve : tuple of five floats
        S_D (Pa, amplitude), N_D, k, slope below the knee, and the amplitude below which there is no
        damage: ``SN.numbers``.
    mean : MeanStress or None
        Mean stress correction.
    residue : str
        One of `RESIDUES`.
    depth : int
        Number of stored turning points.
    resolution : float
        Resolution to which samples are rounded, Pa; 0 for no rounding.
    """

    curve: tuple[float, float, float, float, float]
    mean: MeanStress | None
    residue: str
    depth: int
    resolution: float

    @property
    def correction(self) -> tuple[str, dict[str, float]]:
        """Law of the mean stress correction and its parameters: ``MeanStress.law``."""
        return ("none", {}) if self.mean is None else self.mean.law


def check_residue(problems: Problems, where: str, residue: Any) -> None:
    """Report a problem unless the residue rule exists."""
    if residue not in RESIDUES:
        known = ", ".join(f'"{name}"' for name in RESIDUES)
        problems.add(
            where,
            f"residue is {residue!r}, must be one of {known}{suggest(str(residue), RESIDUES)}",
            "residue",
        )


def meter_rule(
    problems: Problems,
    where: str,
    sn: Any,
    *,
    residue: Any,
    mean: Any = None,
    depth: Any = 64,
    resolution: Any = 0.0,
) -> MeterRule:
    """Return the rule of a meter, or report what is wrong with the arguments.

    Parameters
    ----------
    problems, where
        Collected problems, and prefix of messages.
    sn : SN
        S-N curve.
    residue, mean, depth, resolution
        See `DamageMeter`.
    """
    curve = getattr(sn, "numbers", None)
    if not isinstance(curve, tuple) or len(curve) != 5:
        problems.add(
            where, f"sn is {sn!r}, must be an S-N curve: jo.SN(S_D=.., N_D=.., k=..)", "sn"
        )
        curve = (1.0, 1.0, 1.0, 1.0, 0.0)
    if not isinstance(mean, MeanStress | None):
        problems.add(
            where,
            f"mean is {mean!r}, must be a mean stress correction such as "
            "jo.fatigue.Goodman(S_u=..)",
            "mean",
        )
        mean = None
    check_residue(problems, where, residue)
    if not isinstance(depth, int | np.integer) or isinstance(depth, bool) or depth < SHALLOWEST:
        problems.add(
            where, f"depth is {depth!r}, must be a whole number of at least {SHALLOWEST}", "depth"
        )
        depth = SHALLOWEST
    width = number(problems, where, "resolution", resolution)
    if width is not None and width < 0.0:
        problems.add(where, f"resolution is {width:g} Pa, must be 0 or positive", "resolution")
    S_D, N_D, k, below, cut = map(float, curve)
    return MeterRule(
        (S_D, N_D, k, below, cut),
        mean,
        str(residue),
        int(depth),
        float(width or 0.0),
    )
