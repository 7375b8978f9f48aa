"""Cost of a sample in a `Monitor`: eight gauges, three modes, four hot spots with damage and band.

Prints processor time in microseconds per sample, pushed one by one and in blocks.
"""

from __future__ import annotations

import time

import numpy as np

import jousto as jo
from jousto.measurement.monitor.alarms import AlarmLimits
from jousto.measurement.monitor.monitor import Monitor
from jousto.measurement.twin.reconstruction import Reconstruction

SPOTS = ("e1.a.top", "e2.a.bottom", "e3.a.top", "e5.a.bottom")


def part() -> tuple[jo.ReducedPart, np.ndarray, tuple[str, ...]]:
    """A cantilever with eight gauges: reduced part, their rows and names."""
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
    beam = jo.Part.beam(1.0, jo.Rectangle(0.02, 0.01), 10, steel)
    reduced = jo.reduce(beam, jo.CraigBampton(("start",), modes=6))
    reduced = reduced.keep(reduced.in_plane("xz")[:3])
    names = tuple(f"g{i + 1}" for i in range(8))
    rows = [jo.gauges.Gauge(name, reduced, f"e{i + 1}.a.top").rows for i, name in enumerate(names)]
    return reduced, np.vstack(rows), names


def main(n: int = 20_000) -> None:
    reduced, B, names = part()
    t = 1e-3 * np.arange(n)
    p = np.stack([np.sin(6 * t), 0.05 * np.sin(17 * t), 0.01 * np.sin(40 * t)], axis=1)
    root = reduced.stress.modes[reduced.stress.labels.index(SPOTS[0]), 0]
    p *= 70e6 / np.abs(p @ root).max()
    e = p @ B.T + 1e-6 * np.random.default_rng(0).normal(size=(n, len(B)))
    for criterion in ("signed-von-mises", "s11"):
        for block, total in ((1, 2000), (10, n), (100, n), (1000, n)):
            monitor = Monitor(
                Reconstruction(B, noise=1e-6, names=names),
                reduced,
                SPOTS,
                criterion=criterion,
                sn=jo.SN(S_D=50e6, N_D=1e6, k=5, T_S=1.3),
                limits=AlarmLimits(stress=200e6, channels=5),
            )
            warm = max(block, 200)  # gains, roots and the engine's code are there from then on
            for i in range(0, warm, block):
                monitor.push(t[i : i + block], e[i : i + block])
            start = time.process_time()
            for i in range(warm, total, block):
                monitor.push(t[i : i + block], e[i : i + block])
            spent = 1e6 * (time.process_time() - start) / (total - warm)
            print(f"{criterion:<17} blocks of {block:<5} {spent:8.1f} us per sample")


if __name__ == "__main__":
    main()
