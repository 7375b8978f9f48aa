"""The sine signal."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.signals.base import USE, Jet, Law, Signal


class Harmonic(Signal, tag="harmonic", by_value=True):
    """A sine: ``offset + amplitude sin(2 pi frequency t + phase)``.

    Examples
    --------
    >>> Harmonic(frequency=0.5, amplitude=3.0, offset=1.0)(1.5).round(12)
    np.float64(-2.0)
    """

    frequency: Number = field("Frequency", unit="Hz", least=0, kw_only=True)
    amplitude: Number = field(
        "Amplitude in the unit of the driven quantity; factors of forces have no unit",
        unit=USE,
        default=1.0,
        kw_only=True,
    )
    phase: Number = field("Phase", unit="rad", default=0.0, kw_only=True)
    offset: Number = field(
        "Mean value, in the unit of the amplitude", unit=USE, default=0.0, kw_only=True
    )

    def jet(self, t: Array) -> Jet:
        """Return value, rate and acceleration."""
        omega = 2 * np.pi * self.frequency
        angle = omega * t + self.phase
        sine, cosine = self.amplitude * np.sin(angle), self.amplitude * np.cos(angle)
        return np.asarray(self.offset + sine), omega * cosine, -(omega**2) * sine

    @property
    def law(self) -> Law:
        """Law of the sine signal in the engine."""
        data = {"offset": self.offset, "amplitude": self.amplitude, "phase": self.phase}
        return Law("harmonic", {"omega": 2 * np.pi * self.frequency, **data})
