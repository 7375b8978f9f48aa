"""A rail conveyor carriage: forces of its four wheels while it starts, hits a bad joint, is loaded.

The model is ``carriage.yaml``: a frame of beams on four wheels, which are springs whose foot
follows the rail. It starts to travel, its left wheels pass a bad joint of the rail one after the
other, then a trolley rolls over the frame from the rear end to the front end: two travelling
forces. Where nothing shakes, the forces must be those of a rigid frame: the weight, the lever rule
of the trolley, ``m a h / L`` of the start. Their sum must be the whole weight.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

MODEL = Path(__file__).with_name("carriage.yaml")
G = 9.81  # m/s2
TROLLEY = 100.0  # kg
BASE = 2.0  # m, between front and rear wheels


def mass_and_height() -> tuple[float, float]:
    """Mass of the carriage, kg, and height of its centre over the frame, m."""
    box = {120: 0.08 * 0.12 - 0.072 * 0.112, 80: 0.08**2 - 0.072**2}
    beams = 7850 * (2 * 2.4 * box[120] + 3 * 1.0 * box[80])
    return beams + 200.0, 200.0 * 0.2 / (beams + 200.0)


def at_rest(t: np.ndarray) -> np.ndarray:
    """Force of one front and one rear wheel under a rigid frame (instants, 2), N."""
    mass, height = mass_and_height()
    step = np.clip(t, 0.0, 1.0)
    fade = jo.SCurve((0.0, 1.0), (0.0, 1.0))
    travel = 2 * fade.rate(step) + step * fade.acceleration(step)  # x = t s(t), 1 m/s
    transfer = mass * np.where(t < 1.0, travel, 0.0) * height / BASE
    place = -1.2 + 0.6 * (t - 5.0)
    load = np.where((t > 5.0) & (t < 9.0), TROLLEY * G, 0.0)
    front = mass * G / 2 + load * (0.5 + place / BASE) - transfer
    rear = mass * G / 2 + load * (0.5 - place / BASE) + transfer
    return np.stack([front, rear], axis=1) / 2


def draw(t: np.ndarray, wheels: dict[str, np.ndarray], statics: np.ndarray, path: Path) -> None:
    """Forces of the wheels, the whole run and the bad joint."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    theory = {"color": "black", "linestyle": (0, (1, 2)), "zorder": 4}
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(11, 3.8), layout="constrained")
        for ax, (low, high) in zip(axes, ((0.0, 10.0), (1.9, 2.5)), strict=True):
            part = (t >= low) & (t <= high)
            for color, (name, force) in zip(COLORS, wheels.items(), strict=False):
                ax.plot(t[part], force[part], color=color, label=name)
            ax.plot(t[part], statics[part, 0], **theory, label="rigid frame, at rest")
            ax.plot(t[part], statics[part, 1], **theory)
            ax.set(xlabel="time (s)", ylabel="N")
        axes[0].set_title("Forces of the wheels", **bold)
        axes[1].set_title("The front left wheel passes a bad joint", **bold)
        axes[0].legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run the file, compare and draw; return 0 if the wheels carry what they must."""
    out.mkdir(parents=True, exist_ok=True)
    file = jo.read_model(MODEL)
    model = jo.compile(file.mechanism)
    run = jo.simulate(model, file.simulation.t_end, **file.simulation.given(model))
    t = run.time
    names = ("front left", "front right", "rear left", "rear right")
    wheels = {name: np.ravel(run[name]) for name in names}
    statics = at_rest(t)
    weight, _ = mass_and_height()

    def worst(low: float, high: float) -> float:
        part = (t >= low) & (t <= high)
        known = [statics[part, 0 if "front" in name else 1] for name in names]
        return max(
            np.abs(wheels[name][part] / k - 1).max() for name, k in zip(names, known, strict=True)
        )

    rest, start, rolling = worst(1.5, 1.99), worst(0.0, 1.0), worst(6.0, 8.99)
    total = np.sum(list(wheels.values()), axis=0)
    loaded = (t > 6.0) & (t < 8.9)
    sums = np.abs(total[loaded] / (G * (weight + TROLLEY)) - 1).max()
    passing = (t > 1.9) & (t < 2.5)
    peak = max(force[passing].max() for force in wheels.values())

    print(f"weight of the carriage {G * weight:.1f} N, four wheels {total[0]:.1f} N")
    print(f"rolling evenly: wheels off a quarter of the weight by {rest:.1e}")
    print(f"starting: wheels off weight and m a h / L by          {start:.1e}")
    print(f"under the trolley: wheels off the lever rule by       {rolling:.1e}")
    print(f"                   sum off the whole weight by        {sums:.1e}")
    print(f"1 mm of a bad joint: {peak:.0f} N instead of {statics[0, 0]:.0f} N")
    draw(t, wheels, statics, out / "carriage.png")

    good = abs(total[0] / (G * weight) - 1) < 1e-6 and rest < 1e-3 and start < 0.02
    good = good and rolling < 0.01 and sums < 1e-3 and peak > 1.1 * statics[0, 0]
    print("the wheels carry what they must" if good else "THE WHEELS ARE WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
