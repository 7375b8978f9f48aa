"""Impacts in a run: stops that are hit, drives whose velocity jumps, and other jumps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from jousto.base.arrays import Array
from jousto.base.rounding import STANDARD_GRAVITY
from jousto.model.model import Model
from jousto.model.native.native import Engine
from jousto.model.scales import velocity_metres
from jousto.simulation.results.solution import Solution
from jousto.simulation.state import put

JUMP = 0.02
"""Jump of velocities / largest velocity, from which on it is an impact."""
PUSHED = 1e-12
"""Force of a stop / weight of the machine, from which on the stop is hit."""
FEWEST = 5
"""Number of instants below which no jump is looked for."""
HALVES = 40
"""Number of halvings of an interval in search of a jump of a drive."""
CANDIDATES = 8
"""Number of intervals that are halved, those with the largest changes of the rate."""


def has_impact(model: Model, run: Solution) -> bool:
    """Return whether a stop is hit, the velocity of a drive jumps, or another velocity does.

    An impact excites all frequencies of the bodies, so that a rigid body may lose everything.

    Parameters
    ----------
    model : Model
        Model of the run.
    run : Solution
    """
    engine = Engine(replace(model, tree=()))
    stops = [i for i, force in enumerate(model.forces) if force.element == "stop"]
    weight = sum(float(np.real(b.mass[0])) for b in model.bodies) * STANDARD_GRAVITY
    metres = velocity_metres(model)
    v, a, pushed = [], [], 0.0
    for state in run.each_state():
        engine.lam[:] = 0.0
        put(engine, replace(state, work=None), run.where)
        v.append(np.array(engine.v) * metres)
        a.append(np.array(engine.accelerations()[0]) * metres)
        for k in range(len(model.bodies)) if stops else ():
            pushed = max(pushed, float(np.abs(engine.body_loads(k)[stops]).max()))
    if pushed > PUSHED * weight:
        return True
    return (
        velocity_jump(run.time, np.array(v), np.array(a)) > JUMP or drive_jump(engine, run) > JUMP
    )


def velocity_jump(time: Array, v: Array, a: Array) -> float:
    """Return the largest jump of velocities / largest velocity.

    A change of velocity between two instants is a jump as far as the trapezoidal rule with the
    accelerations, and their whole change in the interval, do not explain it.

    Parameters
    ----------
    time : (nt,) array
        Instants, s.
    v, a : (nt, n) array
        Velocities, m/s, and accelerations, m/s2.
    """
    largest = float(np.abs(v).max(initial=0.0))
    if largest == 0.0 or len(time) < FEWEST:
        return 0.0
    step = np.diff(time)[:, None]
    gap = np.abs(np.diff(v, axis=0) - 0.5 * step * (a[1:] + a[:-1]))
    return float((gap - step * np.abs(np.diff(a, axis=0))).max(initial=0.0) / largest)


def drive_jump(engine: Engine, run: Solution) -> float:
    """Return the largest jump of the rate of a drive / its largest rate in the run.

    Intervals with the largest changes are halved: the change of a smooth rate vanishes, a jump
    remains.
    """
    time = run.time

    def rates(t: float) -> Array:
        engine.time[0], engine.v[:] = t, 0.0
        return np.array(engine.constraints()[1].real)

    values = np.array([rates(t) for t in time])
    largest = np.abs(values).max(axis=0, initial=0.0)
    worst = 0.0
    for row in np.flatnonzero(largest > 0.0):
        changes = np.abs(np.diff(values[:, row]))
        for k in np.argsort(-changes, kind="stable")[:CANDIDATES]:
            left, right = float(time[k]), float(time[k + 1])
            first, last = values[k, row], values[k + 1, row]
            for _ in range(HALVES):
                middle = 0.5 * (left + right)
                rate = rates(middle)[row]
                if abs(rate - first) >= abs(last - rate):
                    right, last = middle, rate
                else:
                    left, first = middle, rate
            worst = max(worst, float(abs(last - first) / largest[row]))
    return worst
