"""Modal coordinates of a stream, block by block, with a state that can be saved."""

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
"""Cache size: channel combinations with their gains."""


class Estimator(Protocol):
    """Protocol of an estimator of modal coordinates from strains."""

    names: tuple[str, ...]
    missed: float

    def estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates of samples (k, nc), nan for missing channels."""

    def save(self) -> dict[str, Array]:
        """Return the state as arrays."""

    def load(self, memory: Mapping[str, Array]) -> None:
        """Restore the state that `save` returned."""


@described
class Static:
    """Modal coordinates by a `Reconstruction`, each sample independent of the others."""

    def __init__(self, twin: Reconstruction) -> None:
        self.twin = twin
        self.names = twin.names
        self.missed = twin.discrepancy
        self._gains: dict[bytes, tuple[Array, Array] | None] = {}
        self._whole: tuple[Array, Array] | None = None

    def estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates of samples (k, nc): ``p = K e`` of the valid channels.

        The gains of every combination of channels are computed once; the validity of the samples
        was checked before.
        """
        n = self.twin.n
        seen = np.isfinite(strain)
        if np.count_nonzero(seen) == seen.size:
            return self._full_estimate(time, strain)
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

    def _full_estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates where no channel is missing (fast path)."""
        if self._whole is None:
            gain = self.twin.gain(np.ones(strain.shape[1], dtype=bool))
            assert gain is not None  # the constructor checked the full set of channels
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
        """Return no arrays: there is no state."""
        return {}

    def load(self, memory: Mapping[str, Array]) -> None:
        """Do nothing: there is no state."""


def estimator_of(twin: Any) -> Estimator:
    """Return the streaming estimator of a reconstruction or an observer.

    Raises
    ------
    InputError
        If `twin` is neither a Reconstruction nor an Observer.
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
