"""An `Observer` in a stream, with a memory that can be kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.recovery.twin import Observer
from jousto.recovery.twin.kalman import Gain
from jousto.recovery.twin.observed import Observed
from jousto.recovery.twin.posterior import Posterior

Array = NDArray[np.float64]
GAIN = ("F", "Gu", "K", "whiten", "predicted", "P")


class Dynamic:
    """Takes the samples one by one; what it remembers are the state and its covariance."""

    def __init__(self, twin: Observer) -> None:
        self.twin = twin
        self.names = tuple(twin.names)

    def estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates of samples (k, nc)."""
        steps: list[Any] = [self.twin.step(t, e) for t, e in zip(time, strain, strict=True)]
        return Observed.collect(self.twin, steps)

    def save(self) -> dict[str, Array]:
        """Return the state, its covariance and gain."""
        twin, gain = self.twin, self.twin._gain
        if gain is None:
            return {}
        own = {
            "time": np.array([twin.time, gain.key[0], float(gain.steady)]),
            "x": twin._x,
            "f": twin._f,
            "mask": gain.mask.astype(np.float64),
        }
        return own | {name: getattr(gain, name) for name in GAIN}

    def load(self, memory: Mapping[str, Array]) -> None:
        """Go on from what `save` returned."""
        self.twin.reset()
        if not memory:
            return
        time, step, steady = (float(x) for x in memory["time"])
        mask = memory["mask"] > 0.5
        parts = {name: np.array(memory[name]) for name in GAIN}
        self.twin._gain = Gain((step, mask.tobytes()), mask, steady=bool(steady), **parts)
        self.twin._x, self.twin._f = np.array(memory["x"]), np.array(memory["f"])
        self.twin.time = time
