"""How an optimisation went."""

from __future__ import annotations

import numpy as np

from jousto.design.optimisation.optimum import Optimum
from jousto.output.style import COLORS, MUTED, Picture, drawing, headline


@drawing
def plot_optimum(found: Optimum) -> Picture:
    """Draw cost, largest ratio and parameters over the cycles of an optimisation.

    Parameters
    ----------
    found : Optimum
        From `optimise`.
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
