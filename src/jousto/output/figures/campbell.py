"""plot_campbell and plot_root_locus: eigenvalues over a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from jousto.base.arguments import explained
from jousto.output.style import COLORS, MUTED, PICTURES, Picture, save, styled, target
from jousto.simulation.modes.campbell import Campbell

SIZE = (8.0, 4.6)  # inch


@explained
def plot_campbell(
    data: Campbell, *, orders: Sequence[float] = (), path: str | Path | None = None
) -> Picture:
    """Draw frequencies over the parameter.

    Parameters
    ----------
    data : Campbell
        From `campbell`.
    orders : sequence of float
        Lines ``order * value / (2 pi)`` of excitation by a speed in rad/s.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    out = None if path is None else target(path, PICTURES)
    with styled():
        figure = Picture(figsize=SIZE, layout="constrained")
        ax = figure.subplots()
        for k, line in enumerate(data.frequencies.T):
            ax.plot(data.values, line, color=COLORS[k % len(COLORS)])
        top = float(np.nanmax(data.frequencies)) if data.frequencies.size else 1.0
        for order in orders:
            ax.plot(data.values, order * data.values / (2 * np.pi), "--", color=MUTED)
        ax.set_ylim(0.0, 1.08 * top)
        ax.set_xlabel(data.parameter)
        ax.set_ylabel("frequency (Hz)")
    if out is not None:
        save(figure, out)
    return figure


@explained
def plot_root_locus(data: Campbell, *, path: str | Path | None = None) -> Picture:
    """Draw the paths of the eigenvalues in the complex plane, a dot at the first value.

    Parameters
    ----------
    data : Campbell
        From `campbell`.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    out = None if path is None else target(path, PICTURES)
    with styled():
        figure = Picture(figsize=SIZE, layout="constrained")
        ax = figure.subplots()
        for k, line in enumerate(data.eigenvalues.T):
            color = COLORS[k % len(COLORS)]
            ax.plot(line.real, line.imag, color=color)
            ax.plot(line.real[:1], line.imag[:1], "o", color=color)
        ax.axvline(0.0, color=MUTED, linewidth=0.8)
        ax.set_xlabel("real part (1/s)")
        ax.set_ylabel("imaginary part (1/s)")
    if out is not None:
        save(figure, out)
    return figure
