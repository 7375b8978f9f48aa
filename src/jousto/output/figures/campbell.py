"""Eigenvalues over a parameter: Campbell diagrams and root loci."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes

from jousto.base.errors import InputError, Problem, suggest
from jousto.output.style import COLORS, MUTED, Picture, drawing
from jousto.simulation.modes.campbell import Campbell

SIZE = (8.0, 4.6)  # width and height, inch
KINDS = ("frequencies", "root locus")


@drawing
def plot_campbell(
    data: Campbell,
    *,
    kind: Literal["frequencies", "root locus"] = "frequencies",
    orders: Sequence[float] = (),
) -> Picture:
    """Draw frequencies over the parameter, or the paths of the eigenvalues.

    Parameters
    ----------
    data : Campbell
        Result of `campbell`.
    kind : {"frequencies", "root locus"}
        A root locus draws the eigenvalues in the complex plane, a dot at the first value.
    orders : sequence of float
        Lines ``order * value / (2 pi)`` of excitation by a speed in rad/s, over frequencies.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For an unknown kind or suffix, or an unwritable path.
    """
    if kind not in KINDS:
        raise InputError(Problem("plot", f"kind is {kind!r}{suggest(str(kind), KINDS)}"))
    figure = Picture(figsize=SIZE, layout="constrained")
    ax = figure.subplots()
    if kind == "frequencies":
        _frequencies(ax, data, orders)
    else:
        _locus(ax, data)
    return figure


def _frequencies(ax: Axes, data: Campbell, orders: Sequence[float]) -> None:
    for k, line in enumerate(data.frequencies.T):
        ax.plot(data.values, line, color=COLORS[k % len(COLORS)])
    top = float(np.nanmax(data.frequencies)) if data.frequencies.size else 1.0
    for order in orders:
        ax.plot(data.values, order * data.values / (2 * np.pi), "--", color=MUTED)
    ax.set_ylim(0.0, 1.08 * top)
    ax.set_xlabel(data.parameter)
    ax.set_ylabel("frequency (Hz)")


def _locus(ax: Axes, data: Campbell) -> None:
    for k, line in enumerate(data.eigenvalues.T):
        color = COLORS[k % len(COLORS)]
        ax.plot(line.real, line.imag, color=color)
        ax.plot(line.real[:1], line.imag[:1], "o", color=color)
    ax.axvline(0.0, color=MUTED, linewidth=0.8)
    ax.set_xlabel("real part (1/s)")
    ax.set_ylabel("imaginary part (1/s)")
