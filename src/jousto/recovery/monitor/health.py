"""The health of measured channels: which values can be believed, sample by sample."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.errors import Problems
from jousto.recovery.monitor.stream import EMPTY, INFINITE, NOT_A_NUMBER
from jousto.recovery.twin.signals import LARGEST

Array = NDArray[np.float64]
States = NDArray[np.uint8]

STATES = ("ok", "dropout", "nan", "saturated", "stuck", "spike", "back")
"""What a channel can be; only values of channels that are "ok" are used."""
OK, DROPOUT, NAN, SATURATED, STUCK, SPIKE, BACK = range(len(STATES))

FOLLOW = 0.02  # share by which the usual step of a channel follows that of a sample
WARM = 50  # samples before spikes are looked for
PERSIST = 3  # samples at a new level that make a jump real


@dataclass(frozen=True)
class ChannelRules:
    """When a value is not believed.

    Parameters
    ----------
    range : float
        Magnitude at which a channel is saturated, m/m; at most 0.01.
    stuck : int
        Samples of exactly the same value, while others change, after which a channel is stuck;
        0 does not look.
    spike : float
        Jump, in usual steps of the channel from sample to sample, that is a spike unless the next
        samples confirm it; 0 does not look.
    back : int
        Good samples in a row before a channel that failed is used again.
    """

    range: float = LARGEST
    stuck: int = 50
    spike: float = 40.0
    back: int = 10

    def __post_init__(self) -> None:
        problems = Problems()
        problems.positive("ChannelRules", "range", self.range, "m/m")
        if self.range > LARGEST:
            problems.add(
                "ChannelRules",
                f"range is {self.range:g} m/m, must be at most {LARGEST:g}: no gauge shows more",
            )
        for name in ("stuck", "back"):
            value = getattr(self, name)
            if not isinstance(value, int) or value < 0:
                problems.add(
                    "ChannelRules", f"{name} is {value!r}, must be a number of samples, 0 or more"
                )
        problems.number(
            "ChannelRules", "spike", self.spike, "", "0 or positive", lambda x: x >= 0.0
        )
        problems.raise_if_any()


@dataclass(frozen=True)
class Change:
    """A channel that changed its state.

    Attributes
    ----------
    time : float
        s.
    channel : str
        Its name.
    before, after : str
        Of STATES.
    """

    time: float
    channel: str
    before: str
    after: str


class Health:
    """Follows the states of channels through a stream.

    Parameters
    ----------
    names : sequence of str
        Channels.
    rules : ChannelRules
        When a value is not believed.
    """

    def __init__(self, names: Sequence[str], rules: ChannelRules | None = None) -> None:
        self.names = tuple(names)
        self.rules = rules or ChannelRules()
        n = len(self.names)
        self.state: States = np.zeros(n, dtype=np.uint8)
        self._last = np.full(n, np.nan)  # value before, believed or not
        self._good = np.full(n, np.nan)  # last value that was believed
        self._usual = np.zeros(n)  # mean size of a step
        self._seen = np.zeros(n)  # samples that made it
        self._same = np.zeros(n)  # samples of the same value in a row
        self._moves = np.zeros(n)  # samples since, in which others changed
        self._level = np.zeros(n)  # samples at a level that a jump led to
        self._well = np.zeros(n)  # good samples in a row

    def save(self) -> Array:
        """Return all that is remembered, for `load`."""
        return np.stack([self.state.astype(np.float64), *(getattr(self, x) for x in MEMORY)])

    def load(self, memory: Array) -> None:
        """Go on from what `save` returned."""
        self.state = memory[0].astype(np.uint8)
        for name, row in zip(MEMORY, memory[1:], strict=True):
            setattr(self, name, np.array(row))

    def check(
        self, time: Array, values: Array, cells: States | None = None
    ) -> tuple[States, list[Change]]:
        """Return the state of every value, and what changed.

        Parameters
        ----------
        time : (k,) array
            s.
        values : (k, nc) array
            Strains, m/m; nan where there is none.
        cells : (k, nc) uint8 array, optional
            What stood there (`stream`); from the values if not given.
        """
        if cells is None:
            cells = np.where(
                np.isnan(values), NOT_A_NUMBER, np.where(np.isinf(values), INFINITE, 0)
            )
        states = np.empty(values.shape, dtype=np.uint8)
        changes: list[Change] = []
        for k in range(len(values)):
            states[k] = self._sample(values[k], cells[k])
            for c in np.flatnonzero(states[k] != self.state):
                before, after = STATES[self.state[c]], STATES[states[k, c]]
                changes.append(Change(float(time[k]), self.names[c], before, after))
            self.state = states[k]
        return states, changes

    def _sample(self, x: Array, cells: States) -> States:
        rules = self.rules
        there = np.isfinite(x)
        state = np.zeros(len(x), dtype=np.uint8)
        state[~there] = NAN
        state[cells == EMPTY] = DROPOUT
        wide = (cells == INFINITE) | (there & (np.abs(x) >= rules.range))
        state[wide] = SATURATED

        # stuck: the same to the last digit while the others move on
        same = there & (x == self._last)
        moved = there & ~same & np.isfinite(self._last)
        others = moved.sum() > 0
        self._same = np.where(same, self._same + 1.0, 0.0)
        self._moves = np.where(same, self._moves + (1.0 if others else 0.0), 0.0)
        if rules.stuck:
            state[(state == OK) & (self._moves >= rules.stuck)] = STUCK

        # spike: a jump far beyond the usual steps, until a few samples stay there
        step = np.abs(x - self._good)
        if rules.spike:
            known = (self._seen >= WARM) & np.isfinite(step)
            limit = rules.spike * np.maximum(self._usual, 1e-12)
            jump = known & (state == OK) & (step > limit)
            near = np.isfinite(self._last) & (np.abs(x - self._last) <= limit)
            self._level = np.where(jump, np.where(near, self._level + 1.0, 1.0), 0.0)
            state[jump & (self._level < PERSIST)] = SPIKE
        good = state == OK
        usual = good & np.isfinite(step)
        rate = np.maximum(FOLLOW, 1.0 / (1.0 + self._seen))
        # a believed jump must not make the next one look usual
        capped = np.where(self._seen >= WARM, np.minimum(step, 4.0 * self._usual + 1e-12), step)
        self._usual = np.where(usual, self._usual + rate * (capped - self._usual), self._usual)
        self._seen = np.where(usual, self._seen + 1.0, self._seen)
        self._good = np.where(good, x, self._good)
        self._last = np.where(there, x, np.nan)

        # what failed must be well for some samples before it is believed again
        self._well = np.where(good, self._well + 1.0, 0.0)
        failed = self.state != OK
        brief = self.state == SPIKE  # one wild value says nothing of the next
        state[good & failed & ~brief & (self._well <= rules.back)] = BACK
        return state


MEMORY = ("_last", "_good", "_usual", "_seen", "_same", "_moves", "_level", "_well")
