"""A four-bar linkage of thin steel bars: slowly as calculated by hand, fast as it really bends.

The model is ``four_bar.yaml``. Its crank makes one slow, smooth turn. Then the closed form of the
rigid linkage holds within micrometres, and the coupler bends like a beam on two supports under
its own inertia load ``mu a``: ``w = 5 mu a L**4 / (384 E I)``, with a the acceleration of its
middle across the bar. Near 300 rpm the bars bend by up to 8 % more than that, and ring. The torque
of the motor goes through the root of the crank.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import jousto as jo
from jousto.output.style import COLORS, STYLE

MODEL = Path(__file__).with_name("four_bar.yaml")
FRAME, CRANK, COUPLER, FOLLOWER = 0.25, 0.1, 0.28, 0.27  # m, as in the file
E, WIDTH, THIN, THICK = 210e9, 0.025, 0.002, 0.005  # Pa, m
MU = 7850 * WIDTH * THIN  # kg/m


def coupler_end(phi: np.ndarray) -> np.ndarray:
    """Where the rigid coupler ends: two circles meet (law of cosines)."""
    pin = CRANK * np.stack([np.cos(phi), np.sin(phi)], axis=1)
    across = np.array([FRAME, 0.0]) - pin
    d = np.linalg.norm(across, axis=1)
    angle = np.arctan2(across[:, 1], across[:, 0]) + np.arccos(
        (COUPLER**2 + d**2 - FOLLOWER**2) / (2 * COUPLER * d)
    )
    return pin + COUPLER * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def across_bar(run: jo.Solution, x: np.ndarray) -> np.ndarray:
    """Component of a plane vector across the line from the coupler's start to its end."""
    along = (run["end"] - run["start"])[:, :2]
    along = along / np.linalg.norm(along, axis=1)[:, None]
    return along[:, 0] * x[:, 1] - along[:, 1] * x[:, 0]


def draw(
    t: np.ndarray, bend: np.ndarray, estimate: np.ndarray, drive: tuple[np.ndarray, ...], path: Path
) -> None:
    """Bending of the coupler in the slow turn and at speed, and the torque."""
    bold = {"loc": "left", "fontweight": "bold", "fontsize": 10.5, "pad": 8}
    theory = {"color": COLORS[1], "linestyle": (0, (5, 2)), "zorder": 3}
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(12, 3.6), layout="constrained")
        parts = (
            ("slow turn", t < 1.55, 1e6, "µm"),
            ("near 300 rpm", (t > 2.7) & (t < 3.3), 1e3, "mm"),
        )
        for ax, (title, part, scale, unit) in zip(axes, parts, strict=False):
            ax.plot(t[part], scale * bend[part], color=COLORS[0], label="jousto")
            ax.plot(t[part], scale * estimate[part], **theory, label="quasi-static")
            ax.set_title(f"Middle of the coupler, {title}", **bold)
            ax.set(xlabel="time (s)", ylabel=unit)
        axes[2].plot(t, drive[0], color=COLORS[0], label="flexible")
        axes[2].plot(t, drive[1], **theory, label="rigid")
        axes[2].set_title("Torque of the motor", **bold)
        axes[2].set(xlabel="time (s)", ylabel="N m")
        for ax in axes:
            ax.legend()
        figure.savefig(path)
        plt.close(figure)


def main(out: Path) -> int:
    """Run the file, compare and draw; return 0 if everything is as it must be."""
    out.mkdir(parents=True, exist_ok=True)
    file = jo.read_model(MODEL)
    model = jo.compile(file.mechanism)
    run = jo.simulate(model, file.simulation.t_end, **file.simulation.given())
    stiff = jo.compile(jo.read_model(MODEL, rigid=True).mechanism)
    rigid = jo.simulation.inverse_dynamics(stiff, run.time)
    t, step = run.time, run.time[1]
    slow, fast = t < 1.5, t > 1.5

    phi = jo.SCurve((0.0, 1.5), (0.0, 2 * np.pi))(t)
    miss = np.linalg.norm(run["end"][:, :2] - coupler_end(phi), axis=1)[slow].max()

    bend = across_bar(run, (run["middle"] - run["start"])[:, :2])
    a = np.gradient(np.gradient(rigid["middle"][:, :2], step, axis=0), step, axis=0)
    I = WIDTH * THIN**3 / 12
    estimate = -5 * MU * COUPLER**4 / (384 * E * I) * across_bar(rigid, a)
    bending = np.abs(bend - estimate)[slow].max() / np.abs(bend[slow]).max()

    drive, ideal = np.ravel(run["motor"]), np.ravel(rigid["motor"])
    stress = drive / (WIDTH * THICK**2 / 6)
    root = np.abs(run["root"][:, 0] - stress).max() / np.abs(stress).max()
    more = np.abs(drive - ideal)[slow].max() / np.abs(ideal[slow]).max()

    print(f"slow: coupler off the closed form       {1e6 * miss:.1f} µm")
    print(f"slow: bending against the estimate      {100 * bending:.2f} %")
    print(f"slow: torque against the rigid linkage  {100 * more:.2f} %")
    print(f"stress at the root against torque / W   {100 * root:.2f} %")
    for name, values in (("bending, jousto", bend), ("bending, quasi-static", estimate)):
        print(f"fast: {name:<30} {1e3 * np.abs(values[fast]).max():.2f} mm")
    draw(t, bend, estimate, (drive, ideal), out / "four_bar.png")
    jo.still(run, out / "four_bar_still.png", times=(0.2, 0.5, 0.7, 0.9, 1.2), trail="middle")

    good = miss < 1e-5 and bending < 0.02 and more < 0.02 and root < 0.02
    print("the linkage bends as it must" if good else "THE LINKAGE IS WRONG")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "out")))
