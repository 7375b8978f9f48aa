"""History of an optimisation by one or several methods."""

from __future__ import annotations

import numpy as np

from jousto.design.optimisation.comparison import Comparison
from jousto.design.optimisation.optimum import Optimum
from jousto.output.style import COLORS, MUTED, Picture, drawing, headline


@drawing
def plot_optimum(found: Optimum) -> Picture:
    """Draw cost, largest ratio and parameters over the cycles of an optimisation.

    Parameters
    ----------
    found : Optimum
        Result of `optimise`.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    figure = Picture(figsize=(10.8, 3.4), layout="constrained")
    cost, ratio, values = figure.subplots(1, 3)
    cycles = np.arange(len(found.history))
    cost.plot(cycles, [one.cost for one in found.history], "o-", color=COLORS[0])
    headline(cost, "Cost", found.method)
    ratio.plot(cycles, [one.ratio for one in found.history], "o-", color=COLORS[1])
    ratio.axhline(1.0, color=MUTED, linewidth=0.8, linestyle=":")
    headline(ratio, "Largest value / limit")
    for i, name in enumerate(found.values):
        rows = [one.values[name] for one in found.history]
        color = COLORS[i % len(COLORS)]
        values.plot(cycles, rows, "o-", color=color)
        place = {"xytext": (6, 0), "textcoords": "offset points", "va": "center"}
        values.annotate(name, (cycles[-1], rows[-1]), color=color, annotation_clip=False, **place)
    headline(values, "Parameters")
    for ax in (cost, ratio, values):
        ax.set_xlabel("cycle")
    return figure


@drawing
def plot_comparison(found: Comparison) -> Picture:
    """Draw cost and largest ratio over the runs of several methods, and their parameters.

    Parameters
    ----------
    found : Comparison
        Comparison of optima.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    figure = Picture(figsize=(10.8, 3.4), layout="constrained")
    cost, ratio, values = figure.subplots(1, 3)
    names = list(found.optima[0].values)
    wide = 0.8 / len(found.optima)
    for i, one in enumerate(found.optima):
        color, runs = COLORS[i % len(COLORS)], [cycle.runs for cycle in one.history]
        cost.plot(runs, [cycle.cost for cycle in one.history], "o-", color=color)
        ratio.plot(runs, [cycle.ratio for cycle in one.history], "o-", color=color)
        first = max(abs(found.optima[0].values[name]) for name in names) or 1.0
        places = np.arange(len(names)) + wide * (i - 0.5 * (len(found.optima) - 1))
        sizes = [one.values[name] / (abs(found.optima[0].values[name]) or first) for name in names]
        values.bar(places, sizes, wide, color=color, label=one.method)
    ratio.axhline(1.0, color=MUTED, linewidth=0.8, linestyle=":")
    values.set_xticks(np.arange(len(names)), names)
    headline(cost, "Cost")
    headline(ratio, "Largest value / limit")
    headline(values, "Parameters", f"1 is that of {found.optima[0].method}")
    for ax in (cost, ratio):
        ax.set_xlabel("runs")
    figure.legend(loc="outside lower right", ncols=len(found.optima))
    return figure
