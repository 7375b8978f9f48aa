"""Miner's sum as a function of a factor on the load."""

from __future__ import annotations

import math

import numpy as np

from jousto.base.arrays import Array
from jousto.materials.strength.sn import SN


class Spectrum:
    """Spectrum of equivalent amplitudes with counts, sorted for a fast evaluation of D(f).

    Miner's sum with a factor f on the stresses S is ``D(f) N_D = sum n x^k`` over x >= 1 plus
    ``sum n x^k2`` over x < 1 above the limit, with ``x = f S / S_D``. An evaluation needs two
    binary searches.

    Parameters
    ----------
    amplitude, count : (nc,) array
        Equivalent amplitudes, Pa, and numbers of cycles.
    sn : SN
    """

    def __init__(self, amplitude: Array, count: Array, sn: SN) -> None:
        S_D, N_D, k, k2, limit = sn.numbers
        order = np.argsort(amplitude)[::-1]
        x, n = amplitude[order] / S_D, count[order]
        keep = (x > 0.0) & (n > 0.0)
        self.x: Array = x[keep]
        n = n[keep]
        self.N_D, self.k, self.k2 = N_D, k, k2
        self.limit = limit / S_D
        self.falls = -self.x
        # cumulative sums of x^k from the largest amplitude and of x^k2 from the smallest one, so
        # that a difference of sums loses no digits; x is relative to the largest amplitude
        self.top = float(self.x[0]) if len(self.x) else 1.0
        y = self.x / self.top
        self.above = np.zeros(len(y) + 1)
        np.cumsum(n * y**k, out=self.above[1:])
        self.below = np.zeros(len(y) + 1)
        if not math.isinf(k2):
            self.below[:-1] = np.cumsum((n * y**k2)[::-1])[::-1]

    def damage(self, factor: float = 1.0) -> float:
        """Return Miner's sum with all stresses multiplied by a factor."""
        if not len(self.x):
            return 0.0
        i = int(np.searchsorted(self.falls, -1.0 / factor, side="right"))
        j = len(self.x)
        if self.limit > 0.0:
            j = max(i, int(np.searchsorted(self.falls, -self.limit / factor, side="right")))
        size = math.log(factor * self.top)
        total = _times(float(self.above[i]), self.k * size)
        total += _times(float(self.below[i] - self.below[j]), self.k2 * size)
        return total / self.N_D

    def factor(self, allowable: float) -> float:
        """Return the largest factor with which Miner's sum does not exceed the allowable one."""
        if not len(self.x):
            return math.inf
        low, high = math.log(1e-9 / self.top), math.log(1e9 / self.top)
        if self.k == self.k2 and self.limit == 0.0:  # a single power law: explicit solution
            whole = self.damage(1.0 / self.top)
            return math.exp(math.log(allowable / whole) / self.k) / self.top
        for _ in range(48):
            middle = 0.5 * (low + high)
            if self.damage(math.exp(middle)) <= allowable:
                low = middle
            else:
                high = middle
        return math.exp(low)


def _times(value: float, power: float) -> float:
    """Return ``value exp(power)``; inf in case of overflow."""
    if value <= 0.0:
        return 0.0
    return math.inf if power > 700.0 else value * math.exp(power)
