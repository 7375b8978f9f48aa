"""Damage and remaining life of hot spots during monitoring, with confidence bands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.model.native.damage_meter import DamageMeter

PAUSE = 10.0  # number of usual time steps above which a gap does not count as monitored time


@described
@dataclass(frozen=True, eq=False)
class Life:
    """Accumulated damage, and remaining life at the same rate.

    Attributes
    ----------
    watched : float
        Evaluated time, s, without pauses and without samples that determine no stress.
    damage, damage_low, damage_high : (ns,) array
        Miner's sum with the ends of its band.
    remaining, remaining_low, remaining_high : (ns,) array
        Time until the sum is 1 at the mean rate so far, s; inf without damage.
    """

    watched: float
    damage: Array
    damage_low: Array
    damage_high: Array
    remaining: Array
    remaining_low: Array
    remaining_high: Array


@described
class LifeMeter:
    """Cycle counters of the stress at hot spots: estimate and both ends of the band.

    For the band of damage every peak is moved outward, or inward, by the half width of the stress
    band, and the S-N curve is that of the survival probabilities at the ends of the band if its
    scatter is known. In reality errors that differ from peak to peak average out, so that the band
    is conservative.

    Parameters
    ----------
    sn : SN
        S-N curve.
    ns : int
        Number of hot spots.
    residue : str
        "half", "repeat" or "ignore".
    mean : optional
        Mean stress correction.
    level : float
        Share of the band.
    """

    def __init__(
        self, sn: Any, ns: int, *, residue: str, mean: Any = None, level: float = 0.95
    ) -> None:
        self.residue = residue
        curves = {"value": sn, "low": sn, "high": sn}
        if getattr(sn, "T_S", None) or getattr(sn, "T_N", None):
            # lower damage uses the S-N curve of higher life
            curves["low"] = sn.at_survival(0.5 - 0.5 * level)
            curves["high"] = sn.at_survival(0.5 + 0.5 * level)
        self.meters = {
            name: DamageMeter(curve, residue=residue, mean=mean, n=ns)
            for name, curve in curves.items()
        }
        self.watched = 0.0
        self._time, self._step = np.nan, np.nan
        self._sum, self._number = np.zeros(ns), 0.0  # sum and number of samples since the start
        self._centre = np.zeros(ns)  # mean stress relative to which peaks are counted

    def push(
        self,
        time: Array,
        stress: Array,
        low: Array,
        high: Array,
        seen: NDArray[np.bool_] | None = None,
    ) -> None:
        """Count samples (k, ns), Pa, and skip those outside the mask `seen` (k,)."""
        half = 0.5 * (high - low)
        away = stress - self._centre
        self.meters["value"].push(stress)
        self.meters["high"].push(stress + np.copysign(half, away))
        inner = np.copysign(np.maximum(np.abs(away) - half, 0.0), away)
        self.meters["low"].push(self._centre + inner)
        known = stress if seen is None else stress[seen]
        self._sum += known[0] if len(known) == 1 else known.sum(axis=0)
        self._number += float(len(known))
        if len(time) == 1 and seen is None:
            self._watch_one(float(time[0]))
        else:
            self._watch(time, np.ones(len(time), dtype=bool) if seen is None else seen)

    def _watch_one(self, time: float) -> None:
        step = time - self._time
        if math.isnan(self._step):
            self._step = step
        # no step is counted before the first sample
        if step <= PAUSE * self._step:
            self.watched += step
        self._time = time

    def _watch(self, time: Array, seen: NDArray[np.bool_]) -> None:
        step = np.empty(len(time))
        step[0] = time[0] - self._time
        np.subtract(time[1:], time[:-1], out=step[1:])
        usual = self._step
        if np.isnan(usual) and np.isfinite(step).any():
            usual = float(step[np.isfinite(step)][0])
        good = seen & (step <= (PAUSE * usual if np.isfinite(usual) else np.inf))
        self.watched += float(step[good].sum())
        self._time, self._step = float(time[-1]), float(usual)

    def settle(self) -> None:
        """Move the reference of the peaks to the present mean, at the end of an interval."""
        if self._number:
            self._centre = self._sum / self._number

    def life(self) -> Life:
        """Return the present damage and remaining life."""
        D = {name: np.asarray(m.damage(self.residue)) for name, m in self.meters.items()}
        low, high = np.minimum(D["low"], D["value"]), np.maximum(D["high"], D["value"])

        def remaining(damage: Array) -> Array:
            with np.errstate(divide="ignore", invalid="ignore"):
                left = np.maximum(1.0 - damage, 0.0) * self.watched / damage
            return np.where(damage > 0.0, left, np.inf)

        return Life(
            self.watched,
            D["value"],
            low,
            high,
            remaining(D["value"]),
            remaining(high),
            remaining(low),
        )

    def save(self) -> dict[str, Array]:
        """Return the state as arrays, for `load`."""
        own = np.array([self.watched, self._time, self._step, self._number])
        memory = {"own": own, "sum": self._sum.copy(), "centre": self._centre.copy()}
        return memory | {name: np.asarray(m.save()) for name, m in self.meters.items()}

    def load(self, memory: Mapping[str, Array]) -> None:
        """Restore the state that `save` returned."""
        self.watched, self._time, self._step, self._number = (float(x) for x in memory["own"])
        self._sum, self._centre = np.array(memory["sum"]), np.array(memory["centre"])
        for name, meter in self.meters.items():
            meter.load(memory[name])
