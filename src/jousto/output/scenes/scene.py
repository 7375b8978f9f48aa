"""A moving mechanism as lines and surfaces in a picture: what films and stills share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb
from matplotlib.ticker import MaxNLocator

from jousto.base.arrays import Array
from jousto.base.errors import Problems, suggest
from jousto.output.scenes.lines import Outline, drawn
from jousto.output.scenes.skins import BeamSkin, beam_skin
from jousto.output.scenes.surface import DARKEST, DARKEST_STRESS, STRESS_COLORS, lit, make_surface
from jousto.output.scenes.symbols import (
    NO_SYMBOLS,
    Symbols,
    draw_grounds,
    joined_points,
    make_symbols,
    size_of,
)
from jousto.output.scenes.view import View, choose_view
from jousto.output.style import COLORS, MUTED, Picture, scale_at
from jousto.recovery.shape import positions
from jousto.recovery.surface import surface_stress
from jousto.simulation.results.records import BodyShape
from jousto.simulation.results.solution import Solution

WIDTH = 7.2  # inch
MARGIN = 0.07
FLATTEST, TALLEST = 0.35, 1.0  # height of a picture by its width
LEGEND = 0.8  # inch, room for the colours of stress
LEAST = 0.008  # thickness of a beam by the extent of its motion; thinner ones are drawn thicker
UNKNOWN = "#B9BEC5"  # where the stress is not known


@dataclass(frozen=True, eq=False)
class Scene:
    """Everything that is in the picture at some instants.

    Attributes
    ----------
    times : (nt,) array
        Instants, s.
    bodies : tuple of (Outline, (nt, nn, 3) array)
        Lines of each body and the projected positions of its nodes: right, up, nearness, m.
    trails : tuple of (nt', 3) arrays
        Projected paths of sensors, m, at the instants `trail_times`.
    view : View
        From where it is seen.
    box : (2, 2) array
        Lower left and upper right corner of the picture, m.
    corners : (2, 3) array
        Opposite corners of the box around everything in the world frame, m.
    level, step : float
        Height and spacing of the grid on the floor, m; there is none in a plane view.
    grid : tuple of (2, 2) arrays
        Its projected lines, m.
    stress : tuple of (nt, m) arrays or None
        Von Mises stress at the drawn nodes of each body, Pa; None where it is not shown.
    limit : float
        Stress of the highest colour, Pa; 0 if no stress is shown.
    symbols : Symbols
        Joints, springs, actuators and supports.
    """

    times: Array
    bodies: tuple[tuple[Outline, Array], ...]
    trails: tuple[Array, ...]
    trail_times: Array
    view: View
    box: Array
    corners: Array
    level: float
    step: float
    grid: tuple[Array, ...]
    stress: tuple[Array | None, ...] = ()
    limit: float = 0.0
    symbols: Symbols = NO_SYMBOLS

    @property
    def flat(self) -> bool:
        """Whether a coordinate plane is seen straight on."""
        return bool(self.view.plane)


def make_scene(
    run: Solution,
    times: Array,
    *,
    scale: float,
    view: View | str | None,
    trail: Sequence[str] | str | None,
    stress: bool | float = False,
) -> Scene:
    """Return the scene of a run at some instants.

    Raises
    ------
    InputError
        If there is nothing to draw, a trail is not of a position sensor, the scale is no number,
        or no body knows the stress that is to be shown.
    """
    problems = Problems()
    problems.positive("animate", "scale", float(scale), "")
    names = () if trail is None else (trail,) if isinstance(trail, str) else tuple(trail)
    for name in names:
        if name not in run.sensors:
            problems.add("trail", f"no sensor '{name}'{suggest(name, run.sensors)}")
        elif run.about(name)["unit"] != "m":
            problems.add("trail", f"sensor '{name}' is not a position but in {_unit(run, name)}")
    # the nodes of beams are no bodies in a picture, their beams are
    beams = run.beams
    nodes = {int(k) for beam in beams for k in beam.bodies}
    shapes = tuple(shape for k, shape in enumerate(run.bodies) if k not in nodes)
    if not shapes and not beams:
        problems.add(run.where, "there are no bodies to draw")
    problems.raise_if_any()
    skins = [beam_skin(run, beam, times, stress=stress is not False, least=LEAST) for beam in beams]
    values, limit = _stress(run, shapes, skins, times, stress, problems)
    problems.raise_if_any()

    pairs = [drawn(shape) for shape in shapes]
    world = [positions(run, shape, times, scale=scale) for shape, _ in pairs]
    outlines = [lines for _, lines in pairs]
    for skin in skins:
        surface = make_surface(skin.x[0], skin.triangles)
        outlines.append(Outline((), np.zeros(0, dtype=np.intp), surface))
        world.append(skin.x[:, surface.nodes])
    within = (run.time >= times[0]) & (run.time <= times[-1])
    trail_times = run.time[within]
    every = max(1, len(trail_times) // 4000)
    paths = [run[name][within][::every] for name in names]
    joined = run.connections
    points = joined_points(run, joined, times, scale)
    clouds = [x.reshape(-1, 3) for x in (*world, *paths, points) if x.size]
    ends = [f(x, axis=0) for x in clouds for f in (np.min, np.max)]
    low, high = np.min(ends, axis=0), np.max(ends, axis=0)
    # the world origin belongs to the picture unless it is far away
    size = max(float(np.max(high - low)), 1e-9)
    if np.all(np.abs(np.clip(0.0, low, high)) <= size):
        low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
    chosen = choose_view(view, np.stack([low, high]), run.attributes.get("gravity"))
    bodies = tuple((lines, chosen.project(x)) for lines, x in zip(outlines, world, strict=True))
    trails = tuple(chosen.project(path) for path in paths)
    symbols = make_symbols(joined, points, chosen)
    corners = np.stack([low, high])
    level, step, grid = (0.0, 0.0, ()) if chosen.plane else _floor(chosen, corners)
    return Scene(
        times=times,
        bodies=bodies,
        trails=trails,
        trail_times=trail_times[::every],
        view=chosen,
        box=_box(bodies, symbols, trails, grid, _has_origin(corners)),
        corners=corners,
        level=level,
        step=step,
        grid=grid,
        stress=tuple(
            None if v is None or lines.surface is None else v[:, lines.surface.nodes]
            for v, lines in zip(values, outlines, strict=True)
        ),
        limit=limit,
        symbols=symbols,
    )


def _stress(
    run: Solution,
    shapes: Sequence[BodyShape],
    skins: Sequence[BeamSkin],
    times: Array,
    wanted: bool | float,
    problems: Problems,
) -> tuple[list[Array | None], float]:
    """Return the von Mises stress (nt, nn) of each body, nan where unknown, and the top of it."""
    if wanted is False:
        return [None] * (len(shapes) + len(skins)), 0.0
    if wanted is not True:
        problems.positive("animate", "stress", float(wanted), "Pa")
    values: list[Array | None] = []
    for shape in shapes:
        found = surface_stress(run, shape.name, times)
        if found is None:
            values.append(None)
            continue
        whole = np.full((len(times), len(shape.nodes)), np.nan)
        whole[:, found[0]] = found[1]
        values.append(whole)
    values += [skin.mises for skin in skins]
    if all(v is None for v in values):
        problems.add(
            "stress",
            "no body of this run has a surface with stress; modal beams are lines: "
            "'jousto hotspots RESULT BODY -o FILE.png' colours them, and "
            "'jousto stress RESULT BODY -o FILE.pvd' writes a film for ParaView",
        )
        return values, 0.0
    highest = max(float(np.nanmax(v)) for v in values if v is not None)
    return values, float(wanted) if wanted is not True else max(highest, 1e-300)


def _has_origin(corners: Array) -> bool:
    return bool(np.all(corners[0] <= 0.0) and np.all(corners[1] >= 0.0))


def _unit(run: Solution, name: str) -> str:
    return str(run.about(name)["unit"])


def _box(
    bodies: tuple[tuple[Outline, Array], ...],
    symbols: Symbols,
    trails: tuple[Array, ...],
    grid: tuple[Array, ...],
    origin: bool,
) -> Array:
    """Return the corners of the picture, neither a slit nor a tower, around all that is in it."""
    clouds = [x.reshape(-1, 3)[:, :2] for _, x in bodies] + [x[:, :2] for x in trails] + list(grid)
    clouds += [symbols.ends.reshape(-1, 3)[:, :2]] if symbols.kinds else []
    if origin:
        clouds.append(np.zeros((1, 2)))
    low = np.min([c.min(axis=0) for c in clouds], axis=0)
    high = np.max([c.max(axis=0) for c in clouds], axis=0)
    size = np.maximum(high - low, 1e-9) * (1.0 + 2.0 * MARGIN)
    size = np.maximum(size, [size[1] / TALLEST, size[0] * FLATTEST])
    middle = 0.5 * (low + high)
    return np.stack([middle - 0.5 * size, middle + 0.5 * size])


def _floor(view: View, corners: Array) -> tuple[float, float, tuple[Array, ...]]:
    """Return level and spacing in m of a grid under the scene, and its projected lines (2, 2)."""
    up = view.up
    a, b = (i for i in range(3) if i != up)
    level = float(corners[0 if view.axes[1][up] > 0 else 1][up])
    step = _round_step(float(max(np.ptp(corners[:, a]), np.ptp(corners[:, b]))) / 6.0)
    lows, highs = np.floor(corners[0] / step), np.ceil(corners[1] / step)
    highs = np.maximum(highs, lows + 1.0)
    lines = []
    for across, along in ((a, b), (b, a)):
        for value in np.arange(lows[across], highs[across] + 1.0) * step:
            line = np.full((2, 3), level)
            line[:, across] = value
            line[:, along] = lows[along] * step, highs[along] * step
            lines.append(view.project(line)[:, :2])
    return level, step, tuple(lines)


def _round_step(value: float) -> float:
    power = 10.0 ** np.floor(np.log10(max(value, 1e-12)))
    return float(power * min((1.0, 2.0, 5.0, 10.0), key=lambda f: abs(f - value / power)))


# -- the picture ----------------------------------------------------------------------------


def new_picture(scene: Scene, title: str, note: str) -> tuple[Picture, Axes]:
    """Return a figure with everything in it that does not move."""
    size = scene.box[1] - scene.box[0]
    left, right, bottom, top = (0.62, 0.2, 0.55, 0.5) if scene.flat else (0.15, 0.15, 0.15, 0.5)
    right += LEGEND if scene.limit else 0.0
    inner = WIDTH - left - right
    height = inner * size[1] / size[0]
    total = height + bottom + top
    figure = Picture(figsize=(WIDTH, total))
    ax = figure.add_axes((left / WIDTH, bottom / total, inner / WIDTH, height / total))
    ax.set_xlim(scene.box[0, 0], scene.box[1, 0])
    ax.set_ylim(scene.box[0, 1], scene.box[1, 1])
    if scene.flat:
        _rulers(ax, scene.view)
    else:
        ax.axis("off")
        _draw_floor(ax, scene)
    _origin(ax, scene)
    draw_grounds(ax, scene.symbols, size_of(scene.box))
    figure.text(left / WIDTH, 1 - 0.3 / total, title, fontsize=10.5, fontweight="bold", va="center")
    if note:
        x = 1 - right / WIDTH  # beside the colours of stress, never below them
        figure.text(x, 0.14 / total, note, color=MUTED, fontsize=8.5, ha="right", va="center")
    if scene.limit:
        color_bar(
            figure, scene.limit, (1 - (LEGEND - 0.05) / WIDTH, bottom / total, height / total)
        )
    return figure, ax


def color_bar(
    figure: Picture,
    limit: float,
    place: tuple[float, float, float],
    title: str = "von Mises",
    unit: str = "Pa",
) -> None:
    """Draw the colours of stress from 0 to a limit; place is left, bottom and height."""
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


def _draw_floor(ax: Axes, scene: Scene) -> None:
    lines = LineCollection(scene.grid, colors="#DDE1E6", linewidths=0.8, zorder=0)
    ax.add_collection(lines)
    note = f"grid {scene.step:g} m"
    ax.annotate(note, (0, 0), xycoords="axes fraction", color=MUTED, fontsize=8.5)


def _origin(ax: Axes, scene: Scene) -> None:
    """Draw the world frame: a support in a plane view, else three short arrows with letters."""
    if not _has_origin(scene.corners):
        return
    if scene.flat:
        ax.plot(0, 0, marker="+", markersize=13, markeredgewidth=1.2, color=MUTED, zorder=1)
        return
    length = 0.09 * float(np.max(scene.corners[1] - scene.corners[0]))
    for name, axis in zip("xyz", scene.view.axes.T, strict=True):
        x, y = length * axis[0], length * axis[1]
        ax.plot([0, x], [0, y], color=MUTED, linewidth=1.0, zorder=1)
        ax.text(
            1.35 * x, 1.35 * y, name, color=MUTED, fontsize=8, ha="center", va="center", zorder=1
        )


def body_color(k: int) -> str:
    """Return the colour of body k."""
    return COLORS[k % len(COLORS)]


def body_lines(scene: Scene, instant: int) -> list[tuple[list[Array], Array]]:
    """Return the polylines (k, 2) and the dots (m, 2) of each body at an instant, m."""
    found = []
    for shape, x in scene.bodies:
        lines = [chain.weights @ x[instant, chain.nodes, :2] for chain in shape.chains]
        found.append((lines, x[instant, shape.dots, :2]))
    return found


def shadow_lines(scene: Scene, instant: int) -> list[Array]:
    """Return the polylines of all bodies projected straight down onto the floor, m."""
    axes, up = scene.view.axes, scene.view.up
    found = []
    for shape, x in scene.bodies:
        for chain in shape.chains:
            world = chain.weights @ x[instant, chain.nodes] @ axes
            world[:, up] = scene.level
            found.append(scene.view.project(world)[:, :2])
    return found


def body_skin(scene: Scene, k: int, instant: int, share: float = 1.0) -> tuple[Array, Array] | None:
    """Return the visible triangles of body k and their colours, None if it has no surface.

    See `lit`; a share below 1 mixes the colours with white.
    """
    shape, x = scene.bodies[k]
    if shape.surface is None:
        return None
    values = scene.stress[k] if scene.stress else None
    if values is None:
        colors = np.array(to_rgb(body_color(k) if not scene.limit else UNKNOWN))
    else:
        v = values[instant]
        colors = np.asarray(STRESS_COLORS(np.clip(v / scene.limit, 0.0, 1.0)))[:, :3]
        colors[np.isnan(v)] = to_rgb(UNKNOWN)
    darkest = DARKEST if values is None else DARKEST_STRESS
    corners, shades = lit(shape.surface, x[instant], colors, darkest)
    if values is None:  # a pale colour would be read as another stress
        shades[:, :, :3] = 1.0 + share * (shades[:, :, :3] - 1.0)
    return corners, shades


def skin_shadow(scene: Scene, k: int, instant: int) -> Array | None:
    """Return the triangles (nt, 3, 2) of body k straight down on the floor, if it has some."""
    shape, x = scene.bodies[k]
    if shape.surface is None:
        return None
    world = x[instant] @ scene.view.axes
    world[:, scene.view.up] = scene.level
    return np.asarray(scene.view.project(world)[:, :2][shape.surface.triangles])


def nearness(scene: Scene, instant: int) -> list[int]:
    """Return the numbers of the bodies, the farthest from the eye first."""
    depth = [float(x[instant, :, 2].mean()) for _, x in scene.bodies]
    return sorted(range(len(depth)), key=depth.__getitem__)


def line_width(scene: Scene) -> float:
    """Return the width of the bodies' lines in points: thinner where there are many."""
    count = sum(len(shape.chains) for shape, _ in scene.bodies)
    return float(np.clip(7.0 - 1.1 * np.log2(max(count, 1)), 1.0, 6.0))
