"""Cost of a step of the observer: how fast a twin may be fed.

    .venv/bin/python benchmarks/twin.py

Prints the time of `Observer.step` (10 % quantile, for a busy machine) while gains are still formed
and when they have become constant, and that of the stress of all sites with its band,
for a beam with more and more modes and gauges.
"""

from __future__ import annotations

import time

import numpy as np

import jousto as jo
from jousto.measurement.twin.estimates import Posterior

STEEL = jo.Material(2.1e11, 0.3, 7850.0)
STEPS, START = 15_000, 100


def main() -> None:
    part = jo.Part.beam(2.0, jo.Box(0.08, 0.12, web=0.004, flange=0.004), 40, STEEL)
    rng = np.random.default_rng(1)
    print("modes  gauges  loads  states  forming, us  constant, us  surface with bands, us (sites)")
    for modes, gauges in ((2, 4), (6, 8), (14, 16), (24, 32)):
        rod = jo.reduction.clamp(
            jo.reduce(part, jo.CraigBampton(("start", "end"), modes=modes)), "start"
        )
        S = rod.stress.modes[:: max(1, len(rod.stress.labels) // gauges)][:gauges, 0]
        load = jo.twin.UnknownLoad("end", "fx fy fz mx my mz", rate=1e3, size=1e3, smooth=True)
        observer = jo.twin.Observer(rod, S / STEEL.E, loads=[load], step=1e-3, limit=2000.0)
        cost = []
        for k, e in enumerate(1e-6 * rng.standard_normal((STEPS, gauges))):
            start = time.perf_counter()
            step = observer.step(1e-3 * k, e)
            step.p  # noqa: B018
            cost.append(time.perf_counter() - start)
        # one frame of the whole surface: the covariance is formed anew each time here
        frames = []
        for _ in range(20):
            start = time.perf_counter()
            now = Posterior(np.zeros(1), step.p[None], step.covariance[None], np.zeros(1, int))
            jo.twin.stress_band(now, rod, "s11")
            frames.append(time.perf_counter() - start)
        first, last, frame = (
            1e6 * np.quantile(x, 0.1) for x in (cost[5:START], cost[-1000:], frames)
        )
        print(
            f"{rod.n:5d}  {gauges:6d}  {6:5d}  {observer.system.nx:6d}  "
            f"{first:11.0f}  {last:12.0f}  {frame:12.0f} ({len(rod.stress.labels)})"
        )


if __name__ == "__main__":
    main()
