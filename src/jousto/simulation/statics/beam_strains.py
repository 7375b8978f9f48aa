"""Strains of beam elements at real or complex positions, for exact directional derivatives."""

from __future__ import annotations

from typing import Any

import numpy as np

from jousto.model.model import Model
from jousto.model.native.header import named
from jousto.simulation.statics.residual import turned

SMALL = 1e-4  # sine of half the relative rotation, below which the series is exact to round-off


def beam_strains(model: Model, q: Any) -> Any:
    """Return strains ``[Q_m^T (r_b - r_a)/L - e1, phi/L]`` (elements, 6) of all beam elements.

    ``Q_a^T Q_b = exp(phi)``, ``Q_m = Q_a exp(phi/2)`` is the frame at mid-length, in which the
    strains are resolved. For helical elements the part of Gamma perpendicular to phi is multiplied
    by ``h / sin h``, ``h = |phi|/2``. Initial strains of the unstressed shape are not subtracted.
    Units m/m, rad/m.
    """
    frames = [turned(q[b.iq + 3 : b.iq + 7]) for b in model.bodies]
    places = [q[b.iq : b.iq + 3] for b in model.bodies]
    out = np.zeros((len(model.beams), 6), dtype=q.dtype)
    for i, beam in enumerate(model.beams):
        x = named("jo_beam_data", beam.data)
        A, B = frames[beam.a], frames[beam.b]
        along = places[beam.b] + B @ x.u_b - places[beam.a] - A @ x.u_a
        first = A @ x.B_a.reshape(3, 3)
        relative = first.T @ B @ x.B_b.reshape(3, 3)
        # Euler parameters of the rotation between the ends, and of half of it
        cosine = 0.5 * np.sqrt(1.0 + np.trace(relative))
        odd = relative - relative.T
        sine = np.array([odd[2, 1], odd[0, 2], odd[1, 0]]) / (4.0 * cosine)
        square = sine @ sine
        if abs(square) > SMALL**2:
            n = np.sqrt(square)
            ratio = np.arctan(n / cosine) / n  # h / sin h
            screw = (ratio - 1.0) / square
        else:
            ratio, screw = 1.0 + square / 6.0, 1.0 / 6.0
        half = np.sqrt(0.5 * (1.0 + cosine))
        middle = first @ turned(np.concatenate([[half], sine / (2.0 * half)]))
        gamma = middle.T @ along / x.length
        if x.helical:
            gamma = gamma + screw * (square * gamma - sine * (sine @ gamma))
        gamma[0] -= 1.0
        out[i, :3], out[i, 3:] = gamma, 2.0 * ratio * sine / x.length
    return out
