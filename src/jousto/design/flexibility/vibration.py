"""Vibration of elastic bodies under the loads of a rigid run: history, frequency and bounds."""

from __future__ import annotations

import numpy as np

from jousto.base.arrays import Array
from jousto.design.flexibility.quasi_static import HeldBodies

NOTICED = 0.05
"""Share of the energy of the loads above their highest frequency."""
STEADY = 1e-9
"""Largest change of the loads / their largest value, below which they are constant."""


def highest_frequency(time: Array, loads: Array) -> float:
    """Return the frequency W, rad/s, above which loads have NOTICED of their energy.

    Energy of the Fourier series over the run, without mean value and without the straight line
    between first and last value.

    Parameters
    ----------
    time : (nt,) array
        Instants, s.
    loads : (nt, n) array
        Loads as square roots of energies.
    """
    count = len(time)
    if count < 3:
        return 0.0
    even = np.linspace(time[0], time[-1], count)
    values = np.stack([np.interp(even, time, x) for x in loads.T], axis=1)
    line = np.linspace(0.0, 1.0, count)[:, None]
    rest = values - (1.0 - line) * values[0] - line * values[-1]
    if np.abs(rest).max(initial=0.0) <= STEADY * np.abs(values).max(initial=0.0):
        return 0.0
    # the last instant repeats the first one of a period
    energy = (np.abs(np.fft.rfft(rest[:-1], axis=0)) ** 2).sum(axis=1)
    energy[0] = 0.0
    above = np.cumsum(energy[::-1])[::-1]
    k = int(np.flatnonzero(above >= NOTICED * above[0])[-1])
    return float(2.0 * np.pi * k / (time[-1] - time[0]))


def vibration(
    held: HeldBodies, start: Array, rate_at_start: Array, factor: float = 1.0
) -> tuple[Array, Array]:
    """Return deformation and its rate under the loads of a rigid run, (nt, n) each.

    Each natural mode is an oscillator ``c'' + 2 zeta w c' + w^2 c = w^2 c_static``, integrated
    exactly between instants for a static deformation that is linear there (Duhamel's integral).

    Parameters
    ----------
    held : HeldBodies
    start, rate_at_start : (n,) array
        Deformation and its rate at the first instant.
    factor : float
        Factor on all natural frequencies.
    """
    p, time = held.static, held.time
    slope = np.diff(p, axis=0) / np.diff(time)[:, None]
    out, rate = np.array(p), np.zeros_like(p)
    z, dz = start - p[0], rate_at_start - slope[0]
    out[0], rate[0] = start, rate_at_start
    for k, step in enumerate(np.diff(time)):
        if k:
            dz = dz - (slope[k] - slope[k - 1])
        shapes, inverse = held.shapes[k], held.inverses[k]
        w, damping = factor * held.omega[k], held.damping[k]
        # damping acts on the rate of the deformation: the deviation oscillates about an offset
        still = np.zeros_like(w)
        np.divide(damping * (inverse @ slope[k]), w**2, out=still, where=w > 0.0)
        c, dc = free_oscillation(inverse @ z + still, inverse @ dz, w, damping, float(step))
        z, dz = shapes @ (c - still), shapes @ dc
        out[k + 1], rate[k + 1] = p[k + 1] + z, slope[k] + dz
    return out, rate


def free_oscillation(
    c: Array, dc: Array, w: Array, damping: Array, t: float
) -> tuple[Array, Array]:
    """Return c(t) and c'(t) of ``c'' + damping c' + w^2 c = 0``, exactly, damped in any degree."""
    half = 0.5 * damping
    mu = np.sqrt((half**2 - w**2).astype(complex))
    up, down = np.exp((mu - half) * t), np.exp((-mu - half) * t)
    cosh = 0.5 * (up + down)
    slow = np.abs(mu) * t < 1e-6
    sinh = np.where(slow, t * np.exp(-half * t), (up - down) / (2.0 * np.where(slow, 1.0, mu)))
    value = c * (cosh + half * sinh) + dc * sinh
    rate = dc * (cosh - half * sinh) - w**2 * c * sinh
    return np.real(value), np.real(rate)
