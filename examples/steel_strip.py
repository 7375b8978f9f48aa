"""A steel strip that sags under its own weight, then is swung up by its clamp.

The model is ``steel_strip.yaml``: 1 m of spring steel, 20 mm wide and 0.5 mm thick, one
geometrically exact beam of 20 elements. At rest its tip hangs 0.81 m below a level clamp. The shape
is compared with the heavy elastica, solved by SciPy's ``solve_bvp``, and the motion with its energy
balance and with twice as many elements.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_bvp

import jousto as jo
from jousto.output.style import COLORS, STYLE
from jousto.schema.read import parse_model

MODEL = Path(__file__).with_name("steel_strip.yaml")
LENGTH, WIDTH, HEIGHT = 1.0, 0.02, 0.0005  # m, as in the file
BENDING = 210e9 * WIDTH * HEIGHT**3 / 12  # N m2
WEIGHT = 7850 * WIDTH * HEIGHT * 9.81  # N/m


def strip(elements: int) -> tuple[jo.Model, jo.simulation.LoadPath, jo.Solution]:
    """Model, path of the weight from none to all of it, and the swing from where it rests."""
    text = MODEL.read_text(encoding="utf-8").replace("elements: 20", f"elements: {elements}")
    file = parse_model(text, name=MODEL.name)
    model = jo.compile(file.mechanism)
    path = jo.simulation.load_path(model, "gravity", to=1.0, steps=10)
    settings = file.simulation.given()
    return model, path, jo.simulate(model, 1.5, state=path.states[-1], **settings)


def heavy_elastica() -> np.ndarray:
    """Tip (x, z) and moment at the clamp of an inextensible strip, theta from the horizontal."""

    def slope(s: np.ndarray, y: np.ndarray) -> np.ndarray:
        theta, moment = y[0], y[1]
        load = -WEIGHT * (LENGTH - s) * np.cos(theta)
        return np.stack([moment / BENDING, load, np.cos(theta), -np.sin(theta)])

    def ends(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.array([a[0], b[1], a[2], a[3]])

    s = np.linspace(0.0, LENGTH, 41)
    found = solve_bvp(slope, ends, s, np.stack([s, 0.2 * (1 - s), s, -s]), tol=1e-9)
    assert found.success
    return np.array([found.y[2, -1], found.y[3, -1], found.y[1, 0]])


def nodes(model: jo.Model, q: np.ndarray) -> np.ndarray:
    """Places of the strip's nodes at a row of coordinates, m."""
    return np.stack([q[b.iq : b.iq + 3] for b in model.bodies if b.name.startswith("strip")])


def draw(model: jo.Model, run: jo.Solution, path: Path) -> None:
    """The strip at some instants, and the moment in its first element over time."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    with plt.style.context(STYLE):
        figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 4.2), layout="constrained")
        rows = range(0, 91, 9)
        for k in rows:
            x = nodes(model, run.q[k])
            left.plot(x[:, 0], x[:, 2], color=plt.cm.viridis(k / 90), linewidth=1.4)
        left.set_title("The strip every 0.09 s", **bold)
        left.set(xlabel="x (m)", ylabel="z (m)", aspect="equal")
        right.plot(run.time, run["root"][:, 4], color=COLORS[0])
        right.set_title("Moment at the clamp", **bold)
        right.set(xlabel="time (s)", ylabel="N m")
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Load, swing, compare and draw; return 0 if the strip is right."""
    out.mkdir(parents=True, exist_ok=True)
    model, path, run = strip(20)
    _, fine, twice = strip(40)
    x, z, _ = heavy_elastica()
    errors = [np.hypot(p["tip"][-1, 0] - x, p["tip"][-1, 2] - z) for p in (path, fine)]
    swing = np.linalg.norm(run["tip"] - twice["tip"], axis=1)
    exchanged = np.ptp(run.energy.kinetic) + np.ptp(run.energy.potential)
    missed = float(np.abs(run.energy.error).max())
    draw(model, run, out / "steel_strip.png")
    print(f"tip at rest             x {path['tip'][-1, 0]:.4f} m, z {path['tip'][-1, 2]:.4f} m")
    print(f"off the heavy elastica  {1e3 * errors[0]:.3f} mm, {1e3 * errors[1]:.3f} mm with 40")
    print(f"20 and 40 elements      {1e3 * swing.max():.1f} mm apart at most while it swings")
    print(f"energy missed           {missed:.2e} J of {exchanged:.2f} J exchanged")

    good = errors[0] < 4e-4 and 3.5 < errors[0] / errors[1] < 4.5
    good = good and swing.max() < 0.03 and missed < 0.01 * exchanged
    print("the strip is where it must be" if good else "THE STRIP IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
