"""Records at other instants."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jousto.base.errors import Problems, warn

if TYPE_CHECKING:
    from jousto.measurement.gauges.record import Record

Array = NDArray[np.float64]

MOST = 50_000_000
"""Samples that a record may get."""

PASS = 0.4
"""Corner of the filter, of the new rate."""


def resample(
    record: Record, rate: float | None, times: ArrayLike | None, gap: float, antialias: bool
) -> Record:
    """See `Record.resample`."""
    problems = Problems()
    if rate is not None and times is not None:
        problems.add(record.name, "give rate or times, not both")
    if rate is not None:
        problems.positive(record.name, "rate", rate, "1/s")
    problems.positive(record.name, "gap", gap, "steps")
    wanted = None if times is None else problems.array(record.name, "times", times, (None,))
    if wanted is not None and np.any(np.diff(wanted) <= 0.0):
        problems.add(record.name, "times do not ascend")
    if len(record) < 2:
        problems.add(record.name, "has a single instant, nothing to interpolate")
    problems.raise_if_any()
    if wanted is None:
        step = record.step if rate is None else 1.0 / rate
        number = int(np.floor((record.time[-1] - record.time[0]) / step * (1 + 1e-12))) + 1
        if number > MOST:
            problems.add(record.name, f"{number} samples are too many (limit {MOST})")
        problems.raise_if_any()
        wanted = record.time[0] + step * np.arange(number)
    channels = {
        name: _channel(record, name, x, np.asarray(wanted), gap, antialias)
        for name, x in record.channels.items()
    }
    return replace(record, time=wanted, channels=channels)


def _channel(
    record: Record, name: str, x: Array, times: Array, gap: float, antialias: bool
) -> Array:
    from scipy.interpolate import CubicSpline

    known = np.isfinite(x)
    if np.count_nonzero(known) < 2:
        return np.full(len(times), np.nan)
    t, y = record.time[known], x[known]
    old, new = record.step, float(np.median(np.diff(times))) if len(times) > 1 else record.step
    if antialias and new > 1.01 * old:
        t, y = _filtered(record, name, t, y, old, PASS / new)
    out = np.asarray(CubicSpline(t, y)(times))
    out[(times < t[0] - 1e-9 * old) | (times > t[-1] + 1e-9 * old)] = np.nan
    # inside a gap nothing is known
    where = np.clip(np.searchsorted(record.time[known], times), 1, known.sum() - 1)
    source = record.time[known]
    inside = np.diff(source)[where - 1] > gap * old
    on_a_sample = np.minimum(np.abs(source[where] - times), np.abs(times - source[where - 1]))
    out[inside & (on_a_sample > 1e-9 * old)] = np.nan
    return out


def _filtered(
    record: Record, name: str, t: Array, y: Array, step: float, corner: float
) -> tuple[Array, Array]:
    """Return even samples without what is above a corner frequency, Hz."""
    from scipy.interpolate import CubicSpline
    from scipy.signal import butter, sosfiltfilt

    even = np.arange(t[0], t[-1] + 0.5 * step, step)
    even = even[even <= t[-1]]
    values = CubicSpline(t, y)(even)
    sos = butter(8, min(2.0 * corner * step, 0.99), output="sos")
    if len(even) <= 3 * (2 * len(sos) + 1):
        warn(record.name, f"channel '{name}' is too short to filter before coarser steps")
        return t, y
    return even, np.asarray(sosfiltfilt(sos, values))
