"""Answers to requests of the page, computed from the opened objects in double precision.

Only the columns and instants that a question needs are read from the file of a run.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arrays import Array
from jousto.base.errors import InputError, Problem, suggest
from jousto.recovery.fields.criteria import evaluate, principal_values
from jousto.simulation.results.dataframes import component_units
from jousto.viewer.extremes import extent, rank_places
from jousto.viewer.file_watch import Renewed, Watched, unfinished_note
from jousto.viewer.frames import Frames, nearest, thinned
from jousto.viewer.measures import CRITERIA, NUMBERED, SHIFTS, unit_of
from jousto.viewer.packing import frames_header, scene_header
from jousto.viewer.points import Point, rows_of
from jousto.viewer.requests import Request
from jousto.viewer.touches import Touches, model_of

if TYPE_CHECKING:
    from jousto.scene.scene import Body, Scene

MOST_POINTS = 20_000  # points of a plot
MOST_COUNT = 100  # extreme places in an answer
MOST_INSTANTS = 64  # instants of an answer with points that touch
BLOCK = 16 << 20  # bytes of rows per read
WINDOWS = 64  # number of pages whose window is remembered


class Answers:
    """Answers for one or several overlaid scenes.

    Parameters
    ----------
    scenes : sequence of Scene
        The first one, and those that it is compared with.
    titles : sequence of str, optional
        Names of the scenes if there are several.
    page : callable, optional
        Returns all scenes as one page.
    watched : Watched, optional
        Displayed files; if a new run replaces one of them, the new run is shown.
    """

    def __init__(
        self,
        scenes: Sequence[Scene],
        titles: Sequence[str] = (),
        page: Callable[[], bytes] | None = None,
        watched: Watched | None = None,
    ) -> None:
        self.scenes = tuple(scenes)
        self.titles = list(titles) or [scene.title for scene in scenes]
        self._page, self._watched = page, watched
        self._said, self._one = "", threading.Lock()
        # version of the content, and the version that each page shows
        self._made, self._shown = 0, dict[int, int]()
        self._windows: dict[tuple[int, int], Frames] = {}
        self._known: dict[tuple[Any, ...], dict[str, Any]] = {}  # cache of slow answers by request
        self._touching: dict[int, Touches] = {}
        self._compiling = threading.Lock()

    @property
    def title(self) -> str:
        """Title of the page."""
        return " and ".join(self.titles)

    def page(self) -> bytes:
        """Return the self-contained page of all scenes."""
        if self._page is None:
            raise InputError(Problem("page", "this cannot be saved as a page of its own"))
        return self._page()

    def answer(self, request: dict[str, Any]) -> dict[str, Any]:
        """Return the header of the answer to a request, with arrays.

        Raises
        ------
        InputError
            With the sentence that the page shows.
        Renewed
            If the content of its files has changed.
        """
        asked = Request(request)
        with self._one:
            self._renew(asked, request.get("ask") == "scene")
        known: dict[str, Callable[[Request, int], dict[str, Any]]] = {
            "scene": self._scene,
            "rows": self._rows,
            "touches": self._touches,
            "window": self._window,
            "probe": self._probe,
            "history": self._history,
            "sensor": self._sensor,
            "worst": self._worst,
            "extent": self._extent,
            "still": lambda _, __: {"kind": "done"},
        }
        what = asked.name("ask") if "ask" in request else ""
        if what not in known:
            raise InputError(Problem("request", f"asks for {what!r}; there are {', '.join(known)}"))
        return known[what](asked, asked.whole("run", len(self.scenes), default=0))

    # -- frames -----------------------------------------------------------------------------

    def _frames(self, asked: Request, run: int) -> Frames | None:
        motion = self.scenes[run].motion
        if motion is None:
            return None
        page = asked.whole("page", 1 << 62, default=0)
        return self._windows.get((page, run), Frames.thinned(0, len(motion.times)))

    def _scene(self, asked: Request, run: int) -> dict[str, Any]:
        header = scene_header(self.scenes[run], self._frames(asked, run), half=True)
        if len(self.scenes) > 1:
            header["runs"] = self.titles
        if note := unfinished_note(self.scenes[run].run):
            header["note"] = note
        return header

    def _window(self, asked: Request, run: int) -> dict[str, Any]:
        motion = self.scenes[run].motion
        if motion is None:
            raise InputError(Problem("window", "this scene has no motion"))
        start, end = asked.number("start"), asked.number("end")
        frames = Frames.within(motion.times, start, end)
        while len(self._windows) >= WINDOWS:
            self._windows.pop(next(iter(self._windows)))
        self._windows[asked.whole("page", 1 << 62, default=0), run] = frames
        return {"kind": "window", "window": [start, end]} | frames_header(motion.times, frames)

    def _rows(self, asked: Request, run: int) -> dict[str, Any]:
        scene, frames = self.scenes[run], self._frames(asked, run)
        width = len(scene.still)
        if scene.motion is None or frames is None:
            frames = Frames(0, 1, 0)
        first = asked.whole("first", max(frames.number, 1))
        every = asked.whole("every", 1 << 31, least=1, default=1)
        chosen = frames.rows(first, asked.whole("count", 1 << 62), every, width)
        time, rows = np.zeros(0), np.zeros((0, width))
        if scene.motion is not None:
            time, rows = scene.motion.times[chosen], scene.motion.rows(chosen)
        return {
            "kind": "rows",
            "first": first,
            "every": every,
            "time": time,
            "rows": np.asarray(rows, dtype=np.float32),
        }

    def _touches(self, asked: Request, run: int) -> dict[str, Any]:
        scene, frames = self.scenes[run], self._frames(asked, run)
        if scene.run is None or scene.touches is None or frames is None:
            raise InputError(Problem("touches", "this scene has no contacts"))
        first = asked.whole("first", max(frames.number, 1))
        number = asked.whole("count", MOST_INSTANTS + 1, least=1)
        chosen = frames.rows(first, number, 1, len(scene.still))
        with self._compiling:
            if run not in self._touching:
                self._touching[run] = Touches(model_of(scene.run))
            touching = self._touching[run]
        return touching.at(scene.run.each_state(range(scene.run.nt)[chosen])) | {"first": first}

    def _renew(self, asked: Request, begins: bool) -> None:
        """Reopen changed files; raise Renewed for a page with the old content."""
        page = asked.whole("page", 1 << 62, default=0)
        if self._watched is not None and (file := self._watched.changed()) is not None:
            try:
                self.scenes = tuple(self._watched.scenes())
            except InputError as error:
                message = f"has changed, and what it contains now cannot be shown: {error}"
                raise InputError(Problem(str(file), message)) from None
            self._made += 1
            self._windows.clear()
            self._known.clear()
            self._touching.clear()
            self._said = f"{file}: was written anew; this is what it contains now"
        if begins:
            self._shown[page] = self._made
        elif self._shown.get(page, self._made) != self._made:
            raise Renewed(Problem("page", self._said.partition(";")[0]))

    # -- points -----------------------------------------------------------------------------

    def _point(self, asked: Request, run: int) -> Point:
        bodies = self.scenes[run].bodies
        body = bodies[asked.whole("body", len(bodies))]
        return Point(body, asked.whole("vertex", len(body.positions)))

    def _probe(self, asked: Request, run: int) -> dict[str, Any]:
        scene, point = self.scenes[run], self._point(asked, run)
        time, motion = asked.number("time"), scene.motion
        if motion is None:
            row = np.asarray(scene.still)[None, point.columns]
        else:
            k = nearest(motion.times, time)
            row = rows_of(scene, point, slice(k, k + 1))
            time = float(motion.times[k])
        return {"kind": "probe", "time": time} | values_at(point, row, scene)

    def _history(self, asked: Request, run: int) -> dict[str, Any]:
        scene, point = self.scenes[run], self._point(asked, run)
        names = asked.names("of")
        for name in names:
            if name not in NUMBERED:
                hint = suggest(name, NUMBERED)
                raise InputError(Problem("history", f"there is no {name!r}{hint}"))
        if scene.motion is None:
            raise InputError(Problem("history", "this scene has no motion and no history"))
        times = scene.motion.times
        series = np.empty((len(names), len(times)))
        step = max(1, BLOCK // (8 * max(1, point.columns.stop - point.columns.start)))
        for start in range(0, len(times), step):
            part = slice(start, min(start + step, len(times)))
            rows = rows_of(scene, point, part)
            series[:, part] = series_of(point, rows, names)
        units = [unit_of(name) for name in names]
        return plotted(times, series, units, names, self._most(asked))

    def _sensor(self, asked: Request, run: int) -> dict[str, Any]:
        source = self.scenes[run].run
        if source is None:
            raise InputError(Problem("sensor", "sensors have values in a run only"))
        series: list[Array] = []
        units: list[str] = []
        labels: list[str] = []
        for name in asked.names("names"):
            if name not in source.sensors:
                hint = suggest(name, source.sensors)
                raise InputError(Problem("sensor", f"there is no sensor {name!r}{hint}"))
            about = source.about(name)
            parts = about["components"]
            values = np.asarray(source[name])
            series.append(values.reshape(len(values), -1).T)
            units += component_units(about)
            labels += [f"{name} {part}" for part in parts] if len(parts) > 1 else [name]
        return plotted(source.time, np.concatenate(series), units, labels, self._most(asked))

    def _most(self, asked: Request) -> int:
        return asked.whole("most", MOST_POINTS + 1, least=2, default=4000)

    # -- over the run -----------------------------------------------------------------------

    def _worst(self, asked: Request, run: int) -> dict[str, Any]:
        scene, measure = self.scenes[run], self._measure(asked, run)
        count = asked.whole("count", MOST_COUNT + 1, least=1, default=5)
        key = ("worst", run, measure, count)
        if key not in self._known:
            found = rank_places(scene, measure, count)
            self._known[key] = {"kind": "worst", "measure": measure, "worst": found}
        return self._known[key]

    def _extent(self, asked: Request, run: int) -> dict[str, Any]:
        measure = self._measure(asked, run)
        key = ("extent", run, measure)
        if key not in self._known:
            low, high = extent(self.scenes[run], measure)
            self._known[key] = {"kind": "extent", "measure": measure, "low": low, "high": high}
        return self._known[key]

    def _measure(self, asked: Request, run: int) -> str:
        name, known = asked.name("measure"), self.scenes[run].measures
        if name not in known:
            found = f"{', '.join(known)}" if known else "none"
            raise InputError(
                Problem("request", f"measure is {name!r}{suggest(name, known)}; allowed: {found}")
            )
        return name


def values_at(point: Point, row: Array, scene: Scene) -> dict[str, Any]:
    """Return the values at a point and an instant."""
    body, v = point.body, point.vertex
    stress = point.stresses(row)
    damage = None if body.damage is None else float(body.damage[v])
    u = None if body.rings is not None else point.displacements(row)[0].tolist()
    return {
        "node": v + 1 if body.nodes is None else int(body.nodes[v]),
        "position": point.positions(row)[0].tolist(),
        "displacement": [None] * 3 if u is None else u,
        "stress": None if stress is None else stress[0].tolist(),
        "von-mises": None if stress is None else float(evaluate(stress, "von-mises")[0]),
        "principal": None if stress is None else principal_values(stress)[0].tolist(),
        "damage": damage,
        "life": life_of(body, v),
    }


def life_of(body: Body, vertex: int) -> float | None:
    """Return the life at a vertex, s; None if unknown or infinite."""
    life = body.life
    return None if life is None or not np.isfinite(life[vertex]) else float(life[vertex])


def series_of(point: Point, rows: Array, names: Sequence[str]) -> Array:
    """Return values (k, nt) at a point by their names; nan where unknown."""
    found = np.full((len(names), len(rows)), np.nan)
    stress = point.stresses(rows) if set(names) & CRITERIA.keys() else None
    for k, name in enumerate(names):
        if name in CRITERIA:
            if stress is not None:
                found[k] = evaluate(stress, CRITERIA[name])
        elif name in "xyz":
            found[k] = point.positions(rows)[:, "xyz".index(name)]
        elif name == "damage":
            damage = point.body.damage
            found[k] = np.nan if damage is None else damage[point.vertex]
        elif point.body.rings is None:
            u = point.displacements(rows)
            found[k] = u[:, SHIFTS.index(name)] if name in SHIFTS else np.linalg.norm(u, axis=1)
    return found


def plotted(
    times: Array, series: Array, units: Sequence[str], labels: Sequence[str], most: int
) -> dict[str, Any]:
    """Return the header of curves (k, nt) over time, thinned with minima and maxima kept."""
    kept = thinned(series, most)
    return {
        "kind": "history",
        "time": np.asarray(times, dtype=np.float64)[kept],
        "values": np.asarray(series[:, kept], dtype=np.float64),
        "units": list(units),
        "labels": list(labels),
        "thinned": len(kept) < len(times),
    }
