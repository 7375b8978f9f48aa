"""Shapes of a planar frame with its energies or its load path."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from jousto.output.style import COLORS, MUTED, Picture, blend, drawing
from jousto.planar.results import PlanarPath, PlanarRun

SHAPES = 7  # shapes drawn of a motion


@drawing
def plot_planar(run: PlanarRun | PlanarPath) -> Picture:
    """Draw shapes of a frame, the last one darkest, with energies or load path.

    Parameters
    ----------
    run : PlanarRun or PlanarPath
        A motion: with its energies and the residuals evaluated per step. Equilibria: with the load
        factor over the largest displacement of a node.
    path : path, optional
        File to write; the suffix chooses the format.

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path.
    """
    motion = isinstance(run, PlanarRun)
    figure = Picture(figsize=(9.5, 3.6), layout="constrained")
    axes = figure.subplots(1, 3 if motion else 2)
    _shapes(axes[0], run)
    if isinstance(run, PlanarRun):
        axes[1].plot(run.time, run.energies[:, 0], color=COLORS[0], label="kinetic")
        axes[1].plot(run.time, run.energies[:, 1], color=COLORS[1], label="strain")
        axes[1].set(xlabel="time (s)", ylabel="energy (J)")
        axes[1].legend()
        axes[2].plot(run.time[1:], run.evaluations[1:], ".", color=COLORS[0], markersize=2)
        axes[2].set(xlabel="time (s)", ylabel="residuals evaluated per step", ylim=(0, None))
    else:
        size = np.hypot(run.displacements[:, :, 0], run.displacements[:, :, 1])
        k = int(size.max(axis=0).argmax())
        axes[1].plot(size[:, k], run.factors, ".-", color=COLORS[0])
        name = list(run.frame.nodes)[k]
        axes[1].set(xlabel=f"displacement of node {name} (m)", ylabel="load factor")
    return figure


def _shapes(ax: Axes, run: PlanarRun | PlanarPath) -> None:
    count = len(run.q)
    chosen = np.unique(np.linspace(0, count - 1, SHAPES).round().astype(int))
    for i, k in enumerate(chosen):
        color = blend(COLORS[0], 0.25 + 0.75 * i / max(1, len(chosen) - 1))
        for line in lines(run, int(k)):
            ax.plot(line[:, 0], line[:, 1], color=color if i else MUTED)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.05)
    ax.set(xlabel="x (m)", ylabel="y (m)")


def lines(run: PlanarRun | PlanarPath, k: int) -> list[NDArray[np.float64]]:
    """Return the polyline of each beam at one instant: node, arm, axis, arm, node; m."""
    frame = run.frame
    places = {name: i for i, name in enumerate(frame.nodes)}
    out = []
    for beam in frame.beams:
        points = []
        for name, offset in ((beam.a, beam.offset_a), (beam.b, beam.offset_b)):
            i = places[name]
            x, th = run.positions[k, i], run.displacements[k, i, 2]
            c, s = np.cos(th), np.sin(th)
            points.append((x, x + np.array([[c, -s], [s, c]]) @ np.asarray(offset)))
        (a, axis_a), (b, axis_b) = points
        out.append(np.array([a, axis_a, axis_b, b]))
    return out
