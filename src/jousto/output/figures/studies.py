"""Study pictures: outcomes over parameters, scatter, response surface, parallel axes."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.design.studies.table import StudyTable
from jousto.output.style import COLORS, FAINT, MUTED, PICTURES, Picture, save, styled, target

KINDS = ("lines", "scatter", "surface", "parallel")
WIDE, HIGH = 3.4, 2.6  # inch, width and height of one axis
SHADES = LinearSegmentedColormap.from_list("jousto", [COLORS[0], FAINT, COLORS[1]])
FEW = 7  # number of parameter values up to which each value gets its own line


@explained_as("plot")
def plot_study(
    table: StudyTable,
    *names: str,
    kind: Literal["lines", "scatter", "surface", "parallel"] | None = None,
    path: str | Path | None = None,
) -> Picture:
    """Draw the points of a study; failed points are left out and their number is stated.

    Parameters
    ----------
    table : StudyTable
        Table from ``study.run``.
    *names : str
        Names of columns, by default all; for a surface, two parameters and an outcome.
    kind : {"lines", "scatter", "surface", "parallel"}, optional
        "lines": outcomes over a parameter, with a line for each value of a second one; "scatter":
        columns over each other; "surface": an outcome over two parameters; "parallel": all columns
        side by side, with a line for each point, coloured by the last column. Default: lines for
        one parameter, or for two if one has few values; else scatter.
    path : path, optional
        File to write; the suffix chooses the format.

    Raises
    ------
    InputError
        For unknown columns or kinds, a surface without two varying parameters, or if all points
        failed.
    """
    for name in names:
        table[name]
    if kind is not None and kind not in KINDS:
        raise InputError(Problem("plot", f"kind is {kind!r}{suggest(str(kind), KINDS)}"))
    good = table.good
    if not good.any():
        raise InputError(Problem("plot", "all points of the study failed"))
    out = None if path is None else target(path, PICTURES)
    columns = {name: table[name][good] for name in names or table.columns}
    across = [n for n in table.parameters if n in columns and np.ptp(columns[n]) > 0.0]
    up = [name for name in table.outcomes if name in columns]
    chosen = kind or _kind(columns, across)
    if not up or not across:
        message = "needs an outcome and a parameter that varies"
        raise InputError(Problem("plot", f"a picture of a study {message}"))
    with styled():
        if chosen == "lines":
            figure = _lines(table, columns, across, up)
        elif chosen == "surface":
            figure = _surface(table, columns, across, up)
        elif chosen == "parallel":
            figure = _parallel(table, {n: columns[n] for n in (*across, *up)})
        else:
            figure = _scatter(table, {n: columns[n] for n in (*across, *up)})
        if failed := int((~good).sum()):
            figure.suptitle(f"{failed} failed", x=0.99, ha="right", color=MUTED, fontsize=8.5)
    if out is not None:
        save(figure, out)
    return figure


def _kind(columns: dict[str, Array], across: Sequence[str]) -> str:
    """Return the kind of picture that suits the columns."""
    if len(across) < 2:
        return "lines"
    few = min(len(np.unique(columns[name])) for name in across)
    return "lines" if len(across) == 2 and few <= FEW else "scatter"


def _lines(
    table: StudyTable, columns: dict[str, Array], across: Sequence[str], up: Sequence[str]
) -> Picture:
    """Draw outcomes over the parameter with most values, a line per value of the next one."""
    order = sorted(across, key=lambda name: -len(np.unique(columns[name])))
    x, second = order[0], order[1] if len(order) > 1 else None
    groups = [slice(None)] if second is None else list(np.unique(columns[second]))
    figure = Picture(figsize=(WIDE * 1.9, HIGH * len(up) * 0.95), layout="constrained")
    axes = np.atleast_1d(figure.subplots(len(up), 1, sharex=True))
    for ax, name in zip(axes, up, strict=True):
        for k, value in enumerate(groups):
            some: Any = value if second is None else columns[second] == value
            place = np.argsort(columns[x][some], kind="stable")
            text = None if second is None else f"{value:.4g}"
            line = columns[x][some][place], columns[name][some][place]
            ax.plot(*line, ".-", color=_color(k, len(groups)), label=text)
        ax.set_ylabel(table.label(name))
    if second is not None and len(groups) <= 2 * FEW:
        axes[0].legend(title=table.label(second))
    axes[-1].set_xlabel(table.label(x))
    return figure


def _color(k: int, count: int) -> Any:
    return COLORS[k] if count <= len(COLORS) else SHADES(k / max(count - 1, 1))


def _scatter(table: StudyTable, columns: dict[str, Array]) -> Picture:
    """Draw every column over every other, with histograms on the diagonal."""
    names, n = list(columns), len(columns)
    size = max(1.5, min(2.2, 12.0 / n))
    figure = Picture(figsize=(size * n, size * n), layout="constrained")
    axes = np.array(figure.subplots(n, n, squeeze=False))
    for i, up in enumerate(names):
        for j, across in enumerate(names):
            ax: Axes = axes[i, j]
            if i == j:
                ax.hist(columns[up], bins=20, color=COLORS[0])
                ax.set_yticks([])
            else:
                color = COLORS[0] if up in table.outcomes else COLORS[7]
                ax.plot(columns[across], columns[up], ".", color=color, markersize=3)
            if i < n - 1:
                ax.tick_params(labelbottom=False)
            else:
                ax.set_xlabel(table.label(across))
            if j == 0 and i:
                ax.set_ylabel(table.label(up))
            elif j == 0:
                ax.set_ylabel(table.label(up))
            else:
                ax.tick_params(labelleft=False)
    return figure


def _surface(
    table: StudyTable, columns: dict[str, Array], across: Sequence[str], up: Sequence[str]
) -> Picture:
    """Draw outcomes over two parameters as interpolated colours."""
    if len(across) != 2:
        found = ", ".join(across)
        message = f"a surface is over two parameters that vary; there are: {found}; name two"
        raise InputError(Problem("plot", message))
    x, y = (columns[name] for name in across)
    u, v = (x - x.min()) / np.ptp(x), (y - y.min()) / np.ptp(y)
    corners = np.linalg.matrix_rank(np.column_stack([u - u[0], v - v[0]]), tol=1e-9)
    if corners < 2:
        raise InputError(Problem("plot", "a surface needs points that are not on a line"))
    figure = Picture(figsize=(WIDE * 1.4 * len(up), HIGH * 1.4), layout="constrained")
    for ax, name in zip(np.atleast_1d(figure.subplots(1, len(up))), up, strict=True):
        if np.ptp(columns[name]) > 0.0:
            shown = ax.tricontourf(x, y, columns[name], levels=16, cmap=SHADES)
            figure.colorbar(shown, ax=ax, label=table.label(name))
        else:
            ax.set_title(f"{table.label(name)}: {columns[name][0]:.4g}")
        ax.plot(x, y, ".", color=MUTED, markersize=2)
        ax.grid(False)
        ax.set_xlabel(table.label(across[0]))
        ax.set_ylabel(table.label(across[1]))
    return figure


def _parallel(table: StudyTable, columns: dict[str, Array]) -> Picture:
    """Draw one line per point through all columns, coloured by the last column."""
    names = list(columns)
    low = {name: float(columns[name].min()) for name in names}
    span = {name: float(np.ptp(columns[name])) or 1.0 for name in names}
    lines = np.array([(columns[name] - low[name]) / span[name] for name in names]).T
    figure = Picture(figsize=(max(5.0, 1.5 * len(names)), HIGH * 1.5), layout="constrained")
    ax = figure.subplots()
    at = np.arange(len(names), dtype=float)
    paths = [np.column_stack([at, line]) for line in lines]
    drawn = LineCollection(paths, cmap=SHADES, linewidths=0.8, alpha=0.8)
    drawn.set_array(columns[names[-1]])
    ax.add_collection(drawn)
    ax.set_xlim(-0.1, len(names) - 0.9)
    ax.set_ylim(-0.1, 1.1)
    for k, name in enumerate(names):
        ax.axvline(k, color=MUTED, linewidth=0.8)
        for height, value in ((-0.06, low[name]), (1.03, low[name] + span[name])):
            ax.text(k, height, f"{value:.4g}", ha="center", color=MUTED, fontsize=8)
    ax.set_xticks(at, [table.label(name) for name in names])
    ax.set_yticks([])
    ax.grid(False)
    return figure
