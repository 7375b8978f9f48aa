"""BodyAdvice, ReadingAdvice: what readings lose with one body rigid, and the recommendation."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.object_repr import described
from jousto.base.units import shown_unit
from jousto.design.flexibility.expected import RESONANT, RETUNED
from jousto.design.flexibility.reading_loss import ReadingLoss

FLEXIBLE, RIGID = "flexible", "rigid"


@described
@dataclass(frozen=True, eq=False)
class ReadingAdvice:
    """Loss of one reading, measured by a run and estimated from the rigid run.

    Attributes
    ----------
    reading : str
        ``sensor.component``, or ``stress BODY SITE`` for the hot spot of a body.
    unit : str
    measured : ReadingLoss or None
        Loss of the rigid run against the flexible one; None without a flexible run, or if the
        rigid run failed.
    estimate : float
        Upper figure of the largest difference, in the unit of the reading, from the rigid run and
        the elastic body alone; infinite after an impact or if the loads feed its vibration,
        NaN if there is none.
    scale : float
        Range of the reading, to which the estimate refers; without a range its largest value.
    life : float
        Damage of the rigid run / damage of the flexible one; NaN if it is no stress or no S-N curve
        is known.
    recovered : bool
        Whether the reading with the rigid body is that of its static deformation (inertia relief).
    floor : float
        Rounding level of the reading in its unit.
    """

    reading: str
    unit: str
    measured: ReadingLoss | None
    estimate: float
    scale: float
    life: float = float("nan")
    recovered: bool = False
    floor: float = 0.0

    @property
    def share(self) -> float:
        """Measured loss that is compared with the limit; NaN if it was not measured."""
        return float("nan") if self.measured is None else self.measured.share

    @property
    def estimated_share(self) -> float:
        """Estimate / `scale`; 0 if both are zero."""
        if self.scale > 0.0 or np.isnan(self.estimate):
            return self.estimate / self.scale if self.scale else self.estimate
        return float("inf") if self.estimate > 0.0 else 0.0

    @property
    def worst(self) -> float:
        """The larger one of both."""
        return float(np.nanmax([self.share, self.estimated_share, -1.0]))

    @property
    def difference(self) -> float:
        """Largest difference, in the unit of the reading: measured, otherwise estimated."""
        return self.estimate if self.measured is None else self.measured.difference

    def exceeds(self, limit: float, life_limit: float) -> bool:
        """Return whether a loss exceeds its limit."""
        return self.worst > limit or abs(self.life - 1.0) > life_limit

    def within_estimate(self, tolerance: float = 0.2) -> bool | None:
        """Return whether the measured loss exceeds the estimate by at most a tolerance.

        None if one of them is missing.
        """
        if self.measured is None or np.isnan(self.estimate):
            return None
        floor = max(self.floor, 1e-12 * self.scale)
        return bool(self.measured.difference * (1.0 - tolerance) <= self.estimate + floor)


@described
@dataclass(frozen=True, eq=False)
class ModesAdvice:
    """Modes of a body by their energy in the run, and what is lost without the smallest.

    Attributes
    ----------
    energy : (n,) array
        Share of each mode in the strain energy of the body, mean value over the run.
    kept : tuple of int
        Modes that remain, from 0.
    readings : tuple of ReadingAdvice
        Loss in a run with the modes that remain; empty if all remain.
    steps : float
        Steps of this run; NaN if there is none.
    seconds : float
        Its duration, s.
    failed : str
        Reason why this run failed; empty if it did not.
    """

    energy: Array
    kept: tuple[int, ...]
    readings: tuple[ReadingAdvice, ...] = ()
    steps: float = float("nan")
    seconds: float = float("nan")
    failed: str = ""

    @property
    def left_out(self) -> int:
        """Number of modes left out."""
        return len(self.energy) - len(self.kept)


@described
@dataclass(frozen=True, eq=False)
class BodyAdvice:
    """What is lost with one body rigid.

    Attributes
    ----------
    body : str
    readings : tuple of ReadingAdvice
    limit, life_limit : float
        Largest loss of a reading and of the life for "rigid", as shares.
    first : float
        First natural frequency of the body as the joints hold it, Hz; NaN without an estimate.
    highest : float
        Highest frequency of its loads, Hz.
    ratio : float
        ``r = W / w``, both.
    deflection : float
        Largest static displacement of a node under the loads of the rigid run, in the body frame,
        m: d.
    bound : float
        ``1 / (1 - r)``: largest deflection in one smooth stroke / d.
    amplification : float
        Largest vibration / largest static deformation under its loads.
    slower : float
        Period of free motions of the machine with the elastic body / that with the rigid one - 1.
    impact : bool
        Whether a stop was hit or a velocity jumped: a rigid body then loses everything.
    steps, seconds : float
        Steps and duration, s, of the run with the rigid body.
    modes : ModesAdvice or None
    failed : str
        Reason why the run with the rigid body, or the estimate, failed; empty if neither did.
    """

    body: str
    readings: tuple[ReadingAdvice, ...]
    limit: float
    life_limit: float
    first: float = float("nan")
    highest: float = float("nan")
    ratio: float = float("nan")
    deflection: float = float("nan")
    bound: float = float("nan")
    amplification: float = float("nan")
    slower: float = 0.0
    impact: bool = False
    steps: float = float("nan")
    seconds: float = float("nan")
    modes: ModesAdvice | None = None
    failed: str = ""

    @property
    def resonant(self) -> bool:
        """Whether vibration or free motions grow too different for an estimate."""
        return self.amplification >= RESONANT or self.slower >= RETUNED

    @property
    def verdict(self) -> str:
        """Whether the body must be "flexible" or can be "rigid"."""
        lost = any(one.exceeds(self.limit, self.life_limit) for one in self.readings)
        unknown = self.impact or self.resonant or self.idle or not self.readings
        return FLEXIBLE if lost or unknown else RIGID

    @property
    def idle(self) -> bool:
        """Whether no load deforms the body in this run, so that nothing was compared."""
        return self.deflection == 0.0 and not any(one.difference > 0.0 for one in self.readings)

    @property
    def ranked(self) -> list[ReadingAdvice]:
        """Readings, the largest loss first."""
        return sorted(self.readings, key=lambda one: (-one.worst, -np.nan_to_num(one.share)))

    def reasons(self) -> Iterator[str]:
        """Yield the numbers behind the verdict."""
        if self.idle:
            yield "no load deforms it in this run, so that nothing was compared"
            return
        if self.impact:
            yield "a stop is hit or a velocity jumps, and an impact excites all frequencies"
        elif self.resonant:
            yield self._dynamic()
        if not self.readings:
            yield self.failed
            return
        if (self.impact or self.resonant) and not self._measured:
            return
        worst = self.ranked[0]
        if worst.worst > self.limit:
            yield self._loss(worst)
            away = max(self.readings, key=lambda one: one.difference if one.unit == "m" else -1.0)
            notable = away.measured is None or away.worst > self.limit
            if away.unit == "m" and away is not worst and notable:
                yield self._loss(away)
        lives = [one for one in self.readings if abs(one.life - 1.0) > self.life_limit]
        for one in sorted(lives, key=lambda one: -abs(one.life - 1.0))[:1]:
            yield f"the rigid body leaves {one.life:.3g} of the damage of {one.reading}"
        if self.verdict == RIGID:
            limit = percent(self.limit)
            yield f"no reading loses more than {limit} of its range; {self._loss(worst)}"

    def _dynamic(self) -> str:
        grows = f"its vibration grows to {self.amplification:.3g} times the static deformation"
        if self.amplification < RESONANT:
            grows = f"free motions are slower by {percent(self.slower)}"
        elif np.isinf(self.amplification):
            grows = "its first frequency falls to 0 under its loads"
        text = f"not estimable: dynamic, r = {self.ratio:.3g}, {grows}"
        return text if self._measured else f"{text}; run it flexible"

    @property
    def _measured(self) -> bool:
        return any(one.measured is not None for one in self.readings)

    def _loss(self, one: ReadingAdvice) -> str:
        away = shown(one.difference, one.unit)
        if one.measured is None:
            return f"{one.reading} up to {away} elsewhere ({percent(one.estimated_share)})"
        text = f"{one.reading} is up to {away} elsewhere ({percent(one.share)}"
        estimate = one.estimated_share
        if one.share <= self.limit < estimate < np.inf:
            text += f", but the estimate of {percent(estimate)} is above the limit"
        return text + ")"


def percent(share: float) -> str:
    """Return a share as per cent, with three digits."""
    return f"{100.0 * share:.3g} %" if np.isfinite(share) else "everything"


def shown(value: float, unit: str) -> str:
    """Return a value in the unit of tables, with three digits."""
    if not np.isfinite(value):
        return "any distance"
    if unit == "m" and abs(value) < 1.0:
        return f"{1e3 * value:.3g} mm"
    name, factor = shown_unit(unit)
    return f"{factor * value:.3g}" + (f" {name}" if name != "1" else "")
