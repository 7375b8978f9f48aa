"""Draw how the moving frame comes to the engine, from the test that asks for its order.

.venv/bin/python docs/pictures/moving_frame.py FOLDER
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
from natural.test_order import MACHINES, errors, steps

MARKERS = {"position": "o-", "velocity": "d-", "reaction": "s-", "stress": "^-", "multiplier": "v-"}


def main(folder: Path) -> None:
    """One panel for each machine, both axes logarithmic, one line for each kind of reading."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 6, figsize=(14.5, 3.6), layout="constrained", sharey=True)
        for ax, name in zip(axes, MACHINES, strict=True):
            h = 1e3 * np.array(steps(name))
            found = errors(name)
            for kind, e in found.items():
                color = COLORS[list(MARKERS).index(kind)]
                word = "drive" if kind == "multiplier" else kind
                label = f"{word}  {np.log2(e[-2] / e[-1]):.2f}"
                ax.loglog(h, e, MARKERS[kind], color=color, markerfacecolor="white", label=label)
            top = max(e[0] for e in found.values())
            ideal = 4.0 * top * (h / h[0]) ** 2
            ax.loglog(h, ideal, color="black", linestyle=(0, (1, 2)), linewidth=1)
            ax.set_title(name, loc="left", fontweight="bold", fontsize=10.5)
            ax.minorticks_off()
            ax.set_xticks(h, [f"{x:g}" for x in h])
            ax.set(xlabel="step (ms)", xlim=(0.85 * h[-1], 1.18 * h[0]))
            ax.legend(loc="lower right", fontsize=7.5)
        axes[0].set(ylabel="largest difference over size", ylim=(1e-12, 1))
        figure.savefig(folder / "moving_frame_order.png")
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
