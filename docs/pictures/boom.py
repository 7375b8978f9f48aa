"""Draw the boom of Makinen, Marjamaki and Pajunen: its model, its moment, its positions.

.venv/bin/python docs/pictures/boom.py FOLDER

After figures 4 and 5 of the paper; model, moment and motion are those of examples/offset_boom.py.
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from planar_element import TITLE

ROOT = Path(__file__).parent.parent.parent
sys.path[:0] = [str(ROOT / "examples")]

from offset_boom import boom, rpm, spin

from jousto.output.style import COLORS, MUTED, STYLE
from jousto.planar import PlanarFrame, PlanarRun

STEP, END = 1e-4, 2.0  # s; the run ends at 1.997 s, as in the paper
INSTANTS = (0.0, 0.442, 0.7, 1.0, 1.25, 1.5, 1.75, 1.99)  # s
ABOVE = (1.25, 1.5, 1.75)  # instants with their text above the boom


def model(axes: Axes, frame: PlanarFrame) -> None:
    """Draw the elements, the arm to the pivot and the dimensions."""
    ends = np.array([frame.ends(e) for e in range(len(frame.beams))])
    pivot = np.array(frame.nodes[0])
    for number, pair in enumerate(ends, 1):
        axes.plot(*pair.T, "-o", color=COLORS[0], mfc="w", lw=2.4, ms=5)
        axes.annotate(f"{number}", pair.mean(axis=0) + (0.0, 0.12), ha="center", color=COLORS[0])
    axes.plot(*np.array([pivot, ends[0, 0]]).T, color=COLORS[1], lw=1.8)
    axes.plot(*pivot, "s", color=COLORS[1], ms=7)
    axes.plot(*(pivot + (0.0, -0.12)), "^", color=MUTED, ms=9, zorder=0)
    # moment about the pivot
    arc = np.linspace(-2.7, 0.4, 40)
    x, y = pivot[0] + 0.3 * np.cos(arc), pivot[1] + 0.3 * np.sin(arc)
    axes.plot(x, y, color=COLORS[3], lw=1.4)
    head = {"arrowstyle": "-|>", "color": COLORS[3]}
    axes.annotate("", (x[-1], y[-1]), (x[-3], y[-3]), arrowprops=head)
    axes.annotate("M(t)", pivot + (0.36, -0.08), color=COLORS[3], va="center")
    axes.annotate("0.5 m", 0.5 * (pivot + ends[0, 0]) + (-0.08, 0.0), ha="right", color=COLORS[1])
    axes.annotate("4 x 1 m", (2.0, -0.25), ha="center", color=MUTED)
    axes.set(xlim=(-0.8, 4.3), ylim=(-0.95, 0.4))
    axes.set_aspect("equal")
    axes.set_anchor("N")
    axes.set_axis_off()
    axes.set_title("Model", **TITLE)


def moment(axes: Axes, frame: PlanarFrame) -> None:
    """Draw the moment of the frame's load over the time."""
    (load,) = frame.loads
    t = np.linspace(0.0, END, 400)
    axes.plot(t, [1e-6 * load.moment * load.signal(x) for x in t], color=COLORS[3])
    axes.set(xlabel="time (s)", ylabel="MN m", xlim=(0.0, END))
    axes.set_title("Moment: t, from 1 s on t$^6$", **TITLE)


def seen_from_arm(run: PlanarRun, k: int) -> np.ndarray:
    """Return the ends of the elements at a step, (5, 2), with the arm of the pivot along x."""
    angle = run.displacements[k, 0, 2]
    x, y = np.array([np.sin(-angle), np.cos(-angle)]), np.array([-np.cos(-angle), np.sin(-angle)])
    places = run.positions[k, 1:] - run.positions[k, 0]
    return np.vstack([(0.5, 0.0), np.column_stack([places @ x, places @ y])])


def positions(axes: Axes, run: PlanarRun) -> None:
    """Draw the boom at some instants."""
    shades = plt.get_cmap("viridis")(np.linspace(0.0, 0.85, len(INSTANTS)))
    for t, color in zip(INSTANTS, shades, strict=True):
        shape = seen_from_arm(run, round(t / STEP))
        axes.plot(*shape.T, "-o", color=color, ms=3, lw=1.4)
        side = 1 if t in ABOVE else -1
        text = {"textcoords": "offset points", "color": color, "ha": "center", "va": "center"}
        axes.annotate(f"{t:g} s", shape[-1], (6, 11 * side), **text)
    axes.plot(*np.array([(0.0, 0.0), (0.5, 0.0)]).T, color=COLORS[1], lw=1.8)
    axes.plot(0.0, 0.0, "s", color=COLORS[1], ms=6)
    axes.set(xlabel="m, along the arm of the pivot", xlim=(-0.6, 26.5), ylim=(-5.0, 0.8))
    axes.set_aspect("equal")
    axes.set_title("Positions, seen from the arm of the pivot", **TITLE)


def main(folder: Path) -> None:
    """Draw the boom before the run and in it."""
    frame, run = boom(), spin(STEP, END, True)
    stretched = run.strains[-1, :, 0].mean() + 1.0
    print(f"{run.steps} steps, {rpm(run)[-1]:.0f} rpm, {stretched:.2f} times as long at the end")
    with plt.rc_context(STYLE):
        figure, axes = plt.subplot_mosaic(
            [["model", "moment"], ["run", "run"]],
            figsize=(11, 6.0),
            layout="constrained",
            width_ratios=(1.25, 1),
        )
        model(axes["model"], frame)
        moment(axes["moment"], frame)
        positions(axes["run"], run)
        figure.savefig(folder / "boom.png", dpi=110)
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
