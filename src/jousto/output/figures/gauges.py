"""Measured channels over virtual gauges."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.layout_engine import ConstrainedLayoutEngine

from jousto.base.arguments import explained_as
from jousto.base.errors import InputError, Problem
from jousto.base.units import shown_unit
from jousto.measurement.gauges.compare import GaugeComparison
from jousto.output.style import COLORS, INK, MUTED, PICTURES, Picture, blend, save, styled, target

WIDTH = 8.0  # inch
MOST = 12  # panels


@explained_as("plot")
def plot_gauges(comparison: GaugeComparison, *, path: str | Path | None = None) -> Picture:
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
    out = None if path is None else target(path, PICTURES)
    pairs = comparison.pairs
    if len(pairs) > MOST:
        raise InputError(Problem("plot", f"{len(pairs)} pairs; a picture holds {MOST}"))
    with styled():
        figure = Picture(
            figsize=(WIDTH, 0.75 + (2.9 if len(pairs) == 1 else 1.75) * len(pairs)),
            layout=ConstrainedLayoutEngine(h_pad=0.09, w_pad=0.09, hspace=0.02),
        )
        axes = figure.subplots(len(pairs), 1, sharex=True, squeeze=False)[:, 0]
        for ax, pair in zip(axes, pairs, strict=True):
            unit, factor = shown_unit(pair.unit)
            ax.plot(
                comparison.time,
                factor * pair.measured,
                color=blend(INK, 0.35),
                linewidth=3.0,
                label="measured",
            )
            ax.plot(
                comparison.time,
                factor * pair.virtual,
                color=COLORS[1],
                linewidth=1.2,
                label="virtual",
            )
            same = pair.sensor == pair.channel
            title = pair.channel if same else f"{pair.channel}, {pair.sensor}"
            ax.set_title(title, loc="left", fontsize=10.5, fontweight="bold", pad=7)
            ax.annotate(
                f"scale {pair.scale:.3f}, rms of the difference {factor * pair.rms:.3g} {unit}",
                (1, 1),
                xytext=(0, 7),
                xycoords="axes fraction",
                textcoords="offset points",
                ha="right",
                va="baseline",
                color=MUTED,
                fontsize=8.5,
            )
            ax.set_ylabel(unit.replace("um/m", "µm/m"))
            known = np.isfinite(pair.measured)
            if known.any():
                ax.set_xlim(comparison.time[known][0], comparison.time[known][-1])
        for ax in axes[:-1]:
            ax.tick_params(labelbottom=False)
        axes[-1].set_xlabel("time (s)")
        handles, labels = axes[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", ncols=2)
    if out is not None:
        save(figure, out)
    return figure
