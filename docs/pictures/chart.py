"""Boxes, questions and arrows of the flow charts of the documentation; sizes in inches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.patches import FancyBboxPatch, Polygon
from matplotlib.text import Text

from jousto.output.style import COLORS, INK, MUTED, STYLE, blend

Point = tuple[float, float]
FONT = 9.5  # points


@dataclass(frozen=True)
class Box:
    """Place of a box: centre, width and height."""

    x: float
    y: float
    w: float
    h: float

    @property
    def left(self) -> Point:
        """Middle of the left side."""
        return self.x - self.w / 2, self.y

    @property
    def right(self) -> Point:
        """Middle of the right side."""
        return self.x + self.w / 2, self.y

    @property
    def top(self) -> Point:
        """Middle of the upper side."""
        return self.x, self.y + self.h / 2

    @property
    def bottom(self) -> Point:
        """Middle of the lower side."""
        return self.x, self.y - self.h / 2


class Chart:
    """Figure of the given size without axes, on which boxes and arrows are drawn."""

    def __init__(self, width: float, height: float) -> None:
        with plt.rc_context(STYLE):
            self.figure = plt.figure(figsize=(width, height))
        self.ax = self.figure.add_axes((0, 0, 1, 1))
        self.ax.set(xlim=(0, width), ylim=(0, height))
        self.ax.set_axis_off()
        self.page = Box(width / 2, height / 2, width, height)
        self.texts: list[tuple[Text, Box, bool]] = []  # with their box, and if that is a diamond

    def write(
        self,
        at: Point,
        text: str,
        within: Box | None = None,
        diamond: bool = False,
        **style: object,
    ) -> None:
        """Write text centred at a place; `within` is the box that it must not leave."""
        look = {"ha": "center", "va": "center", "fontsize": FONT, "color": INK, "linespacing": 1.35}
        written = self.ax.text(*at, text, **{**look, **style})  # type: ignore[arg-type]
        self.texts.append((written, within or self.page, diamond))

    def misfits(self) -> list[str]:
        """Return the texts that leave their box or the picture."""
        back = self.ax.transData.inverted()
        found = []
        for text, box, diamond in self.texts:
            corners = back.transform(text.get_window_extent().corners())
            # share of the way from the middle to the sides
            x, y = abs((corners - (box.x, box.y)) / (box.w / 2, box.h / 2)).T
            if max(x + y if diamond else [*x, *y]) > 1.0:
                found.append(text.get_text())
        return found

    def frame(self, box: Box, name: str, note: str, color: str) -> None:
        """Draw the pale frame of a loop, its name in one upper corner, a note in the other one."""
        self._round(box, blend(color, 0.09), blend(color, 0.5))
        y = box.top[1] - 0.2
        self.write((box.left[0] + 0.14, y), name, ha="left", color=color, fontweight="bold")
        self.write((box.right[0] - 0.14, y), note, ha="right", color=color)

    def box(self, box: Box, head: str, text: str = "", color: str = COLORS[0]) -> Box:
        """Draw a step: a bold line, and what it computes below."""
        self._round(box, "white", color)
        self._label(box, head, text)
        return box

    def end(self, box: Box, head: str, text: str = "", color: str = COLORS[7]) -> Box:
        """Draw the start or an end."""
        self._round(box, blend(color, 0.16), color, size=0.45 * box.h)
        self._label(box, head, text)
        return box

    def question(self, box: Box, text: str, color: str = COLORS[4]) -> Box:
        """Draw a question."""
        corners = [box.left, box.top, box.right, box.bottom]
        self.ax.add_patch(Polygon(corners, facecolor=blend(color, 0.15), edgecolor=color, lw=1.3))
        self.write((box.x, box.y), text, box, diamond=True)
        return box

    def arrow(self, points: Sequence[Point], text: str = "", at: Point = (0.0, 0.0)) -> None:
        """Draw an arrow along straight lines, with a word `at` from its start."""
        self.ax.plot(*zip(*points, strict=True), color=MUTED, lw=1.4, solid_capstyle="butt")
        style = {"arrowstyle": "-|>", "color": MUTED, "lw": 1.4, "shrinkA": 0, "shrinkB": 0}
        self.ax.annotate("", points[-1], points[-2], arrowprops=style)
        if text:
            x, y = points[0]
            self.write((x + at[0], y + at[1]), text, color=MUTED)

    def down(self, *boxes: Box) -> None:
        """Draw arrows from each box to the one below."""
        for upper, lower in pairwise(boxes):
            self.arrow([upper.bottom, lower.top])

    def save(self, path: Path) -> None:
        """Write the picture.

        Raises
        ------
        ValueError
            If a text is wider or higher than its box.
        """
        if wrong := self.misfits():
            raise ValueError(f"{path.name}: no room for {', '.join(map(repr, wrong))}")
        self.figure.savefig(path, dpi=220)
        plt.close(self.figure)

    def _round(self, box: Box, face: object, edge: object, size: float = 0.06) -> None:
        corner = (box.left[0], box.bottom[1])
        style = f"round,pad=0,rounding_size={size}"
        patch = FancyBboxPatch(corner, box.w, box.h, style, facecolor=face, edgecolor=edge, lw=1.3)
        self.ax.add_patch(patch)

    def _label(self, box: Box, head: str, text: str) -> None:
        lines = text.count("\n") + 1 if text else 0
        up = 0.098 * lines
        self.write((box.x, box.y + up), head, box, fontweight="bold")
        if text:
            rows = head.count("\n") + 1
            self.write((box.x, box.y + up - 0.098 * (rows + lines)), text, box)
