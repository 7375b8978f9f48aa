"""Instants of a run: those in a time span, and those around a given time."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array, Index
from jousto.base.errors import InputError, Problem


def window(time: Array, start: float | None, end: float | None, where: str) -> slice:
    """Return the slice of the instants from `start` to `end`, s.

    Raises
    ------
    InputError
        If there is no instant in this span.
    """
    slack = 1e-9 * max(float(time[-1] - time[0]), 1e-300)
    first = 0 if start is None else int(np.searchsorted(time, start - slack))
    last = len(time) if end is None else int(np.searchsorted(time, end + slack, side="right"))
    if first >= last:
        shown = f"{time[0] if start is None else start:g} to {time[-1] if end is None else end:g} s"
        message = f"no instant from {shown}; the run has {time[0]:g} to {time[-1]:g} s"
        raise InputError(Problem(where, message))
    return slice(first, last)


def bracket_instants(time: Array, times: ArrayLike, where: str) -> tuple[Index, Index, Array]:
    """Return the indices of the instants around each time, and the weight of the later one.

    Raises
    ------
    InputError
        If there are no times, or a time is outside the run or not a number.
    """
    wanted = np.atleast_1d(np.asarray(times, dtype=np.float64))
    if not wanted.size:
        raise InputError(Problem(where, "name at least one instant; times is empty"))
    slack = 1e-9 * max(float(time[-1] - time[0]), 1e-300)
    bad = wanted[~((wanted >= time[0] - slack) & (wanted <= time[-1] + slack))]
    if len(bad):
        message = f"{bad[0]:g} s is outside the run of {time[0]:g} to {time[-1]:g} s"
        raise InputError(Problem(where, message))
    if len(time) == 1:
        none = np.zeros(len(wanted), dtype=np.intp)
        return none, none, np.zeros(len(wanted))
    after = np.clip(np.searchsorted(time, wanted), 1, len(time) - 1)
    before = after - 1
    share = np.clip((wanted - time[before]) / (time[after] - time[before]), 0.0, 1.0)
    return before, after, share
