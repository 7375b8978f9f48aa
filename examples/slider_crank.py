"""A slider-crank with a flexible rod, driven through two smooth turns, against closed forms.

The model is ``slider_crank.yaml``. With a rigid rod the slider would follow
``x = r cos(phi) + sqrt(l**2 - r**2 sin(phi)**2)``; the pin has to carry m x'' along the slide. The
rod is stretched by some F l / (E A) = 2.3 µm, and at the end, at rest, by nothing.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

MODEL = Path(__file__).with_name("slider_crank.yaml")
CRANK, ROD, MASS = 0.2, 0.5, 2.0  # m, m, kg: as in the file
TURNS = jo.SCurve((0.0, 2.0), (0.0, 4 * np.pi))


def rigid(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Position and acceleration of the slider with a rigid rod, by the chain rule."""
    phi, rate, acceleration = TURNS(t), TURNS.rate(t), TURNS.acceleration(t)
    s, c = CRANK * np.sin(phi), CRANK * np.cos(phi)
    root = np.sqrt(ROD**2 - s**2)
    first = -s - s * c / root
    second = -c - (c**2 - s**2) / root - (s * c) ** 2 / root**3
    return c + root, first * acceleration + second * rate**2


def draw(run: jo.Solution, x: np.ndarray, force: np.ndarray, path: Path) -> None:
    """Position of the slider and force of its pin, with the closed forms."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    theory = {"color": COLORS[1], "linestyle": (0, (5, 2)), "zorder": 3, "label": "rigid rod"}
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6), layout="constrained")
        left.plot(run.time, run["slider"][:, 0], color=COLORS[0], label="jousto")
        left.plot(run.time, x, **theory)
        left.set_title("Position of the slider", **bold)
        left.set(xlabel="time (s)", ylabel="x (m)")
        left.legend()
        right.plot(run.time, run["pin"][:, 0], color=COLORS[0], label="jousto")
        right.plot(run.time, force, **theory)
        right.set_title("Force of the pin along the slide", **bold)
        right.set(xlabel="time (s)", ylabel="N")
        right.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run the file, compare and draw; return 0 if slider and force are right."""
    out.mkdir(parents=True, exist_ok=True)
    file = jo.read_model(MODEL)
    run = jo.simulate(jo.compile(file.mechanism), file.simulation.t_end, **file.simulation.given())
    x, acceleration = rigid(run.time)
    force = MASS * acceleration
    miss = np.abs(run["slider"][:, 0] - x)
    difference = np.abs(run["pin"][:, 0] - force).max() / np.abs(force).max()
    print(f"slider off the closed form  {1e6 * miss.max():.2f} µm, at rest {1e6 * miss[-1]:.4f} µm")
    print(f"largest force of the pin    {np.abs(run['pin'][:, 0]).max():.2f} N")
    print(f"closed form m x''           {np.abs(force).max():.2f} N, differs by {difference:.1e}")
    print(f"largest energy error        {np.abs(run.energy.error).max():.1e} J")
    draw(run, x, force, out / "slider_crank.png")

    good = miss.max() < 5e-6 and miss[-1] < 1e-7 and difference < 1e-3
    print("the slider moves as it must" if good else "THE SLIDER IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
