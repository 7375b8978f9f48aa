"""ReadingLoss: difference of a reading between two runs as error, peak, shift in time and life."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems
from jousto.base.object_repr import described

LARGEST_SHIFT = 0.1
"""Largest shift in time / length of the run."""
SHIFTS = 41
"""Number of shifts of the first search; the neighbourhood of the best one is refined."""
REFINED = 3
"""Number of refinements of the shift, each by a factor of SHIFTS / 2."""
NOT_BETTER = 1e-3
"""Decrease of the error / error, below which no shift is reported."""


@described
@dataclass(frozen=True, eq=False)
class ReadingLoss:
    """Difference between a reading y of a full run and y_r of a simpler run.

    Attributes
    ----------
    error : float
        ``e_inf = max |y_r - y| / (max y - min y)``; without a range `difference`.
    absolute : bool
        Whether the reading has no range, so that `error` is in the unit of the reading.
    difference : float
        ``max |y_r - y|``, in the unit of the reading.
    peak : float
        ``max |y_r| / max |y| - 1``; infinite if y is zero and y_r is not.
    lag : float
        Shift tau, s, with the smallest error of ``y_r(t + tau)``: positive where the simpler run is
        late.
    shifted : float
        The error at this shift.
    range : float
        ``max y - min y``, in the unit of the reading; 0 if it is rounding.
    """

    error: float
    absolute: bool
    difference: float
    peak: float
    lag: float
    shifted: float
    range: float

    @property
    def share(self) -> float:
        """Loss that is compared with the limit: `error`, and without a range the peak's change."""
        return abs(self.peak) if self.absolute else self.error


@explained
def reading_loss(
    time: ArrayLike, full: ArrayLike, simple: ArrayLike, *, floor: float = 0.0
) -> ReadingLoss:
    """Return what a reading of a simpler run loses against that of the full run.

    A lag alone causes a large error although the peaks are equal; therefore the shift in time that
    minimises the error is found as well.

    Parameters
    ----------
    time : (nt,) array_like
        Instants of both runs, s, ascending.
    full, simple : (nt,) array_like
        Readings y and y_r, in one unit.
    floor : float
        Rounding level of the reading in its unit; a smaller range counts as none.

    Raises
    ------
    InputError
        With all arrays of the wrong shape.

    Examples
    --------
    >>> t = np.linspace(0.0, 1.0, 1001)
    >>> late = reading_loss(t, np.sin(20 * t), np.sin(20 * (t - 0.01)))
    >>> print(f"{late.error:.3f} {late.peak:.3f} {late.lag:.4f} {late.shifted:.4f}")
    0.100 0.000 0.0100 0.0000
    """
    problems = Problems()
    t = problems.array("reading_loss", "time", time, (None,))
    n = None if t is None else len(t)
    y = problems.array("reading_loss", "full", full, (n,))
    r = problems.array("reading_loss", "simple", simple, (n,))
    if t is not None and (len(t) < 2 or (np.diff(t) <= 0.0).any()):
        problems.add("reading_loss", "time must have two or more ascending instants")
    problems.raise_if_any()
    assert t is not None and y is not None and r is not None
    difference = float(np.abs(r - y).max())
    span = float(np.ptp(y))
    span = span if span > floor else 0.0
    lag, shifted = _best_shift(t, y, r) if span else (0.0, difference)
    scale = span or 1.0
    return ReadingLoss(
        error=difference / scale,
        absolute=not span,
        difference=difference,
        peak=_peak_change(y, r, floor),
        lag=lag,
        shifted=shifted / scale,
        range=span,
    )


def _peak_change(y: Array, r: Array, floor: float) -> float:
    """Return ``max |r| / max |y| - 1``; 0 if both are rounding, infinite if only y is."""
    largest, other = float(np.abs(y).max()), float(np.abs(r).max())
    if largest > floor:
        return other / largest - 1.0
    return float("inf") if other > floor else 0.0


def _best_shift(t: Array, y: Array, r: Array) -> tuple[float, float]:
    """Return the shift of r, s, with the smallest largest difference to y, and that difference."""
    width = LARGEST_SHIFT * float(t[-1] - t[0])
    # all shifts are compared over the same instants, at which every shifted reading exists
    inner = (t >= t[0] + width) & (t <= t[-1] - width)
    if inner.sum() < 2:
        return 0.0, float(np.abs(r - y).max())

    def error(shift: float) -> float:
        return float(np.abs(np.interp(t[inner] + shift, t, r) - y[inner]).max())

    centre, still = 0.0, error(0.0)
    for _ in range(1 + REFINED):
        shifts = centre + width * np.linspace(-1.0, 1.0, SHIFTS)
        shifts = shifts[np.abs(shifts) <= LARGEST_SHIFT * float(t[-1] - t[0]) * (1.0 + 1e-12)]
        errors = np.array([error(one) for one in shifts])
        # of equal errors the one with the smallest shift
        best = int(np.lexsort((np.abs(shifts), errors))[0])
        centre, width = float(shifts[best]), 2.0 * width / (SHIFTS - 1)
    whole = float(np.abs(r - y).max())
    if errors[best] >= (1.0 - NOT_BETTER) * still:
        return 0.0, whole
    reach = (t + centre >= t[0]) & (t + centre <= t[-1])
    return centre, float(np.abs(np.interp(t[reach] + centre, t, r) - y[reach]).max())
