"""A force crosses a beam on two supports, slowly and fast, against the closed form of Fryba.

The model is ``moving_load.yaml``: 2 kN cross a steel bar of 4 m with 25 m/s. The same is done with
10 m/s and with the critical speed ``v = pi / L sqrt(E I / mu)``, at which the force passes in half
a period of the first mode. L. Fryba, *Vibration of Solids and Structures under Moving Loads*
(1972), chapter 1: each mode is driven by its value under the force, ``sin(n pi v t / L)``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

MODEL = Path(__file__).with_name("moving_load.yaml")
LENGTH, FORCE = 4.0, 2000.0  # m, N: as in the file
EI, MU = 210e9 * 0.08 * 0.06**3 / 12, 7850 * 0.08 * 0.06  # N m2, kg/m
CRITICAL = np.pi / LENGTH * np.sqrt(EI / MU)  # m/s


def closed_form(t: np.ndarray, speed: float) -> np.ndarray:
    """Deflection of the middle, m, while the force is on the beam; undamped."""
    w = np.zeros_like(t)
    drive = np.pi * speed / LENGTH
    for n in range(1, 40, 2):
        own, forced = (n * np.pi / LENGTH) ** 2 * np.sqrt(EI / MU), n * drive
        if abs(own / forced - 1) < 1e-9:
            # resonance: the limit of the fraction below
            shape = (np.sin(own * t) - own * t * np.cos(own * t)) / (2 * own**2)
        else:
            shape = (np.sin(forced * t) - forced / own * np.sin(own * t)) / (own**2 - forced**2)
        w += 2 * FORCE / (MU * LENGTH) * np.sin(n * np.pi / 2) * shape
    return w


def crossing(speed: float) -> jo.Solution:
    """Run the file with another speed, until the force leaves."""
    file = jo.read_model(MODEL)
    items = [item for item in file.mechanism.items if not isinstance(item, jo.mechanism.MovingLoad)]
    (wheel,) = (item for item in file.mechanism.items if isinstance(item, jo.mechanism.MovingLoad))
    end = LENGTH / speed
    position = jo.Ramp(0.0, end, before=0.0, after=LENGTH)
    load = jo.mechanism.MovingLoad("wheel", wheel.body, wheel.path, wheel.vector, position)
    model = jo.compile(jo.Mechanism(*items, load))
    return jo.simulate(model, end, solver=file.simulation.solver, output_step=end / 100)


def main(out: Path) -> int:
    """Run, compare and draw; return 0 if every crossing is right."""
    out.mkdir(parents=True, exist_ok=True)
    sag = FORCE * LENGTH**3 / (48 * EI)
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    errors = []
    with plt.style.context(STYLE):
        figure, ax = plt.subplots(figsize=(6.5, 3.8), layout="constrained")
        for i, speed in enumerate((10.0, 25.0, CRITICAL)):
            run = crossing(speed)
            found, known = -run["middle"][:, 2] / sag, closed_form(run.time, speed) / sag
            errors.append(np.abs(found - known).max() / known.max())
            print(
                f"{speed:5.1f} m/s: {found.max():.4f} times F L3 / 48 EI, off by {errors[-1]:.1e}"
            )
            place = speed * run.time / LENGTH
            ax.plot(place, found, color=COLORS[i], label=f"{speed:.0f} m/s")
            label = "closed form" if i == 2 else None
            ax.plot(place, known, color="black", linestyle=(0, (1, 2)), zorder=3, label=label)
        ax.set_title("Middle of the beam over the static sag", **bold)
        ax.set(xlabel="place of the force / length")
        ax.invert_yaxis()
        ax.legend()
        figure.savefig(out / "moving_load.png")
        plt.close(figure)

    good = max(errors) < 1e-3
    print("the force crosses as it must" if good else "THE CROSSING IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
