"""The twin as a stream needs it: block after block, with a memory that can be kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.errors import InputError, Problem, warn
from jousto.recovery.twin import Observer, Reconstruction
from jousto.recovery.twin.posterior import Posterior

Array = NDArray[np.float64]
KEPT = 256
"""Combinations of channels whose gains are remembered."""


class Estimator(Protocol):
    """From strains to modal coordinates."""

    names: tuple[str, ...]

    def estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates of samples (k, nc), nan where a channel is silent."""

    def save(self) -> dict[str, Array]:
        """Return all that is remembered as numbers."""

    def load(self, memory: Mapping[str, Array]) -> None:
        """Go on from what `save` returned."""


class Static:
    """A `Reconstruction`: every sample stands alone, nothing is remembered."""

    def __init__(self, twin: Reconstruction) -> None:
        if twin.errors is not None:
            warn(
                "Monitor",
                "the bands of a monitor hold the noise, not the errors= of the gauges; read the "
                "record again with stress_band to have them",
            )
        self.twin = twin
        self.names = twin.names
        self._gains: dict[bytes, tuple[Array, Array] | None] = {}

    def estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates of samples (k, nc): ``p = K e`` of the channels there are.

        The gains of every combination of channels are worked out once; what the samples are worth
        was checked before, by the health of the channels.
        """
        n = self.twin.n
        seen = np.isfinite(strain)
        if seen.all():
            masks, which = seen[:1], np.zeros(len(strain), dtype=np.intp)
        else:
            masks, which = np.unique(seen, axis=0, return_inverse=True)
            which = which.reshape(-1)
        p = np.full((len(strain), n), np.nan)
        P = np.full((len(masks), n, n), np.inf)
        for m, mask in enumerate(masks):
            gain = self._gain(mask)
            if gain is not None:
                K, P[m] = gain
                rows = which == m
                p[rows] = strain[rows][:, mask] @ K.T
        return Posterior(time, p, P, which)

    def _gain(self, mask: NDArray[np.bool_]) -> tuple[Array, Array] | None:
        key = mask.tobytes()
        if key not in self._gains:
            if len(self._gains) >= KEPT:
                self._gains.clear()
            self._gains[key] = self.twin.gain(mask)
        return self._gains[key]

    def save(self) -> dict[str, Array]:
        """Return nothing."""
        return {}

    def load(self, memory: Mapping[str, Array]) -> None:
        """Do nothing."""


def estimator_of(twin: Any) -> Estimator:
    """Return what estimates the modal coordinates.

    Raises
    ------
    InputError
        If it is neither a Reconstruction nor an Observer.
    """
    if isinstance(twin, Reconstruction):
        return Static(twin)
    if isinstance(twin, Observer):
        from jousto.recovery.monitor.observed import Dynamic

        return Dynamic(twin)
    raise InputError(
        Problem(
            "Monitor",
            f"twin is a {type(twin).__name__}, must be a Reconstruction or an Observer",
        )
    )
