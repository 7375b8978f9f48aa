"""Losses of the stress at hot spots of a machine with a simpler body, and of its damage."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicSpline

from jousto.base.arrays import Array
from jousto.design.flexibility.body_advice import ReadingAdvice
from jousto.design.flexibility.comparison import Comparison, common, reading_scale
from jousto.design.flexibility.expected import AROUND, jump
from jousto.design.flexibility.hot_spot_readings import (
    HotSpotReading,
    damage_ratio,
    hot_spot_reading,
    stress_of_modes,
)
from jousto.design.flexibility.reading_loss import reading_loss
from jousto.mechanism.bodies.body import FlexibleBody
from jousto.mechanism.mechanism import Mechanism
from jousto.reduction.stress_sites import located

NO_RANGE = 1e-9
"""Range / largest stress, below which a stress has no range."""


def stress_losses(comparison: Comparison, mechanism: Mechanism) -> Iterator[ReadingAdvice]:
    """Yield the losses of the stress at the hot spot of each flexible body that has stress data.

    Parameters
    ----------
    comparison : Comparison
    mechanism : Mechanism
        The full machine.
    """
    for body in mechanism.bodies:
        if isinstance(body, FlexibleBody) and (modes := located(body.reduced)) is not None:
            deformation = _full_deformation(comparison, body.name)
            if deformation is None:
                continue
            time, p = deformation
            spot = hot_spot_reading(body.name, modes, p, time, comparison.rules)
            if comparison.is_wanted(spot.name, f"stress {body.name}"):
                yield _loss(comparison, spot, time, p)


def _full_deformation(comparison: Comparison, body: str) -> tuple[Array, Array] | None:
    """Return instants and modal coordinates of a body, measured or static; None if unknown."""
    if comparison.full is not None:
        run = comparison.full.run
        return run.time, run.coordinates(body)[:, 7:]
    if comparison.expected is None:
        return None
    return comparison.expected.held.time, comparison.expected.deformation(body)


def _loss(comparison: Comparison, spot: HotSpotReading, time: Array, p: Array) -> ReadingAdvice:
    """Return the loss of the stress at a hot spot."""
    y, expected = spot.history(p), comparison.expected
    simple, recovered = _simple_history(comparison, spot)
    estimate, measured, life = float("nan"), None, float("nan")
    if expected is not None:
        static = spot.history(expected.deformation(spot.body))
        vibrating = [spot.history(x) for x in expected.vibrations(spot.body)]
        base = static if simple is None else np.interp(expected.held.time, *simple)
        # the static deformation is known at fewer instants: a jump is looked for at the start alone
        known = static[:AROUND] if simple is None or recovered else simple[1]
        estimate = expected.upper(base, static, vibrating, jump(known, "Pa"))
        estimate += expected.static_drift(static)
    if comparison.full is not None and simple is not None:
        t, full, other = common(time, y, *simple)
        measured = reading_loss(t, full, other, floor=NO_RANGE * float(np.abs(full).max()))
        life = damage_ratio(spot.damage(simple[1]), spot.damage(y))
    floor = NO_RANGE * float(np.abs(y).max())
    scale = reading_scale(y, floor)
    return ReadingAdvice(spot.name, "Pa", measured, estimate, scale, life, recovered, floor)


def _simple_history(
    comparison: Comparison, spot: HotSpotReading
) -> tuple[tuple[Array, Array] | None, bool]:
    """Return instants and stress in the simpler run, and whether it is that of statics.

    A rigid body has the stress of its static deformation, by inertia relief.
    """
    simple = comparison.simple
    body = next(one for one in simple.mechanism.bodies if one.name == spot.body)
    if isinstance(body, FlexibleBody):
        modes = located(body.reduced)
        assert modes is not None
        p = simple.run.coordinates(spot.body)[:, 7:]
        chosen = modes.select(np.array([modes.labels.index(spot.site)]))
        return (simple.run.time, stress_of_modes(chosen, p)), False
    expected = comparison.expected
    if expected is None:
        return None, True
    # between the instants of the estimate by a spline, so that no cycle is lost
    p = expected.deformation(spot.body)
    if comparison.full is None or len(expected.held.time) == simple.run.nt:
        return (expected.held.time, spot.history(p)), True
    time = simple.run.time
    return (time, spot.history(CubicSpline(expected.held.time, p)(time))), True
