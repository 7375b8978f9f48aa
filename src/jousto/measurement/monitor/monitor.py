"""Monitor: stress at hot spots, damage, remaining life and alarms from strains."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems
from jousto.base.object_repr import described
from jousto.measurement.monitor.alarms import Alarm, AlarmLimits, Alarms
from jousto.measurement.monitor.health import OK, Change, ChannelRules, Health
from jousto.measurement.monitor.life import Life, LifeMeter
from jousto.measurement.monitor.streaming_reconstruction import Estimator, estimator_of
from jousto.measurement.twin.bands.bands import stress_band
from jousto.measurement.twin.bands.spot_band import SpotBand
from jousto.measurement.twin.estimates import Posterior
from jousto.measurement.twin.observer import Observer
from jousto.measurement.twin.reconstruction import Reconstruction
from jousto.reduction.fields.stress import StressModes
from jousto.reduction.reduced import ReducedPart


@dataclass(frozen=True, eq=False)
class Summary:
    """Values at the end of an interval.

    Attributes
    ----------
    time : float
        Last instant of the interval, s.
    samples, blind : int
        Number of instants in the interval, and of those with too few valid channels.
    peak : (ns,) array
        Largest magnitude of the stress at each hot spot in the interval, Pa; nan if blind.
    life : Life or None
        Damage and remaining life, if there is an S-N curve.
    """

    time: float
    samples: int
    blind: int
    peak: Array
    life: Life | None


@dataclass(frozen=True, eq=False)
class Update:
    """Results of a block of samples.

    Attributes
    ----------
    time : (k,) array
        s.
    states : (k, nc) uint8 array
        States of the channels, numbers of `STATES`.
    stress, low, high : (k, ns) array
        Stress at the hot spots with its band, Pa; nan with too few valid channels.
    changes : tuple of Change
        Channels that changed their state.
    alarms : tuple of Alarm
        Alarms that began or ended.
    summaries : tuple of Summary
        Summaries of intervals that ended.
    """

    time: Array
    states: NDArray[np.uint8]
    stress: Array
    low: Array
    high: Array
    changes: tuple[Change, ...]
    alarms: tuple[Alarm, ...]
    summaries: tuple[Summary, ...]


@explained
@described
class Monitor:
    """Monitoring of the stress of a part by its gauges.

    Each sample passes the check of its channels; channels that are not "ok" are left out. The twin
    (`Reconstruction` or `Observer`) estimates modal coordinates from the others; these give the
    stress at the hot spots with its band, whose cycles a damage meter of fixed memory counts.

    Parameters
    ----------
    twin : Reconstruction or Observer
        Estimator of modal coordinates; its channels are those of the samples, in their order.
    modes : StressModes or ReducedPart
        Stress of the same modes.
    spots : sequence of str
        Stress sites to watch.
    criterion : str
        Stress criterion, such as "signed-von-mises"; see `stress_band`.
    sn : SN, optional
        S-N curve; without it there is no damage and no life.
    residue : str
        Treatment of open cycles: "half", "repeat" or "ignore".
    mean : mean stress correction, optional
        Mean-stress correction such as ``Goodman(S_u)``.
    limits : AlarmLimits, optional
        Alarm limits.
    rules : ChannelRules, optional
        Rules for valid values of channels.
    level : float
        Share of the bands.
    every : float
        Time between summaries, s.
    scale : float
        Relative error common to all stresses, of modulus and gauge factor, as in `stress_band`;
        errors of single gauges belong to the twin (``errors=gauge_errors(..)``).

    Raises
    ------
    InputError
        With all inconsistent arguments.
    """

    def __init__(
        self,
        twin: Reconstruction | Observer,
        modes: StressModes | ReducedPart,
        spots: Sequence[str],
        *,
        criterion: str = "signed-von-mises",
        sn: Any = None,
        residue: str = "half",
        mean: Any = None,
        limits: AlarmLimits | None = None,
        rules: ChannelRules | None = None,
        level: float = 0.95,
        every: float = 1.0,
        scale: float = 0.0,
    ) -> None:
        problems = Problems()
        where = "Monitor"
        self.estimator: Estimator = estimator_of(twin)
        known = modes.stress if isinstance(modes, ReducedPart) else modes
        if known is None:
            raise InputError(Problem(where, "the part has no stress data; use part.with_stress"))
        spots = (spots,) if isinstance(spots, str) else tuple(spots)
        if not spots:
            problems.add(where, "no hot spot is named; spots are labels of stress sites")
        if len(set(spots)) != len(spots):
            problems.add(where, "a hot spot is named twice")
        problems.positive(where, "every", every, "s")
        limits = limits or AlarmLimits()
        if sn is None:
            for name in ("damage", "life"):
                if getattr(limits, name) is not None:
                    problems.add(where, f"a limit of {name} needs an S-N curve, sn=")
        problems.raise_if_any()
        missing = [spot for spot in spots if spot not in known.labels]
        if missing:
            # raises InputError with the names of the missing data
            stress_band(_nothing(known), known, criterion, sites=missing)
        place = {label: i for i, label in enumerate(known.labels)}
        at = [place[s] for s in spots]
        self.modes = StressModes(
            spots,
            known.positions[at],
            known.axes[at],
            known.modes[at],
            known.elasticity if known.elasticity is None else known.elasticity[at],
        )
        stress_band(_nothing(self.modes), self.modes, criterion, level=level, scale=scale)
        self.band = SpotBand(
            self.modes, criterion, float(level), float(scale), self.estimator.missed
        )
        self.channels = self.estimator.names
        self.spots = spots
        self.criterion = criterion
        self.level = float(level)
        self.every = float(every)
        self.limits = limits
        self.rules = rules or ChannelRules()
        self.residue = residue
        self.sn = sn
        self.health = Health(self.channels, self.rules)
        self.alarms = Alarms(limits, spots)
        self.meter = (
            LifeMeter(sn, len(spots), residue=residue, mean=mean, level=level) if sn else None
        )
        self._time = np.nan  # time of the last sample, s
        self._interval = np.nan  # index of the present interval
        self._origin = np.nan
        self._samples, self._blind = 0, 0
        self._peak = np.full(len(spots), np.nan)

    # -- samples ----------------------------------------------------------------------------------

    def push(self, time: ArrayLike, strain: ArrayLike, cells: Any = None) -> Update:
        """Process samples and return stress, alarms, changes of state and summaries.

        Parameters
        ----------
        time : (k,) array_like
            s, increasing.
        strain : (k, nc) array_like
            m/m, in the order of `channels`; nan where there is no value.
        cells : (k, nc) uint8 array, optional
            Reason of each missing value (`stream`).

        Raises
        ------
        InputError
            For wrong shapes, or time that does not increase.
        """
        t = np.asarray(time, dtype=np.float64)
        if t.ndim != 1:
            t = t.reshape(-1)
        if not len(t):
            states, stress = (
                np.zeros((0, len(self.channels)), np.uint8),
                np.zeros((0, len(self.spots))),
            )
            return Update(t, states, stress, stress, stress, (), (), ())
        e = np.asarray(strain, dtype=np.float64)
        if e.ndim != 2 or len(e) != len(t):
            e = e.reshape(len(t), -1)
        if e.shape[1] != len(self.channels) or not self._increases(t):
            self._refuse(t, e)
        states, changes = self.health.check(t, e, cells)
        whole = not np.count_nonzero(states)
        p = self.estimator.estimate(t, e if whole else np.where(states == OK, e, np.nan))
        stress, low, high = self._stress(p)
        size = np.abs(stress)
        alarms = self.alarms.stress(t, size)
        alarms += self.alarms.channels(t, states)
        summaries: list[Summary] = []
        for part in self._intervals(t):
            number = self._number(float(t[part.start]))
            if number != self._interval:
                summaries += self._end(alarms)
                self._interval = number
            self._count(t[part], stress[part], low[part], high[part], size[part])
        if len(alarms) > 1:
            alarms.sort(key=lambda alarm: alarm.time)
        return Update(t, states, stress, low, high, tuple(changes), tuple(alarms), tuple(summaries))

    def _increases(self, t: Array) -> bool:
        """Return whether times increase (fast path for one sample)."""
        first, last = float(t[0]), float(t[-1])
        if not (math.isfinite(first) and math.isfinite(last)) or first <= self._time:
            return False
        return len(t) == 1 or bool((t[1:] > t[:-1]).all())

    def _refuse(self, t: Array, e: Array) -> None:
        problems = Problems()
        if e.shape[1] != len(self.channels):
            problems.add(
                "Monitor.push",
                f"{e.shape[1]} channels, must be {len(self.channels)}: {', '.join(self.channels)}",
            )
        if not self._increases(t):
            problems.add("Monitor.push", "time must increase from sample to sample")
        problems.raise_if_any()

    def _stress(self, p: Posterior) -> tuple[Array, ...]:
        """Return stress, low and high (k, ns) of the hot spots; nan without an estimate."""
        moved = p.deviations(slice(None))
        known = np.isfinite(p.p)
        if len(p.covariances) == 1 and np.count_nonzero(known) == known.size:
            return self.band(p.p, p.covariances[0], moved)
        found = tuple(np.full((len(p), len(self.spots)), np.nan) for _ in range(3))
        whole = known.all(axis=1)
        for m, P in enumerate(p.covariances):
            rows = whole & (p.which == m)
            if rows.any():
                own = None if moved is None else moved[rows]
                for all_, part in zip(found, self.band(p.p[rows], P, own), strict=True):
                    all_[rows] = part
        return found

    def finish(self) -> tuple[tuple[Alarm, ...], tuple[Summary, ...]]:
        """Return the alarms and the summary of the unfinished interval."""
        alarms: list[Alarm] = []
        summaries = tuple(self._end(alarms))
        return tuple(alarms), summaries

    @property
    def life(self) -> Life | None:
        """Present damage and remaining life."""
        return None if self.meter is None else self.meter.life()

    def _number(self, t: float) -> float:
        return float(math.floor((t - self._origin) / self.every + 1e-9))

    def _intervals(self, t: Array) -> list[slice]:
        if not len(t):
            return []
        if np.isnan(self._origin):
            self._origin, self._interval = float(t[0]), 0.0
        if self._number(float(t[-1])) == self._interval:
            return [slice(0, len(t))]
        number = np.floor((t - self._origin) / self.every + 1e-9)
        cuts = [0, *(np.flatnonzero(np.diff(number)) + 1).tolist(), len(t)]
        return [slice(a, b) for a, b in zip(cuts[:-1], cuts[1:], strict=True)]

    def _count(self, t: Array, stress: Array, low: Array, high: Array, size: Array) -> None:
        good = np.isfinite(stress)
        seen = None
        if np.count_nonzero(good) != good.size:
            seen = np.asarray(good.all(axis=1))
            size = size[seen]
            self._blind += len(t) - len(size)
        self._samples += len(t)
        if len(size):
            self._peak = np.fmax(self._peak, size[0] if len(size) == 1 else size.max(axis=0))
        if self.meter is not None:
            self.meter.push(t, stress, low, high, seen)
        self._time = float(t[-1])

    def _end(self, alarms: list[Alarm]) -> list[Summary]:
        """Finish the present interval, if it contains samples."""
        if not self._samples:
            return []
        life = None
        if self.meter is not None:
            self.meter.settle()
            life = self.meter.life()
            alarms += self.alarms.summary(self._time, life.damage, life.remaining_low)
        found = Summary(self._time, self._samples, self._blind, self._peak, life)
        self._samples, self._blind = 0, 0
        self._peak = np.full(len(self.spots), np.nan)
        return [found]

    # -- memory -----------------------------------------------------------------------------------

    def save(self) -> dict[str, Array]:
        """Return the state as arrays, for `load`."""
        own = [self._time, self._interval, self._origin, float(self._samples), float(self._blind)]
        memory = {
            "monitor": np.array(own),
            "peak": self._peak,
            "health": self.health.save(),
            "alarms": self.alarms.save(),
        }
        if self.meter is not None:
            memory |= {f"meter.{name}": x for name, x in self.meter.save().items()}
        return memory | {f"twin.{name}": x for name, x in self.estimator.save().items()}

    def load(self, memory: Mapping[str, Array]) -> None:
        """Restore the state that `save` returned."""
        own = memory["monitor"]
        self._time, self._interval, self._origin = (float(x) for x in own[:3])
        self._samples, self._blind = int(own[3]), int(own[4])
        self._peak = np.array(memory["peak"])
        self.health.load(memory["health"])
        self.alarms.load(memory["alarms"])
        if self.meter is not None:
            self.meter.load(_part(memory, "meter."))
        self.estimator.load(_part(memory, "twin."))


def _part(memory: Mapping[str, Array], start: str) -> dict[str, Array]:
    return {name[len(start) :]: x for name, x in memory.items() if name.startswith(start)}


def _nothing(modes: StressModes) -> Posterior:
    """Return an estimate without instants, for the check of names."""
    n = modes.modes.shape[2]
    return Posterior(np.zeros(0), np.zeros((0, n)), np.zeros((1, n, n)), np.zeros(0, dtype=np.intp))
