"""Alignment in time of a measured record with a run or another record."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, Problems, warn
from jousto.base.object_repr import described
from jousto.measurement.gauges.record import Record, record_of

if TYPE_CHECKING:
    from jousto.simulation.results.solution import Solution


OVERLAP = 0.25
"""Share of the shorter record that must overlap with the other one."""

MOST = 1 << 22
"""Number of samples of the longer record on the uniform grid of the search."""


@described
@dataclass(frozen=True, eq=False)
class Alignment:
    """Time shift between a record and another one, with its quality.

    Attributes
    ----------
    record : Record
        The record with its time shifted.
    shift : float
        Time that is added to the record's instants, s.
    correlation : float
        Correlation of both channels where they overlap, -1 to 1.
    scale : float
        Factor on the other channel that fits this one best; 1 if gauge factors and signs agree.
    rms : float
        Root mean square of the difference without the factor, in the channel's unit.
    uncertainty : float
        Standard deviation of the shift, s: from the scatter of the events, else from the remaining
        noise.
    """

    record: Record
    shift: float
    correlation: float
    scale: float
    rms: float
    uncertainty: float

    def __str__(self) -> str:
        return (
            f"shift {self.shift:+.6g} s (+- {self.uncertainty:.2g} s), correlation "
            f"{self.correlation:.4f}, scale {self.scale:.4f}, rms of the difference {self.rms:.4g}"
        )


@explained
def align(
    record: Record,
    other: Record | Solution,
    channel: str,
    other_channel: str | None = None,
    *,
    level: float | None = None,
    max_shift: float | None = None,
) -> Alignment:
    """Return the time shift that aligns a record with another record or a run.

    Without a level: the shift of the largest correlation coefficient over the overlap, first on a
    uniform grid by fast Fourier transform, then between its samples on splines. With a level: the
    shift at which both signals cross it at the same times (triggers, light barriers, impacts).

    Parameters
    ----------
    record : Record
        Measured.
    other : Record or Solution
        Reference record or run; its time is unchanged.
    channel, other_channel : str
        Channels to compare; the same name if only one is given.
    level : float, optional
        Value in SI units whose rising crossings are compared.
    max_shift : float, optional
        Largest shift, s.

    Raises
    ------
    InputError
        If channels are missing or constant, nothing overlaps, or a level is never crossed.

    Warns
    -----
    JoustoWarning
        If other shifts fit as well (periodic signals), the correlation is poor, or the signals are
        of opposite sign.
    """
    reference = other if isinstance(other, Record) else record_of(other)
    b = channel if other_channel is None else other_channel
    problems = Problems()
    for where, name in ((record, channel), (reference, b)):
        try:
            x = where[name]
        except InputError as error:
            problems.found += error.problems
            continue
        good = x[np.isfinite(x)]
        if len(good) < 4 or np.ptp(good) == 0.0:
            problems.add(where.name, f"channel '{name}' is constant and cannot be aligned")
    if max_shift is not None:
        problems.positive("align", "max_shift", max_shift, "s")
    problems.raise_if_any()
    if level is None:
        shift = _by_correlation(record, reference, channel, b, max_shift)
        return _make_alignment(record, reference, channel, b, shift, None)
    shift, scatter = _by_events(record, reference, channel, b, level, max_shift)
    return _make_alignment(record, reference, channel, b, shift, scatter)


def _clean(record: Record, channel: str) -> tuple[Array, Array]:
    x = record[channel]
    known = np.isfinite(x)
    return record.time[known], x[known]


def _by_correlation(
    record: Record, reference: Record, a: str, b: str, max_shift: float | None
) -> float:
    from scipy.optimize import minimize_scalar
    from scipy.signal import correlate

    ta, xa = _clean(record, a)
    tb, xb = _clean(reference, b)
    step = min(record.step, reference.step)
    step = max(step, max(np.ptp(ta), np.ptp(tb)) / MOST)
    ga = np.interp(np.arange(ta[0], ta[-1], step), ta, xa)
    gb = np.interp(np.arange(tb[0], tb[-1], step), tb, xb)
    ga, gb = ga - ga.mean(), gb - gb.mean()
    # sums over the overlap for every lag: products, squares, values, counts
    lags = np.arange(-(len(ga) - 1), len(gb))
    one_a, one_b = np.ones(len(ga)), np.ones(len(gb))

    def over(p: Array, q: Array) -> Array:
        return np.asarray(correlate(p, q, mode="full", method="fft"))

    n = np.maximum(np.rint(over(one_b, one_a)), 1.0)
    sab, saa, sbb = over(gb, ga), over(one_b, ga * ga), over(gb * gb, one_a)
    sa, sb = over(one_b, ga), over(gb, one_a)
    va, vb = saa - sa * sa / n, sbb - sb * sb / n
    floor_a = 1e-3 * n * (ga @ ga) / len(ga)
    floor_b = 1e-3 * n * (gb @ gb) / len(gb)
    r = (sab - sa * sb / n) / np.sqrt(np.maximum(va, floor_a) * np.maximum(vb, floor_b))
    shifts = tb[0] - ta[0] + step * lags
    allowed = n >= OVERLAP * min(len(ga), len(gb))
    if max_shift is not None:
        allowed &= np.abs(shifts) <= max_shift + 0.5 * step
    if not np.any(allowed):
        raise InputError(
            Problem("align", f"no shift within {max_shift} s lets the records overlap by a quarter")
        )
    r = np.where(allowed, r, -np.inf)
    i = int(np.argmax(r))
    low = np.where(allowed, r, np.inf)
    if -float(low.min()) > float(r[i]) + 0.05:
        warn(
            "align",
            f"channels '{a}' and '{b}' fit best with opposite sign (correlation {low.min():.3f}); "
            "check the wiring of the bridge or the direction of the gauge",
        )
    else:
        _ambiguous(r, i, shifts, a)
    # refine the shift between the samples of the grid
    lower, upper = shifts[i] - step, shifts[i] + step
    found = minimize_scalar(
        lambda s: -_correlation(record, reference, a, b, float(s))[0],
        bounds=(lower, upper),
        method="bounded",
        options={"xatol": 1e-6 * step},
    )
    return float(found.x)


def _ambiguous(r: Array, i: int, shifts: Array, channel: str) -> None:
    """Warn if another peak of the correlation is nearly as high."""
    peaks = np.flatnonzero((r[1:-1] >= r[:-2]) & (r[1:-1] > r[2:])) + 1
    rivals = [k for k in peaks if k != i and r[k] > 0.99 * r[i] and abs(k - i) > 2]
    if rivals:
        second = min(rivals, key=lambda k: -r[k])
        warn(
            "align",
            f"channel '{channel}': a shift of {shifts[second]:.4g} s fits as well as "
            f"{shifts[i]:.4g} s ({r[second]:.3f} to {r[i]:.3f}), the signal repeats itself; give "
            "max_shift or align by an event",
        )


def _spline(t: Array, x: Array) -> Any:
    from scipy.interpolate import CubicSpline

    return CubicSpline(t, x)


def _correlation(
    record: Record, reference: Record, a: str, b: str, shift: float
) -> tuple[float, float, float, Array, Array, Array]:
    """Return correlation, scale, rms and the overlapping values at a shift."""
    ta, xa = _clean(record, a)
    tb, xb = _clean(reference, b)
    # interpolate the finer record at the instants of the coarser one
    fine = record.step <= reference.step
    if fine:
        at = tb[(tb >= ta[0] + shift) & (tb <= ta[-1] + shift)]
        u = _spline(ta, xa)(at - shift)
        v = xb[(tb >= ta[0] + shift) & (tb <= ta[-1] + shift)]
    else:
        inside = (ta + shift >= tb[0]) & (ta + shift <= tb[-1])
        at = ta[inside] + shift
        u, v = xa[inside], _spline(tb, xb)(at)
    if len(at) < 4:
        return -1.0, np.nan, np.nan, at, u, v
    du, dv = u - u.mean(), v - v.mean()
    uu, vv, uv = float(du @ du), float(dv @ dv), float(du @ dv)
    r = uv / np.sqrt(uu * vv) if uu > 0.0 and vv > 0.0 else 0.0
    scale = uv / vv if vv > 0.0 else np.nan
    return r, scale, float(np.sqrt(np.mean((u - v) ** 2))), at, u, v


def _by_events(
    record: Record, reference: Record, a: str, b: str, level: float, max_shift: float | None
) -> tuple[float, float]:
    ta, tb = record.crossings(a, level), reference.crossings(b, level)
    problems = Problems()
    for times, name, where in ((ta, a, record), (tb, b, reference)):
        if not len(times):
            x = where[name]
            problems.add(
                where.name,
                f"channel '{name}' never rises through {level:g}; it goes from {np.nanmin(x):.4g} "
                f"to {np.nanmax(x):.4g}",
            )
    problems.raise_if_any()
    best: tuple[float, float, float] | None = None
    # events may be missing at either end
    for k in range(-(len(ta) - 1), len(tb)):
        i, j = max(0, -k), max(0, k)
        m = min(len(ta) - i, len(tb) - j)
        differences = tb[j : j + m] - ta[i : i + m]
        shift = float(np.median(differences))
        if max_shift is not None and abs(shift) > max_shift:
            continue
        scatter = float(np.std(differences))
        # prefer the shift at which more events agree
        score = (scatter + record.step) / m
        if best is None or score < best[0]:
            best = (score, shift, scatter / np.sqrt(m))
    if best is None:
        raise InputError(Problem("align", f"no shift within {max_shift} s matches any events"))
    return best[1], best[2]


def _make_alignment(
    record: Record, reference: Record, a: str, b: str, shift: float, scatter: float | None
) -> Alignment:
    r, scale, rms, at, u, v = _correlation(record, reference, a, b, shift)
    if scatter is None:
        # standard deviation of the shift: residual noise divided by the rms slope of the signal
        slope = np.gradient(v, at)
        noise = u - u.mean() - scale * (v - v.mean())
        size = float(np.sqrt(np.sum((scale * slope) ** 2)))
        scatter = float(np.std(noise)) / size if size > 0.0 else float("nan")
    if r < 0.5:
        warn(
            "align",
            f"channels '{a}' and '{b}' hardly agree at any shift (correlation {r:.3f}); check that "
            "they are the same gauge",
        )
    return Alignment(record.shifted(shift), shift, r, scale, rms, scatter)
