"""Self-contained page in one file, without references to other files or the network."""

from __future__ import annotations

import gzip
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jousto.base.errors import InputError, JoustoError, Problem
from jousto.base.files import written
from jousto.viewer.bundle import standalone_page
from jousto.viewer.container import pack
from jousto.viewer.extremes import rank_places, stress_fields
from jousto.viewer.frames import Frames, thinned
from jousto.viewer.packing import scene_header
from jousto.viewer.touches import Touches, model_of

if TYPE_CHECKING:
    from jousto.base.arrays import Array, Index
    from jousto.scene.scene import Motion, Scene

Places = dict[str, list[dict[str, Any]]]  # extreme places by measure

FRAMES = 400  # instants in a page
WORST = 10  # number of extreme places per measure
POINTS = 2000  # instants of a sensor
ENDINGS = (".html", ".htm")
LARGEST = 512 << 20  # bytes of unpacked data that browsers handle


def write_page(
    scenes: Sequence[Scene], path: str | Path, *, frames: int = FRAMES, titles: Sequence[str] = ()
) -> Path:
    """Write scenes as one page and return its path.

    Parameters
    ----------
    scenes : sequence of Scene
    path : path
        Ends with .html.
    frames : int
        Largest number of instants of each run in the page.
    titles : sequence of str, optional
        Names of the scenes where there are several.

    Raises
    ------
    InputError
        For another ending, a page that would be too large, or a file that cannot be written.
    """
    out = Path(path)
    if out.suffix.lower() not in ENDINGS:
        raise InputError(Problem(str(out), "must end with .html"))
    data = page(scenes, frames=frames, titles=titles)
    with written(out) as beside:
        beside.write_bytes(data)
    return out


def page(scenes: Sequence[Scene], *, frames: int = FRAMES, titles: Sequence[str] = ()) -> bytes:
    """Return scenes as one page."""
    stored = [contents(scene, frames) for scene in scenes]
    title = " and ".join(titles) or scenes[0].title
    header: dict[str, Any] = {"kind": "file", **stored[0]}
    if len(stored) > 1:
        names = list(titles) or [scene.title for scene in scenes]
        header["scene"] = {**stored[0]["scene"], "runs": names}
        header["runs"] = [{**stored[0], "scene": header["scene"]}, *stored[1:]]
    data = pack(header)
    if len(data) > LARGEST:
        message = (
            f"would unpack to {len(data) / 1e6:.0f} MB, more than {LARGEST >> 20} MiB, which a "
            "browser may not manage: take fewer frames, or send the results file"
        )
        raise InputError(Problem("page", message))
    return standalone_page(title, gzip.compress(data, 9, mtime=0)).encode()


def contents(scene: Scene, frames: int) -> dict[str, Any]:
    """Return the data of a scene for the page: frames, sensors and extreme places."""
    places = _worst(scene)
    time, rows, chosen = np.zeros(0), np.zeros((0, len(scene.still))), None
    touches: dict[str, Any] = {}
    if scene.motion is not None:
        chosen = Frames.thinned(0, len(scene.motion.times), most=max(2, frames))
        kept = _instants(scene.motion, chosen, places)
        time = np.asarray(scene.motion.times, dtype=np.float64)[kept]
        rows = _rows(scene.motion, chosen, kept)
        touches = _touches(scene, kept)
    header = scene_header(scene, chosen, half=False)
    if chosen is not None:
        header["frames"] = time
    if note := touches.pop("note", ""):
        header |= {"touches": None, "note": note}
    return {
        "scene": header,
        "time": time,
        "rows": np.asarray(rows, dtype=np.float32),
        "sensors": _sensors(scene),
        "worst": places,
        **touches,
    }


def _instants(motion: Motion, chosen: Frames, places: Places) -> Index:
    """Return the stored indices (m,) of the frames and of the extreme places, ascending."""
    every = np.arange(len(motion.times))[chosen.rows_of_all()]
    worst_times = [x["time"] for found in places.values() for x in found if x["time"] is not None]
    return np.union1d(every, np.searchsorted(motion.times, worst_times)).astype(np.intp)


def _rows(motion: Motion, chosen: Frames, kept: Index) -> Array:
    """Return the rows (m, width) of instants, those of the frames read at once."""
    further = np.setdiff1d(kept, np.arange(len(motion.times))[chosen.rows_of_all()])
    pieces = [motion.rows(slice(i, i + 1)) for i in further.tolist()]
    rows = np.concatenate([motion.rows(chosen.rows_of_all()), *pieces])
    return rows[np.argsort(np.concatenate([np.setdiff1d(kept, further), further]))]


def _touches(scene: Scene, kept: Index) -> dict[str, Any]:
    """Return the points at which bodies touch at instants, or a note why they are not known."""
    if scene.run is None or scene.touches is None:
        return {}
    try:
        found = Touches(model_of(scene.run)).at(scene.run.each_state(kept.tolist()))
    except JoustoError as error:
        return {"note": f"The page has no arrows of contact forces. {error}"}
    return {"touches": found | {"values": found["values"].astype(np.float32)}}


def _sensors(scene: Scene) -> dict[str, Any]:
    run = scene.run
    if run is None or not run.sensors:
        return {"time": np.zeros(0), "values": {}}
    series = {name: np.asarray(run[name]).reshape(run.nt, -1).T for name in run.sensors}
    # common instants for all sensors
    kept = thinned(np.concatenate(list(series.values())), POINTS)
    return {
        "time": run.time[kept],
        "values": {name: x[:, kept].astype(np.float32) for name, x in series.items()},
    }


def _worst(scene: Scene) -> Places:
    found = {}
    fields = stress_fields(scene)
    for measure in scene.measures:
        try:
            found[measure] = rank_places(scene, measure, WORST, fields)
        except JoustoError:
            continue  # models and parts have none
    return found
