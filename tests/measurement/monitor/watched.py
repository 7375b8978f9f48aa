"""A cantilever with five gauges on top: one bending mode after the other has a closed form."""

from __future__ import annotations

from functools import cache

import numpy as np

import jousto as jo
from jousto.measurement.monitor.alarms import AlarmLimits
from jousto.measurement.monitor.monitor import Monitor
from jousto.measurement.twin.reconstruction import Reconstruction

NAMES = ("g1", "g2", "g3", "g4", "g5")
SPOTS = ("e1.a.top", "e2.a.bottom")
NOISE = 1e-6


@cache
def cantilever():
    """Reduced beam in the plane, rows of the gauges."""
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
    part = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 10, steel)
    reduced = jo.reduce(part, jo.CraigBampton(("start",), modes=6))
    reduced = reduced.keep(reduced.in_plane("xz")[:2])
    gauges = [jo.gauges.Gauge(name, reduced, f"e{2 * i + 1}.a.top") for i, name in enumerate(NAMES)]
    return reduced, np.vstack([gauge.rows for gauge in gauges])


def curve():
    return jo.SN(S_D=50e6, N_D=1e6, k=5, T_S=1.3)


def monitor(*, limits=None, sn=None, **options):
    reduced, B = cantilever()
    twin = Reconstruction(B, noise=NOISE, names=NAMES)
    return Monitor(twin, reduced, SPOTS, sn=sn, limits=limits or AlarmLimits(), **options)


def motion(n=2000, step=1e-2, seed=0):
    """Time, modal coordinates whose stress at the root reaches 70 MPa, strains with noise."""
    rng = np.random.default_rng(seed)
    reduced, B = cantilever()
    t = step * np.arange(n)
    p = np.stack([np.sin(6.0 * t), 0.05 * np.sin(17.0 * t)], axis=1)
    root = reduced.stress.modes[reduced.stress.labels.index(SPOTS[0]), 0]
    p *= 70e6 / np.abs(p @ root).max()
    return t, p, p @ B.T + NOISE * rng.normal(size=(n, len(B)))


def truth(p):
    """Stress along the beam at the spots (nt, 2), Pa: with its sign the signed von Mises stress."""
    reduced, _ = cantilever()
    S = reduced.stress.modes[[reduced.stress.labels.index(spot) for spot in SPOTS], 0]
    return p @ S.T


def lines(t, e, digits=4):
    head = "time [s]," + ",".join(f"{name} [um/m]" for name in NAMES)
    rows = [
        f"{time:.6g}," + ",".join(f"{1e6 * x:.{digits}f}" for x in row)
        for time, row in zip(t, e, strict=True)
    ]
    return [head, *rows]


def written(path, rows):
    path.write_text("\n".join(rows) + "\n")
    return path
