"""Fatigue damage at places without gauge, with confidence bands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.files import Rows, Tabular
from jousto.base.object_repr import described
from jousto.measurement.twin.bands.bands import _check, _select_sites
from jousto.measurement.twin.estimates import Estimates
from jousto.measurement.twin.smoother import sample_posterior, smooth
from jousto.model.native.damage_meter import DamageMeter
from jousto.recovery.fields.criteria import Criterion, evaluate
from jousto.reduction.fields.stress import StressModes
from jousto.reduction.reduced import ReducedPart


@described
@dataclass(frozen=True, eq=False)
class DamageBand(Tabular):
    """Damage and life of sites over a record, with confidence bands.

    Attributes
    ----------
    labels : tuple of str
        Sites.
    damage : (ns,) array
        Median of the damage.
    low, high : (ns,) arrays
        Ends of the band.
    level : float
        Share of the band.
    duration : float
        Length of the record, s.
    residue : str
        Treatment of the residue in the rainflow count.
    criterion : str
        Counted stress criterion.
    """

    labels: tuple[str, ...]
    damage: Array
    low: Array
    high: Array
    level: float
    duration: float
    residue: str
    criterion: str

    @property
    def life(self) -> Array:
        """Median life (ns,), s of repeated operation; inf without damage."""
        return self._lives(self.damage)

    @property
    def life_band(self) -> tuple[Array, Array]:
        """Lower and upper life (ns,), s of repeated operation."""
        return self._lives(self.high), self._lives(self.low)

    def _lives(self, damage: Array) -> Array:
        endless = np.full(len(damage), np.inf)
        return np.asarray(np.divide(self.duration, damage, out=endless, where=damage > 0.0))

    def _csv(self) -> Rows:
        """Return damage and life of every site with their bands."""
        head = [
            *("site", f"damage of {self.duration:g} s ({self.criterion}, residue {self.residue})"),
            *("damage low", "damage high", "life h", "life low h", "life high h"),
        ]
        shortest, longest = self.life_band
        numbers = [self.damage, self.low, self.high]
        numbers += [x / 3600.0 for x in (self.life, shortest, longest)]
        table = zip(self.labels, *numbers, strict=True)
        return head, ([row[0], *(f"{x:.6g}" for x in row[1:])] for row in table)

    def __str__(self) -> str:
        width = max(4, *(len(label) for label in self.labels))
        shortest, longest = self.life_band
        lines = [
            f"{self.criterion}, residue {self.residue}, {self.duration:g} s, "
            f"{100 * self.level:g} % band",
            f"{'site':<{width}}     damage       low        high   life (h)      from        to",
        ]
        for i, label in enumerate(self.labels):
            lines.append(
                f"{label:<{width}}  {self.damage[i]:9.3e} {self.low[i]:9.3e} {self.high[i]:9.3e}  "
                f"{self.life[i] / 3600:9.3g} {shortest[i] / 3600:9.3g} {longest[i] / 3600:9.3g}"
            )
        return "\n".join(lines)


@explained
def damage_band(
    observed: Estimates,
    modes: StressModes | ReducedPart,
    sn: Any,
    *,
    residue: str,
    sites: Sequence[str] | str | None = None,
    criterion: Criterion = "signed-von-mises",
    mean: Any = None,
    level: float = 0.95,
    scale: float = 0.005,
    draws: int = 60,
    seed: int = 1,
) -> DamageBand:
    """Return fatigue damage of sites with its band, from sampled histories of the record.

    Stress histories are drawn from their distribution (`sample_posterior`) and counted by rainflow;
    the band consists of quantiles of their damage. The model error changes slowly and is drawn once
    for each site, as is a proportional error, whose effect on damage is k times that on stress.
    Gauge errors (``Observer(errors=)``) are drawn once for each history. A drawn history is rougher
    than the truth by the noise of the estimate, so that its damage is conservative; the smoothed
    history alone underestimates damage: the band starts no higher than its value.

    Parameters
    ----------
    observed : Estimates
        Estimates from `Observer.run`.
    modes : StressModes or ReducedPart
        Stress of the same modes.
    sn : SN
        S-N curve.
    residue : {"half", "repeat", "ignore"}
        Treatment of the residue in the rainflow count.
    sites, criterion, level
        As for `stress_band`.
    mean : mean stress correction, optional
        Mean-stress correction as in `DamageMeter`.
    scale : float
        Relative standard deviation of errors proportional to stress: about 0.5 % for gauge factors,
        1 to 2 % for Young's modulus of steel.
    draws, seed : int
        Number of histories, and seed of the random numbers.

    Raises
    ------
    InputError
        As for `stress_band`, and for fewer than 20 draws.
    """
    if not isinstance(observed, Estimates):
        raise InputError(
            Problem(
                "damage_band",
                f"observed is of type {type(observed).__name__}, must be from Observer.run: "
                "histories are drawn from the motion between the instants, which a "
                "Reconstruction does not estimate; use stress_band for it",
            )
        )
    labels, S, missed = _select_sites(observed, modes, sites)
    _check(criterion, level)
    if not 0.0 <= scale < 0.5:
        raise InputError(
            Problem("damage_band", f"scale is {scale!r}, must be a share such as 0.01")
        )
    if draws < 20:
        raise InputError(Problem("damage_band", f"{draws} draws, must be 20 or more"))
    smoothed = observed if observed.smoothed else smooth(observed)
    histories = sample_posterior(smoothed, draws, seed=seed)
    rng = np.random.default_rng(seed + 1)
    damage = np.empty((draws, len(labels)))
    moved = smoothed.moved
    for i in range(draws):
        p = histories.p[:, :, i]
        if moved is not None:
            p = p + moved @ rng.standard_normal(moved.shape[2])
        s = np.einsum("tj,scj->tsc", p, S, optimize=True)
        s *= 1.0 + scale * rng.standard_normal((len(labels), 1))
        s += missed * rng.standard_normal(missed.shape)
        damage[i] = _count(evaluate(s, criterion), sn, residue, mean)
    s = np.einsum("tj,scj->tsc", smoothed.p, S, optimize=True)
    calm = _count(evaluate(s, criterion), sn, residue, mean)
    low, middle, high = np.quantile(damage, [0.5 - 0.5 * level, 0.5, 0.5 + 0.5 * level], axis=0)
    time = observed.time
    step = (time[-1] - time[0]) / max(len(time) - 1, 1)
    return DamageBand(
        labels,
        middle,
        np.minimum(low, calm),
        high,
        level,
        float(len(time) * step),
        residue,
        str(criterion),
    )


def _count(values: Array, sn: Any, residue: str, mean: Any) -> Array:
    meter = DamageMeter(sn, residue=residue, mean=mean, n=values.shape[1])
    meter.push(np.ascontiguousarray(values))
    return np.asarray(meter.damage())
