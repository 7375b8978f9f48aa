"""Algebraic loops: outputs of units that depend at once on what they do to the machine.

A unit that takes an acceleration or a reaction and returns a force closes a loop without delay:
``y = g(s(y))``, s being the sensors for outputs y and g the unit's outputs for these sensors. Held
values iterate ``y <- g(s(y))`` once an exchange, which grows by the loop's gain,
``|dg/ds ds/dy|``, e.g. the added mass over that of the machine. Newton's method on the interface
solves it (Kuebler and Schiehlen, Mathematical and Computer Modelling of Dynamical Systems 6, 2000,
93-113): ``(dg/dy - I) dy = y - g``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array

CLOSED = 1e-9  # residual over the largest value of the loop so far
PROBE = 1e-4  # difference for the Jacobian over the values
MOST = 20  # iterations of Newton's method
SLOW = 0.1  # reduction of the residual above which the Jacobian is computed anew
GROWTH = 20  # exchanges in a row after which growing differences are an unstable loop
STEEP = 1.3  # ratio of two differences that a smooth motion does not keep up


class LoopFailed(Exception):
    """The loop has no solution that Newton's method finds."""


@dataclass
class Loop:
    """Solves ``y = g(y)`` for what crosses between a machine and units at one instant.

    Attributes
    ----------
    jacobian : (n, n) array
        ``dg/dy``, kept from exchange to exchange until it is no longer good enough.
    largest : float
        Largest value of a solution so far, the scale of residuals.
    """

    jacobian: Array = field(default_factory=lambda: np.zeros((0, 0)))
    largest: float = 0.0

    def solve(self, y: Array, g: Callable[[Array], Array]) -> None:
        """Iterate from outputs `y` (n,); the last call of `g` is at the solution.

        Raises
        ------
        LoopFailed
            If it does not converge.
        """
        found, last = g(y), np.inf
        for _ in range(MOST):
            off = found - y
            error = float(np.abs(off).max())
            scale = max(self.largest, float(np.abs(y).max()))
            if not error > CLOSED * scale:
                self.largest = scale
                return
            if len(self.jacobian) != len(y) or error > SLOW * last:
                self.jacobian = self._differences(y, found, g)
            try:
                y = y + np.linalg.solve(np.eye(len(y)) - self.jacobian, off)
            except np.linalg.LinAlgError:
                break
            last, found = error, g(y)
        if not self._noisy(y, found, g):
            raise LoopFailed
        g(y)

    @property
    def gain(self) -> float:
        """Factor by which held values would grow from exchange to exchange."""
        return float(np.abs(np.linalg.eigvals(self.jacobian)).max(initial=0.0))

    def _noisy(self, y: Array, found: Array, g: Callable[[Array], Array]) -> bool:
        """Return whether a residual is the rounding of `g`, such as that of forces that cancel.

        A smooth function has second differences that are small beside the residual; one that is
        rounded to steps has larger ones, or does not change at all.
        """
        above, below = g(y + PROBE * y), g(y - PROBE * y)
        jumps = np.abs(above + below - 2.0 * found).max() > SLOW * np.abs(found - y).max()
        return bool(jumps or (np.array_equal(above, found) and np.array_equal(below, found)))

    def _differences(self, y: Array, found: Array, g: Callable[[Array], Array]) -> Array:
        size = PROBE * max(float(np.abs([y, found]).max()), CLOSED * self.largest)
        columns = [(g(y + size * e) - found) / size for e in np.eye(len(y))]
        return np.array(columns).T


@dataclass
class Growth:
    """Watches differences of outputs from exchange to exchange.

    Attributes
    ----------
    ratios : list of float
        Of successive differences, the newest last; negative where they change their sign.
    """

    ratios: list[float] = field(default_factory=list)
    last: Array | None = None

    def see(self, before: Array, now: Array) -> None:
        """Take the outputs of two successive exchanges."""
        change = now - before
        if self.last is not None:
            square = float(self.last @ self.last)
            ratio = float(change @ self.last) / square if square > 0.0 else 0.0
            self.ratios = [*self.ratios[1 - GROWTH :], ratio]
        self.last = change

    @property
    def gain(self) -> float:
        """Factor of the growth that cannot be a motion; 0 where there is none.

        Differences that alternate and grow, or grow by more than 1.3 over 20 exchanges: those of a
        start from rest like t^n fall below that.
        """
        found = np.array(self.ratios)
        if len(found) < GROWTH or not ((found < -1.0).all() or (found > STEEP).all()):
            return 0.0
        return float(np.abs(found).mean())
