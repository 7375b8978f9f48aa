"""The health of measured channels: which values can be believed, sample by sample."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from jousto.base.arguments import explained
from jousto.base.described import described
from jousto.base.errors import Problems
from jousto.measurement.monitor.stream import EMPTY, INFINITE
from jousto.measurement.twin.signals import LARGEST
from jousto.model.native.health import HealthCheck

Array = NDArray[np.float64]
States = NDArray[np.uint8]

STATES = ("ok", "dropout", "nan", "saturated", "stuck", "spike", "back")
"""What a channel can be; only values of channels that are "ok" are used."""
OK = STATES.index("ok")


@explained
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


@described
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
        self._memory = np.zeros((len(MEMORY), n))
        self._memory[: MEMORY.index("usual step")] = np.nan
        self._engine = HealthCheck(self.rules, cells=(EMPTY, INFINITE))

    def save(self) -> Array:
        """Return all that is remembered, for `load`."""
        return np.concatenate([self.state[None].astype(np.float64), self._memory])

    def load(self, memory: Array) -> None:
        """Go on from what `save` returned."""
        self.state = memory[0].astype(np.uint8)
        self._memory = np.array(memory[1:], dtype=np.float64, order="C")

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
        states = self._engine(self._memory, self.state, values, cells)
        if not len(states):
            return states, []
        last, self.state = self.state, states[-1].copy()
        if not (np.count_nonzero(states) or np.count_nonzero(last)):
            return states, []
        before = np.concatenate([last[None], states[:-1]])
        changed = np.argwhere(states != before).tolist()
        return states, [
            Change(float(time[k]), self.names[c], STATES[before[k, c]], STATES[states[k, c]])
            for k, c in changed
        ]


MEMORY = (
    "last value",  # believed or not
    "last good value",
    "usual step",
    "samples in it",
    "samples of the same value",
    "samples in which others changed",
    "samples at a new level",
    "good samples in a row",
)
"""What is remembered of each channel, row by row; see jo_health_check."""
