"""Algebraic loops between a machine and units whose outputs act on it at the same instant.

A unit that receives an acceleration or a reaction and returns a force closes a loop without delay:
``y = g(s(y))``, with the sensors s for outputs y and the outputs g of the unit for these sensors.
Constant values between exchanges are the iteration ``y <- g(s(y))``, one per exchange, whose error
grows by the gain of the loop, ``|dg/ds ds/dy|``, for example the ratio of the added mass to the
mass of the machine. Newton's method on the interface converges (Kuebler and Schiehlen, Mathematical
and Computer Modelling of Dynamical Systems 6, 2000, 93-113): ``(dg/dy - I) dy = y - g``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from jousto.base.arrays import Array

CLOSED = 1e-9  # convergence tolerance: residual over the largest value of the loop so far
PROBE = 1e-4  # relative increment of the finite differences of the Jacobian
MOST = 20  # maximum number of Newton iterations
SLOW = 0.1  # ratio of successive residuals, above which the Jacobian is computed again
GROWTH = 20  # number of successive growing differences that indicate an unstable loop
STEEP = 1.3  # ratio of successive differences that a smooth motion does not have 20 times


class LoopFailed(Exception):
    """Error raised if Newton's method finds no solution of an algebraic loop."""


@dataclass
class Loop:
    """Solver of ``y = g(y)`` for the outputs y of units at one instant.

    Attributes
    ----------
    jacobian : (n, n) array
        ``dg/dy``, reused until the iteration converges slowly.
    largest : float
        Largest value of a solution so far, the scale of residuals.
    """

    jacobian: Array = field(default_factory=lambda: np.zeros((0, 0)))
    largest: float = 0.0

    def solve(self, y: Array, g: Callable[[Array], Array]) -> None:
        """Solve ``y = g(y)`` from outputs `y` (n,); the last call of `g` is at the solution.

        Raises
        ------
        LoopFailed
            If the iteration does not converge.
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
        """Gain of the loop: growth of the error per exchange without Newton's method."""
        return float(np.abs(np.linalg.eigvals(self.jacobian)).max(initial=0.0))

    def _noisy(self, y: Array, found: Array, g: Callable[[Array], Array]) -> bool:
        """Return whether a residual is round-off of `g`, such as that of forces that cancel.

        A smooth function has second differences that are small beside the residual; a rounded one
        has larger ones, or does not change at all.
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
    """Detector of growing differences of outputs from exchange to exchange.

    Attributes
    ----------
    ratios : list of float
        Ratios of successive differences, the newest last; negative if the sign changes.
    """

    ratios: list[float] = field(default_factory=list)
    last: Array | None = None

    def see(self, before: Array, now: Array) -> None:
        """Add the outputs of two successive exchanges."""
        change = now - before
        if self.last is not None:
            square = float(self.last @ self.last)
            ratio = float(change @ self.last) / square if square > 0.0 else 0.0
            self.ratios = [*self.ratios[1 - GROWTH :], ratio]
        self.last = change

    @property
    def gain(self) -> float:
        """Growth factor per exchange of an unstable loop; 0 if there is none.

        A loop is unstable if differences alternate and grow, or if they grow by more than 1.3 in
        each of 20 exchanges. Values that start from rest like t^n grow more slowly.
        """
        found = np.array(self.ratios)
        if len(found) < GROWTH or not ((found < -1.0).all() or (found > STEEP).all()):
            return 0.0
        return float(np.abs(found).mean())
