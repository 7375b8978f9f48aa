"""Pictures and ParaView files of hot spots."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb

from jousto.base.arguments import explained_as
from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem
from jousto.output.figures.coloured_body import extent, mark_place, paint_body
from jousto.output.files.paraview import cells_of, save_vtu
from jousto.output.scenes.backdrop import color_bar
from jousto.output.scenes.stage import UNKNOWN
from jousto.output.scenes.surface import STRESS_COLORS
from jousto.output.scenes.view import View, choose_view
from jousto.output.style import COLORS, INK, MUTED, Picture, drawing, target
from jousto.recovery.hotspots.hot_spots import HotSpots
from jousto.recovery.shape import find_body
from jousto.simulation.results.records import BodyShape
from jousto.simulation.results.solution import Solution

WIDTH, LEGEND, GAP = 7.2, 1.1, 0.2  # inch: width, colour legend, gap
CURVES = 5  # maximum number of histories in a picture
VALUES = 2e8  # maximum number of stress values behind the colours
POINTS = 4000  # points of a curve


@drawing
def plot_hotspots(
    found: HotSpots,
    run: Solution,
    *,
    view: View | str | None = None,
) -> Picture:
    """Draw the largest value at every place, numbered hot spots, and their histories.

    Numbers in brackets mark places behind the body. For very long runs the colours use the instants
    of the hot spots and evenly spaced ones, with a note in the picture; the table covers all
    instants.

    Parameters
    ----------
    found : HotSpots
        Result of `hot_spots`.
    run : Solution
        Run of the hot spots.
    view : View, "xy", "xz" or "yz", optional
        Direction of view in the body frames.
    path : path, optional
        File to write: png, svg, pdf, jpg, webp or eps.

    Raises
    ------
    InputError
        For an unknown suffix or an unwritable path, or a run that has no such body.
    """
    figure = _picture(run, found, view)
    return figure


@explained_as("write")
def write_hotspots(found: HotSpots, path: str | Path, run: Solution) -> Path:
    """Write largest value, its time and hot-spot rank at every node for ParaView.

    One file contains all bodies, each undeformed in its own frame; the field ``body`` is the number
    of the body.

    Parameters
    ----------
    found : HotSpots
    path : path
        Ends with .vtu.
    run : Solution
        Run of the hot spots.

    Raises
    ------
    InputError
        For another ending or a path that cannot be written.
    """
    out = target(path, ("vtu",))
    nodes: list[Array] = []
    cells: list[tuple[str, Any]] = []
    offset = 0
    fields: dict[str, list[Array]] = {}
    for number, field in enumerate(found.fields, 1):
        shape = find_body(run, field.name)
        values, _ = node_values(shape, found, number - 1)
        ranks = np.zeros(len(shape.nodes))
        for spot in found:
            if spot.body == field.name:
                ranks[_node(shape, spot.node, spot.position)] = spot.rank
        data = {f"{found.criterion} ({found.unit})": values, "hot spot": ranks}
        data["body"] = np.full(len(shape.nodes), float(number))
        for key, column in data.items():
            fields.setdefault(key, []).append(column)
        nodes.append(shape.nodes)
        cells += cells_of(shape.elements, offset)
        offset += len(shape.nodes)
    columns = {key: np.concatenate(parts) for key, parts in fields.items()}
    return save_vtu(out, np.concatenate(nodes), cells, columns)


def node_values(shape: BodyShape, found: HotSpots, k: int) -> tuple[Array, int]:
    """Return the largest value at the nodes (nn,) of a body, and the stride of its instants.

    nan where unknown; the larger value where places share a node.
    """
    field = found.fields[k].during(found.start, found.end)
    every = max(1, int(np.ceil(field.ns * field.nt / VALUES)))
    if every > 1:
        own = [spot.time for spot in found if spot.body == field.name]
        kept = np.zeros(field.nt, dtype=bool)
        kept[::every] = True
        kept[np.searchsorted(field.time, own)] = True
        A = None if field.A is None else field.A[kept]
        field = replace(field, p=field.p[kept], time=field.time[kept], A=A)
    envelope = field.envelope(found.criterion)
    ranked = {
        "largest": envelope.max,
        "smallest": -envelope.min,
        "magnitude": np.maximum(np.abs(envelope.max), np.abs(envelope.min)),
    }[found.extreme]
    values = np.full(len(shape.nodes), -np.inf)
    nodes = field.modes.nodes
    if nodes is None:
        nodes = np.array([_node(shape, -1, x) for x in field.positions])
    np.maximum.at(values, nodes[nodes >= 0], ranked[nodes >= 0])
    values[~np.isfinite(values)] = np.nan
    return values, every


def _node(shape: BodyShape, node: int, position: Array) -> int:
    if node >= 0:
        return node
    return int(np.argmin(np.linalg.norm(shape.nodes - position, axis=1)))


def _picture(run: Solution, found: HotSpots, view: View | str | None) -> Picture:
    if not found.spots:
        raise InputError(Problem("plot", "there are no hot spots to draw"))
    names = list(dict.fromkeys(spot.body for spot in found))
    shapes = [find_body(run, name) for name in names]
    places = [field.name for field in found.fields]
    known = [node_values(s, found, places.index(s.name)) for s in shapes]
    limit = max(float(np.nanmax(values)) for values, _ in known)
    limit = limit if limit > 0.0 else 1e-300
    chosen = [choose_view(view, shape.nodes, None) for shape in shapes]
    heights = [_height(shape, v) for shape, v in zip(shapes, chosen, strict=True)]
    below, top = 2.3, 0.5
    total = sum(heights) + 0.35 * len(shapes) + below + top
    figure = Picture(figsize=(WIDTH, total))
    inner = WIDTH - GAP - LEGEND
    y = total - top
    for shape, eye, height, (values, _) in zip(shapes, chosen, heights, known, strict=True):
        y -= height + 0.1
        ax = figure.add_axes((GAP / WIDTH, y / total, inner / WIDTH, height / total))
        _body(ax, shape, eye, values / limit, found)
        if len(shapes) > 1:
            figure.text(
                GAP / WIDTH, (y + height) / total, shape.name, color=MUTED, fontsize=8.5, va="top"
            )
        y -= 0.25
    what = str(found.criterion)
    what = what.replace("-", "-\n", 1) if len(what) > 11 else what
    what += {"smallest": ",\nnegative", "magnitude": "", "largest": ""}[found.extreme]
    title = f"{found.criterion}: the worst places of {run.name}"
    figure.text(GAP / WIDTH, 1 - 0.25 / total, title, fontsize=10.5, fontweight="bold", va="center")
    first = heights[0]
    place = (1 - (LEGEND - 0.15) / WIDTH, (total - top - first - 0.1) / total, first / total)
    factor = 1.0 if found.unit == "Pa" else 1e6
    color_bar(figure, factor * limit, place, what, "Pa" if found.unit == "Pa" else "µm/m")
    every = max(step for _, step in known)
    if every > 1:
        note = f"colours: every {every}. instant and those of the hot spots"
        figure.text(GAP / WIDTH, (below - 0.05) / total, note, color=MUTED, fontsize=8)
    axes = figure.add_axes(
        (0.62 / WIDTH, 0.5 / total, (WIDTH - 0.62 - LEGEND) / WIDTH, (below - 0.75) / total)
    )
    _histories(axes, found)
    return figure


def _height(shape: BodyShape, view: View) -> float:
    _, size = extent(shape, view)
    return float((WIDTH - GAP - LEGEND) * size[1] / size[0])


def _body(ax: Axes, shape: BodyShape, view: View, shares: Array, found: HotSpots) -> None:
    """Draw a body coloured by nodal values with its hot spots."""
    paint_body(ax, shape, view, shares, _colors)
    for spot in reversed(found.spots):
        if spot.body == shape.name:
            color = COLORS[(spot.rank - 1) % len(COLORS)] if spot.rank <= CURVES else INK
            mark_place(ax, shape, view, spot.position, spot.rank, color)


def _colors(shares: Array) -> Any:
    colors = np.asarray(STRESS_COLORS(np.clip(np.nan_to_num(shares), 0.0, 1.0)))[:, :3]
    colors[np.isnan(shares)] = to_rgb(UNKNOWN)
    return colors


def _histories(ax: Axes, found: HotSpots) -> None:
    factor, unit = (1e-6, "MPa") if found.unit == "Pa" else (1e6, "µm/m")
    for spot in found.spots[:CURVES]:
        field = found.field(spot)
        values = factor * found.history(spot)
        color = COLORS[(spot.rank - 1) % len(COLORS)]
        ax.plot(*_thinned(field.time, values), color=color, linewidth=1.1, label=str(spot.rank))
        ax.plot(spot.time, factor * spot.value, "o", markersize=4, color=color)
    ax.set_xlabel("time (s)")
    ax.set_ylabel(f"{found.criterion} ({unit})")
    ax.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), title="hot spot")


def _thinned(time: Array, values: Array) -> tuple[Array, Array]:
    """Return a curve with fewer points: the extremes of each piece."""
    if len(values) <= POINTS:
        return time, values
    step = -(-2 * len(values) // POINTS)
    kept = set()
    for first in range(0, len(values), step):
        piece = values[first : first + step]
        kept |= {first + int(np.argmin(piece)), first + int(np.argmax(piece))}
    at = np.array(sorted(kept))
    return time[at], values[at]
