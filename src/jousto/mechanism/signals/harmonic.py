"""The sine signal."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.errors import InputError, Problem
from jousto.base.rotations import Array
from jousto.mechanism.signals.base import Jet, Signal
from jousto.mechanism.signals.piecewise import set_numbers


@dataclass(frozen=True, init=False)
class Harmonic(Signal):
    """A sine: ``offset + amplitude sin(2 pi frequency t + phase)``.

    Parameters
    ----------
    frequency : float
        Frequency, Hz.
    amplitude, offset : float
        In the unit of what the signal is used for; factors on forces are dimensionless.
    phase : float
        Phase, rad.

    Examples
    --------
    >>> Harmonic(frequency=0.5, amplitude=3.0, offset=1.0)(1.5).round(12)
    np.float64(-2.0)
    """

    amplitude: float
    frequency: float
    phase: float
    offset: float

    def __init__(
        self, *, frequency: float, amplitude: float = 1.0, phase: float = 0.0, offset: float = 0.0
    ) -> None:
        set_numbers(self, amplitude=amplitude, frequency=frequency, phase=phase, offset=offset)
        if self.frequency < 0:
            raise InputError(
                Problem("Harmonic", f"frequency is {self.frequency:g} Hz, must not be negative")
            )

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration."""
        omega = 2 * np.pi * self.frequency
        angle = omega * t + self.phase
        sine, cosine = self.amplitude * np.sin(angle), self.amplitude * np.cos(angle)
        return np.asarray(self.offset + sine), omega * cosine, -(omega**2) * sine
