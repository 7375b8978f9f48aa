"""Resampling of records."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from jousto.base.arrays import Array
from jousto.base.errors import Problems, warn

MOST = 50_000_000
"""Maximum number of samples of a resampled record."""

PASS = 0.4
"""Cutoff frequency of the anti-aliasing filter, relative to the new rate."""


def resample(
    where: str,
    time: Array,
    channels: Mapping[str, Array],
    rate: float | None,
    times: ArrayLike | None,
    gap: float,
    antialias: bool,
) -> tuple[Array, dict[str, Array]]:
    """Return instants and channels, see `Record.resample`."""
    problems = Problems()
    if rate is not None and times is not None:
        problems.add(where, "give rate or times, not both")
    if rate is not None:
        problems.positive(where, "rate", rate, "1/s")
    problems.positive(where, "gap", gap, "steps")
    wanted = None if times is None else problems.array(where, "times", times, (None,))
    if wanted is not None and np.any(np.diff(wanted) <= 0.0):
        problems.add(where, "times do not ascend")
    if len(time) < 2:
        problems.add(where, "has a single instant, nothing to interpolate")
    problems.raise_if_any()
    old = float(np.median(np.diff(time)))
    if wanted is None:
        step = old if rate is None else 1.0 / rate
        number = int(np.floor((time[-1] - time[0]) / step * (1 + 1e-12))) + 1
        if number > MOST:
            problems.add(where, f"{number} samples are too many (limit {MOST})")
        problems.raise_if_any()
        wanted = time[0] + step * np.arange(number)
    corner = None
    if antialias and len(wanted) > 1 and (new := float(np.median(np.diff(wanted)))) > 1.01 * old:
        corner = PASS / new
    return wanted, {
        name: _channel((where, name), time, x, wanted, old, gap, corner)
        for name, x in channels.items()
    }


def _channel(
    label: tuple[str, str],
    time: Array,
    x: Array,
    times: Array,
    old: float,
    gap: float,
    corner: float | None,
) -> Array:
    from scipy.interpolate import CubicSpline

    known = np.isfinite(x)
    if np.count_nonzero(known) < 2:
        return np.full(len(times), np.nan)
    source = time[known]
    t, y = source, x[known]
    if corner is not None:
        t, y = _filtered(label, t, y, old, corner)
    out = np.asarray(CubicSpline(t, y)(times))
    out[(times < t[0] - 1e-9 * old) | (times > t[-1] + 1e-9 * old)] = np.nan
    # no values inside a gap
    where = np.clip(np.searchsorted(source, times), 1, known.sum() - 1)
    inside = np.diff(source)[where - 1] > gap * old
    on_a_sample = np.minimum(np.abs(source[where] - times), np.abs(times - source[where - 1]))
    out[inside & (on_a_sample > 1e-9 * old)] = np.nan
    return out


def _filtered(
    label: tuple[str, str], t: Array, y: Array, step: float, corner: float
) -> tuple[Array, Array]:
    """Return uniform samples low-pass filtered at a cutoff frequency, Hz."""
    from scipy.interpolate import CubicSpline
    from scipy.signal import butter, sosfiltfilt

    even = np.arange(t[0], t[-1] + 0.5 * step, step)
    even = even[even <= t[-1]]
    values = CubicSpline(t, y)(even)
    sos = butter(8, min(2.0 * corner * step, 0.99), output="sos")
    if len(even) <= 3 * (2 * len(sos) + 1):
        warn(label[0], f"channel '{label[1]}' is too short to filter before coarser steps")
        return t, y
    return even, np.asarray(sosfiltfilt(sos, values))
