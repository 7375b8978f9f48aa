"""Places and ranges of extreme values over a run: exact for stress, else at many instants.

Stress comes from the run as in `hot_spots`; for very long runs, whose coordinates would fill the
memory, evenly spaced instants are searched.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.arrays import Array, Index
from jousto.base.errors import InputError, Problem
from jousto.base.ranking import ranking
from jousto.recovery.fields.build import field_from, stress_field
from jousto.recovery.fields.criteria import evaluate
from jousto.recovery.fields.field import StressField
from jousto.recovery.hotspots.hot_spots import worst_places
from jousto.recovery.hotspots.search_result import HotSpot
from jousto.viewer.measures import CRITERIA
from jousto.viewer.points import Point, rows_of

if TYPE_CHECKING:
    from jousto.scene.scene import Body, Scene
    from jousto.simulation.results.solution import Solution

MOST_NUMBERS = 32 << 20  # largest number of modal coordinates in a search
INSTANTS = 200  # instants at which displacements are computed
BLOCK = 4 << 20  # displacements per block
APART = 0.04  # smallest distance of two listed places, relative to the largest body


def rank_places(
    scene: Scene, measure: str, count: int, fields: list[StressField] | None = None
) -> list[dict[str, Any]]:
    """Return the places of the largest values of a measure, largest first.

    Each is `body`, `vertex`, `position` (world, at that time), `value`, `time` and `label`.
    Pass `fields`, the result of `stress_fields`, to rank several measures.

    Raises
    ------
    InputError
        If no value of the measure is known.
    """
    if measure == "damage":
        return _damaged_places(scene, count)
    if measure == "displacement":
        return _displaced_places(scene, count)
    run = _run_of(scene, measure)
    spots = _spots(scene, measure, count, None, fields)
    places = {body.name: k for k, body in reversed([*enumerate(scene.bodies)])}
    found = []
    for spot in spots:
        k = places[spot.body]
        vertex = _vertex(scene.bodies[k], spot.node, spot.position)
        instant = int(np.argmin(np.abs(run.time - spot.time)))
        label = f"{spot.body} {spot.site}"
        found.append(_place(scene, k, vertex, instant, float(spot.value), label))
    return found


def extent(scene: Scene, measure: str) -> tuple[float, float]:
    """Return the smallest and largest value of a measure over bodies and instants.

    Raises
    ------
    InputError
        If no value of the measure is known.
    """
    known = scene.limits.get(measure)
    if known is not None:
        return float(known[0]), float(known[1])
    if measure == "damage":
        known_ones = [body.damage for body in scene.bodies if body.damage is not None]
        values = np.concatenate([np.zeros(0), *known_ones])
        values = values[np.isfinite(values)]
        if not len(values):
            raise InputError(Problem("extent", f"{measure} is not known in this run"))
        return float(values.min()), float(values.max())
    if measure == "displacement":
        found = _displaced_places(scene, 1)
        return 0.0, found[0]["value"] if found else 0.0
    if scene.run is None:
        return _still(scene, measure)
    high = _spots(scene, measure, 1, "largest")[0].value
    if measure == "von-mises":
        return 0.0, float(high)
    return float(_spots(scene, measure, 1, "smallest")[0].value), float(high)


# -- stress ---------------------------------------------------------------------------------


def _run_of(scene: Scene, measure: str) -> Solution:
    if scene.run is None:
        raise InputError(Problem("worst", f"{measure} is known over a run only"))
    return scene.run


def stress_fields(scene: Scene) -> list[StressField]:
    """Return the stress fields of all bodies of a scene; empty without a run."""
    if scene.run is None:
        return []
    shown = {body.name for body in scene.bodies}
    return [_field(scene.run, name) for name in scene.run.stressed if name in shown]


def _spots(
    scene: Scene,
    measure: str,
    count: int,
    extreme: str | None,
    fields: list[StressField] | None = None,
) -> list[HotSpot]:
    fields = stress_fields(scene) if fields is None else fields
    if not fields:
        raise InputError(Problem("worst", "no body of this run has stress data"))
    size = max(float(np.linalg.norm(np.ptp(field.positions, axis=0))) for field in fields)
    how: dict[str, Any] = {"criterion": CRITERIA[measure], "extreme": extreme}
    return worst_places(fields, count=count, separation=APART * size if count > 1 else None, **how)


def _field(run: Solution, name: str) -> StressField:
    """Return the stress field of a body in the displayed axes of the part."""
    beams = {beam.name for beam in run.beams}
    if name in beams or run.nt * run.coordinates(name, slice(0, 1)).shape[1] <= MOST_NUMBERS:
        return stress_field(run, name, frame="site" if name in beams else "body")
    modes = run.stress_modes(name)
    assert modes is not None
    width = run.coordinates(name, slice(0, 1)).shape[1]
    every = slice(None, None, -(-run.nt * width // MOST_NUMBERS))
    p = run.coordinates(name, every)[:, 7:]
    return field_from(modes, p, run.time[every], frame="body", name=name)


def _vertex(body: Body, node: int, position: Array) -> int:
    """Return the vertex of a node, or the nearest vertex."""
    x = np.asarray(body.positions)
    away = np.linalg.norm(x - position, axis=1)
    if body.nodes is not None and node >= 0:
        own = np.flatnonzero(np.asarray(body.nodes) == node + 1)
        if len(own):
            return int(own[np.argmin(away[own])])
    return int(np.argmin(away))


def _still(scene: Scene, measure: str) -> tuple[float, float]:
    low, high = np.inf, -np.inf
    for body in scene.bodies:
        if body.static is not None:
            values = evaluate(np.asarray(body.static, dtype=np.float64), CRITERIA[measure])
            low, high = min(low, float(values.min())), max(high, float(values.max()))
    return (low, high) if high >= low else (0.0, 0.0)


# -- damage and displacement ----------------------------------------------------------------


def _damaged_places(scene: Scene, count: int) -> list[dict[str, Any]]:
    places = [
        (float(body.damage[v]), k, int(v))
        for k, body in enumerate(scene.bodies)
        if body.damage is not None
        for v in _largest(np.asarray(body.damage), count)
    ]
    return _listed(scene, places, None, count)


def _displaced_places(scene: Scene, count: int) -> list[dict[str, Any]]:
    """Return the places of largest displacement at instants spread over the run."""
    if scene.motion is None:
        return []
    nt = len(scene.motion.times)
    every = max(1, -(-nt // INSTANTS))
    rows = scene.motion.rows(slice(0, nt, every))
    places, instants = [], {}
    for k, body in enumerate(scene.bodies):
        if body.shapes is None or body.place < 0 or not body.modes:
            continue
        p = rows[:, body.place + 7 : body.place + 7 + body.modes]
        nv = len(body.positions)
        size, when = np.zeros(nv), np.zeros(nv, dtype=np.intp)
        step = max(1, BLOCK // (3 * nv))
        for first in range(0, len(p), step):
            u = np.einsum("tj,jvi->tvi", p[first : first + step], body.shapes, optimize=True)
            length = np.linalg.norm(u, axis=2)
            at = length.argmax(axis=0)
            top = length[at, np.arange(nv)]
            better = top > size
            size[better], when[better] = top[better], first + at[better]
        for v in _largest(size, count):
            places.append((float(size[v]), k, int(v)))
            instants[k, int(v)] = int(when[v]) * every
    return _listed(scene, places, instants, count)


def _largest(values: Array, count: int) -> Index:
    known = np.where(np.isfinite(values), values, -np.inf)
    return np.argsort(-known, kind="stable")[:count].astype(np.intp)


def _listed(
    scene: Scene,
    places: list[tuple[float, int, int]],
    instants: dict[tuple[int, int], int] | None,
    count: int,
) -> list[dict[str, Any]]:
    labels = [f"{scene.bodies[k].name} {_number(scene.bodies[k], v)}" for _, k, v in places]
    order = ranking([value for value, _, _ in places], labels).tolist()[:count]
    found = []
    for i in order:
        value, k, v = places[i]
        instant = None if instants is None else instants[k, v]
        found.append(_place(scene, k, v, instant, value, labels[i]))
    return found


def _number(body: Body, vertex: int) -> str:
    return f"node {vertex + 1 if body.nodes is None else int(body.nodes[vertex])}"


def _place(
    scene: Scene, body: int, vertex: int, instant: int | None, value: float, label: str
) -> dict[str, Any]:
    point = Point(scene.bodies[body], vertex)
    if instant is None or scene.motion is None:
        row, time = np.asarray(scene.still)[None, point.columns], None
    else:
        row = rows_of(scene, point, slice(instant, instant + 1))
        time = float(scene.motion.times[instant])
    return {
        "body": body,
        "vertex": vertex,
        "position": point.positions(row)[0].tolist(),
        "value": value,
        "time": time,
        "label": label,
    }
