"""A crane boom watched by six strain gauges: stress where none sits, damage, life and alarms.

The data come from a simulation of a finer boom (16 elements, 10 modes, half the damping) whose
payload swings at random, with noise of 2 um/m, and are spoilt as real data are: a cable that
fails, a channel that freezes, a spike, lines of garbage. The twin is the coarse boom of
``monitor.yaml``; what it says lies in its 95 % band.
"""

from __future__ import annotations

import sys
import tempfile
import warnings
from pathlib import Path

import numpy as np

import jousto as jo

MODEL = Path(__file__).with_name("monitor.yaml")
T_END, RATE = 40.0, 100.0  # s, samples a second
NOISE = 2e-6  # m/m
# the coarse and the fine name of places: e1.a is the clamp, e2.a at 0.5 m, e3.a at 1 m, ..
FINE = {"e1": "e1", "e2": "e3", "e3": "e5", "e6": "e11"}
SPOTS = ("e1.a.top_left", "e1.a.bottom_right", "e2.a.top_left")


def truth() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return time, gauges (nt, 6) and stress (nt, 3) of a boom that the twin does not know."""
    rng = np.random.default_rng(1)
    steel = jo.Material(E=2.1e11, nu=0.3, rho=7850.0)
    part = jo.Part.beam(4.0, jo.Rectangle(width=0.09, height=0.16), 16, steel)
    reduced = jo.reduce(part, jo.CraigBampton(("start", "end"), modes=10))
    boom = jo.FlexibleBody("boom", reduced, damping=0.01)
    times = np.arange(0.0, T_END + 0.5, 0.25)
    swing = rng.uniform(-1.0, 1.0, (len(times), 2))
    swing[:3] = 0.0
    gauges = [
        jo.gauges.Gauge(f"g{2 * i + j + 1}", boom, f"{FINE[element]}.a.{side}")
        for i, element in enumerate(("e1", "e3", "e6"))
        for j, side in enumerate(("top", "left"))
    ]
    down = jo.SCurve(times, 1.0 + 0.5 * swing[:, 0])
    model = jo.compile(
        jo.Mechanism(
            boom,
            jo.Fixed("mast", jo.ground["origin"], boom["start"]),
            jo.Force("down", boom["end"], (0.0, 0.0, -9e3), signal=down),
            jo.Force("side", boom["end"], (0.0, 3e3, 0.0), signal=jo.SCurve(times, swing[:, 1])),
            jo.Gravity((0.0, 0.0, -9.81)),
            *gauges,
        )
    )
    run = jo.simulate(
        model,
        T_END,
        solver=jo.ROS2(step=1e-3),
        output_step=1.0 / RATE,
        state=jo.equilibrium(model),
    )
    spots = [f"{FINE[spot[:2]]}{spot[2:]}" for spot in SPOTS]
    stress = jo.stress_field(run, "boom").values("signed-von-mises", sites=spots)
    return run.time, np.hstack([run[gauge.name] for gauge in gauges]), stress


def logged(time: np.ndarray, e: np.ndarray, path: Path) -> None:
    """Write what a logger would have written on a bad day."""
    e = e + NOISE * np.random.default_rng(2).normal(size=e.shape)
    lines = ["time [s]," + ",".join(f"g{i + 1} [um/m]" for i in range(6))]
    for k, t in enumerate(time):
        cells = [f"{1e6 * x:.2f}" for x in e[k]]
        if 10.0 <= t < 14.0:
            cells[2] = ""  # the cable of g3
        if t >= 25.0:
            cells[5] = f"{1e6 * e[2500, 5]:.2f}"  # g6 freezes
        if k == 2000:
            cells[0] = "9999.99"
        lines.append(f"{t:.3f}," + ",".join(cells))
        if k in (700, 3000):
            lines += ["\x07#!", "buffer overrun"]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def main(folder: Path) -> None:
    """Make data, watch them, compare with the truth and draw."""
    folder.mkdir(parents=True, exist_ok=True)
    time, e, stress = truth()
    file = jo.read_model(MODEL)
    reference = jo.simulate(
        jo.compile(file.mechanism), file.simulation.t_end, **file.simulation.given()
    )
    with warnings.catch_warnings():
        # six gauges do not see all of ten modes: the reference run says how large the others are
        warnings.filterwarnings("ignore", message=".*the prior alone determines")
        monitor = file.monitor.monitor(reference)
    with tempfile.TemporaryDirectory() as scratch:
        data = Path(scratch) / "monitor.csv"
        logged(time, e, data)
        record = jo.monitor.watch(monitor, data, Path(scratch) / "monitor.h5")
        print(record)
        for event in record.events:
            print(f"{event.time:8.2f} s  {event.kind}: {event.text}")
        jo.plot(record, path=folder / "monitor.png")
        inside = ((record.low <= stress) & (stress <= record.high)).mean(axis=0)
        apart = np.abs(record.stress - stress).max(axis=0) / 1e6
        low, high = record.summary("damage_low")[-1], record.summary("damage_high")[-1]
    print(f"in the 95 % band {inside.round(3)} of the time, at most {apart.round(1)} MPa off")
    meter = jo.model.DamageMeter(monitor.sn, residue="half", n=3)
    meter.push(stress)
    print(f"damage of the truth {meter.damage()}, band {low} to {high}")
    assert np.all(inside > 0.93)
    assert np.all(apart < 20.0)
    assert np.all((low < meter.damage()) & (meter.damage() < high))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path("out"))
