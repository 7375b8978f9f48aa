"""Style of all pictures, and checks of output paths; matplotlib's global state is unchanged."""

from __future__ import annotations

import functools
import inspect
import io
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
from cycler import cycler
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from jousto.base.arguments import explained_as
from jousto.base.errors import InputError, Problem
from jousto.base.files import check_file, unwritable, written

INK = "#22272E"  # text and outlines of bodies
MUTED = "#69707A"  # secondary text
FAINT = "#E7EAEE"  # grid lines
PAPER = "#FFFFFF"

# distinguishable with all kinds of colour vision, dark enough for thin lines on white
COLORS = ("#1C5FA8", "#D9542B", "#2A9D78", "#8A56B0", "#C8961A", "#4BA3D4", "#B0426B", "#6B7280")
DASHES: tuple[tuple[float, ...], ...] = (
    *((), (5, 1.6), (1.4, 1.4), (6, 1.5, 1.4, 1.5)),
    *((12, 2.5), (1.4, 4.5), (6, 1.5, 1.4, 1.5, 1.4, 1.5)),
)

STYLE: dict[Any, Any] = {
    "font.family": ["DejaVu Sans"],
    "font.size": 9.5,
    "mathtext.default": "regular",
    "text.color": INK,
    "figure.facecolor": PAPER,
    "figure.dpi": 110,
    "savefig.dpi": 160,
    "savefig.facecolor": PAPER,
    "axes.facecolor": PAPER,
    "axes.edgecolor": "#9AA1AB",
    "axes.linewidth": 0.8,
    "axes.labelcolor": MUTED,
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.prop_cycle": cycler(color=COLORS),
    "axes.axisbelow": True,
    "axes.xmargin": 0.0,
    "axes.ymargin": 0.06,
    "axes.formatter.limits": (-3, 4),
    "axes.formatter.use_mathtext": True,
    "axes.unicode_minus": True,
    "grid.color": FAINT,
    "grid.linewidth": 0.8,
    "xtick.color": "#9AA1AB",
    "ytick.color": "#9AA1AB",
    "xtick.labelcolor": MUTED,
    "ytick.labelcolor": MUTED,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "xtick.major.size": 3.0,
    "ytick.major.size": 0.0,
    "xtick.minor.size": 0.0,
    "ytick.minor.size": 0.0,
    "lines.linewidth": 1.4,
    "lines.solid_capstyle": "round",
    "lines.solid_joinstyle": "round",
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "svg.hashsalt": "jousto",  # equal pictures give equal bytes
    "svg.fonttype": "path",
    "pdf.fonttype": 42,
}


def blend(color: str, share: float) -> tuple[float, float, float]:
    """Return a colour mixed with white; share 1 is the colour itself."""
    r, g, b = to_rgb(color)
    return 1 + share * (r - 1), 1 + share * (g - 1), 1 + share * (b - 1)


PICTURES = ("png", "svg", "pdf", "jpg", "jpeg", "webp", "eps")


class Picture(Figure):
    """Matplotlib figure that displays itself in notebooks and is in no global list."""

    def _repr_png_(self) -> bytes:
        data = io.BytesIO()
        with styled():
            self.savefig(data, format="png", dpi=2 * STYLE["figure.dpi"])
        return data.getvalue()


@contextmanager
def styled() -> Iterator[None]:
    """Apply the style inside the with block."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        yield


def drawing(function: Callable[..., Picture]) -> Callable[..., Picture]:
    """Return a decorator: draw in the style, and write the picture if `path` is given."""

    @functools.wraps(function)
    def draw(*given: Any, path: str | Path | None = None, **options: Any) -> Picture:
        out = None if path is None else target(path, PICTURES)
        with styled():
            figure = function(*given, **options)
        if out is not None:
            save(figure, out)
        return figure

    old = inspect.signature(function)
    more = inspect.Parameter(
        "path", inspect.Parameter.KEYWORD_ONLY, default=None, annotation="str | Path | None"
    )
    draw.__signature__ = old.replace(  # type: ignore[attr-defined]
        parameters=[*old.parameters.values(), more]
    )
    return explained_as("plot")(draw)


def panels_below(count: int) -> tuple[Picture, list[Axes]]:
    """Return a picture of panels one below the other with a common time axis."""
    height = 0.75 + (2.9 if count == 1 else 2.1 if count < 4 else 1.75) * count
    layout = ConstrainedLayoutEngine(h_pad=0.09, w_pad=0.09, hspace=0.02)
    figure = Picture(figsize=(8.0, height), layout=layout)
    axes = list(figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0])
    axes[-1].set_xlabel("time (s)")
    return figure, axes


def headline(ax: Axes, title: str, note: str = "") -> None:
    """Write a title above a panel on the left and a pale note on the right."""
    ax.set_title(title, loc="left", fontsize=10.5, fontweight="bold", pad=7)
    ax.annotate(
        note,
        (1, 1),
        xytext=(0, 7),
        xycoords="axes fraction",
        textcoords="offset points",
        ha="right",
        va="baseline",
        color=MUTED,
        fontsize=8.5,
    )


def scale_at(figure: Figure, place: tuple[float, float, float], title: str) -> Axes:
    """Return the axes of a colour bar with its title; place is left, bottom and height."""
    left, bottom, height = place
    height = min(height, 2.4 / figure.get_figheight())
    ax = figure.add_axes((left, bottom, 0.13 / figure.get_figwidth(), height))
    ax.set_xticks([])
    ax.yaxis.tick_right()
    ax.tick_params(length=0, which="both")
    ax.grid(False)
    ax.spines[:].set_visible(False)
    y = bottom + height + 0.08 / figure.get_figheight()
    figure.text(left, y, title, color=MUTED, fontsize=8.5, va="bottom")
    return ax


def target(path: str | Path, formats: tuple[str, ...], *, hint: str = "") -> Path:
    """Return the path after a check that a file of one of the formats can be written there.

    Raises
    ------
    InputError
        If the suffix is none of the formats, the path is a folder, device or pipe, or its folder
        does not exist or is a file.
    """
    path = Path(path)
    suffix = path.suffix.lower().lstrip(".")
    if suffix not in formats:
        found = f"'.{suffix}' is not a format" if suffix else "there is no suffix"
        known = ", ".join(f".{f}" for f in formats)
        raise InputError(Problem(str(path), f"{found} to write here; known: {known}{hint}"))
    check_file(path)
    try:
        missing = not path.parent.is_dir()
    except OSError as error:
        raise unwritable(path, error) from error
    if missing:
        raise InputError(
            Problem(str(path), f"the folder {path.parent} does not exist; create it first")
        )
    return path


def save(figure: Figure, path: Path) -> None:
    """Write a figure; the same figure gives the same bytes.

    Raises
    ------
    InputError
        If the file cannot be written.
    """
    suffix = path.suffix.lower().lstrip(".")
    metadata: dict[str, Any] = {"svg": {"Date": None}, "pdf": {"CreationDate": None}}.get(
        suffix, {}
    )
    with written(path) as beside, styled():
        figure.savefig(beside, format=suffix, metadata=metadata or None)
