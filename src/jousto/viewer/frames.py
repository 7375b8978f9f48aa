"""Frames: the instants of a run that the page shows, thinned evenly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, count

MOST_FRAMES = 20_000
LARGEST = 8 << 20  # bytes of an answer with rows
NUMBER = 4  # bytes of a transmitted number


@dataclass(frozen=True)
class Frames:
    """Instants ``first + k every``, `number` of them.

    Attributes
    ----------
    first, every, number : int
        First index, stride and number of the stored instants.
    """

    first: int
    every: int
    number: int

    @classmethod
    def thinned(cls, first: int, stop: int, most: int = MOST_FRAMES) -> Frames:
        """Return the frames of an index range, thinned evenly to the limit.

        Examples
        --------
        >>> Frames.thinned(100, 200, most=30)
        Frames(first=100, every=4, number=25)
        """
        every = max(1, -(-(stop - first) // most))
        return cls(first, every, -(-(stop - first) // every))

    @classmethod
    def within(cls, times: Array, start: float, end: float) -> Frames:
        """Return the frames of a time window with one neighbour on each side.

        Raises
        ------
        InputError
            If the window is empty or contains no frames.
        """
        if not end > start:
            raise InputError(
                Problem("window", f"from {start:g} to {end:g} s: must end after its start")
            )
        first = max(int(np.searchsorted(times, start, side="right")) - 1, 0)
        stop = min(int(np.searchsorted(times, end)) + 1, len(times))
        if start > times[-1] or end < times[0]:
            message = f"{start:g} to {end:g} s is outside the run, {times[0]:g} to {times[-1]:g} s"
            raise InputError(Problem("window", message))
        return cls.thinned(first, stop)

    def rows_of_all(self) -> slice:
        """Return the stored indices of all frames."""
        return slice(self.first, self.first + (self.number - 1) * self.every + 1, self.every)

    def rows(self, first: int, number: int, every: int, width: int) -> slice:
        """Return the stored indices of some frames.

        Parameters
        ----------
        first, number, every : int
            Selected frames: one in `every` from number `first`.
        width : int
            Numbers of a row.

        Raises
        ------
        InputError
            If the frames exceed the largest answer.
        """
        most = LARGEST // (NUMBER * max(width, 1))
        chosen = max(0, min(number, -(-(self.number - first) // every)))
        if number > max(most, 1):
            message = (
                f"asks for {count(number, 'frame')} of {width} numbers; an answer has "
                f"{LARGEST >> 20} MiB, {max(most, 1)} of them: ask for fewer at a time"
            )
            raise InputError(Problem("rows", message))
        start = self.first + first * self.every
        step = every * self.every
        return slice(start, start + (chosen - 1) * step + 1 if chosen else start, step)


def nearest(times: Array, time: float) -> int:
    """Return the index of the instant nearest to a time."""
    after = int(np.clip(np.searchsorted(times, time), 1, max(len(times) - 1, 1)))
    if after >= len(times):
        return len(times) - 1
    return after - int(time - times[after - 1] <= times[after] - time)


def thinned(values: Array, most: int) -> np.ndarray[tuple[int], np.dtype[np.intp]]:
    """Return about `most` instants (m,) that preserve the plot of series (k, nt).

    Each of equal time spans keeps the minimum and the maximum of every series, so that no peak is
    lost; the first and the last instant are kept as well.

    Examples
    --------
    >>> x = np.zeros((1, 1000)); x[0, 555] = 7.0
    >>> 555 in thinned(x, 20), len(thinned(x, 20)) <= 22
    (True, True)
    """
    k, nt = values.shape
    if nt <= most:
        return np.arange(nt)
    spans = max(1, most // (2 * max(k, 1)))
    edges = np.linspace(0, nt, spans + 1).astype(np.intp)
    size = int(np.diff(edges).max())
    # equal spans: repeat the last number of a shorter one
    at = np.minimum(edges[:-1, None] + np.arange(size), edges[1:, None] - 1)
    kept = [np.array([0, nt - 1])]
    for series in values:
        block = np.where(np.isfinite(series), series, 0.0)[at]
        rows = np.arange(spans)
        kept += [at[rows, block.argmin(axis=1)], at[rows, block.argmax(axis=1)]]
    return np.unique(np.concatenate(kept))
