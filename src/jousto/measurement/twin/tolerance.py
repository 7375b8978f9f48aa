"""What a gauge may be wrong by: its factor, its place, its direction."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.declare import Declared
from jousto.base.errors import InputError, Problems
from jousto.base.fields import field
from jousto.base.numbers import Number
from jousto.mechanism.sensors.gauge import Gauge, outward

TURN = 1e-2
"""Angle of the difference for the derivative by the direction, rad."""


class GaugeErrors(Declared, kw_only=True):
    """Standard deviations of errors that stay through a record and that no record shows."""

    scale: Number = field(
        "Of all stress, relative: modulus, common gauge factor, as of `stress_band`",
        least=0,
        below=1,
        wanted="from 0 to below 1",
        default=0.0,
    )
    factor: Number = field(
        "Of each gauge's factor, relative, as of `gauge_errors`",
        least=0,
        below=1,
        wanted="from 0 to below 1",
        default=0.0,
    )
    position: Number = field(
        "Of each gauge's place", unit="m", least=0, wanted="0 or positive", default=0.0
    )
    angle: Number = field(
        "Of each gauge's direction",
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
    """Return the standard deviation of the strain that each gauge shows wrongly, per mode.

    ``factor B_g``, ``position dB_g/dx`` and ``angle dB_g/dtheta``: the derivatives are differences
    of the strain field of the modes, along the grid (beams and solids) and, of solids, across it.

    Parameters
    ----------
    gauges : sequence of Gauge
        The ng gauges, in their order.
    factor : float
        Relative, of each gauge for itself; what all share belongs to ``stress_band(scale=)``.
    position : float
        m, in each direction of the surface.
    angle : float
        rad, about the normal of the surface.

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
        found.append([position * _slope(gauge, gauge.axis, position) for gauge in gauges])
        across = [_across(gauge) for gauge in gauges]
        if all(direction is not None for direction in across):
            pairs = zip(gauges, across, strict=True)
            found.append([position * _slope(g, d, position) for g, d in pairs if d is not None])
    if angle:
        found.append([angle * _turn(gauge) for gauge in gauges])
    n = gauges[0].rows.shape[1]
    return np.array(found).reshape(-1, len(gauges), n)


def _rows(gauge: Gauge, at: Array, direction: Array) -> Array:
    """Return the row (1, n) of a gauge that sticks elsewhere."""
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


def _slope(gauge: Gauge, direction: Array, h: float) -> Array:
    """Return the derivative of the row by the position, per m; one-sided at edges."""
    ends, span = [], 0.0
    for sign in (1.0, -1.0):
        try:
            ends.append(_rows(gauge, gauge.position + sign * h * direction, gauge.axis))
            span += h
        except InputError:  # the surface ends there
            ends.append(gauge.rows)
    if not span:
        _rows(gauge, gauge.position + h * direction, gauge.axis)  # says why
    return (ends[0] - ends[1]) / span


def _across(gauge: Gauge) -> Array | None:
    """Return the direction across the grid along the surface, None on beams."""
    if not gauge.reduced.faces:
        return None
    return np.asarray(np.cross(outward(gauge), gauge.axis))


def _turn(gauge: Gauge) -> Array:
    """Return the derivative of the row by the angle about the normal, per rad."""
    across = np.cross(outward(gauge), gauge.axis)
    c, s = math.cos(TURN), math.sin(TURN)
    left, right = (
        _rows(gauge, gauge.position, c * gauge.axis + sign * s * across) for sign in (1.0, -1.0)
    )
    return np.asarray((left - right) / (2.0 * TURN))
