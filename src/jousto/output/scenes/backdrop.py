"""Background of a picture: rulers or floor, world frame, stress colour bar."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.ticker import MaxNLocator

from jousto.output.scenes.stage import Stage
from jousto.output.scenes.surface import STRESS_COLORS
from jousto.output.scenes.view import View
from jousto.output.style import MUTED, Picture, scale_at

WIDTH = 7.2  # width of a picture, inch
LEGEND = 0.8  # width of the stress colour bar, inch


def new_picture(stage: Stage, title: str, note: str) -> tuple[Picture, Axes]:
    """Return a figure with all content that does not move."""
    size = stage.box[1] - stage.box[0]
    left, right, bottom, top = (0.62, 0.2, 0.55, 0.5) if stage.flat else (0.15, 0.15, 0.15, 0.5)
    right += LEGEND if stage.limit else 0.0
    inner = WIDTH - left - right
    height = inner * size[1] / size[0]
    total = height + bottom + top
    figure = Picture(figsize=(WIDTH, total))
    ax = figure.add_axes((left / WIDTH, bottom / total, inner / WIDTH, height / total))
    ax.set_xlim(stage.box[0, 0], stage.box[1, 0])
    ax.set_ylim(stage.box[0, 1], stage.box[1, 1])
    if stage.flat:
        _rulers(ax, stage.view)
    else:
        ax.axis("off")
        _draw_floor(ax, stage)
    _origin(ax, stage)
    figure.text(left / WIDTH, 1 - 0.3 / total, title, fontsize=10.5, fontweight="bold", va="center")
    if note:
        x = 1 - right / WIDTH  # beside the colour bar, never below it
        figure.text(x, 0.14 / total, note, color=MUTED, fontsize=8.5, ha="right", va="center")
    if stage.limit:
        color_bar(
            figure, stage.limit, (1 - (LEGEND - 0.05) / WIDTH, bottom / total, height / total)
        )
    return figure, ax


def color_bar(
    figure: Picture,
    limit: float,
    place: tuple[float, float, float],
    title: str = "von Mises",
    unit: str = "Pa",
) -> None:
    """Draw the stress colour bar from 0 to a limit; place is left, bottom and height."""
    power, prefix = next(
        ((p, s) for p, s in ((6, "M"), (3, "k"), (0, "")) if limit >= 10.0**p), (0, "")
    )
    ax = scale_at(figure, place, f"{title}\n{prefix}{unit}")
    ax.imshow(
        np.linspace(0.0, 1.0, 256)[:, None],
        cmap=STRESS_COLORS,
        aspect="auto",
        origin="lower",
        extent=(0.0, 1.0, 0.0, limit / 10.0**power),
    )
    ax.yaxis.set_major_locator(MaxNLocator(5, steps=[1, 2, 2.5, 5, 10]))


def _rulers(ax: Axes, view: View) -> None:
    for spine in ax.spines.values():
        spine.set_visible(False)
    ax.tick_params(length=0)
    ax.xaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
    ax.yaxis.set_major_locator(MaxNLocator(7, steps=[1, 2, 2.5, 5, 10]))
    ax.set_xlabel(f"{view.plane[0]} (m)")
    ax.set_ylabel(f"{view.plane[1]} (m)")
    # an axis may point to the left or down
    for axis, row in ((ax.xaxis, view.axes[0]), (ax.yaxis, view.axes[1])):
        if row.sum() < 0:
            axis.set_major_formatter(lambda value, _: f"{0.0 - value:g}")


def _draw_floor(ax: Axes, stage: Stage) -> None:
    lines = LineCollection(stage.grid, colors="#DDE1E6", linewidths=0.8, zorder=0)
    ax.add_collection(lines)
    note = f"grid {stage.step:g} m"
    ax.annotate(note, (0, 0), xycoords="axes fraction", color=MUTED, fontsize=8.5)


def _origin(ax: Axes, stage: Stage) -> None:
    """Draw the world frame: a support in a plane view, else three short arrows with letters."""
    if not stage.has_origin:
        return
    if stage.flat:
        ax.plot(0, 0, marker="+", markersize=13, markeredgewidth=1.2, color=MUTED, zorder=1)
        return
    length = 0.09 * float(np.max(stage.corners[1] - stage.corners[0]))
    for name, axis in zip("xyz", stage.view.axes.T, strict=True):
        x, y = length * axis[0], length * axis[1]
        ax.plot([0, x], [0, y], color=MUTED, linewidth=1.0, zorder=1)
        ax.text(
            1.35 * x, 1.35 * y, name, color=MUTED, fontsize=8, ha="center", va="center", zorder=1
        )
