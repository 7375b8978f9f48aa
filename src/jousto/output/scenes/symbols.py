"""Symbols of joints, springs, actuators and ground in the picture of a mechanism."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import Collection, LineCollection, PolyCollection
from matplotlib.lines import Line2D

from jousto.base.arrays import Array
from jousto.output.scenes.view import View
from jousto.output.style import INK, MUTED, PAPER, blend
from jousto.scene.scene import Symbol
from jousto.scene.values_at_rows import points

Lines = list[Array]

SIZE = 0.018  # size of a symbol relative to the picture
COILS = 6  # windings of a spring
BARREL = 0.6  # length of an actuator's cylinder relative to its shortest length
STEEL = "#5A6472"
KINDS = {
    **dict.fromkeys(("hinge", "revolute", "spherical", "universal"), "hinge"),
    **dict.fromkeys(("slide", "prismatic", "cylindrical", "screw", "planar"), "slide"),
    **dict.fromkeys(("point-on-line", "point-on-plane", "knife-edge"), "slide"),
    **dict.fromkeys(("rolling-disc", "rolling-wheel", "rail-wheel"), "slide"),
    **{kind: kind for kind in ("fixed", "rod", "spring", "damper", "actuator", "bushing")},
    "spring-damper": "spring",
}
"""Symbols of a scene that pictures show, with their drawing; other joints and forces have no two
end points, or are visible by their effect."""
MARKS = {"hinge": "o", "bushing": "o", "slide": "s", "fixed": "s"}
ALONG = ("rod", "spring", "damper", "actuator")
MOST_MARKS = 300  # number of joints up to which each joint gets a mark


@dataclass(frozen=True, eq=False)
class Symbols:
    """Symbols between the bodies of a scene, projected.

    Attributes
    ----------
    kinds : tuple of str
        Some of the values of `KINDS`.
    ends : (nt, k, 2, 3) array
        Both points of each at every instant: right, up, nearness, m.
    grounds : (g, 2) array
        Points of ground, m.
    """

    kinds: tuple[str, ...]
    ends: Array
    grounds: Array


NO_SYMBOLS = Symbols((), np.zeros((1, 0, 2, 3)), np.zeros((0, 2)))


def make_symbols(found: Sequence[Symbol], rows: Array, scale: float, view: View | None) -> Symbols:
    """Return the symbols of a picture at rows of the scene, in the world if no view is given."""
    shown = [one for one in found if one.kind in KINDS and len(one.sides) > 1]
    ends = np.zeros((len(rows), len(shown), 2, 3))
    for k, one in enumerate(shown):
        for i, side in enumerate((one.sides[0], one.sides[-1])):
            ends[:, k, i] = points(side, rows, scale=scale)
    grounds = np.array([one.sides[0].u for one in found if one.kind == "ground"]).reshape(-1, 3)
    if view is not None:
        ends, grounds = view.project(ends), view.project(grounds)
    return Symbols(tuple(KINDS[one.kind] for one in shown), ends, grounds[:, :2])


def size_of(box: Array) -> float:
    """Return the size of a symbol for the corners of a picture, m."""
    return SIZE * float(np.max(box[1] - box[0]))


def coil(a: Array, b: Array, size: float) -> Array:
    """Return the zigzag of a spring between two points (2,), m."""
    along = b - a
    length = float(np.hypot(*along))
    if length < 1e-12:
        return np.stack([a, b])
    across = np.array([-along[1], along[0]]) / length
    t = np.linspace(0.2, 0.8, 2 * COILS + 1)
    height = np.zeros(len(t))
    height[1:-1:2], height[2:-1:2] = 1.0, -1.0
    middle = a + t[:, None] * along + size * height[:, None] * across
    return np.concatenate([a[None], middle, b[None]])


def ground_lines(point: Array, size: float) -> Lines:
    """Return the lines of the support symbol below a ground point: a triangle on hatched ground."""
    x, y = point
    low = y - 1.5 * size
    base = [(x - 1.5 * size, low), (x + 1.5 * size, low)]
    triangle = [(x, y), (x - size, low), (x + size, low), (x, y)]
    hatch = [
        [(x + s * size, low), (x + (s - 0.5) * size, low - 0.6 * size)]
        for s in (-1.0, -0.25, 0.5, 1.25)
    ]
    return [np.array(line) for line in (triangle, base, *hatch)]


def draw_grounds(ax: Axes, symbols: Symbols, size: float, order: float) -> list[Collection]:
    """Draw the supports before the bodies, which may hide them."""
    found = [ground_lines(point, size) for point in symbols.grounds]
    if not found:
        return []
    paper = PolyCollection([lines[0] for lines in found], facecolors=PAPER, zorder=order)
    inked = [line for lines in found for line in lines]
    lines = LineCollection(inked, colors=MUTED, linewidths=0.9, zorder=order + 0.01)
    for part in (paper, lines):
        ax.add_collection(part)
    return [paper, lines]


class SymbolPen:
    """Drawing of symbols at successive instants in the same axes.

    Parameters
    ----------
    ax : Axes
    symbols : Symbols
    size : float
        Size of a symbol, m.
    share : float
        Share of the colours; below 1 they are mixed with white.
    order : float
        Drawing order: symbols are above objects of lower order.
    """

    def __init__(
        self, ax: Axes, symbols: Symbols, size: float, share: float = 1.0, order: float = 3.4
    ) -> None:
        self.ax, self.symbols, self.size = ax, symbols, size
        ink, steel = blend(INK, share), blend(STEEL, share)
        lengths = np.hypot(
            *np.moveaxis(symbols.ends[:, :, 1, :2] - symbols.ends[:, :, 0, :2], 2, 0)
        )
        self.barrels = BARREL * lengths.min(axis=0, initial=np.inf)
        self.thin = LineCollection([], colors=[ink], linewidths=1.3, zorder=order)
        self.thick = LineCollection([], colors=[steel], linewidths=5.0, zorder=order + 0.05)
        # a picture of several instants shows the supports at the last instant
        still = draw_grounds(ax, symbols, size, order - 0.1) if share == 1.0 else []
        self.artists: list[Collection | Line2D] = [*still, self.thin, self.thick]
        for lines in (self.thin, self.thick):
            ax.add_collection(lines)
        self.marks: dict[str, Line2D] = {}
        kinds = [kind for kind in symbols.kinds if kind in MARKS]
        for kind in MARKS if len(kinds) <= MOST_MARKS else ():
            filled = ink if kind == "fixed" else PAPER
            (mark,) = ax.plot(
                [],
                [],
                linestyle="none",
                marker=MARKS[kind],
                markersize=6.5 if kind == "bushing" else 4.5,
                markerfacecolor=filled,
                markeredgecolor=ink,
                markeredgewidth=1.1,
                zorder=order + 0.1,
            )
            self.marks[kind] = mark
            self.artists.append(mark)

    def show(self, instant: int) -> None:
        """Move the symbols to an instant."""
        if not self.symbols.kinds:
            return
        thin: Lines = []
        thick: Lines = []
        ends = self.symbols.ends[instant, :, :, :2]
        for k, kind in enumerate(self.symbols.kinds):
            if kind not in ALONG:
                continue
            a, b = ends[k]
            length = float(np.hypot(*(b - a)))
            thin.append(coil(a, b, self.size) if kind == "spring" else np.stack([a, b]))
            if kind in ("damper", "actuator") and length > 2.0 * self.size:
                thick.append(np.stack([a, a + min(1.0, self.barrels[k] / length) * (b - a)]))
        self.thin.set_segments(thin)
        self.thick.set_segments(thick)
        for kind, mark in self.marks.items():
            places = [ends[k, 1] for k, one in enumerate(self.symbols.kinds) if one == kind]
            mark.set_data(*np.array(places).reshape(-1, 2).T)

    def draw(self) -> None:
        """Draw the symbols directly, for films."""
        for artist in self.artists:
            self.ax.draw_artist(artist)
