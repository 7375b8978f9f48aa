"""Measured signals: checks, noise, and errors of gauges."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy.linalg as la

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import LARGE_STRAIN, InputError, Problems, count, strain_remedy
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.sensors.gauge import Gauge, outward

LARGEST = LARGE_STRAIN
"""Largest plausible elastic strain, m/m."""


TURN = 1e-2
"""Step of the derivative by the direction, rad."""


def read_strain(
    problems: Problems, where: str, e: Any, names: Sequence[str], strains: int | None = None
) -> Array | None:
    """Return strains (nt, ng), nan for missing gauges, and add their problems.

    Parameters
    ----------
    problems, where
        Collector of problems, and the place in messages.
    e : array_like
        Strains, m/m, one column for each channel.
    names : sequence of str
        The channels.
    strains : int, optional
        Number of leading channels that are strains; by default all.
    """
    if (
        isinstance(e, np.ndarray)
        and e.dtype == np.float64
        and e.shape == (len(names),)
        and bool((np.abs(e[:strains]) <= LARGEST).all())
        and bool(np.isfinite(e).all())
    ):
        return e[None]  # one sample of a stream
    try:
        strain = np.atleast_2d(np.array(e, dtype=np.float64))
    except (TypeError, ValueError):
        problems.add(where, "e is not an array of numbers, one row per instant")
        return None
    ng = len(names)
    if strain.ndim != 2 or strain.shape[1] != ng:
        turned = strain.ndim == 2 and strain.shape[0] == ng and strain.shape[1] != ng
        problems.add(
            where,
            f"e has shape {strain.shape}, must be (instants, {ng}): one column for each of "
            f"{', '.join(names[:6])}{', ...' if ng > 6 else ''}"
            + ("; it looks transposed, give e.T" if turned else ""),
        )
        return None
    endless = np.argwhere(np.isinf(strain))
    if len(endless):
        row, column = endless[0]
        problems.add(
            where,
            f"channel '{names[column]}' is infinite at row {row}; give nan for missing values",
        )
        return None
    part = strain[:, : ng if strains is None else strains]
    size = np.nanmax(np.abs(part), axis=0, initial=0.0) if part.size else np.zeros(0)
    size = np.nan_to_num(size)
    if len(size) and size.max() > LARGEST:
        worst = int(size.argmax())
        problems.add(
            where,
            f"strain of '{names[worst]}' reaches {size[worst]:.4g} m/m, "
            f"{100 * size[worst]:.4g} %, which no elastic part can have; it looks like "
            f"{strain_remedy(float(size[worst]))}",
        )
        return None
    return strain


def read_time(problems: Problems, where: str, time: Any, strain: Array | None) -> Array | None:
    """Return the instants (0, 1, 2 .. by default), and add their problems."""
    nt = 0 if strain is None else len(strain)
    if time is None:
        return np.arange(nt, dtype=np.float64)
    t = problems.array(where, "time", np.atleast_1d(np.asarray(time)), (None,))
    if t is None or strain is None:
        return t
    if len(t) != nt:
        problems.add(where, f"{count(len(t), 'time')} for {count(nt, 'row')} of strain")
        return None
    back = np.flatnonzero(np.diff(t) <= 0.0)
    if len(back):
        k = int(back[0])
        problems.add(
            where,
            f"time runs backwards or stands still: {t[k]:.9g} s is followed by {t[k + 1]:.9g} s "
            f"(row {k + 1}, {count(len(back), 'place')} in all); sort the record",
        )
        return None
    return t


def read_noise(
    problems: Problems, where: str, key: str, value: Any, size: int, unit: str, largest: float
) -> Array | None:
    """Return a covariance matrix from standard deviations or a matrix; add its problems."""
    try:
        given = np.array(value, dtype=np.float64)
    except (TypeError, ValueError):
        problems.add(where, f"{key} is {value!r}, must be standard deviations in {unit}")
        return None
    if given.ndim < 2:
        if given.ndim == 1 and given.shape != (size,):
            problems.add(where, f"{key} has {len(given)} values, must be 1 or {size}")
            return None
        bad = given[~(np.isfinite(given) & (given > 0.0))]
        if bad.size:
            problems.add(
                where,
                f"{key} is {bad.flat[0]:g} {unit}, must be positive: a gauge without noise would "
                "make all others and the model worthless"
                if key == "noise"
                else f"{key} is {bad.flat[0]:g} {unit}, must be positive",
            )
            return None
        if given.max() > largest:
            problems.add(
                where,
                f"{key} is {given.max():g} {unit}; standard deviations are in {unit}, a good gauge "
                "has 1e-6",
            )
            return None
        return np.diag(np.broadcast_to(given**2, (size,)))
    if given.shape != (size, size) or not np.isfinite(given).all():
        problems.add(where, f"{key} has shape {given.shape}, must be finite of ({size}, {size})")
        return None
    if not np.allclose(given, given.T, rtol=1e-8, atol=1e-12 * np.abs(given).max(initial=0.0)):
        problems.add(where, f"{key} is a covariance matrix, but not symmetric")
        return None
    even = 0.5 * (given + given.T)
    least = la.eigvalsh(even)[0]
    floor = 0.0 if key == "noise" else -1e-10 * np.abs(even).max(initial=0.0)
    if least < floor or (key == "noise" and least <= 0.0):
        problems.add(
            where, f"{key} is not a covariance matrix: its smallest eigenvalue is {least:.3g}"
        )
        return None
    return np.asarray(even)


class GaugeErrors(Declared, kw_only=True):
    """Standard deviations of errors that are constant over a record."""

    scale: Number = field(
        "Relative error of all stress: modulus, common gauge factor; see `stress_band`",
        least=0,
        below=1,
        wanted="from 0 to below 1",
        default=0.0,
    )
    factor: Number = field(
        "Relative error of each gauge factor; see `gauge_errors`",
        least=0,
        below=1,
        wanted="from 0 to below 1",
        default=0.0,
    )
    position: Number = field(
        "Position error of each gauge", unit="m", least=0, wanted="0 or positive", default=0.0
    )
    angle: Number = field(
        "Angle error of each gauge",
        unit="rad",
        least=0,
        most=0.5,
        wanted="from 0 to 0.5",
        default=0.0,
    )


@explained
def gauge_errors(
    gauges: Sequence[Gauge],
    *,
    factor: float = 0.0,
    position: float = 0.0,
    angle: float = 0.0,
) -> Array:
    """Return the standard deviation of each gauge's error in strain per unit mode.

    ``factor B_g``, ``position dB_g/dx`` and ``angle dB_g/dtheta``: the derivatives are differences
    of the strain field of the modes, along the grid (beams and solids) and, of solids, across it.

    Parameters
    ----------
    gauges : sequence of Gauge
        The ng gauges, in their order.
    factor : float
        Relative deviation of each gauge factor; a common error belongs to ``stress_band(scale=)``.
    position : float
        Deviation of the position in each direction of the surface, m.
    angle : float
        Deviation of the angle about the normal of the surface, rad.

    Returns
    -------
    (k, ng, n) array
        For ``Reconstruction(errors=)``: k kinds of error, each independent from gauge to gauge.

    Raises
    ------
    InputError
        If a standard deviation is negative or not small.

    Examples
    --------
    Along a cantilever under a load at its end the strain falls in proportion to the distance:

    >>> import jousto as jo
    >>> beam = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 10, jo.Material(2.1e11, 0.3, 7850.0))
    >>> free = jo.reduce(beam, jo.CraigBampton(("start", "end"), modes=0))
    >>> rod = jo.reduction.clamp(free, "start")
    >>> gauge = jo.gauges.Gauge("g", rod, (0.5, 0.0, 0.005))
    >>> gauge_errors([gauge], factor=0.01, position=2e-3).shape
    (2, 1, 6)
    """
    problems = Problems()
    where = "gauge_errors"
    for key, value in (("factor", factor), ("position", position), ("angle", angle)):
        GaugeErrors.fields[key].check(problems, where, value)
    if not gauges:
        problems.add(where, "there is no gauge")
    problems.raise_if_any()
    found = []
    if factor:
        found.append([factor * gauge.rows for gauge in gauges])
    if position:
        found.append(
            [position * _position_derivative(gauge, gauge.axis, position) for gauge in gauges]
        )
        across = [_across_grid(gauge) for gauge in gauges]
        if all(direction is not None for direction in across):
            pairs = zip(gauges, across, strict=True)
            found.append(
                [position * _position_derivative(g, d, position) for g, d in pairs if d is not None]
            )
    if angle:
        found.append([angle * _angle_derivative(gauge) for gauge in gauges])
    n = gauges[0].rows.shape[1]
    return np.array(found).reshape(-1, len(gauges), n)


def _rows(gauge: Gauge, at: Array, direction: Array) -> Array:
    """Return the row (1, n) of a gauge at another place."""
    return Gauge(
        gauge.name,
        gauge.reduced,
        at,
        direction,
        length=gauge.length,
        width=gauge.width,
        transverse=gauge.transverse,
        reach=gauge.reach,
        E=gauge.E,
        nu=gauge.nu,
    ).rows


def _position_derivative(gauge: Gauge, direction: Array, h: float) -> Array:
    """Return the derivative of the row by the position, per m; one-sided at edges."""
    ends, span = [], 0.0
    for sign in (1.0, -1.0):
        try:
            ends.append(_rows(gauge, gauge.position + sign * h * direction, gauge.axis))
            span += h
        except InputError:  # edge of the surface
            ends.append(gauge.rows)
    if not span:
        # raises the InputError with its reason
        _rows(gauge, gauge.position + h * direction, gauge.axis)
    return (ends[0] - ends[1]) / span


def _across_grid(gauge: Gauge) -> Array | None:
    """Return the in-surface direction across the grid; None on beams."""
    if not gauge.reduced.faces:
        return None
    return np.asarray(np.cross(outward(gauge), gauge.axis))


def _angle_derivative(gauge: Gauge) -> Array:
    """Return the derivative of the row by the angle about the normal, per rad."""
    across = np.cross(outward(gauge), gauge.axis)
    c, s = math.cos(TURN), math.sin(TURN)
    left, right = (
        _rows(gauge, gauge.position, c * gauge.axis + sign * s * across) for sign in (1.0, -1.0)
    )
    return np.asarray((left - right) / (2.0 * TURN))
