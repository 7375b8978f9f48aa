"""Draw the errors of all solvers against the step, from the test that asks for their orders.

.venv/bin/python docs/pictures/orders.py FOLDER
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
from verification.test_orders import METHODS, MODELS, T_END, errors


def main(folder: Path) -> None:
    """Three mechanisms beside one another, both axes logarithmic."""
    with plt.style.context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(10.5, 3.9), layout="constrained", sharey=True)
        for ax, name in zip(axes, MODELS, strict=True):
            for color, (method, (solver, counts)) in zip(COLORS, METHODS.items(), strict=False):
                h = T_END[name] / np.array(counts)
                e = errors(name, solver, counts)["state"]
                slope = np.log2(e[-2] / e[-1])
                marker = "s--" if method == "Newmark" else "o-"
                ax.loglog(h, e, marker, color=color, markerfacecolor="white", markersize=4)
                if method == "Newmark":
                    continue  # lies on generalised alpha
                label = method.replace("GeneralizedAlpha", "gen. alpha, Newmark")
                last = method == "DormandPrince"
                ax.annotate(
                    f"{label}  {slope:.2f}",
                    (h[2], e[2]) if last else (h[0], e[0]),
                    xytext=(8, -6) if last else (0, -17 if method == "ROS2" else 6),
                    textcoords="offset points",
                    color=color,
                    fontsize=7.5,
                    ha="left" if last else "right",
                    va="center",
                )
            ax.set_title(name, loc="left", fontweight="bold", fontsize=10.5)
            ticks = T_END[name] / np.array([800, 400, 200, 100])
            ax.minorticks_off()
            ax.set_xticks(ticks, [f"{1e3 * x:g}" for x in ticks])
            ax.set(xlabel="step (ms)", xlim=(0.8 * ticks[0], 1.8 * ticks[-1]))
        axes[0].set_ylabel("largest error of the state")
        figure.savefig(folder / "orders.png")
        plt.close(figure)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
