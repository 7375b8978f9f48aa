"""Films of moving, deformed bodies, and pictures of several instants."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import LineCollection
from numpy.typing import ArrayLike

from jousto.base.arguments import explained
from jousto.base.arrays import Array
from jousto.base.errors import Problems, warn
from jousto.base.names import file_name
from jousto.output.scenes.backdrop import new_picture
from jousto.output.scenes.film import (
    FILMS,
    MOST_FRAMES,
    Pixels,
    find_ffmpeg,
    frame_rate,
    write_film,
)
from jousto.output.scenes.stage import Moment, Stage, body_color, make_stage
from jousto.output.scenes.surface import Skin, plain
from jousto.output.scenes.symbols import SymbolPen, size_of
from jousto.output.scenes.view import View
from jousto.output.style import INK, MUTED, PAPER, PICTURES, blend, save, styled, target
from jousto.simulation.results.solution import Solution

Report = Callable[[int, int], None]

DPI = 100
AFTERGLOW = 1.0  # time for which a trail remains visible, s of the film
INSTANTS = 8
GLOW_PIECES, GLOW_FINE = 25, 6  # shades of a trail, points per shade


@explained
def animate(
    run: Solution,
    path: str | Path | None = None,
    *,
    fps: float = 25.0,
    speed: float = 1.0,
    scale: float = 1.0,
    view: View | str | None = None,
    trail: Sequence[str] | str | None = None,
    stills: int | ArrayLike = INSTANTS,
    stress: bool | float = False,
    progress: Report | None = None,
) -> Path:
    """Write a film of a run, or a picture of several instants.

    Parameters
    ----------
    run : Solution
        The results.
    path : path, optional
        File to write: .gif, .mp4 (needs ffmpeg), .html (a page with a player), or a picture (.png,
        .svg, .pdf ...), see `still`. None: the mechanism's name with the suffix .gif, in the
        working folder.
    fps : float
        Frames per second.
    speed : float
        Simulated seconds per second of the film; 0.1 is ten times slow motion.
    scale : float
        Factor on the deformation of each body in its own moving frame. A factor other than 1 also
        moves the ends of the bodies, so that joints no longer close in the picture.
    view : View, "xy", "xz" or "yz", optional
        Direction of view; None: the plane of a plane motion, else from the front and above.
    trail : str or sequence of str, optional
        Position sensors that leave a trail.
    stills : int or (k,) array_like
        Number of instants, or instants in s, for a picture.
    stress : bool or float
        Whether solids are coloured by their von Mises stress; a number is the stress of the highest
        colour, Pa; by default it is the largest stress in the film.
    progress : function, optional
        Called with the number of frames done and their total.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    InputError
        For an unknown suffix, an unwritable path, a missing ffmpeg, an unknown sensor or view.

    Warns
    -----
    JoustoWarning
        If the film would have too many frames for its format; its speed is then raised.
    """
    out = target(f"{file_name(run.name)}.gif" if path is None else path, FILMS + PICTURES)
    suffix = out.suffix.lower().lstrip(".")
    if suffix in PICTURES:
        return still(run, out, times=stills, scale=scale, view=view, trail=trail, stress=stress)
    problems = Problems()
    problems.positive("animate", "fps", float(fps), "1/s")
    problems.positive("animate", "speed", float(speed), "")
    problems.raise_if_any()
    if suffix == "mp4":
        find_ffmpeg(out)
    fps = frame_rate(suffix, float(fps))
    times, speed = _instants(run, fps, float(speed), MOST_FRAMES[suffix])
    with styled():
        stage = make_stage(run, times, scale=scale, view=view, trail=trail, stress=stress)
        frames = _frames(stage, run.name, _note(speed, scale), fps, speed, progress)
        write_film(out, frames, len(times), fps)
    return out


@explained
def still(
    run: Solution,
    path: str | Path,
    *,
    times: int | ArrayLike = INSTANTS,
    scale: float = 1.0,
    view: View | str | None = None,
    trail: Sequence[str] | str | None = None,
    stress: bool | float = False,
) -> Path:
    """Write one picture of several instants, early ones pale.

    Parameters
    ----------
    run : Solution
        The results.
    path : path
        File to write: png, svg, pdf, jpg, webp or eps.
    times : int or (k,) array_like
        Number of instants spread over the run, or instants in s.
    scale, view, trail, stress
        As for `animate`.

    Raises
    ------
    InputError
        For an unknown suffix, an unwritable path, an unknown sensor or view, or a time outside
        the run.
    """
    out = target(path, PICTURES)
    t = run.time
    if isinstance(times, int):
        problems = Problems()
        problems.positive("still", "times", times, "")
        problems.raise_if_any()
        instants = np.linspace(t[0], t[-1], times) if times > 1 else t[-1:]
    else:
        instants = np.sort(np.atleast_1d(np.asarray(times, dtype=np.float64)))
    with styled():
        stage = make_stage(run, instants, scale=scale, view=view, trail=trail, stress=stress)
        figure, ax = new_picture(stage, run.name, _note(1.0, scale))
        overlay(ax, stage)
        figure.text(
            ax.get_position().x1,
            1 - 0.3 / figure.get_figheight(),
            f"{len(instants)} instants, {instants[0]:g} to {instants[-1]:g} s"
            if len(instants) > 1
            else f"t = {instants[0]:g} s",
            color=MUTED,
            ha="right",
            va="center",
        )
        save(figure, out)
    return out


def _instants(run: Solution, fps: float, speed: float, most: int) -> tuple[Array, float]:
    """Return the instants of the frames and the speed, raised to limit the frame count."""
    start, end = float(run.time[0]), float(run.time[-1])
    wanted = (end - start) / speed * fps + 1.0  # may be infinite
    count = max(2, round(min(wanted, 1.0 + most)))
    if count > most:
        speed, count = ((end - start) * fps + speed) / most, most
        warn(
            "animate",
            f"the film would have more than {most} frames; it runs at {speed:.3g} times the real "
            f"speed instead (speed={speed:.3g}; an .mp4 may have {MOST_FRAMES['mp4']} frames)",
        )
    return np.minimum(start + np.arange(count) * speed / fps, end), speed


def _note(speed: float, scale: float) -> str:
    words = []
    if scale != 1.0:
        words.append(f"deformation × {scale:g}")
    if speed < 1.0 - 1e-9:
        words.append(f"{1.0 / speed:.3g} × slow motion")
    elif speed > 1.0 + 1e-9:
        words.append(f"{speed:.3g} × real speed")
    return ", ".join(words)


def overlay(ax: Axes, stage: Stage) -> None:
    """Draw all instants of a stage into one picture, with labels for some of them."""
    count, width = len(stage.times), stage.line_width
    for k, path in enumerate(stage.trails):
        ax.plot(*path[:, :2].T, color=blend(body_color(k), 0.55), linewidth=1.0, zorder=2)
    moments = [stage.at(i) for i in range(count)]
    if not stage.flat:
        for moment in moments:
            shadow = LineCollection(moment.shadow_lines(), colors="#EDEFF2", linewidths=width)
            shadow.set_capstyle("round")
            ax.add_collection(shadow)
            fallen = moment.shadow()
            _add_skin(ax, fallen, plain(fallen, "#EDEFF2"), 1.5)
    for i, moment in enumerate(moments):
        share = 1.0 if count == 1 else 0.22 + 0.78 * (i / (count - 1)) ** 1.3
        behind, before = moment.lined()
        for k in behind:
            _add_lines(ax, moment, k, share)
        _add_skin(ax, *moment.skin(share), 3.0)
        for k in before:
            _add_lines(ax, moment, k, share)
        symbols = SymbolPen(ax, stage.symbols, size_of(stage.box), share)
        symbols.show(i)


def _add_lines(ax: Axes, moment: Moment, k: int, share: float) -> None:
    lines, dots = moment.lines(k)
    color, width = blend(body_color(k), share), moment.stage.line_width
    for edge, extra in ((PAPER, 2.0), (color, 0.0)):
        drawn = LineCollection(lines, colors=[edge], linewidths=width + extra)
        drawn.set_capstyle("round")
        drawn.set_zorder(3)
        ax.add_collection(drawn)
    ax.plot(
        *dots.T,
        linestyle="none",
        marker="o",
        markersize=width,
        markerfacecolor=PAPER,
        markeredgecolor=color,
        markeredgewidth=1.4,
        zorder=3.1,
    )


def _add_skin(ax: Axes, corners: Array, shades: Array, order: float) -> None:
    skin = Skin()
    skin.show(corners, shades)
    skin.set_zorder(order)
    ax.add_artist(skin)


def _frames(
    stage: Stage, title: str, note: str, fps: float, speed: float, progress: Report | None
) -> Iterator[Pixels]:
    """Yield the frames; the static background is drawn once."""
    figure, ax = new_picture(stage, title, note)
    figure.set_dpi(DPI)
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    background = canvas.copy_from_bbox(figure.bbox)
    clock = figure.text(
        ax.get_position().x1,
        1 - 0.3 / figure.get_figheight(),
        "",
        ha="right",
        va="center",
        fontsize=10.5,
        color=INK,
    )
    digits = int(np.clip(-np.floor(np.log10(speed / fps)), 0, 6))
    pens = {k: _Pen(ax, k, stage) for k, one in enumerate(stage.bodies) if not one.surface}
    shadow = LineCollection([], colors="#E3E6EA", linewidths=stage.line_width)
    shadow.set_capstyle("round")
    trails = [LineCollection([], linewidths=1.6) for _ in stage.trails]
    for artist in (shadow, *trails):
        ax.add_collection(artist)
    fallen, skin = Skin(), Skin()
    for triangles in (fallen, skin):
        ax.add_artist(triangles)
    symbols = SymbolPen(ax, stage.symbols, size_of(stage.box))
    for i, t in enumerate(stage.times):
        canvas.restore_region(background)
        moment = stage.at(i)
        if not stage.flat:
            shadow.set_segments(moment.shadow_lines())
            ax.draw_artist(shadow)
            below = moment.shadow()
            fallen.show(below, plain(below, "#E3E6EA"))
            ax.draw_artist(fallen)
        for k, trail in enumerate(trails):
            _glow(trail, stage, k, float(t), AFTERGLOW * speed)
            ax.draw_artist(trail)
        behind, before = moment.lined()
        for k in behind:
            pens[k].draw(*moment.lines(k))
        skin.show(*moment.skin())
        ax.draw_artist(skin)
        for k in before:
            pens[k].draw(*moment.lines(k))
        symbols.show(i)
        symbols.draw()
        clock.set_text(f"{t:.{digits}f} s")
        figure.draw_artist(clock)
        yield np.array(canvas.buffer_rgba(), dtype=np.uint8)[:, :, :3].copy()
        if progress is not None:
            progress(i + 1, len(stage.times))


class _Pen:
    """Drawing of one body in successive frames: white edge, lines, end dots."""

    def __init__(self, ax: Axes, k: int, stage: Stage) -> None:
        width, color = stage.line_width, body_color(k)
        self.ax = ax
        self.edge = LineCollection([], colors=PAPER, linewidths=width + 2.0)
        self.line = LineCollection([], colors=color, linewidths=width)
        for lines in (self.edge, self.line):
            lines.set_capstyle("round")
            lines.set_joinstyle("round")
            ax.add_collection(lines)
        (self.dots,) = ax.plot(
            [],
            [],
            linestyle="none",
            marker="o",
            markersize=width,
            markerfacecolor=PAPER,
            markeredgecolor=color,
            markeredgewidth=1.4,
        )

    def draw(self, lines: list[Array], dots: Array) -> None:
        for artist in (self.edge, self.line):
            artist.set_segments(lines)
            self.ax.draw_artist(artist)
        self.dots.set_data(*dots.T)
        self.ax.draw_artist(self.dots)


def _glow(trail: LineCollection, stage: Stage, k: int, t: float, seconds: float) -> None:
    """Draw the fading trail of the last `seconds`."""
    times = np.linspace(max(t - seconds, stage.trail_times[0]), t, GLOW_PIECES * GLOW_FINE + 1)
    path = np.stack(
        [np.interp(times, stage.trail_times, stage.trails[k][:, i]) for i in range(2)], axis=1
    )
    starts = range(0, len(times) - 1, GLOW_FINE)
    trail.set_segments([path[i : i + GLOW_FINE + 1] for i in starts])
    ages = [(t - times[i + GLOW_FINE]) / seconds for i in starts]
    trail.set_color([blend(body_color(k), 0.75 * (1.0 - age)) for age in ages])
