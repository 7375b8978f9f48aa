"""Draw the work-precision diagrams of the stored run into docs/pictures.

.venv/bin/python benchmarks/precision_figures.py

Each picture carries a digest of the points it shows, which tests/test_benchmarks.py compares with
the stored run.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt

from jousto.output.style import COLORS, STYLE
from page import ROOT, stored
from precision_fronts import front, methods, programs

PICTURES = ROOT / "docs" / "pictures"
FIGURES = {"precision_flexible.png": slice(0, 4), "precision_others.png": slice(4, 8)}
OWN = dict(zip(("RK4", "ROS2", "GeneralizedAlpha", "DormandPrince", "ROS3A"), COLORS, strict=False))
OTHERS = {
    "EXUDYN": "#22272E",
    "EXUDYN tree": "#69707A",
    "MuJoCo": COLORS[6],
    "Pinocchio": COLORS[5],
}
DASHES = ("-", "--", ":")


def digest(results: dict[str, Any]) -> str:
    """Return the digest of the points of a run."""
    text = json.dumps(results["precision"], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def draw(ax: Any, name: str, found: dict[str, Any]) -> None:
    """Draw one machine: a line for each method, for EXUDYN's tolerances their front."""
    points = found["points"]
    for program in programs(points):
        for number, method in enumerate(methods(points, program)):
            line = front(points, program, method)
            if not len(line):
                continue
            own = program == "jousto"
            ax.loglog(
                line[:, 1],
                line[:, 0],
                DASHES[0 if own else number % 3],
                marker="o" if own else "s",
                markersize=3.5,
                linewidth=1.4,
                color=OWN[method] if own else OTHERS[program],
                label=f"{program}, {method}",
            )
    ax.set_title(name, loc="left", fontweight="bold", fontsize=10)
    ax.set_xlabel("processor time for a second of motion (s)")
    ax.set_ylabel("largest error of the tip (m)")
    ax.minorticks_off()
    ax.margins(0.06)
    ax.legend(fontsize=7, loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=2.6)


def main(folder: Path = PICTURES) -> None:
    """Draw both pictures."""
    results = stored()
    machines = list(results["precision"].items())
    for file, part in FIGURES.items():
        with plt.style.context(STYLE):
            figure, axes = plt.subplots(2, 2, figsize=(13.0, 8.4), layout="constrained")
            for ax, (name, found) in zip(axes.flat, machines[part], strict=False):
                draw(ax, name, found)
            figure.savefig(folder / file, metadata={"Description": digest(results)})
            plt.close(figure)


if __name__ == "__main__":
    main()
