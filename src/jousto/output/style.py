"""The look of all pictures, and where they go; no state of matplotlib is changed for good."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib
from cycler import cycler
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from jousto.base.errors import InputError, Problem
from jousto.base.files import check_file, unwritable, written

INK = "#22272E"  # text and bodies' outlines
MUTED = "#69707A"  # second-rank text
FAINT = "#E7EAEE"  # grids
PAPER = "#FFFFFF"

# told apart with every kind of colour vision, dark enough for thin lines on white
COLORS = ("#1C5FA8", "#D9542B", "#2A9D78", "#8A56B0", "#C8961A", "#4BA3D4", "#B0426B", "#6B7280")
DASHES: tuple[tuple[float, ...], ...] = ((), (5, 1.6), (1.4, 1.4), (6, 1.5, 1.4, 1.5))

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
    "svg.hashsalt": "jousto",  # the same picture gives the same bytes
    "svg.fonttype": "path",
    "pdf.fonttype": 42,
}


def blend(color: str, share: float) -> tuple[float, float, float]:
    """Return a colour mixed with white; share 1 is the colour itself."""
    r, g, b = to_rgb(color)
    return 1 + share * (r - 1), 1 + share * (g - 1), 1 + share * (b - 1)


PICTURES = ("png", "svg", "pdf", "jpg", "jpeg", "webp", "eps")


class Picture(Figure):
    """A matplotlib figure that shows itself in notebooks and belongs to no global list."""

    def _repr_png_(self) -> bytes:
        data = io.BytesIO()
        with styled():
            self.savefig(data, format="png", dpi=2 * STYLE["figure.dpi"])
        return data.getvalue()


@contextmanager
def styled() -> Iterator[None]:
    """Use the style inside the with block only."""
    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(STYLE)
        yield


def target(path: str | Path, formats: tuple[str, ...], *, hint: str = "") -> Path:
    """Return the path if a file of one of the formats can be written there.

    Raises
    ------
    InputError
        If the suffix is none of the formats, a folder, device or pipe stands there, or the
        folder does not exist or is a file.
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
