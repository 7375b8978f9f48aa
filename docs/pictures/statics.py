"""Draw how stress at the surface of solids converges, from the test that checks it.

.venv/bin/python docs/pictures/statics.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).parent.parent.parent
sys.path[:0] = [str(ROOT / "tests")]

from jousto.output.style import COLORS, STYLE
from verification import statics as st

LAYERS = (2, 3, 4, 6, 8)
KINDS = {"hexahedron20": COLORS[0], "tetra10": COLORS[1], "wedge15": COLORS[2]}
WIDTH, RATIO = 0.1, 0.2


def cylinder(kind: str, layers: int) -> tuple[int, float, float]:
    """Degrees of freedom; error of the outside's hoop stress at the nodes and from the skin."""
    solved = st.cylinder(kind, layers)
    angle, s = st.on_arc(solved, st.OUTSIDE)
    return errors(solved, st.OUTSIDE, st.lame(np.array([st.OUTSIDE]))[1][0], angle, s)


def kirsch(kind: str, layers: int) -> tuple[int, float, float]:
    """The same all around a hole in a wide plate, over its peak."""
    solved = st.wide_plate(kind, layers)
    angle, s = st.on_arc(solved, st.HOLE)
    return errors(solved, st.HOLE, 3.0 * st.PULL, angle, s)


def errors(solved, radius, scale, angle, s):  # type: ignore[no-untyped-def]
    """Largest errors on an arc around the origin."""
    x = solved.part.nodes
    arc = st.near(np.hypot(x[:, 0], x[:, 1]), radius)

    def exact(a):  # type: ignore[no-untyped-def]
        wave = st.PULL * (1.0 - 2.0 * np.cos(2.0 * a))
        return wave if radius == st.HOLE else scale + 0.0 * a

    at = np.arctan2(x[arc, 1], x[arc, 0])
    nodes = np.abs(st.hoop(at, solved.s[arc]) - exact(at)).max() / scale
    return solved.size, nodes, np.abs(st.hoop(angle, s) - exact(angle)).max() / scale


def notches(kind: str, layers: int) -> tuple[int, float, float]:
    """The peak at two notches of a strip, against Peterson's chart."""
    solved = st.strip(kind, layers, width=WIDTH, radius=0.5 * RATIO * WIDTH, notch=True)
    _, s = st.on_arc(solved, 0.5 * RATIO * WIDTH, (0.0, 0.5 * WIDTH))
    peak = st.PULL * st.semicircular_notches(RATIO) / (1.0 - RATIO)
    return solved.size, abs(solved.s[:, 0].max() / peak - 1.0), abs(s[:, 0].max() / peak - 1.0)


CASES = {
    "thick cylinder, outside (Lamé)": cylinder,
    "hole in a wide plate (Kirsch)": kirsch,
    "half-round notches (Peterson)": notches,
}


def main(folder: Path) -> None:
    """Three problems beside one another, both axes logarithmic."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(10.5, 3.7), layout="constrained", sharey=True)
        for ax, (title, case) in zip(axes, CASES.items(), strict=True):
            for kind, color in KINDS.items():
                size, nodes, skin = np.array([case(kind, n) for n in LAYERS]).T
                ax.loglog(size, nodes, "o--", color=color, markerfacecolor="white", markersize=4)
                ax.loglog(size, skin, "o-", color=color, markersize=4, label=kind)
            ax.axhline(0.02, color=COLORS[-1], linewidth=0.8)
            ax.set_title(title, loc="left", fontweight="bold", fontsize=10.5)
            ax.minorticks_off()
            ax.set_xticks([300, 1000, 3000, 10_000], ["300", "1000", "3000", "10 000"])
            ax.set(xlabel="degrees of freedom", xlim=(200, 25_000), ylim=(1e-6, 0.5))
            # where there is no curve
            at, side = (210, "left") if ax is axes[2] else (24_000, "right")
            ax.annotate("2 %", (at, 0.021), color=COLORS[-1], fontsize=7.5, ha=side)
        axes[2].annotate("digits of the chart", (400, 4e-4), color=COLORS[-1], fontsize=7.5)
        axes[0].set_ylabel("error of the surface stress")
        axes[0].legend(frameon=False, fontsize=8, loc="lower left")
        figure.savefig(folder / "statics.png")
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
