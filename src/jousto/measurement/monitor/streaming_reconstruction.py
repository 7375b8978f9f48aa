"""The twin as a stream needs it: block after block, with a memory that can be kept."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.base.object_repr import described
from jousto.measurement.twin.estimates import Posterior, Told
from jousto.measurement.twin.observer import Observer
from jousto.measurement.twin.reconstruction import Reconstruction

KEPT = 256
"""Combinations of channels whose gains are remembered."""


class Estimator(Protocol):
    """From strains to modal coordinates."""

    names: tuple[str, ...]
    missed: float

    def estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates of samples (k, nc), nan where a channel is silent."""

    def save(self) -> dict[str, Array]:
        """Return all that is remembered as numbers."""

    def load(self, memory: Mapping[str, Array]) -> None:
        """Go on from what `save` returned."""


@described
class Static:
    """A `Reconstruction`: every sample stands alone, nothing is remembered."""

    def __init__(self, twin: Reconstruction) -> None:
        self.twin = twin
        self.names = twin.names
        self.missed = twin.discrepancy
        self._gains: dict[bytes, tuple[Array, Array] | None] = {}
        self._whole: tuple[Array, Array] | None = None

    def estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates of samples (k, nc): ``p = K e`` of the channels there are.

        The gains of every combination of channels are worked out once; what the samples are worth
        was checked before, by the health of the channels.
        """
        n = self.twin.n
        seen = np.isfinite(strain)
        if np.count_nonzero(seen) == seen.size:
            return self._of_all(time, strain)
        masks, which = np.unique(seen, axis=0, return_inverse=True)
        which = which.reshape(-1)
        p = np.full((len(strain), n), np.nan)
        P = np.full((len(masks), n, n), np.inf)
        errors = self.twin.errors
        gains = None if errors is None else np.zeros((len(masks), n, strain.shape[1]))
        for m, mask in enumerate(masks):
            gain = self._gain(mask)
            if gain is not None:
                K, P[m] = gain
                rows = which == m
                p[rows] = strain[rows][:, mask] @ K.T
                if gains is not None:
                    gains[m][:, mask] = K
        return Told(time, p, P, which, gains=gains, errors=errors)

    def _of_all(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates if no channel is silent, as it is most of the time."""
        if self._whole is None:
            gain = self.twin.gain(np.ones(strain.shape[1], dtype=bool))
            assert gain is not None  # refused by the twin
            self._whole = gain[0], gain[1][None]
        K, P = self._whole
        errors = self.twin.errors
        gains = None if errors is None else K[None]
        which = np.zeros(len(strain), dtype=np.intp)
        return Told(time, strain @ K.T, P, which, gains=gains, errors=errors)

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
        from jousto.measurement.monitor.streaming_observer import Dynamic

        return Dynamic(twin)
    raise InputError(
        Problem(
            "Monitor",
            f"twin is a {type(twin).__name__}, must be a Reconstruction or an Observer",
        )
    )
