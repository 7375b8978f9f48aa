"""The monitor: strains in, stress at hot spots, damage, remaining life and alarms out."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.described import described
from jousto.errors import InputError, Problem, Problems
from jousto.recovery.monitor.alarms import Alarm, AlarmLimits, Alarms
from jousto.recovery.monitor.estimate import Estimator, estimator_of
from jousto.recovery.monitor.health import OK, Change, ChannelRules, Health
from jousto.recovery.monitor.life import Life, LifeMeter
from jousto.recovery.twin import Observer, Reconstruction, stress_band
from jousto.recovery.twin.bands import SpotBand
from jousto.recovery.twin.posterior import Posterior
from jousto.reduction import ReducedPart, StressModes

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Summary:
    """What is known at the end of an interval.

    Attributes
    ----------
    time : float
        Last instant of the interval, s.
    samples, blind : int
        Instants of the interval, and those at which too few channels were left.
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
    """What a block of samples told.

    Attributes
    ----------
    time : (k,) array
        s.
    states : (k, nc) uint8 array
        States of the channels, numbers of `STATES`.
    stress, low, high : (k, ns) array
        At the hot spots with the band, Pa; nan where too few channels were left.
    changes : tuple of Change
        Channels that changed their state.
    alarms : tuple of Alarm
        That began or ended.
    summaries : tuple of Summary
        Of intervals that ended.
    """

    time: Array
    states: NDArray[np.uint8]
    stress: Array
    low: Array
    high: Array
    changes: tuple[Change, ...]
    alarms: tuple[Alarm, ...]
    summaries: tuple[Summary, ...]


@described
class Monitor:
    """Watches the stress of a part by its gauges.

    Each sample goes through the health of its channels; those that are not "ok" are left out. The
    twin (`Reconstruction` or `Observer`) makes modal coordinates of the others, from which the
    stress at the hot spots follows with its band; a damage meter of fixed memory counts its cycles.

    Parameters
    ----------
    twin : Reconstruction or Observer
        From strains to modal coordinates; its channels are those of the samples, in their order.
    modes : StressModes or ReducedPart
        Stress of the same modes.
    spots : sequence of str
        Stress sites to watch.
    criterion : str
        Of the stress, such as "signed-von-mises"; see `stress_band`.
    sn : SN, optional
        S-N curve; without it there is no damage and no life.
    residue : str
        What open cycles count: "half", "repeat" or "ignore".
    mean : mean stress correction, optional
        Such as ``Goodman(S_u)``.
    limits : AlarmLimits, optional
        What raises an alarm.
    rules : ChannelRules, optional
        When a channel is not believed.
    level : float
        Share of the bands.
    every : float
        Time between summaries, s.

    Raises
    ------
    InputError
        With everything that does not fit together.
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
    ) -> None:
        problems = Problems()
        where = "Monitor"
        self.estimator: Estimator = estimator_of(twin)
        known = modes.stress if isinstance(modes, ReducedPart) else modes
        if known is None:
            raise InputError(Problem(where, "the part knows no stress; use part.with_stress"))
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
            stress_band(_nothing(known), known, criterion, sites=missing)  # says which and why
        place = {label: i for i, label in enumerate(known.labels)}
        self.modes = StressModes(
            spots,
            known.positions[[place[s] for s in spots]],
            known.axes[[place[s] for s in spots]],
            known.modes[[place[s] for s in spots]],
        )
        stress_band(_nothing(self.modes), self.modes, criterion, level=level)
        self._band = SpotBand(self.modes, criterion, float(level))
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
        self._time = np.nan  # of the last sample
        self._interval = np.nan  # number of the present interval
        self._origin = np.nan
        self._samples, self._blind = 0, 0
        self._peak = np.full(len(spots), np.nan)

    # -- samples ----------------------------------------------------------------------------------

    def push(self, time: ArrayLike, strain: ArrayLike, cells: Any = None) -> Update:
        """Take samples and return what they told.

        Parameters
        ----------
        time : (k,) array_like
            s, increasing.
        strain : (k, nc) array_like
            m/m, in the order of `channels`; nan where there is no value.
        cells : (k, nc) uint8 array, optional
            Why there is no value (`stream`).

        Raises
        ------
        InputError
            Shapes that do not fit, time that does not increase.
        """
        t = np.atleast_1d(np.asarray(time, dtype=np.float64))
        if not len(t):
            states, stress = (
                np.zeros((0, len(self.channels)), np.uint8),
                np.zeros((0, len(self.spots))),
            )
            return Update(t, states, stress, stress, stress, (), (), ())
        e = np.asarray(strain, dtype=np.float64).reshape(len(t), -1)
        problems = Problems()
        if e.shape[1] != len(self.channels):
            problems.add(
                "Monitor.push",
                f"{e.shape[1]} channels, must be {len(self.channels)}: {', '.join(self.channels)}",
            )
        if t[0] <= self._time or not np.isfinite(t).all() or (t[1:] <= t[:-1]).any():
            problems.add("Monitor.push", "time must increase from sample to sample")
        problems.raise_if_any()
        states, changes = self.health.check(t, e, cells)
        p = self.estimator.estimate(t, np.where(states == OK, e, np.nan))
        stress, low, high = (np.full((len(t), len(self.spots)), np.nan) for _ in range(3))
        told = np.isfinite(p.p).all(axis=1)
        for m, P in enumerate(p.covariances):
            rows = told & (p.which == m)
            if rows.any():
                stress[rows], low[rows], high[rows] = self._band(p.p[rows], P)
        alarms = self.alarms.stress(t, np.abs(stress))
        alarms += self.alarms.channels(t, (states == OK).sum(axis=1))
        summaries: list[Summary] = []
        for part in self._intervals(t):
            number = self._number(float(t[part.start]))
            if number != self._interval:
                summaries += self._end(alarms)
                self._interval = number
            self._count(t[part], stress[part], low[part], high[part])
        alarms.sort(key=lambda alarm: alarm.time)
        return Update(t, states, stress, low, high, tuple(changes), tuple(alarms), tuple(summaries))

    def finish(self) -> tuple[tuple[Alarm, ...], tuple[Summary, ...]]:
        """Return the alarms and the summary of the interval that is not over yet."""
        alarms: list[Alarm] = []
        summaries = tuple(self._end(alarms))
        return tuple(alarms), summaries

    @property
    def life(self) -> Life | None:
        """Damage and remaining life now."""
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

    def _count(self, t: Array, stress: Array, low: Array, high: Array) -> None:
        seen = np.isfinite(stress).all(axis=1)
        self._samples += len(t)
        self._blind += int(len(t) - seen.sum())
        if seen.any():
            self._peak = np.fmax(self._peak, np.abs(stress[seen]).max(axis=0))
        if self.meter is not None:
            self.meter.push(t, stress, low, high)
        self._time = float(t[-1])

    def _end(self, alarms: list[Alarm]) -> list[Summary]:
        """Close the present interval, if it holds anything."""
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
        """Return all that is remembered as numbers, for `load`."""
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
        """Go on from what `save` returned."""
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
    """Return an estimate without instants, to have names checked."""
    n = modes.modes.shape[2]
    return Posterior(np.zeros(0), np.zeros((0, n)), np.zeros((1, n, n)), np.zeros(0, dtype=np.intp))
