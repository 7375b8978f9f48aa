"""Published and independent cases of planar beams: spin-up of a hub, and a soft pendulum.

The spin-up is that of J. C. Simo, L. Vu-Quoc, *J. Appl. Mech.* 53 (1986) 855-863, here without
shear and rotary inertia. Numbers are those of an independent program with cubic elements of order 4
and an integrator of order 8, extrapolated.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jousto.planar.dynamics import simulate_planar
from jousto.planar.element import PlanarElement
from jousto.planar.frame import PlanarFrame
from jousto.planar.items import PlanarMotion, PlanarSupport
from jousto.planar.methods import PlanarNewmark
from jousto.planar.results import PlanarRun
from jousto.planar.section import PlanarSection
from planar.frames import chain

Array = NDArray[Any]
BLADE = PlanarSection(EA=2.8e7, GA=math.inf, EI=1.4e4, mass=1.2)
ROPE = PlanarSection(EA=4e4, GA=math.inf, EI=0.4, mass=0.5)
SPIN_TIMES, SPIN = (5.0, 7.5, 10.0, 15.0), (-0.46844198, -0.55903917, -0.36276537, 0.00129028)
SWING_TIMES = (0.3, 0.5, 0.9)
SWING = ((0.96030292, -0.23858980), (0.40216446, -0.91394326), (-0.98098135, -0.18185657))
WAVE = 2.0 * math.pi / 15.0


def hub(t: float) -> tuple[float, float, float]:
    """Angle of the hub with its rates: ``phi' = (2/5) (t - sin(w t)/w)``, w = 2 pi / 15 s."""
    angle = 0.4 * (0.5 * t**2 + (math.cos(WAVE * t) - 1.0) / WAVE**2)
    return angle, 0.4 * (t - math.sin(WAVE * t) / WAVE), 0.4 * (1.0 - math.cos(WAVE * t))


def spin_up(element: PlanarElement | str, n: int, step: float, t_end: float = 15.0) -> PlanarRun:
    """Turn a blade of 10 m on a hub to 6 rad/s."""
    frame = chain(
        n,
        10.0,
        BLADE,
        supports=[PlanarSupport(0)],
        motions=[PlanarMotion(0, rotation=hub)],
        element=element,
    )
    return simulate_planar(frame, t_end, PlanarNewmark(step))


def across(run: PlanarRun, times: Any) -> Array:
    """Displacement of the end of the blade across the axis of the turned hub."""
    rows = [int(np.argmin(abs(run.time - t))) for t in times]
    angles = np.array([hub(t)[0] for t in times])
    x, y = run.positions[rows, -1].T
    return np.asarray(-x * np.sin(angles) + y * np.cos(angles))


def smooth_gravity(t: float) -> float:
    """Share of gravity: from 0 to 1 in 0.2 s, three times differentiable at both ends."""
    x = min(t / 0.2, 1.0)
    return x**4 * (35.0 - 84.0 * x + 70.0 * x**2 - 20.0 * x**3)


def pendulum(element: PlanarElement | str, n: int) -> PlanarFrame:
    """A soft pendulum of 1 m, straight and level at first."""
    return chain(
        n,
        1.0,
        ROPE,
        supports=[PlanarSupport(0)],
        gravity=(0.0, -9.81),
        gravity_signal=smooth_gravity,
        element=element,
    )


def swing(element: PlanarElement | str, n: int, step: float, t_end: float = 0.9) -> Array:
    """Positions of the end of the pendulum at `SWING_TIMES`, (times, 2), m."""
    run = simulate_planar(pendulum(element, n), t_end, PlanarNewmark(step))
    rows = [int(np.argmin(abs(run.time - t))) for t in SWING_TIMES if t <= t_end + 1e-9]
    return np.asarray(run.positions[rows, -1])


def extrapolated(f: Any, step: float) -> Array:
    """Richardson extrapolation in the step of a method of order 2."""
    coarse, fine = f(step), f(0.5 * step)
    return np.asarray((4.0 * fine - coarse) / 3.0)
