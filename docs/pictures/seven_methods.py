"""Draw what each of the seven methods of Altarriba (2010) needs and what it results in.

.venv/bin/python docs/pictures/seven_methods.py FOLDER
"""

from __future__ import annotations

import sys
from pathlib import Path

from chart import Chart
from matplotlib.patches import Circle, Rectangle

from jousto.output.style import COLORS, FAINT, blend

NEEDS = ("part", "machine", "runs", "gauges", "scatter")
RESULTS = ("motion", "stress", "loads", "dimensions", "probability", "a check")
RUNS = "runs"  # this column has their number
# as the sections of the page on the seven methods show it; n is the number of parameters
METHODS: dict[str, tuple[str, str, str]] = {
    "component modes": ("1", "part machine", "motion stress"),
    "equivalent static loads": ("1 + 2n", "part machine", "stress loads dimensions"),
    "reliability-based design": ("many", "machine scatter", "dimensions probability"),
    "strain reconstruction": ("", "part gauges", "stress loads check"),
    "stress due to friction": ("2", "part machine", "stress"),
    "moving frame": ("1", "part machine", "motion stress check"),
    "shape functions": ("1", "part machine", "motion stress"),
}
FIRST, STEP, TOP, ROW, HEAD = 2.7, 0.56, 3.15, 0.46, 1.15  # inches


def column(word: str) -> float:
    """Return the place of a column; there is a gap between needs and results."""
    if word in NEEDS:
        return FIRST + STEP * NEEDS.index(word)
    return FIRST + STEP * (len(NEEDS) + RESULTS.index(word)) + 0.12


def group(chart: Chart, words: tuple[str, ...], name: str, color: str) -> None:
    """Draw the pale ground of some columns, their name, and a head for each."""
    low = TOP - ROW * (len(METHODS) - 0.5)
    left = column(words[0]) - STEP / 2
    high = TOP + ROW / 2 + HEAD - low
    ground = Rectangle((left, low), STEP * len(words), high, facecolor=blend(color, 0.08))
    chart.ax.add_patch(ground)
    middle = 0.5 * (column(words[0]) + column(words[-1]))
    chart.write((middle, low + high + 0.17), name, color=color, fontweight="bold")
    for word in words:
        at = (column(word), TOP + ROW / 2 + 0.08)
        chart.write(at, word, rotation=90, va="bottom")


def row(chart: Chart, y: float, name: str) -> None:
    """Draw the line of a method: its name, a dot where it needs or results in something."""
    runs, needs, results = METHODS[name]
    chart.write((FIRST - 0.45, y), name, ha="right")
    chart.write((column(RUNS), y), runs, color=COLORS[0])
    for words, color in ((needs, COLORS[0]), (results, COLORS[2])):
        for word in words.split():
            dot = Circle(
                (column("a check" if word == "check" else word), y), 0.085, facecolor=color
            )
            chart.ax.add_patch(dot)


def main(folder: Path) -> None:
    """Draw a line for each method below the heads of the columns."""
    chart = Chart(8.9, 4.85)
    group(chart, NEEDS, "needs", COLORS[0])
    group(chart, RESULTS, "results in", COLORS[2])
    for number, name in enumerate(METHODS):
        y = TOP - ROW * number
        chart.ax.plot(
            [0.15, column(RESULTS[-1]) + STEP / 2], [y + ROW / 2] * 2, color=FAINT, lw=0.9
        )
        row(chart, y, name)
    chart.save(folder / "seven_methods.png")


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
