"""Measured channels over virtual gauges."""

from __future__ import annotations

import numpy as np

from jousto.base.errors import InputError, Problem
from jousto.base.units import shown_unit
from jousto.measurement.gauges.compare import GaugeComparison
from jousto.output.style import COLORS, INK, Picture, blend, drawing, headline, panels_below

MOST = 12  # panels


@drawing
def plot_gauges(comparison: GaugeComparison) -> Picture:
    """Draw measured channels and virtual gauges over one another, a panel for each pair.

    Parameters
    ----------
    comparison : GaugeComparison
        From `compare_gauges`.
    path : path, optional
        File to write; the suffix chooses the format.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path, or more pairs than a picture holds.
    """
    pairs = comparison.pairs
    if len(pairs) > MOST:
        raise InputError(Problem("plot", f"{len(pairs)} pairs; a picture holds {MOST}"))
    figure, axes = panels_below(len(pairs))
    for ax, pair in zip(axes, pairs, strict=True):
        unit, factor = shown_unit(pair.unit)
        measured, virtual = factor * pair.measured, factor * pair.virtual
        pale = blend(INK, 0.35)
        ax.plot(comparison.time, measured, color=pale, linewidth=3.0, label="measured")
        ax.plot(comparison.time, virtual, color=COLORS[1], linewidth=1.2, label="virtual")
        same = pair.sensor == pair.channel
        title = pair.channel if same else f"{pair.channel}, {pair.sensor}"
        note = f"scale {pair.scale:.3f}, rms of the difference {factor * pair.rms:.3g} {unit}"
        headline(ax, title, note)
        ax.set_ylabel(unit.replace("um/m", "µm/m"))
        known = np.isfinite(pair.measured)
        if known.any():
            ax.set_xlim(comparison.time[known][0], comparison.time[known][-1])
    axes[-1].set_xlabel("time (s)")
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2)
    return figure
