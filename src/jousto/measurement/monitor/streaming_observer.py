"""Observer of a stream whose state can be saved."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.measurement.twin.estimates import Estimates, Posterior
from jousto.measurement.twin.observer import Observer


class Dynamic:
    """Modal coordinates of a stream by a Kalman filter; its state can be saved.

    Parameters
    ----------
    twin : Observer
        Observer, which is reset and then advanced; give each monitor its own.

    Raises
    ------
    InputError
        If the observer has accelerometers, which a stream of strains does not contain.
    """

    def __init__(self, twin: Observer) -> None:
        if twin.accelerometers:
            names = ", ".join(sensor.name for sensor in twin.accelerometers)
            raise InputError(
                Problem(
                    "Monitor",
                    f"the observer has accelerometers ({names}), but a monitor reads strains "
                    "only; build the observer from gauges",
                )
            )
        twin.reset()
        self.twin = twin
        self.names = tuple(twin.names)
        self.missed = twin.system.discrepancy

    def estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates of samples (k, nc)."""
        if not len(time):
            n = self.twin.reduced.n
            none = np.zeros(0, dtype=np.intp)
            return Posterior(np.zeros(0), np.zeros((0, n)), np.zeros((1, n, n)), none)
        steps = [self.twin.step(t, e) for t, e in zip(time, strain, strict=True)]
        return Estimates.collect(self.twin, steps)

    def save(self) -> dict[str, Array]:
        """Return the state, its covariance and gain."""
        return self.twin.save()

    def load(self, memory: Mapping[str, Array]) -> None:
        """Restore the state that `save` returned."""
        self.twin.load(memory)
