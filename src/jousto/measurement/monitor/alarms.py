"""Alarm limits, and the alarms that begin and end at them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, OptionalPositive, OptionalWhole
from jousto.base.object_repr import described
from jousto.measurement.monitor.health import OK

NEVER = -np.inf


class AlarmLimits(Declared, by_value=True):
    """Limits on stress, damage, life and channels from which an alarm begins."""

    stress: OptionalPositive = field(
        "Stress: alarm if its magnitude at a hot spot exceeds this value", unit="Pa", default=None
    )
    damage: OptionalPositive = field(
        "Damage: alarm if Miner's sum at a hot spot exceeds this value, such as 0.5",
        unit="1",
        default=None,
    )
    life: OptionalPositive = field(
        "Remaining life: alarm if the lower end of its band is below this value",
        unit="s",
        default=None,
    )
    channels: OptionalWhole = field(
        'Valid channels: alarm if fewer are "ok"', least=0, default=None
    )
    release: Number = field(
        "Fraction of the stress limit below which an alarm ends",
        least=0,
        most=1,
        wanted="a share from 0 to 1",
        default=0.9,
    )
    hold: Number = field(
        "Time for which the stress must stay below that fraction before the alarm ends",
        unit="s",
        least=0,
        wanted="0 or positive",
        default=5.0,
    )

    def consistent(self, problems: Problems, where: str) -> None:
        """Add a problem for a stress limit that is probably in MPa."""
        if self.stress is not None and self.stress < 1e4:
            problems.add(
                where, f"stress is {self.stress:g} Pa, which is far too small; was it meant in MPa?"
            )


@dataclass(frozen=True)
class Alarm:
    """Beginning or end of an alarm.

    Attributes
    ----------
    time : float
        s.
    kind : str
        "stress", "damage", "life" or "channels".
    place : str
        Hot spot, or empty.
    on : bool
        Whether the alarm begins (else it ends).
    value, limit : float
        Value and limit in SI.
    """

    time: float
    kind: str
    place: str
    on: bool
    value: float
    limit: float


@described
class Alarms:
    """Comparison of values with limits, sample by sample.

    Parameters
    ----------
    limits : AlarmLimits
        Alarm limits.
    places : sequence of str
        Hot spots.
    """

    def __init__(self, limits: AlarmLimits, places: Sequence[str]) -> None:
        self.limits = limits
        self.places = tuple(places)
        ns = len(self.places)
        self._on = {kind: np.zeros(ns, dtype=bool) for kind in ("stress", "damage", "life")}
        self._on["channels"] = np.zeros(1, dtype=bool)
        # time of the last sample with the stress above the release level
        self._above = np.full(ns, NEVER)
        self._short = np.full(1, NEVER)  # time of the last sample with missing channels

    @property
    def active(self) -> tuple[tuple[str, str], ...]:
        """Kind and place of the active alarms."""
        return tuple(
            (kind, "" if kind == "channels" else self.places[k])
            for kind, on in self._on.items()
            for k in np.flatnonzero(on)
        )

    def save(self) -> Array:
        """Return the state as arrays, for `load`."""
        return np.concatenate(
            [*(on.astype(float) for on in self._on.values()), self._above, self._short]
        )

    def load(self, memory: Array) -> None:
        """Restore the state that `save` returned."""
        at = 0
        for kind, on in self._on.items():
            self._on[kind] = memory[at : at + len(on)] > 0.5
            at += len(on)
        self._above = np.array(memory[at : at + len(self._above)])
        self._short = np.array(memory[at + len(self._above) :])

    def stress(self, time: Array, size: Array) -> list[Alarm]:
        """Return the alarms of stress magnitudes (k, ns) at times (k,)."""
        limit = self.limits.stress
        if limit is None or not len(time):
            return []
        high = size >= limit
        # places that can neither start nor end an alarm
        if not (np.count_nonzero(high) or np.count_nonzero(self._on["stress"])):
            return []
        found: list[Alarm] = []
        held = size >= self.limits.release * limit
        for c in np.flatnonzero(high.any(axis=0) | self._on["stress"]):
            on, last = bool(self._on["stress"][c]), self._above[c]
            for k, t in enumerate(time):
                if held[k, c]:
                    last = t
                if not on and high[k, c]:
                    on = True
                    found.append(
                        Alarm(float(t), "stress", self.places[c], True, float(size[k, c]), limit)
                    )
                elif (
                    on
                    and np.isfinite(size[k, c])
                    and t - last >= self.limits.hold
                    and not held[k, c]
                ):
                    on = False
                    found.append(
                        Alarm(float(t), "stress", self.places[c], False, float(size[k, c]), limit)
                    )
            self._on["stress"][c], self._above[c] = on, last
        return sorted(found, key=lambda alarm: alarm.time)

    def channels(self, time: Array, states: NDArray[np.uint8]) -> list[Alarm]:
        """Return the alarms of channel states (k, nc)."""
        limit = self.limits.channels
        if limit is None or not len(time):
            return []
        on = bool(self._on["channels"][0])
        if not on and states.shape[1] >= limit and not np.count_nonzero(states):
            return []
        ok = (states == OK).sum(axis=1)
        if not on and not np.any(ok < limit):
            return []
        found: list[Alarm] = []
        for t, n in zip(time, ok, strict=True):
            if n < limit:
                self._short[0] = t
                if not on:
                    on = True
                    found.append(Alarm(float(t), "channels", "", True, float(n), float(limit)))
            elif on and t - self._short[0] >= self.limits.hold:
                on = False
                found.append(Alarm(float(t), "channels", "", False, float(n), float(limit)))
        self._on["channels"][0] = on
        return found

    def summary(self, time: float, damage: Array, life: Array) -> list[Alarm]:
        """Return the alarms of damage (ns,) and of the lower end of remaining life (ns,), s."""
        found: list[Alarm] = []
        for kind, value, limit, high in (
            ("damage", damage, self.limits.damage, True),
            ("life", life, self.limits.life, False),
        ):
            if limit is None:
                continue
            with np.errstate(invalid="ignore"):
                now = value >= limit if high else value <= limit
                # hysteresis: an estimated life may rise again; 10 % above the limit ends the alarm
                stay = now if high else value <= 1.1 * limit
            on = self._on[kind]
            new = np.where(on, stay | now, now)
            found += [
                Alarm(time, kind, self.places[c], bool(new[c]), float(value[c]), limit)
                for c in np.flatnonzero(new != on)
            ]
            self._on[kind] = new
        return found
