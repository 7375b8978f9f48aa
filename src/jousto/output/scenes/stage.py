"""Stage: the scene of a run at some instants, projected for pictures and films."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from matplotlib.colors import to_rgb

from jousto.base.arrays import Array, Index
from jousto.base.errors import Problems, suggest
from jousto.output.scenes.surface import (
    DARKEST,
    DARKEST_STRESS,
    STRESS_COLORS,
    Surface,
    lit,
    make_surface,
)
from jousto.output.scenes.symbols import NO_SYMBOLS, Symbols, make_symbols
from jousto.output.scenes.view import View, choose_view
from jousto.output.style import COLORS
from jousto.recovery.fields.criteria import evaluate
from jousto.scene.make import make_scene
from jousto.scene.scene import Body, Scene
from jousto.scene.values_at_rows import (
    body_points,
    rows_at,
    select_vertices,
    stresses,
    thicken_body,
    vertices,
)
from jousto.simulation.results.solution import Solution

MARGIN = 0.07
FLATTEST, TALLEST = 0.35, 1.0  # limits of height / width of a picture
LEAST = 0.008  # smallest beam thickness drawn, relative to the extent of the motion
UNKNOWN = "#B9BEC5"  # colour of unknown stress
BLOCK = 32 << 20  # bytes of positions or stress per block


@dataclass(frozen=True, eq=False)
class DrawnBody:
    """Body of a picture: drawn vertices and its surface or lines."""

    body: Body
    surface: Surface | None

    @property
    def lines(self) -> Index:
        """Pairs of vertices with a line between them."""
        found = self.body.lines
        return np.zeros((0, 2), dtype=np.intp) if found is None else found


@dataclass(frozen=True, eq=False)
class Stage:
    """Content of a picture at some instants.

    Attributes
    ----------
    times : (nt,) array
        Instants, s.
    bodies : tuple of Drawn
    rows : (nt, nr) array
        The rows of the scene at the instants.
    scale : float
        Factor on the deformation.
    trails : tuple of (nt', 3) arrays
        Projected paths of sensors, m, at the instants `trail_times`.
    view : View
        Direction of view.
    box : (2, 2) array
        Lower left and upper right corner of the picture, m.
    corners : (2, 3) array
        Opposite corners of the box around everything in the world frame, m.
    level, step : float
        Height and spacing of the grid on the floor, m; 0 in a plane view.
    grid : tuple of (2, 2) arrays
        Projected lines of the floor grid, m.
    limit : float
        Stress of the highest colour, Pa; 0 if no stress is shown.
    symbols : Symbols
        Joints, springs, actuators and supports.
    """

    times: Array
    bodies: tuple[DrawnBody, ...]
    rows: Array
    scale: float
    trails: tuple[Array, ...]
    trail_times: Array
    view: View
    box: Array
    corners: Array
    level: float = 0.0
    step: float = 0.0
    grid: tuple[Array, ...] = ()
    limit: float = 0.0
    symbols: Symbols = NO_SYMBOLS

    @property
    def flat(self) -> bool:
        """Whether the view is normal to a coordinate plane."""
        return bool(self.view.plane)

    @property
    def has_origin(self) -> bool:
        """Whether the world origin is in the picture."""
        return bool(np.all(self.corners[0] <= 0.0) and np.all(self.corners[1] >= 0.0))

    @property
    def line_width(self) -> float:
        """Line width of bodies in points; thinner with many lines."""
        return float(np.clip(7.0 - 1.1 * np.log2(max(len(self.bodies), 1)), 1.0, 6.0))

    def at(self, instant: int) -> Moment:
        """Return the content at one instant."""
        return Moment(self, self.rows[instant : instant + 1])


@dataclass(frozen=True, eq=False)
class Moment:
    """Content of a picture at one instant."""

    stage: Stage
    row: Array

    @cached_property
    def x(self) -> tuple[Array, ...]:
        """Vertices (nv, 3) of each body: right, up, nearness, m."""
        stage = self.stage
        return tuple(
            stage.view.project(vertices(one.body, self.row, scale=stage.scale)[0])
            for one in stage.bodies
        )

    def skin(self, share: float = 1.0) -> tuple[Array, Array]:
        """Return visible triangles (k, 3, 3) of all bodies, and their colours.

        See `lit`; a share below 1 mixes the colours with white.
        """
        found = [self._skin(k, share) for k, one in enumerate(self.stage.bodies) if one.surface]
        none = np.zeros((0, 3, 3)), np.zeros((0, 3, 4))
        corners, shades = zip(none, *found, strict=True)
        return np.concatenate(corners), np.concatenate(shades)

    def lined(self) -> tuple[list[int], list[int]]:
        """Return the bodies without surface, far ones first, behind the centres of surfaces.

        The farthest body of each list comes first.
        """
        depth = [float(x[:, 2].mean()) for x in self.x]
        order = sorted(range(len(depth)), key=depth.__getitem__)
        bodies = self.stage.bodies
        solid = [depth[k] for k in order if bodies[k].surface]
        middle = float(np.mean(solid)) if solid else -np.inf
        rest = [k for k in order if not bodies[k].surface]
        return [k for k in rest if depth[k] < middle], [k for k in rest if depth[k] >= middle]

    def lines(self, k: int) -> tuple[list[Array], Array]:
        """Return lines (2, 2) and end dots (m, 2) of a body without surface, m."""
        x, pairs = self.x[k][:, :2], self.stage.bodies[k].lines
        if len(pairs):
            return list(x[pairs]), np.zeros((0, 2))
        return [], x if self.stage.bodies[k].surface is None else np.zeros((0, 2))

    def _skin(self, k: int, share: float) -> tuple[Array, Array]:
        one, limit = self.stage.bodies[k], self.stage.limit
        assert one.surface is not None
        found = stresses(one.body, self.row) if limit else None
        if found is None:
            colors = np.array(to_rgb(UNKNOWN if limit else body_color(k)))
        else:
            v = evaluate(found, "von-mises")[0]
            colors = np.asarray(STRESS_COLORS(np.clip(np.nan_to_num(v) / limit, 0.0, 1.0)))[:, :3]
            colors[np.isnan(v)] = to_rgb(UNKNOWN)
        darkest = DARKEST if found is None else DARKEST_STRESS
        corners, shades = lit(one.surface, self.x[k], colors, darkest)
        if found is None:  # grey, since a pale colour would look like another stress
            shades[:, :, :3] = 1.0 + share * (shades[:, :, :3] - 1.0)
        return corners, shades

    def _below(self, k: int) -> Array:
        stage = self.stage
        world = self.x[k] @ stage.view.axes
        world[:, stage.view.up] = stage.level
        return stage.view.project(world)

    def shadow(self) -> Array:
        """Return the triangles (k, 3, 3) of all bodies projected onto the floor, m."""
        found = [np.zeros((0, 3, 3))]
        for k, one in enumerate(self.stage.bodies):
            if one.surface is not None:
                found.append(self._below(k)[one.surface.triangles])
        return np.concatenate(found)

    def shadow_lines(self) -> list[Array]:
        """Return the lines of all bodies projected onto the floor, m."""
        return [
            line
            for k, one in enumerate(self.stage.bodies)
            if len(one.lines)
            for line in self._below(k)[one.lines, :2]
        ]


def body_color(k: int) -> str:
    """Return the colour of the body with index k."""
    return COLORS[k % len(COLORS)]


def make_stage(
    run: Solution,
    times: Array,
    *,
    scale: float,
    view: View | str | None,
    trail: Sequence[str] | str | None,
    stress: bool | float = False,
) -> Stage:
    """Return the projected scene of a run at some instants.

    Raises
    ------
    InputError
        If there is nothing to draw, a trail does not belong to a position sensor, the scale is not
        a number, or no body has stress data for the colours.
    """
    problems = Problems()
    problems.positive("animate", "scale", float(scale), "")
    names = () if trail is None else (trail,) if isinstance(trail, str) else tuple(trail)
    for name in names:
        if name not in run.sensors:
            problems.add("trail", f"no sensor '{name}'{suggest(name, run.sensors)}")
        elif run.about(name)["unit"] != "m":
            unit = str(run.about(name)["unit"])
            problems.add("trail", f"sensor '{name}' is not a position but in {unit}")
    if stress is not False and stress is not True:
        problems.positive("animate", "stress", float(stress), "Pa")
    if not run.bodies:
        problems.add(run.where, "there are no bodies to draw")
    problems.raise_if_any()
    scene = make_scene(run)
    rows = rows_at(scene, times)
    bodies = drawn_bodies(scene)
    limit = _limit(bodies, rows, stress, problems)
    problems.raise_if_any()

    within = (run.time >= times[0]) & (run.time <= times[-1])
    trail_times = run.time[within]
    every = max(1, len(trail_times) // 4000)
    paths = [run[name][within][::every] for name in names]
    none = make_symbols(scene.symbols, rows, scale, None)
    others = [x.reshape(-1, 3) for x in (*paths, none.ends) if x.size]
    spans = [_span(x) for x in others]
    spans += [_span(x) for one in bodies for x in _blocks(one.body, rows, scale)]
    low, high = np.concatenate(spans).min(axis=0), np.concatenate(spans).max(axis=0)
    # include the world origin unless it is far away
    size = max(float(np.max(high - low)), 1e-9)
    near = bool(np.all(np.abs(np.clip(0.0, low, high)) <= size))
    if near:
        low, high = np.minimum(low, 0.0), np.maximum(high, 0.0)
    corners = np.stack([low, high])
    # sections and balls have a depth also in a plane motion
    thin = [_span(x) for x in (*_skeleton(run, scene, rows, scale), *others)]
    seen = np.concatenate([*thin, np.zeros((int(near), 3))])
    eye = choose_view(view, _span(seen), run.attributes.get("gravity"))
    level, step, grid = (0.0, 0.0, ()) if eye.plane else _floor(eye, corners)
    stage = Stage(
        times=times,
        bodies=bodies,
        rows=rows,
        scale=scale,
        trails=tuple(eye.project(path) for path in paths),
        trail_times=trail_times[::every],
        view=eye,
        box=np.zeros((2, 2)),
        corners=corners,
        level=level,
        step=step,
        grid=grid,
        limit=limit,
        symbols=make_symbols(scene.symbols, rows, scale, eye),
    )
    return replace(stage, box=_box(stage))


def drawn_bodies(scene: Scene) -> tuple[DrawnBody, ...]:
    """Return the drawn bodies of a scene: thin beams thickened, fine surfaces coarsened."""
    least = LEAST * float(np.ptp(scene.box, axis=0).max())
    found = []
    for given in scene.bodies:
        if given.kind == "contact":
            continue
        body = thicken_body(given, least)
        if body.triangles is None or not len(body.triangles):
            found.append(DrawnBody(body, None))
            continue
        surface = make_surface(body.positions, body.triangles)
        found.append(DrawnBody(select_vertices(body, surface.nodes), surface))
    return tuple(found)


def _blocks(body: Body, rows: Array, scale: float) -> Iterator[Array]:
    """Yield the vertices (k, 3) of a body in the world, m, in blocks of instants."""
    for part in _parts(body, rows):
        yield vertices(body, part, scale=scale).reshape(-1, 3)


def _parts(body: Body, rows: Array) -> Iterator[Array]:
    step = max(1, BLOCK // (48 * max(len(body.positions), 1)))
    for first in range(0, len(rows), step):
        yield rows[first : first + step]


def _span(x: Array) -> Array:
    return np.stack([x.min(axis=0), x.max(axis=0)])


def _skeleton(run: Solution, scene: Scene, rows: Array, scale: float) -> list[Array]:
    """Return points (k, 3) of all bodies without their thickness, for the choice of view, m."""
    found = []
    shapes = {shape.name: shape for shape in run.bodies}
    for body in scene.bodies:
        if body.kind == "contact":
            continue
        if body.rings is not None:
            at = body.rings.places[:, None] + np.arange(3)
            found.append(rows[:, at].reshape(-1, 3))
        elif body.kind in ("frame", "rigid") and shapes[body.name].elements.shape[1:] != (3,):
            shape = shapes[body.name]
            phi = np.moveaxis(np.asarray(shape.modes), 2, 0)
            found.append(body_points(body.place, shape.nodes, phi, rows, scale).reshape(-1, 3))
        else:
            found += [_span(x) for x in _blocks(body, rows, scale)]
    return found


def _limit(
    bodies: Sequence[DrawnBody], rows: Array, wanted: bool | float, problems: Problems
) -> float:
    """Return the upper limit of the stress colours, Pa; 0 without stress."""
    if wanted is False:
        return 0.0
    highest = -1.0
    for one in bodies:
        if one.surface is None:
            continue
        for part in _parts(one.body, rows):
            found = stresses(one.body, part)
            if found is None:
                break
            values = evaluate(found, "von-mises")
            highest = max(highest, float(np.nanmax(values, initial=-1.0)))
    if highest < 0.0:
        problems.add(
            "stress",
            "no body of this run has a surface with stress; for modal beams in files of older "
            "versions, 'jousto hotspots RESULT BODY -o FILE.png' colours the lines, and "
            "'jousto stress RESULT BODY -o FILE.pvd' writes a film for ParaView",
        )
    return max(highest, 1e-300) if wanted is True else float(wanted)


def _box(stage: Stage) -> Array:
    """Return the corners of the picture around its content, with a limited aspect ratio."""
    project = stage.view.project
    clouds = [x[:, :2] for x in stage.trails] + list(stage.grid)
    for one in stage.bodies:
        for x in _blocks(one.body, stage.rows, stage.scale):
            clouds.append(_span(project(x)[:, :2]))
    if stage.symbols.kinds:
        clouds.append(stage.symbols.ends.reshape(-1, 3)[:, :2])
    if stage.has_origin:
        clouds.append(np.zeros((1, 2)))
    low = np.min([c.min(axis=0) for c in clouds], axis=0)
    high = np.max([c.max(axis=0) for c in clouds], axis=0)
    size = np.maximum(high - low, 1e-9) * (1.0 + 2.0 * MARGIN)
    size = np.maximum(size, [size[1] / TALLEST, size[0] * FLATTEST])
    middle = 0.5 * (low + high)
    return np.stack([middle - 0.5 * size, middle + 0.5 * size])


def _floor(view: View, corners: Array) -> tuple[float, float, tuple[Array, ...]]:
    """Return level and spacing of the floor grid, m, and its projected lines (2, 2)."""
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
