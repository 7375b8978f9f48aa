"""One body coloured by nodal values, with numbered marks: damage and hot spots."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection

from jousto.base.arrays import Array
from jousto.output.scenes.surface import DARKEST_STRESS, Skin, is_surface, lit, make_surface
from jousto.output.scenes.view import View
from jousto.output.style import INK, PAPER
from jousto.simulation.results.records import BodyShape

PIECES = 8  # pieces of a line element, each of one colour
FADED = 0.6  # opacity of a mark behind the body


def extent(shape: BodyShape, view: View) -> tuple[Array, Array]:
    """Return centre and size (2,) of the picture of a body with its margin, m."""
    x = view.project(shape.nodes)[:, :2]
    low, high = x.min(axis=0), x.max(axis=0)
    size = np.maximum(high - low, 1e-9)
    size = np.maximum(size, [size[1] / 1.2, size[0] * 0.22]) * 1.1
    return 0.5 * (low + high), size


def paint_body(
    ax: Axes,
    shape: BodyShape,
    view: View,
    values: Array,
    colors: Callable[[Array], Array],
    *,
    decades: bool = False,
) -> None:
    """Draw a body coloured by nodal values; `decades`: lines interpolate in logarithms."""
    middle, size = extent(shape, view)
    ax.set_xlim(middle[0] - 0.5 * size[0], middle[0] + 0.5 * size[0])
    ax.set_ylim(middle[1] - 0.5 * size[1], middle[1] + 0.5 * size[1])
    ax.axis("off")
    if is_surface(shape.elements):
        surface = make_surface(shape.nodes, shape.elements)
        skin = Skin()
        x, tints = view.project(shape.nodes[surface.nodes]), colors(values[surface.nodes])
        skin.show(*lit(surface, x, tints, DARKEST_STRESS))
        ax.add_artist(skin)
        return
    if not len(shape.elements):
        return
    ends = shape.elements[:, :2]
    x, share = view.project(shape.nodes)[:, :2], np.linspace(0.0, 1.0, PIECES + 1)
    points = x[ends[:, 0], None] + share[:, None] * (x[ends[:, 1]] - x[ends[:, 0]])[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        known = np.log(np.maximum(values[ends], 1e-300)) if decades else values[ends]
        middles = known[:, :1] + (share[:-1] + 0.5 / PIECES) * (known[:, 1:] - known[:, :1])
        between = np.exp(middles) if decades else middles
    pieces = np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 2)
    tints = colors(between.ravel())
    ax.add_collection(
        LineCollection(list(pieces), colors=list(tints), linewidths=6.0, capstyle="round")
    )


def mark_place(
    ax: Axes, shape: BodyShape, view: View, position: Array, number: int, color: str = INK
) -> None:
    """Mark a place by a numbered point, in brackets and faded if it is behind the body."""
    at = view.project(position[None])[0]
    seen = not is_hidden(shape, view, position)
    below = at[1] < extent(shape, view)[0][1]  # place the number on the outer side of the point
    ax.plot(
        at[0],
        at[1],
        "o",
        markersize=4.2,
        color=PAPER if seen else "none",
        markeredgecolor=color,
        alpha=1.0 if seen else FADED,
        zorder=5,
    )
    box = {"boxstyle": "round,pad=0.12", "facecolor": PAPER, "edgecolor": "none", "alpha": 0.8}
    ax.annotate(
        str(number) if seen else f"({number})",
        (at[0], at[1]),
        xytext=(5, -5 if below else 5),
        textcoords="offset points",
        va="top" if below else "bottom",
        color=color,
        fontsize=8.5,
        fontweight="bold" if seen else "normal",
        alpha=1.0 if seen else FADED,
        bbox=box if seen else None,
        zorder=6,
    )


def is_hidden(shape: BodyShape, view: View, position: Array) -> bool:
    """Return whether the surface of a body hides a place; bodies drawn as lines hide nothing."""
    if shape.elements.ndim != 2 or shape.elements.shape[1] != 3 or not len(shape.elements):
        return False
    x, p = view.project(shape.nodes), view.project(position[None])[0]
    size = float(np.ptp(x, axis=0).max())
    a, b, c = (x[shape.elements[:, k]] for k in range(3))
    u, v, w = b - a, c - a, p - a
    area = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
    flat = np.abs(area) < 1e-12 * size**2  # triangles seen edge-on
    area = np.where(flat, 1.0, area)
    s = (w[:, 0] * v[:, 1] - w[:, 1] * v[:, 0]) / area
    t = (u[:, 0] * w[:, 1] - u[:, 1] * w[:, 0]) / area
    over = ~flat & (s > -1e-9) & (t > -1e-9) & (s + t < 1.0 + 1e-9)
    # amount by which the plane of the triangle is nearer to the eye than the place
    nearer = a[:, 2] + s * u[:, 2] + t * v[:, 2] - p[2]
    return bool(np.any(over & (nearer > 1e-5 * size)))
