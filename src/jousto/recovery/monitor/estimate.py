"""The twin as a stream needs it: block after block, with a memory that can be kept."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from jousto.errors import InputError, JoustoWarning, Problem
from jousto.recovery.twin import Observer, Reconstruction
from jousto.recovery.twin.posterior import Posterior

Array = NDArray[np.float64]


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
        self.twin = twin
        self.names = twin.names

    def estimate(self, time: Array, strain: Array) -> Posterior:
        """Return the modal coordinates of samples (k, nc)."""
        with warnings.catch_warnings():  # gaps are told by the health of the channels
            warnings.simplefilter("ignore", JoustoWarning)
            return self.twin.estimate(strain, time)

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
