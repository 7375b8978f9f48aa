"""What a damage meter needs to know: curve, mean stress, residue and how much it remembers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.errors import Problems, suggest
from jousto.base.numbers import number
from jousto.materials.strength.mean_stress import MeanStress

RESIDUES = ("half", "repeat", "ignore")
"""How what the rainflow count leaves over is counted."""
SHALLOWEST = 6


@dataclass(frozen=True)
class MeterRule:
    """How a damage meter counts; the same for all that share it.

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
        Turning points that are remembered.
    resolution : float
        Samples are rounded to multiples of it, Pa; 0 takes them as they are.
    """

    curve: tuple[float, float, float, float, float]
    mean: MeanStress | None
    residue: str
    depth: int
    resolution: float

    @property
    def correction(self) -> tuple[str, dict[str, float]]:
        """The law of the mean stress correction and its values: ``MeanStress.law``."""
        return ("none", {}) if self.mean is None else self.mean.law


def check_residue(problems: Problems, where: str, residue: Any) -> None:
    """Note a problem unless the residue rule is known."""
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
    """Return the rule of a meter and note what is wrong with it.

    Parameters
    ----------
    problems, where
        As everywhere.
    sn : SN
        S-N curve.
    residue, mean, depth, resolution
        As of `DamageMeter`.
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
            where, f"depth is {depth!r}, must be a whole number from {SHALLOWEST} on", "depth"
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
