"""Pictures of an identification: measured and fitted channels, residuals."""

from __future__ import annotations

import numpy as np

from jousto.base.errors import InputError, Problem
from jousto.base.units import shown_unit
from jousto.design.identification.identified import Fit, Identified
from jousto.output.style import COLORS, INK, MUTED, Picture, blend, drawing, headline, panels_below

PANELS = 6
"""Largest number of channels in a picture."""


def over_time(found: Identified) -> list[Fit]:
    """Return the channels over time, fitted ones and those of checks."""
    return [fit for fit in (*found.fits, *found.checks) if len(fit.time) > 1]


@drawing
def plot_identified(found: Identified) -> Picture:
    """Draw measured and fitted channels, each above its residuals in deviations of the noise.

    Parameters
    ----------
    found : Identified
        Result of `identify`.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path, or without a channel over time.
    """
    fits = over_time(found)[:PANELS]
    if not fits:
        raise InputError(Problem("plot", "nothing was compared over time"))
    figure, axes = panels_below(2 * len(fits))
    for k, fit in enumerate(fits):
        unit, factor = shown_unit(fit.unit)
        above, below = axes[2 * k], axes[2 * k + 1]
        pale = blend(INK, 0.35)
        above.plot(
            fit.time, factor * fit.measured, ".", color=pale, markersize=2.0, label="measured"
        )
        above.plot(fit.time, factor * fit.fitted, color=COLORS[1], linewidth=1.2, label="fitted")
        title = fit.channel if fit.channel == fit.sensor else f"{fit.channel}, {fit.sensor}"
        share = f"{100 * fit.test.explained:.4g} % explained"
        headline(above, f"{fit.experiment}: {title}", share)
        above.set_ylabel(unit.replace("um/m", "µm/m"))
        r = (fit.fitted - fit.measured) / fit.sd
        below.plot(fit.time, r, ".", color=COLORS[1], markersize=2.0)
        below.axhspan(-2.0, 2.0, color=blend(MUTED, 0.15), linewidth=0)
        headline(below, "residuals", f"rms {fit.test.rms:.3f} sd, Ljung-Box p {fit.test.p:.2g}")
        below.set_ylabel("sd")
        below.set_ylim(*(4.5 * np.array([-1.0, 1.0]) * max(fit.test.rms, 1.0)))
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2)
    return figure


@drawing
def plot_correlation(found: Identified) -> Picture:
    """Draw the correlation of the found values as a matrix of colours.

    Parameters
    ----------
    found : Identified
        Result of `identify`.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    names = found.names
    size = 1.6 + 0.45 * len(names)
    figure = Picture(figsize=(size + 1.0, size), layout="constrained")
    ax = figure.subplots()
    rho = np.ma.masked_invalid(found.correlation)
    image = ax.imshow(rho, vmin=-1.0, vmax=1.0, cmap="RdBu_r")
    ax.set_xticks(range(len(names)), names, rotation=90)
    ax.set_yticks(range(len(names)), names)
    figure.colorbar(image, ax=ax, label="correlation")
    return figure
