"""Strain gauges on a bar: virtual, measured, and what a rosette says.

A clamped bar is shaken at its end. Virtual gauges record what real ones would: a grid along it,
a rosette beside it and a half bridge of both sides. A logger with a clock, a gain and noise of its
own "measures" the same; the record is read back from its file, aligned and compared.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import jousto as jo

LENGTH, WIDTH, HEIGHT = 0.5, 0.04, 0.02  # m
FORCE, AT = 120.0, 0.15  # N; place of the gauges, m
LATE, GAIN, NOISE = 0.31416, 1.03, 1.5e-6  # s, 1, m/m


def mechanism() -> jo.Mechanism:
    """The bar under a force that sweeps slowly, with its gauges."""
    steel = jo.material("S355")
    part = jo.Part.beam(LENGTH, jo.Rectangle(WIDTH, HEIGHT), 5, steel)
    bar = jo.FlexibleBody("bar", jo.reduce(part, jo.CraigBampton(("start", "end"), modes=4)),
                          damping=0.02)  # fmt: skip
    sweep = 0.6 * jo.Harmonic(frequency=1.3) + 0.4 * jo.Harmonic(frequency=3.7, phase=0.8)
    top = jo.gauges.Gauge("top", bar, (AT, 0, HEIGHT / 2), length=0.006, transverse=0.002)
    bottom = jo.gauges.Gauge("bottom", bar, (AT, 0, -HEIGHT / 2), length=0.006, transverse=0.002)
    return jo.Mechanism(
        bar,
        jo.Fixed("clamp", jo.ground["origin"], bar["start"]),
        jo.Force("shaker", bar["end"], (0, 0, -FORCE), signal=sweep),
        *(top, bottom),
        jo.gauges.Rosette("rosette", bar, "e2.b.top"),
        jo.gauges.Bridge("half bridge", (top, bottom), gauge_factor=2.05),
    )


def measure(run: jo.Solution, path: Path) -> None:
    """Write what a logger would: late, with noise and a gain, at its own rate, decimal commas."""
    rng = np.random.default_rng(7)
    record = jo.gauges.record_of(run, ["top", "half bridge"]).resample(
        times=np.arange(0.4, 2.7, 1 / 180), antialias=False
    )
    strain = GAIN * record["top"] + NOISE * rng.standard_normal(len(record))
    rows = zip(record.time - LATE, 1e6 * strain, 1e3 * record["half bridge"], strict=True)
    lines = [";".join(f"{x:.7g}" for x in row).replace(".", ",") for row in rows]
    path.write_text("\n".join(["Zeit;top;half bridge", "s;µm/m;mV/V", *lines]), encoding="utf-8")


def main(out: Path) -> int:
    """Run, measure and compare; return 0 if the numbers are right."""
    out.mkdir(parents=True, exist_ok=True)
    model = jo.compile(mechanism())
    run = jo.simulate(model, 3.0, solver=jo.ROS2(1e-3), output_step=2e-3)
    path = out.parent / "measured.csv"
    measure(run, path)
    found = jo.gauges.compare_gauges(run, jo.gauges.read_record(path), max_shift=1.0)
    print(found)
    jo.plot(found, path=out / "gauges.png")

    k = int(np.argmax(np.abs(run["top"])))
    state = jo.gauges.rosette_state(run["rosette"][k], E=210e9, nu=0.3, noise=NOISE)
    print(f"the rosette at {run.time[k]:.3f} s")
    print(state)
    assert found.alignment is not None
    good = abs(found.alignment.shift - LATE) < 1e-3 and abs(found.pairs[0].scale - GAIN) < 0.01
    along, across = sorted(np.abs([state.s1, state.s2]), reverse=True)
    good = good and across < 1e-3 * along  # uniaxial
    print("shift and gain are found" if good else "THE COMPARISON IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
