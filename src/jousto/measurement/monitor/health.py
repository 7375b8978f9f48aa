"""Validity of measured channels, sample by sample."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import Problems
from jousto.base.fields import field
from jousto.base.numbers import Number, Positive, Whole
from jousto.base.object_repr import described
from jousto.measurement.monitor.stream import EMPTY, INFINITE
from jousto.measurement.twin.signals import LARGEST
from jousto.model.native.header import kinds
from jousto.model.native.health import HealthCheck

States = NDArray[np.uint8]

STATES = tuple(kinds("jo_value"))
"""States of a channel; only values of channels in state "ok" are used."""
OK = STATES.index("ok")
SAMPLES = "a number of samples, 0 or more"


class Saturation(Positive):
    """Type of fields: a strain above the range of gauges."""

    def check(self, problems: Problems, where: str, value: Any) -> Any:
        """Return the strain."""
        found = super().check(problems, where, value)
        if found is not None and found > LARGEST:
            problems.add(
                where,
                f"{self.name} is {found:g} m/m, must be at most {LARGEST:g}: no gauge measures "
                "more",
            )
        return found


class ChannelRules(Declared, by_value=True):
    """Rules for valid values of a channel."""

    range: Saturation = field(
        "Strain magnitude at which a channel is saturated; at most 0.01",
        unit="m/m",
        default=LARGEST,
    )
    stuck: Whole = field(
        "Samples of exactly the same value, while others change, after which a channel is "
        "stuck; 0 for no check",
        least=0,
        wanted=SAMPLES,
        default=50,
    )
    spike: Number = field(
        "Jump, in usual steps of the channel from sample to sample, that is a spike unless the "
        "next samples confirm it; 0 for no check",
        least=0,
        wanted="0 or positive",
        default=40.0,
    )
    back: Whole = field(
        "Consecutive valid samples before a failed channel is used again",
        least=0,
        wanted=SAMPLES,
        default=10,
    )


@dataclass(frozen=True)
class Change:
    """Change of a channel's state.

    Attributes
    ----------
    time : float
        s.
    channel : str
        Name of the channel.
    before, after : str
        States of `STATES` before and after the change.
    """

    time: float
    channel: str
    before: str
    after: str


@described
class Health:
    """States of channels through a stream.

    Parameters
    ----------
    names : sequence of str
        Channels.
    rules : ChannelRules
        Rules for valid values.
    """

    def __init__(self, names: Sequence[str], rules: ChannelRules | None = None) -> None:
        self.names = tuple(names)
        self.rules = rules or ChannelRules()
        n = len(self.names)
        self.state: States = np.zeros(n, dtype=np.uint8)
        rows = kinds("jo_health_row")
        self._memory = np.zeros((len(rows), n))
        self._memory[[rows["last"], rows["good"]]] = np.nan
        self._engine = HealthCheck(self.rules, cells=(EMPTY, INFINITE))

    @property
    def native(self) -> Any:
        """The rules as the engine's structure jo_health."""
        return self._engine.rule

    def save(self) -> Array:
        """Return the state as arrays, for `load`."""
        return np.concatenate([self.state[None].astype(np.float64), self._memory])

    def load(self, memory: Array) -> None:
        """Restore the state that `save` returned."""
        self.state = memory[0].astype(np.uint8)
        self._memory = np.array(memory[1:], dtype=np.float64, order="C")

    def check(
        self, time: Array, values: Array, cells: States | None = None
    ) -> tuple[States, list[Change]]:
        """Return the state of every value, and the changes of state.

        Parameters
        ----------
        time : (k,) array
            s.
        values : (k, nc) array
            Strains, m/m; nan where there is none.
        cells : (k, nc) uint8 array, optional
            Content of the cells (`stream`); by default derived from the values.
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
