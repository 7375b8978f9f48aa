"""Draw how solid parts converge: with the mesh, and with the modes kept.

.venv/bin/python docs/pictures/solids.py FOLDER
"""

from __future__ import annotations

import sys
import warnings
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

ROOT = Path(__file__).parent.parent.parent
sys.path[:0] = [str(ROOT / "tests")]
warnings.simplefilter("ignore")

from jousto.output.style import COLORS, STYLE
from verification import (
    test_solid_centrifugal as ring,
    test_solid_pulse as pulse,
    test_solid_theory as theory,
)

KINDS = {"tetra10": "tet10", "wedge15": "wedge15", "hexahedron20": "hex20"}
LINEAR = {"tetra": "tet4", "hexahedron": "hex8"}
SIZE = (0.3, 0.3, 0.15)
COUNTS = (2, 3, 4, 6)
TITLE = {"loc": "left", "fontweight": "bold", "fontsize": 10.5}
RADIAL = (2, 3, 4, 6, 8)


def label(ax, x, y, text, color, dy=0):
    """Write at the right end of a line."""
    style = {"textcoords": "offset points", "color": color, "fontsize": 7.5, "va": "center"}
    ax.annotate(text, (x, y), xytext=(6, dy), **style)


def main(folder: Path) -> None:
    """Three figures beside one another, all axes logarithmic."""
    with plt.style.context(STYLE):
        figure, (left, middle, right) = plt.subplots(
            1, 3, figsize=(10.5, 3.9), layout="constrained"
        )

        # frequencies of a thick plate
        for color, (kind, name) in zip(COLORS, (KINDS | LINEAR).items(), strict=False):
            e, h = [], []
            for n in COUNTS:
                e.append(theory.bending_error(kind, (n, n, n), SIZE))
                h.append(1e3 * SIZE[0] / n)
            left.loglog(h, e, "o-", color=color, markerfacecolor="white", markersize=4)
            label(left, h[-1], e[-1], name, color)
        left.set_title("First frequency of a plate", **TITLE)
        left.set(xlabel="element (mm)", ylabel="relative error, exact plate waves", xlim=(170, 31))
        ticks = (50, 75, 100, 150)

        # a ring between smooth planes
        h = [1e3 * (ring.RADII[1] - ring.RADII[0]) / n for n in RADIAL]
        table = np.array([ring.errors("hexahedron20", (n, 8 * n, 1)) for n in RADIAL])
        for color, e, name in zip(COLORS, table.T, ("displacement", "hoop stress"), strict=False):
            middle.loglog(h, e, "o-", color=color, markerfacecolor="white", markersize=4)
            label(middle, h[-1], e[-1], name, color)
        middle.set_title("Spinning ring, hex20", **TITLE)
        middle.set(
            xlim=(55, 6), xlabel="element (mm)", ylabel="largest error, Timoshenko and Goodier"
        )

        # a clamped bar hit by a pulse
        for color, residuals, name in zip(
            COLORS, ((), pulse.patterns()), ("modes alone", "with a residual vector"), strict=False
        ):
            e = pulse.convergence(residuals)
            for column, style in ((0, "o-"), (2, "s--")):
                right.loglog(
                    pulse.COUNTS,
                    e[:, column],
                    style,
                    color=color,
                    markerfacecolor="white",
                    markersize=4,
                )
            label(right, pulse.COUNTS[-1], e[-1, 0], name, color)
        right.set_title("Clamped bar hit by a pulse", **TITLE)
        right.set(xlabel="modes", ylabel="largest error, full model")
        for ax, values in ((left, ticks), (middle, h), (right, pulse.COUNTS)):
            ax.minorticks_off()
            ax.set_xticks(values, [f"{x:.3g}" for x in values])
        right.set_xlim(1.7, 90)
        right.plot([], [], "o-", color="#69707A", markerfacecolor="white", label="displacement")
        right.plot([], [], "s--", color="#69707A", markerfacecolor="white", label="stress")
        right.legend(loc="lower left")
        figure.savefig(folder / "solids.png")
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
